//! Configurations of any length: a vector of sites, each a number, a row of numbers or a vector of
//! nalgebra.

use core::fmt::Debug;

use nalgebra::SVector;

use super::{Configuration, add};

/// A site of a scene. A slice of sites is a slice of rows of numbers in the same memory.
pub trait Site: Copy + Debug + PartialEq + Send + Sync + sealed::Sealed + 'static {
    /// A row of numbers, `[f64; D]`; `[f64; 1]` for a number.
    type Row: AsRef<[f64]> + AsMut<[f64]> + Copy;
    /// Number of numbers of a site.
    const NUMBERS: usize;
    /// Returns the rows of sites.
    fn rows(sites: &[Self]) -> &[Self::Row];
    /// Returns the rows of sites, to be changed.
    fn rows_mut(sites: &mut [Self]) -> &mut [Self::Row];
    /// Returns the site with the numbers zero.
    fn zero() -> Self;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl<const D: usize> Sealed for [f64; D] {}
    impl<const D: usize> Sealed for nalgebra::SVector<f64, D> {}
}

impl Site for f64 {
    type Row = [f64; 1];
    const NUMBERS: usize = 1;

    #[inline(always)]
    fn rows(sites: &[f64]) -> &[[f64; 1]] {
        sites.as_chunks().0
    }

    #[inline(always)]
    fn rows_mut(sites: &mut [f64]) -> &mut [[f64; 1]] {
        sites.as_chunks_mut().0
    }

    fn zero() -> f64 {
        0.0
    }
}

impl<const D: usize> Site for [f64; D] {
    type Row = Self;
    const NUMBERS: usize = D;

    #[inline(always)]
    fn rows(sites: &[Self]) -> &[Self] {
        sites
    }

    #[inline(always)]
    fn rows_mut(sites: &mut [Self]) -> &mut [Self] {
        sites
    }

    fn zero() -> Self {
        [0.0; D]
    }
}

impl<const D: usize> Site for SVector<f64, D> {
    type Row = [f64; D];
    const NUMBERS: usize = D;

    #[inline(always)]
    fn rows(sites: &[Self]) -> &[[f64; D]] {
        bytemuck::cast_slice(sites)
    }

    #[inline(always)]
    fn rows_mut(sites: &mut [Self]) -> &mut [[f64; D]] {
        bytemuck::cast_slice_mut(sites)
    }

    fn zero() -> Self {
        Self::zeros()
    }
}

/// A vector space whose dimension is the number of sites times the numbers of a site. Stored values
/// and increments follow one another in the order of the sites.
impl<Q: Site> Configuration for Vec<Q> {
    type Momentum = Self;

    fn degrees_of_freedom(&self) -> usize {
        self.len() * Q::NUMBERS
    }

    fn stored_values(&self) -> usize {
        self.degrees_of_freedom()
    }

    fn store(&self, values: &mut [f64]) {
        assert_eq!(values.len(), self.stored_values(), "another length");
        for (row, values) in Q::rows(self)
            .iter()
            .zip(values.chunks_exact_mut(Q::NUMBERS.max(1)))
        {
            values.copy_from_slice(row.as_ref());
        }
    }

    fn restore(&mut self, values: &[f64]) {
        assert_eq!(values.len(), self.stored_values(), "another length");
        let rows = Q::rows_mut(self).iter_mut();
        for (row, values) in rows.zip(values.chunks_exact(Q::NUMBERS.max(1))) {
            row.as_mut().copy_from_slice(values);
        }
    }

    fn retract(&mut self, increment: &[f64]) {
        assert_eq!(increment.len(), self.stored_values(), "another length");
        let rows = Q::rows_mut(self).iter_mut();
        for (row, increment) in rows.zip(increment.chunks_exact(Q::NUMBERS.max(1))) {
            add(row.as_mut(), increment);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::{Configuration, Site};

    /// Stores, restores and moves a configuration of sites.
    fn check<Q: Site>(sites: &[Q], values: &[f64]) {
        let sites = sites.to_vec();
        assert_eq!(sites.degrees_of_freedom(), values.len());
        let mut stored = vec![0.0; sites.stored_values()];
        sites.store(&mut stored);
        assert_eq!(stored, values);
        let mut again = vec![Q::zero(); sites.len()];
        again.retract(values);
        assert_eq!(again, sites);
        again.fill(Q::zero());
        again.restore(values);
        assert_eq!(again, sites);
        let rows: Vec<f64> = Q::rows(&sites)
            .iter()
            .flat_map(|row| row.as_ref().to_vec())
            .collect();
        assert_eq!(rows, values);
        if let Some(row) = Q::rows_mut(&mut again).last_mut() {
            row.as_mut()[0] = 7.0;
            again.store(&mut stored);
            assert_eq!(stored[values.len() - Q::NUMBERS], 7.0);
        }
    }

    #[test]
    fn sites_are_rows_in_the_same_memory() {
        check(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0]);
        check(&[[1.0, 2.0], [3.0, 4.0]], &[1.0, 2.0, 3.0, 4.0]);
        check(
            &[Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0)],
            &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        );
        check::<[f64; 3]>(&[], &[]);
    }
}
