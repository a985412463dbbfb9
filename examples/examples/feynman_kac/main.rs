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
use std::path::Path;
use std::process::ExitCode;

use sve_examples::check::{self, Check};
use sve_examples::page::{self, Section};
use sve_examples::render;
use sve_examples::report::one_row;

fn run() -> Result<bool, Box<dyn Error>> {
    let folder = Path::new("target/feynman_kac");
    fs::create_dir_all(folder)?;
    let (solution, mut checks) = quadratic::solve()?;
    checks.extend(kubo::solve()?);
    let (times, time_checks) = time_to_error::measure()?;
    checks.extend(time_checks);
    println!("{}", check::table("Parabolic equations by paths", &checks));
    let figure = one_row("feynman_kac", [1080, 440], vec![solution, times]);
    let svg = render::svg(&figure)?;
    fs::write(folder.join("feynman_kac.svg"), &svg)?;
    fs::write(folder.join("feynman_kac.png"), render::png(&figure)?)?;
    fs::write(folder.join("feynman_kac.csv"), figure.csv())?;
    let caption = "Left: the first problem along the axis of q, by the midpoint rule; lines are the closed form, points are means over paths. Right: the time of all paths that are needed for an error, \
        half of whose square is bias and half sampling: bias without sampling, variance and time of a path measured.";
    let sections = [Section {
        title: "Solution, and what an error costs",
        svg: &svg,
        caption,
        checks: &checks,
    }];
    let html = page::html("A parabolic equation by paths", "", &sections, "");
    fs::write(folder.join("index.html"), html)?;
    println!("wrote {}", folder.join("index.html").display());
    Ok(checks.iter().all(|check| !check.failed()))
}

/// Compares a mean with its expectation, with a known bias.
pub(crate) fn mean(what: String, measured: f64, expected: f64, error: f64, bias: f64) -> Check {
    Check::new(what, measured).near(
        expected,
        4.5 * error + bias.abs(),
        format!("4.5 standard errors of {error:.1e}, and the bias {bias:.1e} of the rule"),
    )
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            eprintln!("some of the numbers above are off");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
