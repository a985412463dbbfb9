//! A system with few neighbours, whose equations are banded once they are ordered.

use sve_comparison::compared;

/// Beads on parallel rails, coupled to their neighbours by springs and by masses that roll on both,
/// and numbered at random: bead `3k mod 8` is the k-th along the chain. The spring in the middle is
/// shaken.
#[derive(Clone, Debug)]
pub struct Rails {
    /// Mass of a bead.
    pub m: f64,
    /// Masses that roll.
    pub r: f64,
    /// Stiffness and its growth.
    pub k: [f64; 2],
    /// Strength of the noise.
    pub s: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Rails {
    /// L.
    pub fn lagrangian(&self, q: [f64; 8], v: [f64; 8]) -> f64 {
        let way = [0, 3, 6, 1, 4, 7, 2, 5];
        let mut l = 0.5 * self.m * v[0].powi(2);
        for at in 1..8 {
            let (a, b) = (way[at - 1], way[at]);
            let stretch = q[b] - q[a];
            l += 0.5 * self.m * v[b].powi(2) + 0.5 * self.r * (v[a] - v[b]).powi(2);
            l -= 0.5 * self.k[0] * stretch.powi(2) + 0.25 * self.k[1] * stretch.powi(4);
        }
        l
    }

    /// γ.
    #[gamma]
    pub fn shake(&self, q: [f64; 8]) -> f64 {
        self.s * (q[1] - q[4]).sin()
    }
}
