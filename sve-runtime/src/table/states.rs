//! States as a table: a row for each state, a column for each coordinate and momentum.
//!
//! Input: states of a system. Output: columns with the names that the Lagrangian gives the
//! coordinates. Invariant: numbers keep their bits.

use std::io;

use super::{Table, Values, table_writers};
use crate::error::StepError;
use crate::error::observed::Observed;
use crate::phase::configuration::{Configuration, FixedSize};
use crate::phase::state::State;
use crate::readable::debug_is_display;
use crate::system::{ConfigurationOf, MomentumOf, StateOf, System};

/// States as a table, to be written as CSV, as an array of `NumPy` (feature `npy`), or as Parquet
/// (feature `parquet`).
///
/// Its columns are the time `t`, the coordinates and the momenta, with the names that the
/// Lagrangian gives them: [`System::COORDINATES`] and [`System::MOMENTA`].
/// [`table`](crate::Saved::table) makes a table of [saved](crate::Saved) states; `of` takes any
/// states.
///
/// ```
/// use sve_runtime::StateTable;
/// use sve_runtime::prelude::*;
///
/// struct HenonHeiles;
///
/// #[variational(midpoint)]
/// impl HenonHeiles {
///     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
///         let [x, y] = q;
///         0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y * y * y / 3.0
///     }
/// }
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let motion = Integrator::new(HenonHeiles, Midpoint);
/// let path = motion.trajectory(State::new([0.0, 0.1], [0.4, 0.0]), 0.1, NoNoise);
/// let table = StateTable::of(motion.system(), path.take(20))?
///     .with(motion.system(), "energy", |system, state| system.hamiltonian(state))?;
/// assert_eq!(table.names().collect::<Vec<_>>(), ["t", "x", "y", "p_x", "p_y", "energy"]);
/// assert_eq!(table.rows(), 20);
/// let mut text = Vec::new();
/// table.write_csv(&mut text)?; // or `to_csv` with a path
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct StateTable {
    /// Numbers of the paths, if the states belong to several paths.
    paths: Option<Vec<u64>>,
    columns: Vec<(String, Vec<f64>)>,
}

/// The reason why saved states could not be made into a table, or written.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum SaveError {
    /// The trajectory has no end.
    #[error(
        "a trajectory without an end has no table of its states: add `.until(t)`, or make a table of some of them with `StateTable::of(&system, path.take(1000))`"
    )]
    NoEnd,
    /// A step failed.
    #[error("{0}")]
    Step(#[from] StepError),
    /// The file could not be written.
    #[error("{0}")]
    File(#[from] io::Error),
}

debug_is_display!(SaveError);

impl StateTable {
    /// Returns an empty table of states of a system. A table of several paths has a column `path`.
    pub(crate) fn new<S: System + ?Sized>(has_paths: bool) -> Self {
        let names = [(S::COORDINATES, "q"), (S::MOMENTA, "p")];
        let sizes = [
            ConfigurationOf::<S>::STORED_VALUES,
            ConfigurationOf::<S>::DEGREES_OF_FREEDOM,
        ];
        let mut columns = vec![("t".to_owned(), Vec::new())];
        for ((names, letter), size) in names.into_iter().zip(sizes) {
            for i in 0..size {
                // A system that was not written with the attribute may have no names.
                let name = names
                    .get(i)
                    .map_or_else(|| format!("{letter}[{i}]"), |&name| name.to_owned());
                columns.push((name, Vec::new()));
            }
        }
        Self {
            paths: has_paths.then(Vec::new),
            columns,
        }
    }

    /// Returns a table of the states in their order.
    ///
    /// # Errors
    /// The first error among the states.
    pub fn of<S: System + ?Sized>(
        system: &S,
        states: impl IntoIterator<Item = Result<StateOf<S>, StepError>>,
    ) -> Result<Self, StepError> {
        let _ = system;
        let mut table = Self::new::<S>(false);
        for state in states {
            table.push(None, &state?);
        }
        Ok(table)
    }

    /// Adds a row.
    pub(crate) fn push<Q: FixedSize>(&mut self, path: Option<u64>, state: &State<Q>) {
        self.push_values(path, state.t, &state.stored().concat());
    }

    /// Adds a row of the time, the stored values and the momenta.
    pub(crate) fn push_values(&mut self, path: Option<u64>, t: f64, values: &[f64]) {
        if let (Some(paths), Some(path)) = (&mut self.paths, path) {
            paths.push(path);
        }
        for ((_, column), value) in self.columns.iter_mut().zip([t].iter().chain(values)) {
            column.push(*value);
        }
    }

    /// Adds a column of values of a function of the system and a state: an energy, a distance.
    ///
    /// # Errors
    /// The first error of the function.
    ///
    /// # Panics
    /// If the states belong to a system with other coordinates, or there is a column of this name.
    pub fn with<S: System, O: Observed>(
        mut self,
        system: &S,
        name: impl Into<String>,
        function: impl Fn(&S, &StateOf<S>) -> O,
    ) -> Result<Self, StepError> {
        let empty = Self::new::<S>(false);
        let names = empty.names().zip(self.columns.iter());
        let is_of_system = self.columns.len() >= empty.columns.len();
        assert!(
            is_of_system && names.into_iter().all(|(name, column)| name == column.0),
            "these are states of another system"
        );
        let values = (0..self.rows())
            .map(|row| function(system, &self.state::<S>(row)).observed())
            .collect::<Result<_, _>>()?;
        let name = name.into();
        let is_new = name != "path" && self.get(&name).is_none();
        assert!(
            is_new,
            "there is a column `{name}` already: give the values another name"
        );
        self.columns.push((name, values));
        Ok(self)
    }

    /// Returns the state of a row.
    fn state<S: System>(&self, row: usize) -> StateOf<S> {
        let values: Vec<f64> = self.columns.iter().map(|(_, column)| column[row]).collect();
        let (q, p) = (
            ConfigurationOf::<S>::origin(),
            ConfigurationOf::<S>::no_momentum(),
        );
        let mut state = State::at(values[0], q, p);
        let q = 1..1 + ConfigurationOf::<S>::STORED_VALUES;
        let p = q.end..q.end + ConfigurationOf::<S>::DEGREES_OF_FREEDOM;
        state.q.restore(&values[q]);
        MomentumOf::<S>::restore(&mut state.p, &values[p]);
        state
    }

    /// Returns the number of states.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.len())
    }

    /// Returns the names of the columns of numbers.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|(name, _)| name.as_str())
    }

    /// Returns the values of a column; `None` if there is no column of this name.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        let mut columns = self.columns.iter();
        columns.find_map(|(known, column)| (known == name).then_some(column.as_slice()))
    }

    /// Returns the numbers of the paths, if the states belong to an ensemble.
    pub fn paths(&self) -> Option<&[u64]> {
        self.paths.as_deref()
    }

    fn table(&self) -> Table {
        let paths = self.paths.iter();
        let paths = paths.map(|paths| ("path".to_owned(), Values::Counts(paths.clone())));
        let numbers = self.columns.iter();
        let numbers = numbers.map(|(name, column)| (name.clone(), Values::Numbers(column.clone())));
        Table {
            name: "states",
            columns: paths.chain(numbers).collect(),
        }
    }
}

table_writers!(
    StateTable,
    "the states, a row for each with its time, coordinates and momenta, and those of an ensemble with the number of the path first,"
);
