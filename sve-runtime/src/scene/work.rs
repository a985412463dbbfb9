//! The arrays of midpoint steps, which are kept from step to step.

use super::passes::Factors;
use super::sweep::Buffers;

/// The arrays of a solution, of the components of rows. A displacement is `d = f p₀ + e`.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    /// The nodes q₀ + f p₀/2 of displacements without impulses.
    pub(super) centres: Vec<f64>,
    pub(super) e: Vec<f64>,
    /// e before the last update; after the iteration, the momenta at the end.
    pub(super) other: Vec<f64>,
    /// The boxes of the nodes; during the iteration, the nodes before and after an update.
    pub(super) boxes: Vec<f64>,
    /// e of the displacements around which the boxes are; nothing if it is zero.
    pub(super) around: Vec<f64>,
    /// The factors of the displacements, with their step size.
    pub(super) factors: Option<(f64, Factors)>,
    pub(super) of_bounds: Option<Buffers>,
}

impl Work {
    /// Returns the number of numbers.
    pub(super) fn len(&self) -> usize {
        let factors = match &self.factors {
            Some((_, Factors::Each(factors))) => factors.len(),
            _ => 0,
        };
        let buffers = self.of_bounds.as_ref().map_or(0, Buffers::len);
        let arrays = [&self.centres, &self.e, &self.other, &self.boxes];
        let arrays = arrays.iter().map(|array| array.len()).sum::<usize>();
        arrays + self.around.capacity() + factors + buffers
    }

    /// Begins a solution with e = 0 for `numbers` components.
    pub(super) fn begin(&mut self, numbers: usize) {
        for array in [&mut self.centres, &mut self.e, &mut self.other] {
            array.resize(numbers, 0.0);
        }
        self.boxes.resize(2 * numbers, 0.0);
        self.e.fill(0.0);
        self.around.clear();
        self.around.reserve_exact(numbers);
    }
}
