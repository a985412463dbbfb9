//! The number of changes of sign of a function along each path.
//!
//! Input: a function of the system and a state. Output: an observable of the number of its changes
//! of sign from one step to the next so far.

use super::Ensemble;
use super::memory::{Accumulate, Accumulated};
use super::observer::{Kind, LastStep};
use crate::ensemble::PathMethod;
use crate::error::observed::Observed;
use crate::system::StateOf;

impl<'a, I: PathMethod, K> Ensemble<'a, I, K> {
    /// Takes statistics of the number of times that a function has changed its sign from one step
    /// to the next, along each path.
    ///
    /// A value of exactly 0 after a step counts as a change; the motion that leaves this zero is
    /// not counted again. Two changes within a step are not detected. [`integral`](Self::integral)
    /// has an example.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().crossings("zeros", |_, state| state.q[0]).run()?;
    /// assert_eq!(summary["zeros"].mean()[0], 0.0);
    /// assert!(summary["zeros"].mean()[1] > 0.0);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn crossings<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name, Accumulated::new(function, Crossings))
    }
}

/// The number of changes of sign.
#[derive(Clone, Copy)]
struct Crossings;

impl Accumulate for Crossings {
    const KIND: Kind = Kind::Crossings;

    fn after(self, changes: f64, [last, now]: [f64; 2], _: &LastStep, _: usize) -> f64 {
        changes + f64::from(u8::from(crosses(last, now)))
    }
}

/// Returns whether a function changes its sign from one value to the next. A motion that arrives at
/// 0 changes the sign, a motion that leaves from 0 does not.
#[inline(always)]
pub(super) fn crosses(last: f64, now: f64) -> bool {
    let (rises, falls) = (last < 0.0 && now >= 0.0, last > 0.0 && now <= 0.0);
    rises || falls
}
