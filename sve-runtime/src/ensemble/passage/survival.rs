//! First-passage times as a distribution: survival, rates, and the paths that were not seen to pass.
//!
//! Input: merged counts. Output: the numbers that users read. Invariant: at each recorded time the paths that have passed, those that were censored and those at risk sum up to all paths.
//!
//! Sources: E. L. Kaplan, P. Meier, *Nonparametric estimation from incomplete observations*, J. Am. Stat. Assoc. 53 (1958); M. Greenwood, *The errors of sampling of the survivorship tables* (1926).

use core::fmt;

use super::counts::PassageCounts;

/// The first passages of the paths of an ensemble, from [`Summary::passage`](super::super::Summary::passage): the distribution of the time τ of the first zero of a function.
///
/// A path is at risk until it passes, fails, or is stopped by another function; then it is censored: all that is known of its τ is that it is greater. Paths that have not passed at the
/// end of the run are censored there.
#[derive(Clone, Debug, PartialEq)]
pub struct Passages {
    name: String,
    times: Vec<f64>,
    paths: u64,
    counts: PassageCounts,
}

/// A rate with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rate {
    /// Events per unit of time.
    pub value: f64,
    /// Its standard error; NaN without an event.
    pub standard_error: f64,
    /// Number of events.
    pub events: u64,
    /// The time for which paths were at risk, summed over the paths.
    pub exposure: f64,
}

impl Passages {
    pub(in super::super) fn new(
        name: String,
        times: Vec<f64>,
        paths: u64,
        counts: PassageCounts,
    ) -> Self {
        Self {
            name,
            times,
            paths,
            counts,
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the number of all paths.
    pub fn paths(&self) -> u64 {
        self.paths
    }

    /// The recorded times, those of the [summary](super::super::Summary::times).
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Returns the number of paths that have passed until each recorded time.
    pub fn passed(&self) -> Vec<u64> {
        cumulative(&self.counts.passed)
    }

    /// Returns the number of paths that were censored until each recorded time: that failed, or were stopped by another function, before they passed.
    pub fn censored(&self) -> Vec<u64> {
        cumulative(&self.counts.censored)
    }

    /// Returns the number of paths that are still at risk at each recorded time. Those at the last one are censored by the end of the run.
    pub fn at_risk(&self) -> Vec<u64> {
        let ended = self.passed().into_iter().zip(self.censored());
        ended
            .map(|(passed, censored)| self.paths - passed - censored)
            .collect()
    }

    /// Returns the estimate of P(τ > t) of Kaplan and Meier at each recorded time t: the fraction of paths that have not passed, as it would be without censoring.
    ///
    /// A path that is censored between two recorded times counts there for the part of that time in which it was at risk. If none is censored, the estimate is the fraction of the paths that have not passed.
    /// Paths have to be censored by what does not tell how soon they would have passed: for functions that stop paths in competition, `passed` over `paths` is the probability of each end.
    pub fn survival(&self) -> Vec<f64> {
        self.survival_and_error().0
    }

    /// Returns the standard error of [`survival`](Self::survival) by Greenwood's formula, S √Σ d/(n(n − d)) for d passages of n paths at risk in each interval. Where no path survives it is NaN.
    pub fn survival_error(&self) -> Vec<f64> {
        self.survival_and_error().1
    }

    fn survival_and_error(&self) -> (Vec<f64>, Vec<f64>) {
        let at_risk = self.at_risk();
        let (mut survival, mut sum) = (1.0, 0.0);
        let (mut values, mut errors) = (vec![1.0], vec![0.0]);
        for record in 1..self.times.len() {
            let (passed, censored) = (self.counts.passed[record], self.counts.censored[record]);
            if passed > 0 {
                let interval = (self.times[record] - self.times[record - 1]).abs();
                let unseen = censored as f64 - self.counts.censored_time[record] / interval;
                let n = at_risk[record - 1] as f64 - unseen;
                let d = passed as f64;
                survival *= 1.0 - d / n;
                sum += d / (n * (n - d));
            }
            values.push(survival);
            errors.push(survival * f64::sqrt(sum));
        }
        (values, errors)
    }

    /// Returns the number of passages after recorded time number `from`, divided by the time that paths were at risk: the maximum-likelihood estimate of a constant rate λ, with P(τ > t) ∝ e^(−λt), and its
    /// standard error λ/√events. Number 0 is the start; take a later one to leave out the time in which the paths forget their start.
    ///
    /// # Panics
    /// Unless there is a recorded time of that number.
    pub fn rate(&self, from: usize) -> Rate {
        assert!(from < self.times.len(), "no recorded time number {from}");
        let at_risk = self.at_risk();
        let (mut events, mut exposure) = (0, 0.0);
        for record in from + 1..self.times.len() {
            let interval = (self.times[record] - self.times[record - 1]).abs();
            events += self.counts.passed[record];
            exposure += at_risk[record] as f64 * interval
                + (self.counts.passed_time[record] + self.counts.censored_time[record]);
        }
        let value = if events == 0 {
            0.0
        } else {
            events as f64 / exposure
        };
        let standard_error = if events == 0 {
            f64::NAN
        } else {
            value / (events as f64).sqrt()
        };
        Rate {
            value,
            standard_error,
            events,
            exposure,
        }
    }
}

impl fmt::Display for Passages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Rate {
            value,
            standard_error,
            events,
            ..
        } = self.rate(0);
        write!(f, "{}: {events} of {} paths passed", self.name, self.paths)?;
        if events == 0 {
            return Ok(());
        }
        write!(
            f,
            ", {value:.4e} ± {standard_error:.1e} per unit of time at risk"
        )
    }
}

fn cumulative(counts: &[u64]) -> Vec<u64> {
    let sums = counts.iter().scan(0, |sum, count| {
        *sum += count;
        Some(*sum)
    });
    sums.collect()
}
