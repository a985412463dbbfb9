//! The second problem: a rotation whose speed is noisy. The rules keep I, so all paths have the
//! same weight.

use std::error::Error;

use sve_examples::check::Check;
use sve_runtime::prelude::*;

use crate::mean;

/// Kubo's oscillator with a = 1.
#[derive(Clone, Copy, Debug)]
struct Kubo {
    sigma: f64,
}

#[variational(midpoint, gauss(2))]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

const KAPPA: f64 = 0.6;

/// Solves at (1, ½) and t = 1, and compares.
pub(crate) fn solve() -> Result<Vec<Check>, Box<dyn Error>> {
    let kubo = Kubo { sigma: 0.5 };
    let (sin, cos) = 1.0_f64.sin_cos();
    let exact = (-KAPPA * 0.625 - 0.5 * kubo.sigma * kubo.sigma).exp() * (cos + 0.5 * sin);
    let start = State::new([1.0], [0.5]);
    let solve = |summary: Summary| (summary["u"].mean()[1], summary["u"].standard_error()[1]);
    let action = |state: &State<[f64; 1]>| 0.5 * (state.q[0].powi(2) + state.p[0].powi(2));
    let midpoint = Integrator::new(kubo, Midpoint);
    let gauss = Integrator::new(kubo, Gauss::<2>);
    let by_midpoint = Ensemble::new(&midpoint)
        .paths(200_000)
        .seed(2)
        .steps(1.0 / 64.0, 64)
        .start(start)
        .weight(|_, state| KAPPA * action(state))
        .terminal("u", |_, state| state.q[0])
        .run()?;
    let by_gauss = Ensemble::new(&gauss)
        .paths(50_000)
        .seed(3)
        .steps(1.0 / 16.0, 16)
        .start(start)
        .weight(|_, state| KAPPA * action(state))
        .terminal("u", |_, state| state.q[0])
        .run()?;
    let (u, error) = solve(by_midpoint);
    let (v, spread) = solve(by_gauss);
    Ok(vec![
        mean(
            "2: u by 2·10⁵ paths, `midpoint`, h = 1/64".to_owned(),
            u,
            exact,
            error,
            5e-4,
        ),
        mean(
            "2: u by 5·10⁴ paths, `gauss(2)`, h = 1/16".to_owned(),
            v,
            exact,
            spread,
            1e-5,
        ),
    ])
}
