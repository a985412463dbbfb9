//! Single steps.
//!
//! A step tests the numbers of a tile as long as it has their old values. If one of them is not
//! finite, the shears of the tiles before it are made backwards, which restores the state to
//! rounding errors. Where the way back is not safe, the state is copied before the step.

use super::errors::not_finite;
use super::shear::{Phase, Prepared};
use super::steps::{Failed, Increments, Steps, is_plain};
use super::sweep::Place;
use super::{Row, Scene};
use crate::error::StepError;
use crate::lanes::dispatch::dispatch;
use crate::rule::StepShear;

/// The part of a state that is copied before a step, so that the state can be restored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Copied {
    All,
    Momenta,
    Nothing,
}

impl Prepared {
    /// Makes one step from the time `t`.
    ///
    /// # Errors
    /// An index that is out of range; an input or a result that is not finite. The state is then
    /// unchanged if `is_exact`; otherwise it may be restored to rounding errors of the largest
    /// numbers in the step.
    pub fn step<S: Scene>(
        &mut self,
        scene: &S,
        shears: &[StepShear],
        state: &mut Phase<'_, S::Row>,
        [t, h]: [f64; 2],
        dw: &[f64],
        is_exact: bool,
    ) -> Result<(), StepError> {
        let copied = self.needed::<S>(shears, is_exact);
        self.keep(state, copied);
        let result = dispatch(Steps {
            scene,
            prepared: self,
            state: state.part(usize::MAX),
            shears,
            t,
            increments: Increments::Given(dw),
            is_tested: true,
            pieces: usize::MAX,
        });
        match result {
            Ok(_) => Ok(()),
            Err(Failed::Error(error)) => {
                self.restore(state, copied);
                Err(error)
            }
            Err(Failed::NotFinite(place)) => {
                if copied != Copied::All {
                    self.undo(scene, shears, state, t, dw, place);
                }
                self.restore(state, copied);
                Err(not_finite(state, place, [t, h], dw))
            }
        }
    }

    /// Returns what has to be copied before a step.
    ///
    /// One drift and one kick after it can be made backwards: the kick finds the places at which it
    /// was made, and friction, which may leave nothing of a momentum, is absent. Before the drift,
    /// the places are unchanged. Velocities that are solved for have no such way back. Beside the
    /// loops of other scenes a copy costs little. A step of the midpoint rule writes the state
    /// after its tests.
    pub(super) fn needed<S: Scene>(&self, shears: &[StepShear], is_exact: bool) -> Copied {
        use StepShear::{Drift, Kick, Midpoint};
        let is_gathered = self.segments.nests.is_empty() && S::TOTALS == 0;
        let is_undone = is_gathered && self.rates.is_empty() && is_plain::<S>();
        match shears {
            [Midpoint { .. }] => Copied::Nothing,
            _ if is_exact || !is_undone => Copied::All,
            [Drift { .. }, Kick { .. }] => Copied::Nothing,
            [Kick { .. }, Drift { .. }] | [Kick { .. }, Drift { .. }, Kick { .. }] => {
                Copied::Momenta
            }
            _ => Copied::All,
        }
    }

    /// Makes the last kick backwards and then the drift before it, as far as they were made.
    #[cold]
    fn undo<S: Scene>(
        &mut self,
        scene: &S,
        shears: &[StepShear],
        state: &mut Phase<'_, S::Row>,
        t: f64,
        dw: &[f64],
        Place { moved, pieces, .. }: Place,
    ) {
        if moved == 0 {
            return;
        }
        for &shear in shears.iter().rev() {
            let (back, nodes) = match shear {
                StepShear::Kick { h, part, at } => {
                    let [h, part] = [-h, -part];
                    (StepShear::Kick { h, part, at }, usize::MAX)
                }
                StepShear::Drift {
                    h,
                    friction,
                    parts,
                    at,
                } => {
                    let h = -h;
                    let back = StepShear::Drift {
                        h,
                        friction,
                        parts,
                        at,
                    };
                    (back, moved)
                }
                StepShear::Midpoint { .. } => break,
            };
            // The steps end as those before them did, except for a number that overflows.
            let _ = dispatch(Steps {
                scene,
                prepared: self,
                state: state.part(nodes),
                shears: &[back],
                t,
                increments: Increments::Given(dw),
                is_tested: false,
                pieces,
            });
            for rows in [&mut *state.q, &mut *state.p] {
                // A sum that rounding takes beyond the largest number was close to that number.
                for x in S::Row::numbers_mut(&mut rows[..moved]) {
                    *x = x.clamp(f64::MIN, f64::MAX);
                }
            }
            if matches!(back, StepShear::Drift { .. }) {
                break;
            }
        }
    }
}
