//! Paths that stop, and observers with memory: the same bits for any layout of lanes, memories
//! against single paths, and what stopped paths cost.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use sve_models::checks::assert_within;
use sve_models::models::{Kicked, Oscillator, Pushed};
use sve_runtime::__private::{IncrementLanesOf, Mask, StateLanesOf};
use sve_runtime::OneStepMethod;
use sve_runtime::prelude::*;
use sve_runtime::system::StateOf;

use crate::runs::{drawn, free, run_in_parts, scratch};

type Method = Integrator<Pushed, Midpoint>;

fn pendulum() -> Method {
    Integrator::new(Pushed { g: 1.0, s: 0.4 }, Midpoint)
}

const H: f64 = 0.05;

fn observed(method: &Method) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(1500)
        .seed(3)
        .steps(H, 300)
        .every(60)
        .start(Starts::each(|_, rng| {
            State::new([0.1 * rng.normal()], [0.0])
        }))
        .observe("q", |_, state| state.q[0])
        .average("kinetic", |_, state| 0.5 * state.p[0] * state.p[0])
        .integral("area", |_, state| state.q[0])
        .maximum("highest", |_, state| state.q[0])
        .crossings("turns", |_, state| state.p[0])
        .fold(
            "lowest",
            |_, s| s.q[0],
            |m, _, s| *m = m.min(s.q[0]),
            |m| *m,
        )
        .weight(|_, state| 0.1 * state.q[0].powi(2))
        .terminal("u", |_, state| state.q[0].cos())
        .bound("kinetic", ..=0.7)
        .stop_at("right", |_, state| state.q[0] - 1.2)
        .first_passage("left", |_, state| state.q[0] + 0.8)
        .histogram("q", -2.0..2.0, 8)
        .keep_final_states(true)
}

/// With one thread, 16 blocks are run together; with many, or in shards, one.
#[test]
fn no_layout_of_lanes_changes_a_bit() {
    let method = pendulum();
    let whole = run_in_parts(|| observed(&method), &[2, 5], &[&[0, 1, 2]]);
    let passed = whole.passage("right").unwrap().passed()[5];
    assert!((300..1400).contains(&passed), "{passed}");
    assert!(whole.failed() > 0);
}

#[test]
fn a_run_that_was_stopped_goes_on_with_the_same_passages() {
    let method = pendulum();
    let path = scratch("passages.sve");
    let blocks = AtomicU64::new(0);
    let first = observed(&method)
        .threads(1)
        .checkpoint(&path, Duration::ZERO)
        .stop_when(|| blocks.fetch_add(1, Ordering::Relaxed) >= 2);
    assert!(!first.run().unwrap().is_complete());
    let rest = observed(&method)
        .checkpoint(&path, Duration::ZERO)
        .resume(true);
    assert_eq!(rest.run().unwrap(), observed(&method).run().unwrap());
    std::fs::remove_file(path).unwrap();
}

/// The memory of observers, against the states of single paths.
#[test]
fn memories_are_those_of_replayed_paths() {
    let method = pendulum();
    let ensemble = observed(&method).paths(256);
    let summary = ensemble.run().unwrap();
    let ends: Vec<(u64, f64)> = summary.final_states().map(|(k, s)| (k, s.t)).collect();
    let failed: Vec<u64> = summary.failures().iter().map(|f| f.path).collect();
    let starts = drawn(256, 3, |_, rng| 0.1 * rng.normal());
    let (mut area, mut highest, mut lowest, mut turns) = (0.0, 0.0, 0.0, 0.0);
    let (mut kinetic, mut stopped) = (0.0, 0);
    for &(path, end) in &ends {
        let mut last = State::new([starts[path as usize]], [0.0]);
        let (mut sum, mut top, mut low, mut count) = (0.0, last.q[0], last.q[0], 0.0);
        let mut energy = 0.0;
        for state in ensemble.replay(path).unwrap() {
            let state = state.unwrap();
            sum += 0.5 * (state.t - last.t) * (last.q[0] + state.q[0]);
            energy += 0.25 * (state.t - last.t) * (last.p[0].powi(2) + state.p[0].powi(2));
            top = state.q[0].max(top);
            low = state.q[0].min(low);
            if last.p[0] * state.p[0] < 0.0 {
                count += 1.0;
            }
            last = state;
        }
        assert_eq!(last.t, end, "path {path}");
        area += sum;
        // the average of a path that has stopped is that until its end
        kinetic += energy / end;
        stopped += u32::from(end < 300.0 * H);
        highest += top;
        lowest += low;
        turns += count;
    }
    assert_eq!(ends.len() + failed.len(), 256);
    let n = ends.len() as f64;
    let close = |name: &str, sum: f64| {
        let mean = summary[name].mean()[5];
        assert!((mean - sum / n).abs() < 1e-11, "{name}: {mean} {}", sum / n);
    };
    assert!(stopped > 50, "{stopped}");
    close("kinetic", kinetic);
    close("area", area);
    close("highest", highest);
    close("lowest", lowest);
    close("turns", turns);
}

/// A method that counts its steps in lanes.
struct Counting<I>(I, AtomicU64);

impl<I: OneStepMethod> OneStepMethod for Counting<I> {
    type System = I::System;
    type Increments = I::Increments;
    type Prepared = I::Prepared;
    fn system(&self) -> &I::System {
        self.0.system()
    }
    fn prepare(&self, h: f64) -> Result<I::Prepared, StepError> {
        self.0.prepare(h)
    }
    fn step_prepared(
        &self,
        prepared: &I::Prepared,
        state: &mut StateOf<I::System>,
        h: f64,
        dw: &I::Increments,
    ) -> Result<(), StepError> {
        self.0.step_prepared(prepared, state, h, dw)
    }
    fn step_lanes(
        &self,
        prepared: &I::Prepared,
        states: &StateLanesOf<I::System>,
        next: &mut StateLanesOf<I::System>,
        h: f64,
        dw: &IncrementLanesOf<I::Increments>,
    ) -> Mask {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.step_lanes(prepared, states, next, h, dw)
    }
}

/// Paths stop at a constant rate. What they cost is counted in steps of lanes, in units of the
/// steps that the paths make until they stop.
#[test]
fn stopped_paths_cost_no_steps() {
    let cost = |threads: usize, end: f64| {
        let method = Counting(free(), AtomicU64::new(0));
        let h = 0.005;
        #[allow(clippy::cast_sign_loss)] // a number of steps
        let steps = (end / h).round() as u64;
        let summary = Ensemble::new(&method)
            .paths(4096)
            .seed(1)
            .steps(h, steps)
            .start(Starts::each(|_, rng| {
                State::new([0.0], [-1.0 / (1.0 - rng.uniform()).ln()])
            }))
            // the time of passage 1/v is exponential
            .stop_at("wall", |_, state| state.q[0] - 1.0)
            .threads(threads)
            .run()
            .unwrap();
        let exposure = summary.passage("wall").unwrap().rate(0).exposure;
        let steps = method.1.load(Ordering::Relaxed) * sve_runtime::__private::LANES as u64;
        steps as f64 * h / exposure
    };
    // 16 blocks together, until all have stopped: lanes are filled again every 32 steps, and the
    // last tile empties slowly
    let together = cost(1, 20.0);
    assert!(together < 1.3, "{together}");
    // four times as long a horizon costs as much
    let longer = cost(1, 80.0);
    assert!((longer / together - 1.0).abs() < 1e-3, "{longer}");
}

/// The integral of a Brownian motion by the trapezoidal rule over n steps is normal with variance
/// h³ n(4n² − 1)/12.
#[test]
fn integrals_have_their_exact_moments() {
    let method = Integrator::new(Kicked { sigma: 1.0 }, Midpoint);
    let (paths, n, h) = (20_000_u32, 50, 0.1_f64);
    let summary = Ensemble::new(&method)
        .paths(u64::from(paths))
        .seed(17)
        .steps(h, n)
        .start(State::new([0.0], [0.0]))
        .integral("area", |_, state| state.p[0])
        .run()
        .unwrap();
    let n = n as f64;
    let variance = h.powi(3) * n * (4.0 * n * n - 1.0) / 12.0;
    let (mean, measured) = (summary["area"].mean()[1], summary["area"].variance()[1]);
    let count = f64::from(paths);
    assert_within(mean, 0.0, (variance / count).sqrt(), 4.0, "mean");
    let ratio = measured / variance;
    assert_within(ratio, 1.0, (2.0 / count).sqrt(), 4.0, "variance");
}

/// An oscillator in steps of the midpoint rule turns by 2 arctan(h/2) a step, and stays on its
/// circle.
#[test]
fn an_oscillator_has_its_exact_maximum_and_turns() {
    let method = Integrator::new(Oscillator { sigma: 0.0 }, Midpoint);
    let (h, steps) = (0.1_f64, 1000_u64);
    let phase = |path: u64| 0.1 + 0.06 * path as f64;
    let summary = Ensemble::new(&method)
        .paths(100)
        .steps(h, steps)
        .start(Starts::each(move |path, _| {
            State::new([phase(path).cos()], [-phase(path).sin()])
        }))
        .maximum("q", |_, state| state.q[0])
        .crossings("turns", |_, state| state.q[0])
        .run()
        .unwrap();
    let angle = |path: u64, step: u64| phase(path) + 2.0 * (0.5 * h).atan() * step as f64;
    let (mut highest, mut turns) = (0.0, 0.0);
    for path in 0..100 {
        let q = (0..=steps).map(|step| angle(path, step).cos());
        highest += q.fold(f64::MIN, f64::max);
        // cos changes its sign at odd multiples of π/2
        let quarter = |step| (angle(path, step) / std::f64::consts::PI - 0.5).floor();
        turns += quarter(steps) - quarter(0);
    }
    assert!((summary["q"].mean()[1] - highest / 100.0).abs() < 1e-11);
    assert!((summary["turns"].mean()[1] - turns / 100.0).abs() < 1e-12);
}
