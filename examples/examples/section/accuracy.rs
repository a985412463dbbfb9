//! The accuracy of crossings: the local order of each rule, and the same bits in a repetition.

use std::error::Error;

use sve_examples::check::Check;
use sve_runtime::prelude::*;

use crate::{HenonHeiles, Point};

/// Returns all checks.
pub(crate) fn checks() -> Result<Vec<Check>, Box<dyn Error>> {
    let system = HenonHeiles { sigma: 0.0 };
    let midpoint = Integrator::new(system, Midpoint);
    let verlet = Integrator::new(system, StormerVerlet);
    let gauss2 = Integrator::new(system, Gauss::<2>);
    let mut checks = vec![
        order("`midpoint`", &midpoint, 0.1, 3.0)?,
        order("`stormer_verlet`", &verlet, 0.1, 3.0)?,
        order("`gauss(2)`", &gauss2, 0.4, 5.0)?,
        Check::new(
            "error at a crossing, `gauss(4)`, h = 0.1",
            error(&Integrator::new(system, Gauss::<4>), 0.1)?,
        )
        .near(0.0, 1e-14, "order 9: rounding only"),
    ];
    checks.push(replay()?);
    Ok(checks)
}

/// Returns the distance of the first crossing from the exact one, which lies at 0.6 of the first
/// step.
fn error<I: Method<System = HenonHeiles>>(method: &I, h: f64) -> Result<f64, StepError> {
    let exact = Integrator::new(HenonHeiles { sigma: 0.0 }, Gauss::<8>);
    let crossing = State::new([0.0, 0.25], [0.4, 0.1]);
    let mut start = crossing;
    for _ in 0..16 {
        exact.step(&mut start, -0.6 * h / 16.0, &[0.0; 2])?;
    }
    let mut crossings = method
        .trajectory(start, h, NoNoise)
        .crossings(|_, state| state.q[0]);
    let found: Point = crossings.next().expect("a crossing")?;
    let differences = [
        found.t - crossing.t,
        found.q[1] - crossing.q[1],
        found.p[0] - crossing.p[0],
        found.p[1] - crossing.p[1],
    ];
    Ok(differences.map(f64::abs).into_iter().fold(0.0, f64::max))
}

fn order<I>(name: &str, method: &I, h: f64, expected: f64) -> Result<Check, StepError>
where
    I: Method<System = HenonHeiles>,
{
    let order = (error(method, h)? / error(method, 0.25 * h)?).log2() / 2.0;
    let what = format!("order of the error at a crossing, {name}");
    let reason = "the local order of a step; the next term of the error still counts";
    Ok(Check::new(what, order).near(expected, 0.1, reason))
}

/// Compares a section with noise with its repetition: the path within a step is a function of seed,
/// path and step.
fn replay() -> Result<Check, Box<dyn Error>> {
    let motion = Integrator::new(HenonHeiles { sigma: 0.002 }, StormerVerlet);
    let section = || {
        let path = motion.trajectory(State::new([0.0, 0.1], [0.3, 0.0]), 0.1, Wiener::new(9));
        let crossings = path.crossings(|_, state| state.q[0]);
        crossings.take(50).collect::<Result<Vec<Point>, _>>()
    };
    let (first, second) = (section()?, section()?);
    let differences = first.iter().zip(&second).map(|(a, b)| (a.t - b.t).abs());
    Ok(Check::new(
        "a section with noise and its repetition, `stormer_verlet`",
        differences.fold(0.0, f64::max),
    )
    .near(0.0, 0.0, "the same bits"))
}
