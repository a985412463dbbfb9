//! The results of an ensemble.
//!
//! Input: the nodes of a merge tree. Output: statistics by name, at each recorded time. Invariant:
//! a complete run has one node; the statistics of several nodes are their merge from left to right.

use core::fmt;

#[cfg(feature = "plot")]
use super::antithetic::are_pairs;
use super::failure::Failure;
use super::final_state::FinalState;
use super::info::Info;
use super::merge_tree::{MergeTree, PartialResult};
use super::statistic::Shown;
use super::warning::Warning;
use super::{BLOCK_PATHS, EnsembleError, path_at};
#[cfg(feature = "plot")]
use crate::description::RunDescription;

/// Statistics of the paths of an [`Ensemble`](super::Ensemble): of all, or of the shards merged so
/// far.
#[derive(Clone)]
pub struct Summary {
    pub(super) info: Info,
    pub(super) tree: MergeTree,
    /// The statistics as users read them.
    pub(super) shown: Shown,
    counts: Vec<u64>,
    refined: u64,
    failed: u64,
    failures: Vec<Failure>,
    /// Warnings about the runs, and not about their results.
    run_warnings: Vec<Warning>,
}

impl Summary {
    /// Summarises the nodes of a tree, which has at least one.
    pub(super) fn new(info: Info, tree: MergeTree) -> Self {
        let mut summary = Self {
            shown: Shown::default(),
            counts: Vec::new(),
            refined: 0,
            failed: 0,
            failures: Vec::new(),
            run_warnings: Vec::new(),
            info,
            tree,
        };
        let mut nodes = summary.tree.nodes.values();
        let whole = nodes.next().cloned().map(|first| {
            nodes.fold(first, |mut whole, node| {
                whole.merge(node);
                whole
            })
        });
        if let Some(whole) = whole {
            summary.show(whole);
        }
        summary
    }

    /// Adds warnings about the run.
    pub(super) fn warned(mut self, warnings: impl IntoIterator<Item = Warning>) -> Self {
        self.run_warnings.extend(warnings);
        self
    }

    fn show(&mut self, node: PartialResult) {
        self.counts = node.counts;
        self.refined = node.refined;
        self.failed = node.failed;
        self.failures = node.failures;
        for statistic in node.statistics {
            statistic.show(self);
        }
    }

    /// The paths are antithetic pairs.
    #[cfg(feature = "plot")]
    pub(crate) fn is_antithetic(&self) -> bool {
        are_pairs(&self.info.statistics)
    }

    /// The description of the run.
    #[cfg(feature = "plot")]
    pub(crate) fn description(&self) -> &RunDescription {
        &self.info.description
    }

    /// Number of paths of the whole ensemble.
    #[cfg(feature = "plot")]
    pub(crate) fn paths_of_ensemble(&self) -> u64 {
        self.info.paths
    }

    /// The recorded times: the start, the time after each `every` steps, and the end.
    pub fn times(&self) -> &[f64] {
        &self.info.times
    }

    /// Returns the number of paths that were run, including the paths that failed.
    pub fn paths(&self) -> u64 {
        let at = |block| path_at(block, self.info.paths);
        let of = |node: &PartialResult| at(node.first + node.blocks) - at(node.first);
        self.tree.nodes.values().map(of).sum()
    }

    /// Returns whether the summary has all paths of the ensemble, and not only the paths of some
    /// shards.
    pub fn is_complete(&self) -> bool {
        self.paths() == self.info.paths
    }

    /// Returns the number of paths in the statistics, at each recorded time: the paths that have
    /// not failed before.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Returns the number of paths that failed.
    pub fn failed(&self) -> u64 {
        self.failed
    }

    /// Returns the number of steps that failed and were made in smaller steps, see
    /// [`refine`](super::Ensemble::refine).
    pub fn refined_steps(&self) -> u64 {
        self.refined
    }

    /// The failures of the lowest paths, at most [`FAILURES_KEPT`](super::FAILURES_KEPT) = 256, in
    /// their order: number, time and error of each. [`failed`](Self::failed) counts all failures;
    /// [`replay`](super::Ensemble::replay) shows any path that failed.
    pub fn failures(&self) -> &[Failure] {
        &self.failures
    }

    /// Returns warnings about unreliable statistics: observables that diverge, and means that
    /// depend on one path; and about a checkpoint that could not be written. See [`Warning`] for
    /// the criteria. `Display` and `write_html` show them.
    ///
    /// ```
    /// use sve_runtime::ensemble::Warning;
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator { omega: f64 }
    ///
    /// #[variational(endpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
    ///         0.5 * v * v - 0.5 * (self.omega * q).powi(2)
    ///     }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// // this rule is unstable from ωh = 2 on
    /// let stiff = Integrator::new(Oscillator { omega: 21.0 }, Endpoint);
    /// let ensemble = Ensemble::new(&stiff)
    ///     .paths(100).steps(0.1, 100).every(10)
    ///     .start(State::new([1.0], [0.0]))
    ///     .observe("energy", |system, state| system.hamiltonian(state));
    /// let summary = ensemble.run()?;
    /// assert_eq!(summary.failed(), 0); // no state is infinite yet
    /// let warnings = summary.warnings();
    /// assert!(matches!(&warnings[..], [Warning::Diverges { name, .. }] if name == "energy"));
    /// // a bound makes paths fail that leave a range
    /// let summary = ensemble.bound("energy", ..=1e6).run()?;
    /// assert_eq!(summary.failed(), 100);
    /// # Ok(())
    /// # }
    /// ```
    pub fn warnings(&self) -> Vec<Warning> {
        let all = self.statistics().iter();
        let of_statistics = all.flat_map(|s| s.warnings(&self.info.times));
        of_statistics
            .chain(self.run_warnings.iter().cloned())
            .collect()
    }

    /// The final states of the paths that did not fail, with their numbers, in their order; none
    /// unless [`keep_final_states`](super::Ensemble::keep_final_states) was asked for.
    pub fn final_states(&self) -> impl Iterator<Item = (u64, FinalState<'_>)> {
        let (coordinates, momenta) = (self.info.coordinates, self.info.momenta);
        self.tree.nodes.values().flat_map(move |node| {
            let rows = node.final_states.chunks_exact(1 + coordinates + momenta);
            let states = rows.map(move |row| {
                let (q, p) = row[1..].split_at(coordinates);
                FinalState { t: row[0], q, p }
            });
            node.final_paths.iter().copied().zip(states)
        })
    }

    /// Adds the paths of another shard of the same run.
    ///
    /// Shards can be merged in any order. All shards together have the bits of the whole run.
    ///
    /// Shards belong to the same run if they have equal settings, formulas of the system, values of
    /// its parameters (of the fields that the functions of its block use), method, rule and
    /// options, and starts. Closures cannot be compared. They are sampled, with all bits: starts of
    /// the first 16 paths, of 16 evenly distributed paths, and of the last path; observables and
    /// states along path 0, at its recorded times, for 4096 steps or a thousandth of all steps of
    /// the ensemble, whichever is more, and along three other paths for 64 steps. **Other values of
    /// a closure are not compared**: give shards equal closures. A
    /// [`OneStepMethod`](crate::OneStepMethod) of your own adds its options in
    /// [`identify`](crate::OneStepMethod::identify). Shards of machines whose mathematical
    /// functions differ in the last digit do not merge.
    ///
    #[doc = include_str!("example.md")]
    /// let mut summary = ensemble().shard(1, 2).run()?;
    /// summary.merge(ensemble().shard(0, 2).run()?)?;
    /// assert_eq!(summary["q"].mean(), ensemble().run()?["q"].mean());
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// [`EnsembleError::OtherRun`], which names the difference; [`EnsembleError::Overlap`] if both
    /// have the same paths. Nothing is merged then.
    pub fn merge(&mut self, other: Self) -> Result<(), EnsembleError> {
        if let Some(what) = self.info.difference(&other.info) {
            return Err(EnsembleError::OtherRun { what });
        }
        let blocks = |node: &PartialResult| node.first..node.first + node.blocks;
        let nodes = other.tree.nodes.values();
        if let Some(block) = nodes.flat_map(blocks).find(|&block| self.tree.has(block)) {
            let first = block * BLOCK_PATHS;
            let last = path_at(block + 1, self.info.paths) - 1;
            return Err(EnsembleError::Overlap { first, last });
        }
        for node in other.tree.nodes.into_values() {
            self.tree.insert(node);
        }
        let blocks = self.tree.blocks;
        let tree = core::mem::replace(&mut self.tree, MergeTree::new(blocks));
        let mut run_warnings = core::mem::take(&mut self.run_warnings);
        run_warnings.extend(other.run_warnings);
        *self = Self::new(self.info.clone(), tree);
        self.run_warnings = run_warnings;
        Ok(())
    }
}

/// Summaries are equal if settings, statistics, failures and final states are equal. Warnings about
/// files are not compared.
impl PartialEq for Summary {
    fn eq(&self, other: &Self) -> bool {
        self.info == other.info && self.tree == other.tree
    }
}

impl fmt::Debug for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Summary")
            .field("paths", &self.paths())
            .field("failed", &self.failed)
            .field("times", &self.info.times.len())
            .field("observables", &self.info.names)
            .finish_non_exhaustive()
    }
}

impl fmt::Display for Summary {
    /// A short table: each observable at the end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (paths, failed) = (self.paths(), self.failed);
        write!(f, "{paths} paths")?;
        if !self.is_complete() {
            write!(f, " of {}", self.info.paths)?;
        }
        if failed > 0 {
            write!(f, ", of which {failed} failed")?;
        }
        if let Some(t) = self.info.times.last() {
            write!(f, ", at t = {t}")?;
        }
        let width = self.info.names.iter().map(|n| n.chars().count()).max();
        let width = width.unwrap_or(0);
        for s in self.statistics() {
            write!(f, "\n  {:width$}  ", s.name())?;
            let last = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
            match self.counts.last() {
                None | Some(0) => write!(f, "no path is left")?,
                Some(1) => write!(f, "{:.6e}, of one path", last(s.mean()))?,
                Some(_) => write!(
                    f,
                    "{:.6e} ± {:.1e}, from {:.6e} to {:.6e}",
                    last(s.mean()),
                    last(&s.standard_error()),
                    last(s.min()),
                    last(s.max())
                )?,
            }
        }
        for passages in self.passages() {
            write!(f, "\n  {passages}")?;
        }
        for warning in self.warnings() {
            write!(f, "\n  {warning}")?;
        }
        if let Some(first) = self.failures.first() {
            write!(f, "\n  first failure: {first}")?;
        }
        Ok(())
    }
}
