//! Steps computed elsewhere with 40-digit arithmetic from the discrete action, independently of
//! this project.

use std::borrow::Borrow as _;
use std::collections::HashMap;

use serde::Deserialize;
use serde_json::Value;
use sve_runtime::__private::{AnyIncrements as _, ConstraintImpulses, Coordinates};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Configuration, Rule, Variational};

use crate::orders::numbers;

/// A run of steps by a rule.
#[derive(Deserialize)]
pub struct ReferenceRun {
    /// Name of the rule.
    pub rule: String,
    /// Parameters of the system.
    params: HashMap<String, Value>,
    h: f64,
    /// Increments of each step.
    dw: Vec<Vec<f64>>,
    /// Entries of q, then entries of p: at the start, and after each step.
    states: Vec<Vec<f64>>,
    /// Multipliers of the constraints at the start of each step, and at its end.
    #[serde(default)]
    lambda: Vec<Vec<f64>>,
    #[serde(default)]
    mu: Vec<Vec<f64>>,
}

/// Compares the runs in a file of the reference data with steps: the error of each run is below a
/// bound.
///
/// # Panics
/// If the file has another number of runs, or an error is above the bound.
pub fn check(file: &str, runs: usize, bound: f64, error: impl Fn(&ReferenceRun) -> f64) {
    let path = format!("{}/../data/{file}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let all: Vec<ReferenceRun> = serde_json::from_str(&text).expect("reference data");
    assert_eq!(all.len(), runs, "{path}");
    for run in &all {
        assert!(run.dw.len() >= 10, "{path}: too few steps");
        assert_eq!(run.dw.len() + 1, run.states.len(), "{path}");
        let error = error(run);
        println!("{file} {}: {error:e}", run.rule);
        assert!(error < bound, "{file} {}: {error:e} > {bound:e}", run.rule);
    }
}

/// Returns the largest difference of two rows of numbers.
fn difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let pairs = found.iter().zip(expected);
    pairs.fold(0.0, |worst, (x, y)| worst.max((x - y).abs()))
}

/// Returns the largest magnitude of a number.
fn size(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |m, x| m.max(x.abs()))
}

impl ReferenceRun {
    /// Returns whether the system has a parameter.
    pub fn has(&self, parameter: &str) -> bool {
        self.params.contains_key(parameter)
    }

    /// Returns a parameter of the system.
    ///
    /// # Panics
    /// If the run has no parameter of this name.
    pub fn number(&self, parameter: &str) -> f64 {
        self.params[parameter].as_f64().expect("a number")
    }

    /// Returns a row of three numbers among the parameters of the system.
    ///
    /// # Panics
    /// If the run has no parameter of this name.
    pub fn vector(&self, parameter: &str) -> Vector3<f64> {
        let value = &self.params[parameter];
        Vector3::from_fn(|i, _| value[i].as_f64().expect("a number"))
    }

    /// Returns the entries of q at the start, then the entries of p.
    pub fn first(&self) -> &[f64] {
        &self.states[0]
    }

    /// Returns the state at the start.
    fn start<Q: Coordinates<N>, const N: usize>(&self) -> State<Q> {
        let mut start = State::new(Q::origin(), Q::no_momentum());
        let (q, p) = self.first().split_at(Q::STORED_VALUES);
        start.q.restore(q);
        start.p.restore(p);
        start
    }

    /// Returns the largest error of an integrator's steps along the run, relative to the largest
    /// entry.
    ///
    /// # Panics
    /// If a step fails, or the integrator takes other states or increments.
    pub fn error<S, R, Q, const N: usize, const M: usize>(&self, system: S, rule: R) -> f64
    where
        S: System<Dims = Dims<N, M, Q>>,
        R: Rule<S::Itself>,
        Q: Coordinates<N>,
    {
        self.error_from(system, rule, self.start())
    }

    /// Returns the largest error of an integrator's steps from `state` along the run, relative to
    /// the largest entry.
    ///
    /// # Panics
    /// If a step fails, or the integrator takes other states or increments.
    pub fn error_from<S, R, Q, const N: usize, const M: usize>(
        &self,
        system: S,
        rule: R,
        mut state: State<Q>,
    ) -> f64
    where
        S: System<Dims = Dims<N, M, Q>>,
        R: Rule<S::Itself>,
        Q: Coordinates<N>,
    {
        let integrator = Integrator::new(system, rule);
        let mut worst: f64 = 0.0;
        for (dw, expected) in self.dw.iter().zip(&self.states[1..]) {
            let processes = || Ok::<_, StepError>(dw.len());
            let increments = R::Increments::take(&mut Default::default(), processes);
            let mut increments = increments.expect("increments");
            increments.as_mut().copy_from_slice(dw);
            let step = integrator.step(&mut state, self.h, increments.borrow());
            step.unwrap_or_else(|error| panic!("{}: {error}", self.rule));
            worst = worst.max(difference(&numbers(&state), expected) / size(expected));
        }
        worst
    }

    /// Returns the largest error of the multipliers of constraints and of the states along the run,
    /// relative to the largest entry of a state.
    ///
    /// # Panics
    /// If a step fails, or the integrator takes other states or increments.
    pub fn error_with_multipliers<S, R, const N: usize, const M: usize>(
        &self,
        system: &S,
        rule: R,
    ) -> f64
    where
        S: System<Dims = Dims<N, M>> + Variational<R> + ConstraintImpulses<R>,
        R: Copy,
    {
        let integrator = Integrator::new(system, rule);
        let mut state = self.start();
        let mut worst = self.error(system, rule);
        for (k, dw) in self.dw.iter().enumerate() {
            let dw: [f64; M] = dw.as_slice().try_into().expect("increments");
            let forces = integrator.constraint_forces(&state, self.h, &dw);
            let forces = forces.unwrap_or_else(|error| panic!("{}: {error}", self.rule));
            let at_start = forces.constraints.iter().map(|force| force.at_start);
            let at_end = forces.constraints.iter().map(|force| force.at_end);
            let found: Vec<f64> = at_start.chain(at_end).collect();
            let expected = [self.lambda[k].as_slice(), &self.mu[k]].concat();
            worst = worst.max(difference(&found, &expected) / size(&self.states[k + 1]));
            integrator.step(&mut state, self.h, &dw).expect("a step");
        }
        worst
    }
}
