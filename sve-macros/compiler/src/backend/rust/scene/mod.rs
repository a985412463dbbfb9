//! The implementations of a scene.

mod drags;
mod kinetic;
mod loops;
mod momenta;
mod nodes;
mod placeholders;
mod system;
mod tables;
mod walk;

use proc_macro2::TokenStream;
use quote::quote;

use super::function::Formulas;
use super::inputs::{stepped, unread, within};
use super::{bounded, private};
use crate::algebra::Arena;
use crate::explain;
use crate::scene::Derived;
use crate::syntax::parse::Annotated;
pub(super) use placeholders::placeholders;
use system::Context;

/// Prints all that was derived from the block of a scene, with the bounds of its slopes if a rule
/// needs them.
pub(crate) fn print(
    derived: &Derived,
    slopes: Option<&(Derived, Arena)>,
    block: &Annotated,
    arena: &Arena,
) -> TokenStream {
    let private = &private(block);
    let formulas = Formulas {
        arena,
        symbols: &derived.scene.symbols,
        private,
    };
    let texts = &explain::scene(derived, arena);
    let context = Context {
        derived,
        block,
        formulas,
        texts,
        self_ty: stepped(block),
    };
    let system = context.system();
    let self_ty = &context.self_ty;
    let scene = loops::scene(derived, slopes.is_some(), self_ty, formulas);
    let slopes = slopes.map(|(slopes, arena)| {
        let formulas = Formulas {
            arena,
            symbols: &slopes.scene.symbols,
            private,
        };
        loops::contributions(slopes, "Slopes", self_ty, formulas)
    });
    let rules = block.arguments.rules.iter();
    let rules = rules.map(|listed| context.rule(listed.rule));
    let momenta = context.momenta();
    let (symbols, read) = (&derived.scene.symbols, derived.scene.formulas());
    let unread = unread(block, symbols, read, arena);
    let stepped = quote!(#system #scene #slopes #(#rules)* #unread);
    let stepped = within(private, (block, symbols), stepped);
    bounded(quote!(#stepped #momenta))
}
