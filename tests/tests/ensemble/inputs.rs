//! Inputs of the paths of an ensemble: each path is the trajectory with the same inputs, also where
//! a step leaves the lanes.

use std::time::Duration;

use sve_models::assert_matches;
use sve_runtime::ensemble::{Cause, Difference};
use sve_runtime::prelude::*;

use crate::runs::scratch;

/// A pendulum with a motor, whose noise is fed back too.
pub(crate) struct Motor {
    pub(crate) g: f64,
    pub(crate) sigma: f64,
}

#[variational(
    endpoint,
    initial_point,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(3),
    gauss(2, stage_noise)
)]
impl Motor {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2], u: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + (1.0 + u[1] * u[1]) * v[1] * v[1])
            + self.g * (q[0] + 0.3 * q[1]).cos()
            + u[0] * q[0]
    }
    #[force]
    fn brake(&self, _q: [f64; 2], v: [f64; 2], u: [f64; 2]) -> [f64; 2] {
        [-0.1 * u[1] * v[0], -0.1 * v[1]]
    }
    #[gamma]
    fn shake(&self, q: [f64; 2], u: [f64; 2]) -> f64 {
        self.sigma * (1.0 + u[0]) * q[0].sin() * q[1].cos()
    }
}

/// Inputs that differ from path to path, from step to step, and with the state.
pub(crate) fn fed_back(path: u64, step: u64, state: &State<[f64; 2]>) -> [f64; 2] {
    let phase = path as f64 + 0.1 * step as f64;
    [
        0.5 * phase.sin() - 0.4 * state.p[0],
        0.3 * phase.cos() + 0.1 * state.q[1],
    ]
}

pub(crate) const PATHS: u64 = 71;
pub(crate) const H: f64 = 0.05;
pub(crate) const STEPS: u64 = 40;

pub(crate) fn start() -> State<[f64; 2]> {
    State::at(0.5, [0.4, -0.3], [0.2, 0.1])
}

/// Compares the ends of all paths with those of single trajectories.
macro_rules! assert_equal_paths {
    ($rule:expr) => {{
        let motor = Integrator::new(Motor { g: 2.0, sigma: 0.3 }, $rule);
        let summary = Ensemble::new(&motor)
            .paths(PATHS)
            .seed(3)
            .steps(H, STEPS)
            .start(start())
            .inputs("fed back", fed_back)
            .keep_final_states(true)
            .run()
            .unwrap();
        assert_eq!(summary.failed(), 0);
        for (path, end) in summary.final_states() {
            let noise = Wiener::new(3).path(path);
            let alone = motor.trajectory(start(), H, noise);
            let mut alone = alone.inputs(|step, state| fed_back(path, step, state));
            let expected = alone.nth(STEPS as usize - 1).unwrap().unwrap();
            for i in 0..2 {
                assert!((end.q[i] - expected.q[i]).abs() < 1e-12, "path {path}");
                assert!((end.p[i] - expected.p[i]).abs() < 1e-12, "path {path}");
            }
            assert_eq!(end.t, expected.t);
        }
    }};
}

#[test]
fn each_path_is_the_trajectory_with_its_inputs() {
    assert_equal_paths!(Endpoint);
    assert_equal_paths!(InitialPoint);
    assert_equal_paths!(Midpoint);
    assert_equal_paths!(StormerVerlet);
    assert_equal_paths!(Gauss::<2>);
    assert_equal_paths!(Gauss::<3>);
    assert_equal_paths!(StageNoise(Gauss::<2>));
    assert_equal_paths!(Composed::new(Midpoint, KahanLi8));
    assert_equal_paths!(Composed::new(StormerVerlet, KahanLi8));
}

pub(crate) fn motor() -> Integrator<Motor, Midpoint> {
    Integrator::new(Motor { g: 2.0, sigma: 0.3 }, Midpoint)
}

/// A macro, since the type of an ensemble with inputs has no name.
macro_rules! ensemble {
    ($motor:expr) => {
        Ensemble::new($motor)
            .inputs("fed back", fed_back)
            .paths(PATHS)
            .seed(3)
            .steps(H, STEPS)
            .start(start())
            .keep_final_states(true)
    };
}

/// Steps that the lanes do not solve, tangent vectors, other threads, shards and replays see the
/// same inputs.
#[test]
fn no_path_sees_the_inputs_of_another() {
    let motor = motor();
    let ends = ensemble!(&motor).run().unwrap();
    let with = |summary: Summary| {
        for ((_, end), (_, other)) in ends.final_states().zip(summary.final_states()) {
            assert_eq!(end.q, other.q);
            assert_eq!(end.p, other.p);
        }
    };
    with(ensemble!(&motor).threads(1).run().unwrap());
    with(
        ensemble!(&motor)
            .gradient("q", ["g"], |s| s.q[0])
            .run()
            .unwrap(),
    );
    with(
        ensemble!(&motor)
            .refine(4)
            .integral("q", |_, s| s.q[0])
            .run()
            .unwrap(),
    );
    let mut shards = ensemble!(&motor).shard(0, 2).run().unwrap();
    shards
        .merge(ensemble!(&motor).shard(1, 2).run().unwrap())
        .unwrap();
    with(shards);
    let ensemble = ensemble!(&motor);
    let replayed = ensemble.replay(70).unwrap().last().unwrap().unwrap();
    let (path, end) = ends.final_states().last().unwrap();
    assert_eq!((path, end.q, end.p), (70, &replayed.q[..], &replayed.p[..]));

    // a single iteration is enough for no lane, so that the scalar step makes all of them
    let one = Newton {
        max_iterations: 1,
        ..Newton::default()
    };
    let motor = Integrator::new(Motor { g: 2.0, sigma: 0.3 }, Midpoint).with_newton(one);
    for ((_, end), (path, other)) in ends
        .final_states()
        .zip(ensemble!(&motor).run().unwrap().final_states())
    {
        assert!((end.q[0] - other.q[0]).abs() < 1e-12, "{path}");
    }
}

/// The name stands for the function: under another name shards do not merge, and a checkpoint does
/// not continue.
#[test]
fn inputs_of_another_name_are_another_run() {
    let (motor, file) = (motor(), scratch("inputs.sve"));
    let renamed = || ensemble!(&motor).inputs("fed back twice", fed_back);
    let mut shard = ensemble!(&motor).shard(0, 2).run().unwrap();
    let error = shard.merge(renamed().shard(1, 2).run().unwrap());
    let what = Difference::Method;
    assert_matches!(error, Err(EnsembleError::OtherRun { what: w }) if *w == what);
    let written = ensemble!(&motor)
        .checkpoint(&file, Duration::ZERO)
        .run()
        .unwrap();
    let error = renamed()
        .checkpoint(&file, Duration::ZERO)
        .resume(true)
        .run();
    assert_matches!(error, Err(EnsembleError::OtherCheckpoint { what: w, .. }) if *w == what);
    let again = ensemble!(&motor)
        .checkpoint(&file, Duration::ZERO)
        .resume(true);
    assert_eq!(again.run().unwrap(), written);
    std::fs::remove_file(file).unwrap();
}

/// Each row of a sweep over starts is the run of its own, with the same inputs.
#[test]
fn rows_of_a_sweep_have_the_inputs() {
    let motor = motor();
    let other = State::at(0.5, [0.1, 0.2], [0.0, 0.3]);
    let ensemble = |start| ensemble!(&motor).start(start).observe("q", |_, s| s.q[0]);
    let sweep = ensemble(start()).sweep(&[start(), other]).unwrap();
    for (row, start) in sweep.rows().iter().zip([start(), other]) {
        assert_eq!(row["q"].mean(), ensemble(start).run().unwrap()["q"].mean());
    }
}

/// A passage is found within a step that holds the inputs of its path: where the event of the
/// trajectory is.
#[test]
fn passages_within_steps_hold_the_inputs() {
    let quiet = Integrator::new(Motor { g: 2.0, sigma: 0.0 }, Midpoint);
    let ensemble = ensemble!(&quiet).stop_at("out", |_, state| state.q[0] - 0.45);
    let summary = ensemble.run().unwrap();
    let mut stopped = 0;
    for (path, end) in summary.final_states() {
        let path_of = quiet.trajectory(start(), H, NoNoise);
        let path_of = path_of.inputs(|step, state| fed_back(path, step, state));
        let mut events = path_of.stop_at(|_, state| state.q[0] - 0.45);
        if (end.q[0] - 0.45).abs() < 1e-9 {
            stopped += 1;
            let alone = events.by_ref().last().unwrap().unwrap();
            assert!((alone.t - end.t).abs() < 1e-9, "{path}");
            assert!((alone.p[1] - end.p[1]).abs() < 1e-9, "{path}");
        }
    }
    assert!(stopped > 10, "{stopped}");
}

/// dp = u dW with u = σp: the moment of Itô, `E p_N²` = p₀² (1 + σ²h)^N.
#[test]
fn feedback_of_a_noise_has_the_moments_of_ito() {
    struct Kicked;
    #[variational(midpoint)]
    impl Kicked {
        fn lagrangian(&self, _q: f64, v: f64) -> f64 {
            0.5 * v * v
        }
        #[gamma]
        fn kick(&self, q: f64, u: f64) -> f64 {
            u * q
        }
    }
    let kicked = Integrator::new(Kicked, Midpoint);
    let (sigma, h, steps) = (0.4, 0.05, 20);
    let summary = Ensemble::new(&kicked)
        .paths(40_000)
        .seed(8)
        .steps(h, steps)
        .start(State::new([0.0], [1.0]))
        .observe("p", |_, state| state.p[0])
        .observe("p2", |_, state| state.p[0].powi(2))
        .inputs("sigma p", move |_, _, state| sigma * state.p[0])
        .run()
        .unwrap();
    let exact = [1.0, (1.0 + sigma * sigma * h).powi(steps as i32)];
    for (name, exact) in ["p", "p2"].into_iter().zip(exact) {
        let (mean, error) = (summary[name].mean()[1], summary[name].standard_error()[1]);
        assert!(
            (mean - exact).abs() < 4.0 * error,
            "{name}: {mean} ± {error}, {exact}"
        );
    }
    // Stratonovich's moment is far away
    assert!(summary["p2"].standard_error()[1] < 0.01);
}

/// The derivative of a mean by an input that is the same in all steps is the sum over the steps.
#[test]
fn means_have_derivatives_by_a_constant_input() {
    struct Pushed;
    #[variational(stormer_verlet)]
    impl Pushed {
        fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
            0.5 * v * v + u * q
        }
        #[gamma]
        fn kick(&self, q: f64) -> f64 {
            q
        }
    }
    let pushed = Integrator::new(Pushed, StormerVerlet);
    let summary = Ensemble::new(&pushed)
        .paths(100)
        .steps(0.1, 30)
        .start(State::new([0.0], [0.0]))
        .inputs("step", |_, step, _| step as f64)
        .gradient("q", ["u[0]"], |state| state.q[0])
        .run()
        .unwrap();
    let by = summary.derivative("q", "u[0]").unwrap();
    // h² Σ (N − k − ½) = t²/2
    assert!((by.mean()[1] - 4.5).abs() < 1e-12);
    assert!(by.standard_error()[1] < 1e-12);
}

#[test]
fn bad_inputs_are_errors_with_path_and_step() {
    let motor = motor();
    let table: Vec<[f64; 2]> = vec![[0.1, 0.2]; STEPS as usize];
    let summary = ensemble!(&motor)
        .inputs("bad", |path, step, _| match (path, step) {
            (5, 7) => [f64::NAN, 0.0],
            (40, 9) => table[table.len()],
            _ => table[step as usize],
        })
        .run()
        .unwrap();
    let of = |path| {
        let failures = summary.failures().iter();
        failures
            .clone()
            .find(|failure| failure.path == path)
            .unwrap()
            .clone()
    };
    assert_eq!(summary.failed(), 2);
    let nan = of(5);
    assert_eq!(nan.step, 7);
    assert!(
        matches!(&nan.cause, Cause::Step(StepError::NonFiniteInput { what, .. }) if what == "u[0]")
    );
    let panicked = of(40);
    assert!(matches!(
        panicked.cause,
        Cause::Step(StepError::Inputs { step: 9, .. })
    ));

    let leveled = ensemble!(&motor).observe("q", |_, state| state.q[0]);
    let error = leveled.multilevel("q").run(0.1).unwrap_err().to_string();
    assert!(error.contains("inputs"), "{error}");
}
