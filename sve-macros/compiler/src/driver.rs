//! The whole pipeline: read → classify → derive each rule → print. A stage reads the results of
//! earlier stages and does not change them.

use std::collections::BTreeSet;

use proc_macro2::{Span, TokenStream, TokenTree};
use quote::quote;
use syn::ItemImpl;

use crate::algebra::Arena;
use crate::backend::rust;
use crate::derivation::derive;
use crate::errors::Errors;
use crate::interpret;
use crate::model::Model;
use crate::model::scene::Scene;
use crate::scene;
use crate::settings::Settings;
use crate::syntax::nesting;
use crate::syntax::parse::{self, Annotated};
use crate::syntax::recovery;
use crate::syntax::roles;
use crate::system::applicable;
use crate::system::classify::classify;
use crate::system::size::{Budget, WORK};

/// Returns the expansion of the attribute: the unchanged block of the user, and the derived
/// implementations or the errors.
pub fn expand(attribute: &TokenStream, item: &TokenStream, settings: Settings) -> TokenStream {
    expand_within(attribute, item, settings, WORK)
}

/// Returns the expansion with another bound on the work of each stage.
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
    match implementations(attribute.clone(), block, settings, work, &mut mistaken) {
        Ok(derived) => quote! {
            // this macro requires `&self`
            #[allow(clippy::trivially_copy_pass_by_ref, clippy::large_types_passed_by_value, clippy::unused_self)]
            #plain
            #derived
        },
        Err(error) => after_mistakes(&error, attribute, item, &mistaken),
    }
}

/// Returns the errors, and a block that gives no further errors in the functions and constants of
/// these names.
fn after_mistakes(
    error: &syn::Error,
    attribute: &TokenStream,
    item: &TokenStream,
    mistaken: &BTreeSet<String>,
) -> TokenStream {
    let error = error.to_compile_error();
    match syn::parse2::<ItemImpl>(item.clone()) {
        Ok(mut block) => {
            recovery::remove_mistakes(&mut block, mistaken);
            let placeholders = rust::placeholders(&block, attribute);
            recovery::remove_attributes(&mut block);
            quote!(#error #block #placeholders)
        }
        Err(_) => error,
    }
}

/// Returns the derived implementations, or the errors. In the second case `mistaken` gets the names
/// of functions and constants with errors.
fn implementations(
    attribute: TokenStream,
    item: ItemImpl,
    settings: Settings,
    work: usize,
    mistaken: &mut BTreeSet<String>,
) -> syn::Result<TokenStream> {
    let mut arena = Arena::new();
    let (block, model) = match read(attribute, item, &mut arena, mistaken)? {
        (block, Read::Unrolled(model)) => (block, *model),
        (block, Read::Scene(scene)) => {
            applicable::check_scene(&block)?;
            let scene = scene::derive(*scene, &mut arena)?;
            let mut rules = block.arguments.rules.iter();
            let implicit = rules.find(|listed| scene::is_implicit(listed.rule));
            let slopes = implicit.map(|listed| {
                let slopes = scene::slopes(&scene, &arena);
                slopes.map_err(|reason| syn::Error::new(listed.place, reason))
            });
            let slopes = slopes.transpose()?;
            return Ok(rust::print_scene(&scene, slopes.as_ref(), &block, &arena));
        }
    };
    applicable::check(&block, &model)?;
    let settings = Settings {
        // states of a path with a time scale are stepped one by one
        lanes: settings.lanes && block.time_scale.is_none(),
        ..settings
    };
    let budget = Budget::new(&block, &model, work)?;
    let system = classify(&block, model, &budget, &mut arena)?;
    let derivation = derive(block, system, &budget, settings, arena)?;
    Ok(rust::print(&derivation))
}

/// A system as it is read.
enum Read {
    Unrolled(Box<Model>),
    /// The arguments are slices.
    Scene(Box<Scene>),
}

/// Reads a block. After errors, `mistaken` gets the names of functions and constants with errors.
fn read(
    attribute: TokenStream,
    item: ItemImpl,
    arena: &mut Arena,
    mistaken: &mut BTreeSet<String>,
) -> syn::Result<(Annotated, Read)> {
    let mut errors = Errors::new();
    let read = parse::annotated(attribute, item, &mut errors).and_then(|block| {
        let system = if block.is_scene() {
            interpret::scene(&block, arena, &mut errors).map(|scene| Read::Scene(scene.into()))
        } else {
            let model = interpret::interpret(&block, arena, &mut errors);
            model.map(|model| Read::Unrolled(model.into()))
        };
        Some((block, system?))
    });
    mistaken.clone_from(errors.places());
    let unreadable = || syn::Error::new(Span::call_site(), "this block cannot be read");
    errors.finish(read)?.ok_or_else(unreadable)
}
