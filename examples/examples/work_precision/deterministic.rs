//! The problems without noise: errors of the end point, and of the energy on the way.

use sve_runtime::baseline::{EulerMaruyama, Heun, RungeKutta4, TaylorSeries2};
use sve_runtime::prelude::*;
use sve_runtime::study::{Study, StudyError};
use sve_runtime::{Dims, System, Variational};

use crate::problem::{Problem, powers};
use crate::systems::{DoublePendulum, Kepler, Pendulum};

/// The methods that every problem without noise is given to.
struct Methods<S> {
    initial_point: Integrator<S, InitialPoint>,
    endpoint: Integrator<S, Endpoint>,
    midpoint: Integrator<S, Midpoint>,
    taylor: Integrator<S, Taylor2>,
    series: TaylorSeries2<S>,
    runge_kutta: RungeKutta4<S>,
    heun: Heun<S>,
    euler: EulerMaruyama<S>,
}

impl<S, const N: usize> Methods<S>
where
    S: System<Dims = Dims<N, 0>>
        + Copy
        + Sync
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Midpoint>
        + Variational<Taylor2>,
{
    fn new(system: S) -> Self {
        Self {
            initial_point: Integrator::new(system, InitialPoint),
            endpoint: Integrator::new(system, Endpoint),
            midpoint: Integrator::new(system, Midpoint),
            taylor: Integrator::new(system, Taylor2),
            series: TaylorSeries2::new(system),
            runge_kutta: RungeKutta4::new(system),
            heun: Heun::new(system),
            euler: EulerMaruyama::new(system),
        }
    }

    /// A study of all of them, which watches the energy.
    fn study<'a>(&'a self, name: &'static str) -> Study<'a, S> {
        Study::new(name)
            .method("midpoint", &self.midpoint)
            .method("endpoint", &self.endpoint)
            .method("initial point", &self.initial_point)
            .method("taylor2", &self.taylor)
            .method("Taylor series 2", &self.series)
            .method("Runge–Kutta 4", &self.runge_kutta)
            .method("Heun", &self.heun)
            .method("Euler", &self.euler)
            .invariant(Mechanics::hamiltonian)
    }
}

/// L = v²/2 + g cos q.
pub(crate) fn pendulum() -> Result<Problem, StudyError> {
    let methods = Methods::new(Pendulum { g: 9.8 });
    let report = methods
        .study("pendulum")
        .start(State::new([1.0], [0.0]))
        .horizon(500.0)
        .steps(powers(11..=18))
        .fine(&methods.runge_kutta, 8)
        .run()?;
    Ok(Problem {
        title: "Pendulum",
        setting: "L = v²/2 + 9.8 cos q, from q = 1 at rest to t = 500, some 230 periods. Errors against Runge–Kutta 4 with 8 times shorter steps.",
        invariant: Some("energy"),
        report,
    })
}

/// Two pendula of unit masses and lengths.
pub(crate) fn double_pendulum() -> Result<Problem, StudyError> {
    let methods = Methods::new(DoublePendulum { g: 9.8 });
    let report = methods
        .study("double_pendulum")
        .start(State::new([2.0, 1.0], [0.0, 0.0]))
        .horizon(4.0)
        .steps(powers(6..=13))
        .fine(&methods.runge_kutta, 8)
        .run()?;
    Ok(Problem {
        title: "Double pendulum",
        setting: "Unit masses and lengths, g = 9.8, from angles (2, 1) at rest to t = 4. Errors against Runge–Kutta 4 with 8 times shorter steps.",
        invariant: Some("energy"),
        report,
    })
}

/// L = v²/2 + 1/r with eccentricity 0.6.
pub(crate) fn kepler() -> Result<Problem, StudyError> {
    let methods = Methods::new(Kepler { k: 1.0 });
    let e: f64 = 0.6;
    let start = State::new([1.0 - e, 0.0], [0.0, ((1.0 + e) / (1.0 - e)).sqrt()]);
    let horizon = 20.0 * std::f64::consts::PI;
    let report = methods
        .study("kepler")
        .start(start)
        .horizon(horizon)
        .steps(powers(10..=17))
        // after whole revolutions it is where it was
        .exact(move |_| State::at(horizon, start.q, start.p))
        .run()?;
    Ok(Problem {
        title: "Kepler, eccentricity 0.6",
        setting: "L = v²/2 + 1/r, from the perihelion (0.4, 0), p = (0, 2), for ten revolutions, t = 20π. Errors against the exact return to the start.",
        invariant: Some("energy"),
        report,
    })
}
