//! The whole pipeline, a line a stage: attribute → block → model → action → equations → scheme → tokens.

use std::collections::BTreeSet;

use proc_macro2::{Span, TokenStream, TokenTree};
use quote::quote;
use syn::ItemImpl;

use crate::algebra::Arena;
use crate::backend::rust::{self, Context, Derived};
use crate::discretise::equations;
use crate::discretise::tangent;
use crate::errors::Errors;
use crate::explain;
use crate::interpret;
use crate::rules::Rule;
use crate::rules::action;
use crate::structure::{self, Degenerate};
use crate::syntax::nesting;
use crate::syntax::parse::{self, Annotated};
use crate::syntax::roles;
use crate::system::mechanics;
use crate::system::model::{Meaning, Model};
use crate::system::regular;
use crate::system::symmetry;

/// What an expansion is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Whether steps of many states at once are derived too, for ensembles.
    pub lanes: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { lanes: true }
    }
}

/// The expansion of the attribute: the user's block as it was, and the derived implementations or the errors.
pub fn expand(attribute: &TokenStream, item: &TokenStream, settings: Settings) -> TokenStream {
    expand_within(attribute, item, settings, WORK)
}

/// The expansion with another bound on the work of each stage.
pub(crate) fn expand_within(
    attribute: &TokenStream,
    item: &TokenStream,
    settings: Settings,
    work: usize,
) -> TokenStream {
    if let Err(error) = nesting::check(attribute).and_then(|()| nesting::check(item)) {
        return error.into_compile_error();
    }
    let block = match syn::parse2::<ItemImpl>(item.clone()) {
        Ok(block) => block,
        Err(error) => {
            let is_impl = |t: TokenTree| matches!(t, TokenTree::Ident(word) if word == "impl");
            let error = if item.clone().into_iter().any(is_impl) {
                error
            } else {
                let message = "`#[variational]` belongs on the `impl` block that holds the Lagrangian, `impl MySystem { fn lagrangian(…) … }`";
                syn::Error::new(error.span(), message)
            };
            let error = error.into_compile_error();
            return quote!(#item #error);
        }
    };
    let plain = roles::without_roles(item);
    let mut mistaken = BTreeSet::new();
    match derive(attribute.clone(), block, settings, work, &mut mistaken) {
        Ok(derived) => quote! {
            // `&self` is what this macro asks for
            #[allow(clippy::trivially_copy_pass_by_ref, clippy::unused_self)]
            #plain
            #derived
        },
        Err(error) => after_mistakes(&error, attribute, item, &mistaken),
    }
}

/// The errors, beside a block that gives no errors of its own in the functions and constants of these names.
fn after_mistakes(
    error: &syn::Error,
    attribute: &TokenStream,
    item: &TokenStream,
    mistaken: &BTreeSet<String>,
) -> TokenStream {
    let error = error.to_compile_error();
    match syn::parse2::<ItemImpl>(item.clone()) {
        Ok(block) => {
            let (block, stub) = rust::stub(block, attribute, mistaken);
            quote!(#error #block #stub)
        }
        Err(_) => error,
    }
}

/// The derived implementations; or the errors, and in `mistaken` the names of functions and constants that have some.
fn derive(
    attribute: TokenStream,
    item: ItemImpl,
    settings: Settings,
    work: usize,
    mistaken: &mut BTreeSet<String>,
) -> syn::Result<TokenStream> {
    let mut arena = Arena::new();
    let mut errors = Errors::new();
    let read = parse::annotated(attribute, item, &mut errors).and_then(|block| {
        let model = interpret::interpret(&block, &mut arena, &mut errors)?;
        Some((block, model))
    });
    mistaken.clone_from(errors.places());
    let Some((block, model)) = errors.finish(read)? else {
        return Err(syn::Error::new(
            Span::call_site(),
            "this block cannot be read",
        ));
    };
    check_rules(&block, &model)?;
    check_size(&block, &model)?;
    arena.grant(work);
    let mut mechanics = mechanics::mechanics(&model, &mut arena);
    let regular = regular::check(&block, &model, &mechanics, &arena);
    check_work(&block, &model, &arena, work)?;
    regular?;
    let momenta = symmetry::check(&block, &model, &mut arena);
    check_work(&block, &model, &arena, work)?;
    let momenta = momenta?;
    let mut steps = Vec::new();
    let compared: &[bool] = if block.arguments.compared {
        &[false, true]
    } else {
        &[false]
    };
    let rules = |is_unstructured| {
        block
            .arguments
            .rules
            .iter()
            .map(move |(rule, _)| (*rule, is_unstructured))
    };
    for (rule, is_unstructured) in compared.iter().copied().flat_map(rules) {
        let mut symbols = model.symbols.clone();
        arena.grant(work);
        let action = action::discretise(rule, &model, &mut symbols, &mut arena);
        let equations = equations::equations(&action, &mut arena);
        let scheme = if is_unstructured {
            Ok(structure::unstructured(equations, &mut symbols, &mut arena))
        } else {
            structure::analyse(equations, &action, &mut symbols, &mut arena)
        };
        check_work(&block, &model, &arena, work)?;
        let scheme = scheme.map_err(|degenerate| singular(&degenerate, &block, &symbols))?;
        let linearisation = tangent::linearise(&scheme, &action, &symbols, &mut arena);
        check_work(&block, &model, &arena, work)?;
        steps.push(Derived {
            rule,
            is_unstructured,
            symbols,
            action,
            scheme,
            linearisation,
        });
    }
    // what is left to do is in proportion to what has been built
    arena.grant(usize::MAX);
    let about = explain::system(&model, &mechanics, &momenta, &arena);
    mechanics.stabilise(&mut arena);
    let mut output = rust::system(&block, &model, &mechanics, &about, &arena);
    output.extend(rust::momenta(&block, &model, &momenta, &arena));
    let context = Context {
        settings,
        block: &block,
        model: &model,
        mechanics: &mechanics,
        momenta: &momenta,
        about: &about,
        arena: &arena,
    };
    for derived in &steps {
        let Derived {
            rule,
            symbols,
            action,
            scheme,
            ..
        } = derived;
        let texts = explain::step(*rule, &model, &mechanics, action, scheme, symbols, &arena);
        output.extend(rust::rule(&context, derived, &texts));
    }
    Ok(output)
}

/// Work that the derivatives may take, and then each rule, in the units of the arena's budget; a unit is some 20 nanoseconds of
/// an optimised build. A dense system of 48 coordinates takes five sixths of it.
const WORK: usize = 200_000_000;

/// Second derivatives of L and of the noises that are written down, zeros included.
const ENTRIES: usize = 200_000;

/// An error where there would be too many second derivatives.
fn check_size(block: &Annotated, model: &Model) -> syn::Result<()> {
    let (n, m) = (model.dof(), model.noises.len());
    let entries = (m + 1).saturating_mul(3 * n * n);
    if entries <= ENTRIES {
        return Ok(());
    }
    let message = format!(
        "this system is too large to unroll: {n} coordinates and {m} noise terms have {entries} second derivatives, and the limit is {ENTRIES}; use fewer of them"
    );
    Err(syn::Error::new(block.lagrangian.name.span(), message))
}

/// An error where the last stage used up its work.
fn check_work(block: &Annotated, model: &Model, arena: &Arena, work: usize) -> syn::Result<()> {
    if !arena.is_exhausted() {
        return Ok(());
    }
    let message = format!(
        "this system is too large to unroll: with {} coordinates and {} noise terms its derivatives take more than {work} operations of the macro, which is the limit; use fewer coordinates or noise terms, shorter loops, or helpers that are called less often",
        model.dof(),
        model.noises.len(),
    );
    Err(syn::Error::new(block.lagrangian.name.span(), message))
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
    symbols: &crate::system::model::Symbols,
) -> syn::Error {
    let names: Vec<String> = degenerate
        .unknowns
        .iter()
        .map(|&u| match symbols.meaning(u) {
            Meaning::Unknown(unknown) => format!("`{unknown}`"),
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
