//! The stored form of a trajectory.

use super::adapted::Sizes;
use super::{Refinements, StepKind, Trajectory};
use crate::error::StepError;
use crate::fingerprint::{StepsDifference, StepsFingerprint};
use crate::method::{OneStepMethod, Shared};
use crate::noise::Noise;
use crate::system::StateOf;

/// The stored form of a trajectory after some steps, from
/// [`Trajectory::snapshot`](crate::Trajectory::snapshot).
///
/// It contains everything that a trajectory carries from step to step: its first time, step size,
/// number of steps, state, the low parts of [compensated](crate::Trajectory::compensated) sums, the
/// numbers that the method carries (the force at the end of a step, say), the numbers from which a
/// path with a [tolerance](crate::Trajectory::tolerance) takes the size of its next step, and the
/// count of refined steps. It contains neither the system nor the method nor the noise:
/// [`Method::resume`](crate::Method::resume) takes them again. Hashes of the formulas, of the
/// parameters and of the method tell `resume` whether the numbers that the method carries belong to
/// them.
///
/// With the feature `serde` it can be serialised. The format has to keep all bits of numbers:
/// `serde_json` does so with its feature `float_roundtrip`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Snapshot<T> {
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub(super) start: f64,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub(super) h: f64,
    pub(super) step: u64,
    pub(super) state: T,
    /// Low parts of the state, if sums are compensated.
    #[cfg_attr(feature = "serde", serde(rename = "rest"))]
    pub(super) low: Option<T>,
    /// The numbers that the method carries from step to step.
    #[cfg_attr(feature = "serde", serde(default, with = "crate::floats::many"))]
    pub(super) memory: Vec<f64>,
    /// The numbers from which a path with a tolerance takes the size of its next step.
    #[cfg_attr(feature = "serde", serde(default, with = "crate::floats::many"))]
    pub(super) adapted: Vec<f64>,
    /// The formulas, parameters and method of the steps that were made, which determine `memory`.
    #[cfg_attr(feature = "serde", serde(default))]
    pub(super) steps: StepsFingerprint,
    pub(super) refinements: Refinements,
}

impl<T> Snapshot<T> {
    /// Returns the state reached.
    pub fn state(&self) -> &T {
        &self.state
    }

    /// Returns the number of steps that were made.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Returns the step size; that of the last step if the sizes are adapted to a tolerance.
    pub fn h(&self) -> f64 {
        self.h
    }
}

impl<'a, I: OneStepMethod, W: Noise> Trajectory<'a, I, W> {
    #[allow(clippy::needless_pass_by_value)] // the trajectory takes the place of its snapshot
    pub(crate) fn resume(
        method: impl Into<Shared<'a, I>>,
        snapshot: Snapshot<StateOf<I::System>>,
        noise: W,
    ) -> Result<Self, StepError> {
        let Snapshot {
            start,
            h,
            step,
            state,
            low,
            memory,
            adapted,
            steps,
            refinements,
        } = snapshot;
        let (method, t) = (method.into(), state.t);
        if low.is_some() && adapted.is_empty() && !method.has_compensated_step() {
            return Err(StepError::Uncompensated { t });
        }
        let (mut prepared, mut sizes) = (None, Sizes::Fixed);
        // Without numbers that are carried the next step reads the state and the present parameters
        // alone.
        let numbers = memory.len() + adapted.len();
        if numbers > 0 {
            let other = |differs: &str| StepError::OtherSteps {
                t,
                numbers,
                differs: differs.into(),
            };
            if let Some(what) = steps.difference(&StepsFingerprint::of(&*method)) {
                return Err(other(match what {
                    StepsDifference::Formulas => "formulas of the system",
                    StepsDifference::Parameters => "values of the system's parameters",
                    StepsDifference::Method => "rules or options of Newton's method",
                }));
            }
            if adapted.is_empty() {
                let carried = prepared.insert(method.prepare(h)?);
                if !method.recall(carried, &memory) {
                    return Err(other("versions of this library"));
                }
            } else {
                sizes = Sizes::Stored(adapted);
            }
        }
        Ok(Self {
            start,
            prepared,
            step,
            refinements,
            low,
            sizes,
            ..Self::new(method, state, h, noise)
        })
    }
}

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Trajectory<'_, I, W, K> {
    /// Returns the snapshot from which [`Method::resume`](crate::Method::resume) continues with the
    /// bits of this trajectory.
    pub fn snapshot(&self) -> Snapshot<StateOf<I::System>> {
        Snapshot {
            start: self.start,
            h: self.h,
            step: self.step,
            state: self.state.clone(),
            low: self.low.clone(),
            memory: (self.prepared.as_ref())
                .map_or_else(Vec::new, |prepared| self.method.memory(prepared)),
            adapted: self.sizes.numbers(),
            steps: StepsFingerprint::of(&*self.method),
            refinements: self.refinements,
        }
    }
}
