//! Continuation: follows the solution of a step from the limit of no noise and h → 0.
//!
//! Input: a step that the fast path did not solve. Output: the step, or the fraction of the path
//! along which its solution can be followed. Invariant: each point is reached from the point before
//! by contracting updates (see [`newton`](crate::solve::newton)) that end near the point
//! extrapolated from the earlier points, within the domain of L.
//!
//! The path is the path of the definition (`docs/mathematics.md`, section 6). It starts at the
//! known limit: for h = 0 and no noise v is the velocity of p₀ ([`legendre`](crate::legendre)) and
//! nothing moves. First the step size grows to `h` without noise, then the increments grow to `ΔW`
//! at that `h`, along `s ΔW`. A stride that fails is halved. A fold, where the solution turns back,
//! ends the path. Nothing is allocated, but for systems with constraints, whose gradients are
//! compared with the gradients at the start at each point.
//!
//! Source: Allgower, Georg, *Introduction to Numerical Continuation Methods* (2003), chapter 2 and,
//! for the choice of strides, chapter 6. Paths are not followed around folds.

use super::accept::all_finite;
use crate::mechanics;
use crate::mechanics::constraints::fold::Fold;
use crate::mechanics::legendre;
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::rule::Walker;
use crate::solve::SolveError;
use crate::solve::newton::BlockSolver;
use crate::system::equations::Memory;
use crate::system::equations::{StepEquations, StepOf};
use crate::system::{AnyIncrements as _, Dims, System};

/// Smallest stride, relative to the part of the path behind it; at the start relative to the first
/// stride.
const SMALLEST: f64 = 1e-7;

/// Largest stride. If the equations have many solutions, a contracting iteration can jump to
/// another one; the shorter the stride, the fewer solutions are near.
const LARGEST: f64 = 0.125;

/// First stride. There is no extrapolation to compare its end with.
const FIRST: f64 = 1.0 / 64.0;

/// Largest number of points tried on a path. Halving down to the smallest stride and doubling up to
/// the largest takes some 50; a rapidly oscillating force takes some ten points a period.
const MAX_POINTS: u32 = 4000;

/// Largest distance between the extrapolated and the solved point, relative to the distance from
/// the last point.
const MAX_DEVIATION: f64 = 0.25;

/// Ratio of a stride to the last one below which there is no extrapolation.
const SHORTEST_EXTRAPOLATION: f64 = 1.0 / 16.0;

/// Relative error allowed for an increment: far above the error of an ill-conditioned step, far
/// below the distance of two solutions that a stride could confuse.
const INCREMENT_ERROR: f64 = 1e-8;

/// Increments that are smaller than the increments of other coordinates by this factor can be
/// rounding error.
const SMALL: f64 = 1e-5;

/// Error allowed for an increment relative to the largest coordinate: forces depend on differences
/// of coordinates.
const ROUNDING: f64 = 1e-12;

/// The reason why continuation found no solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ContinuationError {
    /// The momentum at the start has no velocity.
    NoStart(SolveError),
    /// The path ends.
    PathEnds {
        /// Fraction of the step size up to which the solution was followed without noise.
        step: f64,
        /// Fraction of the increments up to which the solution was followed at the whole step size.
        noise: f64,
    },
    /// The path passes near a fold of the constraints.
    NearFold {
        /// Fraction of the step size there.
        step: f64,
        /// Fraction of the increments.
        noise: f64,
        /// The size of the gradients of the constraints there, relative to the start, see [`Fold`].
        part: f64,
    },
}

/// Follows the solution of a step.
///
/// # Errors
/// A [`ContinuationError`] if the path cannot start, or ends before the whole step.
#[cold]
pub(super) fn follow<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
    state: &State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Result<StepOf<S, R>, ContinuationError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let system = walker.system;
    // The sum is finite only if all numbers are; finite numbers whose sum overflows are recognised
    // too.
    let has_state =
        state.q.sum_with(&state.p).is_finite() || all_finite(&state.q.values(), &state.p);
    let mut others = dw.as_ref().iter().chain([&state.t]);
    if !has_state || !others.all(|x| x.is_finite()) {
        return Err(ContinuationError::NoStart(SolveError::NonFinite));
    }
    let velocity = legendre::velocity(system, state).map_err(ContinuationError::NoStart)?;
    let motion = mechanics::solve_motion(system, state, velocity);
    let acceleration = motion.map_or([0.0; N], |motion| motion.second.q);
    let start = Point {
        at: 0.0,
        q: [0.0; N],
        p: [0.0; N],
        x: system.start(state, &velocity, &acceleration),
    };
    let at_whole_step = Scale::of(system, state, &velocity, h);
    let step = |part: f64, noise: f64, guesses: &S::Unknowns| {
        let h = part * h;
        let solver = BlockSolver::warm_started(walker.newton, guesses.as_ref());
        let dw = dw.times(noise);
        let memory = &mut S::Memory::none();
        system.increment(&system.prepare(h), memory, state, h, &dw, &solver)
    };
    let fold = Fold::from(system, state.t, &state.q);
    let meets_fold = |part: f64, q: &[f64; N]| {
        let (there, _) = Q::Flat::moved(state, q, &[0.0; N]);
        fold.as_ref()?.met_at(system, state.t + part * h, &there)
    };
    let mut end = follow_path(
        start,
        FIRST,
        |part| at_whole_step.of_part(part),
        |part, x| step(part, 0.0, x),
        meets_fold,
    )
    .map_err(End::in_step)?;
    if dw.as_ref().iter().any(|&w| w != 0.0) {
        // a stride must not jump over a pole
        let reach = mechanics::reach_of_noise(system, state, dw.as_ref());
        end = follow_path(
            Point { at: 0.0, ..end },
            FIRST / reach.max(1.0),
            |_| at_whole_step,
            |noise, x| step(1.0, noise, x),
            |_, q| meets_fold(1.0, q),
        )
        .map_err(End::in_noise)?;
    }
    Ok((end.q, end.p, end.x))
}

/// A point of a path.
#[derive(Clone, Copy)]
struct Point<const N: usize, X> {
    /// Fraction of the path before the point.
    at: f64,
    /// `q₁ − q₀` and `p₁ − p₀`.
    q: [f64; N],
    p: [f64; N],
    /// The unknowns of the blocks.
    x: X,
}

/// Magnitudes that bound the rounding errors of the increments.
#[derive(Clone, Copy)]
struct Scale {
    /// Largest magnitudes of configuration and momentum at the start of the step.
    q: f64,
    p: f64,
    /// Largest momentum with which the configuration moves by its own size in the step, if
    /// constraints solve for momenta: impulses that hold the configuration on the constraints have
    /// the rounding errors of the configuration, divided by the step size.
    impulse: f64,
}

impl Scale {
    fn of<S, Q, const N: usize, const M: usize>(
        system: &S,
        state: &State<Q::Flat>,
        velocity: &[f64; N],
        h: f64,
    ) -> Self
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: Coordinates<N>,
    {
        let q = state.q.size();
        let impulse = if S::CONSTRAINTS.is_empty() {
            0.0
        } else {
            let mass = system.lagrangian_jet(state.t, &state.q, velocity).dvv;
            let rows = mass.iter().map(|row| row.iter().map(|m| m.abs()).sum());
            rows.fold(0.0, f64::max) * q / h.abs()
        };
        let p = state.p.size();
        Self { q, p, impulse }
    }

    /// Returns the magnitudes of a step with a part of the step size.
    fn of_part(self, part: f64) -> Self {
        let impulse = self.impulse / part;
        Self { impulse, ..self }
    }
}

/// The point before 1 at which a path ends.
struct End {
    at: f64,
    /// The size of the gradients of the constraints relative to the start, if the path ends near a
    /// fold.
    fold: Option<f64>,
}

impl End {
    /// Returns the error on the path of the step size.
    fn in_step(self) -> ContinuationError {
        let (step, noise) = (self.at, 0.0);
        match self.fold {
            Some(part) => ContinuationError::NearFold { step, noise, part },
            None => ContinuationError::PathEnds { step, noise },
        }
    }

    /// Returns the error on the path of the noise.
    fn in_noise(self) -> ContinuationError {
        let (step, noise) = (1.0, self.at);
        match self.fold {
            Some(part) => ContinuationError::NearFold { step, noise, part },
            None => ContinuationError::PathEnds { step, noise },
        }
    }
}

/// Follows a path from a point at 0 to 1, with a first stride. Returns its end. `meets_fold` gets
/// each point.
///
/// # Errors
/// The [`End`] before 1.
fn follow_path<const N: usize, X: Copy + AsRef<[f64]> + AsMut<[f64]>>(
    start: Point<N, X>,
    first: f64,
    scale: impl Fn(f64) -> Scale,
    solve: impl Fn(f64, &X) -> Result<([f64; N], [f64; N], X), SolveError>,
    meets_fold: impl Fn(f64, &[f64; N]) -> Option<f64>,
) -> Result<Point<N, X>, End> {
    let mut here = start;
    let mut before: Option<Point<N, X>> = None;
    let mut stride: f64 = first;
    for _ in 0..MAX_POINTS {
        // The last stride ends at 1 exactly.
        let there = if stride >= 1.0 - here.at {
            1.0
        } else {
            here.at + stride
        };
        let ahead = before.map_or(here, |before| here.extrapolated(&before, there));
        let found = solve(there, &ahead.x)
            .ok()
            .map(|(q, p, x)| Point { at: there, q, p, x });
        match found {
            Some(found)
                if before.is_none() || found.is_near(&ahead, &here, &start, scale(there)) =>
            {
                if let Some(part) = meets_fold(there, &found.q) {
                    let fold = Some(part);
                    return Err(End { at: there, fold });
                }
                if there >= 1.0 {
                    return Ok(found);
                }
                before = Some(here);
                here = found;
                stride = (2.0 * stride).min(LARGEST);
            }
            _ => {
                stride = 0.5 * stride.min(1.0 - here.at);
                if stride < SMALLEST * if here.at > 0.0 { here.at } else { first } {
                    break;
                }
                // A line through points that are far apart does not predict the end of a much
                // shorter stride.
                before = before
                    .filter(|before| stride >= SHORTEST_EXTRAPOLATION * (here.at - before.at));
            }
        }
    }
    Err(End {
        at: here.at,
        fold: None,
    })
}

impl<const N: usize, X: Copy + AsRef<[f64]> + AsMut<[f64]>> Point<N, X> {
    /// Returns the point at `there` on the line from `before` through this point.
    fn extrapolated(&self, before: &Self, there: f64) -> Self {
        let ratio = (there - self.at) / (self.at - before.at);
        let mut ahead = *self;
        for i in 0..N {
            ahead.q[i] += ratio * (self.q[i] - before.q[i]);
            ahead.p[i] += ratio * (self.p[i] - before.p[i]);
        }
        for (x, y) in ahead.x.as_mut().iter_mut().zip(before.x.as_ref()) {
            *x += ratio * (*x - y);
        }
        ahead
    }

    /// Returns whether the state here is near the extrapolated one, relative to its distance from
    /// the last point. The coordinates of the state are compared. The unknowns are not: some are
    /// multipliers, which have no natural scale.
    fn is_near(&self, ahead: &Self, last: &Self, start: &Self, scale: Scale) -> bool {
        let reach = |to: &[f64; N], from: &[f64; N], first: &[f64; N]| {
            let each = (0..N).map(|i| (to[i] - first[i]).abs().max((from[i] - first[i]).abs()));
            each.fold(0.0, f64::max)
        };
        let largest_q = reach(&self.q, &last.q, &start.q);
        let largest_p = reach(&self.p, &last.p, &start.p);
        let (mut error, mut distance): (f64, f64) = (0.0, 0.0);
        let mut compare = |[to, guess, from, first]: [f64; 4], size: f64, largest: f64| {
            let unit = (to - first).abs().max((from - first).abs());
            let unit = unit.max(SMALL * largest);
            if unit > 0.0 {
                let rounding = ROUNDING * size + INCREMENT_ERROR * unit;
                error = error.max(((to - guess).abs() - rounding) / unit);
                distance = distance.max((to - from).abs() / unit);
            }
        };
        let (size_q, size_p) = (scale.q, scale.p.max(scale.impulse));
        for i in 0..N {
            let q = [self.q[i], ahead.q[i], last.q[i], start.q[i]];
            let p = [self.p[i], ahead.p[i], last.p[i], start.p[i]];
            compare(q, size_q, largest_q);
            compare(p, size_p, largest_p);
        }
        error <= MAX_DEVIATION * distance
    }
}
