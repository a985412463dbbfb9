//! Lists of the pairs of particles that are close to each other.
//!
//! Input: positions, a cut-off and a skin. Output: each pair within cut-off + skin once, in rows of
//! one particle; the test when the lists expire; a numbering of the particles by their place.
//! Invariant: as long as no particle has moved by more than half the skin, every pair within the
//! cut-off is listed, up to rounding.
//!
//! Source: L. Verlet, *Computer "experiments" on classical fluids*, Phys. Rev. 159 (1967) 98–103,
//! for lists with a skin; M. P. Allen, D. J. Tildesley, *Computer Simulation of Liquids*, 2nd ed.,
//! Oxford (2017), section 5.3, for lists from cells.

mod cells;
mod error;
mod order;
#[cfg(test)]
mod tests;

pub use error::NeighbourError;
pub use order::SpaceOrder;

use cells::Cells;

/// The pairs of particles within a cut-off and a skin, as a half list: each pair once, in the row
/// of the particle with the smaller number.
///
/// The neighbours of particle `i` are `list[start[i]..start[i + 1]]`, all of them greater than `i`,
/// in ascending order. A Lagrangian that has the lists as a field loops over them and skips the
/// pairs beyond the cut-off, which lie in the skin. `D` is 1, 2 or 3.
///
/// ```
/// use sve_runtime::{NeighbourError, Neighbours};
///
/// /// Sum of a short-ranged repulsion (1 − r²)² over the pairs closer than 1.
/// fn energy(near: &Neighbours<2>, q: &[[f64; 2]]) -> f64 {
///     let mut sum = 0.0;
///     for i in 0..q.len() {
///         for k in near.start[i]..near.start[i + 1] {
///             let [x, y] = near.separation(q[i], q[near.list[k]]);
///             let r2 = x * x + y * y;
///             if r2 < 1.0 {
///                 sum += (1.0 - r2).powi(2);
///             }
///         }
///     }
///     sum
/// }
///
/// # fn main() -> Result<(), NeighbourError> {
/// let mut q = [[0.1, 0.5], [0.7, 0.5], [3.9, 0.5]];
/// let mut near = Neighbours::periodic(1.0, 0.2, [4.0, 4.0])?;
/// near.rebuild(&q)?;
/// assert_eq!((&near.start[..], &near.list[..]), (&[0, 2, 3, 3][..], &[1, 2, 2][..]));
/// q[1][0] += 0.09;
/// assert!(near.is_valid(&q)); // less than half the skin
/// q[1][0] += 0.02;
/// assert!(!near.is_valid(&q));
/// near.update(&q)?; // rebuilds lists that have expired
/// assert_eq!(near.of(0), [1, 2]);
/// let pairs = [0.71, 0.2, 0.91].map(|r: f64| (1.0 - r * r).powi(2));
/// assert!((energy(&near, &q) - pairs.iter().sum::<f64>()).abs() < 1e-14);
/// # Ok(())
/// # }
/// ```
///
/// The lists come from cells as long as cut-off + skin: the work is linear in the number of
/// particles as long as their density is bounded, in a box of any size and also without a box. A
/// skin of a tenth to a third of the cut-off is usual: a wide skin lists more pairs, a narrow skin
/// expires sooner. [`order`](Self::order) gives the numbering in which neighbours are close in
/// memory, which makes loops over a list several times as fast as a random numbering.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighbours<const D: usize> {
    /// The start of each row in `list`, and the length of `list`: one entry more than particles.
    pub start: Vec<usize>,
    /// The neighbours of all particles, row by row.
    pub list: Vec<usize>,
    cutoff: f64,
    skin: f64,
    /// Length of the box along each axis; infinite if the axis is open.
    lengths: [f64; D],
    /// The positions at which the lists were made.
    positions: Vec<[f64; D]>,
}

impl<const D: usize> Neighbours<D> {
    /// Returns the lists of no particles in open space, for [`rebuild`](Self::rebuild).
    ///
    /// # Errors
    /// [`NeighbourError::Cutoff`] if the cut-off is not positive and finite,
    /// [`NeighbourError::Skin`] if the skin is negative or not finite.
    pub fn open(cutoff: f64, skin: f64) -> Result<Self, NeighbourError> {
        Self::periodic(cutoff, skin, [f64::INFINITY; D])
    }

    /// Returns the lists of no particles in a periodic box with right angles, for
    /// [`rebuild`](Self::rebuild). An axis whose length is [`f64::INFINITY`] is open.
    ///
    /// Distances are those to the nearest image. Positions may lie outside of the box.
    ///
    /// # Errors
    /// As [`open`](Self::open), and [`NeighbourError::Box`] if a length is below twice the sum of
    /// cut-off and skin, where a particle could be the neighbour of two images of another one.
    pub fn periodic(cutoff: f64, skin: f64, lengths: [f64; D]) -> Result<Self, NeighbourError> {
        const {
            assert!(
                1 <= D && D <= 3,
                "neighbours are known in 1, 2 and 3 dimensions"
            );
        };
        if !(cutoff > 0.0 && cutoff.is_finite()) {
            return Err(NeighbourError::Cutoff { cutoff });
        }
        if !(skin >= 0.0 && skin.is_finite()) {
            return Err(NeighbourError::Skin { skin });
        }
        let reach = cutoff + skin;
        for (axis, length) in lengths.into_iter().enumerate() {
            // NaN is not long enough
            let is_long_enough = length >= 2.0 * reach;
            if !is_long_enough {
                return Err(NeighbourError::Box {
                    axis,
                    length,
                    reach,
                });
            }
        }
        Ok(Self {
            start: vec![0],
            list: Vec::new(),
            cutoff,
            skin,
            lengths,
            positions: Vec::new(),
        })
    }

    /// Makes the lists of the particles at these positions, arrays or vectors of numbers.
    ///
    /// # Errors
    /// [`NeighbourError::Position`] for a position that is not finite, or further than 2³⁰ times
    /// cut-off + skin from the box or the other particles; then the lists are unchanged.
    pub fn rebuild(
        &mut self,
        positions: &[impl Copy + Into<[f64; D]>],
    ) -> Result<(), NeighbourError> {
        let positions: Vec<[f64; D]> = positions.iter().map(|&at| at.into()).collect();
        let reach = self.cutoff + self.skin;
        let cells = Cells::new(&positions, reach, self.lengths)?;
        self.start.clear();
        self.list.clear();
        self.start.push(0);
        let mut row = Vec::new();
        for i in 0..positions.len() {
            row.clear();
            cells.add_neighbours_after(i, reach * reach, &mut row);
            row.sort_unstable();
            row.dedup();
            self.list.extend(&row);
            self.start.push(self.list.len());
        }
        self.positions = positions;
        Ok(())
    }

    /// Returns whether the lists still have every pair within the cut-off: twice the largest
    /// displacement since they were made does not exceed the skin. Lists of another number of
    /// particles are not valid, and positions that are not finite have no valid lists.
    pub fn is_valid(&self, positions: &[impl Copy + Into<[f64; D]>]) -> bool {
        self.displacement2(positions) <= 0.25 * self.skin * self.skin
    }

    /// Returns the number of steps of length `h` for which the lists stay valid if no particle
    /// moves faster than `speed`, a length in the unit of time of `h`: a trajectory makes as many
    /// at once. It is 0 for lists that are not [valid](Self::is_valid).
    ///
    /// Impulses change the speeds during these steps, so that `speed` has to be a bound, such as
    /// twice the largest speed at present.
    ///
    /// ```
    /// # use sve_runtime::{NeighbourError, Neighbours};
    /// # fn main() -> Result<(), NeighbourError> {
    /// let mut near = Neighbours::open(1.0, 0.2)?;
    /// near.rebuild(&[[0.0, 0.0], [0.7, 0.0]])?;
    /// assert_eq!(near.valid_steps(&[[0.0, 0.0], [0.7, 0.0]], 2.0, 0.015), 3); // up to 0.1
    /// assert_eq!(near.valid_steps(&[[0.0, 0.0], [0.7, 0.05]], 2.0, 0.015), 1);
    /// # Ok(())
    /// # }
    /// ```
    #[allow(clippy::cast_sign_loss)] // a negative number of steps becomes 0, and so does NaN
    pub fn valid_steps(&self, positions: &[impl Copy + Into<[f64; D]>], speed: f64, h: f64) -> u64 {
        let left = 0.5 * self.skin - self.displacement2(positions).sqrt();
        (left / (speed * h).abs()) as u64
    }

    /// Returns the square of the largest displacement since the lists were made; infinity for
    /// another number of particles and for positions that are not finite.
    fn displacement2(&self, positions: &[impl Copy + Into<[f64; D]>]) -> f64 {
        if positions.len() != self.positions.len() {
            return f64::INFINITY;
        }
        let pairs = positions.iter().zip(&self.positions);
        pairs.fold(0.0, |largest, (&at, &before)| {
            let at: [f64; D] = at.into();
            let plain: [f64; D] = core::array::from_fn(|axis| at[axis] - before[axis]);
            // A particle that was put back into the box has moved by a length of the box.
            let moved = squared(plain).min(squared(self.separation(before, at)));
            let moved = if moved.is_nan() { f64::INFINITY } else { moved };
            f64::max(largest, moved)
        })
    }

    /// Makes the lists anew if they are not [valid](Self::is_valid), and returns whether it did.
    ///
    /// # Errors
    /// As [`rebuild`](Self::rebuild).
    pub fn update(
        &mut self,
        positions: &[impl Copy + Into<[f64; D]>],
    ) -> Result<bool, NeighbourError> {
        let has_expired = !self.is_valid(positions);
        if has_expired {
            self.rebuild(positions)?;
        }
        Ok(has_expired)
    }

    /// Returns the neighbours of a particle that have a greater number; none if there is no such
    /// particle.
    pub fn of(&self, i: usize) -> &[usize] {
        match (self.start.get(i), self.start.get(i + 1)) {
            (Some(&from), Some(&to)) => self.list.get(from..to).unwrap_or_default(),
            _ => &[],
        }
    }

    /// Returns the way from one position to the nearest image of another one.
    pub fn separation(&self, from: impl Into<[f64; D]>, to: impl Into<[f64; D]>) -> [f64; D] {
        let (from, to) = (from.into(), to.into());
        core::array::from_fn(|axis| {
            let (way, length) = (to[axis] - from[axis], self.lengths[axis]);
            if length.is_finite() {
                way - length * (way / length).round()
            } else {
                way
            }
        })
    }

    /// Returns the numbering of particles at these positions by their place, along a Hilbert curve
    /// through the box: particles with close numbers are close to each other.
    ///
    /// # Errors
    /// As [`rebuild`](Self::rebuild).
    pub fn order(
        &self,
        positions: &[impl Copy + Into<[f64; D]>],
    ) -> Result<SpaceOrder, NeighbourError> {
        let positions: Vec<[f64; D]> = positions.iter().map(|&at| at.into()).collect();
        let inside = cells::inside(&positions, self.cutoff + self.skin, self.lengths)?;
        Ok(SpaceOrder::of(&inside))
    }

    /// Returns the cut-off.
    pub fn cutoff(&self) -> f64 {
        self.cutoff
    }

    /// Returns the skin.
    pub fn skin(&self) -> f64 {
        self.skin
    }

    /// Returns the length of the box along each axis, infinite for open axes.
    pub fn lengths(&self) -> [f64; D] {
        self.lengths
    }
}

/// Returns the squared length of a vector.
#[inline]
fn squared<const D: usize>(vector: [f64; D]) -> f64 {
    vector.iter().map(|x| x * x).sum()
}
