//! Tokens → annotated block: which function plays which role, and the errors of shape.
//!
//! Input: the attribute's arguments and the `impl` block. Output: [`Annotated`], the functions of the block sorted by role.
//! Bodies are shared, never copied: they may be long, and copying recurses.

use std::rc::Rc;

use proc_macro2::{Delimiter, Group, Span, TokenStream, TokenTree};
use syn::parse::{ParseStream, Parser};
use syn::spanned::Spanned;
use syn::{
    FnArg, Ident, ImplItem, ImplItemConst, ImplItemFn, ItemImpl, Pat, ReturnType, Token, Type,
};

use crate::errors::{Errors, nearest};
use crate::rule::Rule;

/// The arguments of the attribute.
pub(crate) struct Arguments {
    pub(crate) rules: Vec<(Rule, Ident)>,
    /// Path of the runtime crate, `::sve_runtime` unless `crate = path` says otherwise.
    pub(crate) runtime: syn::Path,
}

/// What a function of the block is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Role {
    Lagrangian,
    Gamma,
    H1,
    Force,
    Symmetry,
    Helper,
}

/// A function that plays a role in mechanics, taken apart.
pub(crate) struct Part {
    pub(crate) name: Ident,
    pub(crate) role: Role,
    /// Pattern and type of the arguments after `&self`.
    pub(crate) arguments: Vec<(Pat, Type)>,
    /// Whether the first of them is the time.
    pub(crate) timed: bool,
    pub(crate) output: Type,
    pub(crate) function: Rc<ImplItemFn>,
}

/// The user's block, sorted.
pub(crate) struct Annotated {
    pub(crate) arguments: Arguments,
    /// The block, emptied of its members.
    pub(crate) item: ItemImpl,
    pub(crate) lagrangian: Part,
    /// `#[gamma]` and `#[h1]` functions in source order.
    pub(crate) noises: Vec<Part>,
    /// `#[force]` functions, which add up.
    pub(crate) forces: Vec<Part>,
    pub(crate) symmetries: Vec<Part>,
    /// All functions, for any can be called from another.
    pub(crate) functions: Vec<Rc<ImplItemFn>>,
    pub(crate) constants: Vec<ImplItemConst>,
}

impl Arguments {
    /// Reads the attribute; what is wrong in it is left out.
    pub(crate) fn read(attribute: TokenStream, errors: &mut Errors) -> Self {
        let mut read = Self {
            rules: Vec::new(),
            runtime: syn::parse_quote!(::sve_runtime),
        };
        let before = errors.count();
        let parsed = (|input: ParseStream<'_>| read.entries(input, errors)).parse2(attribute);
        errors.keep(parsed);
        if read.rules.is_empty() && errors.count() == before {
            errors.push(
                Span::call_site(),
                format!(
                    "name the rules to derive, for example `#[variational(midpoint)]`: {}",
                    Rule::listed()
                ),
            );
        }
        read
    }

    fn entries(&mut self, input: ParseStream<'_>, errors: &mut Errors) -> syn::Result<()> {
        while !input.is_empty() {
            if input.peek(Token![crate]) {
                input.parse::<Token![crate]>()?;
                input.parse::<Token![=]>()?;
                self.runtime = input.call(syn::Path::parse_mod_style)?;
            } else {
                let name: Ident = input.parse().map_err(|e| {
                    syn::Error::new(
                        e.span(),
                        format!(
                            "expected the name of a rule, without quotes: {}",
                            Rule::listed()
                        ),
                    )
                })?;
                if !input.is_empty() && !input.peek(Token![,]) {
                    // what follows is a part of the same mistake
                    return Err(no_argument(&name, input.span()));
                }
                match Rule::named(&name.to_string()) {
                    Some(rule) if self.rules.iter().any(|(other, _)| *other == rule) => {
                        errors.push(
                            name.span(),
                            format!("the rule `{name}` is listed twice: remove one"),
                        );
                    }
                    Some(rule) => self.rules.push((rule, name)),
                    None => errors.push(name.span(), unknown_rule(&name.to_string())),
                }
            }
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        Ok(())
    }
}

/// What to say of a name in the attribute that something else than a comma follows.
fn no_argument(name: &Ident, follows: Span) -> syn::Error {
    match Rule::named(&name.to_string()) {
        Some(_) => syn::Error::new(
            follows,
            "expected a comma: rules take no arguments, as in `#[variational(midpoint, endpoint)]`",
        ),
        None => syn::Error::new(
            name.span(),
            format!(
                "there is no argument `{name}`: the arguments are rules ({}) and `crate = path`",
                Rule::listed()
            ),
        ),
    }
}

fn unknown_rule(name: &str) -> String {
    match nearest(name, Rule::ALL.iter().map(|r| r.attribute_name())) {
        Some(near) => format!(
            "there is no rule `{name}`; did you mean `{near}`? The rules are {}",
            Rule::listed()
        ),
        None => format!(
            "there is no rule `{name}`; the rules are {}",
            Rule::listed()
        ),
    }
}

/// Sorts the block; nothing where its functions cannot be read for a mistake.
pub(crate) fn annotated(
    attribute: TokenStream,
    mut item: ItemImpl,
    errors: &mut Errors,
) -> Option<Annotated> {
    let arguments = Arguments::read(attribute, errors);
    let before = errors.count();
    check_block(&item, errors);
    let is_plain = errors.count() == before;
    let roles = take_roles(&mut item, errors);

    let mut lagrangians = Vec::new();
    let mut noises = Vec::new();
    let mut forces = Vec::new();
    let mut symmetries = Vec::new();
    let mut functions = Vec::new();
    let mut constants = Vec::new();
    for (member, role) in std::mem::take(&mut item.items).into_iter().zip(roles) {
        match (member, role) {
            (ImplItem::Fn(function), Some(role)) => {
                let function = Rc::new(function);
                let outer = errors.enter(&function.sig.ident.to_string());
                match role {
                    Role::Helper => {}
                    // one that cannot be read is there nevertheless
                    Role::Lagrangian => lagrangians.push(errors.keep(part(&function, role))),
                    Role::Gamma | Role::H1 => noises.extend(errors.keep(part(&function, role))),
                    Role::Force => forces.extend(errors.keep(part(&function, role))),
                    Role::Symmetry => symmetries.extend(errors.keep(part(&function, role))),
                }
                errors.leave(outer);
                functions.push(function);
            }
            (ImplItem::Const(constant), _) => constants.push(constant),
            _ => {}
        }
    }
    if lagrangians.is_empty() {
        errors.push(
            item.self_ty.span(),
            "this block has no Lagrangian: add `fn lagrangian(&self, q: [f64; N], v: [f64; N]) -> f64`",
        );
    }
    if let Some(Some(second)) = lagrangians.get(1) {
        errors.push(
            second.name.span(),
            "the block has two functions `lagrangian`: keep one",
        );
    }
    let lagrangian = lagrangians.into_iter().next().flatten();
    is_plain.then_some(Annotated {
        arguments,
        item,
        lagrangian: lagrangian?,
        noises,
        forces,
        symmetries,
        functions,
        constants,
    })
}

fn check_block(item: &ItemImpl, errors: &mut Errors) {
    if let Some((path, _)) = &item.trait_ {
        errors.push(
            path.span(),
            "`#[variational]` belongs on an inherent block, `impl MySystem { … }`, not on the implementation of a trait",
        );
    }
    if !item.generics.params.is_empty() {
        errors.push(
            item.generics.span(),
            "a generic system cannot be differentiated at compile time: write a concrete type, with parameters as fields",
        );
    }
}

/// The attribute of a role that does not exist yet.
const LATER: &str = "constraint";

/// The role of each member; the attributes that say so are removed.
fn take_roles(item: &mut ItemImpl, errors: &mut Errors) -> Vec<Option<Role>> {
    let mut roles = Vec::new();
    for member in &mut item.items {
        let (attributes, name) = match member {
            ImplItem::Fn(f) => (&mut f.attrs, Some(f.sig.ident.clone())),
            ImplItem::Const(c) => (&mut c.attrs, None),
            _ => {
                roles.push(None);
                continue;
            }
        };
        if let Some(attribute) = attributes.iter().find(|a| a.path().is_ident("cfg")) {
            errors.push(
                attribute.span(),
                "whether this `cfg` holds is not known to the macro: put it on the whole block, or on two blocks",
            );
        }
        let mut found: Vec<Role> = Vec::new();
        attributes.retain(|attribute| {
            let Some(ident) = attribute.path().get_ident().map(ToString::to_string) else {
                return true;
            };
            if ident == LATER {
                errors.push(
                    attribute.span(),
                    format!(
                        "`#[{LATER}]` is not supported yet: remove the function or the attribute"
                    ),
                );
                return false;
            }
            let Some(role) = Role::of_attribute(&ident) else {
                return true;
            };
            if name.is_none() {
                errors.push(
                    attribute.span(),
                    format!("`#[{ident}]` belongs on a function"),
                );
            }
            if attribute.meta.require_path_only().is_err() {
                errors.push(
                    attribute.span(),
                    format!("`#[{ident}]` takes no arguments: the signature says all"),
                );
            }
            found.push(role);
            false
        });
        let role = name.map(|name| {
            if found.len() > 1 {
                errors.push(
                    name.span(),
                    format!("`{name}` plays two roles: keep one of its attributes"),
                );
            }
            match found.first() {
                Some(role) if name == "lagrangian" => {
                    errors.push(
                        name.span(),
                        format!(
                            "`lagrangian` cannot play another role: rename it, or remove `#[{}]`",
                            role.attribute()
                        ),
                    );
                    Role::Lagrangian
                }
                Some(&role) => role,
                None if name == "lagrangian" => Role::Lagrangian,
                None => Role::Helper,
            }
        });
        roles.push(role);
    }
    roles
}

impl Role {
    /// The roles that an attribute gives.
    const MARKED: [Self; 4] = [Self::Gamma, Self::H1, Self::Force, Self::Symmetry];

    fn of_attribute(name: &str) -> Option<Self> {
        Self::MARKED
            .into_iter()
            .find(|role| role.attribute() == name)
    }

    pub(crate) fn attribute(self) -> &'static str {
        match self {
            Self::Gamma => "gamma",
            Self::H1 => "h1",
            Self::Force => "force",
            Self::Symmetry => "symmetry",
            Self::Lagrangian | Self::Helper => "",
        }
    }

    /// The signature that a function of this role must have.
    fn signature(self) -> &'static str {
        match self {
            Self::Lagrangian => "fn lagrangian(&self, q: [f64; N], v: [f64; N]) -> f64",
            Self::Gamma => "fn name(&self, q: [f64; N]) -> f64` or `-> [f64; M]",
            Self::H1 => "fn name(&self, q: [f64; N], p: [f64; N]) -> f64` or `-> [f64; M]",
            Self::Force => "fn name(&self, q: [f64; N], v: [f64; N]) -> [f64; N]",
            Self::Symmetry => "fn name(&self, q: [f64; N]) -> [f64; N]",
            Self::Helper => "",
        }
    }

    /// Vector arguments after `&self` and the optional time.
    fn vectors(self) -> usize {
        match self {
            Self::Gamma | Self::Symmetry => 1,
            Self::Lagrangian | Self::H1 | Self::Force | Self::Helper => 2,
        }
    }
}

/// Takes a function apart, or says what its signature should be.
fn part(function: &Rc<ImplItemFn>, role: Role) -> syn::Result<Part> {
    let sig = &function.sig;
    let expected = format!("expected `{}` (`t: f64` may come first)", role.signature());
    if !sig.generics.params.is_empty() {
        let message = format!("this function cannot be generic: {expected}");
        return Err(syn::Error::new(sig.generics.span(), message));
    }
    let mut inputs = sig.inputs.iter();
    let message = format!("the first argument must be `&self`: {expected}");
    match inputs.next() {
        Some(FnArg::Receiver(receiver)) if is_shared(receiver) => {}
        Some(other) => return Err(syn::Error::new(other.span(), message)),
        None => return Err(syn::Error::new(sig.ident.span(), message)),
    }
    let arguments: Vec<(Pat, Type)> = inputs
        .filter_map(|input| match input {
            FnArg::Typed(typed) => Some(((*typed.pat).clone(), (*typed.ty).clone())),
            FnArg::Receiver(_) => None,
        })
        .collect();
    let timed = is_timed(&sig.ident, role, &arguments, &expected)?;
    let ReturnType::Type(_, output) = &sig.output else {
        let message = format!("`{}` returns nothing: {expected}", sig.ident);
        return Err(syn::Error::new(sig.ident.span(), message));
    };
    Ok(Part {
        name: sig.ident.clone(),
        role,
        arguments,
        timed,
        output: (**output).clone(),
        function: Rc::clone(function),
    })
}

/// Whether the first argument is the time, or what is wrong with the arguments.
fn is_timed(
    name: &Ident,
    role: Role,
    arguments: &[(Pat, Type)],
    expected: &str,
) -> syn::Result<bool> {
    if arguments.len() == role.vectors() {
        return Ok(false);
    }
    if arguments.len() != role.vectors() + 1 {
        let hint = match role {
            Role::H1 if arguments.len() == 1 => "; a noise that depends on q alone is `#[gamma]`",
            _ => "",
        };
        let count = match arguments.len() {
            1 => "one argument".to_owned(),
            n => format!("{n} arguments"),
        };
        let message = format!("`{name}` has {count} after `&self`: {expected}{hint}");
        return Err(syn::Error::new(name.span(), message));
    }
    let is_time = is_f64(&arguments[0].1);
    if role.vectors() == 1 && (!is_time || is_momentum(&arguments[1].0)) {
        let hint = match role {
            Role::Gamma => "; a noise that depends on the momentum is `#[h1]`",
            _ => "",
        };
        let message = format!(
            "`#[{}]` depends on q alone: {expected}{hint}",
            role.attribute()
        );
        return Err(syn::Error::new(arguments[1].0.span(), message));
    }
    if !is_time {
        let message = format!("of three arguments the first is the time, `t: f64`: {expected}");
        return Err(syn::Error::new(arguments[0].1.span(), message));
    }
    Ok(true)
}

/// Whether an argument is called like a velocity or a momentum, so that the one before it is no time.
fn is_momentum(pattern: &Pat) -> bool {
    let Pat::Ident(name) = pattern else {
        return false;
    };
    matches!(name.ident.to_string().trim_start_matches('_'), "v" | "p")
}

fn is_shared(receiver: &syn::Receiver) -> bool {
    let mut tokens = quote::ToTokens::to_token_stream(receiver)
        .into_iter()
        .map(|t| t.to_string());
    tokens.next().as_deref() == Some("&")
        && tokens.next().as_deref() == Some("self")
        && tokens.next().is_none()
}

/// Whether a type is written `f64`.
pub(crate) fn is_f64(ty: &Type) -> bool {
    matches!(ty, Type::Path(path) if path.qself.is_none() && path.path.is_ident("f64"))
}

/// The block as it is emitted: the user's tokens without the attributes that only this macro understands.
pub(crate) fn without_roles(item: &TokenStream) -> TokenStream {
    let mut tokens: Vec<TokenTree> = item.clone().into_iter().collect();
    if let Some(TokenTree::Group(body)) = tokens.last_mut()
        && body.delimiter() == Delimiter::Brace
    {
        let mut kept = Group::new(Delimiter::Brace, members_without_roles(body.stream()));
        kept.set_span(body.span());
        *body = kept;
    }
    tokens.into_iter().collect()
}

fn members_without_roles(members: TokenStream) -> TokenStream {
    let mut kept: Vec<TokenTree> = Vec::new();
    for token in members {
        let hash = matches!(kept.last(), Some(TokenTree::Punct(punct)) if punct.as_char() == '#');
        match &token {
            TokenTree::Group(group) if hash && is_role(group) => {
                kept.pop();
            }
            _ => kept.push(token),
        }
    }
    kept.into_iter().collect()
}

/// Whether an attribute of this name gives a role.
pub(crate) fn is_role_name(name: &str) -> bool {
    name == LATER || Role::of_attribute(name).is_some()
}

/// Whether `[…]` is an attribute of this macro.
fn is_role(group: &Group) -> bool {
    let mut inside = group.stream().into_iter();
    let name = match inside.next() {
        Some(TokenTree::Ident(name)) => name.to_string(),
        _ => return false,
    };
    let path = matches!(inside.next(), Some(TokenTree::Punct(punct)) if punct.as_char() == ':');
    !path && is_role_name(&name)
}
