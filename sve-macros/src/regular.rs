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
    let mut rank = 0;
    while rank < n {
        let pivot = (rank..n)
            .flat_map(|i| (rank..n).map(move |j| (i, j)))
            .max_by(|a, b| matrix[a.0][a.1].abs().total_cmp(&matrix[b.0][b.1].abs()));
        let Some((i, j)) = pivot.filter(|&(i, j)| matrix[i][j].abs() > PIVOT) else {
            break;
        };
        matrix.swap(rank, i);
        order.swap(rank, j);
        for row in &mut matrix {
            row.swap(rank, j);
        }
        let pivot = matrix[rank].clone();
        for (_, row) in matrix.iter_mut().enumerate().filter(|(i, _)| *i != rank) {
            let factor = row[rank] / pivot[rank];
            for k in rank..n {
                row[k] -= factor * pivot[k];
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
