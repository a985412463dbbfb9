//! Counts of the operations of L and of the functions derived from it, each as straight-line code
//! that shares no results with the others.
//!
//! Weights: an addition, subtraction, multiplication, division or change of sign counts 1. A call
//! of a function counts [`CALL`]; a sine and cosine of one angle are one call.

use proc_macro2::{Span, TokenStream};
use syn::ItemImpl;

use crate::algebra::{Arena, Expr};
use crate::catalogue::Options;
use crate::discretise::equations;
use crate::errors::Errors;
use crate::interpret;
use crate::model::Symbols;
use crate::program::{self, Array, Kernel, Scheduler};
use crate::rules::action;
use crate::structure::{self, Solution};
use crate::syntax::parse;

/// Number of operations that a call of a function counts.
pub const CALL: usize = 20;

/// Weighted numbers of operations, see [`CALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Operations {
    /// Operations of L.
    pub lagrangian: usize,
    /// Operations of the residual of all implicit equations.
    pub residual: usize,
    /// Operations of the entries of their Jacobian.
    pub jacobian: usize,
}

impl Operations {
    /// Counts the operations of the first rule of a block.
    ///
    /// # Errors
    /// If the block cannot be read, or its Lagrangian is degenerate.
    pub fn count(attribute: &TokenStream, block: &TokenStream) -> syn::Result<Self> {
        count(attribute.clone(), syn::parse2(block.clone())?)
    }
}

fn count(attribute: TokenStream, block: ItemImpl) -> syn::Result<Operations> {
    let mut arena = Arena::new();
    let mut errors = Errors::new();
    let read = parse::annotated(attribute, block, &mut errors).and_then(|block| {
        let model = interpret::interpret(&block, &mut arena, &mut errors)?;
        Some((block, model))
    });
    let no_system = || syn::Error::new(Span::call_site(), "the scene cannot be read");
    let (block, model) = errors.finish(read)?.ok_or_else(no_system)?;
    let mut symbols = model.symbols.clone();
    let rule = block.arguments.rules[0].rule;
    if rule.options != Options::NONE {
        let message = "operations are counted for rules without options";
        return Err(syn::Error::new(block.arguments.rules[0].place, message));
    }
    let action = action::discretise(
        rule,
        &model,
        None,
        action::Terms::NONE,
        &mut symbols,
        &mut arena,
    );
    let equations = equations::equations(&action, &symbols, &mut arena);
    let Ok(scheme) = structure::analyse(equations, &action, &mut symbols, &mut arena) else {
        return Err(syn::Error::new(
            block.lagrangian.name.span(),
            "the scene is degenerate",
        ));
    };
    let (mut residual, mut jacobian) = (Vec::new(), Vec::new());
    for block in &scheme.blocks {
        if let Solution::Iteration(iteration) = &block.solution {
            residual.extend(&iteration.residual);
            jacobian.extend(iteration.jacobian.stored());
        }
    }
    Ok(Operations {
        lagrangian: straight(&arena, &symbols, &[model.lagrangian]),
        residual: straight(&arena, &symbols, &residual),
        jacobian: straight(&arena, &symbols, &jacobian),
    })
}

fn straight(arena: &Arena, symbols: &Symbols, roots: &[Expr]) -> usize {
    let scheduler = Scheduler::of_one_tier(arena, symbols, roots);
    let kernel = Kernel::new(scheduler, &[Array::unnamed(roots)]);
    let counted = program::Operations::of(&kernel.program, |_| true);
    counted.arithmetic + CALL * (counted.transcendental + counted.angle_additions)
}
