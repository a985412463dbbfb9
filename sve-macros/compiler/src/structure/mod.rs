//! Equations → blocks, each of which is explicit, linear or solved by Newton's method.
//!
//! Input: [`Equations`]. Output: a [`Scheme`], the same equations cut into blocks to be solved in
//! order. First, every unknown that some equation gives with a numeric coefficient is eliminated.
//! Then the rest is split into strongly connected blocks of equations against unknowns (Duff,
//! Erisman, Reid: Direct Methods for Sparse Matrices, chapter 6).
//!
//! [`unstructured`] skips this analysis; tests and an example compare its steps with these.

mod band;
mod block;
mod cancel;
mod elimination;
mod enclosure;
mod graph;
mod guess;
mod judge;
mod matrix;
mod outputs;
mod path;
mod pivots;
mod scheme;
mod start;
mod tearing;

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Purpose, Symbol};
use crate::discretise::equations::Equations;
use crate::model::domain;
use crate::model::{Meaning, Quantity, Symbols};
use crate::rules::action::Action;
use crate::rules::rotations::values_at_nodes;
pub(crate) use band::Band;
use elimination::Reduced;
pub(crate) use enclosure::Enclosure;
pub(crate) use matrix::{Matrix, Storage};
use outputs::{cheapest, linear_map};
pub(crate) use path::PathJudge;
pub(crate) use scheme::{
    Block, Iteration, Kind, Linear, Lower, Refinement, Returns, Scheme, Solution,
};
pub(crate) use start::StartTest;

/// The unknowns that the equations do not determine.
pub(crate) struct Degenerate {
    pub(crate) unknowns: Vec<Symbol>,
}

/// Cuts the equations into blocks.
pub(crate) fn analyse(
    equations: Equations,
    action: &Action,
    symbols: &mut Symbols,
    arena: &mut Arena,
) -> Result<Scheme<Expr>, Degenerate> {
    let kept = elimination::kept_unknowns(&equations, symbols);
    let conditions = equations.conditions.clone();
    let mut system = Reduced {
        kept,
        dividing: action.dividing.clone(),
        ..Reduced::new(equations, symbols, arena)
    };
    let roots = roots(action, system.arena);
    system.domain = domain::conditions(&roots, system.arena);
    system.domain.extend(conditions);
    if !action.ends.momentum.is_empty() {
        system.keep_coupled();
    }
    system.eliminate();
    let order = system.blocks()?;
    let mut blocks = Vec::new();
    let mut known = HashMap::new();
    for (rows, columns) in order {
        let torn = system.tear(rows, columns, &known);
        let block = system.solve(&torn.rows, &torn.columns, &mut known);
        blocks.push(block);
        blocks.extend(system.explicit_blocks(torn.formulas, &mut known));
    }
    let reported = system.arena.substitute_all(&system.reported, &known);
    let guards = system.arena.substitute_all(&system.guards, &known);
    let dq = system.arena.substitute_all(&system.dq, &known);
    let forms = system.dp.iter();
    let candidates: Vec<Vec<Expr>> = forms
        .map(|list| system.arena.substitute_all(list, &known))
        .collect();
    let dp = cheapest(system.arena, &candidates, &dq, &blocks);
    let turned = system.arena.substitute_all(&system.turned, &known);
    let numbers = action
        .turned()
        .flat_map(|r| (r.first..).take(r.values.len()));
    let turned = numbers.zip(turned).collect();
    let increments = Scheme {
        blocks,
        increments: [dq.clone(), dp.clone()],
        returns: Returns::Increment,
        dq,
        dp,
        domain: action
            .ends
            .at_start()
            .chain(system.domain_at(&known))
            .collect(),
        guards,
        reported,
        turned,
    };
    let mut scheme = linear_map(increments, action, symbols, arena);
    arena.stabilise(Purpose::Step, scheme.exprs_mut());
    Ok(scheme)
}

/// Returns the step without structure: Newton's method in all unknowns.
pub(crate) fn unstructured(
    equations: Equations,
    symbols: &mut Symbols,
    arena: &mut Arena,
) -> Scheme<Expr> {
    let mut system = Reduced {
        leading: None,
        torn: Vec::new(),
        guards: Vec::new(),
        ..Reduced::new(equations, symbols, arena)
    };
    let mut known = HashMap::new();
    let block = system.unstructured(&mut known);
    let kicks: Vec<Expr> = system.dp.iter().map(|forms| forms[0]).collect();
    let dq = system.arena.substitute_all(&system.dq, &known);
    let dp = system.arena.substitute_all(&kicks, &known);
    let mut scheme = Scheme {
        blocks: vec![block],
        increments: [dq.clone(), dp.clone()],
        returns: Returns::Increment,
        dq,
        dp,
        domain: Vec::new(),
        guards: Vec::new(),
        reported: system.arena.substitute_all(&system.reported, &known),
        turned: Vec::new(),
    };
    arena.stabilise(Purpose::Step, scheme.exprs_mut());
    scheme
}

/// Returns the roots of the expressions of a step: the action and the force.
fn roots(action: &Action, arena: &mut Arena) -> Vec<Expr> {
    let impulses: Vec<Expr> = action.work.iter().map(|w| w.impulse).collect();
    let impulses = if action.rotations.is_empty() {
        impulses
    } else {
        arena.substitute_all(&impulses, &values_at_nodes(&action.rotations))
    };
    let ends = action.ends.end.iter().flatten().copied();
    std::iter::once(action.value)
        .chain(impulses)
        .chain(ends)
        .collect()
}

/// Returns whether a symbol is part of the state at the start of the step.
pub(crate) fn is_state(symbols: &Symbols, symbol: Symbol) -> bool {
    matches!(
        symbols.meaning(symbol),
        Meaning::Start(Quantity::Position | Quantity::Momentum, _)
    )
}
