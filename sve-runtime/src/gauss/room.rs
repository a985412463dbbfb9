//! Distances that judge a solution: its extent, the room around it, and the room that bounds
//! require.

use super::bounds::NodeBounds;
use super::stages::Rows;
use super::tableau::Tableau;

/// Largest ratio of the room that is required to the room that there is. The distance from 1 covers
/// rounding errors.
const BOUND: f64 = 0.95;

/// Factor by which a new room exceeds the room that the bounds over the room before required.
const GROWTH: f64 = 1.3;

/// The interval in which a coordinate moves, relative to its value at the start.
pub(super) struct Extent<const N: usize> {
    pub(super) middle: [f64; N],
    pub(super) half: [f64; N],
    /// Largest distance from the start in units of the stage.
    pub(super) far: [f64; N],
}

impl<const N: usize> Extent<N> {
    #[inline(always)]
    pub(super) fn of<const S: usize>(rows: &Rows<S, N>) -> Self {
        let inverse_units = const { &Tableau::<S>::VALUES.inverse_units };
        let mut all = Self {
            middle: [0.0; N],
            half: [0.0; N],
            far: [0.0; N],
        };
        for n in 0..N {
            let (mut low, mut high, mut far) = (0.0_f64, 0.0_f64, 0.0_f64);
            for i in 0..S {
                let x = rows[n][i];
                low = low.min(x);
                high = high.max(x);
                far = far.max(x.abs() * inverse_units[i]);
            }
            all.middle[n] = 0.5 * (low + high);
            all.half[n] = 0.5 * (high - low);
            all.far[n] = far;
        }
        all
    }
}

/// Distances from the solution and its chord that the box contains.
#[derive(Clone, Copy)]
pub(super) struct Room<const N: usize> {
    pub(super) q: [f64; N],
    pub(super) v: [f64; N],
    pub(super) p: [f64; N],
}

/// Distances of positions and velocities.
pub(super) struct Distances<const N: usize> {
    pub(super) q: [f64; N],
    pub(super) v: [f64; N],
}

/// The room that bounds require.
pub(super) struct Needed<const N: usize> {
    /// True if the given room was enough.
    pub(super) is_enough: bool,
    /// A room that may be enough.
    pub(super) room: Room<N>,
}

impl<const N: usize> Needed<N> {
    /// Compares the requirement on a part of the room with the size of this part less its share of
    /// noise.
    #[inline(always)]
    pub(super) fn grow(
        &mut self,
        part: impl Fn(&mut Room<N>) -> &mut [f64; N],
        needed: &[f64; N],
        noise: &[f64; N],
    ) {
        let room = part(&mut self.room);
        for n in 0..N {
            self.is_enough &= needed[n] <= BOUND * (room[n] - noise[n]);
            room[n] = room[n].max(GROWTH * (needed[n] + noise[n]));
        }
    }
}

/// Returns `|matrix| x`.
#[inline(always)]
pub(super) fn magnitudes<const N: usize>(matrix: &[[f64; N]; N], x: &[f64; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for n in 0..N {
        for k in 0..N {
            sums[n] += matrix[n][k].abs() * x[k];
        }
    }
    sums
}

/// Returns how much momenta differ whose positions, velocities and times differ by these distances.
#[inline(always)]
pub(super) fn momentum<const N: usize, const M: usize>(
    bounds: &NodeBounds<N, M>,
    distances: &Distances<N>,
    time: f64,
) -> [f64; N] {
    let mut p = bounds.momentum_by_time.map(|slope| slope * time);
    for n in 0..N {
        for k in 0..N {
            let mass = bounds.mass[n][k].abs() + bounds.mass_radius[n][k];
            let by_position = bounds.momentum_by_position[n][k];
            p[n] += by_position * distances.q[k] + mass * distances.v[k];
        }
    }
    p
}
