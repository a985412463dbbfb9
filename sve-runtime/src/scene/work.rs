//! The arrays of midpoint steps, which are kept from step to step.

use super::passes::Factors;
use super::shifts::Shifts;
use super::sweep::Buffers;
use super::{Scene, reads_motion};

/// The arrays of a solution, of the components of rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    /// The nodes q₀ + f p₀/2 of displacements without impulses.
    pub(super) centres: Vec<f64>,
    pub(super) nodes: Vec<f64>,
    /// The nodes before the last update; after the iteration, the momenta at the end.
    pub(super) other: Vec<f64>,
    /// The velocities of the nodes, and their boxes, in a scene with forces of velocities or H₁.
    pub(super) velocities: [Vec<f64>; 2],
    /// The boxes of the nodes; after the iteration, its first half has the displacements.
    pub(super) boxes: Vec<f64>,
    /// The displacements around which the boxes are; nothing if they are those without impulses.
    pub(super) around: Vec<f64>,
    /// The factors of the displacements, with their step size.
    pub(super) factors: Option<(f64, Factors)>,
    pub(super) of_bounds: Option<Buffers>,
    pub(super) of_h1: Shifts,
    pub(super) solved: MidpointSolution,
}

/// How the equations of a midpoint step are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MidpointSolution {
    /// Bounds of the eigenvalues of `h²/4 M⁻¹ ∂²V/∂q²`, with γ and the forces, near the motion.
    pub bounds: [f64; 2],
    /// Sweeps of the iteration.
    pub sweeps: u32,
}

impl Work {
    /// Returns the number of numbers.
    pub(super) fn len(&self) -> usize {
        let factors = match &self.factors {
            Some((_, Factors::Each(factors))) => factors.len(),
            _ => 0,
        };
        let buffers = self.of_bounds.as_ref().map_or(0, Buffers::len);
        let [v, of_v] = &self.velocities;
        let arrays = [
            &self.centres,
            &self.nodes,
            &self.other,
            &self.boxes,
            v,
            of_v,
        ];
        let arrays = arrays.iter().map(|array| array.len()).sum::<usize>();
        arrays + self.around.capacity() + self.of_h1.len() + factors + buffers
    }

    /// Returns the displacements after the iteration.
    pub(super) fn displacements(&self) -> &[f64] {
        &self.boxes[..self.nodes.len()]
    }

    /// Keeps the displacements, for boxes around them.
    pub(super) fn next_round(&mut self) {
        let numbers = self.nodes.len();
        self.around.clear();
        self.around.extend_from_slice(&self.boxes[..numbers]);
    }

    /// Makes room for a solution with `numbers` components.
    pub(super) fn begin<S: Scene>(&mut self, numbers: usize) {
        if S::HAS_H1 {
            self.of_h1.begin(numbers);
        }
        if reads_motion::<S>() {
            self.velocities[0].resize(numbers, 0.0);
            self.velocities[1].resize(2 * numbers, 0.0);
        }
        for array in [&mut self.centres, &mut self.nodes, &mut self.other] {
            array.resize(numbers, 0.0);
        }
        self.boxes.resize(2 * numbers, 0.0);
        self.around.clear();
        self.around.reserve_exact(numbers);
    }
}
