//! The whole pipeline, a line a stage: attribute → block → model → action → equations → scheme → tokens.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemImpl;

use crate::action;
use crate::emit;
use crate::equations;
use crate::errors::Errors;
use crate::explain;
use crate::lower;
use crate::mechanics;
use crate::model::{Meaning, Model};
use crate::nesting;
use crate::parse::{self, Annotated};
use crate::regular;
use crate::rule::Rule;
use crate::structure::{self, Degenerate};
use crate::symbolic::Arena;

/// The expansion of the attribute: the user's block as it was, and the derived implementations or the errors.
pub(crate) fn expand(attribute: &TokenStream, item: &TokenStream) -> TokenStream {
    if let Err(error) = nesting::check(attribute).and_then(|()| nesting::check(item)) {
        return error.into_compile_error();
    }
    let block = match syn::parse2::<ItemImpl>(item.clone()) {
        Ok(block) => block,
        Err(error) => {
            let message = format!(
                "`#[variational]` belongs on the `impl` block that holds the Lagrangian: {error}"
            );
            let error = syn::Error::new(error.span(), message).into_compile_error();
            return quote!(#item #error);
        }
    };
    let plain = parse::without_roles(item);
    let stub = emit::stub(&block, attribute);
    let derived = derive(attribute.clone(), block).unwrap_or_else(|error| {
        let error = error.into_compile_error();
        quote!(#error #stub)
    });
    quote! {
        // `&self` is what this macro asks for
        #[allow(clippy::trivially_copy_pass_by_ref, clippy::unused_self)]
        #plain
        #derived
    }
}

fn derive(attribute: TokenStream, item: ItemImpl) -> syn::Result<TokenStream> {
    let mut arena = Arena::new();
    let block = parse::annotated(attribute, item)?;
    let model = lower::lower(&block, &mut arena)?;
    check_rules(&block, &model)?;
    let mechanics = mechanics::mechanics(&model, &mut arena);
    regular::check(&block, &model, &mechanics, &arena)?;
    let about = explain::system(&model, &mechanics, &arena);
    let mut output = emit::system(&block, &model, &mechanics, &about, &arena);
    for (rule, _) in &block.arguments.rules {
        let mut symbols = model.symbols.clone();
        let action = action::discretise(*rule, &model, &mut symbols, &mut arena);
        let equations = equations::equations(&action, &mut arena);
        let scheme = structure::analyse(equations, &action, &mut symbols, &mut arena)
            .map_err(|degenerate| singular(&degenerate, &block, &symbols))?;
        let texts = explain::step(
            *rule, &model, &mechanics, &action, &scheme, &symbols, &arena,
        );
        output.extend(emit::rule(
            *rule, &block, &model, &mechanics, &scheme, &about, &texts, &symbols, &arena,
        ));
    }
    Ok(output)
}

/// A rule that is not for this system.
fn check_rules(block: &Annotated, model: &Model) -> syn::Result<()> {
    let mut errors = Errors::new();
    for (rule, name) in &block.arguments.rules {
        if *rule == Rule::Taylor2 && !model.noises.is_empty() {
            errors.push(
                name.span(),
                "`taylor2` is a rule for systems without noise, and this block has noise terms: use `midpoint`, `endpoint` or `initial_point`",
            );
        }
    }
    errors.finish(())
}

/// A structurally singular step: L does not determine some velocities.
fn singular(
    degenerate: &Degenerate,
    block: &Annotated,
    symbols: &crate::model::Symbols,
) -> syn::Error {
    let names: Vec<String> = degenerate
        .unknowns
        .iter()
        .map(|&u| match symbols.meaning(u) {
            Meaning::Unknown(name) => format!("`{name}`"),
            _ => String::new(),
        })
        .collect();
    syn::Error::new(
        block.lagrangian.name.span(),
        format!(
            "this Lagrangian is degenerate: the step's equations do not determine {}; every velocity must occur in L, quadratically or otherwise non-linearly",
            names.join(", ")
        ),
    )
}
