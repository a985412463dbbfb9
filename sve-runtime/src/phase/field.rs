//! Tangent vectors of phase space.

use crate::phase::configuration::{Configuration as _, FixedSize};

/// A tangent vector of phase space: `(q̇, ṗ)`, or the field of a noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field<V> {
    /// Component along `q`.
    pub q: V,
    /// Component along `p`.
    pub p: V,
}

impl<V: AsRef<[f64]> + AsMut<[f64]>> Field<V> {
    /// Returns the field of a configuration with these components.
    #[inline(always)]
    pub(crate) fn of<Q: FixedSize>(self) -> Field<Q::Momentum> {
        let [mut q, mut p] = [Q::no_momentum(); 2];
        q.restore(self.q.as_ref());
        p.restore(self.p.as_ref());
        Field { q, p }
    }

    /// Adds a multiple of another field.
    #[inline]
    pub(crate) fn add_scaled(&mut self, scale: f64, other: &Self) {
        let [q, p] = [other.q.as_ref(), other.p.as_ref()];
        for (to, from) in self.q.as_mut().iter_mut().zip(q) {
            *to += scale * from;
        }
        for (to, from) in self.p.as_mut().iter_mut().zip(p) {
            *to += scale * from;
        }
    }
}
