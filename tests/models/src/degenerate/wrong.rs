//! Steps of degenerate systems that integrate another equation, or are unstable. Tests have to
//! notice it.

use sve_runtime::system::{Dims, System};

/// The treatment of p = α(q) by a plain midpoint step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plain {
    /// No treatment: the discrete Euler–Lagrange equations with the momentum that the step before
    /// left.
    Free,
    /// Sets p = α(q) after each step.
    Projected,
}

/// Number of iterations of a step; each reduces the error by a factor of the order of the step.
const ITERATIONS: usize = 60;

/// Makes one step of the discrete Euler–Lagrange equations at the midpoint, for a Lagrangian that
/// is linear in all velocities.
#[must_use]
pub fn step<S, const N: usize, const M: usize>(
    system: &S,
    what: Plain,
    (q, p): ([f64; N], [f64; N]),
    h: f64,
    dw: &[f64; M],
) -> ([f64; N], [f64; N])
where
    S: System<Dims = Dims<N, M>>,
{
    let rest = [0.0; N];
    let p = match what {
        Plain::Free => p,
        Plain::Projected => system.lagrangian_jet(0.0, &q, &rest).dv,
    };
    let mut d = [0.0; N];
    let mut end = p;
    for _ in 0..ITERATIONS {
        let node: [f64; N] = core::array::from_fn(|i| q[i] + 0.5 * d[i]);
        let jet = system.lagrangian_jet(0.0, &node, &rest);
        let noises = system.noise_jets(0.0, &node, &rest);
        let kick: [f64; N] = core::array::from_fn(|i| {
            let along: f64 = (0..N).map(|k| jet.dqv[i][k] * d[k]).sum();
            let noise: f64 = noises.iter().zip(dw).map(|(g, w)| g.dq[i] * w).sum();
            along + h * jet.dq[i] - noise
        });
        // The residual is α(q̄) − g/2 − p₀, and its derivative by d is −ω/2.
        let residual: [f64; N] = core::array::from_fn(|i| jet.dv[i] - 0.5 * kick[i] - p[i]);
        let form = core::array::from_fn(|i| {
            core::array::from_fn(|k| 0.5 * (jet.dqv[i][k] - jet.dqv[k][i]))
        });
        let update = solve(form, residual);
        for i in 0..N {
            d[i] += update[i];
            end[i] = jet.dv[i] + 0.5 * kick[i];
        }
    }
    (core::array::from_fn(|i| q[i] + d[i]), end)
}

/// Solves by Gaussian elimination with the largest pivot of each column.
fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    for k in 0..N {
        let size = |i: &usize| matrix[*i][k].abs();
        let pivot = (k..N).max_by(|a, b| size(a).total_cmp(&size(b)));
        let pivot = pivot.expect("a row");
        matrix.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..N {
            let factor = matrix[i][k] / matrix[k][k];
            for j in k..N {
                matrix[i][j] -= factor * matrix[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    let mut x = [0.0; N];
    for i in (0..N).rev() {
        let rest: f64 = (i + 1..N).map(|j| matrix[i][j] * x[j]).sum();
        x[i] = (b[i] - rest) / matrix[i][i];
    }
    x
}
