//! Tangent vectors of phase space.

use crate::phase::configuration::Coordinates;

/// A tangent vector of phase space: `(q̇, ṗ)`, or the field of a noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field<V> {
    /// Component along `q`.
    pub q: V,
    /// Component along `p`.
    pub p: V,
}

impl<const N: usize> Field<[f64; N]> {
    /// The field of a configuration with these components.
    #[inline(always)]
    pub(crate) fn of<Q: Coordinates<N>>(self) -> Field<Q::Momentum> {
        Field {
            q: Q::from_components(&self.q),
            p: Q::from_components(&self.p),
        }
    }

    /// Adds a multiple of another field.
    #[inline]
    pub(crate) fn add_scaled(&mut self, scale: f64, other: &Self) {
        for i in 0..N {
            self.q[i] += scale * other.q[i];
            self.p[i] += scale * other.p[i];
        }
    }
}
