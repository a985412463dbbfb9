//! Times of steps.
//!
//! Input: a method, a start, increments. Output: a [`Timing`]: medians, so that what disturbs a machine now and then does not count.

use std::time::Duration;

use super::report::Timing;
use super::subject::Subject;
use crate::system::{IncrementsOf, StateOf, System};

/// The least time that is measured at once: some hundred times the resolution of a clock.
const SLICE: Duration = Duration::from_micros(200);

/// Walks of a path measured at once, where one takes no time at all.
const MOST: u32 = 1 << 20;

/// The times of a method with a step size.
pub(super) struct Watch<'a, S: System> {
    pub(super) case: usize,
    subject: &'a dyn Subject<S>,
    h: f64,
    increments: Vec<IncrementsOf<S>>,
    /// How often the path is walked in a measurement.
    times: u32,
    /// Seconds a path, one a measurement.
    seconds: Vec<f64>,
}

impl<'a, S: System> Watch<'a, S> {
    pub(super) fn new(
        case: usize,
        subject: &'a dyn Subject<S>,
        start: &StateOf<S>,
        h: f64,
        increments: Vec<IncrementsOf<S>>,
    ) -> Self {
        let mut times = 1;
        // these walks also warm the caches
        while let Ok(elapsed) = subject.clock(start, h, &increments, times)
            && elapsed < SLICE
            && times < MOST
        {
            times *= 2;
        }
        Self {
            case,
            subject,
            h,
            increments,
            times,
            seconds: Vec::new(),
        }
    }

    pub(super) fn measure(&mut self, start: &StateOf<S>) {
        let elapsed = self
            .subject
            .clock(start, self.h, &self.increments, self.times);
        if let Ok(elapsed) = elapsed {
            self.seconds
                .push(elapsed.as_secs_f64() / f64::from(self.times));
        }
    }

    pub(super) fn timing(mut self) -> Option<Timing> {
        self.seconds.sort_by(f64::total_cmp);
        let time_to_solution = quartile(&self.seconds, 2)?;
        let ns = 1e9 / self.increments.len() as f64;
        let quartiles = quartile(&self.seconds, 3)? - quartile(&self.seconds, 1)?;
        Some(Timing {
            ns_per_step: ns * time_to_solution,
            ns_spread: ns * 0.5 * quartiles,
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
