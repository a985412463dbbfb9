//! A problem with its results.

use std::ops::RangeInclusive;

use sve_runtime::study::Report;

/// A problem of the study.
pub(crate) struct Problem {
    pub(crate) title: &'static str,
    /// Description of the problem and of its errors.
    pub(crate) setting: &'static str,
    /// The norm of the error at the end.
    pub(crate) norm: &'static str,
    /// The conserved quantity, if there is one.
    pub(crate) invariant: Option<&'static str>,
    pub(crate) report: Report,
}

/// Returns powers of two.
pub(crate) fn powers(exponents: RangeInclusive<u32>) -> impl Iterator<Item = usize> {
    exponents.map(|k| 1 << k)
}
