//! Passes over the components of all sites that a midpoint step makes between its sweeps.

use core::ops::Range;

use super::masses::InverseMasses;
use crate::lanes::dispatch::{Kernel, dispatch};

/// The factors f of the displacements `d = f (p₀ + I/2)`.
#[derive(Clone, Debug)]
pub(super) enum Factors {
    /// All components have this one.
    Uniform(f64),
    /// One for each component.
    Each(Vec<f64>),
}

/// Factors of consecutive components. All functions are `#[inline(always)]`.
pub(super) trait Factor: Copy {
    /// Returns the factors of some of the components.
    fn within(self, here: Range<usize>) -> Self;
    /// Returns the factor of a component.
    fn of(self, component: usize) -> f64;
}

impl Factor for f64 {
    #[inline(always)]
    fn within(self, _: Range<usize>) -> Self {
        self
    }

    #[inline(always)]
    fn of(self, _: usize) -> f64 {
        self
    }
}

impl Factor for &[f64] {
    #[inline(always)]
    fn within(self, here: Range<usize>) -> Self {
        &self[here]
    }

    #[inline(always)]
    fn of(self, component: usize) -> f64 {
        self[component]
    }
}

/// A computation with the factors of all components. `run` is `#[inline(always)]`.
pub(super) trait Pass {
    type Output;
    /// Computes the result.
    fn run(self, factors: impl Factor) -> Self::Output;
}

struct WithFactors<'a, P>(&'a Factors, P);

impl<P: Pass> Kernel for WithFactors<'_, P> {
    type Output = P::Output;

    #[inline(always)]
    fn run(self) -> P::Output {
        match self.0 {
            Factors::Uniform(factor) => self.1.run(*factor),
            Factors::Each(factors) => self.1.run(&**factors),
        }
    }
}

impl Factors {
    /// Returns the factors `h / (m + h ν/2)`, or the component whose divisor is not of the sign of
    /// its mass.
    pub(super) fn new(masses: &InverseMasses, rates: &[f64], h: f64) -> Result<Self, usize> {
        if rates.is_empty() {
            return Ok(match masses {
                InverseMasses::Uniform(inverse) => Self::Uniform(h * inverse),
                InverseMasses::Each(inverse) => {
                    Self::Each(inverse.iter().map(|inverse| h * inverse).collect())
                }
            });
        }
        let divisor = |rate: f64| 1.0 + 0.5 * h * rate;
        if let Some(at) = rates.iter().position(|&rate| divisor(rate) <= 0.0) {
            return Err(at);
        }
        let factor = |(at, &rate): (usize, &f64)| h * masses.of(at) / divisor(rate);
        Ok(Self::Each(rates.iter().enumerate().map(factor).collect()))
    }

    /// Returns whether all factors have the same sign.
    pub(super) fn have_one_sign(&self) -> bool {
        match self {
            Self::Uniform(_) => true,
            Self::Each(factors) => {
                factors.iter().all(|&f| f > 0.0) || factors.iter().all(|&f| f < 0.0)
            }
        }
    }

    /// Makes a pass with the widest vectors of this machine.
    pub(super) fn pass<P: Pass>(&self, pass: P) -> P::Output {
        dispatch(WithFactors(self, pass))
    }
}

/// Begins a solution: the nodes c = q₀ + f p₀/2 of displacements without impulses, in two arrays.
/// Returns the largest displacement f p₀ and the largest place.
pub(super) struct Begin<'a> {
    pub(super) centres: [&'a mut [f64]; 2],
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
}

impl Pass for Begin<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn run(self, factors: impl Factor) -> [f64; 2] {
        begin(self.centres, self.q, self.p, factors)
    }
}

#[inline(always)]
fn begin([a, b]: [&mut [f64]; 2], q: &[f64], p: &[f64], factors: impl Factor) -> [f64; 2] {
    let n = q.len();
    let (a, b, p) = (&mut a[..n], &mut b[..n], &p[..n]);
    let factors = factors.within(0..n);
    let (mut largest, mut farthest) = (Largest::default(), Largest::default());
    for at in 0..n {
        let d = factors.of(at) * p[at];
        a[at] = q[at] + 0.5 * d;
        b[at] = a[at];
        largest.add(d);
        farthest.add(q[at]);
    }
    [largest, farthest].map(Largest::value)
}

/// Writes the velocities of displacements without impulses.
pub(super) struct FirstVelocities<'a> {
    pub(super) v: &'a mut [f64],
    pub(super) p: &'a [f64],
    pub(super) h: f64,
}

impl Pass for FirstVelocities<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, factors: impl Factor) {
        for (at, (v, p)) in self.v.iter_mut().zip(self.p).enumerate() {
            *v = factors.of(at) * p / self.h;
        }
    }
}

/// Ends a step: the places q₀ + d, and the momenta.
pub(super) struct Finish<'a> {
    pub(super) q: &'a mut [f64],
    pub(super) p: &'a mut [f64],
    pub(super) d: &'a [f64],
    pub(super) end: &'a [f64],
}

impl Kernel for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (q, d) in self.q.iter_mut().zip(self.d) {
            *q += d;
        }
        self.p.copy_from_slice(self.end);
    }
}

/// The largest magnitude of numbers. NaN is larger than all others.
///
/// It is stored as its bits, whose order is that of the numbers: loops over a maximum of integers
/// are made in vectors.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Largest(i64);

impl Largest {
    #[inline(always)]
    pub(super) fn add(&mut self, x: f64) {
        self.0 = self.0.max(x.abs().to_bits().cast_signed());
    }

    pub(super) fn value(self) -> f64 {
        f64::from_bits(self.0.cast_unsigned())
    }
}
