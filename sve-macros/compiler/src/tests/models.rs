//! The annotated blocks of the models of the workspace's tests.

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::{Item, ItemImpl};

const FILES: [&str; 10] = [
    include_str!("../../../../tests/models/src/models/banded.rs"),
    include_str!("../../../../tests/models/src/models/constrained.rs"),
    include_str!("../../../../tests/models/src/models/deterministic.rs"),
    include_str!("../../../../tests/models/src/models/forced.rs"),
    include_str!("../../../../tests/models/src/models/noisy.rs"),
    include_str!("../../../../tests/models/src/models/surfaces.rs"),
    include_str!("../../../../tests/models/src/models/symmetric.rs"),
    include_str!("../../../../tests/models/src/configured.rs"),
    include_str!("../../../../tests/models/src/degenerate/mod.rs"),
    include_str!("../../../../tests/models/src/potential.rs"),
];

/// An `impl` block with the arguments of its attribute.
pub(super) struct Annotated {
    pub(super) name: String,
    pub(super) attribute: TokenStream,
    pub(super) block: ItemImpl,
}

/// Returns all blocks in the order of their files.
pub(super) fn models() -> Vec<Annotated> {
    let files = FILES.map(|text| syn::parse_file(text).expect("a file of models"));
    let items = files.into_iter().flat_map(|file| file.items);
    items.filter_map(annotated).collect()
}

fn annotated(item: Item) -> Option<Annotated> {
    let Item::Impl(mut block) = item else {
        return None;
    };
    let is_this =
        |a: &syn::Attribute| a.path().is_ident("variational") || a.path().is_ident("compared");
    let at = block.attrs.iter().position(is_this)?;
    let attribute = block.attrs.remove(at).meta;
    Some(Annotated {
        name: block.self_ty.to_token_stream().to_string(),
        attribute: attribute.require_list().expect("rules").tokens.clone(),
        block,
    })
}
