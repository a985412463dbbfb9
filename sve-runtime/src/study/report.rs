//! The results of a study.

use super::csv::Record;
use super::estimate::Estimate;
use super::order::{NotAsymptotic, Order};
use crate::description::SystemDescription;

/// The results of a [`Study`](super::Study): a row for each method and number of steps.
///
/// `Display` prints a table; [`records`](Self::records) are the rows as
/// [`write_csv`](super::write_csv) writes them.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    pub(super) problem: String,
    pub(super) horizon: f64,
    pub(super) paths: u64,
    pub(super) observables: Vec<String>,
    pub(super) rows: Vec<Row>,
    pub(super) orders: Vec<Order>,
    pub(super) not_asymptotic: Vec<NotAsymptotic>,
    pub(super) weak_orders: Vec<Order>,
    pub(super) weak_not_asymptotic: Vec<NotAsymptotic>,
    /// The description of the system on pages.
    pub(crate) system: SystemDescription,
    /// The name of each method, and its description.
    pub(crate) methods: Vec<(String, String)>,
    /// The reference against which errors are measured.
    pub(crate) reference: String,
    /// The seed of the paths; `None` without noise, or where the reference draws them.
    pub(crate) seed: Option<u64>,
}

/// One method with one step size.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The name of the method.
    pub method: String,
    /// Step size.
    pub h: f64,
    /// Steps to the horizon.
    pub steps: usize,
    /// Strong error at the horizon, the root of the mean square over the paths that did not fail;
    /// `None` if all failed.
    pub error: Option<Estimate>,
    /// Weak error of each observable, in the order in which they were given: the mean of the method
    /// less the mean of the reference. Empty if all paths failed.
    pub weak_errors: Vec<Estimate>,
    /// The change of the invariant, if one is measured.
    pub invariant: Option<Invariant>,
    /// Times; `None` if they were not measured, or every path failed.
    pub timing: Option<Timing>,
    /// Newton iterations of a step, on average along the first path that did not fail; `None` if
    /// the method does not count them.
    pub newton_iterations: Option<f64>,
    /// Paths on which a step failed, or the error overflowed.
    pub failures: u64,
}

/// The change of an invariant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invariant {
    /// Largest difference from its first value, over steps and paths.
    pub largest: f64,
    /// The slope of the least-squares line through its values, averaged over paths: the secular
    /// change in a unit of time, if there is one. For an error that only oscillates, the slope
    /// depends on the phases at the ends and has either sign: it passes through zero as the step
    /// size changes. A single small value proves nothing; compare several step sizes.
    pub drift: Estimate,
}

/// The times of a step and of a solution with precomputed increments, on one thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Nanoseconds a step, median of the repeats (where a path has more than 2048 steps, of each
    /// part of it).
    pub ns_per_step: f64,
    /// Half the distance of its quartiles.
    pub ns_spread: f64,
    /// Seconds to the horizon on one path, median of the repeats.
    pub time_to_solution: f64,
}

impl Report {
    /// The name of the problem.
    pub fn problem(&self) -> &str {
        &self.problem
    }

    /// Returns the length of the solutions.
    pub fn horizon(&self) -> f64 {
        self.horizon
    }

    /// Returns the number of paths.
    pub fn paths(&self) -> u64 {
        self.paths
    }

    /// The names of the observables.
    pub fn observables(&self) -> &[String] {
        &self.observables
    }

    /// Every method in the order in which they were added, each with every number of steps.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The row of a method and a number of steps.
    pub fn row(&self, method: &str, steps: usize) -> Option<&Row> {
        let wanted = |row: &&Row| row.method == method && row.steps == steps;
        self.rows.iter().find(wanted)
    }

    /// The measured strong order of each method whose local slopes have settled at these step
    /// sizes.
    pub fn orders(&self) -> &[Order] {
        &self.orders
    }

    /// The other methods, with their local slopes.
    pub fn not_asymptotic(&self) -> &[NotAsymptotic] {
        &self.not_asymptotic
    }

    /// The measured weak order of each observable and method whose local slopes have settled.
    ///
    #[doc = include_str!("example.md")]
    /// let report = study().observe("energy", Mechanics::hamiltonian).run()?;
    /// for order in report.weak_orders() {
    ///     println!("{order}");
    /// }
    #[doc = include_str!("../example_end.md")]
    pub fn weak_orders(&self) -> &[Order] {
        &self.weak_orders
    }

    /// The other observables and methods, with their local slopes.
    pub fn weak_not_asymptotic(&self) -> &[NotAsymptotic] {
        &self.weak_not_asymptotic
    }

    /// The rows as records of a file, with the source `sve` and its version.
    pub fn records(&self) -> Vec<Record> {
        let record = |row: &Row| Record {
            problem: self.problem.clone(),
            method: row.method.clone(),
            h: Some(row.h),
            error: row.error.map(|e| e.value),
            error_se: row.error.map(|e| e.standard_error),
            weak_error: row.weak_errors.first().map(|e| e.value),
            weak_error_se: row.weak_errors.first().map(|e| e.standard_error),
            energy_error: row.invariant.map(|i| i.largest),
            energy_drift: row.invariant.map(|i| i.drift.value),
            ns_per_step: row.timing.map(|t| t.ns_per_step),
            ns_spread: row.timing.map(|t| t.ns_spread),
            time_to_solution_s: row.timing.map(|t| t.time_to_solution),
            newton_iterations: row.newton_iterations,
            failures: row.failures,
            source: concat!("sve ", env!("CARGO_PKG_VERSION")).to_owned(),
        };
        self.rows.iter().map(record).collect()
    }
}
