//! Passes over the components of all sites that a midpoint step makes between its sweeps.

use core::ops::Range;

use super::masses::InverseMasses;
use crate::lanes::dispatch::{Kernel, dispatch};

/// Numbers of partial maxima, so that these are computed in vectors.
pub(super) const PARTS: usize = 16;

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
    /// Returns the factors of one chunk of components.
    fn chunk(self, number: usize) -> [f64; PARTS];
    /// Returns the factor of a component.
    fn of(self, component: usize) -> f64;
    /// Returns the factor of all components, if they have one.
    fn of_all(self) -> Option<f64>;
}

impl Factor for f64 {
    #[inline(always)]
    fn within(self, _: Range<usize>) -> Self {
        self
    }

    #[inline(always)]
    fn chunk(self, _: usize) -> [f64; PARTS] {
        [self; PARTS]
    }

    #[inline(always)]
    fn of(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn of_all(self) -> Option<f64> {
        Some(self)
    }
}

impl Factor for &[f64] {
    #[inline(always)]
    fn within(self, here: Range<usize>) -> Self {
        &self[here]
    }

    #[inline(always)]
    fn chunk(self, number: usize) -> [f64; PARTS] {
        self.as_chunks().0[number]
    }

    #[inline(always)]
    fn of(self, component: usize) -> f64 {
        self[component]
    }

    #[inline(always)]
    fn of_all(self) -> Option<f64> {
        None
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

    /// Returns the factor of a component.
    pub(super) fn of(&self, component: usize) -> f64 {
        match self {
            Self::Uniform(factor) => *factor,
            Self::Each(factors) => factors[component],
        }
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

/// Begins a solution: the nodes c = q₀ + f p₀/2 of displacements without impulses. Returns the largest
/// displacement f p₀.
pub(super) struct Begin<'a> {
    pub(super) centres: &'a mut [f64],
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
}

impl Pass for Begin<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(self, factors: impl Factor) -> f64 {
        begin(self.centres, self.q, self.p, factors)
    }
}

#[inline(always)]
fn begin(centres: &mut [f64], q: &[f64], p: &[f64], factors: impl Factor) -> f64 {
    let mut most = [0; PARTS];
    let (chunks, rest) = centres.as_chunks_mut::<PARTS>();
    let [(qs, q), (ps, p)] = [q, p].map(|x| x.as_chunks::<PARTS>());
    let first = chunks.len() * PARTS;
    for (at, ((centre, q), p)) in chunks.iter_mut().zip(qs).zip(ps).enumerate() {
        let factor = factors.chunk(at);
        for k in 0..PARTS {
            let d = factor[k] * p[k];
            centre[k] = q[k] + 0.5 * d;
            keep_larger(&mut most[k], d);
        }
    }
    let mut largest = largest_part(&most).to_bits();
    for (k, ((centre, q), p)) in rest.iter_mut().zip(q).zip(p).enumerate() {
        let d = factors.of(first + k) * p;
        *centre = q + 0.5 * d;
        keep_larger(&mut largest, d);
    }
    f64::from_bits(largest)
}

/// Ends a step: the places q₀ + (f p₀ + e), and the momenta.
pub(super) struct Finish<'a> {
    pub(super) q: &'a mut [f64],
    pub(super) p: &'a mut [f64],
    pub(super) e: &'a [f64],
    pub(super) end: &'a [f64],
}

impl Pass for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, factors: impl Factor) {
        let Self { q, p, e, end } = self;
        finish(q, p, e, end, factors.within(0..e.len()));
    }
}

#[inline(always)]
fn finish(q: &mut [f64], p: &mut [f64], e: &[f64], end: &[f64], factors: impl Factor) {
    let n = e.len();
    let (q, p, end) = (&mut q[..n], &mut p[..n], &end[..n]);
    for at in 0..n {
        q[at] += factors.of(at) * p[at] + e[at];
    }
    p.copy_from_slice(end);
}

/// Writes the nodes c + e/2.
pub(super) struct WriteNodes<'a>(
    pub(super) &'a mut [f64],
    pub(super) &'a [f64],
    pub(super) &'a [f64],
);

impl Kernel for WriteNodes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self(nodes, centres, e) = self;
        for ((node, centre), e) in nodes.iter_mut().zip(centres).zip(e) {
            *node = centre + 0.5 * e;
        }
    }
}

/// Replaces a largest magnitude by that of `x` if this is larger. NaN is larger than all numbers.
///
/// A magnitude is stored as its bits, whose order is that of the numbers.
#[inline(always)]
pub(super) fn keep_larger(largest: &mut u64, x: f64) {
    *largest = x.abs().to_bits().max(*largest);
}

/// Returns the largest magnitude of numbers.
#[inline(always)]
pub(super) fn largest(numbers: &[f64]) -> f64 {
    let mut parts = [0; PARTS];
    let (chunks, rest) = numbers.as_chunks::<PARTS>();
    for chunk in chunks {
        for part in 0..PARTS {
            keep_larger(&mut parts[part], chunk[part]);
        }
    }
    let mut largest = largest_part(&parts).to_bits();
    for x in rest {
        keep_larger(&mut largest, *x);
    }
    f64::from_bits(largest)
}

/// Returns the largest of partial maxima.
#[inline(always)]
pub(super) fn largest_part(parts: &[u64; PARTS]) -> f64 {
    f64::from_bits(parts.iter().fold(0, |largest, part| *part.max(&largest)))
}
