//! Times of steps.
//!
//! Input: a method, a start, increments. Output: a [`Timing`]. A long path is timed in parts, each as the median of its repeats: what disturbs a
//! machine now and then hits few repeats of a short part, and every repeat of a long one.

use std::time::Duration;

use super::report::Timing;
use super::subject::Subject;
use crate::error::StepError;
use crate::system::{IncrementsOf, StateOf, System};

/// The least time that is measured at once: some hundred times the resolution of a clock.
const SLICE: Duration = Duration::from_micros(50);

/// Walks of a path measured at once, where one takes no time at all.
const MOST: u32 = 1 << 20;

/// Steps of a part.
const PART: usize = 2048;

/// The times of a method with a step size.
pub(super) struct Watch<'a, S: System> {
    pub(super) case: usize,
    subject: &'a dyn Subject<S>,
    h: f64,
    increments: Vec<IncrementsOf<S>>,
    /// How often the path is walked in a measurement.
    times: u32,
    /// Seconds of each part, one a measurement.
    seconds: Vec<Vec<f64>>,
}

impl<'a, S: System> Watch<'a, S> {
    pub(super) fn new(
        case: usize,
        subject: &'a dyn Subject<S>,
        start: &StateOf<S>,
        h: f64,
        increments: Vec<IncrementsOf<S>>,
    ) -> Self {
        let seconds = vec![Vec::new(); increments.len().div_ceil(PART)];
        let mut watch = Self {
            case,
            subject,
            h,
            increments,
            times: 1,
            seconds,
        };
        // these walks also warm the caches
        while let Ok(elapsed) = watch.clock(start)
            && elapsed.iter().sum::<Duration>() < SLICE
            && watch.times < MOST
        {
            watch.times *= 2;
        }
        watch
    }

    fn clock(&self, start: &StateOf<S>) -> Result<Vec<Duration>, StepError> {
        let parts: Vec<&[IncrementsOf<S>]> = self.increments.chunks(PART).collect();
        self.subject.clock(start, self.h, &parts, self.times)
    }

    pub(super) fn measure(&mut self, start: &StateOf<S>) {
        let Ok(elapsed) = self.clock(start) else {
            return;
        };
        for (seconds, elapsed) in self.seconds.iter_mut().zip(elapsed) {
            seconds.push(elapsed.as_secs_f64() / f64::from(self.times));
        }
    }

    pub(super) fn timing(mut self) -> Option<Timing> {
        let (mut time_to_solution, mut distance) = (0.0, 0.0);
        for seconds in &mut self.seconds {
            seconds.sort_by(f64::total_cmp);
            time_to_solution += quartile(seconds, 2)?;
            distance += quartile(seconds, 3)? - quartile(seconds, 1)?;
        }
        let ns = 1e9 / self.increments.len() as f64;
        Some(Timing {
            ns_per_step: ns * time_to_solution,
            ns_spread: ns * 0.5 * distance,
            time_to_solution,
        })
    }
}

/// The value below which so many quarters of the sorted values lie, between neighbours in proportion.
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
    fn quartiles() {
        let sorted = [1.0, 2.0, 4.0, 8.0];
        assert_eq!(quartile(&sorted, 2), Some(3.0));
        assert_eq!(quartile(&sorted, 1), Some(1.75));
        assert_eq!(quartile(&sorted, 4), Some(8.0));
        assert_eq!(quartile(&[], 2), None);
    }
}
