//! Runs of derived steps in ensembles: the same tasks as [`limits`](crate::limits), by the
//! functions that users call, on the threads of the surrounding pool.

use std::hint::black_box;

use sve_runtime::__private::{LANES, Lane, Mask, StateLanes};
use sve_runtime::prelude::*;
use sve_runtime::{OneStepMethod, StepError};

use crate::hand::{self, LONG, RECORD};
use crate::systems::{DoublePendulum, Kubo, Oscillator, Pendulum};
use crate::{DOUBLE, DOUBLE_STEPS, PATHS, STEPS};

/// Returns the mean of the only observable at the end.
pub(crate) fn end(summary: &Summary) -> f64 {
    assert_eq!(summary.failed(), 0, "no path fails");
    let means = summary.statistics()[0].mean();
    means[means.len() - 1]
}

pub(crate) fn oscillators() -> f64 {
    let integrator = Integrator::new(Oscillator { sigma: 1.0 }, Endpoint);
    let summary = Ensemble::new(&integrator)
        .paths(PATHS as u64)
        .seed(1)
        .steps(black_box(0.1), STEPS as u64)
        .every(RECORD as u64)
        .start(State::new([1.0], [0.0]))
        .observe("energy", Oscillator::hamiltonian)
        .run();
    end(&summary.expect("a run"))
}

pub(crate) fn kubos() -> f64 {
    let integrator = Integrator::new(Kubo { a: 1.0, sigma: 1.0 }, Midpoint);
    let summary = Ensemble::new(&integrator)
        .paths(PATHS as u64)
        .seed(1)
        .steps(black_box(0.1), STEPS as u64)
        .every(RECORD as u64)
        .start(State::new([1.0], [0.0]))
        .observe("q", |_, state| state.q[0])
        .run();
    end(&summary.expect("a run"))
}

pub(crate) fn pendulums() -> f64 {
    let integrator = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    let (q, p) = hand::pendulum_starts(PATHS);
    let summary = Ensemble::new(&integrator)
        .paths(PATHS as u64)
        .steps(black_box(0.1), STEPS as u64)
        .start(Starts::each(|path, _| {
            let (tile, lane) = (path as usize / LONG, path as usize % LONG);
            State::new([q[tile][lane]], [p[tile][lane]])
        }))
        .observe("p", |_, state| state.p[0])
        .run();
    end(&summary.expect("a run"))
}

fn double_pendulum() -> Integrator<DoublePendulum, Midpoint> {
    let (m, l, g) = ([1.0, 0.5], [1.0, 0.7], 9.8);
    Integrator::new(DoublePendulum { m, l, g }, Midpoint)
}

/// Returns starts that differ from path to path.
fn double_start(path: u64) -> State<[f64; 2]> {
    let at = path as f64 / DOUBLE as f64;
    State::new([1.0 + at, 0.5 - at], [0.3, -0.2])
}

/// Steps the double pendulums one after the other, by the step of one state.
pub(crate) fn double_pendulums_singly() -> f64 {
    let integrator = double_pendulum();
    let mut sum = 0.0;
    for path in 0..DOUBLE as u64 {
        let states = integrator.trajectory(double_start(path), black_box(0.01), NoNoise);
        let last = states.take(DOUBLE_STEPS).last().expect("a step");
        sum += last.expect("a step").p[0];
    }
    sum / DOUBLE as f64
}

pub(crate) fn double_pendulums() -> f64 {
    let integrator = double_pendulum();
    let summary = Ensemble::new(&integrator)
        .paths(DOUBLE as u64)
        .steps(black_box(0.01), DOUBLE_STEPS as u64)
        .start(Starts::each(|path, _| double_start(path)))
        .observe("p", |_, state| state.p[0])
        .run();
    end(&summary.expect("a run"))
}

/// The cheapest possible step, which adds the increment to q. It shows the cost of an ensemble
/// besides its steps.
struct Walk(Oscillator);

impl OneStepMethod for Walk {
    type System = Oscillator;
    type Increments = [f64; 1];
    type Prepared = ();

    fn system(&self) -> &Oscillator {
        &self.0
    }

    fn prepare(&self, _h: f64) -> Result<(), StepError> {
        Ok(())
    }

    fn step_prepared(
        &self,
        (): &(),
        state: &mut State<[f64; 1]>,
        _h: f64,
        dw: &[f64; 1],
    ) -> Result<(), StepError> {
        state.q[0] += dw[0];
        Ok(())
    }

    #[inline(always)]
    fn step_lanes(
        &self,
        (): &(),
        states: &StateLanes<1>,
        next: &mut StateLanes<1>,
        _h: f64,
        dw: &[Lane; 1],
    ) -> Mask {
        for lane in 0..LANES {
            next.q[0][lane] = states.q[0][lane] + dw[0][lane];
            next.p[0][lane] = states.p[0][lane];
        }
        0
    }
}

pub(crate) fn walks() -> f64 {
    let summary = Ensemble::new(&Walk(Oscillator { sigma: 1.0 }))
        .paths(PATHS as u64)
        .seed(1)
        .steps(black_box(0.1), STEPS as u64)
        .start(State::new([0.0], [0.0]))
        .observe("q", |_, state| state.q[0])
        .run();
    end(&summary.expect("a run"))
}
