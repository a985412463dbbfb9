//! Methods of any type as trait objects: the solution along a path, the number of iterations, and
//! times.
//!
//! Input: a start and the increments of a path. Each function of the trait loops over all steps, so
//! that measured times do not contain a virtual call in each step.

use core::hint::black_box;
use std::time::{Duration, Instant};

use crate::error::StepError;
use crate::fingerprint::StepsFingerprint;
use crate::method::OneStepMethod;
use crate::noise::{Recorded, draw};
use crate::system::{Increments, StateOf, System};
use crate::trajectory::Trajectory;

/// Number of steps whose Newton iterations are counted: they vary little along a path.
const COUNTED: usize = 256;

/// A function that is called with each state.
pub(super) type Visit<'a, S> = dyn FnMut(&StateOf<S>) -> Result<(), StepError> + 'a;

/// A [`OneStepMethod`] of any type.
pub(super) trait AnyMethod<S: System>: Sync {
    fn system(&self) -> &S;

    /// The name of the method with its options.
    fn describe(&self) -> String;
    /// The order of the method, if it is known.
    fn order(&self) -> Option<f64>;
    /// Identifies the method with its options, and the parameters of its system.
    fn identity(&self) -> StepsFingerprint;
    /// The increments of a process in a step.
    fn stages(&self) -> usize;

    /// Solves along the path, calls `visit` with each state and returns the last one.
    fn solve(
        &self,
        start: &StateOf<S>,
        path: &Recorded,
        visit: &mut Visit<'_, S>,
    ) -> Result<StateOf<S>, StepError>;

    /// Mean number of Newton iterations of a step along the path; `None` if the method does not
    /// count them.
    fn iterations(&self, start: &StateOf<S>, path: &Recorded) -> Option<f64>;

    /// Measures the time of `repeats` passes along a path whose increments are precomputed, each
    /// step with the numbers that a trajectory carries to it. Returns one duration for each section
    /// of so many steps of the path.
    fn measure(
        &self,
        start: &StateOf<S>,
        path: &Recorded,
        section: usize,
        repeats: u32,
    ) -> Result<Vec<Duration>, StepError>;
}

/// The increments over the first steps of a path.
fn increments<I: OneStepMethod<Increments: Increments>>(
    method: &I,
    path: &Recorded,
    steps: usize,
) -> Result<Vec<I::Increments>, StepError> {
    let of_step = |step: usize| {
        let mut dw = I::Increments::NONE;
        draw(
            &mut { path },
            step as u64,
            path.h(),
            method.stages(),
            dw.as_mut(),
        )
        .map_err(|source| StepError::Noise {
            t: step as f64 * path.h(),
            source,
        })?;
        Ok(dw)
    };
    (0..steps).map(of_step).collect()
}

impl<S: System, I: OneStepMethod<System = S, Increments: Increments> + Sync> AnyMethod<S> for I {
    fn system(&self) -> &S {
        OneStepMethod::system(self)
    }

    fn describe(&self) -> String {
        OneStepMethod::describe(self)
    }

    fn order(&self) -> Option<f64> {
        OneStepMethod::order(self)
    }
    fn identity(&self) -> StepsFingerprint {
        StepsFingerprint::of(self)
    }
    fn stages(&self) -> usize {
        OneStepMethod::stages(self)
    }

    fn solve(
        &self,
        start: &StateOf<S>,
        path: &Recorded,
        visit: &mut Visit<'_, S>,
    ) -> Result<StateOf<S>, StepError> {
        let mut trajectory = Trajectory::new(self, *start, path.h(), path);
        for state in trajectory.by_ref() {
            visit(&state?)?;
        }
        Ok(*trajectory.state())
    }

    fn iterations(&self, start: &StateOf<S>, path: &Recorded) -> Option<f64> {
        let h = path.h();
        let prepared = self.prepare(h).ok()?;
        let mut state = *start;
        let steps = path.len().min(COUNTED);
        let mut sum = 0.0;
        for dw in &increments(self, path, steps).ok()? {
            sum += f64::from(self.newton_iterations(&prepared, &state, h, dw)?);
            self.step_prepared(&prepared, &mut state, h, dw).ok()?;
        }
        Some(sum / steps as f64)
    }

    fn measure(
        &self,
        start: &StateOf<S>,
        path: &Recorded,
        section: usize,
        repeats: u32,
    ) -> Result<Vec<Duration>, StepError> {
        let h = path.h();
        let increments = increments(self, path, path.len())?;
        let sections: Vec<_> = increments.chunks(section).collect();
        let mut sums = vec![Duration::ZERO; sections.len()];
        let mut begin = Instant::now();
        for _ in 0..repeats {
            let mut prepared = self.prepare(black_box(h))?;
            let mut state = black_box(*start);
            for (sum, section) in sums.iter_mut().zip(&sections) {
                for dw in *section {
                    self.next_step(&mut prepared, &mut state, h, dw)?;
                }
                // by value: a state whose address is given away would be written to memory in each
                // step
                state = black_box(state);
                // reading the clock takes as long as a few steps
                if sections.len() > 1 {
                    let end = Instant::now();
                    *sum += end - begin;
                    begin = end;
                }
            }
        }
        if let [sum] = &mut sums[..] {
            *sum = begin.elapsed();
        }
        Ok(sums)
    }
}
