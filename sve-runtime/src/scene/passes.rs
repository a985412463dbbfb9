//! Passes over the components of all sites that a midpoint step makes between its sweeps.

use super::masses::InverseMasses;
use super::shear::name;
use crate::lanes::dispatch::{Kernel, dispatch};

/// Numbers of partial maxima, so that these are computed in vectors.
const PARTS: usize = 16;

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
            Factors::Each(factors) => self.1.run(
                #[inline(always)]
                |at| factors[at],
            ),
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
    fn run(self, factor: impl Fn(usize) -> f64) -> f64 {
        for (at, (d, p)) in self.d.iter_mut().zip(self.p).enumerate() {
            *d = factor(at) * p;
        }
        largest(self.d)
    }
}

/// Writes the nodes q₀ + d/2.
#[inline(always)]
pub(super) fn write_nodes(nodes: &mut [f64], q: &[f64], d: &[f64]) {
    for ((node, q), d) in nodes.iter_mut().zip(q).zip(d) {
        *node = q + 0.5 * d;
    }
}

/// Updates the displacements, Δ ← β Δ − α g with the residual g, and the nodes. Returns the largest
/// update, the largest displacement and the largest node.
pub(super) struct Update<'a> {
    pub(super) d: &'a mut [f64],
    pub(super) update: &'a mut [f64],
    pub(super) nodes: &'a mut [f64],
    pub(super) impulse: &'a [f64],
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
    /// α and β.
    pub(super) weights: [f64; 2],
}

impl Pass for Update<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn run(self, factor: impl Fn(usize) -> f64) -> [f64; 3] {
        let Self {
            d,
            update,
            nodes,
            impulse,
            q,
            p,
            weights: [alpha, beta],
        } = self;
        let n = d.len();
        let (update, nodes) = (&mut update[..n], &mut nodes[..n]);
        let (impulse, q, p) = (&impulse[..n], &q[..n], &p[..n]);
        let mut parts = [[0.0f64; PARTS]; 3];
        let mut at = 0;
        while at < n {
            let length = PARTS.min(n - at);
            for part in 0..length {
                let k = at + part;
                let residual = d[k] - factor(k) * (p[k] + 0.5 * impulse[k]);
                let change = beta * update[k] - alpha * residual;
                let new = d[k] + change;
                let node = q[k] + 0.5 * new;
                (update[k], d[k], nodes[k]) = (change, new, node);
                for (parts, value) in parts.iter_mut().zip([change, new, node]) {
                    let value = value.abs();
                    parts[part] = if value > parts[part] {
                        value
                    } else {
                        parts[part]
                    };
                }
            }
            at += PARTS;
        }
        parts.map(|parts| parts.into_iter().fold(0.0, f64::max))
    }
}

/// Returns the largest magnitude of numbers.
#[inline(always)]
pub(super) fn largest(numbers: &[f64]) -> f64 {
    let mut parts = [0.0f64; PARTS];
    for chunk in numbers.chunks(PARTS) {
        for (part, x) in parts.iter_mut().zip(chunk) {
            *part = if x.abs() > *part { x.abs() } else { *part };
        }
    }
    parts.into_iter().fold(0.0, f64::max)
}

/// The end of a step: q₁ = q₀ + d and p₁ = p₀ + I − N d. `rates` has N M⁻¹.
pub(super) struct End<'a> {
    pub(super) d: &'a [f64],
    pub(super) impulse: &'a [f64],
    pub(super) rates: &'a [f64],
    pub(super) masses: &'a InverseMasses,
    pub(super) q: &'a mut [f64],
    pub(super) p: &'a mut [f64],
}

impl End<'_> {
    /// Returns −N d of a component.
    #[inline(always)]
    fn friction(&self, at: usize) -> f64 {
        match self.rates.get(at) {
            Some(rate) => -rate / self.masses.of(at) * self.d[at],
            None => 0.0,
        }
    }

    /// Returns whether the end is finite.
    #[inline(always)]
    #[allow(clippy::eq_op)] // the difference of two infinite numbers is NaN
    pub(super) fn is_finite(&self) -> bool {
        let mut bits = 0;
        for at in 0..self.d.len() {
            let q = self.q[at] + self.d[at];
            let p = self.p[at] + self.impulse[at] + self.friction(at);
            bits |= (q - q).to_bits() | (p - p).to_bits();
        }
        bits << 1 == 0
    }

    /// Returns the name of the first component that is not finite.
    #[cold]
    pub(super) fn not_finite(&self, length: usize) -> String {
        let p = |at: usize| self.p[at] + self.impulse[at] + self.friction(at);
        let n = self.d.len();
        let found = (0..n).find(|&at| !(self.q[at] + self.d[at]).is_finite());
        let in_p = || (0..n).find(|&at| !p(at).is_finite());
        match (found, in_p) {
            (Some(at), _) => name("q", at, length),
            (None, in_p) => in_p().map_or_else(String::new, |at| name("p", at, length)),
        }
    }

    /// Writes the end.
    #[inline(always)]
    pub(super) fn write(self) {
        for at in 0..self.d.len() {
            self.q[at] += self.d[at];
            self.p[at] = self.p[at] + self.impulse[at] + self.friction(at);
        }
    }
}
