//! Passes over the components of all sites that a midpoint step makes between its sweeps.

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

/// A computation with the factor of each component. `run` is `#[inline(always)]`.
pub(super) trait Pass {
    type Output;
    /// Returns the number of components.
    fn components(&self) -> usize;
    /// Computes the result. `factor` is called with numbers of components.
    fn run(self, factor: impl Fn(usize) -> f64) -> Self::Output;
}

struct WithFactors<'a, P>(&'a Factors, P);

impl<P: Pass> Kernel for WithFactors<'_, P> {
    type Output = P::Output;

    #[inline(always)]
    fn run(self) -> P::Output {
        match self.0 {
            Factors::Uniform(factor) => self.1.run(
                #[inline(always)]
                |_| *factor,
            ),
            Factors::Each(factors) => {
                // so that the loops have no bounds to check
                let factors = &factors[..self.1.components()];
                self.1.run(
                    #[inline(always)]
                    |at| factors[at],
                )
            }
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

/// Writes the displacements with the momenta of the start. Returns the largest one.
pub(super) struct Guess<'a> {
    pub(super) d: &'a mut [f64],
    pub(super) p: &'a [f64],
}

impl Pass for Guess<'_> {
    type Output = f64;

    #[inline(always)]
    fn components(&self) -> usize {
        self.d.len()
    }

    #[inline(always)]
    fn run(self, factor: impl Fn(usize) -> f64) -> f64 {
        let n = self.d.len();
        let p = &self.p[..n];
        for at in 0..n {
            self.d[at] = factor(at) * p[at];
        }
        largest(self.d)
    }
}

/// Writes the nodes q₀ + d/2.
pub(super) struct WriteNodes<'a>(
    pub(super) &'a mut [f64],
    pub(super) &'a [f64],
    pub(super) &'a [f64],
);

impl Kernel for WriteNodes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self(nodes, q, d) = self;
        for ((node, q), d) in nodes.iter_mut().zip(q).zip(d) {
            *node = q + 0.5 * d;
        }
    }
}

/// Replaces a largest magnitude by that of `x` if this is larger.
#[inline(always)]
pub(super) fn keep_larger(largest: &mut f64, x: f64) {
    let x = x.abs();
    *largest = if x > *largest { x } else { *largest };
}

/// Returns the largest magnitude of numbers.
#[inline(always)]
pub(super) fn largest(numbers: &[f64]) -> f64 {
    let mut parts = [0.0f64; PARTS];
    let (chunks, rest) = numbers.as_chunks::<PARTS>();
    for chunk in chunks {
        for part in 0..PARTS {
            keep_larger(&mut parts[part], chunk[part]);
        }
    }
    for (part, x) in rest.iter().enumerate() {
        keep_larger(&mut parts[part], *x);
    }
    parts.into_iter().fold(0.0, f64::max)
}

/// Adds the impulse −N d of friction to momenta; `rates` has N M⁻¹.
pub(super) fn add_friction(p: &mut [f64], d: &[f64], rates: &[f64], masses: &InverseMasses) {
    for (at, ((p, d), rate)) in p.iter_mut().zip(d).zip(rates).enumerate() {
        *p -= rate / masses.of(at) * d;
    }
}

/// The test whether all sums of two numbers are finite.
pub(super) struct SumsAreFinite<'a>(pub(super) &'a [f64], pub(super) &'a [f64]);

impl Kernel for SumsAreFinite<'_> {
    type Output = bool;

    #[inline(always)]
    #[allow(clippy::eq_op)] // the difference of two infinite numbers is NaN
    fn run(self) -> bool {
        let sums = self.0.iter().zip(self.1).map(|(a, b)| a + b);
        sums.fold(0, |bits, x| bits | (x - x).to_bits()) == 0
    }
}

/// Adds the numbers of the second array to those of the first.
pub(super) struct Add<'a>(pub(super) &'a mut [f64], pub(super) &'a [f64]);

impl Kernel for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (to, by) in self.0.iter_mut().zip(self.1) {
            *to += by;
        }
    }
}
