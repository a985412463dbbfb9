//! The problems without noise: errors of the coordinates at the end, and of the energy on the way.
//!
//! Ends without a closed form were computed by Taylor series in numbers of 113 bits, with
//! tolerances of 1e-27 and 1e-28, which agree to 1e-21 at least. The end of the pendulum was also
//! computed by Jacobi's elliptic functions. `examples/peers` computes ends by extrapolation.

use sve_runtime::__private::{Splitting, VectorCoordinates};
use sve_runtime::Variational;
use sve_runtime::baseline::{EulerMaruyama, Heun, RungeKutta4, TaylorSeries2};
use sve_runtime::prelude::*;
use sve_runtime::study::{Study, StudyError};
use sve_runtime::system::{Dims, StateOf, System};

use crate::compensated::{Compensated, Uncounted};
use crate::planets;
use crate::problem::Problem;
use crate::systems::{DoublePendulum, Kepler, OuterSolarSystem, Pendulum, QuietHenonHeiles};

/// Repeats of each time, for the shorter problems and for the longer ones.
const REPEATS: [u32; 2] = [15, 5];

type KahanLi<R> = Composed<R, KahanLi8>;
type Gauss8<S> = Integrator<S, Gauss<8>>;

/// Returns numbers of steps, from `first` by so many doublings, with so many numbers in each.
#[allow(clippy::cast_sign_loss)] // a number of steps is positive
fn doublings(first: usize, doublings: u32, in_each: u32) -> impl Iterator<Item = usize> {
    (0..=doublings * in_each).map(move |k| {
        let factor = (f64::from(k) / f64::from(in_each)).exp2();
        #[allow(clippy::cast_sign_loss)] // both factors are positive
        let steps = (first as f64 * factor).round() as usize;
        steps
    })
}

/// The methods that are run on every problem without noise.
struct Common<S: System> {
    verlet: Integrator<S, StormerVerlet>,
    verlet_8: Integrator<S, KahanLi<StormerVerlet>>,
    gauss_4: Uncounted<Integrator<S, Gauss<4>>>,
    gauss_6: Uncounted<Integrator<S, Gauss<6>>>,
    gauss_8: Uncounted<Gauss8<S>>,
    compensated: Compensated<Gauss8<S>, StateOf<S>>,
    runge_kutta: RungeKutta4<S>,
}

impl<S, Q, const N: usize> Common<S>
where
    S: System<Dims = Dims<N, 0, Q>>
        + Copy
        + Sync
        + Variational<StormerVerlet>
        + Variational<KahanLi<StormerVerlet>>
        + Variational<Gauss<4>>
        + Variational<Gauss<6>>
        + Variational<Gauss<8>>,
    Q: VectorCoordinates<N>,
{
    fn new(system: S) -> Self {
        let zero = State::new(Q::origin(), Q::no_momentum());
        Self {
            verlet: Integrator::new(system, StormerVerlet),
            verlet_8: Integrator::new(system, Composed::new(StormerVerlet, KahanLi8)),
            gauss_4: Uncounted(Integrator::new(system, Gauss::<4>)),
            gauss_6: Uncounted(Integrator::new(system, Gauss::<6>)),
            gauss_8: Uncounted(Integrator::new(system, Gauss::<8>)),
            compensated: Compensated::new(Integrator::new(system, Gauss::<8>), zero),
            runge_kutta: RungeKutta4::new(system),
        }
    }

    /// Returns a study of all these methods, which watches the energy. `coarsest` is the smallest
    /// number of steps of the rule with 8 stages.
    fn study<'a>(&'a self, name: &'static str, coarsest: usize, longest: u32) -> Study<'a, S> {
        Study::new(name)
            .invariant(Mechanics::hamiltonian)
            .distance(|a: &State<Q>, b: &State<Q>| distance(&a.q.coordinates(), &b.q.coordinates()))
            .method_with_step_counts("Gauss 8", &self.gauss_8, doublings(coarsest, 3, 4))
            .method_with_step_counts(
                "Gauss 8, compensated",
                &self.compensated,
                doublings(coarsest, 3, 4),
            )
            .method_with_step_counts("Gauss 6", &self.gauss_6, doublings(3 * coarsest / 2, 3, 2))
            .method_with_step_counts("Gauss 4", &self.gauss_4, doublings(2 * coarsest, 4, 2))
            .method_with_step_counts(
                "Störmer–Verlet",
                &self.verlet,
                doublings(8 * coarsest, longest, 1),
            )
            .method_with_step_counts(
                "Störmer–Verlet, Kahan–Li 8",
                &self.verlet_8,
                doublings(coarsest, 5, 2),
            )
            .method_with_step_counts(
                "Runge–Kutta 4",
                &self.runge_kutta,
                doublings(8 * coarsest, longest - 2, 1),
            )
    }
}

/// Returns the length of the difference.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

/// Splittings, for systems whose L is T(v) − V(q).
struct Splittings<S: System> {
    order_4: Integrator<S, Split<BlanesMoan4>>,
    order_6: Integrator<S, Split<BlanesMoanRkn6>>,
}

impl<S, Q, const N: usize> Splittings<S>
where
    S: System<Dims = Dims<N, 0, Q>>
        + Copy
        + Sync
        + Variational<Split<BlanesMoan4>>
        + Variational<Split<BlanesMoanRkn6>>,
    Q: VectorCoordinates<N>,
    BlanesMoan4: Splitting<S>,
    BlanesMoanRkn6: Splitting<S>,
{
    fn new(system: S) -> Self {
        Self {
            order_4: Integrator::new(system, Split::new(BlanesMoan4)),
            order_6: Integrator::new(system, Split::new(BlanesMoanRkn6)),
        }
    }

    fn add_to<'a>(&'a self, study: Study<'a, S>, coarsest: usize) -> Study<'a, S> {
        study
            .method_with_step_counts(
                "Blanes–Moan 4",
                &self.order_4,
                doublings(2 * coarsest, 6, 1),
            )
            .method_with_step_counts(
                "Blanes–Moan RKN 6",
                &self.order_6,
                doublings(coarsest, 5, 2),
            )
    }
}

/// Methods of low order, and the midpoint rule with its composition.
struct Others<S: System> {
    midpoint: Integrator<S, Midpoint>,
    midpoint_8: Integrator<S, KahanLi<Midpoint>>,
    initial_point: Integrator<S, InitialPoint>,
    endpoint: Integrator<S, Endpoint>,
    taylor: Integrator<S, Taylor2>,
    series: TaylorSeries2<S>,
    heun: Heun<S>,
    euler: EulerMaruyama<S>,
}

impl<S, const N: usize> Others<S>
where
    S: System<Dims = Dims<N, 0>>
        + Copy
        + Sync
        + Variational<Midpoint>
        + Variational<KahanLi<Midpoint>>
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Taylor2>,
{
    fn new(system: S) -> Self {
        Self {
            midpoint: Integrator::new(system, Midpoint),
            midpoint_8: Integrator::new(system, Composed::new(Midpoint, KahanLi8)),
            initial_point: Integrator::new(system, InitialPoint),
            endpoint: Integrator::new(system, Endpoint),
            taylor: Integrator::new(system, Taylor2),
            series: TaylorSeries2::new(system),
            heun: Heun::new(system),
            euler: EulerMaruyama::new(system),
        }
    }

    fn add_to<'a>(&'a self, study: Study<'a, S>, coarsest: usize, longest: u32) -> Study<'a, S> {
        let few = || doublings((8 * coarsest) << (longest - 4), 2, 1);
        study
            .method_with_step_counts(
                "midpoint",
                &self.midpoint,
                doublings(8 * coarsest, longest - 2, 1),
            )
            .method_with_step_counts(
                "midpoint, Kahan–Li 8",
                &self.midpoint_8,
                doublings(2 * coarsest, 2, 1),
            )
            .method_with_step_counts("endpoint", &self.endpoint, few())
            .method_with_step_counts("initial point", &self.initial_point, few())
            .method_with_step_counts("taylor2", &self.taylor, few())
            .method_with_step_counts("Taylor series 2", &self.series, few())
            .method_with_step_counts("Heun", &self.heun, few())
            .method_with_step_counts("Euler", &self.euler, few())
    }
}

/// Runs L = v²/2 + g cos q.
pub(crate) fn pendulum() -> Result<Problem, StudyError> {
    let system = Pendulum { g: 9.8 };
    let (horizon, coarsest, longest) = (2000.0, 3000, 6);
    let (common, splittings, others) = (
        Common::new(system),
        Splittings::new(system),
        Others::new(system),
    );
    let study = common.study("pendulum", coarsest, longest);
    let report = others
        .add_to(splittings.add_to(study, coarsest), coarsest, longest)
        .start(State::new([2.0], [0.0]))
        .repeats(REPEATS[1])
        .horizon(horizon)
        .exact(|_| {
            State::at(
                horizon,
                [1.171_741_965_515_368_5],
                [3.971_398_075_368_108_4],
            )
        })
        .run()?;
    Ok(Problem {
        title: "Pendulum",
        setting: "L = v²/2 + 9.8 cos q, from q = 2 at rest to t = 2000, some 760 periods.",
        norm: "distance of q at the end",
        invariant: Some("energy"),
        report,
    })
}

/// Runs two pendula of unit masses and lengths.
pub(crate) fn double_pendulum() -> Result<Problem, StudyError> {
    let system = DoublePendulum { g: 9.8 };
    let (horizon, coarsest, longest) = (10.0, 68, 7);
    let (common, others) = (Common::new(system), Others::new(system));
    let study = common.study("double_pendulum", coarsest, longest);
    let report = others
        .add_to(study, coarsest, longest)
        .start(State::new([2.0, 1.0], [0.0, 0.0]))
        .repeats(REPEATS[0])
        .horizon(horizon)
        .exact(|_| {
            let q = [0.947_369_524_416_772_2, -6.683_622_982_164_892];
            State::at(horizon, q, [9.445_132_123_201_25, 2.459_576_827_150_103_3])
        })
        .run()?;
    Ok(Problem {
        title: "Double pendulum",
        setting: "Unit masses and lengths, g = 9.8, from angles (2, 1) at rest to t = 10. The motion is chaotic: errors grow with time.",
        norm: "distance of q at the end",
        invariant: Some("energy"),
        report,
    })
}

/// Runs L = v²/2 + 1/r with eccentricity 0.6.
pub(crate) fn kepler() -> Result<Problem, StudyError> {
    let system = Kepler { k: 1.0 };
    let e: f64 = 0.6;
    let start = State::new([1.0 - e, 0.0], [0.0, ((1.0 + e) / (1.0 - e)).sqrt()]);
    // No number of steps is a multiple of the number of revolutions: with such a number, errors
    // would cancel after each revolution.
    let (horizon, coarsest, longest) = (2000.0 * std::f64::consts::PI, 12_345, 4);
    let (common, splittings, others) = (
        Common::new(system),
        Splittings::new(system),
        Others::new(system),
    );
    let study = common.study("kepler", coarsest, longest);
    let report = others
        .add_to(splittings.add_to(study, coarsest), coarsest, longest)
        .start(start)
        .repeats(REPEATS[1])
        .horizon(horizon)
        // After whole revolutions the planet is at its start.
        .exact(move |_| State::at(horizon, start.q, start.p))
        .run()?;
    Ok(Problem {
        title: "Kepler, eccentricity 0.6",
        setting: "L = v²/2 + 1/r, from the perihelion (0.4, 0), p = (0, 2), for 1,000 revolutions, t = 2000π. Errors against the exact return to the start.",
        norm: "distance of q at the end",
        invariant: Some("energy"),
        report,
    })
}

/// Runs Hénon–Heiles without noise.
pub(crate) fn quiet_henon_heiles() -> Result<Problem, StudyError> {
    let system = QuietHenonHeiles;
    let (horizon, coarsest, longest) = (1000.0, 430, 8);
    let (common, splittings, others) = (
        Common::new(system),
        Splittings::new(system),
        Others::new(system),
    );
    let study = common.study("quiet_henon_heiles", coarsest, longest);
    let report = others
        .add_to(splittings.add_to(study, coarsest), coarsest, longest)
        .start(State::new([0.0, 0.1], [0.35, 0.1]))
        .repeats(REPEATS[0])
        .horizon(horizon)
        .exact(|_| {
            let q = [0.144_551_119_447_938_83, -0.124_130_644_914_021_57];
            State::at(
                horizon,
                q,
                [-0.054_625_966_564_800_43, -0.326_279_352_112_980_3],
            )
        })
        .run()?;
    Ok(Problem {
        title: "Hénon–Heiles without noise",
        setting: "L = (v² − q²)/2 − x²y + y³/3, from q = (0, 0.1), p = (0.35, 0.1) to t = 1000.",
        norm: "distance of q at the end",
        invariant: Some("energy"),
        report,
    })
}

/// Runs the Sun and five planets, for a million days.
pub(crate) fn outer_solar_system() -> Result<Problem, StudyError> {
    let system = OuterSolarSystem {
        gravity: planets::GRAVITY,
        masses: planets::MASSES,
    };
    // With longer steps the iteration of the stages does not contract, and Newton's method for all
    // stages is slow.
    let (coarsest, longest) = (654, 4);
    let (common, splittings) = (Common::new(system), Splittings::new(system));
    let study = common.study("outer_solar_system", coarsest, longest);
    let report = splittings
        .add_to(study, coarsest)
        .start(planets::start())
        .repeats(REPEATS[0])
        .horizon(planets::HORIZON)
        .exact(|_| planets::end())
        .run()?;
    Ok(Problem {
        title: "Outer solar system",
        setting: "The Sun with the inner planets, Jupiter, Saturn, Uranus, Neptune and Pluto, from 5 September 1994 for 1,000,000 days; errors in astronomical units, of all positions together.",
        norm: "distance of q at the end",
        invariant: Some("energy"),
        report,
    })
}
