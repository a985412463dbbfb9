//! Steps across places where linkages are almost stretched into a line, and motions that pass no
//! such place.

use sve_models::models::OnSphere;
use sve_models::stepper::{Stepper, with_verlet};
use sve_runtime::__private::{ConstraintImpulses, VectorCoordinates};
use sve_runtime::Variational;
use sve_runtime::ensemble::Cause;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::systems::{Check, conservative, two_rods, two_rods_at};

/// A linkage of two cranks with their pivots at a distance of 1, and a coupler. A spring pulls at
/// the ends of the coupler.
#[derive(Clone, Copy)]
struct Linkage {
    lengths: [f64; 3],
    spring: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Linkage {
    fn lagrangian(&self, q: [Vector2<f64>; 2], v: [Vector2<f64>; 2]) -> f64 {
        let potential = q[0].y + 0.5 * self.spring * (q[0].x * q[1].y).powi(2);
        0.5 * (v[0].norm_squared() + v[1].norm_squared()) - potential
    }

    #[constraint]
    fn bars(&self, q: [Vector2<f64>; 2]) -> [f64; 3] {
        let [first, coupler, second] = self.lengths;
        let arm = q[1] - Vector2::new(1.0, 0.0);
        [
            0.5 * (q[0].norm_squared() - first * first),
            0.5 * (arm.norm_squared() - second * second),
            0.5 * ((q[1] - q[0]).norm_squared() - coupler * coupler),
        ]
    }

    #[gamma]
    fn shake(&self, q: [Vector2<f64>; 2]) -> f64 {
        0.01 * q[0].x
    }
}

/// The same without the spring: Newton's method has the multipliers for unknowns.
#[derive(Clone, Copy)]
struct Torn {
    coupler: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Torn {
    fn lagrangian(&self, q: [Vector2<f64>; 2], v: [Vector2<f64>; 2]) -> f64 {
        0.5 * (v[0].norm_squared() + v[1].norm_squared()) - q[0].y
    }

    #[constraint]
    fn bars(&self, q: [Vector2<f64>; 2]) -> [f64; 3] {
        let arm = q[1] - Vector2::new(1.0, 0.0);
        [
            0.5 * (q[0].norm_squared() - 0.25),
            0.5 * (arm.norm_squared() - 0.25),
            0.5 * ((q[1] - q[0]).norm_squared() - self.coupler * self.coupler),
        ]
    }

    #[gamma]
    fn shake(&self, q: [Vector2<f64>; 2]) -> f64 {
        0.01 * q[0].x
    }
}

type Two = [Vector2<f64>; 2];

fn start(angle: f64, speed: f64) -> State<Two> {
    let (sin, cos) = angle.sin_cos();
    let arm = 0.5 * Vector2::new(cos, sin);
    let along = speed * Vector2::new(-sin, cos);
    State::new([arm, arm + Vector2::new(1.0, 0.0)], [along; 2])
}

/// Steps a linkage until it fails, or to the end. Returns the error and the largest change of the
/// kinetic energy in a step, relative to the energy.
fn run(
    rule: &dyn Stepper<Two, [f64; 1]>,
    state: State<Two>,
    h: f64,
    steps: u32,
) -> (Option<StepError>, f64) {
    let mut state = rule.consistent(state).unwrap();
    let energy = |state: &State<Two>| 0.5 * (state.p[0].norm_squared() + state.p[1].norm_squared());
    let mut largest: f64 = 0.0;
    for _ in 0..steps {
        let before = state;
        if let Err(error) = rule.step(&mut state, h, &[0.0]) {
            assert_eq!(state, before);
            return (Some(error), largest);
        }
        let change = energy(&state) - energy(&before);
        largest = largest.max(change.abs() / energy(&before));
    }
    (None, largest)
}

/// A coupler that is longer than the distance of the pivots by 10⁻⁹ lets the linkage turn by 60
/// degrees where it is almost a line. A step of 0.01 across this place multiplied the energy by 4.
#[test]
fn a_step_across_a_near_fold_is_an_error() {
    let coupler = 1.0 + 1e-9;
    let torn = Torn { coupler };
    let linkage = Linkage {
        lengths: [0.5, coupler, 0.5],
        spring: 0.3,
    };
    for rule in with_verlet(&torn).iter().chain(&with_verlet(&linkage)) {
        for k in 0..12 {
            let at = start(0.7 + 0.05 * f64::from(k), 1.0);
            let (error, largest) = run(&**rule, at, 0.01, 400);
            let Some(StepError::NearFold { step, part, .. }) = error else {
                panic!("{}: {error:?}, {largest}", rule.name());
            };
            assert!(part < 0.25 && step > 0.0 && step <= 1.0);
            assert!(largest < 0.1, "{}: {largest}", rule.name());
        }
    }
}

#[test]
fn lanes_find_the_same_folds() {
    let coupler = 1.0 + 1e-9;
    let integrator = Integrator::new(Torn { coupler }, StormerVerlet);
    assert!(integrator.plan().in_lanes);
    let summary = Ensemble::new(&integrator)
        .paths(64)
        .seed(1)
        .steps(0.01, 400)
        .start(Starts::each(|path, _| {
            let at = start(0.7 + 0.01 * path as f64, 1.0);
            integrator.consistent(at).unwrap()
        }))
        .observe("x", |_, state: &State<Two>| state.q[0].x)
        .run()
        .unwrap();
    assert_eq!(summary.failures().len(), 64);
    for failure in summary.failures() {
        let is_fold = matches!(failure.cause, Cause::Step(StepError::NearFold { .. }));
        assert!(is_fold, "{failure}");
    }
}

/// Linkages away from folds turn and swing for many steps.
#[test]
fn closed_loops_away_from_folds_go_on() {
    for coupler in [1.05, 1.3, 0.8] {
        let torn = Torn { coupler };
        let rules = with_verlet(&torn).into_iter();
        for rule in rules.filter(|rule| ["midpoint", "stormer_verlet"].contains(&rule.rule())) {
            let (error, largest) = run(&*rule, start(1.0, 1.0), 0.01, 3000);
            assert!(error.is_none(), "{coupler}: {error:?} {largest}");
        }
    }
}

/// A pendulum that turns over and one that swings through both extremes, and a double pendulum.
#[test]
fn pendulums_go_on() {
    let sphere = OnSphere { g: 9.8, s: 0.0 };
    let integrator = Integrator::new(&sphere, StormerVerlet);
    for speed in [1.0, 4.0, 6.2, 6.4, 9.0] {
        let start = State::new([0.0, 0.0, -1.0], [speed, 0.0, 0.0]);
        integrator.after(start, 0.01, &[0.0; 2], 4000);
    }
    let integrator = Integrator::new(two_rods(), Midpoint);
    for speed in [1.0, 4.0, 8.0] {
        integrator.after(two_rods_at(speed), 0.01, &[0.0; 2], 4000);
    }
}

/// Long runs of all systems with steps of a twentieth of their lengths.
struct Long;

impl Check for Long {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let trajectory = integrator.trajectory(start, 0.02, Wiener::new(5));
        for (step, state) in trajectory.take(600).enumerate() {
            state.unwrap_or_else(|error| panic!("{name}, step {step}: {error}"));
        }
    }
}

#[test]
fn no_system_meets_a_fold_in_a_long_run() {
    conservative(&mut Long);
}
