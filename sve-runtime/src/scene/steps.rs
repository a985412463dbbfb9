//! Steps, compiled as a whole for the vectors of this machine.

use super::drag::{Motion, Velocities};
use super::drift::Drift;
use super::errors::index_error;
use super::kinetic::KineticForm;
use super::midpoint::MidpointStep;
use super::shear::{Phase, Prepared};
use super::sweep::{Kick, Place, Sweep};
use super::{Row, Scene, reads_motion};
use crate::error::StepError;
use crate::lanes::dispatch::Kernel;
use crate::rule::StepShear;

/// Steps with the same shears.
pub(super) struct Steps<'a, S: Scene> {
    pub(super) scene: &'a S,
    pub(super) prepared: &'a mut Prepared,
    pub(super) state: Phase<'a, S::Row>,
    pub(super) shears: &'a [StepShear],
    /// The time at the start of the current step.
    pub(super) t: f64,
    pub(super) increments: Increments<'a>,
    pub(super) is_tested: bool,
    /// The pieces that get their impulses: the first ones.
    pub(super) pieces: usize,
}

/// The increments of steps.
pub(super) enum Increments<'a> {
    /// The increments of one step.
    Given(&'a [f64]),
    /// The increments of up to `count` steps. `draw` fills them and returns the time at the end of
    /// the step; `None` ends the steps.
    Drawn {
        dw: &'a mut [f64],
        count: u64,
        draw: &'a mut dyn FnMut(u64, &mut [f64]) -> Option<f64>,
    },
}

impl Increments<'_> {
    /// Begins the next step after `made` of them. Returns the time at its end, or at the start of
    /// the only step.
    #[inline(always)]
    fn next(&mut self, made: u64, t: f64) -> Option<f64> {
        match self {
            Self::Given(_) => (made == 0).then_some(t),
            Self::Drawn { dw, count, draw } if made < *count => draw(made, dw),
            Self::Drawn { .. } => None,
        }
    }

    #[inline(always)]
    fn of_step(&self) -> &[f64] {
        match self {
            Self::Given(dw) => dw,
            Self::Drawn { dw, .. } => dw,
        }
    }
}

/// The reason why steps end early.
#[derive(Debug)]
pub(super) enum Failed {
    Error(StepError),
    NotFinite(Place),
}

/// Returns whether the velocities are momenta divided by masses, so that a drift can be part of a
/// sweep.
pub(super) const fn is_plain<S: Scene>() -> bool {
    matches!(S::KINETIC, KineticForm::Masses) && !reads_motion::<S>()
}

/// The time of a drift, and the times of friction before it and after it.
type Plain = (f64, [f64; 2]);

impl<S: Scene> Kernel for Steps<'_, S> {
    /// The number of steps, and the time at their end.
    type Output = Result<(u64, f64), Failed>;

    /// Makes the steps. A drift waits for the kick after it, with which it is one sweep, and a kick
    /// for one of the same length at the same time, as that at the start of the next step: their
    /// impulses differ by the increments alone, and are computed in one sweep.
    #[inline(always)]
    fn run(mut self) -> Self::Output {
        let (mut made, mut end) = (0, self.t);
        let mut drift: Option<Plain> = None;
        // Length and time. A kick at the end of a step waits for that of the next one.
        let mut kick: Option<[f64; 2]> = None;
        let waits = matches!(
            self.shears,
            [StepShear::Kick { .. }, .., StepShear::Kick { .. }]
        );
        // the part of the increments of this step that is set
        let mut set = None;
        let mut shears = [].iter();
        // All sweeps have one call, since each call is a copy of the loops.
        loop {
            let next = shears.next().copied();
            let is_step_over = next.is_none() && (kick.is_none() || waits);
            if is_step_over && let Some(after) = self.increments.next(made, self.t) {
                (self.t, end, shears) = (end, after, self.shears.iter());
                set = None;
                made += 1;
                continue;
            }
            let next_kick = match next {
                // the time of an impulse that does not read it makes no difference
                Some(StepShear::Kick { h, part, at }) => {
                    Some(([h, if S::READS_TIME { self.t + at } else { 0.0 }], part))
                }
                _ => None,
            };
            // the part of the increments of the second kick, if both are one sweep
            let second = next_kick.filter(|&(next, _)| kick == Some(next));
            let second = second.map(|(_, part)| part);
            let is_drift_alone = if kick.is_some() {
                S::TOTALS > 0 || !self.prepared.segments.nests.is_empty()
            } else {
                next_kick.is_none()
            };
            if is_drift_alone && let Some(motion) = drift.take() {
                self.drift(motion)?;
            }
            if let Some(kick) = kick.take() {
                self.kick(drift.take(), kick, second)?;
                set = second.or(set);
            }
            match next {
                Some(StepShear::Drift { h, friction, .. }) if is_plain::<S>() => {
                    drift = Some((h, friction));
                }
                Some(StepShear::Drift {
                    h,
                    friction,
                    parts,
                    at,
                }) => self.drift_with_drags(Motion {
                    h,
                    forced: friction,
                    parts,
                    at: at.map(|at| self.t + at),
                    start: self.t,
                })?,
                Some(StepShear::Midpoint { h, part, at }) => {
                    self.midpoint([h, at], part)?;
                    set = None;
                }
                Some(StepShear::Kick { part, .. }) if second.is_none() => {
                    kick = next_kick.map(|(kick, _)| kick);
                    if set != Some(part) {
                        self.set_increments(part, waits);
                        set = Some(part);
                    }
                }
                None if is_step_over => return Ok((made, end)),
                Some(StepShear::Kick { .. }) | None => {}
            }
        }
    }
}

impl<S: Scene> Steps<'_, S> {
    /// Sets the increments of a kick. `waits` is true if it may wait for those of the next step,
    /// which are then drawn in the place of these.
    #[inline(always)]
    fn set_increments(&mut self, part: f64, waits: bool) {
        if part == 1.0 && S::TOTALS == 0 && !waits {
            self.prepared.of_kicks[0].clear();
        } else {
            let dw = self.increments.of_step();
            self.prepared.set_increments(0, part, dw);
        }
    }

    /// Makes a kick, with the drift before it; and a second one with this part of the increments of
    /// the step, if there is one.
    #[inline(always)]
    fn kick(
        &mut self,
        motion: Option<Plain>,
        [h, t]: [f64; 2],
        second: Option<f64>,
    ) -> Result<(), Failed> {
        let dw = self.increments.of_step();
        let has_two = second.is_some() && !dw.is_empty();
        if let Some(part) = second {
            self.prepared.set_increments(1, part, dw);
        }
        if S::TOTALS > 0 {
            for of_kick in &mut self.prepared.of_kicks[..=usize::from(has_two)] {
                of_kick.resize(dw.len(), 0.0);
                of_kick.resize(dw.len() + S::TOTALS, 0.0);
                let totals = self.scene.totals(t, self.state.q, of_kick);
                totals.map_err(|error| Failed::Error(index_error(error, self.t)))?;
            }
        }
        if second.is_some() {
            self.sweep::<true>(motion, [h, t], has_two)?;
            self.prepared.of_kicks.swap(0, 1);
            Ok(())
        } else {
            self.sweep::<false>(motion, [h, t], false)
        }
    }

    #[inline(always)]
    fn sweep<const TWICE: bool>(
        &mut self,
        motion: Option<Plain>,
        [h, t]: [f64; 2],
        has_two: bool,
    ) -> Result<(), Failed> {
        let Prepared {
            segments,
            masses,
            rates,
            buffers,
            of_kicks: [first, second],
            ..
        } = &mut *self.prepared;
        let of_step = self.increments.of_step();
        let dw = if first.is_empty() { of_step } else { first };
        let sweep = Sweep::<S, TWICE> {
            scene: self.scene,
            segments,
            drift: motion.map(|(h, friction)| Drift {
                masses,
                rates,
                h,
                friction,
            }),
            kick: Kick { h, t, dw },
            second: has_two.then_some(second),
            q: self.state.q,
            p: self.state.p,
            buffers,
            is_tested: self.is_tested,
            pieces: self.pieces,
        };
        match sweep.run() {
            Ok(None) => Ok(()),
            Ok(Some(place)) => Err(Failed::NotFinite(place)),
            Err(error) => Err(Failed::Error(index_error(error, self.t))),
        }
    }

    /// Makes a drift alone.
    #[inline(always)]
    fn drift(&mut self, (h, friction): Plain) -> Result<(), Failed> {
        let Prepared { masses, rates, .. } = &*self.prepared;
        let drift = Drift {
            masses,
            rates,
            h,
            friction,
        };
        drift
            .all(self.state.q, self.state.p, self.is_tested)
            .map_err(Failed::NotFinite)
    }

    /// Makes a drift of a scene whose velocities are solved for, or that has an H₁.
    fn drift_with_drags(&mut self, motion: Motion) -> Result<(), Failed> {
        let Prepared {
            sites,
            masses,
            rates,
            drags,
            ..
        } = &mut *self.prepared;
        let velocities = Velocities {
            sites: sites.as_ref(),
            masses,
            rates,
        };
        let dw = self.increments.of_step();
        let drifted = drags.drift(self.scene, velocities, &mut self.state, motion, dw);
        drifted.map_err(Failed::Error)?;
        let [q, p] = [&*self.state.q, &*self.state.p].map(S::Row::numbers);
        let mut arrays = [("q", q), ("p", p)].into_iter();
        let not_finite = arrays.find_map(|(array, numbers)| {
            let at = numbers.iter().position(|x| !x.is_finite())?;
            Some((array, at))
        });
        match not_finite {
            Some(at) if self.is_tested => Err(Failed::NotFinite(Place::new(at, q.len(), 0))),
            _ => Ok(()),
        }
    }

    /// Makes a step of the midpoint rule of length `h` with its node after the time `at`.
    fn midpoint(&mut self, [h, at]: [f64; 2], part: f64) -> Result<(), Failed> {
        let dw = self.increments.of_step();
        self.prepared.set_increments(0, part, dw);
        let Prepared {
            segments,
            masses,
            rates,
            buffers,
            of_kicks: [dw, _],
            of_midpoint,
            ..
        } = &mut *self.prepared;
        let step = MidpointStep {
            segments,
            masses,
            rates,
            buffers,
            work: of_midpoint,
            q: self.state.q,
            p: self.state.p,
            kick: Kick {
                h,
                t: self.t + at,
                dw,
            },
            start: self.t,
        };
        self.scene.midpoint(step).map_err(Failed::Error)
    }
}
