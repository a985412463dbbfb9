//! Paths given as numbers.
//!
//! Input: a step size and the increments of every process over every step. Output: these
//! increments, or their sums over larger steps. Invariant: the step size is finite and not zero,
//! every increment is finite.

use super::{Noise, NoiseError, Replayable};
use crate::error::check_step;
use crate::gauss::stage_noise;

/// Largest relative difference between a step size and the recorded one: `k * h` and `T / n` have
/// one or two rounding errors each. Different step sizes differ by more.
const STEP_TOLERANCE: f64 = 4.0 * f64::EPSILON;

/// A recorded path: Wiener increments for steps of one size.
///
/// Coarsening gives the same Brownian path in larger steps. Strong errors are measured with it: the
/// solutions with `h` and with `k h` then have the same noise.
///
/// ```
/// use sve_runtime::noise::{Recorded, Wiener};
///
/// let fine = Recorded::record(Wiener::new(42), 0.01, 1, 100)?;
/// let coarse = fine.coarsen(10)?;
/// assert_eq!((coarse.len(), coarse.h()), (10, 0.1));
/// let sum: f64 = (0..10).filter_map(|step| fine.get(step)).map(|dw| dw[0]).sum();
/// assert_eq!(coarse.get(0), Some(&[sum][..]));
///
/// let measured = Recorded::new(0.5, [[0.3, -0.1], [0.0, 0.7]])?; // two steps, two processes
/// assert_eq!(measured.get(1), Some(&[0.0, 0.7][..]));
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
///
/// As [`Noise`], by value or by reference, it starts at step 0 and may be read in any order. Its
/// errors are [`NoiseError::Exhausted`] past the last step, which ends a trajectory,
/// [`NoiseError::StepSize`] for a step of another size (up to rounding), and
/// [`NoiseError::Processes`] for another number of processes.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    h: f64,
    processes: usize,
    /// Number of increments of a process in a step, one for each stage.
    stages: usize,
    steps: usize,
    /// The increments, step by step, process by process.
    increments: Vec<f64>,
}

impl Recorded {
    /// Returns a path with the given increments: an array for each step, an entry for each process.
    ///
    #[doc = include_str!("../example.md")]
    /// let path = Recorded::new(0.01, [[0.02], [-0.05]])?; // two steps of one process
    /// assert_eq!(pendulum.trajectory(start, 0.01, &path).count(), 2);
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// [`NoiseError::InvalidStep`] if `h` is zero or not finite; [`NoiseError::NonFinite`] for an
    /// increment that is NaN or infinite.
    pub fn new<const M: usize>(
        h: f64,
        increments: impl IntoIterator<Item = [f64; M]>,
    ) -> Result<Self, NoiseError> {
        let mut steps = 0;
        let flat = increments
            .into_iter()
            .inspect(|_| steps += 1)
            .flatten()
            .collect();
        Self::checked(h, [M, 1, steps], flat)
    }

    /// Records the first `steps` steps of length `h` of another source.
    ///
    #[doc = include_str!("../example.md")]
    /// let path = Recorded::record(Wiener::new(42), 0.01, 1, 100)?;
    /// assert_eq!((path.len(), path.processes()), (100, 1));
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// The errors of the source and of [`new`](Self::new), and [`NoiseError::TooLong`] if the path
    /// does not fit into memory.
    pub fn record(
        mut noise: impl Noise,
        h: f64,
        processes: usize,
        steps: usize,
    ) -> Result<Self, NoiseError> {
        Self::record_rows(h, [processes, 1, steps], |step, dw| {
            noise.increments(step, h, dw)
        })
    }

    /// Records the first `steps` steps of length `h` of another source, for rules with [stage
    /// noise](crate::StageNoise) of so many stages. Rules with fewer stages, and rules with one
    /// increment for each process, take the path too.
    ///
    #[doc = include_str!("../example.md")]
    /// let path = Recorded::record_stages(Wiener::new(42), 0.01, 1, 2, 100)?;
    /// let gauss = Integrator::new(&system, StageNoise(Gauss::<2>));
    /// assert_eq!(gauss.trajectory(start, 0.01, &path).count(), 100);
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// As [`record`](Self::record); [`NoiseError::NoStages`] if the source has no increments for so
    /// many stages.
    pub fn record_stages(
        mut noise: impl Noise,
        h: f64,
        processes: usize,
        stages: usize,
        steps: usize,
    ) -> Result<Self, NoiseError> {
        if stage_noise::weights(stages).is_none() {
            return Err(NoiseError::NoStages { stages });
        }
        Self::record_rows(h, [processes, stages, steps], |step, dw| {
            noise.stage_increments(step, h, stages, dw)
        })
    }

    /// Records rows of so many processes and stages, for so many steps.
    fn record_rows(
        h: f64,
        [processes, stages, steps]: [usize; 3],
        mut draw: impl FnMut(u64, &mut [f64]) -> Result<(), NoiseError>,
    ) -> Result<Self, NoiseError> {
        check_step(h)?;
        let too_long = NoiseError::TooLong {
            steps: steps as u64,
            processes,
        };
        let mut increments = Vec::new();
        let row = processes * stages;
        let Some(length) = steps.checked_mul(row) else {
            return Err(too_long);
        };
        if increments.try_reserve_exact(length).is_err() {
            return Err(too_long);
        }
        increments.resize(length, 0.0);
        for step in 0..steps {
            draw(step as u64, &mut increments[step * row..][..row])?;
        }
        Self::checked(h, [processes, stages, steps], increments)
    }

    /// Returns the path whose rows contain the increments of so many stages, process by process,
    /// with nodes ascending.
    ///
    #[doc = include_str!("../example.md")]
    /// // one process with two stages
    /// let path = Recorded::new(0.01, [[0.01, -0.02], [0.03, 0.0]])?.with_stages(2)?;
    /// assert_eq!((path.processes(), path.stages()), (1, 2));
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// [`NoiseError::NoStages`] for a number that no rule has; [`NoiseError::Stages`] if the rows
    /// cannot be divided into so many stages.
    pub fn with_stages(self, stages: usize) -> Result<Self, NoiseError> {
        let row = self.row();
        if stage_noise::weights(stages).is_none() {
            return Err(NoiseError::NoStages { stages });
        }
        if !row.is_multiple_of(stages) {
            return Err(NoiseError::Stages {
                asked: stages,
                recorded: row,
            });
        }
        let processes = row / stages;
        Ok(Self {
            processes,
            stages,
            ..self
        })
    }

    /// Returns the number of increments of a step.
    fn row(&self) -> usize {
        self.processes * self.stages
    }

    /// Returns the same path with larger steps: the increments of each `k` steps are summed, the
    /// step size is `k h`. The increments of stages become, exactly, the increments of the stages
    /// of the larger step.
    ///
    #[doc = include_str!("../example.md")]
    /// let fine = Recorded::record(Wiener::new(42), 0.01, 1, 100)?;
    /// let coarse = fine.coarsen(2)?;
    /// let paths = [(&fine, 0.01), (&coarse, 0.02)];
    /// let [a, b] = paths.map(|(path, h)| pendulum.trajectory(start, h, path).last());
    /// let difference = a.expect("steps")?.q[0] - b.expect("steps")?.q[0];
    /// assert!(difference.abs() < 1e-3); // the same path in larger steps
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// [`NoiseError::Coarsen`] unless `k` divides the number of steps.
    pub fn coarsen(&self, k: usize) -> Result<Self, NoiseError> {
        if k == 0 || !self.steps.is_multiple_of(k) {
            return Err(NoiseError::Coarsen {
                recorded: self.steps as u64,
                factor: k as u64,
            });
        }
        let steps = self.steps / k;
        let mut sums = vec![0.0; steps * self.row()];
        for step in 0..self.steps {
            for process in 0..self.processes {
                let at = |step: usize| (step * self.processes + process) * self.stages;
                let parts = &self.increments[at(step)..][..self.stages];
                let longer = &mut sums[at(step / k)..][..self.stages];
                stage_noise::add_to_longer_step(parts, [step % k, k], longer);
            }
        }
        let sizes = [self.processes, self.stages, steps];
        Self::checked(k as f64 * self.h, sizes, sums)
    }

    /// Returns the number of steps.
    pub fn len(&self) -> usize {
        self.steps
    }

    /// Returns whether the path has no step.
    pub fn is_empty(&self) -> bool {
        self.steps == 0
    }

    /// Returns the step size.
    pub fn h(&self) -> f64 {
        self.h
    }

    /// Returns the number of Wiener processes.
    pub fn processes(&self) -> usize {
        self.processes
    }

    /// Returns the number of stages; 1 for a path with one increment for each process.
    pub fn stages(&self) -> usize {
        self.stages
    }

    /// Returns the increments over a step (from 0), one for each process and stage; `None` past the
    /// last step.
    #[inline]
    pub fn get(&self, step: usize) -> Option<&[f64]> {
        // the comparison keeps the products in range
        (step < self.steps).then(|| &self.increments[step * self.row()..][..self.row()])
    }

    fn checked(
        h: f64,
        [processes, stages, steps]: [usize; 3],
        increments: Vec<f64>,
    ) -> Result<Self, NoiseError> {
        check_step(h)?;
        match increments.iter().position(|dw| !dw.is_finite()) {
            Some(at) => Err(NoiseError::NonFinite {
                step: (at / (processes * stages)) as u64,
                process: at / stages % processes,
                value: increments[at],
            }),
            None => Ok(Self {
                h,
                processes,
                stages,
                steps,
                increments,
            }),
        }
    }
}

impl Recorded {
    /// Returns the row of a step, after checking the number of processes and the step size.
    #[inline]
    fn checked_row(&self, step: u64, h: f64, asked: usize) -> Result<&[f64], NoiseError> {
        if asked != self.processes {
            return Err(NoiseError::Processes {
                asked,
                recorded: self.processes,
            });
        }
        // a NaN fails as well
        if (h.abs() - self.h.abs()).abs() <= STEP_TOLERANCE * self.h.abs() {
            let recorded = usize::try_from(step).ok().and_then(|step| self.get(step));
            recorded.ok_or(NoiseError::Exhausted {
                step,
                recorded: self.steps as u64,
            })
        } else {
            Err(NoiseError::StepSize {
                h,
                recorded: self.h,
            })
        }
    }
}

impl Noise for &Recorded {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        let row = self.checked_row(step, h, dw.len())?;
        if self.stages == 1 {
            dw.copy_from_slice(row);
            return Ok(());
        }
        for (dw, parts) in dw.iter_mut().zip(row.chunks_exact(self.stages)) {
            *dw = parts.iter().sum();
        }
        Ok(())
    }

    #[inline]
    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        if stages > self.stages {
            return Err(NoiseError::Stages {
                asked: stages,
                recorded: self.stages,
            });
        }
        let row = self.checked_row(step, h, dw.len() / stages)?;
        if stages == self.stages {
            dw.copy_from_slice(row);
            return Ok(());
        }
        dw.fill(0.0);
        let processes = row
            .chunks_exact(self.stages)
            .zip(dw.chunks_exact_mut(stages));
        for (parts, fewer) in processes {
            stage_noise::add_to_longer_step(parts, [0, 1], fewer);
        }
        Ok(())
    }

    fn is_replayable(&self) -> bool {
        true
    }
}

impl Replayable for Recorded {}
impl Replayable for &Recorded {}

impl Noise for Recorded {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        (&*self).increments(step, h, dw)
    }

    #[inline]
    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        (&*self).stage_increments(step, h, stages, dw)
    }

    fn is_replayable(&self) -> bool {
        true
    }
}
