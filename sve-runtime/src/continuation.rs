//! The solution of a step that is connected with the one without noise, and that with the one for h → 0.
//!
//! Input: a step whose equations were not solved in the usual course. Output: the step, or how far its solution can be followed.
//! Invariant: each point of the way is reached from the last by a calm iteration (see [`newton`](crate::newton)).
//!
//! The way is that of the definition: from small steps to `h` without noise, then from no noise to the increments `ΔW` at
//! that `h`, along `s ΔW`. Guesses are extrapolated from the last two points; where one fails, the stride is halved.
//! A fold, where the solution turns back, ends the way.
//!
//! Source: Allgower, Georg, *Introduction to Numerical Continuation Methods* (2003), chapter 2; without its turns around folds.

use crate::Integrator;
use crate::newton::{SolveError, Solver, Tape};
use crate::state::State;
use crate::system::{Dims, StepOf, System, Variational};

/// The smallest part of a way that is tried, of where it stands or of all of it.
const SMALLEST: f64 = 1e-7;

/// The largest part of a way that is made at once. A calm iteration can leap where the equations have many folds; the
/// shorter the stride, the fewer it has between its ends.
const LARGEST: f64 = 0.125;

/// Points tried on a way. Halving down to the smallest stride and doubling up to the largest again takes some 50.
const POINTS: u32 = 400;

/// How far a solution was followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lost {
    /// The part of the increments up to which it exists.
    pub(crate) noise: f64,
}

/// Follows the solution of a step; the error only where it exists without noise.
#[cold]
pub(crate) fn follow<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    state: &State<N>,
    h: f64,
    dw: &[f64; M],
) -> Option<Result<StepOf<S, R>, Lost>>
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let numbers = state.q.iter().chain(&state.p).chain(dw);
    if !numbers.chain([&state.t]).all(|x| x.is_finite()) {
        return None;
    }
    let system = integrator.system();
    let step = |part: f64, noise: f64, guesses: &[f64]| {
        let h = part * h;
        let tape = Tape::new(guesses.to_vec());
        let solver = Solver::following(integrator.newton(), &tape);
        let found = system.increment(
            &system.prepare(h),
            state,
            h,
            &dw.map(|w| noise * w),
            &solver,
        );
        found.map(|found| (found, tape.into_found()))
    };
    let still = without_noise(|part, guesses| step(part, 0.0, guesses))?;
    let mut last = None;
    let noisy = way((0.0, still), |noise, guesses| {
        let (found, unknowns) = step(1.0, noise, guesses)?;
        last = Some(found);
        Ok(unknowns)
    });
    Some(match (noisy, last) {
        (Ok(_), Some(found)) => Ok(found),
        (Ok(_), None) => return None,
        (Err(noise), _) => Err(Lost { noise }),
    })
}

/// The unknowns of the whole step without noise, followed from a part of it that is solved from its own guess.
fn without_noise<T>(
    step: impl Fn(f64, &[f64]) -> Result<(T, Vec<f64>), SolveError>,
) -> Option<Vec<f64>> {
    let mut part = 1.0;
    while part >= SMALLEST {
        if let Ok((_, found)) = step(part, &[]) {
            let all = way((part, found), |part, guesses| Ok(step(part, guesses)?.1));
            return all.ok();
        }
        part *= 0.5;
    }
    None
}

/// Goes from a place and its unknowns to 1; where it ends instead.
fn way(
    from: (f64, Vec<f64>),
    mut solve: impl FnMut(f64, &[f64]) -> Result<Vec<f64>, SolveError>,
) -> Result<Vec<f64>, f64> {
    let (mut here, mut unknowns) = from;
    let mut before: Option<(f64, Vec<f64>)> = None;
    let mut stride = LARGEST;
    for _ in 0..POINTS {
        if here >= 1.0 {
            return Ok(unknowns);
        }
        // the last stride ends at 1, whatever the rounding
        let there = if stride >= 1.0 - here {
            1.0
        } else {
            here + stride
        };
        let guesses = match &before {
            None => unknowns.clone(),
            Some((past, earlier)) => {
                let ratio = (there - here) / (here - past);
                let pairs = unknowns.iter().zip(earlier);
                pairs.map(|(x, y)| x + ratio * (x - y)).collect()
            }
        };
        match solve(there, &guesses) {
            Ok(found) => {
                before = Some((here, std::mem::replace(&mut unknowns, found)));
                here = there;
                stride = (2.0 * stride).min(LARGEST);
            }
            Err(_) => {
                stride = 0.5 * stride.min(1.0 - here);
                if stride < SMALLEST * if here > 0.0 { here } else { 1.0 } {
                    break;
                }
            }
        }
    }
    Err(here)
}
