//! Steps that are shears: kicks, which change the momenta at fixed places, and drifts, which change
//! the places at fixed momenta.
//!
//! A shear is made in place and needs no second state. A number that is not finite stays so in all
//! later shears. Therefore, many steps without noise are made in blocks: the state is copied, the
//! steps are made without tests, and the result is tested. If it is not finite, the steps are
//! repeated from the copy with a test each, so that the step that fails is known, and the state
//! before it is restored.

use super::drag::Drags;
use super::drift::AreFinite;
use super::errors::{check_forces, index_error};
use super::kinetic::Sites;
use super::masses::InverseMasses;
use super::segments::Segments;
use super::single::Copied;
use super::steps::{Increments, Steps};
use super::sweep::Buffers;
use super::work::{MidpointSolution, Work};
use super::{Layout, Row, Scene};
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

/// The facts about a scene for a number of sites, and the arrays that its steps need.
#[derive(Clone, Debug)]
pub struct Prepared {
    n: usize,
    processes: usize,
    pub(super) segments: Segments,
    /// The kinetic energies of sites that have no masses of components.
    pub(super) sites: Option<Sites>,
    pub(super) masses: InverseMasses,
    pub(super) drags: Drags,
    /// The friction of each component divided by its mass; empty without friction.
    pub(super) rates: Vec<f64>,
    pub(super) buffers: Buffers,
    /// The places and the momenta before a step or block, empty until a step needs a copy of them.
    before: [Vec<f64>; 2],
    /// The increments of a kick, and of the one after it if both are one sweep. Empty for the
    /// increments of the step as they are.
    pub(super) of_kicks: [Vec<f64>; 2],
    pub(super) of_midpoint: Work,
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
            before: [Vec::new(), Vec::new()],
            of_kicks: [Vec::new(), Vec::new()],
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

    /// Returns what is known about the loops. The copies that a single step needs count, also
    /// before the first one.
    pub fn layout<S: Scene>(&self, shears: &[StepShear]) -> Layout {
        let masses = match &self.masses {
            InverseMasses::Uniform(_) => 0,
            InverseMasses::Each(inverse) => inverse.len(),
        };
        let copies = match self.needed::<S>(shears, false) {
            Copied::All => 2,
            Copied::Momenta => 1,
            Copied::Nothing => 0,
        };
        let kept: usize = self.before.iter().map(Vec::len).sum();
        let numbers = masses
            + self.rates.len()
            + self.sites.as_ref().map_or(0, Sites::len)
            + self.drags.len()
            + self.buffers.len()
            + kept.max(copies * self.n * S::Row::LENGTH)
            + self.of_kicks.iter().map(Vec::len).sum::<usize>()
            + self.of_midpoint.len();
        Layout::new::<S>(self.n, &self.segments, numbers * size_of::<f64>())
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
        self.keep(state, Copied::All);
        let result = dispatch(Steps {
            scene,
            prepared: self,
            state: state.part(usize::MAX),
            shears,
            t: *t,
            increments: Increments::Drawn { dw, count, draw },
            is_tested: false,
            pieces: usize::MAX,
        });
        let is_finite = |rows: &[S::Row]| dispatch(AreFinite(S::Row::numbers(rows)));
        if let Ok((made, end)) = result
            && is_finite(state.q)
            && is_finite(state.p)
        {
            *t = end;
            return made;
        }
        self.restore(state, Copied::All);
        0
    }

    /// Makes a step from a copy of a state, without noise. Returns how its equations were solved;
    /// `None` for explicit steps, which are not made.
    ///
    /// # Errors
    /// The error of the step.
    pub fn solved<S: Scene>(
        &mut self,
        scene: &S,
        shears: &[StepShear],
        [q, p]: [&mut [S::Row]; 2],
        times: [f64; 2],
    ) -> Result<Option<MidpointSolution>, StepError> {
        if !shears
            .iter()
            .any(|shear| matches!(shear, StepShear::Midpoint { .. }))
        {
            return Ok(None);
        }
        let dw = vec![0.0; self.processes];
        self.step(scene, shears, &mut Phase { q, p }, times, &dw, true)?;
        Ok(Some(self.of_midpoint.solved))
    }

    /// Sets the increments of a kick, or of the one after it, to a part of those of a step.
    pub(super) fn set_increments(&mut self, kick: usize, part: f64, dw: &[f64]) {
        let of_kick = &mut self.of_kicks[kick];
        of_kick.clear();
        of_kick.extend(dw.iter().map(|dw| part * dw));
    }

    pub(super) fn keep<R: Row>(&mut self, state: &Phase<'_, R>, copied: Copied) {
        let [q, p] = &mut self.before;
        if copied == Copied::All {
            copy(q, R::numbers(state.q));
        }
        if copied != Copied::Nothing {
            copy(p, R::numbers(state.p));
        }
    }

    #[cold]
    pub(super) fn restore<R: Row>(&self, state: &mut Phase<'_, R>, copied: Copied) {
        if copied == Copied::All {
            R::numbers_mut(state.q).copy_from_slice(&self.before[0]);
        }
        if copied != Copied::Nothing {
            R::numbers_mut(state.p).copy_from_slice(&self.before[1]);
        }
    }
}

/// Copies numbers. Allocates for the first ones only.
fn copy(to: &mut Vec<f64>, numbers: &[f64]) {
    to.clear();
    to.extend_from_slice(numbers);
}

impl<R> Phase<'_, R> {
    /// Returns the first nodes.
    pub(super) fn part(&mut self, nodes: usize) -> Phase<'_, R> {
        let nodes = nodes.min(self.q.len());
        Phase {
            q: &mut self.q[..nodes],
            p: &mut self.p[..nodes],
        }
    }
}
