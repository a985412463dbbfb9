//! Steps of the midpoint rule, whose equations join all sites.
//!
//! With the displacement d = q₁ − q₀, the impulse I at the node q₀ + d/2, masses M and friction N,
//! a step is
//!
//! ```text
//! d = f (p₀ + I/2),   f = h (M + h N/2)⁻¹,   p₁ = p₀ + I − N d
//! ```
//!
//! The iteration is one for the nodes, and its last update is one of the displacements. Bounds of
//! the derivatives of I over boxes around the motion give the spectrum of the equations. If it is
//! positive, the root in the boxes is unique; the weights of the iteration come from the same
//! bounds. If the solution is outside of its boxes, boxes around it are tried. The state is written
//! after all tests.

mod errors;
mod h1;
mod iterate;

use core::marker::PhantomData;

use super::chebyshev::Chebyshev;
use super::errors::index_error;
use super::gather::Gather;
use super::masses::InverseMasses;
use super::passes::{Begin, Factors, Finish, FirstVelocities};
use super::relax::{End, OfH1, Tests};
use super::segments::Segments;
use super::shifts::Shifts;
use super::spectrum::{Bounds, BoxesOfVelocities, Extremes, Spectrum, Worst};
use super::sweep::{Buffers, Kick};
use super::work::Work;
use super::{Contributions, Impulses, Row, Scene, Slopes, reads_motion};
use crate::error::StepError;
use crate::lanes::dispatch::dispatch;

/// Sweeps of a step, at most: a stiffer scene needs another method.
const MOST: f64 = 200.0;

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
    step.work.begin::<S>(S::Row::numbers(step.q).len());
    let factors = step.factors()?;
    let Work { centres, nodes, .. } = &mut *step.work;
    let [mut size, places] = factors.pass(Begin {
        centres: [centres, nodes],
        q: S::Row::numbers(step.q),
        p: S::Row::numbers(step.p),
    });
    if reads_motion::<S>() {
        let (h, v) = (step.kick.h, &mut step.work.velocities[0]);
        factors.pass(FirstVelocities {
            v,
            p: S::Row::numbers(step.p),
            h,
        });
    }
    if S::HAS_H1 {
        size = step.first_sweep(scene, &factors, size)?;
    }
    let is_symmetric = S::IS_SYMMETRIC && factors.have_one_sign();
    let (mut sweeps, mut change) = (0, 0.0);
    // an iteration that leaves its boxes need not contract
    for _ in 0..ROUNDS {
        let iteration = step.iteration(scene, &factors, size, is_symmetric)?;
        let iterated = step.iterate(scene, &factors, [size, places], iteration)?;
        let alpha = iteration.updates.plain_weight();
        let end = step.end(scene, &factors, size, alpha)?;
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
        if S::HAS_H1 {
            let Work {
                of_h1, velocities, ..
            } = &mut *step.work;
            of_h1.set_boxes(&velocities[0], end.motions.value());
        }
    }
    Err(step.not_contracting(sweeps, change))
}

/// The iteration of a step.
#[derive(Clone, Copy)]
struct Iteration {
    updates: Chebyshev,
    /// The magnitude of an update of a motion h v/2 that weighs as much as 1 of a node, in a scene
    /// with H₁.
    weight: f64,
}

impl<R: Row> MidpointStep<'_, R> {
    /// Returns the factors of the displacements: those of the last step, if its length was the
    /// same.
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
    ) -> Result<Iteration, StepError>
    where
        S: Scene<Row = R> + Contributions<Slopes>,
    {
        let extremes = self.bounds(scene, factors, size, Extremes::default())?;
        let [lower, upper] = extremes.values();
        self.work.solved.bounds = [lower, upper];
        if 1.0 + lower > 0.0 && upper.is_finite() {
            if S::HAS_H1 {
                return self.contraction(scene, factors, upper.max(-lower));
            }
            let updates = Chebyshev::new([1.0 + lower, 1.0 + upper], is_symmetric);
            if updates.updates(f64::EPSILON) <= MOST {
                let weight = 1.0;
                return Ok(Iteration { updates, weight });
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
            of_h1,
            ..
        } = &mut *self.work;
        let h = self.kick.h;
        let velocities = reads_motion::<S>().then(|| BoxesOfVelocities {
            boxes: <S as Contributions<Slopes>>::Numbers::rows_mut(of_v),
            h,
            around: S::HAS_H1.then_some((&*of_h1.around, of_h1.largest)),
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
            of_h1,
            ..
        } = &mut *self.work;
        let Shifts {
            momenta,
            displacements,
            around: around_v,
            largest,
            ..
        } = of_h1;
        let friction = (!self.rates.is_empty()).then_some((self.rates, self.masses));
        let swept = factors.pass(Gather {
            scene,
            segments: self.segments,
            kick: self.kick,
            buffers: &mut *self.buffers,
            sink: End {
                nodes: R::rows(nodes),
                velocities: v,
                h1: OfH1 {
                    h: self.kick.h,
                    momenta: R::rows(momenta),
                    shifts: displacements,
                    around: around_v,
                    largest: *largest,
                },
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
