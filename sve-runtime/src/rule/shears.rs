//! The step of a scene: a list of shears of phase space.
//!
//! A rule tells the shears of its substep, and a composition walks over the substeps. Output: the
//! shears of the whole step, with their lengths and times.

use core::convert::Infallible;

use super::{Mode, Rule, Walker};
use crate::system::equations::{Memory, StepEquations};
use crate::system::start::Tested;

/// A shear of a substep, as a fraction of its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shear {
    /// The impulse of the potential and of the noises is added to the momenta.
    Kick(f64),
    /// The sites move with their velocities.
    Drift(f64),
    /// The whole substep by the midpoint rule, which is no shear: its impulse and its motion depend
    /// on one another.
    Midpoint,
}

/// A shear of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepShear {
    /// The impulse of the potential and of the noises is added to the momenta.
    Kick {
        /// The time over which the potential acts.
        h: f64,
        /// The fraction of the increments of the step.
        part: f64,
        /// The time of the node, from the start of the step.
        at: f64,
    },
    /// The sites move with their velocities.
    Drift {
        /// The time over which they move.
        h: f64,
        /// The times over which friction and drags act with the velocity of this drift: before it
        /// and after it, those of the kicks on the same sides.
        friction: [f64; 2],
        /// The fractions of the increments of the kicks on the same sides.
        parts: [f64; 2],
        /// The times of its start and its end, from the start of the step.
        at: [f64; 2],
    },
    /// A step of the midpoint rule.
    Midpoint {
        /// Its length.
        h: f64,
        /// The fraction of the increments of the step.
        part: f64,
        /// The time of the node, from the start of the step.
        at: f64,
    },
}

/// Writes the shears of a step of length `h` to `shears`, in order.
pub fn shears<S, R: Rule<S>>(
    walker: Walker<'_, S, R>,
    prepared: &R::Prepared,
    h: f64,
    shears: &mut Vec<StepShear>,
) {
    shears.clear();
    let mut all = Collected { shears, at: 0.0 };
    let Ok(()) = R::walk(walker, prepared, &mut R::Memory::none(), h, &1.0, &mut all);
}

/// Returns the fraction of a step over which shears kick.
fn kicked(shears: &[Shear]) -> f64 {
    let kicks = shears.iter().map(|shear| match *shear {
        Shear::Kick(fraction) => fraction,
        Shear::Drift(_) | Shear::Midpoint => 0.0,
    });
    kicks.sum()
}

/// The mode that collects the shears of a step.
struct Collected<'a> {
    shears: &'a mut Vec<StepShear>,
    /// The time reached by the drifts so far, from the start of the step.
    at: f64,
}

impl<S, I: ?Sized> Mode<S, I> for Collected<'_> {
    /// The fraction of the increments of the step.
    type Increments = f64;
    type Part = f64;
    type Failure = Infallible;
    type Start = f64;

    fn substep<R>(
        &mut self,
        _: Walker<'_, S, R>,
        _: &Tested<S::Prepared>,
        _: &mut S::Memory,
        _: f64,
        _: &f64,
    ) -> Result<(), Infallible>
    where
        S: StepEquations<R, Increments = I>,
    {
        unreachable!("the step of a scene has no equations")
    }

    fn shears(&mut self, shears: &[Shear], h: f64, part: &f64) -> Result<(), Infallible> {
        let start = self.at;
        let mut drifted = 0.0;
        for (at, shear) in shears.iter().enumerate() {
            self.shears.push(match *shear {
                Shear::Kick(fraction) => StepShear::Kick {
                    h: fraction * h,
                    part: fraction * part,
                    at: self.at,
                },
                Shear::Drift(fraction) => {
                    drifted += fraction;
                    let before = self.at;
                    self.at = start + drifted * h;
                    let kicks = [&shears[..at], &shears[at..]];
                    StepShear::Drift {
                        h: fraction * h,
                        friction: kicks.map(|kicks| h * kicked(kicks)),
                        parts: kicks.map(|kicks| part * kicked(kicks)),
                        at: [before, self.at],
                    }
                }
                Shear::Midpoint => {
                    self.at = start + h;
                    StepShear::Midpoint {
                        h,
                        part: *part,
                        at: start + 0.5 * h,
                    }
                }
            });
        }
        Ok(())
    }

    fn begin(&mut self) -> f64 {
        self.at
    }

    fn end(&mut self, start: f64, h: f64) {
        self.at = start + h;
    }

    fn part(dw: &f64, part: f64) -> f64 {
        dw * part
    }
}
