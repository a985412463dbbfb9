//! Steps of the midpoint rule, whose equations join all sites.
//!
//! With the displacement d = q₁ − q₀, the impulse I at q₀ + d/2, masses M and friction N, a step is
//!
//! ```text
//! d = f (p₀ + I/2),   f = h (M + h N/2)⁻¹,   p₁ = p₀ + I − N d
//! ```
//!
//! Bounds of the derivatives of I over boxes around the motion give the spectrum of the equations.
//! If it is positive, the root in the boxes is unique; the weights of the iteration come from the
//! same bounds. If the solution is outside of its boxes, boxes around it are tried. The state is
//! written after all tests.

use core::marker::PhantomData;
use core::mem::swap;

use super::chebyshev::Chebyshev;
use super::errors::{index_error, input_error, name};
use super::gather::Gather;
use super::masses::InverseMasses;
use super::passes::{Begin, Factors, Finish, WriteNodes, largest};
use super::relax::{End, Most, Relax};
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
    step.work.begin(S::Row::numbers(step.q).len());
    let factors = step.factors()?;
    let guess = factors.pass(Begin {
        centres: &mut step.work.centres,
        q: S::Row::numbers(step.q),
        p: S::Row::numbers(step.p),
    });
    let is_symmetric = S::IS_SYMMETRIC && factors.have_one_sign();
    let (mut size, mut sweeps, mut change) = (guess, 0, 0.0);
    // an iteration that leaves its boxes need not contract
    for _ in 0..ROUNDS {
        let iteration = step.iteration(scene, &factors, size, is_symmetric)?;
        let iterated = step.iterate(scene, &factors, guess, iteration)?;
        sweeps += iterated.sweeps;
        change = iterated.change / iterated.size;
        if step.end(scene, &factors, size, iterated.sweeps)? {
            if !iterated.is_solved {
                break;
            }
            factors.pass(Finish {
                q: S::Row::numbers_mut(step.q),
                p: S::Row::numbers_mut(step.p),
                e: &step.work.e,
                end: &step.work.other,
            });
            step.work.factors = Some((step.kick.h, factors));
            return Ok(());
        }
        step.work.around.clear();
        step.work.around.extend_from_slice(&step.work.e);
        size = iterated.size;
    }
    Err(step.not_contracting(&factors, sweeps, change))
}

/// The result of an iteration.
struct Iterated {
    /// False if the updates stopped to become smaller, and are no rounding errors.
    is_solved: bool,
    sweeps: u32,
    /// The last update.
    change: f64,
    /// A bound of the displacements.
    size: f64,
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
            ..
        } = &mut *self.work;
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
                written: 0,
                q: R::numbers(self.q),
                p: R::numbers(self.p),
                e: around,
                largest: size,
                to,
            },
            what: PhantomData::<Slopes>,
        });
        let swept = swept.map_err(|error| index_error(error, self.start))?;
        Ok(swept.to)
    }

    /// Solves the equations, so that `work` has the displacements and, in the first half of `boxes`
    /// after an even number of sweeps and else in the second one, their nodes.
    ///
    /// # Errors
    /// An index that is out of range.
    fn iterate<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        guess: f64,
        mut iteration: Chebyshev,
    ) -> Result<Iterated, StepError>
    where
        S: Scene<Row = R>,
    {
        let q = R::numbers(self.q);
        let farthest = largest(q);
        let Work {
            centres,
            e,
            other,
            boxes,
            ..
        } = &mut *self.work;
        // a step that failed may have left numbers that are not finite
        other.fill(0.0);
        let (nodes, fresh) = boxes.split_at_mut(q.len());
        dispatch(WriteNodes(nodes, centres, e));
        let mut nodes = [nodes, fresh];
        let (mut smallest, mut stalled, mut sweeps) = (f64::INFINITY, 0u32, 0u32);
        loop {
            let [nodes, fresh] = &mut nodes;
            let swept = factors.pass(Gather {
                scene,
                segments: self.segments,
                kick: self.kick,
                buffers: &mut *self.buffers,
                sink: Relax {
                    nodes: &*R::rows_mut(nodes),
                    fresh,
                    centres,
                    e,
                    other,
                    weights: iteration.weights(),
                    most: Most::default(),
                },
                what: PhantomData::<Impulses>,
            });
            let swept = swept.map_err(|error| index_error(error, self.start))?;
            let [change, impulse] = swept.most.values();
            swap(nodes, fresh);
            swap(e, other);
            sweeps += 1;
            let size = guess + impulse;
            let end = |is_solved| Iterated {
                is_solved,
                sweeps,
                change,
                size,
            };
            if iteration.is_solved(change, size, farthest) {
                return Ok(end(true));
            }
            if f64::from(sweeps) > 2.0 * MOST {
                return Ok(end(false));
            }
            if change < smallest {
                (smallest, stalled) = (change, 0);
                continue;
            }
            stalled += 1;
            // the updates of Chebyshev's iteration become smaller on average
            if f64::from(stalled) < STALLED.max(iteration.updates(0.1)) {
                continue;
            }
            if !iteration.make_plain() {
                return Ok(end(change <= ROUNDING * farthest.max(size)));
            }
            (smallest, stalled) = (f64::INFINITY, 0);
        }
    }

    /// Computes the momenta at the end in `work.other`, after the last of so many sweeps. Returns
    /// whether the boxes, around displacements of which none is larger than `size`, contain the
    /// solution.
    ///
    /// # Errors
    /// An index that is out of range; an end in the boxes that is not finite.
    fn end<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        size: f64,
        sweeps: u32,
    ) -> Result<bool, StepError>
    where
        S: Scene<Row = R>,
    {
        let Work {
            e,
            other,
            boxes,
            around,
            ..
        } = &mut *self.work;
        let (even, odd) = boxes.split_at_mut(e.len());
        let nodes = if sweeps.is_multiple_of(2) { even } else { odd };
        let friction = (!self.rates.is_empty()).then_some((self.rates, self.masses));
        let swept = factors.pass(Gather {
            scene,
            segments: self.segments,
            kick: self.kick,
            buffers: &mut *self.buffers,
            sink: End {
                nodes: &*R::rows_mut(nodes),
                q: R::numbers(self.q),
                p: R::numbers(self.p),
                e,
                to: other,
                around,
                largest: size,
                friction,
                bits: 0,
                is_in_boxes: true,
            },
            what: PhantomData::<Impulses>,
        });
        let End {
            bits, is_in_boxes, ..
        } = swept.map_err(|error| index_error(error, self.start))?;
        if is_in_boxes && bits != 0 {
            return Err(self.not_finite(factors));
        }
        Ok(is_in_boxes)
    }

    /// Returns the error of a spectrum that is not accepted, with its bounds at a component.
    #[cold]
    fn stiff(&self, at: usize, bounds: [f64; 2]) -> StepError {
        let (h, length) = (self.kick.h, R::LENGTH);
        self.input_error().unwrap_or_else(|| StepError::Stiff {
            t: self.start,
            h,
            what: name("q", at, length),
            bounds,
        })
    }

    #[cold]
    fn not_contracting(&self, factors: &Factors, sweeps: u32, change: f64) -> StepError {
        let is_finite = self.places(factors).all(f64::is_finite);
        if !is_finite {
            return self.not_finite(factors);
        }
        self.input_error().unwrap_or(StepError::NotContracting {
            t: self.start,
            h: self.kick.h,
            sweeps,
            change,
        })
    }

    /// Returns the error of an end that is not finite.
    #[cold]
    fn not_finite(&self, factors: &Factors) -> StepError {
        self.input_error().unwrap_or_else(|| {
            let place = self.places(factors).position(|x| !x.is_finite());
            let momentum = || self.work.other.iter().position(|x| !x.is_finite());
            let (array, at) = match place {
                Some(at) => ("q", at),
                None => ("p", momentum().unwrap_or_default()),
            };
            StepError::NonFiniteCoordinate {
                t: self.start,
                h: self.kick.h,
                what: name(array, at, R::LENGTH),
            }
        })
    }

    /// Returns the places at the end.
    fn places(&self, factors: &Factors) -> impl Iterator<Item = f64> {
        let [q, p] = [&*self.q, &*self.p].map(R::numbers);
        let place = move |at| q[at] + (factors.of(at) * p[at] + self.work.e[at]);
        (0..q.len()).map(place)
    }

    fn input_error(&self) -> Option<StepError> {
        let [q, p] = [&*self.q, &*self.p].map(R::numbers);
        input_error::<R>([q, p], self.kick.dw, self.start)
    }
}
