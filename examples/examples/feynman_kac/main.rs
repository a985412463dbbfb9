//! A parabolic equation solved by the paths of a stochastic Hamiltonian system (Feynman and Kac).
//!
//! ```text
//! 1.  ∂u/∂t = p ∂u/∂q − q ∂u/∂p + ½σ² ∂²u/∂p² − ½κq² u,  u(0) = 1
//!     u = exp(−½ zᵀA(t)z − c(t))
//! 2.  ∂u/∂t = a Du + ½σ² D²u − κI u,  D = p ∂/∂q − q ∂/∂p,  I = ½(q² + p²),  u(0) = q
//!     u = exp(−κIt − ½σ²t) (q cos at + p sin at)
//! ```
//!
//! u(t, x) is the mean of `u(0, X_t) exp(−∫V dt)` over paths from x. The first equation is solved
//! at many points and several times at once, the second at one point; both results are compared
//! with the closed form, within the sampling error and the bias of the rule. The picture has the
//! time that an error costs, by derived rules and by Euler–Maruyama as it is usually written.
//! Status 1 if a number is off. Writes `target/feynman_kac/`.

mod kubo;
mod quadratic;
mod time_to_error;

use std::error::Error;
use std::fs;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::report::{one_row, report};
use sve_runtime::plot::page::number;

const CAPTION: &str = "Left: the first problem along the axis of q, by the midpoint rule with h = 1/16; lines are the closed form, points are means over 20000 paths each, seed 1. \
    Middle: these means less the closed form, with bars of two standard errors on either side; the two times are drawn beside each other. Right: the time that an error of the first problem \
    costs. It is computed, not run: half of the squared error is bias, half is sampling; the number of paths follows from bias and variance, which are known without sampling, and is \
    multiplied by the measured time of a path.\
    <p>1: ∂u/∂t = p ∂u/∂q − q ∂u/∂p + ½σ² ∂²u/∂p² − ½κq²u, u(0) = 1, with σ = 0.8, κ = 1.3<br>\
    2: ∂u/∂t = a Du + ½σ²D²u − κIu, D = p ∂/∂q − q ∂/∂p, I = ½(q² + p²), u(0) = q, with a = 1, σ = 0.5, κ = 0.6</p>";

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (solution, mut checks) = quadratic::solve()?;
    checks.extend(kubo::solve()?);
    let (times, time_checks) = time_to_error::measure()?;
    checks.extend(time_checks);
    let [values, errors] = solution;
    let figure = one_row("feynman_kac", [1260, 420], vec![values, errors, times]);
    let status = report("Parabolic equations by paths", &figure, CAPTION, &checks)?;
    fs::write("target/feynman_kac/feynman_kac.csv", figure.csv())?;
    Ok(status)
}

/// Compares a mean with its expectation, with a known bias.
pub(crate) fn mean(what: String, measured: f64, expected: f64, error: f64, bias: f64) -> Check {
    let [spread, shift] = [error, bias].map(|x| number(x, 2));
    Check::new(what, measured).near(
        expected,
        4.5 * error + bias.abs(),
        format!("4.5 standard errors of {spread}, and the bias {shift} of the rule"),
    )
}
