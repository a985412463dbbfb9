//! Second moments of linear systems: after steps, by expectations of the matrix of a step, and
//! exact.

use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Rule, Variational};

use super::quadrature::{gauss_hermite, tensor};

pub(crate) type Matrix = Vec<Vec<f64>>;

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |row: &Vec<f64>, j: usize| row.iter().zip(b).map(|(x, y)| x * y[j]).sum();
    a.iter()
        .map(|row| (0..b[0].len()).map(|j| entry(row, j)).collect())
        .collect()
}

fn transposed(a: &Matrix) -> Matrix {
    (0..a[0].len())
        .map(|j| a.iter().map(|row| row[j]).collect())
        .collect()
}

pub(crate) fn plus(a: &Matrix, factor: f64, b: &Matrix) -> Matrix {
    let row =
        |(x, y): (&Vec<f64>, &Vec<f64>)| x.iter().zip(y).map(|(x, y)| x + factor * y).collect();
    a.iter().zip(b).map(row).collect()
}

/// The matrix of a step on (q, p, 1), for systems whose step is affine.
fn step_matrix<S, R, const N: usize, const M: usize, const K: usize>(
    integrator: &Integrator<S, R>,
    [t, h]: [f64; 2],
    dw: &[f64; K],
) -> Matrix
where
    S: System<Dims = Dims<N, M>>,
    R: Rule<S::Itself, Increments = [f64; K]>,
{
    let image = |unit: usize| {
        let mut state = State::at(t, [0.0; N], [0.0; N]);
        if unit < N {
            state.q[unit] = 1.0;
        } else if unit < 2 * N {
            state.p[unit - N] = 1.0;
        }
        integrator.step(&mut state, h, dw).unwrap();
        [state.q, state.p].concat()
    };
    let origin = image(2 * N);
    let mut columns: Matrix = (0..2 * N)
        .map(|unit| {
            image(unit)
                .iter()
                .zip(&origin)
                .map(|(x, y)| x - y)
                .chain([0.0])
                .collect()
        })
        .collect();
    columns.push(origin.into_iter().chain([1.0]).collect());
    transposed(&columns)
}

/// Second moments of (q, p, 1) at T = 1 after 2ᵏ steps.
pub(crate) fn moments<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<[f64; N]>,
    level: u32,
) -> Matrix
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    moments_with(integrator, start, level, [1.0; M])
}

/// The same for increments with these variances in steps of unit length.
pub(crate) fn moments_with<S, R, const N: usize, const M: usize, const K: usize>(
    integrator: &Integrator<S, R>,
    start: State<[f64; N]>,
    level: u32,
    variances: [f64; K],
) -> Matrix
where
    S: System<Dims = Dims<N, M>>,
    R: Rule<S::Itself, Increments = [f64; K]>,
{
    let steps = 1_u32 << level;
    let h = 1.0 / f64::from(steps);
    let nodes = tensor::<K>(&gauss_hermite(12));
    let mut second = second_moments(start);
    for step in 0..steps {
        let mut next = vec![vec![0.0; 2 * N + 1]; 2 * N + 1];
        for (x, weight) in &nodes {
            let a = step_matrix(
                integrator,
                [f64::from(step) * h, h],
                &core::array::from_fn(|at| x[at] * (variances[at] * h).sqrt()),
            );
            next = plus(&next, *weight, &times(&times(&a, &second), &transposed(&a)));
        }
        second = next;
    }
    second
}

fn second_moments<const N: usize>(start: State<[f64; N]>) -> Matrix {
    let z = [&start.q[..], &start.p, &[1.0]].concat();
    z.iter()
        .map(|x| z.iter().map(|y| x * y).collect())
        .collect()
}

/// The exact second moments at T = 1 of `dz = B₀ z dt + Σ B_a(t) z ∘ dW_a`: Runge–Kutta of order 4
/// with 2⁹ steps, whose error is below 1e-10.
pub(crate) fn exact<const N: usize>(
    start: State<[f64; N]>,
    drift: &Matrix,
    noises: impl Fn(f64) -> Vec<Matrix>,
) -> Matrix {
    let rate = |t: f64, m: &Matrix| {
        let half = times(drift, m);
        let mut rate = plus(&half, 1.0, &transposed(&half));
        for b in noises(t) {
            let twice = times(&b, &times(&b, m));
            rate = plus(&plus(&rate, 0.5, &twice), 0.5, &transposed(&twice));
            rate = plus(&rate, 1.0, &times(&times(&b, m), &transposed(&b)));
        }
        rate
    };
    let mut m = second_moments(start);
    let steps = 1 << 9;
    let h = 1.0 / f64::from(steps);
    for step in 0..steps {
        let t = f64::from(step) * h;
        let a = rate(t, &m);
        let b = rate(t + 0.5 * h, &plus(&m, 0.5 * h, &a));
        let c = rate(t + 0.5 * h, &plus(&m, 0.5 * h, &b));
        let d = rate(t + h, &plus(&m, h, &c));
        for (factor, k) in [(1.0, &a), (2.0, &b), (2.0, &c), (1.0, &d)] {
            m = plus(&m, factor * h / 6.0, k);
        }
    }
    m
}

pub(crate) fn distance(a: &Matrix, b: &Matrix) -> f64 {
    let difference = plus(a, -1.0, b).concat();
    difference.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// `rows` as a matrix.
pub(crate) fn matrix<const K: usize>(rows: [[f64; K]; K]) -> Matrix {
    rows.iter().map(|row| row.to_vec()).collect()
}
