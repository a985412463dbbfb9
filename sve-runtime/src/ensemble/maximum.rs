//! The greatest value of a function along each path.
//!
//! Input: a function of the system and a state. Output: an observable of the greatest value after
//! all steps so far, with that at the start.

use super::Ensemble;
use super::memory::{Accumulate, Accumulated};
use super::observer::{Kind, LastStep};
use crate::ensemble::PathMethod;
use crate::error::observed::Observed;
use crate::system::StateOf;

impl<'a, I: PathMethod, K> Ensemble<'a, I, K> {
    /// Takes statistics of the greatest value that a function has had along each path: at the
    /// start, after each step until the recorded time, and where a path [stops](Self::stop_at).
    ///
    /// Values between two steps are not seen. For a function with a smooth motion the maximum is
    /// too small by O(h²). A function that the noise moves itself, such as a momentum with noise of
    /// strength σ, has a mean maximum that is too small by about 0.58 σ√h (Chernoff 1965; Broadie,
    /// Glasserman and Kou 1997). [`integral`](Self::integral) has an example.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().maximum("highest", |_, state| state.q[0]).run()?;
    /// assert_eq!(summary["highest"].mean()[0], 1.0); // at the start
    /// assert!(summary["highest"].min()[1] >= 1.0);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn maximum<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name, Accumulated::new(function, Maximum))
    }
}

/// The greatest value so far.
#[derive(Clone, Copy)]
struct Maximum;

impl Accumulate for Maximum {
    const KIND: Kind = Kind::Maximum;

    fn begin(self, now: f64) -> f64 {
        now
    }

    fn after(self, greatest: f64, [_, now]: [f64; 2], _: &LastStep, _: usize) -> f64 {
        greatest.max(now)
    }
}
