//! Bounds of the derivatives at a node over a box. The macro derives them; they judge a solution of
//! many stages.
//!
//! Input: the centre of a box of times, positions, velocities and momenta, and half its widths.
//! Output: magnitudes that the derivatives do not exceed in the box.

use crate::system::System;

/// The number of solutions of a step, as far as the macro can tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Uniqueness {
    /// The equations are linear: there is one solution.
    Linear,
    /// There is one solution where the bounds prove it.
    Bounded,
    /// There are no bounds: the system has too many coordinates, or a function without bounds.
    Unknown,
}

/// Half the widths of a box.
#[derive(Clone, Copy, Debug)]
pub struct Radii<const N: usize> {
    /// Half the width in time.
    pub t: f64,
    /// Half the widths in the positions.
    pub q: [f64; N],
    /// Half the widths in the velocities.
    pub v: [f64; N],
    /// Half the widths in the momenta.
    pub p: [f64; N],
}

/// Magnitudes of derivatives in a box. Matrices have rows by the component that is differentiated.
#[derive(Clone, Copy, Debug)]
pub struct NodeBounds<const N: usize, const M: usize> {
    /// Midpoints of `∂²L/∂v²`.
    pub mass: [[f64; N]; N],
    /// Largest distances of `∂²L/∂v²` from the midpoints.
    pub mass_radius: [[f64; N]; N],
    /// Magnitudes of `∂²L/∂v∂t`.
    pub momentum_by_time: [f64; N],
    /// Largest distances of `∂²L/∂v∂t` from its midpoint.
    pub momentum_by_time_radius: [f64; N],
    /// Magnitudes of `∂²L/∂v∂q`.
    pub momentum_by_position: [[f64; N]; N],
    /// Largest distances of `∂²L/∂v∂q` from its midpoint.
    pub momentum_by_position_radius: [[f64; N]; N],
    /// Magnitudes of the derivatives of `∂L/∂q + F` by t.
    pub force_by_time: [f64; N],
    /// Magnitudes of the derivatives of `∂L/∂q + F` by q.
    pub force_by_position: [[f64; N]; N],
    /// Magnitudes of the derivatives of `∂L/∂q + F` by v.
    pub force_by_velocity: [[f64; N]; N],
    /// The bounds of each noise.
    pub noises: [NoiseBounds<N>; M],
    /// True if the bounds hold: the functions are defined in the whole box.
    pub hold: bool,
}

/// Magnitudes of derivatives of a noise in a box, with the Hamiltonian G and the force f.
#[derive(Clone, Copy, Debug)]
pub struct NoiseBounds<const N: usize> {
    /// Magnitudes of `∂G/∂q − f`.
    pub against: [f64; N],
    /// Magnitudes of `∂G/∂p`.
    pub dp: [f64; N],
    /// Magnitudes of `∂(∂G/∂q − f)/∂t`.
    pub against_t: [f64; N],
    /// Magnitudes of `∂²G/∂p∂t`.
    pub dpt: [f64; N],
    /// Magnitudes of `∂(∂G/∂q − f)/∂q`.
    pub against_q: [[f64; N]; N],
    /// Magnitudes of `∂²G/∂q∂p`, with rows by q.
    pub dqp: [[f64; N]; N],
    /// Magnitudes of `∂²G/∂p²`.
    pub dpp: [[f64; N]; N],
    /// Magnitudes of `∂f/∂v`.
    pub force_v: [[f64; N]; N],
}

impl<const N: usize> NoiseBounds<N> {
    const UNBOUNDED: Self = Self {
        against: [f64::INFINITY; N],
        dp: [f64::INFINITY; N],
        against_t: [f64::INFINITY; N],
        dpt: [f64::INFINITY; N],
        against_q: [[f64::INFINITY; N]; N],
        dqp: [[f64::INFINITY; N]; N],
        dpp: [[f64::INFINITY; N]; N],
        force_v: [[f64::INFINITY; N]; N],
    };
}

/// A system whose derivatives have bounds, where the macro finds some.
pub trait StageBounds<const N: usize, const M: usize>: System {
    /// The number of solutions, as far as the macro can tell.
    const UNIQUENESS: Uniqueness;

    /// Returns bounds over the box with this centre, `[q, v, p]`. The default implementation
    /// returns no finite bounds.
    #[inline]
    fn bounds(&self, time: f64, centre: [&[f64; N]; 3], radii: &Radii<N>) -> NodeBounds<N, M> {
        let _ = (time, centre, radii);
        NodeBounds {
            mass: [[f64::INFINITY; N]; N],
            mass_radius: [[f64::INFINITY; N]; N],
            momentum_by_time: [f64::INFINITY; N],
            momentum_by_time_radius: [f64::INFINITY; N],
            momentum_by_position: [[f64::INFINITY; N]; N],
            momentum_by_position_radius: [[f64::INFINITY; N]; N],
            force_by_time: [f64::INFINITY; N],
            force_by_position: [[f64::INFINITY; N]; N],
            force_by_velocity: [[f64::INFINITY; N]; N],
            noises: [NoiseBounds::UNBOUNDED; M],
            hold: false,
        }
    }
}
