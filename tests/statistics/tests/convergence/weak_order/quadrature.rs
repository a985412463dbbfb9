//! Gauss–Hermite quadrature over normal variables, and expectations of paths by following all nodes
//! of all steps.

use sve_runtime::Rule;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// Nodes and weights of the quadrature over a normal variable: zeros of the Hermite polynomial of
/// degree n by Newton's method, from starts between those of the zeros of the polynomial of degree
/// n − 1.
pub(crate) fn gauss_hermite(n: usize) -> Vec<(f64, f64)> {
    // orthonormal polynomials: √(k+1) H_{k+1} = x H_k − √k H_{k−1}
    let evaluate = |degree: usize, x: f64| {
        let (mut before, mut value) = (0.0, 1.0);
        for k in 0..degree {
            let next = (x * value - (k as f64).sqrt() * before) / (k as f64 + 1.0).sqrt();
            (before, value) = (value, next);
        }
        [value, before]
    };
    let mut zeros: Vec<f64> = Vec::new();
    for degree in 1..=n {
        let end = 2.0 * (degree as f64).sqrt();
        let borders: Vec<f64> = [&[-end], zeros.as_slice(), &[end]].concat();
        let zero = |pair: &[f64]| {
            let (mut low, mut high) = (pair[0], pair[1]);
            let sign = evaluate(degree, low)[0].signum();
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if evaluate(degree, middle)[0] * sign > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            0.5 * (low + high)
        };
        zeros = borders.windows(2).map(zero).collect();
    }
    let weight = |&x: &f64| {
        let before = evaluate(n, x)[1];
        (x, 1.0 / (n as f64 * before * before))
    };
    zeros.iter().map(weight).collect()
}

#[test]
fn the_quadrature_has_the_moments_of_a_normal_variable() {
    for n in [4, 12] {
        let nodes = gauss_hermite(n);
        let mut expected = 1.0;
        for power in 0..n {
            let moment: f64 = nodes
                .iter()
                .map(|(x, w)| w * x.powi(2 * power as i32))
                .sum();
            assert!(
                (moment / expected - 1.0).abs() < 1e-11,
                "{n} {power}: {moment}"
            );
            expected *= 2.0 * power as f64 + 1.0;
        }
    }
}

/// All nodes of M independent variables with their weights.
pub(crate) fn tensor<const M: usize>(nodes: &[(f64, f64)]) -> Vec<([f64; M], f64)> {
    let mut all = vec![([0.0; M], 1.0)];
    for at in 0..M {
        let extended = all.iter().flat_map(|&(x, w)| {
            nodes.iter().map(move |&(node, weight)| {
                let mut x = x;
                x[at] = node;
                (x, w * weight)
            })
        });
        all = extended.collect();
    }
    all
}

/// Expectations at T = ½ after some steps, by following all nodes of all steps.
pub(crate) fn expectations<S, R, const N: usize, const M: usize, const K: usize>(
    integrator: &Integrator<S, R>,
    state: State<[f64; N]>,
    (left, h): (u32, f64),
    nodes: &[([f64; K], f64)],
    observe: &dyn Fn(&State<[f64; N]>) -> Vec<f64>,
) -> Vec<f64>
where
    S: System<Dims = Dims<N, M>>,
    R: Rule<S::Itself, Increments = [f64; K]>,
{
    if left == 0 {
        return observe(&state);
    }
    let mut sums: Vec<f64> = Vec::new();
    for (x, weight) in nodes {
        let mut next = state;
        integrator
            .step(&mut next, h, &x.map(|x| x * h.sqrt()))
            .unwrap();
        let values = expectations(integrator, next, (left - 1, h), nodes, observe);
        sums.resize(values.len(), 0.0);
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += weight * value;
        }
    }
    sums
}
