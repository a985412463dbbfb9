//! Sweeps: an ensemble for each row of a table of methods or starts, in one run with common noise.
//!
//! Input: an ensemble and a table. Output: a summary for each row, and the statistics of the
//! differences of each two rows along common paths. Invariant: the summary of a row has the bits of
//! the ensemble with this method and start.

use core::ops::Index;

use super::coupled::{Coupled, difference_number};
use super::settings::{Leg, Settings};
use super::starts::Start;
use super::{Ensemble, EnsembleError, Summary, sizes};
use crate::ensemble::PathMethod;
use crate::phase::configuration::FixedSize;
use crate::phase::state::State;
use crate::system::{Dimensions, StateOf, System};

/// A row of the table of a [sweep](Ensemble::sweep): a method, or a start.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no row of a sweep",
    note = "the rows are methods of the type of the ensemble's own, or states of its system"
)]
pub trait SweepRow<I: PathMethod> {
    /// Returns the method that takes the place of the ensemble's own.
    #[doc(hidden)]
    fn method(&self) -> Option<&I> {
        None
    }

    /// Returns the state that takes the place of the ensemble's own starts.
    #[doc(hidden)]
    fn start(&self) -> Option<StateOf<I::System>> {
        None
    }
}

impl<I: PathMethod> SweepRow<I> for I {
    fn method(&self) -> Option<&I> {
        Some(self)
    }
}

impl<I, Q> SweepRow<I> for State<Q>
where
    I: PathMethod<System: System<Dims: Dimensions<Configuration = Q>>>,
    Q: FixedSize,
{
    fn start(&self) -> Option<Self> {
        Some(*self)
    }
}

impl<I: PathMethod + Sync> Ensemble<'_, I> {
    /// Runs all paths for each row of a table: with each of several methods, which are systems with
    /// different parameters, or from each of several starts. A row takes the place of the
    /// ensemble's own method or [`start`](Self::start). Path k has the same noise in all rows.
    ///
    /// With common noise the difference of two rows has a far smaller statistical error than each
    /// of them: the sweep takes the differences path by path, with their standard errors.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator { k: f64, sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * self.k * q * q }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let systems = [1.0, 1.01, 1.1].map(|k| Oscillator { k, sigma: 1.0 });
    /// let table = systems.map(|system| Integrator::new(system, Midpoint));
    /// let sweep = Ensemble::new(&table[0])
    ///     .paths(1000).seed(1)
    ///     .steps(0.05, 20)
    ///     .start(State::new([1.0], [0.0]))
    ///     .observe("q", |_, state| state.q[0])
    ///     .sweep(&table)?;
    /// for (integrator, row) in table.iter().zip(sweep.rows()) {
    ///     println!("{} {}", integrator.system().k, row["q"].mean()[1]);
    /// }
    /// let difference = &sweep.difference(0, 1).expect("two rows")["q"]; // of k = 1.01 and 1
    /// let (mean, error) = (difference.mean()[1], difference.standard_error()[1]);
    /// assert!((mean + 0.0042).abs() < 4.0 * error + 1e-5);
    /// assert!(difference.standard_error()[1] < 0.01 * sweep[0]["q"].standard_error()[1]);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// The differences of all pairs of rows are kept, so the memory grows with the square of the
    /// number of rows. If no differences are needed, [`run`](Self::run) each start alone: runs with
    /// one seed have common noise, and with `.noise(Wiener::new(seed).path(k * paths))` row k has
    /// separate paths.
    ///
    /// # Errors
    /// As [`run`](Self::run); [`EnsembleError::EmptyTable`]; [`EnsembleError::SweepInOneFile`] with
    /// a checkpoint; [`EnsembleError::SweepTimes`] unless all starts have one time.
    pub fn sweep<T: SweepRow<I>>(&self, table: &[T]) -> Result<Sweep, EnsembleError> {
        let starts: Vec<_> = (table.iter())
            .map(|row| row.start().map(Start::Same))
            .collect();
        let legs = table.iter().zip(&starts).map(|(row, start)| {
            let own = Leg::of(self);
            Leg {
                method: row.method().unwrap_or(own.method),
                start: start.as_ref().or(own.start),
                ..own
            }
        });
        self.run_legs(&legs.collect::<Vec<_>>())
    }

    fn run_legs<'b>(&'b self, legs: &[Leg<'b, I>]) -> Result<Sweep, EnsembleError> {
        #[cfg(feature = "checkpoint")]
        if self.execution.checkpoint.is_some() {
            return Err(EnsembleError::SweepInOneFile);
        }
        let legs = legs.iter().map(|leg| Settings::of_leg(self, leg));
        let coupled = Coupled {
            legs: legs.collect::<Result<Vec<_>, _>>()?,
        };
        let Some(first) = coupled.legs.first() else {
            return Err(EnsembleError::EmptyTable);
        };
        let mut starts = coupled.legs.iter().map(|leg| leg.start_time).enumerate();
        if let Some((row, t)) = starts.find(|(_, t)| *t != first.start_time) {
            let first = first.start_time;
            return Err(EnsembleError::SweepTimes { row, t, first });
        }
        sizes::differences(self, first.records, coupled.differences())?;
        let rows = coupled.legs.len();
        let mut trees = first
            .execute_with(rows + coupled.differences(), |block| {
                coupled.run_block(block)
            })?
            .into_iter();
        let infos: Vec<_> = (coupled.legs.iter())
            .map(|leg| leg.info(leg.fingerprint()))
            .collect();
        let own = infos.iter().zip(trees.by_ref());
        let rows = own
            .map(|(info, tree)| Summary::new(info.clone(), tree))
            .collect();
        let of = infos.iter().enumerate().flat_map(|(to, info)| {
            let fingerprint = &info.fingerprint;
            let coupled = &coupled;
            (0..to).map(move |_| coupled.info_of_differences(to, fingerprint.clone()))
        });
        let differences = of.zip(trees).map(|(info, tree)| Summary::new(info, tree));
        Ok(Sweep {
            rows,
            differences: differences.collect(),
        })
    }
}

/// The summaries of the rows of a table, and of their differences. From [`Ensemble::sweep`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sweep {
    rows: Vec<Summary>,
    /// The differences of rows, by the number of the later row, then by the number of the earlier
    /// one.
    differences: Vec<Summary>,
}

impl Sweep {
    /// The summaries of the rows, in the order of the table. Each has the bits of the ensemble run
    /// alone with this method or start.
    pub fn rows(&self) -> &[Summary] {
        &self.rows
    }

    /// Returns the statistics of the differences of the observables, row `to` less row `from`, over
    /// the paths that have failed in neither; `None` unless `from` is before `to` and both are
    /// rows.
    ///
    /// Its standard errors are the errors of differences along common paths.
    pub fn difference(&self, from: usize, to: usize) -> Option<&Summary> {
        let is_pair = from < to && to < self.rows.len();
        is_pair
            .then(|| self.differences.get(difference_number(from, to)))
            .flatten()
    }

    /// Adds the paths of another [shard](Ensemble::shard) of the same sweep.
    ///
    /// # Errors
    /// As [`Summary::merge`]; [`EnsembleError::OtherTable`] if the other sweep has another number
    /// of rows. Nothing is merged then.
    pub fn merge(&mut self, other: Self) -> Result<(), EnsembleError> {
        let (rows, others) = (self.rows.len(), other.rows.len());
        if rows != others || self.differences.len() != other.differences.len() {
            return Err(EnsembleError::OtherTable { rows, others });
        }
        let mut merged = self.clone();
        let own = merged.rows.iter_mut().chain(&mut merged.differences);
        for (own, other) in own.zip(other.rows.into_iter().chain(other.differences)) {
            own.merge(other)?;
        }
        *self = merged;
        Ok(())
    }
}

impl Index<usize> for Sweep {
    type Output = Summary;

    /// The summary of a row.
    ///
    /// # Panics
    /// If there is no row of this number.
    fn index(&self, row: usize) -> &Summary {
        &self.rows[row]
    }
}
