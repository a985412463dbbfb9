//! Configuration spaces: their coordinates, the motion of a coordinate by an increment, and the
//! momenta that follow from derivatives of an action.
//!
//! A configuration consists of blocks: vectors and rotations. Its *entries* are the numbers that a
//! Lagrangian reads: the coordinates of a vector, and the nine entries of the matrix R of a
//! rotation, by columns. Its *directions* are its degrees of freedom: one for each coordinate, and
//! three for a rotation, in which R moves by R ξ̂ (left trivialisation; ξ̂ a = ξ × a).
//!
//! The increment of a rotation is the rotation vector of `R₀ᵀR₁`; [`chart`](super::chart) has the
//! momenta.

use std::collections::HashMap;
use std::ops::Range;

use crate::algebra::{Arena, Expr, Symbol};

/// Number of directions in which a rotation moves.
pub(super) const DIRECTIONS: usize = 3;

/// Number of entries of the matrix of a rotation.
pub(super) const ENTRIES: usize = 9;

/// A factor of a configuration space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Factor {
    /// A vector with this number of coordinates.
    Vector(usize),
    Rotation,
}

/// A configuration space.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Configuration {
    factors: Vec<Factor>,
}

/// A factor with its ranges of entries and directions.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) factor: Factor,
    pub(crate) entries: Range<usize>,
    pub(crate) directions: Range<usize>,
}

impl Configuration {
    pub(crate) fn new(factors: Vec<Factor>) -> Self {
        Self { factors }
    }

    /// Returns the blocks in their order.
    pub(crate) fn blocks(&self) -> Vec<Block> {
        let (mut entry, mut direction) = (0, 0);
        let blocks = self.factors.iter().map(|&factor| {
            let (entries, directions) = match factor {
                Factor::Vector(n) => (n, n),
                Factor::Rotation => (ENTRIES, DIRECTIONS),
            };
            let block = Block {
                factor,
                entries: entry..entry + entries,
                directions: direction..direction + directions,
            };
            (entry, direction) = (block.entries.end, block.directions.end);
            block
        });
        blocks.collect()
    }

    /// Returns the number of entries.
    pub(crate) fn entries(&self) -> usize {
        self.blocks().last().map_or(0, |block| block.entries.end)
    }

    /// Returns the number of degrees of freedom.
    pub(crate) fn directions(&self) -> usize {
        self.blocks().last().map_or(0, |block| block.directions.end)
    }

    /// Returns whether there is a rotation.
    pub(crate) fn has_rotations(&self) -> bool {
        self.factors.contains(&Factor::Rotation)
    }

    /// Returns the rotation to which an entry belongs: its number, and the row and column of the
    /// entry. `None` for a coordinate of a vector.
    pub(crate) fn rotation_of(&self, entry: usize) -> Option<RotationEntry> {
        let blocks = self.blocks();
        let rotations: Vec<&Block> = blocks
            .iter()
            .filter(|block| block.factor == Factor::Rotation)
            .collect();
        let number = rotations
            .iter()
            .position(|block| block.entries.contains(&entry))?;
        let at = entry - rotations[number].entries.start;
        Some(RotationEntry {
            number: (rotations.len() > 1).then_some(number),
            row: at % 3,
            column: at / 3,
        })
    }

    /// Returns the derivative of an expression in each direction; `entries` are the symbols of the
    /// entries.
    pub(crate) fn gradient(&self, expr: Expr, entries: &[Symbol], arena: &mut Arena) -> Vec<Expr> {
        let mut gradient = Vec::new();
        for block in self.blocks() {
            let symbols = &entries[block.entries];
            match block.factor {
                Factor::Vector(_) => gradient.extend(symbols.iter().map(|&s| arena.diff(expr, s))),
                Factor::Rotation => {
                    let slopes: Vec<Expr> = symbols.iter().map(|&s| arena.diff(expr, s)).collect();
                    gradient.extend(directions_of_rotation(&slopes, symbols, arena));
                }
            }
        }
        gradient
    }

    /// Returns the term `Σ Π·(a × b)` of the rotations, by which the Poisson bracket differs from
    /// the bracket of a vector space.
    pub(crate) fn transport(
        &self,
        momenta: &[Expr],
        a: &[Expr],
        b: &[Expr],
        arena: &mut Arena,
    ) -> Expr {
        let mut terms = Vec::new();
        for block in self.blocks() {
            if block.factor == Factor::Rotation {
                let [p, a, b] = [momenta, a, b].map(|x| &x[block.directions.clone()]);
                let product = cross(a, b, arena);
                terms.extend((0..DIRECTIONS).map(|k| (1.0, arena.mul(p[k], product[k]))));
            }
        }
        arena.sum(0.0, &terms)
    }

    /// Returns the commutator of two fields of directions, `a × b` for rotations, and zero for
    /// vectors.
    pub(crate) fn commutator(&self, a: &[Expr], b: &[Expr], arena: &mut Arena) -> Vec<Expr> {
        let mut commutator = vec![arena.constant(0.0); a.len()];
        for block in self.blocks() {
            if block.factor == Factor::Rotation {
                let at = block.directions;
                let product = cross(&a[at.clone()], &b[at.clone()], arena);
                commutator[at].copy_from_slice(&product);
            }
        }
        commutator
    }

    /// Returns expressions of the entries that form rotations for any values of `parameters`. Each
    /// rotation has four parameters, the components of a quaternion of any length. Identities that
    /// hold for rotations hold for these entries.
    pub(crate) fn parametrised(
        &self,
        entries: &[Symbol],
        parameters: &[Symbol],
        arena: &mut Arena,
    ) -> HashMap<Symbol, Expr> {
        let mut by = HashMap::new();
        let rotations = self.blocks().into_iter();
        let rotations = rotations.filter(|block| block.factor == Factor::Rotation);
        for (block, quaternion) in rotations.zip(parameters.chunks(4)) {
            let matrix = rotation_of(quaternion, arena);
            by.extend(entries[block.entries].iter().copied().zip(matrix));
        }
        by
    }

    /// Returns the number of parameters of [`parametrised`](Self::parametrised).
    pub(crate) fn parameters(&self) -> usize {
        let rotations = self.factors.iter().filter(|&&f| f == Factor::Rotation);
        4 * rotations.count()
    }
}

/// An entry of the matrix of a rotation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RotationEntry {
    /// Number of the rotation; `None` if there is only one.
    pub(crate) number: Option<usize>,
    pub(crate) row: usize,
    pub(crate) column: usize,
}

/// Returns the derivative of an expression in the directions of a rotation, from the derivatives in
/// its entries.
pub(crate) fn directions_of_rotation(
    slopes: &[Expr],
    entries: &[Symbol],
    arena: &mut Arena,
) -> Vec<Expr> {
    (0..DIRECTIONS)
        .map(|k| turned(slopes, entries, k, arena))
        .collect()
}

/// Returns a × b.
pub(crate) fn cross(a: &[Expr], b: &[Expr], arena: &mut Arena) -> Vec<Expr> {
    let component = |k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (first, second) = (arena.mul(a[i], b[j]), arena.mul(a[j], b[i]));
        arena.sub(first, second)
    };
    (0..DIRECTIONS).map(component).collect()
}

/// Returns the derivative of an expression if R moves by R ê, where e is the unit vector of a
/// direction: column j moves by `R (e × e_j)`. `slopes` are the derivatives in the entries.
fn turned(slopes: &[Expr], entries: &[Symbol], direction: usize, arena: &mut Arena) -> Expr {
    let (next, last) = ((direction + 1) % 3, (direction + 2) % 3);
    let mut terms = Vec::new();
    // e × e_next = e_last, and e × e_last = −e_next
    for (sign, moved, to) in [(1.0, next, last), (-1.0, last, next)] {
        for row in 0..3 {
            let entry = arena.symbol(entries[3 * to + row]);
            terms.push((sign, arena.mul(slopes[3 * moved + row], entry)));
        }
    }
    arena.sum(0.0, &terms)
}

/// Returns the matrix of a quaternion of any length, by columns.
fn rotation_of(quaternion: &[Symbol], arena: &mut Arena) -> Vec<Expr> {
    let q: Vec<Expr> = quaternion.iter().map(|&s| arena.symbol(s)).collect();
    let squares: Vec<(f64, Expr)> = q.iter().map(|&x| (1.0, arena.pow(x, 2))).collect();
    let length = arena.sum(0.0, &squares);
    let scale = arena.pow(length, -1);
    let mut entries = Vec::new();
    for column in 0..3 {
        for row in 0..3 {
            let terms = if row == column {
                let sign = |k: usize| if k == 0 || k == row + 1 { 1.0 } else { -1.0 };
                (0..4).map(|k| (sign(k), squares[k].1)).collect::<Vec<_>>()
            } else {
                // 2 (u_i u_j ∓ w u_k), with the minus sign where (row, column) is in the order of
                // the axes
                let across = arena.mul(q[row + 1], q[column + 1]);
                let along = arena.mul(q[0], q[4 - row - column]);
                let sign = if (row + 1) % 3 == column { -2.0 } else { 2.0 };
                vec![(2.0, across), (sign, along)]
            };
            let entry = arena.sum(0.0, &terms);
            entries.push(arena.mul(scale, entry));
        }
    }
    entries
}
