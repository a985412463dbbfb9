//! Covariances of observables over the paths, as users read them.
//!
//! Input: tiles of values; merged joint moments. Output: covariances, correlations and standard
//! errors. Invariant: they are NaN for fewer than two paths.

use super::difference::Difference;
use super::joint::{JointColumn, JointMoments, ROW_BYTES, rows};
use super::sizes::AT_ONCE;
use super::statistic::{AnyRequest, Extent, Recorded, Size, Statistic, check_known};
use super::{Ensemble, EnsembleError, Summary};
use crate::ensemble::PathMethod;

impl<I: PathMethod, K> Ensemble<'_, I, K> {
    /// Takes the covariance of two observables over the paths, at each recorded time:
    /// [`Summary::covariance`](super::Summary::covariance).
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator { sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let oscillator = Integrator::new(Oscillator { sigma: 1.0 }, Midpoint);
    /// let summary = Ensemble::new(&oscillator)
    ///     .paths(10_000).seed(1)
    ///     .steps(0.05, 20)
    ///     .start(State::new([0.0], [0.0]))
    ///     .observe("q", |_, state| state.q[0])
    ///     .observe("p", |_, state| state.p[0])
    ///     .covariance("q", "p")
    ///     .run()?;
    /// let both = summary.covariance("q", "p").expect("it was asked for");
    /// let (covariance, error) = (both.covariance()[1], both.standard_error()[1]);
    /// // the exact covariance is ½σ² sin²t
    /// assert!((covariance - 0.5 * 1.0_f64.sin().powi(2)).abs() < 4.0 * error + 1e-3);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn covariance(self, first: impl Into<String>, second: impl Into<String>) -> Self {
        self.request_joint(first.into(), second.into(), false)
    }

    /// Takes the covariance over the paths of one observable at a recorded time s and another one,
    /// or the same, at a recorded time t, for all pairs of recorded times:
    /// [`Summary::two_time`](super::Summary::two_time).
    ///
    /// It costs about as much as a step for each pair of times, and its memory is 64 bytes for
    /// each.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Free { sigma: f64 }
    ///
    /// #[variational(endpoint)]
    /// impl Free {
    ///     fn lagrangian(&self, _q: f64, v: f64) -> f64 { 0.5 * v * v }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let free = Integrator::new(Free { sigma: 1.0 }, Endpoint);
    /// let summary = Ensemble::new(&free)
    ///     .paths(10_000).seed(1)
    ///     .steps(0.1, 20).every(5)
    ///     .start(State::new([0.0], [0.0]))
    ///     .observe("p", |_, state| state.p[0])
    ///     .two_time("p", "p")
    ///     .run()?;
    /// let momentum = summary.two_time("p", "p").expect("it was asked for");
    /// // the momentum is a Wiener process, of covariance min(s, t): at s = 0.5 and t = 2
    /// assert!((momentum.covariance(1, 4) - 0.5).abs() < 4.0 * momentum.standard_error(1, 4));
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn two_time(self, first: impl Into<String>, second: impl Into<String>) -> Self {
        self.request_joint(first.into(), second.into(), true)
    }

    fn request_joint(self, first: String, second: String, is_two_time: bool) -> Self {
        self.take(AnyRequest::Covariance(JointRequest {
            first,
            second,
            is_two_time,
        }))
    }
}

/// The request of covariances of two observables.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct JointRequest {
    /// Names of the observables.
    pub(super) first: String,
    pub(super) second: String,
    /// The first observable is taken at each recorded time s, and the second one at each recorded
    /// time t, instead of both at the same times.
    pub(super) is_two_time: bool,
}

/// The joint moments of two observables.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Joint {
    request: JointRequest,
    /// Numbers of the observables.
    columns: [usize; 2],
    moments: JointColumn,
}

impl JointRequest {
    fn columns(&self, extent: &Extent<'_>) -> [usize; 2] {
        [&self.first, &self.second].map(|name| extent.column(name))
    }
}

impl Statistic for Joint {
    type Request = JointRequest;

    const DIFFERENCE: Difference = Difference::Statistic("covariances");
    const NEEDS_INDEPENDENT_PATHS: bool = true;

    fn check(request: &JointRequest, names: &[String]) -> Result<(), EnsembleError> {
        check_known(&request.first, names, "take a covariance of")?;
        check_known(&request.second, names, "take a covariance of")
    }

    fn size(request: &JointRequest, extent: &Extent<'_>) -> Size {
        let (first, second) = (&request.first, &request.second);
        Size {
            bytes: rows(request.is_two_time, extent.records).saturating_mul(AT_ONCE * ROW_BYTES),
            what: format!("the covariances of `{first}` and `{second}`"),
            remedy: "record less often with `every`",
        }
    }

    fn needs_history(request: &JointRequest) -> bool {
        request.is_two_time
    }

    fn empty(request: &JointRequest, extent: &Extent<'_>) -> Self {
        Self {
            request: request.clone(),
            columns: request.columns(extent),
            moments: JointColumn::new(request.is_two_time, extent.records),
        }
    }

    fn add(&mut self, at: &Recorded<'_>) {
        self.moments.add(self.columns, at);
    }

    fn merge(&mut self, counts: &[u64], other: &Self, others: &[u64]) {
        self.moments.merge(counts, &other.moments, others);
    }

    #[cfg(feature = "serde")]
    fn fits(&self, request: &JointRequest, extent: &Extent<'_>, _: &[u64]) -> bool {
        self.request == *request
            && self.columns == request.columns(extent)
            && self.moments.fits(request.is_two_time, extent.records)
    }

    fn show(self, summary: &mut Summary) {
        let is_two_time = self.request.is_two_time;
        let over_paths = OverPaths {
            names: [self.request.first, self.request.second],
            counts: summary.counts().to_vec(),
            column: self.moments,
        };
        if is_two_time {
            summary.shown.push(TwoTime(over_paths));
        } else {
            summary.shown.push(Covariance(over_paths));
        }
    }
}

impl Summary {
    /// The covariance of two observables, in the order in which
    /// [`Ensemble::covariance`](super::Ensemble::covariance) asked for them.
    pub fn covariance(&self, first: &str, second: &str) -> Option<&Covariance> {
        let mut all = self.shown.all::<Covariance>().iter();
        all.find(|covariance| covariance.names() == [first, second])
    }

    /// The covariance of two observables at two times, in the order in which
    /// [`Ensemble::two_time`](super::Ensemble::two_time) asked for them.
    pub fn two_time(&self, first: &str, second: &str) -> Option<&TwoTime> {
        let mut all = self.shown.all::<TwoTime>().iter();
        all.find(|covariance| covariance.names() == [first, second])
    }
}

/// The covariance of two observables over the paths that have not failed, at each recorded time.
/// From [`Summary::covariance`](super::Summary::covariance).
///
/// Observables beyond 1e75 in size overflow the fourth moments: the standard error is infinite or
/// NaN then.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance(OverPaths);

/// The covariance over the paths of one observable at a time s and another one at a time t. From
/// [`Summary::two_time`](super::Summary::two_time).
///
/// Times are given by their numbers among the [recorded times](super::Summary::times). A pair of
/// times has the paths that have not failed until the later one.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoTime(OverPaths);

/// The joint moments of two observables and the numbers of paths.
#[derive(Clone, Debug, PartialEq)]
struct OverPaths {
    names: [String; 2],
    counts: Vec<u64>,
    column: JointColumn,
}

impl OverPaths {
    fn names(&self) -> [&str; 2] {
        [&self.names[0], &self.names[1]]
    }
}

impl Covariance {
    /// The observables.
    pub fn names(&self) -> [&str; 2] {
        self.0.names()
    }

    fn rows(&self, of: impl Fn(&JointMoments) -> f64) -> Vec<f64> {
        let rows = self.0.counts.iter().enumerate();
        rows.map(|(row, &count)| of(&self.0.column.at(row, count)))
            .collect()
    }

    /// Covariances, with the number of paths less one as the divisor; NaN for fewer than two paths.
    pub fn covariance(&self) -> Vec<f64> {
        self.rows(JointMoments::covariance)
    }

    /// Correlation coefficients: covariances over the products of the standard deviations; NaN if a
    /// standard deviation is 0.
    pub fn correlation(&self) -> Vec<f64> {
        self.rows(JointMoments::correlation)
    }

    /// Standard errors of the covariances, from the fourth moments.
    pub fn standard_error(&self) -> Vec<f64> {
        self.rows(JointMoments::standard_error)
    }
}

impl TwoTime {
    /// The names of the observables at the time s and at the time t.
    pub fn names(&self) -> [&str; 2] {
        self.0.names()
    }

    fn at(&self, s: usize, t: usize) -> JointMoments {
        let records = self.0.counts.len();
        assert!(
            s < records && t < records,
            "there are {records} recorded times, and {s} and {t} are not both among them"
        );
        let count = self.0.counts[s.max(t)];
        self.0.column.at(s * records + t, count)
    }

    /// The covariance of the first observable at recorded time number `s` and the second one at
    /// number `t`; NaN for fewer than two paths.
    ///
    /// # Panics
    /// Unless both numbers are below the number of recorded times.
    pub fn covariance(&self, s: usize, t: usize) -> f64 {
        self.at(s, t).covariance()
    }

    /// The correlation coefficient; NaN if a standard deviation is 0.
    ///
    /// # Panics
    /// As [`covariance`](Self::covariance).
    pub fn correlation(&self, s: usize, t: usize) -> f64 {
        self.at(s, t).correlation()
    }

    /// The standard error of the covariance, from the fourth moments.
    ///
    /// # Panics
    /// As [`covariance`](Self::covariance).
    pub fn standard_error(&self, s: usize, t: usize) -> f64 {
        self.at(s, t).standard_error()
    }
}
