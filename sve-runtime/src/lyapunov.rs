//! Lyapunov exponents: the rates at which small changes of the start grow along a path.
//!
//! Input: an integrator, a start, a step size and a noise. Output: the states along the path, and
//! the leading exponents with their statistical errors. Invariant: the states are those of repeated
//! steps.
//!
//! The tangent maps of the steps act on a frame of orthonormal vectors, which the Gram–Schmidt
//! process makes orthonormal again after each step. The averages of the logarithms of the lengths
//! that it divides by are the exponents. The first frame is v₁ … vₙ, Jvₙ … Jv₁ with vectors v that
//! span a Lagrangian subspace: symplectic maps keep this form, so their exponents have the exact
//! pairs λ, −λ for every length of the path, up to rounding.
//!
//! Source: D. D. Carpintero, J. C. Muzzio, *On the correct computation of all Lyapunov exponents in
//! Hamiltonian dynamical systems* (2023), for the order of the frame; G. Benettin, L. Galgani, A.
//! Giorgilli, J.-M. Strelcyn, *Lyapunov characteristic exponents for smooth dynamical systems and
//! for Hamiltonian systems*, Meccanica 15 (1980) 9–30.

use core::borrow::Borrow as _;
use core::fmt;

use crate::blocking::Blocking;
use crate::error::StepError;
use crate::integrator::accept::time_of_next;
use crate::integrator::{Integrator, Tangent};
use crate::noise::{Noise, NoiseError, Wiener, draw};
use crate::phase::configuration::Coordinates;
use crate::phase::state::State;
use crate::rule::Rule;
use crate::system::{AnyIncrements as _, Dims, StateOf, System};

/// Part of its length before the Gram–Schmidt process below which what is left of a vector is only
/// rounding error.
const ROUNDING: f64 = 1e-13;

impl<S, R, Q, const N: usize, const M: usize> Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    /// Returns the states along a path, as [`trajectory`](Self::trajectory) does, and computes its
    /// first `count` Lyapunov exponents, the largest ones first: of all 2N of the system if there
    /// are so many.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A pencil on its tip.
    /// struct Hill { k: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Hill {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + 0.5 * self.k * q * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let hill = Integrator::new(Hill { k: 4.0 }, Midpoint);
    /// let mut path = hill.lyapunov(State::new([0.0], [0.0]), 0.01, NoNoise, 2);
    /// path.advance(1000)?; // the frame turns to the directions that grow
    /// path.restart();
    /// path.advance(1000)?;
    /// let exponents = path.exponents();
    /// assert!((exponents[0] - 2.0).abs() < 1e-4 && (exponents[1] + 2.0).abs() < 1e-4);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// With noise they are the exponents of the random motion along this path, the same for almost
    /// all paths; a mean over several paths is a sharper estimate. A direction that the step maps
    /// to zero has the exponent −∞: directions across constraints, and the momenta of massless
    /// coordinates. Steps of [compositions](crate::Composed) and [splittings](crate::Split) have
    /// the product of the tangent maps of their substeps.
    pub fn lyapunov<W: Noise>(
        &self,
        state: State<Q>,
        h: f64,
        noise: W,
        count: usize,
    ) -> Lyapunov<'_, S, R, W> {
        let mut frame = first_frame::<N>();
        frame.truncate(count);
        Lyapunov {
            integrator: self,
            start: state.t,
            state,
            h,
            noise,
            step: 0,
            growth: vec![Growth::default(); frame.len()],
            frame,
            has_ended: false,
        }
    }
}

/// A path with its Lyapunov exponents, from [`Integrator::lyapunov`]: an iterator over the states
/// after each step.
///
/// Ends after an error, and at the end of a recorded path.
pub struct Lyapunov<'a, S: System, R, W> {
    integrator: &'a Integrator<S, R>,
    /// Time before the first step.
    start: f64,
    state: StateOf<S>,
    h: f64,
    noise: W,
    /// Steps made.
    step: u64,
    /// Orthonormal vectors of 2N entries, or zero.
    frame: Vec<Vec<f64>>,
    growth: Vec<Growth>,
    has_ended: bool,
}

/// The rates of growth along a vector of the frame.
#[derive(Clone, Debug, Default)]
struct Growth {
    rates: Blocking,
    /// True if the vector was mapped to zero.
    has_vanished: bool,
}

impl<S, R, Q, W: Noise, const N: usize, const M: usize> Lyapunov<'_, S, R, W>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    /// Makes so many steps.
    ///
    /// # Errors
    /// That of the first step that fails; [`StepError::Noise`] if a recorded path is at its end.
    pub fn advance(&mut self, steps: u64) -> Result<(), StepError> {
        for _ in 0..steps {
            if let Some(source) = self.next_state()? {
                let t = self.state.t;
                return Err(StepError::Noise { t, source });
            }
        }
        Ok(())
    }

    /// Makes a step. Returns the error of a recorded path at its end.
    fn next_state(&mut self) -> Result<Option<NoiseError>, StepError> {
        // An array, whose length its type knows.
        let mut dw = R::Increments::take(&mut Default::default(), || Ok::<_, StepError>(0))?;
        let (step, h) = (self.step, self.h);
        let t = self.state.t;
        match draw(&mut self.noise, step, h, R::STAGES, dw.as_mut()) {
            Ok(()) => {}
            Err(source @ NoiseError::Exhausted { .. }) => return Ok(Some(source)),
            Err(source) => return Err(StepError::Noise { t, source }),
        }
        let end = time_of_next(self.start, step + 1, h, t)?;
        let mut state = self.state;
        let (tangent, _) = self
            .integrator
            .step_with_derivatives(&mut state, h, dw.borrow())?;
        state.t = end;
        self.state = state;
        self.step += 1;
        self.grow(&tangent);
        Ok(None)
    }

    /// Maps the frame, makes it orthonormal again and adds the rates at which its vectors have
    /// grown.
    fn grow(&mut self, tangent: &Tangent<N>) {
        for i in 0..self.frame.len() {
            let (before, rest) = self.frame.split_at_mut(i);
            let vector = &mut rest[0];
            let mut image: Vec<f64> = (0..2 * N).map(|row| dot(&tangent[row], vector)).collect();
            let length = norm(&image);
            // twice, since one pass leaves errors of the size of what it takes away
            for _ in 0..2 {
                for other in &*before {
                    let along = dot(other, &image);
                    for (x, y) in image.iter_mut().zip(other) {
                        *x -= along * y;
                    }
                }
            }
            let left = norm(&image);
            if left <= ROUNDING * length {
                self.growth[i].has_vanished = true;
                vector.fill(0.0);
                continue;
            }
            self.growth[i].rates.push(left.ln() / self.h.abs());
            for (x, y) in vector.iter_mut().zip(image) {
                *x = y / left;
            }
        }
    }
}

impl<S: System, R, W> Lyapunov<'_, S, R, W> {
    /// Begins the averages anew: the first steps, in which the frame turns to the directions of the
    /// exponents, then do not count.
    pub fn restart(&mut self) {
        for growth in &mut self.growth {
            growth.rates = Blocking::new();
        }
    }

    /// The exponents, in units of 1/time: averages over all steps since the
    /// [restart](Self::restart); NaN before the first step, and −∞ for a direction that a step maps
    /// to zero.
    pub fn exponents(&self) -> Vec<f64> {
        let exponent = |growth: &Growth| {
            if growth.has_vanished {
                f64::NEG_INFINITY
            } else {
                growth.rates.mean()
            }
        };
        self.growth.iter().map(exponent).collect()
    }

    /// Statistical errors of the exponents, by [`Blocking`]; `None` for a path that is too short to
    /// tell.
    pub fn standard_errors(&self) -> Vec<Option<f64>> {
        let errors = self.growth.iter();
        errors.map(|growth| growth.rates.standard_error()).collect()
    }

    /// Returns the rates of growth of an exponent over all steps since the restart, as a running
    /// average; `None` if there are not so many exponents.
    pub fn rates(&self, exponent: usize) -> Option<&Blocking> {
        self.growth.get(exponent).map(|growth| &growth.rates)
    }

    /// The state reached so far.
    pub fn state(&self) -> &StateOf<S> {
        &self.state
    }

    /// Number of steps made so far.
    pub fn step(&self) -> u64 {
        self.step
    }
}

impl<S, R, Q, W: Noise, const N: usize, const M: usize> Iterator for Lyapunov<'_, S, R, W>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    type Item = Result<State<Q>, StepError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_ended {
            return None;
        }
        let made = self.next_state();
        self.has_ended = !matches!(made, Ok(None));
        match made {
            Ok(None) => Some(Ok(self.state)),
            Ok(Some(_)) => None,
            Err(error) => Some(Err(error)),
        }
    }
}

impl<S: System, R, W> fmt::Debug for Lyapunov<'_, S, R, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Lyapunov")
            .field("step", &self.step)
            .field("exponents", &self.exponents())
            .finish_non_exhaustive()
    }
}

/// Returns an orthonormal frame v₁ … vₙ, Jvₙ … Jv₁ in general position, with J(q, p) = (−p, q).
fn first_frame<const N: usize>() -> Vec<Vec<f64>> {
    let numbers = Wiener::new(0);
    let mut lagrangian: Vec<Vec<f64>> = Vec::with_capacity(N);
    for i in 0..N {
        let entry = |k| numbers.increment(k as u64, i, 1.0);
        let mut vector: Vec<f64> = (0..2 * N).map(entry).collect();
        for _ in 0..2 {
            for other in &lagrangian {
                for other in [other, &turned(other)] {
                    let along = dot(other, &vector);
                    for (x, y) in vector.iter_mut().zip(other) {
                        *x -= along * y;
                    }
                }
            }
        }
        let length = norm(&vector);
        lagrangian.push(vector.iter().map(|x| x / length).collect());
    }
    let conjugate: Vec<_> = lagrangian.iter().rev().map(|v| turned(v)).collect();
    lagrangian.into_iter().chain(conjugate).collect()
}

/// Returns (−p, q).
fn turned(vector: &[f64]) -> Vec<f64> {
    let (q, p) = vector.split_at(vector.len() / 2);
    p.iter().map(|x| -x).chain(q.iter().copied()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
