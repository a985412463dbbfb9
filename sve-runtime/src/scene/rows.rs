//! The numbers of a site.

use core::fmt::Debug;

/// The numbers of a site, `[f64; D]`; `[f64; 1]` for a configuration `&[f64]`.
pub trait Row: Sealed + Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Number of components.
    const LENGTH: usize;
    /// Zeros.
    const ZERO: Self;

    /// Adds the components of another row.
    fn add(&mut self, other: Self);
    /// Returns the components of several rows.
    fn numbers(rows: &[Self]) -> &[f64];
    /// Returns the components of several rows.
    fn numbers_mut(rows: &mut [Self]) -> &mut [f64];
    /// Returns the rows with these components.
    fn rows_mut(numbers: &mut [f64]) -> &mut [Self];
}

#[doc(hidden)]
pub trait Sealed {}

impl<const D: usize> Sealed for [f64; D] {}

impl<const D: usize> Row for [f64; D] {
    const LENGTH: usize = D;
    const ZERO: Self = [0.0; D];

    #[inline(always)]
    fn add(&mut self, other: Self) {
        for (x, y) in self.iter_mut().zip(other) {
            *x += y;
        }
    }

    #[inline(always)]
    fn numbers(rows: &[Self]) -> &[f64] {
        rows.as_flattened()
    }

    #[inline(always)]
    fn numbers_mut(rows: &mut [Self]) -> &mut [f64] {
        rows.as_flattened_mut()
    }

    #[inline(always)]
    fn rows_mut(numbers: &mut [f64]) -> &mut [Self] {
        numbers.as_chunks_mut().0
    }
}
