//! Noether's theorem of the discrete step: if the generator of a symmetry is affine, steps of any size conserve its momentum to rounding,
//! with noise too.
//!
//! Bound: a step rounds each p once in its last addition, and its equations hold to a few units of rounding (Newton's
//! tolerance is two), so the momentum changes by about 4ε times the size of its terms. The changes are practically independent from step
//! to step and add up to 4ε√n times this size after n steps; the bound is four times as large. A wrong term has an effect of order h².

use sve_models::models::{Central, Chain, Charges, Mixed, Stretched};
use sve_models::oracle::{central, chain, charges, mixed, stretched};
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational, VectorCoordinates};

const STEPS: u32 = 5000;

/// Largest product of a coordinate, or 1, with a momentum.
fn size_of<Q: VectorCoordinates<N>, const N: usize>(state: &State<Q>) -> f64 {
    let largest = |x: [f64; N]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    largest(state.q.coordinates()).max(1.0) * largest(Q::components(&state.p))
}

/// Returns the largest drift of `momentum` in units of the bound.
fn drift<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<Q>,
    momentum: impl Fn(&S, &State<Q>) -> f64,
) -> f64
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let expected = momentum(integrator.system(), &start);
    let (mut worst, mut size): (f64, f64) = (0.0, 0.0);
    let path = integrator.trajectory(start, 0.05, Wiener::new(8));
    for (n, state) in (1..=STEPS).zip(path) {
        let state = state.unwrap();
        size = size.max(size_of(&state));
        let bound = 16.0 * f64::EPSILON * f64::from(n).sqrt() * size;
        let change = momentum(integrator.system(), &state) - expected;
        worst = worst.max(change.abs() / bound);
    }
    println!(
        "{}: {worst} of the bound",
        sve_models::oracle::name(integrator)
    );
    worst
}

#[test]
fn angular_momentum_in_a_central_potential() {
    let start = State::new([1.0, 0.2], [-0.3, 0.8]);
    let momentum = Central::rotation_momentum;
    assert_eq!(momentum(&central(), &start), 1.0 * 0.8 - 0.2 * -0.3);
    assert!(drift(&Integrator::new(central(), InitialPoint), start, momentum) < 1.0);
    assert!(drift(&Integrator::new(central(), Endpoint), start, momentum) < 1.0);
    assert!(drift(&Integrator::new(central(), Midpoint), start, momentum) < 1.0);
}

#[test]
fn total_momentum_of_a_free_chain() {
    let start = State::new(
        [0.1, -0.2, 0.3, 0.0, 0.2, -0.1],
        [0.3, 0.1, -0.5, 0.7, 0.2, -0.4],
    );
    let momentum = Chain::shift_momentum;
    assert!((momentum(&chain(), &start) - 0.4).abs() < 1e-15);
    assert!(drift(&Integrator::new(chain(), InitialPoint), start, momentum) < 1.0);
    assert!(drift(&Integrator::new(chain(), Endpoint), start, momentum) < 1.0);
    assert!(drift(&Integrator::new(chain(), Midpoint), start, momentum) < 1.0);
}

/// Two momenta of six coordinates, with noise of every kind.
#[test]
fn momenta_of_two_charges() {
    let start = State::new(
        [[0.7, 0.1, -0.2], [-0.6, 0.2, 0.3]],
        [[0.1, 0.5, 0.2], [-0.2, -0.4, -0.1]],
    );
    let rotation = |state: &State<[[f64; 3]; 2]>| {
        let pairs = state.q.iter().zip(&state.p);
        pairs.map(|(q, p)| q[0] * p[1] - q[1] * p[0]).sum::<f64>()
    };
    assert!((charges().0.rotation_momentum(&start) - rotation(&start)).abs() < 1e-15);
    macro_rules! both {
        ($($rule:ident),*) => {$(
            let integrator = Integrator::new(charges().0, $rule);
            assert!(drift(&integrator, start, Charges::rotation_momentum) < 1.0);
            assert!(drift(&integrator, start, Charges::shift_momentum) < 1.0);
        )*};
    }
    both!(InitialPoint, Endpoint, Midpoint);
}

/// If a generator is not affine, the motion conserves its momentum, but steps conserve it only to their order of accuracy, 2.
#[test]
fn a_symmetry_that_is_not_affine() {
    let start = State::new([0.1], [0.8]);
    let loss = |steps: u32| {
        let h = 1.0 / f64::from(steps);
        let midpoint = Integrator::new(stretched(), Midpoint);
        let mut state = start;
        for _ in 0..steps {
            midpoint.step(&mut state, h, &[]).unwrap();
        }
        (stretched().shift_momentum(&state) - stretched().shift_momentum(&start)).abs()
    };
    let _: fn(&Stretched, &State<[f64; 1]>) -> f64 = Stretched::shift_momentum;
    let order = (loss(32) / loss(64)).log2();
    // the next term of the error is of relative size h
    assert!((order - 2.0).abs() < 0.05, "{order}");
}

/// A free particle seen in a frame that expands, x = eᵗ q: its symmetry depends on time.
struct Expanding;

#[variational(midpoint)]
impl Expanding {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        0.5 * (t.exp() * (v + q)).powi(2)
    }

    #[symmetry]
    fn shift(&self, t: f64, _q: f64) -> f64 {
        (-t).exp()
    }
}

#[test]
fn a_symmetry_that_depends_on_time() {
    let start = State::new([0.1], [0.8]);
    assert!(
        Integrator::new(Expanding, Midpoint)
            .plan()
            .conserved
            .is_empty()
    );
    let loss = |steps: u32| {
        let midpoint = Integrator::new(Expanding, Midpoint);
        let mut state = start;
        for _ in 0..steps {
            midpoint
                .step(&mut state, 1.0 / f64::from(steps), &[])
                .unwrap();
        }
        (Expanding.shift_momentum(&state) - Expanding.shift_momentum(&start)).abs()
    };
    let order = (loss(32) / loss(64)).log2();
    // the next term of the error is of relative size h
    assert!((order - 2.0).abs() < 0.05, "{order}");
}

/// A quantity that is not conserved exceeds the bound by far, so the test can fail.
#[test]
fn without_the_symmetry() {
    let start = State::new([0.2, -0.1], [0.1, 0.3]);
    let quiet = Mixed {
        s: [0.0; 3],
        ..mixed()
    };
    let angular =
        |_: &Mixed, state: &State<[f64; 2]>| state.q[0] * state.p[1] - state.q[1] * state.p[0];
    assert!(drift(&Integrator::new(quiet, Midpoint), start, angular) > 1e6);
}
