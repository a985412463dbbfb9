//! The systems that are measured, and their starts.

use sve_runtime::NeighbourError;
use sve_runtime::prelude::*;

/// A chain with free ends and springs of the force d + β d³.
pub(crate) struct Chain {
    pub beta: f64,
}

#[variational(stormer_verlet)]
impl Chain {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in 1..q.len() {
            let d = q[i] - q[i - 1];
            l -= 0.5 * d * d + 0.25 * self.beta * d.powi(4);
        }
        l
    }
}

/// The φ⁴ field on a lattice with open borders: wells ¼(q² − 1)², and springs between neighbours.
pub(crate) struct Lattice {
    pub sides: [usize; 2],
}

#[variational(stormer_verlet)]
impl Lattice {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..self.sides[0] {
            for j in 0..self.sides[1] {
                let c = i * self.sides[1] + j;
                l += 0.5 * v[c] * v[c] - 0.25 * (q[c] * q[c] - 1.0).powi(2);
                if i + 1 < self.sides[0] {
                    l -= 0.5 * (q[c + self.sides[1]] - q[c]).powi(2);
                }
                if j + 1 < self.sides[1] {
                    l -= 0.5 * (q[c + 1] - q[c]).powi(2);
                }
            }
        }
        l
    }
}

/// Atoms in open space with the potential of Lennard and Jones up to 2.5, from lists of neighbours.
pub(crate) struct Atoms {
    pub near: Neighbours<3>,
    pub cut2: f64,
}

#[variational(stormer_verlet)]
impl Atoms {
    fn lagrangian(&self, q: &[[f64; 3]], v: &[[f64; 3]]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * (v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]);
            for k in self.near.start[i]..self.near.start[i + 1] {
                let j = self.near.list[k];
                let (x, y, z) = (q[j][0] - q[i][0], q[j][1] - q[i][1], q[j][2] - q[i][2]);
                let r2 = x * x + y * y + z * z;
                if r2 > self.cut2 {
                    continue;
                }
                let inverse = 1.0 / (r2 * r2 * r2);
                l -= 4.0 * inverse * (inverse - 1.0);
            }
        }
        l
    }
}

/// Chains of beads with bonds of length 1 from a list, in the order of the beads.
pub(crate) struct Polymer {
    pub bonds: Vec<[usize; 2]>,
    pub k: f64,
}

#[variational(stormer_verlet)]
impl Polymer {
    fn lagrangian(&self, q: &[[f64; 3]], v: &[[f64; 3]]) -> f64 {
        let mut l = 0.0;
        for v in v {
            l += 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        }
        for bond in &self.bonds {
            let (a, b) = (q[bond[0]], q[bond[1]]);
            let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            l -= 0.5 * self.k * ((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt() - 1.0).powi(2);
        }
        l
    }
}

/// Beads of a chain of the polymer.
pub(crate) const BEADS: usize = 50;

/// Coefficients for which the loops by hand are written.
pub(crate) const BETA: f64 = 0.7;
const CUT: f64 = 2.5;
const SKIN: f64 = 0.3;
const STIFFNESS: f64 = 100.0;

/// Returns numbers between −1 and 1 without order.
fn spread(i: usize) -> f64 {
    (i as f64 * 12.9898).sin()
}

/// Returns masses or sites with displacements without order, at rest.
pub(crate) fn sites(n: usize) -> State<Vec<f64>> {
    State::new((0..n).map(|i| 0.5 * spread(i)).collect(), vec![0.0; n])
}

/// Returns a lattice of `n` sites, which is nearly square.
pub(crate) fn lattice(n: usize) -> Lattice {
    let rows = (1..=n.isqrt()).filter(|rows| n.is_multiple_of(*rows));
    let rows = rows.max().unwrap_or(1);
    Lattice {
        sides: [rows, n / rows],
    }
}

/// Returns atoms near the places of a cubic grid, in an order in which neighbours are near: rows
/// and planes are gone through forwards and backwards in turn.
pub(crate) fn grid(atoms: usize) -> State<Vec<[f64; 3]>> {
    let side = (1..=atoms)
        .find(|side| side * side * side >= atoms)
        .unwrap_or(1);
    let turned = |at: usize, row: usize| {
        if row.is_multiple_of(2) {
            at
        } else {
            side - 1 - at
        }
    };
    let place = |i: usize| {
        let (z, y) = (i / (side * side), i / side % side);
        let site = [turned(i % side, y + z * side), turned(y, z), z];
        std::array::from_fn(|k| 1.06 * site[k] as f64 + 0.05 * spread(3 * i + k))
    };
    State::new((0..atoms).map(place).collect(), vec![[0.0; 3]; atoms])
}

/// Returns the atoms of a state with their lists.
pub(crate) fn atoms(state: &State<Vec<[f64; 3]>>) -> Result<Atoms, NeighbourError> {
    let mut near = Neighbours::open(CUT, SKIN)?;
    near.rebuild(&state.q)?;
    Ok(Atoms {
        near,
        cut2: CUT * CUT,
    })
}

/// Returns chains of so many beads in all; the last one may be shorter.
pub(crate) fn polymer(beads: usize) -> Polymer {
    let bonds = (1..beads).filter(|i| i % BEADS != 0);
    Polymer {
        bonds: bonds.map(|i| [i - 1, i]).collect(),
        k: STIFFNESS,
    }
}
