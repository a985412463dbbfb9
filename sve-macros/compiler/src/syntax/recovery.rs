//! The user's block after an error, changed so that the compiler does not report the same mistakes
//! in its own words.
//!
//! Input: the block, and the names of the functions and constants in which mistakes were found.
//! These functions keep their signatures and lose their bodies; all other items stay unchanged.

use std::collections::BTreeSet;

use quote::quote;
use syn::{
    Attribute, Expr, GenericArgument, ImplItem, ImplItemConst, ImplItemFn, ItemImpl, PathArguments,
    ReturnType, Type, parse_quote,
};

use super::nalgebra::{Kind, Size, Written};
use super::parse::{is_f64, is_this};
use super::roles::is_role_name;

/// Removes the bodies in which mistakes were found, and the parts that the compiler would report
/// because of them.
pub(crate) fn remove_mistakes(block: &mut ItemImpl, mistaken: &BTreeSet<String>) {
    let constants: BTreeSet<String> = block
        .items
        .iter()
        .filter_map(|member| match member {
            ImplItem::Const(constant) => Some(constant.ident.to_string()),
            _ => None,
        })
        .collect();
    let mut lagrangians = 0;
    block.items.retain_mut(|member| match member {
        ImplItem::Fn(function) => {
            let name = function.sig.ident.to_string();
            // the compiler would also report the name of the second function
            lagrangians += usize::from(name == "lagrangian");
            if mistaken.contains(&name) {
                empty(function);
            }
            own_lengths(function, &constants);
            name != "lagrangian" || lagrangians == 1
        }
        ImplItem::Const(constant) => {
            if mistaken.contains(&format!("const {}", constant.ident)) {
                zero(constant);
            }
            true
        }
        _ => true,
    });
}

/// Removes the attributes of this macro from the block and its members.
pub(crate) fn remove_attributes(block: &mut ItemImpl) {
    block.attrs.retain(|attribute| !is_this(attribute));
    for member in &mut block.items {
        if let Some(attributes) = member_attributes(member) {
            attributes.retain(|a| {
                !a.path()
                    .get_ident()
                    .is_some_and(|i| is_role_name(&i.to_string()))
            });
        }
    }
}

fn member_attributes(member: &mut ImplItem) -> Option<&mut Vec<Attribute>> {
    match member {
        ImplItem::Fn(function) => Some(&mut function.attrs),
        ImplItem::Const(constant) => Some(&mut constant.attrs),
        _ => None,
    }
}

/// Removes the body.
fn empty(function: &mut ImplItemFn) {
    let fail = quote!(::core::unreachable!("the macro reported an error"));
    function.block = parse_quote!({ #fail });
    function.attrs.push(parse_quote! {
        #[allow(unused_variables, unused_mut, clippy::all, clippy::pedantic, clippy::nursery)]
    });
}

/// Gives a constant a value of its type, if this type consists of `f64`.
fn zero(constant: &mut ImplItemConst) {
    if let Some(value) = zero_of(&constant.ty) {
        constant.expr = value;
    }
}

fn zero_of(ty: &Type) -> Option<Expr> {
    match ty {
        Type::Array(array) => {
            let (entry, length) = (zero_of(&array.elem)?, &array.len);
            Some(parse_quote!([#entry; #length]))
        }
        _ if is_f64(ty) => Some(parse_quote!(0.0)),
        _ => {
            let written = Written::of_type(ty).filter(|written| written.kind == Kind::Matrix)?;
            let (Size::Known(rows), Size::Known(columns)) = (written.rows, written.columns) else {
                return None;
            };
            let zeros = vec![quote!(0.0); rows * columns];
            Some(parse_quote!(<#ty>::new(#(#zeros),*)))
        }
    }
}

/// Replaces `[f64; N]` with a constant `N` of this block by `[f64; Self::N]`, and `SVector<f64, N>`
/// by `SVector<f64, { Self::N }>`.
fn own_lengths(function: &mut ImplItemFn, constants: &BTreeSet<String>) {
    for argument in &mut function.sig.inputs {
        if let syn::FnArg::Typed(argument) = argument {
            own_length(&mut argument.ty, constants);
        }
    }
    if let ReturnType::Type(_, ty) = &mut function.sig.output {
        own_length(ty, constants);
    }
}

fn own_length(ty: &mut Type, constants: &BTreeSet<String>) {
    match ty {
        Type::Reference(reference) => own_length(&mut reference.elem, constants),
        Type::Tuple(tuple) => {
            for ty in &mut tuple.elems {
                own_length(ty, constants);
            }
        }
        Type::Array(array) => {
            own_length(&mut array.elem, constants);
            own_name(&mut array.len, constants);
        }
        Type::Path(path) => {
            let last = path.path.segments.last_mut();
            let Some(PathArguments::AngleBracketed(generics)) = last.map(|s| &mut s.arguments)
            else {
                return;
            };
            for argument in &mut generics.args {
                if let GenericArgument::Type(Type::Path(name)) = argument
                    && let Some(name) = name.path.get_ident().cloned()
                    && constants.contains(&name.to_string())
                {
                    *argument = GenericArgument::Const(parse_quote!({ Self::#name }));
                }
            }
        }
        _ => {}
    }
}

fn own_name(length: &mut Expr, constants: &BTreeSet<String>) {
    match length {
        Expr::Binary(binary) => {
            own_name(&mut binary.left, constants);
            own_name(&mut binary.right, constants);
        }
        Expr::Paren(inner) => own_name(&mut inner.expr, constants),
        Expr::Path(path) => {
            if let Some(name) = path.path.get_ident().cloned()
                && constants.contains(&name.to_string())
            {
                path.path = parse_quote!(Self::#name);
            }
        }
        _ => {}
    }
}
