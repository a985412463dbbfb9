//! The test whether the Lagrangian determines every velocity: `det ∂²L/∂v²` must not vanish
//! identically.
//!
//! Input: the model with its derivatives. Output: the undetermined velocities as an error, if there
//! are any. The rank is found by elimination at random points; one point of full rank is enough.
//! Plain `f64` recognises most regular matrices; a matrix that it takes for singular is eliminated
//! again in 106 bits, with bounds of the errors.

use syn::{Pat, Type};

use crate::algebra::{Arena, Sharp, Verdict};
use crate::model::Model;
use crate::syntax::parse::Annotated;
use crate::system::mechanics::Mechanics;

/// Smallest pivot of an elimination in `f64`, relative to the largest entry of its row. Rounding
/// errors are about 1e-15.
const SMALLEST_PIVOT: f64 = 1e-11;

/// Size below which a component of a null vector counts as a rounding error of the elimination.
const SMALLEST_COMPONENT: f64 = 1e-6;

/// Checks that the mass matrix ∂²L/∂v² is regular.
pub(super) fn check(
    model: &Model,
    mechanics: &Mechanics,
    arena: &Arena,
) -> Result<(), Undetermined> {
    let n = model.dof();
    let masses = mechanics.lagrangian.dvv.concat();
    let is_regular_at =
        |point: Vec<f64>| is_regular(point.chunks(n).map(<[f64]>::to_vec).collect());
    if arena.samples(&masses).any(is_regular_at) {
        return Ok(());
    }
    let mut undetermined: Vec<usize> = Vec::new();
    let mut is_singular = false;
    for point in arena.sharp_samples(&masses) {
        let found = null_columns(point.chunks(n).map(<[Sharp]>::to_vec).collect());
        if found.columns.is_empty() {
            return Ok(());
        }
        is_singular |= found.is_singular;
        undetermined.extend(found.columns);
    }
    undetermined.sort_unstable();
    undetermined.dedup();
    if undetermined.is_empty() {
        // if L is defined at none of the points, the step reports the domain
        return Ok(());
    }
    Err(Undetermined {
        velocities: undetermined,
        is_certain: is_singular && !arena.has_lost_constants(),
    })
}

/// Velocities that ∂L/∂v does not determine.
pub(super) struct Undetermined {
    /// The coordinates in null vectors of ∂²L/∂v², ascending; at least one.
    pub(super) velocities: Vec<usize>,
    /// True if ∂²L/∂v² is certainly singular. False if it is only too near to a singular matrix to
    /// decide.
    pub(super) is_certain: bool,
}

impl Undetermined {
    /// Returns the error. The message names a remedy in addition to giving each velocity a kinetic
    /// term.
    pub(super) fn error(&self, block: &Annotated, n: usize, remedy: &str) -> syn::Error {
        let reason = if self.is_certain {
            "since ∂²L/∂v² is singular everywhere"
        } else {
            "since ∂²L/∂v² is as near to a singular matrix as the rounding of its constants, so that whether it is singular cannot be decided"
        };
        let message = format!(
            "this Lagrangian is degenerate: its momenta ∂L/∂v do not determine {}, {reason}; {remedy}{}",
            names(&self.velocities, |i| velocity(block, i, n)),
            kinetic_term(block, &self.velocities, n),
        );
        syn::Error::new(block.lagrangian.name.span(), message)
    }
}

/// Returns the names of components, each in code quotes.
pub(super) fn names(components: &[usize], name: impl Fn(usize) -> String) -> String {
    let names: Vec<String> = components
        .iter()
        .map(|&i| format!("`{}`", name(i)))
        .collect();
    names.join(", ")
}

/// Returns the advice to give some velocities kinetic terms.
pub(super) fn kinetic_term(block: &Annotated, velocities: &[usize], n: usize) -> String {
    let example = velocity(block, velocities.last().map_or(0, |&i| i), n);
    format!(
        "give each velocity a kinetic term of its own, such as `0.5 * m * {example} * {example}`"
    )
}

/// Returns the user's name of a velocity.
pub(super) fn velocity(block: &Annotated, i: usize, n: usize) -> String {
    component(block.lagrangian.arguments.last(), "v", i, n)
}

/// Returns the user's name of a coordinate.
pub(super) fn coordinate(block: &Annotated, i: usize, n: usize) -> String {
    let first = usize::from(block.lagrangian.is_timed);
    component(block.lagrangian.arguments.get(first), "q", i, n)
}

/// Returns the user's name of a component of an argument.
fn component(argument: Option<&(Pat, Type)>, otherwise: &str, i: usize, n: usize) -> String {
    let name = match argument.map(|a| &a.0) {
        Some(Pat::Ident(ident)) => ident.ident.to_string(),
        _ => otherwise.to_owned(),
    };
    match argument.map(|a| &a.1) {
        Some(Type::Array(array)) if !matches!(&*array.elem, Type::Array(_)) => {
            format!("{name}[{i}]")
        }
        _ if n == 1 => name,
        _ => format!("{name}[{i}]"),
    }
}

/// Divides each row by its largest entry.
fn scale_rows(matrix: &mut [Vec<f64>]) {
    for row in matrix {
        let largest = row.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        if largest > 0.0 {
            for x in row {
                *x /= largest;
            }
        }
    }
}

/// Returns the column of a row's largest entry from column `first` on; `first` if the row ends
/// there.
fn largest_from(row: &[f64], first: usize) -> usize {
    (first..row.len())
        .max_by(|&a, &b| row[a].abs().total_cmp(&row[b].abs()))
        .unwrap_or(first)
}

/// Returns whether an elimination in `f64` finds every pivot.
pub(super) fn is_regular(mut matrix: Vec<Vec<f64>>) -> bool {
    let n = matrix.len();
    scale_rows(&mut matrix);
    // the column of the largest entry of each row right of the eliminated columns; most rows of a
    // large matrix do not change in one step of the elimination
    let mut largest: Vec<usize> = matrix.iter().map(|row| largest_from(row, 0)).collect();
    for rank in 0..n {
        let size = |i: usize| matrix[i][largest[i]].abs();
        let pivot = (rank..n).max_by(|&a, &b| size(a).total_cmp(&size(b)));
        let Some(i) = pivot.filter(|&i| size(i) > SMALLEST_PIVOT) else {
            return false;
        };
        let j = largest[i];
        matrix.swap(rank, i);
        largest.swap(rank, i);
        for (row, largest) in matrix.iter_mut().zip(&mut largest) {
            row.swap(rank, j);
            if *largest == rank {
                *largest = j;
            }
        }
        let pivot = matrix[rank].clone();
        for (i, row) in matrix.iter_mut().enumerate().skip(rank + 1) {
            if row[rank] == 0.0 {
                continue;
            }
            let factor = row[rank] / pivot[rank];
            for k in rank..n {
                row[k] -= factor * pivot[k];
            }
            largest[i] = largest_from(row, rank + 1);
        }
    }
    true
}

/// The result of an elimination in 106 bits.
pub(super) struct Nullity {
    /// Columns that occur in a null vector; empty if the matrix is regular.
    pub(super) columns: Vec<usize>,
    /// True if all remaining entries are zero. Otherwise they are as small as the uncertainty of
    /// constants.
    is_singular: bool,
}

/// Returns the columns that occur in a null vector of a matrix. Its entries have error bounds.
pub(super) fn null_columns(mut matrix: Vec<Vec<Sharp>>) -> Nullity {
    let n = matrix.len();
    for row in &mut matrix {
        let largest = row.iter().fold(0.0f64, |m, x| m.max(x.size()));
        if largest > 0.0 {
            let k = -largest.log2() as i32;
            for x in row {
                *x = x.times_two_to(k);
            }
        }
    }
    let mut order: Vec<usize> = (0..n).collect();
    let mut rank = 0;
    while rank < n {
        let Some((i, j)) = pivot(&matrix, rank) else {
            break;
        };
        matrix.swap(rank, i);
        order.swap(rank, j);
        for row in &mut matrix {
            row.swap(rank, j);
        }
        let pivot = matrix[rank].clone();
        for (i, row) in matrix.iter_mut().enumerate() {
            if i == rank || row[rank].size() == 0.0 {
                continue;
            }
            let factor = row[rank].over(pivot[rank]);
            for k in rank..n {
                row[k] = row[k].minus_product(factor, pivot[k]);
            }
        }
        rank += 1;
    }
    let mut remaining = matrix[rank..].iter().flat_map(|row| &row[rank..]);
    let is_singular = rank < n && remaining.all(|x| x.verdict() == Verdict::Zero);
    // after the elimination, row k is the equation pivot[k] x_k + Σ matrix[k][free] x_free = 0
    let in_null_vector = |k: &usize| {
        let component = |free: usize| matrix[*k][free].size() / matrix[*k][*k].size();
        *k >= rank || (rank..n).any(|free| component(free) > SMALLEST_COMPONENT)
    };
    Nullity {
        columns: (0..n)
            .filter(|k| rank < n && in_null_vector(k))
            .map(|k| order[k])
            .collect(),
        is_singular,
    }
}

/// Returns the row and column of the largest entry that is certainly nonzero, among the rows and
/// columns that are not eliminated.
fn pivot(matrix: &[Vec<Sharp>], rank: usize) -> Option<(usize, usize)> {
    let row = |i: usize| (rank..matrix.len()).map(move |j| (i, j));
    (rank..matrix.len())
        .flat_map(row)
        .filter(|&(i, j)| matrix[i][j].verdict() == Verdict::NotZero)
        .max_by(|a, b| {
            let size = |&(i, j): &(usize, usize)| matrix[i][j].size();
            size(a).total_cmp(&size(b))
        })
}

#[cfg(test)]
mod tests {
    use super::{is_regular, null_columns};
    use crate::algebra::Sharp;

    /// Returns the columns of a null vector of an exact matrix.
    fn columns(matrix: &[Vec<f64>]) -> Vec<usize> {
        let sharp = |row: &Vec<f64>| row.iter().map(|&x| Sharp::exact(x)).collect();
        let found = null_columns(matrix.iter().map(sharp).collect());
        assert_eq!(
            found.is_singular,
            !found.columns.is_empty() || matrix.is_empty()
        );
        found.columns
    }

    /// Returns a uniform number in [−1, 1), by splitmix64.
    fn uniform(state: &mut u64) -> f64 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Returns a random matrix with a cyclic permutation added, in which the fraction `filled` of
    /// the entries is nonzero.
    fn random(n: usize, filled: f64, state: &mut u64) -> Vec<Vec<f64>> {
        let mut matrix = vec![vec![0.0; n]; n];
        for i in 0..n {
            for j in 0..n {
                if uniform(state).abs() < filled {
                    matrix[i][j] = uniform(state);
                }
            }
            matrix[i][(i + 1) % n] += 1.0;
        }
        matrix
    }

    #[test]
    fn regular_matrices_have_no_null_vector() {
        let mut state = 1;
        for n in 1..12 {
            for filled in [0.0, 0.2, 1.0] {
                let matrix = random(n, filled, &mut state);
                assert_eq!(columns(&matrix), []);
                assert!(is_regular(matrix));
            }
        }
    }

    #[test]
    fn columns_of_a_null_vector_are_found() {
        let mut state = 2;
        for n in 3..12 {
            for filled in [0.0, 0.2, 1.0] {
                let mut matrix = random(n, filled, &mut state);
                // column 0 is a combination of two others, so these three columns are in a null
                // vector
                let [a, b] = [n / 3, n - 1];
                for row in &mut matrix {
                    for x in row.iter_mut() {
                        // with few bits, so that the combination is exact
                        *x = (*x * 1024.0).round() / 1024.0;
                    }
                    row[0] = 2.0 * row[b] - 0.5 * row[a];
                }
                let mut found = columns(&matrix);
                assert!(!is_regular(matrix));
                found.sort_unstable();
                assert_eq!(found, [0, a, b], "{n} {filled}");
            }
        }
        assert_eq!(columns(&vec![vec![0.0; 2]; 2]), [0, 1]);
    }
}
