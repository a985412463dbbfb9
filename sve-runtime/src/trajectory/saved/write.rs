//! Saved states as a table, and in files.

use std::path::Path;

use super::search::Steps;
use super::{Saved, Wanted};
use crate::system::System;
use crate::table::{SaveError, StateTable};

#[allow(private_bounds)] // trajectories, plain and refined
impl<T: Steps<System: System>> Saved<T> {
    /// Makes the steps and returns the saved states as a table, to which columns can be
    /// [added](StateTable::with).
    ///
    #[doc = include_str!("../../example.md")]
    /// let table = pendulum.trajectory(start, 0.1, NoNoise).every(2).until(1.0).table()?;
    /// assert_eq!(table.get("t").unwrap(), [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    #[doc = include_str!("../../example_end.md")]
    ///
    /// # Errors
    /// [`SaveError::NoEnd`] without [`at`](crate::Trajectory::at) or [`until`](Self::until); the
    /// error of a step.
    pub fn table(mut self) -> Result<StateTable, SaveError> {
        if matches!(self.wanted, Wanted::Steps { .. }) && self.end.is_none() {
            return Err(SaveError::NoEnd);
        }
        let mut table = StateTable::new::<T::System>(false);
        for state in &mut self {
            table.push(None, &state?);
        }
        Ok(table)
    }

    /// Makes the steps and writes the saved states as CSV into a file: a line of names, then one
    /// line for each state.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Pendulum { g: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, theta: f64, omega: f64) -> f64 {
    ///         0.5 * omega * omega + self.g * theta.cos()
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    /// let start = State::from_velocity(pendulum.system(), [0.0], [1.0])?;
    /// let path = std::env::temp_dir().join(format!("pendulum-{}.csv", std::process::id()));
    /// pendulum.trajectory(start, 0.01, NoNoise).every(10).until(0.5).to_csv(&path)?;
    /// let text = std::fs::read_to_string(&path)?;
    /// assert!(text.starts_with("t,theta,p_theta\n0.0,0.0,1.0\n0.1,"));
    /// # std::fs::remove_file(path)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`table`](Self::table), and errors of the file, which is complete or not written at all.
    pub fn to_csv(self, path: impl AsRef<Path>) -> Result<(), SaveError> {
        Ok(self.table()?.to_csv(path)?)
    }

    /// Makes the steps and writes the saved states as a structured array of `NumPy` into a file;
    /// see [`StateTable::write_npy`].
    ///
    #[doc = include_str!("../../example.md")]
    /// let path = std::env::temp_dir().join(format!("saved-{}.npy", std::process::id()));
    /// pendulum.trajectory(start, 0.1, NoNoise).every(2).until(1.0).to_npy(&path)?;
    /// assert!(std::fs::read(&path)?.starts_with(b"\x93NUMPY"));
    /// # std::fs::remove_file(path)?;
    #[doc = include_str!("../../example_end.md")]
    ///
    /// # Errors
    /// As [`to_csv`](Self::to_csv).
    #[cfg(feature = "npy")]
    pub fn to_npy(self, path: impl AsRef<Path>) -> Result<(), SaveError> {
        Ok(self.table()?.to_npy(path)?)
    }

    /// Makes the steps and writes the saved states as Parquet into a file; see
    /// [`StateTable::write_parquet`].
    ///
    #[doc = include_str!("../../example.md")]
    /// let path = std::env::temp_dir().join(format!("saved-{}.parquet", std::process::id()));
    /// pendulum.trajectory(start, 0.1, NoNoise).every(2).until(1.0).to_parquet(&path)?;
    /// assert!(std::fs::read(&path)?.starts_with(b"PAR1"));
    /// # std::fs::remove_file(path)?;
    #[doc = include_str!("../../example_end.md")]
    ///
    /// # Errors
    /// As [`to_csv`](Self::to_csv).
    #[cfg(feature = "parquet")]
    pub fn to_parquet(self, path: impl AsRef<Path>) -> Result<(), SaveError> {
        Ok(self.table()?.to_parquet(path)?)
    }
}
