//! Drifts of scenes whose velocities are solved for, with a kinetic energy that is no sum of
//! `½ m v²`; with drags, forces that depend on velocities in another way than friction; and with
//! H₁.
//!
//! All forces of velocities act with the velocity v of the drift (`docs/mathematics.md`, section
//! 14). With the times a and b of the kicks before and after the drift, a friction N, drags D, and
//! `α = a ΔW/h`, `β = b ΔW/h`,
//!
//! ```text
//! p + a N v = p₀ + a D(q₀, v) − α ∂H₁/∂q(q₀, p),    p = ∂T/∂v(v)
//! q₁ = q₀ + h v + α ∂H₁/∂p(q₀, p) + β ∂H₁/∂p(q₁, p)
//! p₁ = p − b N v + b D(q₁, v) − β ∂H₁/∂q(q₁, p)
//! ```
//!
//! The first equation and the second one are of all sites. They are solved by fixed-point
//! iterations for D and the derivatives of H₁, which have to contract. If these and ∂T/∂v are
//! affine, an iteration that converges has one fixed point, and so has that of each smaller step:
//! the solution is connected with the limit of no noise and a short step.

use super::errors::index_error;
use super::kinetic::Sites;
use super::masses::InverseMasses;
use super::shear::Phase;
use super::{InDrift, Row, Scene};
use crate::error::StepError;
use crate::gauss::convergence::{Course, Verdict};

/// A drift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    /// The time of the motion.
    pub(super) h: f64,
    /// The times over which forces of velocities act before it and after it.
    pub(super) forced: [f64; 2],
    /// The fractions of the increments by which each H₁ acts before it and after it.
    pub(super) parts: [f64; 2],
    /// The times of its start and its end.
    pub(super) at: [f64; 2],
    /// The time of the start of the step, for messages.
    pub(super) start: f64,
}

/// The ratio of successive changes at which an iteration reaches rounding within its number of
/// sweeps.
const FACTOR: f64 = 0.15;

/// The data that determine the velocities of momenta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Velocities<'a> {
    pub(super) sites: Option<&'a Sites>,
    pub(super) masses: &'a InverseMasses,
    /// The friction of each component divided by its mass; empty without friction or masses.
    pub(super) rates: &'a [f64],
}

impl Velocities<'_> {
    /// Writes the velocities of the momenta `p + impulses`, with friction over the time `damped`.
    fn find<S: Scene>(
        &self,
        scene: &S,
        [q, p, impulses]: [&[S::Row]; 3],
        times: [f64; 2],
        damped: f64,
        v: &mut [S::Row],
    ) -> Result<(), StepError> {
        if let Some(sites) = self.sites {
            return sites.velocities(scene, [q, p, impulses], times, damped, v);
        }
        let momenta = S::Row::numbers(p).iter().zip(S::Row::numbers(impulses));
        let all = S::Row::numbers_mut(v).iter_mut().zip(momenta).enumerate();
        for (at, (v, (p, impulse))) in all {
            let rate = self.rates.get(at).copied().unwrap_or_default();
            *v = self.masses.of(at) * (p + impulse) / (1.0 + damped * rate);
        }
        Ok(())
    }

    fn has_friction(&self) -> bool {
        !self.rates.is_empty() || self.sites.is_some_and(Sites::has_friction)
    }

    /// Returns the friction of a component.
    fn friction(&self, at: usize) -> f64 {
        match self.sites {
            Some(sites) => sites.friction(at),
            None => (self.rates.get(at)).map_or(0.0, |rate| rate / self.masses.of(at)),
        }
    }
}

/// The arrays that such drifts need.
#[derive(Clone, Debug, Default)]
pub(super) struct Drags {
    /// The impulses of drags and H₁ before the drift.
    impulses: Vec<f64>,
    v: Vec<f64>,
    /// The momenta during the drift, ∂T/∂v.
    p: Vec<f64>,
    /// The displacements by the H₁ before the drift, and after it.
    shifts: [Vec<f64>; 2],
    /// The result.
    new: Vec<f64>,
    /// Increments, and totals.
    dw: Vec<f64>,
}

impl Drags {
    /// Returns the number of numbers.
    pub(super) fn len(&self) -> usize {
        let [before, after] = &self.shifts;
        let all = [&self.impulses, &self.v, &self.p, before, after, &self.new];
        all.iter().map(|array| array.len()).sum::<usize>() + self.dw.len()
    }

    /// Makes a drift. The state is changed also if it fails.
    ///
    /// # Errors
    /// An index that is out of range; a site for which no velocity has the momentum; an iteration
    /// that does not contract.
    pub(super) fn drift<S: Scene>(
        &mut self,
        scene: &S,
        velocities: Velocities<'_>,
        state: &mut Phase<'_, S::Row>,
        motion: Motion,
        dw: &[f64],
    ) -> Result<(), StepError> {
        let Phase { q, p } = state;
        let numbers = q.len() * S::Row::LENGTH;
        let [before, after] = &mut self.shifts;
        for array in [&mut self.impulses, &mut self.v, &mut self.p, before, after] {
            array.clear();
            array.resize(numbers, 0.0);
        }
        let step = DriftOf {
            scene,
            velocities,
            motion,
            dw,
        };
        self.solve(step, [&**q, &**p])?;
        self.move_sites(step, q)?;
        let after = motion.forced[1];
        let all = S::Row::numbers_mut(p).iter_mut().enumerate();
        for ((at, p), (v, momentum)) in all.zip(self.v.iter().zip(&self.p)) {
            *p = momentum - after * velocities.friction(at) * v;
        }
        if S::HAS_DRAGS && after != 0.0 || S::HAS_H1 && motion.parts[1] != 0.0 {
            self.compute(step, q, 1, &IMPULSES)?;
            let kicked = S::Row::numbers_mut(p).iter_mut();
            for (p, impulse) in kicked.zip(&self.new) {
                *p += impulse;
            }
        }
        Ok(())
    }

    /// Finds the velocities and momenta of the drift, and the impulses before it.
    fn solve<S: Scene>(
        &mut self,
        step: DriftOf<'_, S>,
        [q, p]: [&[S::Row]; 2],
    ) -> Result<(), StepError> {
        let DriftOf {
            scene,
            velocities,
            motion,
            ..
        } = step;
        let (before, times) = (motion.forced[0], [motion.at[0], motion.h]);
        let has_impulses = S::HAS_DRAGS && before != 0.0 || S::HAS_H1 && motion.parts[0] != 0.0;
        let (mut progress, mut is_solved) = (Progress::new::<S>(motion), !has_impulses);
        loop {
            let momenta = [q, p, &*S::Row::rows_mut(&mut self.impulses)];
            let v = S::Row::rows_mut(&mut self.v);
            velocities.find(scene, momenta, times, before, v)?;
            let all = self.p.iter_mut().zip(S::Row::numbers(p)).enumerate();
            for (at, (momentum, p)) in all {
                let friction = before * velocities.friction(at);
                *momentum = (p + self.impulses[at]) - friction * self.v[at];
            }
            if is_solved {
                return Ok(());
            }
            self.compute(step, q, 0, &IMPULSES)?;
            let change = change::<S::Row>([&self.impulses, &self.new], S::Row::numbers(p));
            core::mem::swap(&mut self.impulses, &mut self.new);
            let has_friction = before != 0.0 && velocities.has_friction();
            is_solved = progress.judge(change, has_friction)?;
        }
    }

    /// Moves the sites: `q₁ = q₀ + h v + α ∂H₁/∂p(q₀, p) + β ∂H₁/∂p(q₁, p)`.
    fn move_sites<S: Scene>(
        &mut self,
        step: DriftOf<'_, S>,
        q: &mut [S::Row],
    ) -> Result<(), StepError> {
        let Motion { h, parts, .. } = step.motion;
        if S::HAS_H1 && parts[0] != 0.0 {
            self.compute(step, q, 0, &[InDrift::Shifts])?;
            core::mem::swap(&mut self.shifts[0], &mut self.new);
        }
        let moved = S::Row::numbers_mut(q).iter_mut();
        for (q, (v, shift)) in moved.zip(self.v.iter().zip(&self.shifts[0])) {
            *q += h * v + shift;
        }
        if !S::HAS_H1 || parts[1] == 0.0 {
            return Ok(());
        }
        // without the displacement that depends on the end
        self.impulses.clear();
        self.impulses.extend_from_slice(S::Row::numbers(q));
        let (mut progress, mut is_solved) = (Progress::new::<S>(step.motion), false);
        while !is_solved {
            self.compute(step, q, 1, &[InDrift::Shifts])?;
            let change = change::<S::Row>([&self.shifts[1], &self.new], &self.impulses);
            core::mem::swap(&mut self.shifts[1], &mut self.new);
            let moved = S::Row::numbers_mut(q).iter_mut();
            for (q, (from, shift)) in moved.zip(self.impulses.iter().zip(&self.shifts[1])) {
                *q = from + shift;
            }
            is_solved = progress.judge(change, false)?;
        }
        Ok(())
    }

    /// Computes the sum of some parts on a side of the drift, in `new`.
    fn compute<S: Scene>(
        &mut self,
        step: DriftOf<'_, S>,
        q: &[S::Row],
        side: usize,
        sum: &[InDrift],
    ) -> Result<(), StepError> {
        let Motion {
            forced,
            parts,
            at,
            start,
            ..
        } = step.motion;
        let (h, t) = (forced[side], at[side]);
        let index = |error| index_error(error, start);
        self.dw.clear();
        self.dw.extend(step.dw.iter().map(|dw| parts[side] * dw));
        if S::TOTALS > 0 {
            self.dw.resize(step.dw.len() + S::TOTALS, 0.0);
            step.scene.totals(t, q, &mut self.dw).map_err(index)?;
        }
        self.new.clear();
        self.new.resize(self.v.len(), 0.0);
        let to = S::Row::rows_mut(&mut self.new);
        for &part in sum {
            let of = match part {
                InDrift::Drags => &mut self.v,
                InDrift::Kicks | InDrift::Shifts => &mut self.p,
            };
            let of = S::Row::rows_mut(of);
            let added = step.scene.in_drift(part, h, t, &self.dw, q, of, to);
            added.map_err(index)?;
        }
        Ok(())
    }
}

/// The impulses in a drift.
const IMPULSES: [InDrift; 2] = [InDrift::Drags, InDrift::Kicks];

/// The data that a drift reads beside the state.
#[derive(Debug)]
struct DriftOf<'a, S> {
    scene: &'a S,
    velocities: Velocities<'a>,
    motion: Motion,
    /// The increments of the step.
    dw: &'a [f64],
}

impl<S> Clone for DriftOf<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for DriftOf<'_, S> {}

/// The course of an iteration.
struct Progress {
    course: Course,
    last: f64,
    motion: Motion,
    has_h1: bool,
}

impl Progress {
    fn new<S: Scene>(motion: Motion) -> Self {
        Self {
            course: Course::new(),
            last: f64::INFINITY,
            motion,
            has_h1: S::HAS_H1,
        }
    }

    /// Returns whether the iteration has converged with this change. Numbers that are not finite
    /// end it too: they are found at the end of the step. `is_damped` is true if there is friction,
    /// which the iteration solves exactly.
    fn judge(&mut self, change: f64, is_damped: bool) -> Result<bool, StepError> {
        let ratio = change / self.last;
        self.last = change;
        match self.course.judge(change) {
            _ if !change.is_finite() => Ok(true),
            Verdict::Leave => Err(self.contraction(ratio, is_damped)),
            verdict => Ok(verdict == Verdict::Converged),
        }
    }

    #[cold]
    fn contraction(&self, ratio: f64, is_damped: bool) -> StepError {
        let Motion { h, start, .. } = self.motion;
        // x or, with friction of the same strength, x/(1 + x), with x in proportion to h
        let damped = if is_damped { (1.0 - ratio).abs() } else { 1.0 };
        let part = FACTOR / ratio * damped.min(1.0);
        // increments are in proportion to the square root of h
        let part = if self.has_h1 { part * part } else { part };
        StepError::Contraction {
            t: start,
            h,
            ratio,
            wanted: h.abs() * part.min(0.5),
        }
    }
}

/// Returns the largest change of numbers from `old` to `new`, relative to the largest of the
/// numbers `of` and the new ones in the same component of any site; NaN if a number is NaN.
fn change<R: Row>([old, new]: [&[f64]; 2], of: &[f64]) -> f64 {
    let mut largest = 0.0;
    for component in 0..R::LENGTH {
        let (mut size, mut change) = (f64::MIN_POSITIVE, 0.0);
        for at in (component..old.len()).step_by(R::LENGTH) {
            size = f64::max(size, of[at].abs() + new[at].abs());
            change = larger((new[at] - old[at]).abs(), change);
        }
        largest = larger(change / size, largest);
    }
    largest
}

/// Returns the larger number; NaN if one is NaN.
fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}
