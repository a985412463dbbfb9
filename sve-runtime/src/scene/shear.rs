//! Steps that are shears: kicks, which change the momenta at fixed places, and drifts, which change
//! the places at fixed momenta.
//!
//! A shear is made in place and needs no second state. A number that is not finite stays so in all
//! later shears. Therefore, many steps without noise are made in blocks: the state is copied, the
//! steps are made without tests, and the result is tested. If it is not finite, the steps are
//! repeated from the copy with a test each, so that the step that fails is known, and the state
//! before it is restored.

use super::drag::{Drags, Motion, Velocities};
use super::drift::{AreFinite, Drift, DriftAlone};
use super::errors::{check_forces, index_error, not_finite};
use super::kinetic::{KineticForm, Sites};
use super::masses::InverseMasses;
use super::midpoint::MidpointStep;
use super::segments::Segments;
use super::sweep::{Buffers, Kick, Sweep};
use super::work::Work;
use super::{Impulses, IndexError, Layout, Row, Scene};
use crate::error::StepError;
use crate::lanes::dispatch::dispatch;
use crate::rule::StepShear;

/// Steps between tests, at least. A block of a small scene has more steps, since the calls of copy
/// and test cost as much as some of its steps.
const BLOCK: u64 = 64;
const SITES: u64 = 1 << 16;

/// The arrays of a state of a scene, of the length for which its steps are prepared.
#[derive(Debug)]
pub struct Phase<'a, R> {
    /// The configuration.
    pub q: &'a mut [R],
    /// The momenta.
    pub p: &'a mut [R],
}

/// What is known about a scene for a number of sites, and the arrays that its steps need.
#[derive(Clone, Debug)]
pub struct Prepared {
    n: usize,
    processes: usize,
    segments: Segments,
    /// The kinetic energies of sites that have no masses of components.
    sites: Option<Sites>,
    masses: InverseMasses,
    drags: Drags,
    /// The friction of each component divided by its mass; empty without friction.
    rates: Vec<f64>,
    buffers: Buffers,
    /// The state before a step or block.
    before: [Vec<f64>; 2],
    /// The increments of a kick.
    of_kick: Vec<f64>,
    of_midpoint: Work,
}

impl Prepared {
    /// Executes the indices of a scene of `n` sites, and reads its masses.
    ///
    /// # Errors
    /// An index that is out of range; a mass without an inverse; a force without an entry for
    /// each site.
    pub fn new<S: Scene>(scene: &S, n: usize, t: f64) -> Result<Self, StepError> {
        let index = |error| index_error(error, t);
        check_forces(scene, n, t)?;
        let segments = Segments::new(scene, n).map_err(index)?;
        let numbers = n * S::Row::LENGTH;
        let masses = InverseMasses::new(scene, n, t)?;
        Ok(Self {
            n,
            processes: scene.processes(n).map_err(index)?,
            rates: masses.rates(scene, n).map_err(index)?,
            masses,
            sites: Sites::new(scene, n).map_err(index)?,
            drags: Drags::default(),
            buffers: Buffers::new::<S::Row>(&segments, n),
            segments,
            before: [vec![0.0; numbers], vec![0.0; numbers]],
            of_kick: Vec::new(),
            of_midpoint: Work::default(),
        })
    }

    /// Returns the number of sites.
    pub fn sites(&self) -> usize {
        self.n
    }

    /// Returns the number of Wiener processes.
    pub fn processes(&self) -> usize {
        self.processes
    }

    /// Returns what is known about the loops.
    pub fn layout<S: Scene>(&self) -> Layout {
        let masses = match &self.masses {
            InverseMasses::Uniform(_) => 0,
            InverseMasses::Each(inverse) => inverse.len(),
        };
        let numbers = masses
            + self.rates.len()
            + self.sites.as_ref().map_or(0, Sites::len)
            + self.drags.len()
            + self.buffers.len()
            + 2 * self.before[0].len()
            + self.of_kick.len()
            + self.of_midpoint.len();
        Layout::new::<S>(self.n, &self.segments, numbers * size_of::<f64>())
    }

    /// Makes one step from the time `t`.
    ///
    /// # Errors
    /// An index that is out of range; an input or a result that is not finite. The state is then
    /// unchanged.
    pub fn step<S: Scene>(
        &mut self,
        scene: &S,
        shears: &[StepShear],
        state: &mut Phase<'_, S::Row>,
        [t, h]: [f64; 2],
        dw: &[f64],
    ) -> Result<(), StepError> {
        self.keep(state);
        let mut run = Run::new(scene, self, state, true);
        let result = run.step(shears, t, dw).and_then(|()| run.end(t));
        let error = match result {
            Ok(true) => return Ok(()),
            Ok(false) => not_finite(&self.before, state, [t, h], dw),
            Err(error) => error,
        };
        self.restore(state);
        Err(error)
    }

    /// Makes up to `count` steps from the time `t` without tests, and tests the result. `draw`
    /// fills the increments of a step and returns the time at its end; `None` ends the block.
    /// Returns the number of steps made. If the result is not finite or an index is out of range,
    /// none is made, and the state is unchanged.
    #[allow(clippy::too_many_arguments)] // those of a step, and of several
    pub fn block<S: Scene>(
        &mut self,
        scene: &S,
        shears: &[StepShear],
        state: &mut Phase<'_, S::Row>,
        t: &mut f64,
        dw: &mut [f64],
        count: u64,
        draw: &mut dyn FnMut(u64, &mut [f64]) -> Option<f64>,
    ) -> u64 {
        let count = count.min(BLOCK + SITES / (self.n as u64 + 1));
        self.keep(state);
        let mut run = Run::new(scene, self, state, false);
        let (mut made, mut end) = (0, *t);
        let mut result = Ok(());
        while made < count
            && result.is_ok()
            && let Some(after) = draw(made, dw)
        {
            result = run.step(shears, end, dw);
            end = after;
            made += 1;
        }
        let result = result.and_then(|()| run.end(end));
        let is_finite = |rows: &[S::Row]| dispatch(AreFinite(S::Row::numbers(rows)));
        if result.is_ok() && is_finite(state.q) && is_finite(state.p) {
            *t = end;
            return made;
        }
        self.restore(state);
        0
    }

    /// Sets the increments of a part of a step.
    fn set_increments(&mut self, part: f64, dw: &[f64]) {
        self.of_kick.clear();
        self.of_kick.extend(dw.iter().map(|dw| part * dw));
    }

    fn keep<R: Row>(&mut self, state: &Phase<'_, R>) {
        self.before[0].copy_from_slice(R::numbers(state.q));
        self.before[1].copy_from_slice(R::numbers(state.p));
    }

    #[cold]
    fn restore<R: Row>(&self, state: &mut Phase<'_, R>) {
        R::numbers_mut(state.q).copy_from_slice(&self.before[0]);
        R::numbers_mut(state.p).copy_from_slice(&self.before[1]);
    }
}

/// Steps that are being made. A drift waits for the kick after it, with which it is one sweep, and
/// a kick for an equal one: the impulse is then computed once, and added twice.
struct Run<'a, 'b, S: Scene> {
    scene: &'a S,
    prepared: &'a mut Prepared,
    state: &'a mut Phase<'b, S::Row>,
    is_tested: bool,
    /// The time of a drift, and the times of friction before it and after it.
    drift: Option<(f64, [f64; 2])>,
    /// Length, part of the increments and time of a kick.
    kick: Option<[f64; 3]>,
    /// Whether all numbers are finite, as far as they were tested.
    is_finite: bool,
}

impl<'a, 'b, S: Scene> Run<'a, 'b, S> {
    fn new(
        scene: &'a S,
        prepared: &'a mut Prepared,
        state: &'a mut Phase<'b, S::Row>,
        is_tested: bool,
    ) -> Self {
        Self {
            scene,
            prepared,
            state,
            is_tested,
            drift: None,
            kick: None,
            is_finite: true,
        }
    }

    fn step(&mut self, shears: &[StepShear], t: f64, dw: &[f64]) -> Result<(), StepError> {
        for shear in shears {
            match *shear {
                StepShear::Drift {
                    h,
                    friction,
                    parts,
                    at,
                } => {
                    self.kick::<false>(t)?;
                    self.drift_alone();
                    let is_plain = S::KINETIC == KineticForm::Masses;
                    if is_plain && !S::HAS_DRAGS && !S::HAS_H1 {
                        self.drift = Some((h, friction));
                    } else {
                        let motion = Motion {
                            h,
                            forced: friction,
                            parts,
                            at: at.map(|at| t + at),
                            start: t,
                        };
                        self.drift_with_drags(motion, dw)?;
                    }
                }
                StepShear::Midpoint { h, part, at } => {
                    self.end(t)?;
                    self.midpoint([h, t + at], part, dw, t)?;
                }
                StepShear::Kick { h, part, at } => {
                    // the time of an impulse that does not read it makes no difference
                    let time = if S::READS_TIME { t + at } else { 0.0 };
                    let kick = Some([h, part, time]);
                    if self.kick == kick {
                        self.kick::<true>(t)?;
                    } else {
                        self.kick::<false>(t)?;
                        self.kick = kick;
                        self.prepared.set_increments(part, dw);
                    }
                }
            }
        }
        // the next step has other increments
        if dw.is_empty() {
            return Ok(());
        }
        self.kick::<false>(t)
    }

    /// Makes a drift of a scene whose velocities are solved for, or that has an H₁.
    fn drift_with_drags(&mut self, motion: Motion, dw: &[f64]) -> Result<(), StepError> {
        let Prepared {
            sites,
            masses,
            rates,
            drags,
            ..
        } = &mut *self.prepared;
        let sites = sites.as_ref();
        let velocities = Velocities {
            sites,
            masses,
            rates,
        };
        drags.drift(self.scene, velocities, self.state, motion, dw)?;
        if self.is_tested {
            let Phase { q, p } = &*self.state;
            self.is_finite &= dispatch(AreFinite(S::Row::numbers(q)));
            self.is_finite &= dispatch(AreFinite(S::Row::numbers(p)));
        }
        Ok(())
    }

    /// Makes a step of the midpoint rule of length `h` with its node at the time `t`.
    fn midpoint(
        &mut self,
        [h, t]: [f64; 2],
        part: f64,
        dw: &[f64],
        start: f64,
    ) -> Result<(), StepError> {
        self.prepared.set_increments(part, dw);
        let Prepared {
            segments,
            masses,
            rates,
            buffers,
            of_kick,
            of_midpoint,
            ..
        } = &mut *self.prepared;
        self.scene.midpoint(MidpointStep {
            segments,
            masses,
            rates,
            buffers,
            work: of_midpoint,
            q: self.state.q,
            p: self.state.p,
            kick: Kick { h, t, dw: of_kick },
            start,
        })
    }

    /// Makes the kick that waits, with the drift before it; `start` is the time of the step, for
    /// messages.
    fn kick<const TWICE: bool>(&mut self, start: f64) -> Result<(), StepError> {
        let Some([h, _, t]) = self.kick.take() else {
            return Ok(());
        };
        self.sweep::<TWICE>([h, t])
            .map_err(|error| index_error(error, start))
    }

    fn sweep<const TWICE: bool>(&mut self, [h, t]: [f64; 2]) -> Result<(), IndexError> {
        if S::TOTALS > 0 {
            // the places of all sites
            self.drift_alone();
            let of_kick = &mut self.prepared.of_kick;
            of_kick.resize(of_kick.len() + S::TOTALS, 0.0);
            self.scene.totals(t, self.state.q, of_kick)?;
        }
        let Prepared {
            segments,
            masses,
            rates,
            buffers,
            of_kick: dw,
            ..
        } = &mut *self.prepared;
        self.is_finite &= dispatch(Sweep::<S, Impulses, TWICE> {
            scene: self.scene,
            segments,
            drift: self.drift.take().map(|(h, friction)| Drift {
                masses,
                rates,
                h,
                friction,
            }),
            kick: Kick { h, t, dw },
            q: self.state.q,
            p: self.state.p,
            buffers,
            is_tested: self.is_tested,
        })?;
        Ok(())
    }

    /// Makes the drift that waits.
    fn drift_alone(&mut self) {
        if let Some((h, friction)) = self.drift.take() {
            let Prepared { masses, rates, .. } = &*self.prepared;
            self.is_finite &= dispatch(DriftAlone {
                drift: Drift {
                    masses,
                    rates,
                    h,
                    friction,
                },
                q: self.state.q,
                p: self.state.p,
                is_tested: self.is_tested,
            });
        }
    }

    /// Makes what waits. Returns whether all numbers are finite, as far as they were tested.
    fn end(&mut self, t: f64) -> Result<bool, StepError> {
        self.kick::<false>(t)?;
        self.drift_alone();
        Ok(self.is_finite)
    }
}
