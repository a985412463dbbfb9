//! Steps computed elsewhere with 40-digit arithmetic from the discrete action, independently of this project.

use std::collections::HashMap;

use serde::Deserialize;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, Increments, Rule, System};

/// A run of steps by a rule.
#[derive(Deserialize)]
pub struct ReferenceRun {
    /// Name of the rule.
    pub rule: String,
    /// Parameters of the system.
    pub params: HashMap<String, f64>,
    h: f64,
    /// Increments of each step.
    dw: Vec<Vec<f64>>,
    /// Entries of q, then those of p: at the start, and after each step.
    states: Vec<Vec<f64>>,
}

impl ReferenceRun {
    /// Reads the runs in a file of the reference data.
    ///
    /// # Panics
    /// If the file cannot be read, or has a run without a state for each step.
    pub fn read(file: &str) -> Vec<Self> {
        let path = format!("{}/../data/{file}.json", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
        let runs: Vec<Self> = serde_json::from_str(&text).expect("reference data");
        for run in &runs {
            assert!(run.dw.len() >= 10, "{path}: too few steps");
            assert_eq!(run.dw.len() + 1, run.states.len(), "{path}");
        }
        runs
    }

    /// Returns the largest error of an integrator's steps along the run, relative to the largest entry.
    ///
    /// # Panics
    /// If a step fails, or the integrator takes other states or increments.
    pub fn error<S, R, const N: usize, const M: usize>(&self, integrator: &Integrator<S, R>) -> f64
    where
        S: System<Dims = Dims<N, M>>,
        R: Rule<S::Itself>,
    {
        let array = |z: &[f64]| -> [f64; N] { z.try_into().expect("coordinates") };
        let (q, p) = self.states[0].split_at(N);
        let mut state = State::new(array(q), array(p));
        let mut worst: f64 = 0.0;
        for (dw, expected) in self.dw.iter().zip(&self.states[1..]) {
            let mut increments = R::Increments::NONE;
            increments.as_mut().copy_from_slice(dw);
            let step = integrator.step(&mut state, self.h, &increments);
            step.unwrap_or_else(|error| panic!("{}: {error}", self.rule));
            let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            for (x, y) in state.q.iter().chain(&state.p).zip(expected) {
                worst = worst.max((x - y).abs() / size);
            }
        }
        worst
    }
}
