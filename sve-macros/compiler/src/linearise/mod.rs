//! Scheme → the linearised step, from which the runtime computes the derivatives of the result in
//! the initial state and the parameters.
//!
//! Let x be the unknowns of the blocks, z the initial state and the parameters, R(x, z) the
//! residuals and y(x, z) the results. By the implicit function theorem,
//!
//! ```text
//! dy/dz = ∂y/∂z − ∂y/∂x (∂R/∂x)⁻¹ ∂R/∂z
//! ```
//!
//! Output: the nonzero entries of the four matrices. A quantity that has a formula does not count
//! as an unknown.
//!
//! If forces act at both ends of an explicit step, ∂y/∂z is a sum over intermediate values w(z),
//! and each of its entries has as many terms as there are coordinates. In a step of many
//! coordinates the derivatives of these values are kept separate:
//!
//! ```text
//! dy/dz = ∂y/∂z + ∂y/∂w dw/dz
//! ```

mod chart;

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Symbol};
use crate::model::Symbols;
use crate::rules::action::Action;
use crate::structure::{Iteration, Linear, Scheme, Solution};
use chart::Input;

/// An entry of a matrix.
pub(crate) struct Entry {
    pub(crate) row: usize,
    pub(crate) column: usize,
    pub(crate) value: Expr,
}

/// The linearised step.
pub(crate) struct Linearisation {
    /// The symbols of x after the blocks are solved.
    pub(crate) unknowns: Vec<Symbol>,
    /// Number of results, twice the number of degrees of freedom.
    pub(crate) outputs: usize,
    /// Number of inputs: q₀, p₀ and the parameters in the order of their declaration.
    pub(crate) inputs: usize,
    /// ∂R/∂x, ∂R/∂z, ∂y/∂x, ∂y/∂z.
    pub(crate) matrices: [Vec<Entry>; 4],
    /// dw/dz and ∂y/∂w, if there are intermediate values. There are at most as many values as
    /// coordinates.
    pub(crate) through: Option<[Vec<Entry>; 2]>,
}

/// Largest number of coordinates of a step without intermediate values.
const WITHOUT_INTERMEDIATES: usize = 8;

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
    let mut inputs = chart::start(action, arena);
    inputs.extend(symbols.parameters().map(Input::Symbol));
    let by_unknowns: Vec<Input> = unknowns.iter().map(|&s| Input::Symbol(s)).collect();
    let results = [scheme.dq.as_slice(), &scheme.dp].concat();
    if let Some(split) = through_intermediates(&results, &inputs, scheme, action, arena) {
        return split;
    }
    let has_rotations = action.configuration.has_rotations();
    let of_results = |columns: &[Input], first: bool, arena: &mut Arena| {
        if !has_rotations {
            return jacobian(&results, columns, arena);
        }
        let mut rows: Vec<Vec<Expr>> = Vec::new();
        for &result in &results {
            let row = columns.iter().map(|input| input.derivative(result, arena));
            rows.push(row.collect());
        }
        chart::at_end(&mut rows, first, scheme, action, arena);
        entries(&rows, arena)
    };
    Linearisation {
        outputs: results.len(),
        inputs: inputs.len(),
        matrices: [
            jacobian(&residuals, &by_unknowns, arena),
            jacobian(&residuals, &inputs, arena),
            of_results(&by_unknowns, false, arena),
            of_results(&inputs, true, arena),
        ],
        through: None,
        unknowns,
    }
}

/// Differentiates the results of an explicit step through the formulas of its blocks. Returns
/// `None` for a step of few coordinates or one that is not explicit.
fn through_intermediates(
    results: &[Expr],
    inputs: &[Input],
    scheme: &Scheme<Expr>,
    action: &Action,
    arena: &mut Arena,
) -> Option<Linearisation> {
    let coordinates = scheme.dq.len();
    if coordinates <= WITHOUT_INTERMEDIATES || action.configuration.has_rotations() {
        return None;
    }
    let mut formulas = Vec::new();
    let mut names = HashMap::new();
    let mut back = HashMap::new();
    for block in &scheme.blocks {
        let Solution::Formula(formula) = block.solution else {
            return None;
        };
        if names.contains_key(&formula) {
            continue;
        }
        // the results contain the formula instead of this symbol
        let symbol = block.unknowns[0];
        names.insert(formula, arena.symbol(symbol));
        back.insert(symbol, formula);
        formulas.push((symbol, formula));
    }
    let open = arena.replace_all(results, &names);
    formulas.retain(|&(symbol, _)| open.iter().any(|&result| arena.contains(result, symbol)));
    if formulas.is_empty() || formulas.len() > coordinates {
        return None;
    }
    let (symbols, values): (Vec<Symbol>, Vec<Expr>) = formulas.into_iter().unzip();
    let symbols: Vec<Input> = symbols.into_iter().map(Input::Symbol).collect();
    let in_inputs = |entries: Vec<Entry>, arena: &mut Arena| -> Vec<Entry> {
        let values: Vec<Expr> = entries.iter().map(|entry| entry.value).collect();
        let values = arena.substitute_all(&values, &back);
        let entries = entries.into_iter().zip(values);
        entries
            .map(|(entry, value)| Entry { value, ..entry })
            .collect()
    };
    let by_inputs = jacobian(&open, inputs, arena);
    let by_intermediates = jacobian(&open, &symbols, arena);
    let through = [
        jacobian(&values, inputs, arena),
        in_inputs(by_intermediates, arena),
    ];
    Some(Linearisation {
        unknowns: Vec::new(),
        outputs: results.len(),
        inputs: inputs.len(),
        matrices: [
            Vec::new(),
            Vec::new(),
            Vec::new(),
            in_inputs(by_inputs, arena),
        ],
        through: Some(through),
    })
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

/// Returns the nonzero entries of a matrix.
fn entries(rows: &[Vec<Expr>], arena: &mut Arena) -> Vec<Entry> {
    let zero = arena.constant(0.0);
    let mut entries = Vec::new();
    for (row, values) in rows.iter().enumerate() {
        for (column, &value) in values.iter().enumerate() {
            if value != zero {
                entries.push(Entry { row, column, value });
            }
        }
    }
    entries
}

fn jacobian(rows: &[Expr], columns: &[Input], arena: &mut Arena) -> Vec<Entry> {
    let zero = arena.constant(0.0);
    let mut entries = Vec::new();
    for (row, &expr) in rows.iter().enumerate() {
        for (column, input) in columns.iter().enumerate() {
            if matches!(input, Input::Symbol(symbol) if !arena.contains(expr, *symbol)) {
                continue;
            }
            let value = input.derivative(expr, arena);
            if value != zero {
                entries.push(Entry { row, column, value });
            }
        }
    }
    entries
}
