//! Tangent vectors of the states in the lanes, and functions for their step along the paths
//! (`docs/mathematics.md`, section 8).
//!
//! Input: the unknowns of a step that was solved in lanes, and tangent vectors before the step.
//! Output: the vectors after it. Invariant: a vector depends on its lane only. If a vector is not
//! finite, the step of a single state computes it and returns the error.

use crate::lanes::{Aligned, LANES, Lane, Mask, needs_scalar_step};
use crate::phase::Field;
use crate::solve::dense::SINGULAR;

/// A tangent vector in each lane. Each component is an array over the lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct TangentLanes<const N: usize> {
    /// Components along the coordinates.
    pub q: [Lane; N],
    /// Components along the momenta.
    pub p: [Lane; N],
}

/// Tangent vectors in lanes, with components of type `V`.
pub trait FieldLanes<V>: Copy + core::fmt::Debug {
    /// Returns the same vector in each lane.
    fn splat(field: &Field<V>) -> Self;
    /// Returns the vector of a lane.
    fn get(&self, lane: usize) -> Field<V>;
    /// Replaces the vector of a lane.
    fn set(&mut self, lane: usize, field: &Field<V>);
}

impl<const N: usize> FieldLanes<[f64; N]> for TangentLanes<N> {
    fn splat(field: &Field<[f64; N]>) -> Self {
        Self {
            q: field.q.map(|x| [x; LANES]),
            p: field.p.map(|x| [x; LANES]),
        }
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Field<[f64; N]> {
        Field {
            q: core::array::from_fn(|i| self.q[i][lane]),
            p: core::array::from_fn(|i| self.p[i][lane]),
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, field: &Field<[f64; N]>) {
        for i in 0..N {
            self.q[i][lane] = field.q[i];
            self.p[i][lane] = field.p[i];
        }
    }
}

/// Tangent vectors of the states in the lanes, which a step carries along.
#[derive(Debug)]
pub struct LaneDirections<'a, L> {
    /// The vectors before the step.
    pub start: &'a [L],
    /// The vectors after the step.
    pub next: &'a mut [L],
    /// The parameter that varies with each vector in this step; `None` if no parameter varies.
    pub parameters: &'a [Option<usize>],
}

/// The memory in which a step in lanes stores its unknowns.
pub trait KeepUnknowns {
    /// Stores the unknowns of a block in a lane, from number `first` on.
    fn keep<const B: usize>(&mut self, lane: usize, first: usize, values: [f64; B]);
}

/// Stores nothing.
impl KeepUnknowns for () {
    #[inline(always)]
    fn keep<const B: usize>(&mut self, _: usize, _: usize, _: [f64; B]) {}
}

impl<const K: usize> KeepUnknowns for Aligned<[Lane; K]> {
    #[inline(always)]
    fn keep<const B: usize>(&mut self, lane: usize, first: usize, values: [f64; B]) {
        for i in 0..B {
            self.0[first + i][lane] = values[i];
        }
    }
}

/// Returns the derivative of each of `P` parameters along a direction: 1 for the parameter that
/// varies, otherwise 0.
#[inline(always)]
pub fn seeds<const P: usize>(varied: Option<usize>) -> [f64; P] {
    core::array::from_fn(|parameter| f64::from(u8::from(varied == Some(parameter))))
}

/// Returns the inverse of `a`. With two rows, the result is not finite where the scalar solve finds
/// the matrix singular.
#[inline(always)]
pub fn regular_inverse<const K: usize>(a: &[[f64; K]; K]) -> [[f64; K]; K] {
    if K != 2 {
        return crate::lanes::solve::inverse(a);
    }
    let (ad, bc) = (a[0][0] * a[1][1], a[0][1] * a[1][0]);
    let det = ad - bc;
    let is_singular = det.abs() <= SINGULAR * (ad.abs() + bc.abs());
    let scale = if is_singular { f64::NAN } else { 1.0 / det };
    let mut inverse = [[0.0; K]; K];
    inverse[0][0] = a[1][1] * scale;
    inverse[0][1] = -a[0][1] * scale;
    inverse[1][0] = -a[1][0] * scale;
    inverse[1][1] = a[0][0] * scale;
    inverse
}

/// Returns the mask of the lanes with a vector that is not finite. `any` is 0 if there are no such
/// vectors, so that the lanes are seldom searched.
#[inline(always)]
pub fn unfinished<const N: usize>(any: u64, fields: &[TangentLanes<N>]) -> Mask {
    if any == 0 {
        return 0;
    }
    search_unfinished(fields)
}

#[cold]
fn search_unfinished<const N: usize>(fields: &[TangentLanes<N>]) -> Mask {
    let mut mask = 0;
    for field in fields {
        for lane in 0..LANES {
            let Field { q, p } = field.get(lane);
            if needs_scalar_step(q, p, true) != 0 {
                mask |= 1 << lane;
            }
        }
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::regular_inverse;

    #[test]
    fn the_inverse_of_a_singular_matrix_is_not_finite() {
        assert!(!regular_inverse(&[[0.0]])[0][0].is_finite());
        let third = 1.0 / 3.0;
        let a = [[1.0, third], [3.0, 3.0 * third]];
        assert!(
            regular_inverse(&a)
                .as_flattened()
                .iter()
                .all(|x| x.is_nan())
        );
        let a = [[2.0, 1.0], [1.0, 1.0]];
        assert_eq!(regular_inverse(&a), [[1.0, -1.0], [-1.0, 2.0]]);
    }
}
