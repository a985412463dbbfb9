//! Langevin dynamics at large steps: the sampled distribution is not exp(−H/kT) but the stationary
//! distribution of the step's matrix.

use sve_runtime::{Variational, prelude::*};

use sve_models::checks::assert_within;
use sve_models::models::Bath;

/// The stationary covariance (⟨q²⟩, ⟨qp⟩, ⟨p²⟩) of z₁ = A z₀ + b ΔW: `C = A C Aᵀ + h b bᵀ`, three
/// linear equations.
fn stationary(a: [[f64; 2]; 2], b: [f64; 2], h: f64) -> [f64; 3] {
    let [[a11, a12], [a21, a22]] = a;
    let [b11, b12, b22] = [h * b[0] * b[0], h * b[0] * b[1], h * b[1] * b[1]];
    let mixed = 1.0 - a11 * a22 - a12 * a21;
    let mut rows = [
        [1.0 - a11 * a11, -2.0 * a11 * a12, -a12 * a12, b11],
        [-a11 * a21, mixed, -a12 * a22, b12],
        [-a21 * a21, -2.0 * a21 * a22, 1.0 - a22 * a22, b22],
    ];
    for k in 0..3 {
        let pivot = (k..3).max_by(|&i, &j| rows[i][k].abs().total_cmp(&rows[j][k].abs()));
        rows.swap(k, pivot.unwrap());
        for i in (0..3).filter(|&i| i != k) {
            let factor = rows[i][k] / rows[k][k];
            for j in k..4 {
                rows[i][j] -= factor * rows[k][j];
            }
        }
    }
    core::array::from_fn(|i| rows[i][3] / rows[i][i])
}

/// Means of q², qp and p² over long runs, with standard errors from blocks.
fn sampled<R>(integrator: &Integrator<Bath, R>, h: f64) -> [(f64, f64); 3]
where
    Bath: Variational<R>,
{
    const BLOCKS: usize = 200;
    const STEPS: usize = 5000;
    let mut blocks = [[0.0; BLOCKS]; 3];
    for block in 0..BLOCKS {
        let path = Wiener::new(11).path(block as u64);
        // a thousand steps are many times of relaxation
        let states = integrator.trajectory(State::new([0.0], [0.0]), h, path);
        for state in states.skip(1000).take(STEPS) {
            let State { q: [q], p: [p], .. } = state.unwrap();
            for (sums, value) in blocks.iter_mut().zip([q * q, q * p, p * p]) {
                sums[block] += value / STEPS as f64;
            }
        }
    }
    blocks.map(|block| {
        let n = BLOCKS as f64;
        let mean = block.iter().sum::<f64>() / n;
        let variance = block.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    })
}

/// Runs at each ωh; whether the sampled variances are those of exp(−H/kT).
fn check<R: Copy>(rule: R, omega_h: &[f64], exact: bool)
where
    Bath: Variational<R>,
{
    let (nu, kt, h) = (0.5, 1.0, 1.0);
    let sigma = (2.0_f64 * nu * kt).sqrt();
    for &omega in omega_h {
        let integrator = Integrator::new(Bath { omega, nu, sigma }, rule);
        let rest = State::new([0.0], [0.0]);
        let tangent = integrator.tangent(&rest, h, &[0.0]).unwrap();
        let mut kicked = rest;
        integrator.step(&mut kicked, h, &[1.0]).unwrap();
        let expected = stationary(
            [0, 1].map(|row| [tangent[row][0], tangent[row][1]]),
            [kicked.q[0], kicked.p[0]],
            h,
        );
        let found = sampled(&integrator, h);
        for ((mean, error), expected) in found.into_iter().zip(expected) {
            // two dozen means with a fixed seed: 4.5 standard errors
            assert_within(mean, expected, error, 4.5, format!("ωh = {omega}"));
        }
        let equilibrium = [kt / omega.powi(2), kt];
        let off = [0, 1].map(|k| expected[2 * k] / equilibrium[k] - 1.0);
        if exact {
            assert!(off.iter().all(|x| x.abs() < 1e-9), "ωh = {omega}: {off:?}");
        } else {
            // far more than the statistical error: the comparison above can tell
            let seen = (found[2].0 - equilibrium[1]).abs() > 10.0 * found[2].1
                || (found[0].0 - equilibrium[0]).abs() > 10.0 * found[0].1;
            assert!(seen, "ωh = {omega}: {found:?}");
        }
    }
}

/// The midpoint rule is the Cayley map of the linear equation, which has its stationary covariance,
/// whatever the step.
#[test]
fn midpoint_samples_the_exact_covariance() {
    check(Midpoint, &[0.5, 2.0, 10.0], true);
}

/// The other rules differ from exp(−H/kT), by a factor near ωh = 2. They sample the stationary
/// covariance of their own steps.
#[test]
fn endpoint_and_initial_point_sample_their_own() {
    check(Endpoint, &[1.0, 1.5], false);
    check(InitialPoint, &[1.0, 1.5], false);
}
