//! The test whether the noises of a degenerate system commute, with the bracket of its two-form,
//! `{G_a, G_b} = ∇G_aᵀ ω⁻¹ ∇G_b`.
//!
//! A γ moves massless coordinates, so γ's need not commute. On the extended phase space of a
//! partially degenerate system (positions and momenta of the massive coordinates, and the massless
//! ones) only the massless coordinates contribute to the bracket of two γ's.

use super::{Degeneracy, Role, part};
use crate::algebra::{Arena, Expr, Sharp, Vanishing, Verdict};
use crate::model::Model;
use crate::system::commutation::Commutation;
use crate::system::mechanics::Mechanics;

/// Evaluates the brackets of all pairs of noises at random points, in 106 bits. Each bracket takes
/// a linear solve with ω.
pub(crate) fn commutation(
    degeneracy: &Degeneracy,
    model: &Model,
    mechanics: &Mechanics,
    arena: &Arena,
) -> Commutation {
    let paired = degeneracy.of(Role::Massless);
    let omega = part(&degeneracy.two_form, &paired);
    let gradients: Vec<Vec<Expr>> = mechanics
        .noises
        .iter()
        .map(|noise| paired.iter().map(|&i| noise.dq[i]).collect())
        .collect();
    let is_given = |g: &&Vec<Expr>| g.iter().any(|&e| arena.constant_value(e) != Some(0.0));
    if gradients.iter().filter(is_given).count() < 2 {
        return Commutation::All(Vanishing::Proved);
    }
    let (n, m) = (paired.len(), gradients.len());
    let entries = [omega.concat(), gradients.concat()].concat();
    let mut evidence = None;
    for point in arena.sharp_samples(&entries) {
        let (matrix, gradients) = point.split_at(n * n);
        let gradients: Vec<&[Sharp]> = gradients.chunks(n).collect();
        let rows: Vec<Vec<Sharp>> = matrix.chunks(n).map(<[Sharp]>::to_vec).collect();
        let Some(fields) = solved(rows, &gradients) else {
            continue;
        };
        for a in 0..m {
            for b in a + 1..m {
                let pairs = gradients[a].iter().zip(&fields[b]);
                let bracket =
                    pairs.fold(Sharp::exact(0.0), |sum, (&x, &y)| sum.minus_product(x, y));
                let found = match bracket.verdict() {
                    Verdict::NotZero => {
                        let [a, b] = [a, b].map(|at| model.noises[at].name.clone());
                        return Commutation::NonCommuting(a, b);
                    }
                    Verdict::Zero => Vanishing::Evaluated,
                    Verdict::Undecided => Vanishing::Undecided,
                    Verdict::Nothing => continue,
                };
                evidence = evidence.max(Some(found));
            }
        }
    }
    match evidence {
        Some(found) => Commutation::All(found),
        // if the brackets are defined at no point, the lower order is claimed
        None => {
            let [a, b] = [0, 1].map(|at| model.noises[at].name.clone());
            Commutation::NonCommuting(a, b)
        }
    }
}

/// Solves linear systems with one matrix by Gauss–Jordan elimination. Returns `None` if a pivot is
/// not certainly different from zero.
fn solved(mut matrix: Vec<Vec<Sharp>>, rhs: &[&[Sharp]]) -> Option<Vec<Vec<Sharp>>> {
    let n = matrix.len();
    for (i, row) in matrix.iter_mut().enumerate() {
        row.extend(rhs.iter().map(|b| b[i]));
    }
    for k in 0..n {
        let size = |&i: &usize| matrix[i][k].size();
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if matrix[pivot][k].verdict() != Verdict::NotZero {
            return None;
        }
        matrix.swap(k, pivot);
        let row = matrix[k].clone();
        for (i, other) in matrix.iter_mut().enumerate() {
            if i == k || other[k].size() == 0.0 {
                continue;
            }
            let factor = other[k].over(row[k]);
            for (x, &of_pivot) in other.iter_mut().zip(&row).skip(k) {
                *x = x.minus_product(factor, of_pivot);
            }
        }
    }
    let solution = |b: usize| {
        (0..n)
            .map(|i| matrix[i][n + b].over(matrix[i][i]))
            .collect()
    };
    Some((0..rhs.len()).map(solution).collect())
}
