//! Errors of lists of neighbours. Each message has the numbers in question and what to change.

use crate::readable::debug_is_display;

/// Why lists of [neighbours](crate::Neighbours) could not be made.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NeighbourError {
    /// The cut-off is not positive and finite.
    #[error("the cut-off {cutoff} must be positive and finite")]
    Cutoff {
        /// The cut-off given.
        cutoff: f64,
    },
    /// The skin is negative or not finite.
    #[error("the skin {skin} must be finite and not negative")]
    Skin {
        /// The skin given.
        skin: f64,
    },
    /// The box is too short.
    #[error(
        "the box has the length {length} along axis {axis}: it must be at least twice the sum of cut-off and skin, 2 × {reach}, \
         so that a particle is the neighbour of one image of another particle; take a larger box, a shorter cut-off or a thinner skin"
    )]
    Box {
        /// The axis, from 0.
        axis: usize,
        /// Length of the box along the axis.
        length: f64,
        /// Sum of cut-off and skin.
        reach: f64,
    },
    /// A position is not finite, or too far away for cells.
    #[error(
        "particle {particle} is at {value} along axis {axis}: positions must be finite, \
         and within 2^30 times cut-off + skin of the box or of the other particles"
    )]
    Position {
        /// The particle, from 0.
        particle: usize,
        /// The axis, from 0.
        axis: usize,
        /// Its coordinate.
        value: f64,
    },
    /// The values to put in order belong to another number of particles.
    #[error("there are {found} values for {expected} particles")]
    Length {
        /// Number of particles.
        expected: usize,
        /// Number of values.
        found: usize,
    },
}

debug_is_display!(NeighbourError);
