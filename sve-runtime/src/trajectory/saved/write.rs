//! Saved states as a table, and in files.

use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

use super::{Saved, Wanted};
use crate::method::OneStepMethod;
use crate::noise::Noise;
use crate::phase::configuration::Site;
use crate::system::{ConfigurationOf, MomentumOf, StateOf, System};
use crate::table::{SaveError, StateTable, Xyz};
use crate::trajectory::{StepKind, Trajectory};

#[cfg(feature = "npy")]
use crate::integrator::scenes::Scenes;
#[cfg(feature = "npy")]
use crate::system::{AnySystem, FixedSizes, Kind};
#[cfg(feature = "npy")]
use crate::table::frames_header;

impl<I, W, K> Saved<Trajectory<'_, I, W, K>>
where
    I: OneStepMethod<System: System>,
    W: Noise,
    K: StepKind<I, W>,
{
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
        self.check_end()?;
        let mut table = StateTable::new::<I::System>(false);
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

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Saved<Trajectory<'_, I, W, K>> {
    /// Makes the steps and writes the saved states as a structured array of `NumPy` into a file.
    ///
    /// For a system of fixed size, its fields are the columns of [`table`](Self::table); see
    /// [`StateTable::write_npy`]. For a scene they are `t`, `q` and `p`: of `frames` states with
    /// `n` sites, `numpy.load(path)["q"]` has the shape `(frames, n)`, or `(frames, n, D)` for
    /// sites of `D` > 1 numbers. Each state of a scene is written as it comes, and not kept.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Ring;
    ///
    /// #[variational(stormer_verlet)]
    /// impl Ring {
    ///     fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
    ///         let mut l = 0.0;
    ///         for i in 0..q.len() {
    ///             l += 0.5 * v[i] * v[i] - (1.0 - (q[(i + 1) % q.len()] - q[i]).cos());
    ///         }
    ///         l
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let ring = Integrator::new(Ring, StormerVerlet);
    /// let start = State::new(vec![0.0, 1.0, 0.0], vec![0.0; 3]);
    /// let path = std::env::temp_dir().join(format!("ring-{}.npy", std::process::id()));
    /// ring.trajectory(start, 0.1, NoNoise).every(2).until(1.0).to_npy(&path)?;
    /// // 6 frames of 7 numbers after the header
    /// assert_eq!(std::fs::read(&path)?.len() % 64, 6 * 7 * 8 % 64);
    /// # std::fs::remove_file(path)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`SaveError::NoEnd`] without [`at`](crate::Trajectory::at) or [`until`](Self::until); the
    /// error of a step; errors of the file, which is complete or not written at all.
    #[cfg(feature = "npy")]
    #[allow(private_bounds)] // the kinds of systems
    pub fn to_npy(self, path: impl AsRef<Path>) -> Result<(), SaveError>
    where
        <I::System as AnySystem>::Kind: WriteNpy<I::System>,
    {
        <I::System as AnySystem>::Kind::write_npy(self, path.as_ref())
    }

    /// Makes the steps and writes the saved states of bodies as frames in the extended XYZ format
    /// into a file. Each state is written as it comes, and not kept.
    ///
    /// Bodies are the entries of a configuration that is a vector or an array of them: numbers,
    /// arrays `[f64; D]` or vectors of nalgebra. `xyz` has their names and their box. Positions are
    /// those of the state, also outside of the box.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// Free bodies in a plane.
    /// struct Gas;
    ///
    /// #[variational(stormer_verlet)]
    /// impl Gas {
    ///     fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
    ///         (0..q.len()).map(|i| 0.5 * (v[i][0] * v[i][0] + v[i][1] * v[i][1])).sum()
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let gas = Integrator::new(Gas, StormerVerlet);
    /// let start = State::new(vec![[0.5, 0.5], [1.0, 2.0]], vec![[1.0, 0.0], [0.0, -1.0]]);
    /// let xyz = Xyz::new().species(["Ar"]).periodic([4.0, 4.0]);
    /// let path = std::env::temp_dir().join(format!("gas-{}.xyz", std::process::id()));
    /// gas.trajectory(start, 0.25, NoNoise).every(2).until(1.0).to_xyz(&path, &xyz)?;
    /// let text = std::fs::read_to_string(&path)?;
    /// assert!(text.ends_with("Time=1.0\nAr 1.5 0.5 0.0 1.0 0.0 0.0\nAr 1.0 1.0 0.0 0.0 -1.0 0.0\n"));
    /// # std::fs::remove_file(path)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`SaveError::NoEnd`] without [`at`](crate::Trajectory::at) or [`until`](Self::until); the
    /// error of a step; errors of the file, which is complete or not written at all, and of
    /// [`Xyz::write_frame`].
    pub fn to_xyz<B, const D: usize>(
        self,
        path: impl AsRef<Path>,
        xyz: &Xyz<D>,
    ) -> Result<(), SaveError>
    where
        ConfigurationOf<I::System>: AsRef<[B]>,
        MomentumOf<I::System>: AsRef<[B]>,
        B: Site<Row = [f64; D]>,
    {
        self.check_end()?;
        self.write_frames(path.as_ref(), &[], |file, state| {
            let (q, p) = (B::rows(state.q.as_ref()), B::rows(state.p.as_ref()));
            xyz.write_frame(file, state.t, q, p)
        })
    }

    /// Checks that there is a last state.
    fn check_end(&self) -> Result<(), SaveError> {
        match (&self.wanted, self.end) {
            (Wanted::Steps { .. }, None) => Err(SaveError::NoEnd),
            _ => Ok(()),
        }
    }

    /// Returns the number of states that will be written.
    #[cfg(feature = "npy")]
    fn frames(&mut self) -> Result<usize, SaveError> {
        self.count_states()?.ok_or(SaveError::NoEnd)
    }

    /// Makes the steps and writes a header and each saved state into a file.
    fn write_frames(
        self,
        path: &Path,
        header: &[u8],
        mut write: impl FnMut(&mut BufWriter<File>, &StateOf<I::System>) -> io::Result<()>,
    ) -> Result<(), SaveError> {
        let mut failed = None;
        let written = crate::file::write(path, |file| {
            file.write_all(header)?;
            for state in self {
                match state {
                    Ok(state) => write(file, &state)?,
                    Err(error) => {
                        failed = Some(error);
                        return Err(io::ErrorKind::Other.into());
                    }
                }
            }
            Ok(())
        });
        match failed {
            Some(error) => Err(error.into()),
            None => Ok(written?),
        }
    }
}

/// How the saved states of systems of a kind are written as an array of `NumPy`.
#[cfg(feature = "npy")]
pub(crate) trait WriteNpy<S: AnySystem>: Kind {
    /// Makes the steps and writes the saved states.
    ///
    /// # Errors
    /// As [`Saved::to_npy`].
    fn write_npy<I: OneStepMethod<System = S>, W: Noise, K: StepKind<I, W>>(
        saved: Saved<Trajectory<'_, I, W, K>>,
        path: &Path,
    ) -> Result<(), SaveError>;
}

#[cfg(feature = "npy")]
impl<S: System> WriteNpy<S> for FixedSizes {
    fn write_npy<I: OneStepMethod<System = S>, W: Noise, K: StepKind<I, W>>(
        saved: Saved<Trajectory<'_, I, W, K>>,
        path: &Path,
    ) -> Result<(), SaveError> {
        Ok(saved.table()?.to_npy(path)?)
    }
}

#[cfg(feature = "npy")]
impl<S: AnySystem<Configuration = Vec<Q>>, Q: Site> WriteNpy<S> for Scenes {
    fn write_npy<I: OneStepMethod<System = S>, W: Noise, K: StepKind<I, W>>(
        mut saved: Saved<Trajectory<'_, I, W, K>>,
        path: &Path,
    ) -> Result<(), SaveError> {
        let frames = saved.frames()?;
        let sites = saved.path.state.q.len();
        let header = frames_header(frames, sites, Q::NUMBERS);
        saved.write_frames(path, &header, |file, state| {
            file.write_all(&state.t.to_le_bytes())?;
            for sites in [&state.q, &state.p] {
                let mut numbers = Q::rows(sites).iter().flat_map(AsRef::as_ref);
                numbers.try_for_each(|x| file.write_all(&x.to_le_bytes()))?;
            }
            Ok(())
        })
    }
}
