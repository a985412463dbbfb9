//! The instances of a loop, cut into runs in which every index advances by one.
//!
//! The indices of a loop are executed once, when the scene is first stepped or has changed. A run
//! needs as much memory as one instance, so a long loop of a few runs costs nothing to keep.

use super::{IndexError, Instance, Stop, Term};

/// Mean length of runs from which slices are faster than the loop as it is written.
const LONG: usize = 8;

/// Instances of a term beyond which a loop is not a loop over neighbours: `MOST n + FEW`.
const MOST: usize = 4;
const FEW: usize = 64;

/// The runs of a term.
#[derive(Clone, Debug)]
pub(super) struct Runs {
    term: &'static Term,
    /// The indices of the first instance of each run: of its slots, then of its increment.
    first: Vec<u32>,
    /// The number of instances up to and with each run.
    ends: Vec<u32>,
    /// The values of each column, in the order of the instances.
    pub(super) columns: Vec<Vec<f64>>,
}

/// A run, as one of its indices sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// Value of the index in the first instance.
    pub(super) start: u32,
    /// Number of instances.
    length: u32,
    /// Number of the run in its term.
    pub(super) number: usize,
    /// Number of the first instance in its term.
    pub(super) instance: u32,
}

impl Run {
    /// Returns the value of the index after the last instance.
    pub(super) fn end(&self) -> u32 {
        self.start + self.length
    }
}

impl Runs {
    fn new(term: &'static Term) -> Self {
        let columns = vec![Vec::new(); term.columns];
        let (first, ends) = (Vec::new(), Vec::new());
        Self {
            term,
            first,
            ends,
            columns,
        }
    }

    /// Returns the number of indices of an instance.
    fn width(&self) -> usize {
        self.term.slots.len() + usize::from(self.term.has_increment)
    }

    /// Returns the number of instances.
    pub(super) fn instances(&self) -> usize {
        self.ends.last().map_or(0, |&end| end as usize)
    }

    /// Returns the number of runs.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns an index of the first instance of a run; the increment is the last one.
    pub(super) fn first(&self, run: usize, index: usize) -> u32 {
        self.first[run * self.width() + index]
    }

    /// Returns the runs in the order of one of their indices.
    pub(super) fn by_index(&self, index: usize) -> Vec<Run> {
        let mut runs = Vec::with_capacity(self.len());
        let mut instance = 0;
        for (number, &end) in self.ends.iter().enumerate() {
            runs.push(Run {
                start: self.first(number, index),
                length: end - instance,
                number,
                instance,
            });
            instance = end;
        }
        runs.sort_unstable_by_key(|run| run.start);
        runs
    }
}

/// The instances of the loops, as they are visited.
#[derive(Debug)]
pub struct Instances {
    n: usize,
    /// For each term.
    pub(super) runs: Vec<Runs>,
}

impl Instances {
    /// Returns no instances of each of the terms, for `n` sites.
    pub(super) fn new(n: usize, terms: &'static [Term]) -> Self {
        let runs = terms.iter().map(Runs::new).collect();
        Self { n, runs }
    }

    /// Adds an instance of a term: the indices of its slots, the values of its columns, and the
    /// number of its increment among all increments of a step (0 for a term without one).
    ///
    /// # Errors
    /// A slot that is out of range; the end of a visit that finds no long runs.
    #[inline]
    pub fn instance(
        &mut self,
        term: usize,
        slots: &[i64],
        columns: &[f64],
        increment: usize,
    ) -> Result<(), Stop> {
        let Self { n, runs } = self;
        let runs = &mut runs[term];
        let count = runs.instances();
        let length = match *runs.ends {
            [] => 0,
            [end] => end,
            [.., before, end] => end - before,
        };
        let width = runs.width();
        let last = &runs.first[runs.first.len().saturating_sub(width)..];
        let mut goes_on = length > 0;
        for (number, &slot) in slots.iter().enumerate() {
            if !usize::try_from(slot).is_ok_and(|slot| slot < *n) {
                return Err(Stop::Index(IndexError {
                    text: runs.term.slots[number],
                    index: slot,
                    length: *n,
                    instance: Instance::default(),
                }));
            }
            goes_on = goes_on && i64::from(last[number]) + i64::from(length) == slot;
        }
        if runs.term.has_increment {
            let Ok(increment) = u32::try_from(increment) else {
                return Err(Stop::AsWritten);
            };
            goes_on = goes_on && last[width - 1] + length == increment;
        }
        if count >= MOST * *n + FEW || runs.len() > MOST * *n / LONG + FEW {
            return Err(Stop::AsWritten);
        }
        #[allow(clippy::cast_sign_loss)] // each slot is in range
        if goes_on {
            if let Some(end) = runs.ends.last_mut() {
                *end += 1;
            }
        } else {
            runs.first.extend(slots.iter().map(|&slot| slot as u32));
            if runs.term.has_increment {
                runs.first.push(increment as u32);
            }
            runs.ends.push(count as u32 + 1);
        }
        for (column, &value) in runs.columns.iter_mut().zip(columns) {
            column.push(value);
        }
        Ok(())
    }

    /// Returns whether the runs of each term of a loop are long on average, or few.
    pub(super) fn are_long(&self, number: usize) -> bool {
        let mut of_loop = (self.runs.iter()).filter(|runs| runs.term.in_loop == number);
        of_loop.all(|runs| LONG * runs.len() <= runs.instances() + FEW)
    }

    /// Forgets the instances of a loop.
    pub(super) fn forget(&mut self, number: usize) {
        for runs in &mut self.runs {
            if runs.term.in_loop == number {
                *runs = Runs::new(runs.term);
            }
        }
    }
}
