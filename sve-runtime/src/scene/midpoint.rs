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
use super::drift::AreFinite;
use super::errors::{index_error, input_error, name};
use super::masses::InverseMasses;
use super::passes::{Add, Factors, Guess, SumsAreFinite, WriteNodes, add_friction, largest};
use super::relax::{Relax, Solution};
use super::segments::Segments;
use super::spectrum::{Boxes, BoxesContain, Extremes, worst};
use super::sweep::{Buffers, Kick, Sweep};
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

/// The arrays of a solution, of the components of rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    /// The displacements.
    d: Vec<f64>,
    /// The last update of each displacement; after the iteration, the momenta at the end.
    update: Vec<f64>,
    /// The boxes of the nodes; during the iteration, the nodes before and after an update.
    boxes: Vec<f64>,
    /// The bounds; after their test, the displacements around which the boxes are.
    bounds: Vec<f64>,
    /// The factors of the displacements, with their step size.
    factors: Option<(f64, Factors)>,
    of_bounds: Option<Buffers>,
}

impl Work {
    /// Returns the number of numbers.
    pub(super) fn len(&self) -> usize {
        let factors = match &self.factors {
            Some((_, Factors::Each(factors))) => factors.len(),
            _ => 0,
        };
        let buffers = self.of_bounds.as_ref().map_or(0, Buffers::len);
        let arrays = [&self.d, &self.update, &self.boxes, &self.bounds];
        arrays.iter().map(|array| array.len()).sum::<usize>() + factors + buffers
    }

    /// Returns whether the boxes of the bounds, around displacements whose largest one is `size`,
    /// contain the solution.
    fn boxes_contain_solution(&self, size: f64) -> bool {
        let d = &*self.d;
        dispatch(BoxesContain {
            d,
            of: &self.bounds[..d.len()],
            largest: size,
        })
    }

    fn fit(&mut self, numbers: usize) {
        for array in [&mut self.d, &mut self.update] {
            array.resize(numbers, 0.0);
        }
        for array in [&mut self.boxes, &mut self.bounds] {
            array.resize(2 * numbers, 0.0);
        }
    }
}

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
    step.work.fit(S::Row::numbers(step.q).len());
    let factors = step.factors()?;
    let guess = factors.pass(Guess {
        d: &mut step.work.d,
        p: S::Row::numbers(step.p),
    });
    let is_symmetric = S::IS_SYMMETRIC && factors.have_one_sign();
    let (mut size, mut sweeps, mut change) = (guess, 0, 0.0);
    // an iteration that leaves its boxes need not contract
    for _ in 0..ROUNDS {
        let iteration = step.iteration(scene, &factors, size, is_symmetric)?;
        let iterated = step.iterate(scene, &factors, guess, iteration)?;
        sweeps += iterated.sweeps;
        change = iterated.change;
        if step.work.boxes_contain_solution(size) {
            if !iterated.is_solved {
                break;
            }
            step.end(scene)?;
            dispatch(Add(S::Row::numbers_mut(step.q), &step.work.d));
            S::Row::numbers_mut(step.p).copy_from_slice(&step.work.update);
            step.work.factors = Some((step.kick.h, factors));
            return Ok(());
        }
        size = largest(&step.work.d);
    }
    Err(step.not_contracting(sweeps, change))
}

/// The result of an iteration.
struct Iterated {
    /// False if the updates stopped to become smaller, and are no rounding errors.
    is_solved: bool,
    sweeps: u32,
    /// The last update, relative to the largest displacement.
    change: f64,
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

    /// Returns the iteration for displacements near those in `work`, whose largest one is `size`.
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
        let Work {
            d,
            boxes,
            bounds,
            of_bounds,
            ..
        } = &mut *self.work;
        dispatch(Boxes {
            rows: boxes,
            q: self.q,
            d: R::rows_mut(d),
            largest: size,
        });
        bounds.fill(0.0);
        let buffers = of_bounds.get_or_insert_with(|| {
            Buffers::new::<<S as Contributions<Slopes>>::Numbers>(self.segments, self.q.len())
        });
        let swept = dispatch(Sweep::<S, Slopes, false> {
            scene,
            segments: self.segments,
            drift: None,
            kick: self.kick,
            q: Row::rows_mut(boxes),
            p: Row::rows_mut(bounds),
            buffers,
            is_tested: false,
        });
        swept.map_err(|error| index_error(error, self.start))?;
        let extremes = Extremes {
            bounds: &self.work.bounds,
            row: PhantomData::<R>,
        };
        let [lower, upper] = if self.q.is_empty() {
            [0.0; 2]
        } else {
            factors.pass(extremes)
        };
        if 1.0 + lower > 0.0 && upper.is_finite() {
            let iteration = Chebyshev::new([1.0 + lower, 1.0 + upper], is_symmetric);
            if iteration.updates(f64::EPSILON) <= MOST {
                let Work { d, bounds, .. } = &mut *self.work;
                bounds[..d.len()].copy_from_slice(d);
                return Ok(iteration);
            }
        }
        let at = worst::<R>(&self.work.bounds, factors);
        Err(self.stiff(at, [lower, upper]))
    }

    /// Solves the equations, so that `work` has the displacements.
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
        let (q, p) = (R::numbers(self.q), R::numbers(self.p));
        let farthest = largest(q);
        let Work {
            d, update, boxes, ..
        } = &mut *self.work;
        // a step that failed may have left numbers that are not finite
        update.fill(0.0);
        let (mut fresh, mut nodes) = boxes.split_at_mut(q.len());
        dispatch(WriteNodes(fresh, q, d));
        // of sites without any term, which are not updated
        nodes.copy_from_slice(fresh);
        let (mut smallest, mut stalled, mut sweeps) = (f64::INFINITY, 0u32, 0u32);
        loop {
            swap(&mut fresh, &mut nodes);
            let swept = factors.pass(Relax {
                scene,
                segments: self.segments,
                kick: self.kick,
                buffers: &mut *self.buffers,
                nodes: R::rows_mut(nodes),
                solution: Solution {
                    d: &mut *d,
                    update: &mut *update,
                    fresh: &mut *fresh,
                    q,
                    p,
                    weights: iteration.weights(),
                },
            });
            let [change, size] = swept.map_err(|error| index_error(error, self.start))?;
            sweeps += 1;
            let end = |is_solved| Iterated {
                is_solved,
                sweeps,
                change: change / size,
            };
            if iteration.is_solved(change, [size, guess, farthest]) {
                return Ok(end(true));
            }
            if f64::from(sweeps) > 2.0 * MOST {
                return Ok(end(false));
            }
            if change < smallest {
                (smallest, stalled) = (change, 0);
            } else {
                stalled += 1;
            }
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

    /// Computes the momenta at the end in `work.update`, and checks that the end is finite.
    fn end<S>(&mut self, scene: &S) -> Result<(), StepError>
    where
        S: Scene<Row = R>,
    {
        let Work {
            d, update, boxes, ..
        } = &mut *self.work;
        let (q, p) = (R::numbers(self.q), R::numbers(self.p));
        update.copy_from_slice(p);
        let nodes = &mut boxes[..q.len()];
        dispatch(WriteNodes(nodes, q, d));
        let swept = dispatch(Sweep::<S, Impulses, false> {
            scene,
            segments: self.segments,
            drift: None,
            kick: self.kick,
            q: R::rows_mut(nodes),
            p: R::rows_mut(update),
            buffers: self.buffers,
            is_tested: false,
        });
        swept.map_err(|error| index_error(error, self.start))?;
        add_friction(update, d, self.rates, self.masses);
        if !dispatch(SumsAreFinite(q, &self.work.d)) {
            let sums = q.iter().zip(&self.work.d).map(|(q, d)| q + d);
            return Err(self.not_finite("q", sums));
        }
        if !dispatch(AreFinite(&self.work.update)) {
            return Err(self.not_finite("p", self.work.update.iter().copied()));
        }
        Ok(())
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
    fn not_contracting(&self, sweeps: u32, change: f64) -> StepError {
        let places = || {
            R::numbers(self.q)
                .iter()
                .zip(&self.work.d)
                .map(|(q, d)| q + d)
        };
        if places().any(|place| !place.is_finite()) {
            return self.not_finite("q", places());
        }
        self.input_error().unwrap_or(StepError::NotContracting {
            t: self.start,
            h: self.kick.h,
            sweeps,
            change,
        })
    }

    #[cold]
    fn not_finite(&self, array: &str, mut numbers: impl Iterator<Item = f64>) -> StepError {
        self.input_error().unwrap_or_else(|| {
            let at = numbers.position(|x| !x.is_finite()).unwrap_or_default();
            StepError::NonFiniteCoordinate {
                t: self.start,
                h: self.kick.h,
                what: name(array, at, R::LENGTH),
            }
        })
    }

    fn input_error(&self) -> Option<StepError> {
        let [q, p] = [&*self.q, &*self.p].map(R::numbers);
        input_error::<R>([q, p], self.kick.dw, self.start)
    }
}
