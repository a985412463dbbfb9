//! Whether the Lagrangian determines every velocity: `det ∂²L/∂v²` must not vanish identically.
//!
//! Input: the model with its derivatives. Output: nothing, or an error that names the velocities in question. The rank is
//! found by elimination at random points; one point of full rank is enough.

use syn::Pat;

use crate::mechanics::Mechanics;
use crate::model::Model;
use crate::parse::Annotated;
use crate::symbolic::Arena;

/// Pivots below this part of the largest entry are zero: between the rounding errors of an elimination, some 1e-15, and
/// the pivots of matrices that a random point makes nearly singular by chance.
const PIVOT: f64 = 1e-11;

pub(crate) fn check(
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    arena: &Arena,
) -> syn::Result<()> {
    let n = model.dof();
    let masses = mechanics.lagrangian.dvv.concat();
    let mut undetermined: Vec<usize> = Vec::new();
    for point in arena.samples(&masses) {
        let matrix = point.chunks(n).map(<[f64]>::to_vec).collect();
        let found = null_columns(matrix);
        if found.is_empty() {
            return Ok(());
        }
        undetermined.extend(found);
    }
    undetermined.sort_unstable();
    undetermined.dedup();
    let Some(&last) = undetermined.last() else {
        // nowhere defined: the step will say so
        return Ok(());
    };
    let names: Vec<String> = undetermined
        .iter()
        .map(|&i| format!("`{}`", velocity(block, i, n)))
        .collect();
    let example = velocity(block, last, n);
    Err(syn::Error::new(
        block.lagrangian.name.span(),
        format!(
            "this Lagrangian is degenerate: its momenta ∂L/∂v do not determine {}, since ∂²L/∂v² is singular everywhere; \
             give each velocity a kinetic term of its own, such as `0.5 * m * {example} * {example}`",
            names.join(", "),
        ),
    ))
}

/// The user's name of a velocity.
fn velocity(block: &Annotated, i: usize, n: usize) -> String {
    let argument = block.lagrangian.arguments.last();
    let name = match argument.map(|a| &a.0) {
        Some(Pat::Ident(ident)) => ident.ident.to_string(),
        _ => "v".to_owned(),
    };
    match argument.map(|a| &a.1) {
        Some(syn::Type::Array(array)) if !matches!(&*array.elem, syn::Type::Array(_)) => {
            format!("{name}[{i}]")
        }
        _ if n == 1 => name,
        _ => format!("{name}[{i}]"),
    }
}

/// The column of a row's largest entry, from column `first` on; `first` where there is none.
fn largest_from(row: &[f64], first: usize) -> usize {
    (first..row.len())
        .max_by(|&a, &b| row[a].abs().total_cmp(&row[b].abs()))
        .unwrap_or(first)
}

/// The columns that occur in a null vector; none where the matrix is regular.
fn null_columns(mut matrix: Vec<Vec<f64>>) -> Vec<usize> {
    let n = matrix.len();
    for row in &mut matrix {
        let largest = row.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        if largest > 0.0 {
            for x in row {
                *x /= largest;
            }
        }
    }
    let mut order: Vec<usize> = (0..n).collect();
    // the largest entry of each row behind the columns that are done: most rows of a large matrix stay as they are
    let mut largest: Vec<usize> = matrix.iter().map(|row| largest_from(row, 0)).collect();
    let mut rank = 0;
    while rank < n {
        let size = |i: usize| matrix[i][largest[i]].abs();
        let pivot = (rank..n).max_by(|&a, &b| size(a).total_cmp(&size(b)));
        let Some(i) = pivot.filter(|&i| size(i) > PIVOT) else {
            break;
        };
        let j = largest[i];
        matrix.swap(rank, i);
        largest.swap(rank, i);
        order.swap(rank, j);
        for (row, largest) in matrix.iter_mut().zip(&mut largest) {
            row.swap(rank, j);
            if *largest == rank {
                *largest = j;
            }
        }
        let pivot = matrix[rank].clone();
        for (i, row) in matrix.iter_mut().enumerate().filter(|(i, _)| *i != rank) {
            if row[rank] == 0.0 {
                continue;
            }
            let factor = row[rank] / pivot[rank];
            for k in rank..n {
                row[k] -= factor * pivot[k];
            }
            if i > rank {
                largest[i] = largest_from(row, rank + 1);
            }
        }
        rank += 1;
    }
    // reduced: row k says that pivot[k] x_k + Σ matrix[k][free] x_free = 0
    let in_null_vector = |k: &usize| {
        *k >= rank || (rank..n).any(|free| (matrix[*k][free] / matrix[*k][*k]).abs() > 1e-6)
    };
    (0..n)
        .filter(|k| rank < n && in_null_vector(k))
        .map(|k| order[k])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::null_columns;

    /// Uniform in [−1, 1): the finaliser of splitmix64.
    fn uniform(state: &mut u64) -> f64 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A matrix with the part `filled` of its entries, and a cyclic permutation.
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
    fn regular_matrices_have_none() {
        let mut state = 1;
        for n in 1..12 {
            for filled in [0.0, 0.2, 1.0] {
                assert_eq!(null_columns(random(n, filled, &mut state)), []);
            }
        }
    }

    #[test]
    fn columns_of_a_null_vector_are_found() {
        let mut state = 2;
        for n in 3..12 {
            for filled in [0.0, 0.2, 1.0] {
                let mut matrix = random(n, filled, &mut state);
                // one column is a combination of two others, so these three are in a null vector
                let [a, b] = [n / 3, n - 1];
                for row in &mut matrix {
                    row[0] = 2.0 * row[b] - 0.5 * row[a];
                }
                let mut found = null_columns(matrix);
                found.sort_unstable();
                assert_eq!(found, [0, a, b], "{n} {filled}");
            }
        }
        assert_eq!(null_columns(vec![vec![0.0; 2]; 2]), [0, 1]);
    }
}
