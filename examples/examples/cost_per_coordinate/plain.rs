//! The loops that one writes first: velocities and positions, then forces and velocities, with an
//! array for the forces. And the bonds of a polymer in the order of its beads, chain by chain.

use crate::hand::{Kernel, dispatch};
use crate::scenes::BEADS;

/// Rows of positions, momenta and forces at the positions.
pub(crate) type Rows<'a, R> = [&'a mut [R]; 3];

/// A step of a chain with free ends.
#[inline(never)]
pub(crate) fn chain([q, p, f]: Rows<'_, f64>, h: f64, beta: f64) {
    let n = q.len();
    for i in 0..n {
        p[i] += 0.5 * h * f[i];
        q[i] += h * p[i];
    }
    let spring = |d: f64| d + beta * d * d * d;
    for i in 0..n {
        let right = if i + 1 < n {
            spring(q[i + 1] - q[i])
        } else {
            0.0
        };
        let left = if i > 0 { spring(q[i] - q[i - 1]) } else { 0.0 };
        f[i] = right - left;
        p[i] += 0.5 * h * f[i];
    }
}

/// A step of the φ⁴ field with open borders.
#[inline(never)]
pub(crate) fn lattice([q, p, f]: Rows<'_, f64>, h: f64, [rows, columns]: [usize; 2]) {
    for i in 0..q.len() {
        p[i] += 0.5 * h * f[i];
        q[i] += h * p[i];
    }
    for i in 0..rows {
        for j in 0..columns {
            let c = i * columns + j;
            let x = q[c];
            let mut force = -x * (x * x - 1.0);
            if i > 0 {
                force += q[c - columns] - x;
            }
            if i + 1 < rows {
                force += q[c + columns] - x;
            }
            if j > 0 {
                force += q[c - 1] - x;
            }
            if j + 1 < columns {
                force += q[c + 1] - x;
            }
            f[c] = force;
            p[c] += 0.5 * h * force;
        }
    }
}

/// Adds half of the impulses of the forces.
fn kick(p: &mut [[f64; 3]], f: &[[f64; 3]], h: f64) {
    for i in 0..p.len() {
        for k in 0..3 {
            p[i][k] += 0.5 * h * f[i][k];
        }
    }
}

/// A step of bodies, whose forces are added to zeros.
fn bodies([q, p, f]: Rows<'_, [f64; 3]>, h: f64, forces: impl Fn(&[[f64; 3]], &mut [[f64; 3]])) {
    kick(p, f, h);
    for i in 0..q.len() {
        for k in 0..3 {
            q[i][k] += h * p[i][k];
            f[i][k] = 0.0;
        }
    }
    forces(q, f);
    kick(p, f, h);
}

/// A step of atoms with the potential of Lennard and Jones up to 2.5, from half lists by rows.
#[inline(never)]
pub(crate) fn atoms(rows: Rows<'_, [f64; 3]>, h: f64, start: &[usize], list: &[usize]) {
    bodies(rows, h, |q, f| {
        for i in 0..q.len() {
            for &j in &list[start[i]..start[i + 1]] {
                let d: [f64; 3] = std::array::from_fn(|k| q[j][k] - q[i][k]);
                let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                if r2 > 6.25 {
                    continue;
                }
                let s = 1.0 / (r2 * r2 * r2);
                let force = 24.0 * s * (1.0 - 2.0 * s) / r2;
                for k in 0..3 {
                    f[i][k] += force * d[k];
                    f[j][k] -= force * d[k];
                }
            }
        }
    });
}

/// A step of beads with bonds of length 1 and stiffness 100 from a list.
#[inline(never)]
pub(crate) fn bonds(rows: Rows<'_, [f64; 3]>, h: f64, list: &[[usize; 2]]) {
    bodies(rows, h, |q, f| {
        for &[i, j] in list {
            let d: [f64; 3] = std::array::from_fn(|k| q[j][k] - q[i][k]);
            let r = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let force = 100.0 * (r - 1.0) / r;
            for k in 0..3 {
                f[i][k] += force * d[k];
                f[j][k] -= force * d[k];
            }
        }
    });
}

/// The forces of the bonds of one chain after the other, without a list: the bonds of a chain go
/// into a buffer, from which each bead takes two.
pub(crate) struct Chains<'a> {
    pub q: &'a [[f64; 3]],
    pub f: &'a mut [[f64; 3]],
}

impl Kernel for Chains<'_> {
    #[inline(always)]
    fn run(self) {
        let chains = self.q.chunks(BEADS).zip(self.f.chunks_mut(BEADS));
        chains.for_each(|(q, f)| one_chain(q, f));
    }
}

#[inline(always)]
fn one_chain(q: &[[f64; 3]], f: &mut [[f64; 3]]) {
    let n = q.len();
    let mut bonds = [[0.0; 3]; BEADS + 1];
    let (from, to) = (&q[..n - 1], &q[1..n]);
    for (bond, (a, b)) in bonds[1..n].iter_mut().zip(from.iter().zip(to)) {
        let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let r = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        let force = 100.0 * (r - 1.0) / r;
        *bond = d.map(|d| force * d);
    }
    for (i, f) in f.iter_mut().enumerate() {
        for k in 0..3 {
            f[k] = bonds[i + 1][k] - bonds[i][k];
        }
    }
}

/// Computes the forces of the bonds of chains with the vectors of the machine.
pub(crate) fn chains(q: &[[f64; 3]], f: &mut [[f64; 3]]) {
    dispatch(Chains { q, f });
}
