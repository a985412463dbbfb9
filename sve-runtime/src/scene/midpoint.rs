//! Steps of the midpoint rule, whose equations join all sites.
//!
//! With the displacement d = q₁ − q₀, the impulse I at the node q₀ + d/2, masses M and friction N, a
//! step is
//!
//! ```text
//! d = f (p₀ + I/2),   f = h (M + h N/2)⁻¹,   p₁ = p₀ + I − N d
//! ```
//!
//! The iteration is one for the nodes, and its last update is one of the displacements. Bounds of
//! the derivatives of I over boxes around the motion give the spectrum of the equations. If it is
//! positive, the root in the boxes is unique; the weights of the iteration come from the same bounds.
//! If the solution is outside of its boxes, boxes around it are tried. The state is written after all
//! tests.

mod errors;

use core::marker::PhantomData;
use core::mem::swap;

use super::chebyshev::Chebyshev;
use super::errors::index_error;
use super::gather::Gather;
use super::masses::InverseMasses;
use super::passes::{Begin, Factors, Finish, FirstVelocities, Largest};
use super::relax::{End, NodeVelocities, Relax, Tests};
use super::segments::Segments;
use super::spectrum::{Bounds, Extremes, Spectrum, Worst};
use super::sweep::{Buffers, Kick};
use super::work::Work;
use super::{Contributions, Impulses, Row, Scene, Slopes};
use crate::error::StepError;
use crate::lanes::dispatch::dispatch;

/// Sweeps of a step, at most: a stiffer scene needs another method.
const MOST: f64 = 200.0;

/// Updates without a smaller one after which the updates are rounding errors.
const STALLED: f64 = 3.0;

/// Largest update, relative to the largest place or displacement, that can be a rounding error.
const ROUNDING: f64 = 1e3 * f64::EPSILON;

/// Such an update that certainly is one if it is not smaller than those before it.
const SMALLEST: f64 = 4.0 * f64::EPSILON;

/// Boxes that are tried, each around the solution for the boxes before it.
const ROUNDS: u32 = 8;

/// A step of the midpoint rule.
#[derive(Debug)]
pub struct MidpointStep<'a, R> {
    pub(super) segments: &'a Segments,
    pub(super) masses: &'a InverseMasses,
    /// The friction of each component divided by its mass; empty without friction.
    pub(super) rates: &'a [f64],
    pub(super) buffers: &'a mut Buffers,
    pub(super) work: &'a mut Work,
    pub(super) q: &'a mut [R],
    pub(super) p: &'a mut [R],
    /// The impulse over the step at the time of the node.
    pub(super) kick: Kick<'a>,
    /// The time at the start of the whole step, for messages.
    pub(super) start: f64,
}

/// Makes a step of the midpoint rule.
///
/// # Errors
/// [`StepError::Stiff`] if the bounds allow other solutions or if the solution takes many sweeps;
/// an index that is out of range; a result that is not finite. The state is then unchanged.
pub fn midpoint<S>(scene: &S, mut step: MidpointStep<'_, S::Row>) -> Result<(), StepError>
where
    S: Scene + Contributions<Slopes>,
{
    step.work.begin(S::Row::numbers(step.q).len(), S::HAS_DRAGS);
    let factors = step.factors()?;
    let Work { centres, nodes, .. } = &mut *step.work;
    let [mut size, places] = factors.pass(Begin {
        centres: [centres, nodes],
        q: S::Row::numbers(step.q),
        p: S::Row::numbers(step.p),
    });
    if S::HAS_DRAGS {
        let (h, v) = (step.kick.h, &mut step.work.velocities[0]);
        factors.pass(FirstVelocities {
            v,
            p: S::Row::numbers(step.p),
            h,
        });
    }
    let is_symmetric = S::IS_SYMMETRIC && factors.have_one_sign();
    let (mut sweeps, mut change) = (0, 0.0);
    // an iteration that leaves its boxes need not contract
    for _ in 0..ROUNDS {
        let iteration = step.iteration(scene, &factors, size, is_symmetric)?;
        let iterated = step.iterate(scene, &factors, [size, places], iteration)?;
        let end = step.end(scene, &factors, size, iteration.plain_weight())?;
        sweeps += iterated.sweeps;
        size = end.displacements.value();
        change = iterated.change / size;
        if end.are_in_boxes() {
            if !iterated.is_solved {
                break;
            }
            if end.changes.value() <= iterated.last {
                dispatch(Finish {
                    q: S::Row::numbers_mut(step.q),
                    p: S::Row::numbers_mut(step.p),
                    d: step.work.displacements(),
                    end: &step.work.other,
                });
                step.work.factors = Some((step.kick.h, factors));
                step.work.solved.sweeps = sweeps;
                return Ok(());
            }
        }
        step.work.next_round();
    }
    Err(step.not_contracting(sweeps, change))
}

/// The result of an iteration.
struct Iterated {
    /// False if the updates stopped to become smaller, and are no rounding errors.
    is_solved: bool,
    sweeps: u32,
    /// The last update.
    change: f64,
    /// The largest update of the displacements at the end. A larger one is a jump of the impulse.
    last: f64,
}

impl<R: Row> MidpointStep<'_, R> {
    /// Returns the factors of the displacements: those of the last step, if its length was the same.
    fn factors(&mut self) -> Result<Factors, StepError> {
        let h = self.kick.h;
        match self.work.factors.take() {
            Some((of, factors)) if of == h => Ok(factors),
            _ => Factors::new(self.masses, self.rates, h).map_err(|at| {
                let bound = 0.5 * h * self.rates[at];
                self.stiff(at, [bound, bound])
            }),
        }
    }

    /// Returns the iteration for displacements near those in `work`, of which none is larger than
    /// `size`.
    ///
    /// # Errors
    /// The bounds of the spectrum are not positive, or the iteration would take many sweeps.
    fn iteration<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        size: f64,
        is_symmetric: bool,
    ) -> Result<Chebyshev, StepError>
    where
        S: Scene<Row = R> + Contributions<Slopes>,
    {
        let extremes = self.bounds(scene, factors, size, Extremes::default())?;
        let [lower, upper] = extremes.values();
        self.work.solved.bounds = [lower, upper];
        if 1.0 + lower > 0.0 && upper.is_finite() {
            let iteration = Chebyshev::new([1.0 + lower, 1.0 + upper], is_symmetric);
            if iteration.updates(f64::EPSILON) <= MOST {
                return Ok(iteration);
            }
        }
        let worst = self.bounds(scene, factors, size, Worst::default())?;
        Err(self.stiff(worst.at, [lower, upper]))
    }

    /// Computes bounds of the spectrum in boxes around the displacements in `work`.
    ///
    /// # Errors
    /// An index that is out of range.
    fn bounds<S, U: Bounds>(
        &mut self,
        scene: &S,
        factors: &Factors,
        size: f64,
        to: U,
    ) -> Result<U, StepError>
    where
        S: Scene<Row = R> + Contributions<Slopes>,
    {
        let Work {
            boxes,
            around,
            of_bounds,
            velocities: [_, of_v],
            ..
        } = &mut *self.work;
        let h = self.kick.h;
        let velocities = S::HAS_DRAGS.then(|| {
            let of_v = <S as Contributions<Slopes>>::Numbers::rows_mut(of_v);
            (of_v, h)
        });
        let buffers = of_bounds.get_or_insert_with(|| {
            Buffers::new::<<S as Contributions<Slopes>>::Numbers>(self.segments, self.q.len())
        });
        let swept = factors.pass(Gather {
            scene,
            segments: self.segments,
            kick: self.kick,
            buffers,
            sink: Spectrum {
                boxes: <S as Contributions<Slopes>>::Numbers::rows_mut(boxes),
                velocities,
                written: 0,
                q: R::numbers(self.q),
                p: R::numbers(self.p),
                d: around,
                largest: size,
                to,
            },
            what: PhantomData::<Slopes>,
        });
        let swept = swept.map_err(|error| index_error(error, self.start))?;
        Ok(swept.to)
    }

    /// Solves the equations for the nodes in `work`. No displacement there is larger than `size`, and
    /// no place than `places`.
    ///
    /// # Errors
    /// An index that is out of range.
    fn iterate<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        [mut size, places]: [f64; 2],
        mut iteration: Chebyshev,
    ) -> Result<Iterated, StepError>
    where
        S: Scene<Row = R>,
    {
        let Work {
            centres,
            nodes,
            other,
            velocities: [v, _],
            ..
        } = &mut *self.work;
        let (p, h) = (R::numbers(self.p), self.kick.h);
        let (mut smallest, mut stalled, mut sweeps) = (f64::INFINITY, 0u32, 0u32);
        loop {
            let swept = factors.pass(Gather {
                scene,
                segments: self.segments,
                kick: self.kick,
                buffers: &mut *self.buffers,
                sink: Relax {
                    nodes: &*R::rows_mut(nodes),
                    other,
                    centres,
                    velocities: S::HAS_DRAGS.then_some(NodeVelocities {
                        v,
                        p,
                        h,
                        largest: Largest::default(),
                    }),
                    weights: iteration.weights(),
                    largest: Largest::default(),
                },
                what: PhantomData::<Impulses>,
            });
            let swept = swept.map_err(|error| index_error(error, self.start))?;
            let change = match swept.velocities {
                Some(of) => 0.5 * h.abs() * of.largest.value(),
                None => swept.largest.value(),
            };
            swap(nodes, other);
            sweeps += 1;
            size += 2.0 * change;
            let farthest = places.max(size);
            let last = 4.0 * iteration.error(change) + ROUNDING * farthest;
            let end = |is_solved| Iterated {
                is_solved,
                sweeps,
                change,
                last,
            };
            // velocities need the digits of the displacements, which the places lack
            let digits = if S::HAS_DRAGS { size } else { farthest };
            if iteration.is_solved(change, size, digits) {
                return Ok(end(true));
            }
            if f64::from(sweeps) > 2.0 * MOST {
                return Ok(end(false));
            }
            if change < smallest {
                (smallest, stalled) = (change, 0);
                continue;
            }
            if change <= SMALLEST * farthest {
                return Ok(end(true));
            }
            stalled += 1;
            // the updates of Chebyshev's iteration become smaller on average
            if f64::from(stalled) < STALLED.max(iteration.updates(0.1)) {
                continue;
            }
            if !iteration.make_plain() {
                return Ok(end(change <= ROUNDING * farthest));
            }
            (smallest, stalled) = (f64::INFINITY, 0);
        }
    }

    /// Computes the displacements with one more update, and the momenta at the end in `work.other`.
    /// None of the displacements around which the boxes are is larger than `size`.
    ///
    /// # Errors
    /// An index that is out of range; an end in the boxes that is not finite.
    fn end<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        size: f64,
        alpha: f64,
    ) -> Result<Tests, StepError>
    where
        S: Scene<Row = R>,
    {
        let Work {
            nodes,
            other,
            boxes,
            around,
            velocities: [v, _],
            ..
        } = &mut *self.work;
        let friction = (!self.rates.is_empty()).then_some((self.rates, self.masses));
        let swept = factors.pass(Gather {
            scene,
            segments: self.segments,
            kick: self.kick,
            buffers: &mut *self.buffers,
            sink: End {
                nodes: &*R::rows_mut(nodes),
                velocities: &*R::rows_mut(v),
                q: R::numbers(self.q),
                p: R::numbers(self.p),
                d: boxes,
                to: other,
                alpha,
                around,
                largest: size,
                friction,
                tests: Tests::default(),
            },
            what: PhantomData::<Impulses>,
        });
        let tests = swept.map_err(|error| index_error(error, self.start))?.tests;
        if tests.are_in_boxes() && !tests.are_finite() {
            return Err(self.not_finite());
        }
        Ok(tests)
    }
}
