//! A trajectory at rest: what it takes to continue it.

use crate::trajectory::Refinements;

/// A trajectory after some steps, to be stored and continued, from [`Trajectory::snapshot`](crate::Trajectory::snapshot).
///
/// It has all that a trajectory carries from step to step: its first time, step size, number of steps, state, the low parts of
/// [compensated](crate::Trajectory::compensated) sums, and the count of refined steps. It has neither the system nor the method nor the noise: these are
/// given again to [`Method::resume`](crate::Method::resume).
///
/// With the feature `serde` it can be serialised. A format has to keep all bits of numbers: of `serde_json` the feature `float_roundtrip` does.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Snapshot<T> {
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub(crate) start: f64,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub(crate) h: f64,
    pub(crate) step: u64,
    pub(crate) state: T,
    /// Low parts of the state, where sums are compensated.
    pub(crate) rest: Option<T>,
    pub(crate) refinements: Refinements,
}

impl<T> Snapshot<T> {
    /// The state reached.
    pub fn state(&self) -> &T {
        &self.state
    }

    /// Number of steps that were made.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// The step size.
    pub fn h(&self) -> f64 {
        self.h
    }
}
