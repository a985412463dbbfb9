//! Steps of the midpoint rule, whose equations join all sites.
//!
//! With the displacement d = q₁ − q₀, the impulse I at q₀ + d/2, masses M and friction N, a step is
//!
//! ```text
//! d = f (p₀ + I/2),   f = h (M + h N/2)⁻¹,   p₁ = p₀ + I − N d
//! ```
//!
//! Bounds of the derivatives of I over boxes around the motion give the spectrum of the equations.
//! If it is positive, the root in the boxes is unique, and it is the one that is connected with
//! h → 0; the weights of the iteration come from the same bounds. The state is written after all
//! tests.

use super::chebyshev::Chebyshev;
use super::masses::InverseMasses;
use super::passes::{End, Factors, Guess, Update, largest, write_nodes};
use super::segments::Segments;
use super::shear::{index_error, input_error, name};
use super::spectrum::{BoxesContain, Extremes, worst, write_boxes};
use super::sweep::{Buffers, Kick, Sweep};
use super::{Contributions, Impulses, Row, Scene, Slopes};
use crate::error::StepError;
use crate::lanes::dispatch::{Call, dispatch};

/// Sweeps of a step, at most: a stiffer scene needs another method.
const MOST: f64 = 200.0;

/// Part of a rounding error that the error of the iteration may have. Rounding errors have random
/// signs, and this error has none.
const PART: f64 = 1.0 / 16.0;

/// Updates without a smaller one after which the updates are rounding errors.
const STALLED: u32 = 3;

/// Largest update, relative to the largest displacement, that can be a rounding error.
const ROUNDING: f64 = 1e-8;

/// The arrays of a solution, of the components of rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    /// The displacements.
    d: Vec<f64>,
    impulse: Vec<f64>,
    /// The boxes of the nodes; during the iteration, the last update of each displacement and the
    /// nodes.
    boxes: Vec<f64>,
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
        let arrays = [&self.d, &self.impulse, &self.boxes, &self.bounds];
        arrays.iter().map(|array| array.len()).sum::<usize>() + factors + buffers
    }

    fn fit(&mut self, numbers: usize) {
        for array in [&mut self.d, &mut self.impulse] {
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
    let guess = Guess {
        d: &mut step.work.d,
        p: S::Row::numbers(step.p),
    };
    let size = factors.pass(guess);
    let spectrum = step.spectrum(scene, &factors, size)?;
    let is_symmetric = S::IS_SYMMETRIC && factors.have_one_sign();
    step.iterate(scene, &factors, Chebyshev::new(spectrum, is_symmetric))?;
    if !dispatch(Call(
        #[inline(always)]
        || step.end().is_finite(),
    )) {
        return Err(step.not_finite());
    }
    let guess = BoxesContain {
        d: &step.work.d,
        p: S::Row::numbers(step.p),
        largest: size,
    };
    if !factors.pass(guess) {
        let size = largest(&step.work.d);
        step.spectrum(scene, &factors, size)?;
    }
    dispatch(Call(
        #[inline(always)]
        || step.end().write(),
    ));
    step.work.factors = Some((step.kick.h, factors));
    Ok(())
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

    /// Returns an interval of positive numbers that contains the spectrum of the equations for
    /// displacements near those in `work`, whose largest one is `size`.
    ///
    /// # Errors
    /// There is no such interval, or the iteration would take many sweeps.
    fn spectrum<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        size: f64,
    ) -> Result<[f64; 2], StepError>
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
        write_boxes::<R>(boxes, R::numbers(self.q), d, size);
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
            size: R::LENGTH,
        };
        let [lower, upper] = if self.q.is_empty() {
            [0.0; 2]
        } else {
            factors.pass(extremes)
        };
        let spectrum = [1.0 + lower, 1.0 + upper];
        let is_positive = spectrum[0] > 0.0 && upper.is_finite();
        if is_positive && Chebyshev::new(spectrum, true).updates(f64::EPSILON) <= MOST {
            return Ok(spectrum);
        }
        let at = worst::<R>(&self.work.bounds, factors);
        Err(self.stiff(at, [lower, upper]))
    }

    /// Solves the equations, so that `work` has the displacements and the impulses.
    ///
    /// # Errors
    /// The updates stop to become smaller, and are no rounding errors.
    fn iterate<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        mut iteration: Chebyshev,
    ) -> Result<(), StepError>
    where
        S: Scene<Row = R>,
    {
        let contraction = iteration.contraction();
        let slope = iteration.slope();
        let q = R::numbers(self.q).len();
        let (mut smallest, mut stalled, mut sweeps) = (f64::INFINITY, 0, 0);
        let (update, nodes) = self.work.boxes.split_at_mut(q);
        let (places, d) = (R::numbers(self.q), &self.work.d);
        dispatch(Call(
            #[inline(always)]
            || write_nodes(nodes, places, d),
        ));
        loop {
            self.work.impulse.fill(0.0);
            let swept = dispatch(Sweep::<S, Impulses, false> {
                scene,
                segments: self.segments,
                drift: None,
                kick: self.kick,
                q: R::rows_mut(nodes),
                p: R::rows_mut(&mut self.work.impulse),
                buffers: self.buffers,
                is_tested: false,
            });
            swept.map_err(|error| index_error(error, self.start))?;
            sweeps += 1;
            let [change, size, node] = factors.pass(Update {
                d: &mut self.work.d,
                update,
                nodes,
                impulse: &self.work.impulse,
                q: R::numbers(self.q),
                p: R::numbers(self.p),
                weights: iteration.weights(),
            });
            // of the displacement, and of the impulse, which is that of the last node
            let error = change * contraction / (1.0 - contraction);
            let lag = 2.0 * slope * change;
            let rounding = PART * f64::EPSILON;
            if error <= rounding * node.max(size) && lag <= rounding * (size + slope * node) {
                return Ok(());
            }
            if change < smallest {
                (smallest, stalled) = (change, 0);
            } else {
                stalled += 1;
            }
            if stalled == STALLED {
                if iteration.make_plain() {
                    (smallest, stalled) = (f64::INFINITY, 0);
                } else if change <= ROUNDING * size {
                    return Ok(());
                } else {
                    return Err(self.not_contracting(sweeps, change / size));
                }
            }
        }
    }

    fn end(&mut self) -> End<'_> {
        End {
            d: &self.work.d,
            impulse: &self.work.impulse,
            rates: self.rates,
            masses: self.masses,
            q: R::numbers_mut(self.q),
            p: R::numbers_mut(self.p),
        }
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
        self.input_error().unwrap_or(StepError::NotContracting {
            t: self.start,
            h: self.kick.h,
            sweeps,
            change,
        })
    }

    #[cold]
    fn not_finite(&mut self) -> StepError {
        if let Some(error) = self.input_error() {
            return error;
        }
        let (start, h) = (self.start, self.kick.h);
        let what = self.end().not_finite(R::LENGTH);
        StepError::NonFiniteCoordinate { t: start, h, what }
    }

    fn input_error(&self) -> Option<StepError> {
        let [q, p] = [&*self.q, &*self.p].map(R::numbers);
        input_error::<R>([q, p], self.kick.dw, self.start)
    }
}
