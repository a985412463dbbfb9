//! Ensembles of a noisy pendulum whose torque is a parameter, and of the same pendulum whose torque
//! is an input, a friction that is computed from the state at the start of each step.

use std::hint::black_box;

use sve_runtime::prelude::*;

use crate::derived::end;
use crate::{PATHS, STEPS, Task, side};

#[derive(Clone, Copy)]
struct Parameter {
    torque: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Parameter {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos() + self.torque * q
    }

    #[gamma]
    fn kick(&self, q: f64) -> f64 {
        0.1 * q
    }
}

#[derive(Clone, Copy)]
struct Input;

#[variational(midpoint, stormer_verlet)]
impl Input {
    fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
        0.5 * v * v + q.cos() + u * q
    }

    #[gamma]
    fn kick(&self, q: f64) -> f64 {
        0.1 * q
    }
}

/// Returns the mean of p at the end with this ensemble of a pendulum.
macro_rules! run {
    ($ensemble:expr) => {{
        let ensemble = $ensemble.paths(PATHS as u64).seed(1);
        let ensemble = ensemble.steps(black_box(0.1), STEPS as u64);
        let ensemble = ensemble.start(State::new([1.0], [0.0]));
        end(&ensemble
            .observe("p", |_, state| state.p[0])
            .run()
            .expect("a run"))
    }};
}

macro_rules! task {
    ($name:literal, $rule:expr, $wanted:literal) => {
        Task {
            name: $name,
            count: PATHS * STEPS,
            sides: vec![
                side("a parameter", || {
                    let torque = black_box(0.1);
                    let pendulum = Integrator::new(Parameter { torque }, $rule);
                    run!(Ensemble::new(&pendulum))
                }),
                side("an input", || {
                    let pendulum = Integrator::new(Input, $rule);
                    let ensemble = Ensemble::new(&pendulum);
                    run!(ensemble.inputs("friction", |_, _, state| -0.1 * state.p[0]))
                })
                .wanted($wanted),
            ],
        }
    };
}

pub(crate) fn tasks() -> [Task<'static>; 2] {
    [
        task!("feedback, midpoint", Midpoint, 1.3),
        task!("feedback, Verlet", StormerVerlet, 1.3),
    ]
}
