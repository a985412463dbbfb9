//! The increments of q and p, in the form that costs the least work and has the shortest chain of
//! operations.

use std::collections::HashMap;

use super::scheme::{Block, Kind, Returns, Scheme, Solution};
use crate::algebra::{Arena, Expr, Node, Symbol};
use crate::model::{Meaning, Symbols};
use crate::rules::action::Action;

/// Largest number of degrees of freedom for which a linear step is written as a matrix.
const MATRIX: usize = 2;

/// Writes a step that is affine in the state and solved by linear formulas as a matrix,
/// `z₁ − z₀ = A z₀ + b`. Its entries are known before the state, so the chain of operations from
/// one state to the next is as short as possible.
///
/// If A depends on the increments of the noise, `z₁ = (1 + A) z₀ + b` is shorter still. The
/// rounding of `1 + A` then differs from step to step and does not accumulate, as it would if A
/// were the same in all steps.
pub(super) fn linear_map(
    scheme: Scheme<Expr>,
    action: &Action,
    symbols: &Symbols,
    arena: &mut Arena,
) -> Scheme<Expr> {
    let formulas = scheme
        .blocks
        .iter()
        .all(|b| matches!(b.solution, Solution::Formula(_)));
    let implicit = scheme.blocks.iter().any(|b| b.kind == Kind::Linear);
    if !formulas || !implicit || action.start_q.len() > MATRIX {
        return scheme;
    }
    let state: Vec<Symbol> = action
        .start_q
        .iter()
        .chain(&action.start_p)
        .copied()
        .collect();
    let Some(rows) = affine(&scheme, &state, arena) else {
        return scheme;
    };
    let is_noisy = |(at, (row, _)): (usize, &(Vec<Expr>, Expr))| {
        let mut symbols_of = arena.symbols_of(row[at]);
        symbols_of.any(|s| matches!(symbols.meaning(s), Meaning::Wiener(_)))
    };
    let returns = if rows.iter().enumerate().all(is_noisy) {
        Returns::State
    } else {
        Returns::MatrixTimesState
    };
    let mut outputs = rows.into_iter().enumerate().map(|(at, (mut row, offset))| {
        if returns == Returns::State {
            row[at] = arena.sum(1.0, &[(1.0, row[at])]);
        }
        let mut terms = vec![(1.0, offset)];
        for (&entry, &s) in row.iter().zip(&state) {
            let entry = arena.opaque(entry);
            let s = arena.symbol(s);
            terms.push((1.0, arena.mul(entry, s)));
        }
        arena.sum(0.0, &terms)
    });
    let n = action.start_q.len();
    let dq = outputs.by_ref().take(n).collect();
    let dp = outputs.collect();
    Scheme {
        returns,
        dq,
        dp,
        ..scheme
    }
}

/// Returns, for each increment, its row of A and its entry of b. `None` if an increment is not
/// affine in the state.
fn affine(
    scheme: &Scheme<Expr>,
    state: &[Symbol],
    arena: &mut Arena,
) -> Option<Vec<(Vec<Expr>, Expr)>> {
    let zero = arena.constant(0.0);
    let origin: HashMap<Symbol, Expr> = state.iter().map(|&s| (s, zero)).collect();
    let mut rows = Vec::new();
    for &increment in scheme.dq.iter().chain(&scheme.dp) {
        let row: Vec<Expr> = state.iter().map(|&s| arena.diff(increment, s)).collect();
        let moves = |e: &Expr| state.iter().any(|&s| arena.contains(*e, s));
        if row.iter().any(moves) {
            return None;
        }
        rows.push((row, arena.substitute(increment, &origin)));
    }
    Some(rows)
}

/// Cost of a call of a function, in operations.
const CALL: usize = 20;

/// Number of operations that must be saved before a momentum increment is written in another form
/// than as the kick itself, which rounds least.
const WORTH: usize = 10;

/// Returns, for each momentum increment, the form that adds the least to the operations that are
/// computed anyway.
pub(super) fn cheapest(
    arena: &Arena,
    candidates: &[Vec<Expr>],
    dq: &[Expr],
    blocks: &[Block<Expr>],
) -> Vec<Expr> {
    let mut needed = vec![false; arena.len()];
    let need = |roots: &[Expr], needed: &mut Vec<bool>| {
        for e in arena.reachable(roots, |e| !needed[e.index()]) {
            needed[e.index()] = true;
        }
    };
    need(dq, &mut needed);
    for block in blocks {
        if let Solution::System { linear, .. } = &block.solution {
            let matrix: Vec<Expr> = linear.matrix.stored().collect();
            need(&matrix, &mut needed);
            need(&linear.rhs, &mut needed);
        }
    }
    let mut chosen = Vec::new();
    for list in candidates {
        let price = |e: Expr| cost(arena, &arena.reachable(&[e], |e| !needed[e.index()]));
        let mut best = (price(list[0]), list[0]);
        for &other in &list[1..] {
            let p = price(other);
            if p + WORTH <= best.0 {
                best = (p, other);
            }
        }
        need(&[best.1], &mut needed);
        chosen.push(best.1);
    }
    chosen
}

fn cost(arena: &Arena, nodes: &[Expr]) -> usize {
    nodes
        .iter()
        .map(|&e| match arena.node(e) {
            Node::Constant(_) | Node::Symbol(_) | Node::Opaque(..) => 0,
            Node::Sum(_, terms) => terms.len(),
            Node::Product(factors) => factors.len(),
            Node::Call(..) | Node::Call2(..) => CALL,
        })
        .sum()
}
