//! Cells of particles, from which neighbours are found.
//!
//! Input: positions, the reach of a pair, and the lengths of the box. Output: the particles within
//! reach of a particle. Invariant: a cell is at least as long as the reach, so that neighbours lie
//! in cells that touch.
//!
//! Cells that are a multiple of a number apart share a bucket. So the number of buckets is bounded
//! by the number of particles, however far they are apart, and a dense cluster is still spread over
//! many buckets. The test of the distance drops the particles of other cells.

use super::{NeighbourError, squared};

/// Length of a cell in units of the reach. The excess covers rounding errors: particles within
/// reach never lie two cells apart.
const CELL: f64 = 1.0 + 1e-6;

/// Largest distance from the origin in units of the reach, at which the rounding error of a place
/// is below the excess of [`CELL`].
const FARTHEST: f64 = (1_u64 << 30) as f64;

/// Largest number of cells that touch a cell, with the cell itself.
const TOUCHING: usize = 27;

/// Particles in buckets of cells.
pub(super) struct Cells<const D: usize> {
    lengths: [f64; D],
    /// Number of cells along each axis. Along an open axis, it is a multiple of the number of
    /// buckets, and the last cell is empty.
    count: [usize; D],
    buckets: [usize; D],
    /// Cell and place of each particle.
    places: Vec<([usize; D], [f64; D])>,
    /// The start of each bucket in `content`, and the length of `content`.
    start: Vec<usize>,
    /// Number and place of particles, bucket by bucket.
    content: Vec<(usize, [f64; D])>,
}

/// Returns the positions moved into the box; along an open axis, relative to the lowest one.
pub(super) fn inside<const D: usize>(
    positions: &[[f64; D]],
    reach: f64,
    lengths: [f64; D],
) -> Result<Vec<[f64; D]>, NeighbourError> {
    let mut inside = positions.to_vec();
    for axis in 0..D {
        let length = lengths[axis];
        let values = positions.iter().map(|at| at[axis]);
        let lowest = values
            .filter(|x| x.is_finite())
            .fold(f64::INFINITY, f64::min);
        let origin = if length.is_finite() { 0.0 } else { lowest };
        for (particle, at) in inside.iter_mut().enumerate() {
            let value = at[axis];
            let mut place = value - origin;
            // NaN is not near
            let is_near = place.abs() < FARTHEST * reach;
            if !is_near {
                return Err(NeighbourError::Position {
                    particle,
                    axis,
                    value,
                });
            }
            if length.is_finite() {
                place -= length * (place / length).floor();
            }
            at[axis] = place;
        }
    }
    Ok(inside)
}

impl<const D: usize> Cells<D> {
    pub(super) fn new(
        positions: &[[f64; D]],
        reach: f64,
        lengths: [f64; D],
    ) -> Result<Self, NeighbourError> {
        let inside = inside(positions, reach, lengths)?;
        let whole = lengths.map(|length| (length / (CELL * reach)).floor().max(1.0));
        #[allow(clippy::cast_sign_loss)] // places in the box are not negative
        let cell = |at: [f64; D]| {
            core::array::from_fn(|axis| {
                let (x, length) = (at[axis], lengths[axis]);
                if length.is_finite() {
                    // rounding can give a place the length of the box
                    (x / length * whole[axis]).min(whole[axis] - 1.0) as usize
                } else {
                    (x / (CELL * reach)) as usize
                }
            })
        };
        let places: Vec<_> = inside.into_iter().map(|at| (cell(at), at)).collect();
        let used = core::array::from_fn(|axis| {
            let last = places.iter().map(|(cell, _)| cell[axis]).max();
            last.unwrap_or(0) + 1
        });
        let buckets = at_most(places.len(), used);
        #[allow(clippy::cast_sign_loss)] // lengths are positive
        let count = core::array::from_fn(|axis| {
            if lengths[axis].is_finite() {
                whole[axis] as usize
            } else {
                (used[axis] + 1).next_multiple_of(buckets[axis])
            }
        });
        let mut cells = Self {
            lengths,
            count,
            buckets,
            places,
            start: Vec::new(),
            content: Vec::new(),
        };
        cells.fill();
        Ok(cells)
    }

    /// Sorts the particles into buckets.
    fn fill(&mut self) {
        self.start = vec![0; self.buckets.iter().product::<usize>() + 1];
        let bucket = |cell: [usize; D]| {
            let along =
                |bucket, axis: usize| bucket * self.buckets[axis] + cell[axis] % self.buckets[axis];
            (0..D).fold(0, along)
        };
        let buckets: Vec<_> = self.places.iter().map(|(cell, _)| bucket(*cell)).collect();
        for &bucket in &buckets {
            self.start[bucket + 1] += 1;
        }
        for bucket in 1..self.start.len() {
            self.start[bucket] += self.start[bucket - 1];
        }
        self.content = vec![(0, [0.0; D]); self.places.len()];
        let mut next = self.start.clone();
        for (particle, &bucket) in buckets.iter().enumerate() {
            self.content[next[bucket]] = (particle, self.places[particle].1);
            next[bucket] += 1;
        }
    }

    /// Adds the particles with greater numbers within reach of a particle to a row. A particle half
    /// a box away, both images of which are within reach, is added twice.
    pub(super) fn add_neighbours_after(&self, i: usize, reach2: f64, row: &mut Vec<usize>) {
        let (cell, at) = self.places[i];
        let (touching, count) = self.touching(cell);
        for &(bucket, shift) in &touching[..count] {
            let here: [f64; D] = core::array::from_fn(|axis| at[axis] + shift[axis]);
            let content = &self.content[self.start[bucket]..self.start[bucket + 1]];
            // The numbers in a bucket ascend.
            if content.last().is_none_or(|(last, _)| *last <= i) {
                continue;
            }
            // One particle in twelve is a neighbour with a greater number. Each is written, and
            // kept by counting it, since a branch would often be predicted wrongly.
            let first = row.len();
            row.resize(first + content.len(), 0);
            let (room, mut found) = (&mut row[first..], 0);
            for &(j, there) in content {
                let way = core::array::from_fn(|axis| there[axis] - here[axis]);
                room[found] = j;
                found += usize::from((j > i) & (squared::<D>(way) <= reach2));
            }
            row.truncate(first + found);
        }
    }

    /// Returns the buckets of the cells that touch a cell, each with the way by which the cell is
    /// moved to lie beside their content, and the number of buckets.
    fn touching(&self, cell: [usize; D]) -> ([(usize, [f64; D]); TOUCHING], usize) {
        let (mut touching, mut count) = ([(0, [0.0; D]); TOUCHING], 1);
        for axis in 0..D {
            let (cells, buckets) = (self.count[axis], self.buckets[axis]);
            let length = Some(self.lengths[axis]).filter(|length| length.is_finite());
            let along = |step| {
                let next = cell[axis] + step;
                let shift = match next {
                    0 => 1.0,
                    _ if next > cells => -1.0,
                    _ => 0.0,
                };
                let bucket = (next + cells - 1) % cells % buckets;
                (bucket, length.map_or(0.0, |length| shift * length))
            };
            let [a, b, c] = [along(0), along(1), along(2)];
            // Cells that share a bucket are looked through once.
            let options = [Some(a), Some(b).filter(|b| *b != a)];
            let last = Some(c).filter(|c| *c != a && *c != b);
            let before = (touching, count);
            count = 0;
            for (along, by) in options.into_iter().chain([last]).flatten() {
                for &(bucket, mut shift) in &before.0[..before.1] {
                    shift[axis] = by;
                    touching[count] = (bucket * buckets + along, shift);
                    count += 1;
                }
            }
        }
        (touching, count)
    }
}

/// Halves the greatest numbers of buckets until their product is at most a number, or 1.
fn at_most<const D: usize>(most: usize, mut buckets: [usize; D]) -> [usize; D] {
    // each is at most 2³⁰
    let product = |buckets: &[usize; D]| buckets.iter().map(|&b| b as u128).product::<u128>();
    while product(&buckets) > most.max(1) as u128 {
        if let Some(greatest) = buckets.iter_mut().max() {
            *greatest = greatest.div_ceil(2);
        }
    }
    buckets
}
