//! The solution of a step that is connected with no noise and h → 0.
//!
//! Input: a step that the fast path did not solve. Output: the step, or how far its solution can be followed.
//! Invariant: each point is reached from the last by contracting updates (see [`newton`](crate::newton)) that end near the
//! point extrapolated from the earlier ones, within the domain of L.
//!
//! The path is that of the definition. It starts where all is known: for h = 0 and no noise v is the velocity of p₀
//! ([`legendre`](crate::legendre)) and nothing moves. It goes to `h` without noise, then to the increments `ΔW` at
//! that `h`, along `s ΔW`. A stride that fails is halved; a fold, where the solution turns back, ends the path.
//! Nothing is allocated.
//!
//! Source: Allgower, Georg, *Introduction to Numerical Continuation Methods* (2003), chapter 2 and, for the choice of strides,
//! chapter 6; without its turns around folds.

use crate::Integrator;
use crate::configuration::Coordinates;
use crate::legendre;
use crate::mechanics;
use crate::newton::{SolveError, Solver};
use crate::state::State;
use crate::system::{Dims, StepOf, System, Variational};

/// The smallest stride, relative to the part of the path that has been made, or to all of it at its start.
const SMALLEST: f64 = 1e-7;

/// The largest stride. A contracting iteration can leap between solutions where the equations have many; the shorter the stride, the
/// fewer lie between its ends.
const LARGEST: f64 = 0.125;

/// The first stride, which has no extrapolation to be compared with.
const FIRST: f64 = 1.0 / 64.0;

/// Points tried on a path. Halving down to the smallest stride and doubling up to the largest again takes some 50; a rapidly
/// oscillating force takes some ten a period.
const POINTS: u32 = 4000;

/// Largest distance between the extrapolated and the solved point, in distances from the last point.
const CURVED: f64 = 0.25;

/// Ratio of a stride to the last one below which no extrapolation is made.
const RENEWED: f64 = 1.0 / 16.0;

/// Relative error of an increment: far above that of an ill-conditioned step, far below the distance of two solutions that a
/// stride could confuse.
const INEXACT: f64 = 1e-8;

/// Increments that are smaller than those of other coordinates by this factor may be all rounding.
const SMALL: f64 = 1e-5;

/// Error of an increment relative to the largest coordinate: forces are differences of coordinates.
const ROUNDING: f64 = 1e-12;

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lost {
    /// There is nothing to follow: the momentum at the start has no velocity.
    NoStart(SolveError),
    /// The path ends.
    Ends {
        /// The part of the step size up to which the solution was followed without noise.
        step: f64,
        /// The part of the increments up to which it was followed at the whole step size.
        noise: f64,
    },
}

/// Follows the solution of a step.
#[cold]
pub(crate) fn follow<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    state: &State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> Result<StepOf<S, R>, Lost>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let system = integrator.system();
    let numbers = state.q.iter().chain(&state.p).chain(dw);
    if !numbers.chain([&state.t]).all(|x| x.is_finite()) {
        return Err(Lost::NoStart(SolveError::NonFinite));
    }
    let velocity = legendre::velocity(system, state).map_err(Lost::NoStart)?;
    let motion = mechanics::solve_motion(system, state, velocity);
    let acceleration = motion.map_or([0.0; N], |motion| motion.second.q);
    let start = Point {
        at: 0.0,
        q: [0.0; N],
        p: [0.0; N],
        x: system.start(state, &velocity, &acceleration),
    };
    let scale = Scale {
        q: &state.q,
        p: &state.p,
    };
    let step = |part: f64, noise: f64, guesses: &S::Unknowns| {
        let h = part * h;
        let solver = Solver::following(integrator.newton(), guesses.as_ref());
        let dw = dw.map(|w| noise * w);
        system.increment(&system.prepare(h), state, h, &dw, &solver)
    };
    let mut end = path(start, scale, |part, x| step(part, 0.0, x))
        .map_err(|step| Lost::Ends { step, noise: 0.0 })?;
    if dw.iter().any(|&w| w != 0.0) {
        end = path(Point { at: 0.0, ..end }, scale, |noise, x| {
            step(1.0, noise, x)
        })
        .map_err(|noise| Lost::Ends { step: 1.0, noise })?;
    }
    Ok((end.q, end.p, end.x))
}

/// A point of a path.
#[derive(Clone, Copy)]
struct Point<const N: usize, X> {
    /// The part of the path before it.
    at: f64,
    /// `q₁ − q₀` and `p₁ − p₀`.
    q: [f64; N],
    p: [f64; N],
    /// What the blocks were solved for.
    x: X,
}

/// Configuration and momentum at the start of the step: their rounding is that of the increments.
#[derive(Clone, Copy)]
struct Scale<'a, const N: usize> {
    q: &'a [f64; N],
    p: &'a [f64; N],
}

/// Goes from a point at 0 to 1; or where the path ends instead.
fn path<const N: usize, X: Copy + AsRef<[f64]> + AsMut<[f64]>>(
    start: Point<N, X>,
    scale: Scale<'_, N>,
    solve: impl Fn(f64, &X) -> Result<([f64; N], [f64; N], X), SolveError>,
) -> Result<Point<N, X>, f64> {
    let mut here = start;
    let mut before: Option<Point<N, X>> = None;
    let mut stride: f64 = FIRST;
    for _ in 0..POINTS {
        // the last stride ends at 1, whatever the rounding
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
            Some(found) if before.is_none() || found.is_near(&ahead, &here, &start, scale) => {
                if there >= 1.0 {
                    return Ok(found);
                }
                before = Some(here);
                here = found;
                stride = (2.0 * stride).min(LARGEST);
            }
            _ => {
                stride = 0.5 * stride.min(1.0 - here.at);
                if stride < SMALLEST * if here.at > 0.0 { here.at } else { FIRST } {
                    break;
                }
                // a line through points far apart says nothing of a stride that is short beside their distance
                before = before.filter(|before| stride >= RENEWED * (here.at - before.at));
            }
        }
    }
    Err(here.at)
}

impl<const N: usize, X: Copy + AsRef<[f64]> + AsMut<[f64]>> Point<N, X> {
    /// The point at `there` on the line from `before` through this one.
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

    /// Whether the state here is near the extrapolated one, compared with its distance from the last point. The coordinates of
    /// the state are compared, not the unknowns, some of which are multipliers without a size of their own.
    fn is_near(&self, ahead: &Self, last: &Self, start: &Self, scale: Scale<'_, N>) -> bool {
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
                let rounding = ROUNDING * size + INEXACT * unit;
                error = error.max(((to - guess).abs() - rounding) / unit);
                distance = distance.max((to - from).abs() / unit);
            }
        };
        let size = |x: &[f64; N]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let (size_q, size_p) = (size(scale.q), size(scale.p));
        for i in 0..N {
            let q = [self.q[i], ahead.q[i], last.q[i], start.q[i]];
            let p = [self.p[i], ahead.p[i], last.p[i], start.p[i]];
            compare(q, size_q, largest_q);
            compare(p, size_p, largest_p);
        }
        error <= CURVED * distance
    }
}
