//! Warnings about unreliable statistics and missing files.
//!
//! Input: the statistics of observables. Output: warnings about observables that diverge, and about
//! means that depend on one path. Both criteria are fixed and documented at [`Warning`]; they use
//! the recorded times only. The warning about a checkpoint comes from the run.

use core::fmt;

use super::moments::Column;

/// Growth within the second half of a run that is reported. A power tᵖ grows by 2ᵖ in it, so this
/// is about the tenth power.
const GROWTH: f64 = 1e3;

/// Growth from the start that is reported if nothing was recorded between the start and the second
/// half.
const GROWTH_FROM_START: f64 = 1e12;

/// Smallest number of paths at which a single path should not have most of the variance.
const MANY: u64 = 100;

/// Largest fraction of the sum of squared deviations of one path.
const SHARE: f64 = 0.5;

/// The reason why a statistic is unreliable, or a file lacks results, from
/// [`Summary::warnings`](super::Summary::warnings).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Warning {
    /// An observable diverges: its largest magnitude over the paths at the end is more than 1000
    /// times its largest magnitude at all recorded times in the first half of the run. If only the
    /// start was recorded in the first half, the factor is 10¹². An observable that is 0 throughout
    /// the first half is not tested.
    ///
    /// Exact solutions that grow exponentially are reported as well. Otherwise the step is too long
    /// for the method.
    Diverges {
        /// The observable.
        name: String,
        /// Recorded time at which the first half had its largest magnitude.
        from: f64,
        /// That magnitude.
        before: f64,
        /// The last time with paths.
        to: f64,
        /// Largest magnitude at the end.
        after: f64,
    },
    /// A single path, among 100 or more, has over half of the sum of squared deviations at the end:
    /// mean and standard error depend on this path. This happens for distributions with an infinite
    /// moment, and for rare events that occurred once.
    OnePath {
        /// The observable.
        name: String,
        /// The last time with paths.
        t: f64,
        /// Number of paths.
        paths: u64,
        /// Value of that path.
        value: f64,
        /// Its fraction of the sum of squared deviations.
        share: f64,
    },
    /// The file of [`Ensemble::checkpoint`](super::Ensemble::checkpoint) could not be written
    /// during the run. The statistics are not affected.
    #[cfg(feature = "checkpoint")]
    Checkpoint {
        /// The file.
        path: String,
        /// Number of attempts that failed.
        failed: u64,
        /// The error of the system at the last of them.
        error: String,
        /// A later attempt, at the end, wrote the file with all results of the run.
        is_written: bool,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Diverges {
                name,
                from,
                before,
                to,
                after,
            } => write!(
                f,
                "`{name}` diverges: up to {before:.1e} at t = {from} and {after:.1e} at t = {to}; take a smaller h, or \
                 let paths fail that leave a range with `.bound(\"{name}\", …)`"
            ),
            Self::OnePath {
                name,
                t,
                paths,
                value,
                share,
            } => write!(
                f,
                "one path of {paths} has {:.0} % of the variance of `{name}` at t = {t}, with the value {value:.1e}: its mean is not resolved",
                100.0 * share
            ),
            #[cfg(feature = "checkpoint")]
            Self::Checkpoint {
                path,
                failed,
                error,
                is_written,
            } => {
                let times = if *failed == 1 { "time" } else { "times" };
                write!(
                    f,
                    "the checkpoint {path} could not be written {failed} {times}, at last because of: {error}; "
                )?;
                f.write_str(if *is_written {
                    "a later attempt wrote the file, which has these results"
                } else {
                    "the file lacks these results, or does not exist: store the summary in another place"
                })
            }
        }
    }
}

/// The warnings about an observable.
pub(super) fn warnings<'a>(
    name: &'a str,
    times: &'a [f64],
    counts: &'a [u64],
    column: &'a Column,
) -> impl Iterator<Item = Warning> + 'a {
    let end = counts.iter().rposition(|&count| count > 0);
    end.into_iter().flat_map(move |end| {
        let growth = diverges(name, times, end, column);
        let one = one_path(name, times[end], end, counts[end], column);
        growth.into_iter().chain(one)
    })
}

fn diverges(name: &str, times: &[f64], end: usize, column: &Column) -> Option<Warning> {
    let size = |record: usize| column.min[record].abs().max(column.max[record].abs());
    let middle = 0.5 * times[0] + 0.5 * times[end];
    let first_half = (0..end).filter(|&record| times[record] <= middle);
    let at = first_half
        .clone()
        .max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
    let (before, after) = (size(at), size(end));
    let factor = if first_half.count() > 1 {
        GROWTH
    } else {
        GROWTH_FROM_START
    };
    // the quotient may overflow, and is then large enough
    (before > 0.0 && after / before > factor).then(|| Warning::Diverges {
        name: name.to_owned(),
        from: times[at],
        before,
        to: times[end],
        after,
    })
}

fn one_path(name: &str, t: f64, record: usize, paths: u64, column: &Column) -> Option<Warning> {
    let (value, share) = column.farthest(record);
    (paths >= MANY && share > SHARE).then(|| Warning::OnePath {
        name: name.to_owned(),
        t,
        paths,
        value,
        share: share.min(1.0),
    })
}
