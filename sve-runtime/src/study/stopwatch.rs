//! Times of steps.
//!
//! Input: a method, a start, a path. Output: a [`Timing`]. A long path is timed in sections,
//! each by the median of its repeats. An occasional disturbance of the machine affects few repeats
//! of a short section, but every repeat of a long one.

use std::time::Duration;

use super::any_method::AnyMethod;
use super::report::Timing;
use crate::error::StepError;
use crate::noise::Recorded;
use crate::system::{StateOf, System};

/// Shortest time that is measured: some hundred times the resolution of a clock.
const SHORTEST: Duration = Duration::from_micros(50);

/// Largest number of passes in a measurement.
const MAX_PASSES: u32 = 1 << 20;

/// Largest number of steps of a section.
const SECTION: usize = 2048;

/// Longest time of a section: shorter than the time slices of a scheduler, so that most sections
/// run without an interruption on a loaded machine.
const LONGEST: Duration = Duration::from_micros(200);

/// The times of a method with a step size.
pub(super) struct Stopwatch<'a, S: System> {
    pub(super) case: usize,
    method: &'a dyn AnyMethod<S>,
    path: Recorded,
    /// Steps of a section.
    section: usize,
    /// Passes along the path in a measurement.
    passes: u32,
    /// Seconds of each section, one for each measurement.
    seconds: Vec<Vec<f64>>,
}

impl<'a, S: System> Stopwatch<'a, S> {
    pub(super) fn new(
        case: usize,
        method: &'a dyn AnyMethod<S>,
        start: &StateOf<S>,
        path: Recorded,
    ) -> Self {
        let mut stopwatch = Self {
            case,
            method,
            path,
            section: SECTION,
            passes: 1,
            seconds: Vec::new(),
        };
        if let Ok(elapsed) = stopwatch.durations(start) {
            let total = elapsed.iter().sum::<Duration>().as_secs_f64();
            let steps = stopwatch.path.len() as f64 * LONGEST.as_secs_f64() / total;
            // a quotient that is not a number counts as 1
            let steps = steps.max(1.0).min(SECTION as f64);
            #[allow(clippy::cast_sign_loss)] // at least 1
            let section = steps as usize;
            stopwatch.section = section;
        }
        let sections = stopwatch.path.len().div_ceil(stopwatch.section);
        stopwatch.seconds = vec![Vec::new(); sections];
        // these passes also warm the caches
        while let Ok(elapsed) = stopwatch.durations(start)
            && elapsed.iter().sum::<Duration>() < SHORTEST
            && stopwatch.passes < MAX_PASSES
        {
            stopwatch.passes *= 2;
        }
        stopwatch
    }

    fn durations(&self, start: &StateOf<S>) -> Result<Vec<Duration>, StepError> {
        (self.method).measure(start, &self.path, self.section, self.passes)
    }

    pub(super) fn measure(&mut self, start: &StateOf<S>) {
        let Ok(elapsed) = self.durations(start) else {
            return;
        };
        for (seconds, elapsed) in self.seconds.iter_mut().zip(elapsed) {
            seconds.push(elapsed.as_secs_f64() / f64::from(self.passes));
        }
    }

    pub(super) fn timing(mut self) -> Option<Timing> {
        let (mut time_to_solution, mut distance) = (0.0, 0.0);
        for seconds in &mut self.seconds {
            seconds.sort_by(f64::total_cmp);
            time_to_solution += quartile(seconds, 2)?;
            distance += quartile(seconds, 3)? - quartile(seconds, 1)?;
        }
        let ns = 1e9 / self.path.len() as f64;
        Some(Timing {
            ns_per_step: ns * time_to_solution,
            ns_spread: ns * 0.5 * distance,
            time_to_solution,
        })
    }
}

/// Returns the value below which so many quarters of the sorted values lie, by linear
/// interpolation.
fn quartile(sorted: &[f64], quarters: usize) -> Option<f64> {
    let at = quarters * sorted.len().checked_sub(1)?;
    let (low, high) = (at / 4, at.div_ceil(4));
    let part = (at % 4) as f64 / 4.0;
    Some(sorted[low] + part * (sorted[high] - sorted[low]))
}

#[cfg(test)]
mod tests {
    use super::quartile;

    #[test]
    fn quartiles_are_interpolated() {
        let sorted = [1.0, 2.0, 4.0, 8.0];
        assert_eq!(quartile(&sorted, 2), Some(3.0));
        assert_eq!(quartile(&sorted, 1), Some(1.75));
        assert_eq!(quartile(&sorted, 4), Some(8.0));
        assert_eq!(quartile(&[], 2), None);
    }
}
