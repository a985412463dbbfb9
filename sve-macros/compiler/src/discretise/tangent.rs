//! Scheme → the linearised step, from which the runtime computes the derivatives of the result by the initial state and the parameters.
//!
//! Let x be the unknowns of the blocks, z the initial state and the parameters, R(x, z) the residuals and y(x, z) the results. By the
//! implicit function theorem,
//!
//! ```text
//! dy/dz = ∂y/∂z − ∂y/∂x (∂R/∂x)⁻¹ ∂R/∂z
//! ```
//!
//! Output: the non-zero entries of the four matrices. A quantity that has a formula is not among the unknowns.

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Symbol};
use crate::rules::action::Action;
use crate::structure::{Iteration, Linear, Scheme, Solution};
use crate::system::model::Symbols;

/// An entry of a matrix.
pub(crate) struct Entry {
    pub(crate) row: usize,
    pub(crate) column: usize,
    pub(crate) value: Expr,
}

/// The linearised step.
pub(crate) struct Linearisation {
    /// The symbols that stand for x after the blocks are solved.
    pub(crate) unknowns: Vec<Symbol>,
    /// Number of results, twice the number of degrees of freedom.
    pub(crate) outputs: usize,
    /// Number of inputs: q₀, p₀ and the parameters in the order of their declaration.
    pub(crate) inputs: usize,
    /// ∂R/∂x, ∂R/∂z, ∂y/∂x, ∂y/∂z.
    pub(crate) matrices: [Vec<Entry>; 4],
}

/// Differentiates the residuals and the results of a scheme.
pub(crate) fn linearise(
    scheme: &Scheme<Expr>,
    action: &Action,
    symbols: &Symbols,
    arena: &mut Arena,
) -> Linearisation {
    let mut unknowns = Vec::new();
    let mut residuals = Vec::new();
    for block in &scheme.blocks {
        match &block.solution {
            Solution::Formula(_) => {}
            Solution::System { linear, solved } => {
                residuals.extend(linear_residuals(linear, solved, arena));
                unknowns.extend(solved);
            }
            Solution::Iteration(iteration) => {
                residuals.extend(residuals_at_solution(iteration, arena));
                unknowns.extend(&iteration.solved);
            }
        }
    }
    let inputs: Vec<Symbol> = action
        .start_q
        .iter()
        .chain(&action.start_p)
        .copied()
        .chain(symbols.parameters())
        .collect();
    let results = [scheme.dq.as_slice(), &scheme.dp].concat();
    Linearisation {
        outputs: results.len(),
        inputs: inputs.len(),
        matrices: [
            jacobian(&residuals, &unknowns, arena),
            jacobian(&residuals, &inputs, arena),
            jacobian(&results, &unknowns, arena),
            jacobian(&results, &inputs, arena),
        ],
        unknowns,
    }
}

/// Returns the residuals of a linear system.
fn linear_residuals(linear: &Linear<Expr>, solved: &[Symbol], arena: &mut Arena) -> Vec<Expr> {
    let rows = linear.rhs.iter().enumerate();
    rows.map(|(i, &rhs)| {
        let mut terms = vec![(-1.0, rhs)];
        for (column, entry) in linear.matrix.row(i) {
            let x = arena.symbol(solved[column]);
            terms.push((1.0, arena.mul(entry, x)));
        }
        arena.sum(0.0, &terms)
    })
    .collect()
}

/// Returns the residuals of an iteration at its solution.
fn residuals_at_solution(iteration: &Iteration<Expr>, arena: &mut Arena) -> Vec<Expr> {
    let pairs = iteration.iterates.iter().zip(&iteration.solved);
    let by: HashMap<Symbol, Expr> = pairs.map(|(&x, &s)| (x, arena.symbol(s))).collect();
    iteration
        .residual
        .iter()
        .map(|&r| arena.substitute(r, &by))
        .collect()
}

fn jacobian(rows: &[Expr], columns: &[Symbol], arena: &mut Arena) -> Vec<Entry> {
    let zero = arena.constant(0.0);
    let mut entries = Vec::new();
    for (row, &expr) in rows.iter().enumerate() {
        for (column, &symbol) in columns.iter().enumerate() {
            if !arena.contains(expr, symbol) {
                continue;
            }
            let value = arena.diff(expr, symbol);
            if value != zero {
                entries.push(Entry { row, column, value });
            }
        }
    }
    entries
}
