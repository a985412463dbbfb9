//! Tokens → annotated block: the roles of functions, and the errors of shape.
//!
//! Input: the attribute's arguments and the `impl` block. Output: [`Annotated`], the functions of
//! the block sorted by role. Bodies are shared and never copied: they may be long, and copying
//! recurses.

use std::rc::Rc;

use proc_macro2::{Span, TokenStream};
use syn::spanned::Spanned;
use syn::{FnArg, Ident, ImplItem, ImplItemConst, ImplItemFn, ItemImpl, Pat, ReturnType, Type};

use crate::errors::{Errors, nearest};
use crate::syntax::arguments::Arguments;
use crate::syntax::inputs::{input_type, take_input, without_last_input};
use crate::syntax::reduced;
use crate::syntax::roles::{Role, take_roles};
use crate::syntax::signature;

/// A function with a role in mechanics, parsed.
pub(crate) struct RoleFunction {
    pub(crate) name: Ident,
    pub(crate) role: Role,
    /// Patterns and types of the arguments after `&self`.
    pub(crate) arguments: Vec<(Pat, Type)>,
    /// True if the first argument is the time.
    pub(crate) is_timed: bool,
    /// The pattern and the type of the argument `u`, which is not among the arguments.
    pub(crate) input: Option<(Pat, Type)>,
    /// Number of arguments of each quantity: two if there are a vector and a rotation, otherwise
    /// one.
    pub(crate) parts: usize,
    pub(crate) output: Type,
    /// The function in the source.
    pub(crate) item: Rc<ImplItemFn>,
}

/// The user's block, with its items sorted.
pub(crate) struct Annotated {
    pub(crate) arguments: Arguments,
    /// The block without its members.
    pub(crate) item: ItemImpl,
    pub(crate) lagrangian: RoleFunction,
    /// The functions of noises in the order of their processes: `#[gamma]` and `#[h1]` functions in
    /// source order, then `#[force(noise)]` functions in source order.
    pub(crate) noises: Vec<RoleFunction>,
    /// `#[force]` functions, whose values are added.
    pub(crate) forces: Vec<RoleFunction>,
    pub(crate) symmetries: Vec<RoleFunction>,
    pub(crate) constraints: Vec<RoleFunction>,
    /// The function of the time scale, if there is one.
    pub(crate) time_scale: Option<RoleFunction>,
    /// The type of the argument `u`, if a function has it.
    pub(crate) inputs: Option<Type>,
    /// All functions, since any of them can be called by another one.
    pub(crate) functions: Vec<Rc<ImplItemFn>>,
    pub(crate) constants: Vec<ImplItemConst>,
}

impl Annotated {
    /// Returns the type of the coordinates, which is the type of the Lagrangian's first vector
    /// argument.
    pub(crate) fn coordinates(&self) -> &Type {
        &self.lagrangian.arguments[usize::from(self.lagrangian.is_timed)].1
    }

    /// Returns whether the coordinates are a slice, whose length is known when the program runs.
    pub(crate) fn is_scene(&self) -> bool {
        signature::entry_of_slice(self.coordinates()).is_some()
    }

    /// Returns the types of the configuration: two if there are a vector and a rotation, otherwise
    /// one.
    pub(crate) fn configuration(&self) -> impl Iterator<Item = &Type> {
        let lagrangian = &self.lagrangian;
        let arguments = &lagrangian.arguments[usize::from(lagrangian.is_timed)..];
        arguments[..lagrangian.parts].iter().map(|(_, ty)| ty)
    }
}

/// Sorts the block; `None` if a mistake prevents its functions from being read.
pub(crate) fn annotated(
    attribute: TokenStream,
    mut item: ItemImpl,
    errors: &mut Errors,
) -> Option<Annotated> {
    let arguments = Arguments::read(attribute, errors);
    let before = errors.count();
    check_block(&item, errors);
    let is_plain = errors.count() == before;
    let mut members = Members::take(&mut item, arguments.is_reduced, errors);
    check_lagrangians(&members, &item, errors);
    let lagrangians = std::mem::take(&mut members.lagrangians);
    let lagrangian = lagrangians.into_iter().next().flatten()?;
    let mut noises = members.of(&[Role::Gamma, Role::H1, Role::TangentH1]);
    noises.extend(members.of(&[Role::NoiseForce]));
    let forces = members.of(&[Role::Force]);
    let readers = || [&lagrangian].into_iter().chain(&noises).chain(&forces);
    let inputs = input_type(readers(), errors);
    let time_scale = members.time_scale(errors);
    is_plain.then_some(Annotated {
        arguments,
        item,
        inputs,
        noises,
        forces,
        symmetries: members.of(&[Role::Symmetry]),
        constraints: members.of(&[Role::Constraint]),
        time_scale,
        functions: members.functions,
        constants: members.constants,
        lagrangian,
    })
}

/// The members of a block, of which the functions with roles are read.
#[derive(Default)]
struct Members {
    /// One that cannot be read counts as present.
    lagrangians: Vec<Option<RoleFunction>>,
    /// The functions with another role.
    others: Vec<RoleFunction>,
    functions: Vec<Rc<ImplItemFn>>,
    constants: Vec<ImplItemConst>,
}

impl Members {
    /// Takes the members out of a block.
    fn take(item: &mut ItemImpl, is_reduced: bool, errors: &mut Errors) -> Self {
        let roles = take_roles(item, errors);
        let read = |function: &Rc<ImplItemFn>, role: Role| {
            if is_reduced {
                reduced::role_function_of(function, role)
            } else {
                role_function(function, role)
            }
        };
        let mut members = Self::default();
        for (member, role) in std::mem::take(&mut item.items).into_iter().zip(roles) {
            match (member, role) {
                (ImplItem::Fn(function), Some(role)) => {
                    let function = Rc::new(function);
                    let outer = errors.enter(&function.sig.ident.to_string());
                    match role {
                        Role::Helper => {}
                        Role::Lagrangian => {
                            let lagrangian = errors.keep(read(&function, role));
                            members.lagrangians.push(lagrangian);
                        }
                        _ => members.others.extend(errors.keep(read(&function, role))),
                    }
                    errors.leave(outer);
                    members.functions.push(function);
                }
                (ImplItem::Const(constant), _) => members.constants.push(constant),
                _ => {}
            }
        }
        members
    }

    /// Takes the functions with some roles, in source order.
    fn of(&mut self, roles: &[Role]) -> Vec<RoleFunction> {
        let all = std::mem::take(&mut self.others).into_iter();
        let (found, rest) = all.partition(|function| roles.contains(&function.role));
        self.others = rest;
        found
    }

    /// Takes the function of the time scale. Reports an error if there are two.
    fn time_scale(&mut self, errors: &mut Errors) -> Option<RoleFunction> {
        let mut time_scales = self.of(&[Role::TimeScale]).into_iter();
        let time_scale = time_scales.next();
        if let Some(second) = time_scales.next() {
            let message = "the block has two functions with `#[time_scale]`: keep one";
            errors.push(second.name.span(), message);
        }
        time_scale
    }
}

/// Reports an error if the block has no Lagrangian or several.
fn check_lagrangians(members: &Members, item: &ItemImpl, errors: &mut Errors) {
    if members.lagrangians.is_empty() {
        let (at, hint) = match misspelt_lagrangian(&members.functions) {
            Some(name) => (name.span(), format!("rename `{name}` to `lagrangian`")),
            None => (
                item.self_ty.span(),
                format!(
                    "add `{}`; equations that follow from none are not planned, and `sve_runtime::guide::not_planned` says what to use for them",
                    Role::Lagrangian.signature()
                ),
            ),
        };
        errors.push(at, format!("this block has no Lagrangian: {hint}"));
    }
    if let Some(Some(second)) = members.lagrangians.get(1) {
        errors.push(
            second.name.span(),
            "the block has two functions `lagrangian`: keep one",
        );
    }
}

/// Returns whether this is a repetition of this macro's attribute.
pub(crate) fn is_this(attribute: &syn::Attribute) -> bool {
    let last = attribute.path().segments.last();
    last.is_some_and(|segment| segment.ident == "variational")
}

/// Returns the function that was meant to be the Lagrangian.
fn misspelt_lagrangian(functions: &[Rc<ImplItemFn>]) -> Option<&Ident> {
    functions.iter().map(|f| &f.sig.ident).find(|name| {
        let name = name.to_string().to_lowercase();
        name == "l" || nearest(&name, ["lagrangian"]).is_some()
    })
}

fn check_block(item: &ItemImpl, errors: &mut Errors) {
    if let Some((path, _)) = &item.trait_ {
        errors.push(
            path.span(),
            "`#[variational]` belongs on an inherent block, `impl MySystem { … }`, not on the implementation of a trait",
        );
    }
    if let Some(second) = item.attrs.iter().find(|a| is_this(a)) {
        errors.push(
            second.path().span(),
            "one attribute lists all rules, as in `#[variational(midpoint, endpoint)]`",
        );
    }
    if !item.generics.params.is_empty() {
        let only_lifetimes = item
            .generics
            .params
            .iter()
            .all(|p| matches!(p, syn::GenericParam::Lifetime(_)));
        let message = if only_lifetimes {
            "lifetimes are left out here: write `'_` where the type has one, as in `impl MySystem<'_>`"
        } else {
            "a generic system cannot be differentiated at compile time: write a concrete type, with parameters as fields"
        };
        errors.push(item.generics.span(), message);
    }
}

/// Parses a function with a role. The error shows the expected signature.
pub(super) fn role_function(function: &Rc<ImplItemFn>, role: Role) -> syn::Result<RoleFunction> {
    let sig = &function.sig;
    let expected = format!("expected `{}` (`t: f64` may come first)", role.signature());
    if !sig.generics.params.is_empty() {
        let message = format!("this function cannot be generic: {expected}");
        return Err(syn::Error::new(sig.generics.span(), message));
    }
    if let Some((at, word)) = qualifier(sig) {
        let message = format!("`{word}` has no place here: {expected}");
        return Err(syn::Error::new(at, message));
    }
    let mut inputs = sig.inputs.iter();
    let message = format!("the first argument must be `&self`: {expected}");
    match inputs.next() {
        Some(FnArg::Receiver(receiver)) if is_shared(receiver) => {}
        Some(other) => return Err(syn::Error::new(other.span(), message)),
        None => return Err(syn::Error::new(sig.ident.span(), message)),
    }
    let mut arguments: Vec<(Pat, Type)> = inputs
        .filter_map(|input| match input {
            FnArg::Typed(typed) => Some(((*typed.pat).clone(), (*typed.ty).clone())),
            FnArg::Receiver(_) => None,
        })
        .collect();
    let parts = signature::parts(role, without_last_input(&arguments))?;
    let input = take_input(role, parts, &mut arguments)?;
    let is_timed = signature::is_timed(&sig.ident, role, parts, &arguments, &expected)?;
    let ReturnType::Type(_, output) = &sig.output else {
        let message = format!("`{}` returns nothing: {expected}", sig.ident);
        return Err(syn::Error::new(sig.ident.span(), message));
    };
    Ok(RoleFunction {
        name: sig.ident.clone(),
        role,
        arguments,
        is_timed,
        input,
        parts,
        output: (**output).clone(),
        item: Rc::clone(function),
    })
}

/// Returns a qualifier by which a function is not a formula, with its place.
fn qualifier(sig: &syn::Signature) -> Option<(Span, &'static str)> {
    let is_async = sig.asyncness.map(|word| (word.span, "async"));
    let is_unsafe = match &sig.safety {
        syn::Safety::Unsafe(word) => Some((word.span, "unsafe")),
        _ => None,
    };
    let is_extern = sig
        .abi
        .as_ref()
        .map(|abi| (abi.extern_token.span, "extern"));
    is_async.or(is_unsafe).or(is_extern)
}

fn is_shared(receiver: &syn::Receiver) -> bool {
    let mut tokens = quote::ToTokens::to_token_stream(receiver)
        .into_iter()
        .map(|t| t.to_string());
    tokens.next().as_deref() == Some("&")
        && tokens.next().as_deref() == Some("self")
        && tokens.next().is_none()
}

/// Returns whether a type is spelt `f64`.
pub(crate) fn is_f64(ty: &Type) -> bool {
    matches!(ty, Type::Path(path) if path.qself.is_none() && path.path.is_ident("f64"))
}
