//! Which solution a step takes: the one connected with no noise and h → 0. Random steps are
//! compared in `tests/statistics/tests/roots`.

use sve_models::assert_matches;
use sve_models::checks::{assert_close, failure};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// `½v² + cos kq`, kicked.
#[derive(Clone, Copy, Debug)]
struct Waves {
    k: f64,
    gamma: f64,
}

#[variational(gauss(2), gauss(3), gauss(2, stage_noise))]
impl Waves {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + (self.k * q).cos()
    }
    #[gamma]
    fn kick(&self, q: f64) -> f64 {
        self.gamma * q.cos()
    }
}

const PENDULUM: Waves = Waves { k: 1.0, gamma: 0.0 };
const SHORT: Waves = Waves { k: 3.0, gamma: 0.0 };
const KICKED: Waves = Waves {
    k: 1.0,
    gamma: 20.0,
};

/// A start from which Newton's method contracts to another solution at this step size.
const START: ([f64; 2], f64) = (
    [1.436_785_055_503_657_4, -0.825_753_215_822_708_8],
    3.978_125_703_128_268_4,
);

fn end<R>(system: Waves, rule: R, [q, p]: [f64; 2], h: f64, dw: f64) -> Result<[f64; 2], StepError>
where
    Waves: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let start = State::new([q], [p]);
    let mut state = start;
    let result = Integrator::new(system, rule).step(&mut state, h, &[dw]);
    assert!(result.is_ok() || state == start);
    result.map(|()| [state.q[0], state.p[0]])
}

#[track_caller]
fn assert_near(found: Result<[f64; 2], StepError>, expected: [f64; 2]) {
    assert_close(&found.unwrap(), &expected, 1e-9, "the end");
}

/// The ends were found by continuation apart from the runtime.
#[test]
fn a_contracting_iteration_does_not_decide() {
    let (start, h) = START;
    let connected = [-1.808_352_783_411_216_7, 0.641_961_110_511_242_2];
    assert_near(end(PENDULUM, Gauss::<2>, start, h, 0.0), connected);
    let connected = [-0.410_041_533_331_146_2, 0.662_447_701_825_125_1];
    assert_near(
        end(SHORT, Gauss::<2>, [0.45056, 0.21958], 1.65077, 0.0),
        connected,
    );
    let connected = [-4.246_180_321_121_49, 7.794_555_133_366_677];
    assert_near(
        end(KICKED, Gauss::<2>, [-1.81580, 0.11326], 0.5, -2.44331),
        connected,
    );
}

/// Increments at the stages in proportion to the weights are those of the rule without stage noise.
#[test]
fn stage_noise_takes_the_same_solution() {
    let mut state = State::new([-1.81580], [0.11326]);
    let dw = -2.44331;
    let integrator = Integrator::new(KICKED, StageNoise(Gauss::<2>));
    integrator.step(&mut state, 0.5, &[0.5 * dw; 2]).unwrap();
    let connected = [-4.246_180_321_121_49, 7.794_555_133_366_677];
    assert_near(Ok([state.q[0], state.p[0]]), connected);
}

/// Newton's method has solutions at these step sizes, but the path from small steps ends before.
#[test]
fn steps_beyond_the_end_of_the_path_are_refused() {
    let lost_at = |result: Result<[f64; 2], StepError>| match result {
        Err(StepError::BranchLost { step, reached, .. }) => (step, reached),
        other => panic!("{other:?}"),
    };
    let (step, reached) = lost_at(end(PENDULUM, Gauss::<2>, [2.07196, -0.33162], 4.65841, 0.0));
    assert!((step - 0.903).abs() < 1e-3 && reached == 0.0, "{step}");
    let (step, reached) = lost_at(end(PENDULUM, Gauss::<3>, [2.49141, -1.29913], 4.97305, 0.0));
    assert!((step - 0.964).abs() < 1e-3 && reached == 0.0, "{step}");
}

/// Five pendulums beside one another: more coordinates than have bounds.
#[derive(Clone, Copy, Debug)]
struct Pendulums;

#[variational(gauss(2), gauss(3))]
impl Pendulums {
    fn lagrangian(&self, q: [f64; 5], v: [f64; 5]) -> f64 {
        (0..5).map(|i| 0.5 * v[i] * v[i] + q[i].cos()).sum()
    }
}

#[test]
fn many_coordinates_take_the_solution_of_each() {
    let ([q, p], h) = START;
    let mut state = State::new([q, 0.1, -0.2, 0.3, 0.0], [p, 0.0, 0.1, 0.0, -0.2]);
    let integrator = Integrator::new(Pendulums, Gauss::<2>);
    integrator.step(&mut state, h, &[]).unwrap();
    let connected = [-1.808_352_783_411_216_7, 0.641_961_110_511_242_2];
    assert_near(Ok([state.q[0], state.p[0]]), connected);
    // one of the paths ends
    let start = State::new(
        [2.49141, 0.1, 0.0, 0.0, 0.0],
        [-1.29913, 0.0, 0.0, 0.0, 0.1],
    );
    let error = failure(
        &Integrator::new(Pendulums, Gauss::<3>),
        &start,
        4.97305,
        &[],
    );
    assert_matches!(error, StepError::BranchLost { .. });
}
