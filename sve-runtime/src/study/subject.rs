//! A method, whatever its type: walked along a path, asked for its iterations, timed.
//!
//! Input: a start and the increments of a path. The loop over the steps is compiled with the method in it, so that a time is that of the
//! step and not of a call through a table.

use core::hint::black_box;
use std::time::{Duration, Instant};

use crate::ensemble::fingerprint;
use crate::error::StepError;
use crate::method::Method;
use crate::noise::Recorded;
use crate::system::{Dimensions, IncrementsOf, StateOf, System};

/// Steps of which the Newton iterations are counted: they vary little along a path.
const COUNTED: usize = 256;

/// Called with each state.
pub(super) type Visit<'a, S> = dyn FnMut(&StateOf<S>) -> Result<(), StepError> + 'a;

/// A [`Method`] of any type.
pub(super) trait Subject<S: System>: Sync {
    fn system(&self) -> &S;

    /// The order that the method has, where it tells.
    fn order(&self) -> Option<f64>;
    /// What tells this method, its options and the parameters of its system from others.
    fn identity(&self) -> [u64; 2];

    /// The state at the end of the path, after a visit of each.
    fn walk(
        &self,
        start: &StateOf<S>,
        path: &Recorded,
        visit: &mut Visit<'_, S>,
    ) -> Result<StateOf<S>, StepError>;

    /// Mean number of Newton iterations of a step along the path; `None` where the method does not tell.
    fn iterations(&self, start: &StateOf<S>, path: &Recorded) -> Option<f64>;

    /// Times to walk the path so many times, its increments at hand: one for each of its parts.
    fn clock(
        &self,
        start: &StateOf<S>,
        h: f64,
        parts: &[&[IncrementsOf<S>]],
        times: u32,
    ) -> Result<Vec<Duration>, StepError>;
}

/// The increments over a step.
pub(super) fn increments<S: System>(path: &Recorded, step: usize) -> IncrementsOf<S> {
    let mut dw = <S::Dims as Dimensions>::NO_INCREMENTS;
    if let Some(recorded) = path.get(step) {
        dw.as_mut().copy_from_slice(recorded);
    }
    dw
}

impl<S: System, I: Method<System = S> + Sync> Subject<S> for I {
    fn system(&self) -> &S {
        Method::system(self)
    }

    fn order(&self) -> Option<f64> {
        Method::order(self)
    }
    fn identity(&self) -> [u64; 2] {
        [
            fingerprint::method(self),
            fingerprint::parameters(Method::system(self)),
        ]
    }

    fn walk(
        &self,
        start: &StateOf<S>,
        path: &Recorded,
        visit: &mut Visit<'_, S>,
    ) -> Result<StateOf<S>, StepError> {
        let mut trajectory = self.trajectory(start.clone(), path.h(), path);
        for state in trajectory.by_ref() {
            visit(&state?)?;
        }
        Ok(trajectory.state().clone())
    }

    fn iterations(&self, start: &StateOf<S>, path: &Recorded) -> Option<f64> {
        let h = path.h();
        let prepared = self.prepare(h).ok()?;
        let mut state = start.clone();
        let steps = path.len().min(COUNTED);
        let mut sum = 0.0;
        for step in 0..steps {
            let dw = increments::<S>(path, step);
            sum += f64::from(self.newton_iterations(&prepared, &state, h, &dw)?);
            self.step_prepared(&prepared, &mut state, h, &dw).ok()?;
        }
        Some(sum / steps as f64)
    }

    fn clock(
        &self,
        start: &StateOf<S>,
        h: f64,
        parts: &[&[IncrementsOf<S>]],
        times: u32,
    ) -> Result<Vec<Duration>, StepError> {
        let mut sums = vec![Duration::ZERO; parts.len()];
        let mut begin = Instant::now();
        for _ in 0..times {
            let prepared = self.prepare(black_box(h))?;
            let mut state = black_box(start.clone());
            for (sum, part) in sums.iter_mut().zip(parts) {
                for dw in *part {
                    self.step_prepared(&prepared, &mut state, h, dw)?;
                }
                black_box(&state);
                // reading the clock takes as long as a few steps
                if parts.len() > 1 {
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
