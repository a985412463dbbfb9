//! Numbers of particles in the order of space.
//!
//! Input: positions. Output: a permutation of the particles along a Hilbert curve, and its use.
//! Invariant: each particle occurs once; particles of the same place keep their order.
//!
//! Source: J. Skilling, *Programming the Hilbert curve*, AIP Conf. Proc. 707 (2004) 381–387.

use super::NeighbourError;

/// Number of binary digits of a place along an axis: three of them fit into a word.
const DIGITS: u32 = 20;

/// A numbering of particles by their place, from [`Neighbours::order`](crate::Neighbours::order).
///
/// ```
/// use sve_runtime::{NeighbourError, Neighbours};
///
/// # fn main() -> Result<(), NeighbourError> {
/// let q = [[0.0, 0.0], [9.0, 9.0], [0.0, 0.1], [9.0, 8.9]];
/// let (mass, bonds) = ([1.0, 2.0, 3.0, 4.0], [[0, 2], [1, 3]]);
/// let order = Neighbours::open(1.0, 0.2)?.order(&q)?;
/// let (q, mass) = (order.apply(&q)?, order.apply(&mass)?);
/// let bonds = bonds.map(|bond| bond.map(|old| order.new_numbers()[old]));
/// assert_eq!(mass[..2], [1.0, 3.0]); // close particles have close numbers
/// assert!(bonds.iter().all(|[a, b]| a.abs_diff(*b) == 1));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpaceOrder {
    old: Vec<usize>,
    new: Vec<usize>,
}

impl SpaceOrder {
    /// Orders positions, none of which is negative.
    pub(super) fn of<const D: usize>(positions: &[[f64; D]]) -> Self {
        let largest = positions.iter().flatten().copied().fold(0.0, f64::max);
        let cells = f64::from(1_u32 << DIGITS) - 1.0;
        let place = |x: f64| {
            if largest > 0.0 {
                x / largest * cells
            } else {
                0.0
            }
        };
        #[allow(clippy::cast_sign_loss)] // it is not negative
        let keys = positions
            .iter()
            .map(|at| hilbert(at.map(|x| place(x) as u32)));
        let mut keys: Vec<_> = keys.zip(0..).collect();
        keys.sort_unstable();
        let old: Vec<usize> = keys.into_iter().map(|(_, particle)| particle).collect();
        let mut new = vec![0; old.len()];
        for (number, &particle) in old.iter().enumerate() {
            new[particle] = number;
        }
        Self { old, new }
    }

    /// Returns values of the particles in the order of space: `q`, `p`, masses, kinds.
    ///
    /// # Errors
    /// [`NeighbourError::Length`] if there is another number of values than of particles.
    pub fn apply<T: Clone>(&self, values: &[T]) -> Result<Vec<T>, NeighbourError> {
        let (expected, found) = (self.old.len(), values.len());
        if expected != found {
            return Err(NeighbourError::Length { expected, found });
        }
        Ok(self.old.iter().map(|&old| values[old].clone()).collect())
    }

    /// Returns the old number of each particle.
    pub fn old_numbers(&self) -> &[usize] {
        &self.old
    }

    /// Returns the new number of each old one, for lists of bonds.
    pub fn new_numbers(&self) -> &[usize] {
        &self.new
    }
}

/// Returns the place of a cell along the Hilbert curve.
pub(super) fn hilbert<const D: usize>(mut cell: [u32; D]) -> u64 {
    let digits = || (0..DIGITS).rev().map(|digit| 1 << digit);
    for digit in digits().filter(|&digit: &u32| digit > 1) {
        let lower = digit - 1;
        for axis in 0..D {
            if cell[axis] & digit != 0 {
                cell[0] ^= lower;
            } else {
                let exchanged = (cell[0] ^ cell[axis]) & lower;
                cell[0] ^= exchanged;
                cell[axis] ^= exchanged;
            }
        }
    }
    // the code of Gray
    for axis in 1..D {
        cell[axis] ^= cell[axis - 1];
    }
    let flips = digits().filter(|&digit| digit > 1 && cell[D - 1] & digit != 0);
    let flips = flips.fold(0, |flips, digit| flips ^ (digit - 1));
    let mut place = 0;
    for digit in digits() {
        for axis in 0..D {
            place = place << 1 | u64::from((cell[axis] ^ flips) & digit != 0);
        }
    }
    place
}
