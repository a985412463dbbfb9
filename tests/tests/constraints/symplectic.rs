//! Steps are symplectic on the manifold of the constraints, with noise, and a step whose constraint
//! force acts at the node is not.

use sve_models::differences::derivatives;
use sve_models::random::Random;
use sve_runtime::__private::{ConstraintImpulses, VectorCoordinates};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::systems::{Check, conservative};

/// Differences are good to some 1e-11; a step that is not symplectic is wrong by 1e-5.
const BOUND: f64 = 1e-9;

const H: f64 = 0.05;

type Point = Vec<f64>;

/// ω of two vectors `(q, p)`.
fn form(u: &[f64], w: &[f64]) -> f64 {
    let n = u.len() / 2;
    (0..n).map(|i| u[i] * w[n + i] - u[n + i] * w[i]).sum()
}

/// Returns how much `step` changes ω on tangent vectors of the manifold onto which `consistent`
/// projects, and the largest difference between the images of these vectors and what `tangent`
/// makes of them.
fn defect(
    start: &[f64],
    consistent: impl Fn(&[f64]) -> Point,
    step: impl Fn(&[f64]) -> Point,
    tangent: impl Fn(&[f64]) -> Point,
) -> [f64; 2] {
    let mut random = Random::new(7);
    let mut vector = || random.vector(start.len(), -1.0, 1.0);
    let pairs = (0..3).map(|_| {
        let pair = [vector(), vector()].map(|along| {
            let moved = |d: f64| -> Point {
                let near: Point = start.iter().zip(&along).map(|(x, a)| x + d * a).collect();
                consistent(&near)
            };
            let u = derivatives(moved);
            let image = derivatives(|d| step(&moved(d)));
            (u, image)
        });
        let [(u, u_image), (w, w_image)] = &pair;
        let change = (form(u_image, w_image) - form(u, w)).abs();
        let differences = pair.iter().flat_map(|(u, image)| {
            let computed = tangent(u);
            computed
                .into_iter()
                .zip(image.clone())
                .map(|(a, b)| (a - b).abs())
        });
        [change, differences.fold(0.0, f64::max)]
    });
    let pairs: Vec<[f64; 2]> = pairs.collect();
    [0, 1].map(|i| pairs.iter().fold(0.0, |m: f64, x| m.max(x[i])))
}

struct Symplectic {
    worst: [f64; 2],
}

impl Check for Symplectic {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let dw: [f64; M] = core::array::from_fn(|i| [0.3, -0.2, 0.25][i % 3]);
        let row = |state: &State<Q>| [state.q.coordinates(), Q::components(&state.p)].concat();
        let state = |z: &[f64]| {
            let [q, p]: [[f64; N]; 2] = [&z[..N], &z[N..]].map(|part| part.try_into().unwrap());
            State::at(start.t, Q::from_coordinates(&q), Q::from_components(&p))
        };
        let tangent = integrator.tangent(&start, H, &dw).unwrap();
        let found = defect(
            &row(&start),
            |z| row(&integrator.consistent(state(z)).unwrap()),
            |z| {
                let mut state = state(z);
                integrator.step(&mut state, H, &dw).unwrap();
                row(&state)
            },
            |u| {
                let image = |i: usize| tangent[i].iter().zip(u).map(|(a, b)| a * b).sum();
                (0..2 * N).map(image).collect()
            },
        );
        println!("{name}: {found:?}");
        for (worst, found) in self.worst.iter_mut().zip(found) {
            assert!(found < BOUND, "{name}: {found:e}");
            *worst = worst.max(found);
        }
    }
}

#[test]
fn every_step_is_symplectic_on_its_manifold() {
    let mut check = Symplectic { worst: [0.0; 2] };
    conservative(&mut check);
    println!("{:?}", check.worst);
}

/// The spherical pendulum by the midpoint rule with the constraint force at the node:
/// `p̄ = p₀ − ½h g + λ q̄`, `|q₁| = 1`, p₁ projected.
fn force_at_node(z: &[f64]) -> Point {
    let [q, p] = [&z[..3], &z[3..]].map(Vector3::from_column_slice);
    let g = Vector3::new(0.0, 0.0, 1.3);
    let middle = |lambda: f64| (p - 0.5 * H * g + lambda * q) / (1.0 - 0.5 * H * lambda);
    let phi = |lambda: f64| (q + H * middle(lambda)).norm_squared() - 1.0;
    let (mut before, mut here) = (-0.1, 0.0);
    while phi(here).abs() > 1e-15 && before != here {
        let slope = (phi(here) - phi(before)) / (here - before);
        (before, here) = (here, here - phi(here) / slope);
    }
    let end = q + H * middle(here);
    let node = 0.5 * (q + end);
    let p = middle(here) - 0.5 * H * g + here * node;
    let p = p - end * end.dot(&p);
    [end.as_slice(), p.as_slice()].concat()
}

#[test]
fn a_constraint_force_at_the_node_is_not_symplectic() {
    let consistent = |z: &[f64]| {
        let [q, p] = [&z[..3], &z[3..]].map(Vector3::from_column_slice);
        let q = q.normalize();
        let p = p - q * q.dot(&p);
        [q.as_slice(), p.as_slice()].concat()
    };
    let start = consistent(&[0.6, 0.0, -0.8, 0.3, 0.9, 0.2]);
    let [found, _] = defect(&start, consistent, force_at_node, |u| vec![0.0; u.len()]);
    println!("{found:e}");
    assert!(found > 1e-5, "{found:e}");
}
