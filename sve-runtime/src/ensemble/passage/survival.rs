//! First-passage times as a distribution: survival, rates, and the paths that were not seen to
//! pass.
//!
//! Input: merged counts. Output: the public statistics. Invariant: at each recorded time the paths
//! that have passed, the censored paths and the paths at risk sum up to all paths. No number is NaN
//! except the error of a rate without an event.
//!
//! Sources: E. L. Kaplan, P. Meier, *Nonparametric estimation from incomplete observations*, J. Am.
//! Stat. Assoc. 53 (1958); M. Greenwood, *The errors of sampling of the survivorship tables*
//! (1926); for passages and other ends in one bin, C. L. Chiang, *Introduction to Stochastic
//! Processes in Biostatistics* (1968), chapter 11.

use core::fmt;

use super::counts::{Ends, PassageCounts};

/// The first passages of the paths of an ensemble, from
/// [`Summary::passage`](super::super::Summary::passage): the distribution of the time τ of the
/// first zero of a function.
///
/// A path is at risk until it passes, fails, or is stopped by another function. In the last two
/// cases it is censored: its τ is only known to be greater. Paths that have not passed at the end
/// of the run are censored at the end.
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

    /// The recorded times of the [summary](super::super::Summary::times).
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Returns the number of paths that have passed until each recorded time.
    pub fn passed(&self) -> Vec<u64> {
        self.cumulative(|ends| ends.passed)
    }

    /// Returns the number of paths that were censored until each recorded time: that failed, or
    /// were stopped by another function, before they passed.
    pub fn censored(&self) -> Vec<u64> {
        self.cumulative(|ends| ends.censored + ends.censored_at_end)
    }

    /// Returns the number of paths that are still at risk at each recorded time. The end of the run
    /// censors the paths at risk at the last time.
    pub fn at_risk(&self) -> Vec<u64> {
        let ended = self.passed().into_iter().zip(self.censored());
        ended
            .map(|(passed, censored)| self.paths - passed - censored)
            .collect()
    }

    /// Returns the estimate of P(τ > t) of Kaplan and Meier at each recorded time t: the fraction
    /// of paths that have not passed, as it would be without censoring. `None` where it is unknown:
    /// after the last path at risk was censored.
    ///
    /// The estimate does not depend on the number of recorded times. Ends of paths are counted in
    /// bins, some 2,000 to 4,096 in the run, or one bin for each recorded time if there are more.
    /// If paths pass and paths are censored in one bin, the order is assumed to be random. This is
    /// exact if the two rates have a constant ratio within the bin, and otherwise has an error of
    /// the second order in the length of the bin. If no path is censored, the estimate is the
    /// fraction of the paths that have not passed.
    ///
    /// The reason for censoring must not depend on how soon a path would have passed. For functions
    /// that stop paths in competition, `passed` over `paths` is the probability of each end.
    pub fn survival(&self) -> Vec<Option<f64>> {
        let points = self.points().into_iter();
        points.map(|point| Some(point?.survival)).collect()
    }

    /// Returns the standard error of [`survival`](Self::survival) by Greenwood's formula, S √Σ d/(n
    /// m) for d passages in a bin with n paths at risk before and m after it, where m = n − d
    /// without censoring. `None` where the survival is unknown, and where no path survives: an
    /// estimate of 0 has no error by this formula.
    pub fn survival_error(&self) -> Vec<Option<f64>> {
        let points = self.points().into_iter();
        let error = |point: Point| point.survival * point.sum.sqrt();
        let known = points.map(|point| point.filter(|point| point.survival > 0.0));
        known.map(|point| point.map(error)).collect()
    }

    /// Returns the first recorded time at which the survival is unknown.
    pub(crate) fn unknown_from(&self) -> Option<f64> {
        let first = self.points().iter().position(Option::is_none)?;
        Some(self.times[first])
    }

    /// Returns the point of the curve of survival at each recorded time; `None` where the curve is
    /// unknown.
    fn points(&self) -> Vec<Option<Point>> {
        let mut curve = Curve::new(self.paths);
        let mut bins = self.counts.bins.iter().peekable();
        let records = 0..self.times.len() as u64;
        let at = records.map(|record| {
            let end = record * self.counts.between_records;
            // paths that are censored at the recorded time itself are at risk until then
            let mut until_now = 0;
            while let Some((&bin, ends)) = bins.next_if(|(bin, _)| **bin <= end) {
                curve.add(ends);
                until_now = if bin == end { ends.censored_at_end } else { 0 };
            }
            let point = curve.point();
            let is_known = point.survival == 0.0 || point.at_risk + until_now > 0;
            is_known.then_some(point)
        });
        at.collect()
    }

    /// Returns the sum of a count of the ends until each recorded time.
    fn cumulative(&self, count: impl Fn(&Ends) -> u64) -> Vec<u64> {
        let mut sums = vec![0; self.times.len()];
        for (bin, ends) in &self.counts.bins {
            sums[bin.div_ceil(self.counts.between_records) as usize] += count(ends);
        }
        let mut sum = 0;
        for value in &mut sums {
            sum += *value;
            *value = sum;
        }
        sums
    }

    /// Returns the number of passages after recorded time number `from`, divided by the time that
    /// paths were at risk: the maximum-likelihood estimate of a constant rate λ, with P(τ > t) ∝
    /// e^(−λt), and its standard error λ/√events. Number 0 is the start; take a later one to leave
    /// out the time in which the paths forget their start.
    ///
    /// # Panics
    /// If there is no recorded time of this number.
    pub fn rate(&self, from: usize) -> Rate {
        assert!(from < self.times.len(), "no recorded time number {from}");
        let (passed, at_risk) = (self.passed(), self.at_risk());
        let events = passed[passed.len() - 1] - passed[from];
        let mut exposure = 0.0;
        for record in from + 1..self.times.len() {
            let interval = (self.times[record] - self.times[record - 1]).abs();
            exposure += at_risk[record] as f64 * interval + self.counts.times[record];
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

/// A point of the curve of survival.
#[derive(Clone, Copy, Debug)]
struct Point {
    survival: f64,
    /// Greenwood's sum.
    sum: f64,
    /// Paths at risk after it.
    at_risk: u64,
}

impl Point {
    /// Returns the point after so many passages, without censored paths in between.
    fn after(self, passed: u64) -> Self {
        if passed == 0 {
            return self;
        }
        let left = self.at_risk - passed;
        let (n, m) = (self.at_risk as f64, left as f64);
        Self {
            survival: self.survival * m / n,
            sum: self.sum + passed as f64 / (n * m),
            at_risk: left,
        }
    }
}

/// The curve of survival, followed bin by bin.
struct Curve {
    /// The point at which a path was last censored.
    last: Point,
    /// Passages since. Their factors have a product without rounding errors: a fraction of two
    /// counts.
    passed: u64,
}

impl Curve {
    fn new(paths: u64) -> Self {
        let last = Point {
            survival: 1.0,
            sum: 0.0,
            at_risk: paths,
        };
        Self { last, passed: 0 }
    }

    /// Returns the point that the curve has reached.
    fn point(&self) -> Point {
        self.last.after(self.passed)
    }

    /// Adds the ends of a bin.
    fn add(&mut self, ends: &Ends) {
        let (passed, censored) = (ends.passed, ends.censored);
        if censored == 0 {
            self.passed += passed;
        } else {
            let mut point = self.point();
            let before = point.at_risk as f64;
            point.at_risk -= passed + censored;
            let after = point.at_risk as f64;
            // If no path is left, it is unknown whether the last path passed or was censored.
            if passed > 0 && after > 0.0 {
                // in random order, each end is a passage with this probability
                let share = passed as f64 / (passed + censored) as f64;
                point.survival *= (after / before).powf(share);
                point.sum += passed as f64 / (before * after);
            }
            self.restart(point);
        }
        if ends.censored_at_end > 0 {
            let mut point = self.point();
            point.at_risk -= ends.censored_at_end;
            self.restart(point);
        }
    }

    fn restart(&mut self, last: Point) {
        *self = Self { last, passed: 0 };
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
        if events > 0 {
            write!(
                f,
                ", {value:.4e} ± {standard_error:.1e} per unit of time at risk"
            )?;
        }
        match self.unknown_from() {
            Some(t) => write!(
                f,
                ", survival unknown from t = {t} on, since all other paths were censored before"
            ),
            None => Ok(()),
        }
    }
}
