//! The numbers of a site.

use core::array::from_fn;
use core::fmt::Debug;

use super::KineticJet;
use crate::error::{StepError, step_error};
use crate::mechanics::connected::{affine_velocity, connected_velocity};
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::solve::newton::Evaluation;

/// The numbers of a site, `[f64; D]`; `[f64; 1]` for a configuration `&[f64]`.
pub trait Row: Sealed + Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Number of components.
    const LENGTH: usize;
    /// Zeros.
    const ZERO: Self;
    /// Numbers that are not finite.
    const NAN: Self;
    /// A square matrix that acts on rows.
    type Matrix: Copy + Debug;
    /// Zeros.
    const ZERO_MATRIX: Self::Matrix;

    /// Adds the components of another row.
    fn add(&mut self, other: Self);
    /// Returns the components of several rows.
    fn numbers(rows: &[Self]) -> &[f64];
    /// Returns the components of several rows.
    fn numbers_mut(rows: &mut [Self]) -> &mut [f64];
    /// Returns the rows with these components.
    fn rows(numbers: &[f64]) -> &[Self];
    /// Returns the rows with these components.
    fn rows_mut(numbers: &mut [f64]) -> &mut [Self];
    /// Adds a multiple of some numbers.
    fn add_scaled(&mut self, factor: f64, numbers: &[f64]);
    /// Returns the velocity with this momentum, for a kinetic energy with the derivatives `jet` and
    /// with `damping` on the diagonal of ∂²T/∂v²: the one that is connected with `near`.
    ///
    /// # Errors
    /// As the inverse Legendre transform of a system.
    #[doc(hidden)]
    fn velocity(
        &self,
        near: &Self,
        damping: &Self,
        is_affine: bool,
        jet: impl Fn(&Self) -> KineticJet<Self>,
    ) -> Result<Self, SolveError>;
    /// Returns the error of a step that starts with one site, of the time `t` and the length `h`.
    #[doc(hidden)]
    fn step_error(error: SolveError, times: [f64; 2], q: Self, p: Self) -> StepError;
}

#[doc(hidden)]
pub trait Sealed {}

impl<const D: usize> Sealed for [f64; D] {}

impl<const D: usize> Row for [f64; D] {
    const LENGTH: usize = D;
    const ZERO: Self = [0.0; D];
    const NAN: Self = [f64::NAN; D];
    type Matrix = [[f64; D]; D];
    const ZERO_MATRIX: Self::Matrix = [[0.0; D]; D];

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
    fn rows(numbers: &[f64]) -> &[Self] {
        numbers.as_chunks().0
    }

    #[inline(always)]
    fn rows_mut(numbers: &mut [f64]) -> &mut [Self] {
        numbers.as_chunks_mut().0
    }

    #[inline(always)]
    fn add_scaled(&mut self, factor: f64, numbers: &[f64]) {
        for (x, y) in self.iter_mut().zip(numbers) {
            *x += factor * y;
        }
    }

    fn velocity(
        &self,
        near: &Self,
        damping: &Self,
        is_affine: bool,
        jet: impl Fn(&Self) -> KineticJet<Self>,
    ) -> Result<Self, SolveError> {
        let damped = |v: &Self| {
            let mut jet = jet(v);
            for i in 0..D {
                jet.dv[i] += damping[i] * v[i];
                jet.dvv[i][i] += damping[i];
            }
            jet
        };
        if is_affine {
            let of_rest = damped(&Self::ZERO);
            return affine_velocity(self, &of_rest.dv, &of_rest.dvv);
        }
        if !self.iter().all(|p| p.is_finite()) {
            return Err(SolveError::NonFinite);
        }
        connected_velocity(self, near, |v, target| {
            let jet = damped(v);
            Evaluation {
                residual: from_fn(|i| jet.dv[i] - target[i] + jet.undefined),
                magnitude: from_fn(|i| jet.dv[i].abs() + target[i].abs()),
                jacobian: jet.dvv,
                curvature: f64::NAN,
            }
        })
    }

    fn step_error(error: SolveError, [t, h]: [f64; 2], q: Self, p: Self) -> StepError {
        step_error(error, &State::at(t, q, p), h, &[])
    }
}
