//! Tokens → annotated block: which function plays which role, and the errors of shape.
//!
//! Input: the attribute's arguments and the `impl` block. Output: [`Annotated`], with the block as it will be emitted
//! (the role attributes removed) and its functions sorted by role.

use proc_macro2::{Span, TokenStream};
use syn::parse::{Parse, ParseStream};
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
    pub(crate) body: syn::Block,
}

/// The user's block, sorted.
pub(crate) struct Annotated {
    pub(crate) arguments: Arguments,
    /// The block without the attributes that only this macro understands.
    pub(crate) item: ItemImpl,
    pub(crate) lagrangian: Part,
    /// `#[gamma]` and `#[h1]` functions in source order.
    pub(crate) noises: Vec<Part>,
    pub(crate) helpers: Vec<ImplItemFn>,
    pub(crate) constants: Vec<ImplItemConst>,
}

impl Parse for Arguments {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut errors = Errors::new();
        let mut rules: Vec<(Rule, Ident)> = Vec::new();
        let mut runtime = syn::parse_quote!(::sve_runtime);
        while !input.is_empty() {
            if input.peek(Token![crate]) {
                input.parse::<Token![crate]>()?;
                input.parse::<Token![=]>()?;
                runtime = input.call(syn::Path::parse_mod_style)?;
            } else {
                let name: Ident = input.parse().map_err(|e| {
                    syn::Error::new(
                        e.span(),
                        format!("expected the name of a rule: {}", Rule::listed()),
                    )
                })?;
                match Rule::named(&name.to_string()) {
                    Some(rule) if rules.iter().any(|(other, _)| *other == rule) => {
                        errors.push(
                            name.span(),
                            format!("the rule `{name}` is listed twice: remove one"),
                        );
                    }
                    Some(rule) => rules.push((rule, name)),
                    None => errors.push(name.span(), unknown_rule(&name.to_string())),
                }
            }
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        if rules.is_empty() && errors.count() == 0 {
            errors.push(
                Span::call_site(),
                format!(
                    "name the rules to derive, for example `#[variational(midpoint)]`: {}",
                    Rule::listed()
                ),
            );
        }
        errors.finish(Self { rules, runtime })
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

/// Sorts the block.
pub(crate) fn annotated(attribute: TokenStream, mut item: ItemImpl) -> syn::Result<Annotated> {
    let mut errors = Errors::new();
    let arguments = match syn::parse2::<Arguments>(attribute) {
        Ok(arguments) => Some(arguments),
        Err(error) => {
            errors.add(error);
            None
        }
    };
    check_block(&item, &mut errors);
    let roles = take_roles(&mut item, &mut errors);

    let mut lagrangians: Vec<Part> = Vec::new();
    let mut noises = Vec::new();
    let mut helpers = Vec::new();
    let mut constants = Vec::new();
    for (member, role) in item.items.iter().zip(roles) {
        match (member, role) {
            (ImplItem::Fn(function), Some(Role::Helper)) => helpers.push(function.clone()),
            (ImplItem::Fn(function), Some(role)) => {
                if let Some(part) = part(function, role, &mut errors) {
                    if role == Role::Lagrangian {
                        lagrangians.push(part);
                    } else {
                        noises.push(part);
                    }
                } else if role == Role::Lagrangian {
                    // the mistake is reported; a missing lagrangian would be a second-hand error
                    return Err(errors.finish(()).err().unwrap_or_else(|| {
                        syn::Error::new(function.span(), "this lagrangian cannot be read")
                    }));
                }
            }
            (ImplItem::Const(constant), _) => constants.push(constant.clone()),
            _ => {}
        }
    }
    if lagrangians.len() > 1 {
        errors.push(
            lagrangians[1].name.span(),
            "the block has two functions `lagrangian`: keep one",
        );
    }
    let Some(lagrangian) = lagrangians.into_iter().next() else {
        errors.push(
            item.self_ty.span(),
            "this block has no Lagrangian: add `fn lagrangian(&self, q: [f64; N], v: [f64; N]) -> f64`",
        );
        return Err(errors.finish(()).err().unwrap_or_else(|| {
            syn::Error::new(item.self_ty.span(), "this block has no Lagrangian")
        }));
    };
    match arguments {
        Some(arguments) => errors.finish(Annotated {
            arguments,
            item,
            lagrangian,
            noises,
            helpers,
            constants,
        }),
        None => Err(errors.finish(()).err().unwrap_or_else(|| {
            syn::Error::new(
                Span::call_site(),
                "the arguments of the attribute cannot be read",
            )
        })),
    }
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

/// Role attributes, with what they would need and do not have yet.
const LATER: [&str; 3] = ["force", "symmetry", "constraint"];

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
        let mut found: Vec<Role> = Vec::new();
        attributes.retain(|attribute| {
            let Some(ident) = attribute.path().get_ident().map(ToString::to_string) else {
                return true;
            };
            let role = match ident.as_str() {
                "gamma" => Role::Gamma,
                "h1" => Role::H1,
                later if LATER.contains(&later) => {
                    errors.push(attribute.span(), format!("`#[{later}]` is not supported yet: remove the function or the attribute"));
                    return false;
                }
                _ => return true,
            };
            if name.is_none() {
                errors.push(attribute.span(), format!("`#[{ident}]` belongs on a function"));
            }
            if attribute.meta.require_path_only().is_err() {
                errors.push(attribute.span(), format!("`#[{ident}]` takes no arguments"));
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
                            "`lagrangian` cannot also be a noise: rename it, or remove `#[{}]`",
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
    pub(crate) fn attribute(self) -> &'static str {
        match self {
            Self::Gamma => "gamma",
            Self::H1 => "h1",
            Self::Lagrangian | Self::Helper => "",
        }
    }

    /// The signature that a function of this role must have.
    fn signature(self) -> &'static str {
        match self {
            Self::Lagrangian => "fn lagrangian(&self, q: [f64; N], v: [f64; N]) -> f64",
            Self::Gamma => "fn name(&self, q: [f64; N]) -> f64` or `-> [f64; M]",
            Self::H1 => "fn name(&self, q: [f64; N], p: [f64; N]) -> f64` or `-> [f64; M]",
            Self::Helper => "",
        }
    }

    /// Vector arguments after `&self` and the optional time.
    fn vectors(self) -> usize {
        match self {
            Self::Gamma => 1,
            _ => 2,
        }
    }
}

/// Takes a function apart, or says what its signature should be.
fn part(function: &ImplItemFn, role: Role, errors: &mut Errors) -> Option<Part> {
    let sig = &function.sig;
    let expected = format!("expected `{}` (`t: f64` may come first)", role.signature());
    if !sig.generics.params.is_empty() {
        errors.push(
            sig.generics.span(),
            format!("this function cannot be generic: {expected}"),
        );
        return None;
    }
    let mut inputs = sig.inputs.iter();
    match inputs.next() {
        Some(FnArg::Receiver(receiver)) if is_shared(receiver) => {}
        Some(other) => {
            errors.push(
                other.span(),
                format!("the first argument must be `&self`: {expected}"),
            );
            return None;
        }
        None => {
            errors.push(
                sig.ident.span(),
                format!("the first argument must be `&self`: {expected}"),
            );
            return None;
        }
    }
    let arguments: Vec<(Pat, Type)> = inputs
        .filter_map(|input| match input {
            FnArg::Typed(typed) => Some(((*typed.pat).clone(), (*typed.ty).clone())),
            FnArg::Receiver(_) => None,
        })
        .collect();
    let timed = arguments.len() == role.vectors() + 1;
    if !timed && arguments.len() != role.vectors() {
        let hint = match role {
            Role::Gamma if arguments.len() == 2 => {
                "; a noise that depends on the momentum is `#[h1]`"
            }
            Role::H1 if arguments.len() == 1 => "; a noise that depends on q alone is `#[gamma]`",
            _ => "",
        };
        errors.push(
            sig.ident.span(),
            format!(
                "`{}` has {} arguments after `&self`: {expected}{hint}",
                sig.ident,
                arguments.len()
            ),
        );
        return None;
    }
    if timed && !is_f64(&arguments[0].1) {
        let hint = if role == Role::Gamma {
            "; a noise that depends on the momentum is `#[h1]`"
        } else {
            ""
        };
        errors.push(
            arguments[0].1.span(),
            format!("of three arguments the first is the time, `t: f64`: {expected}{hint}"),
        );
        return None;
    }
    let ReturnType::Type(_, output) = &sig.output else {
        errors.push(
            sig.ident.span(),
            format!("`{}` returns nothing: {expected}", sig.ident),
        );
        return None;
    };
    Some(Part {
        name: sig.ident.clone(),
        role,
        arguments,
        timed,
        output: (**output).clone(),
        body: function.block.clone(),
    })
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

/// The block as it is emitted: without the attributes that only this macro understands.
pub(crate) fn without_roles(mut item: ItemImpl) -> ItemImpl {
    let mut ignored = Errors::new();
    take_roles(&mut item, &mut ignored);
    // What runs are the derivatives: most programs never call L itself. And `&self` is what this macro asks for.
    item.attrs.push(syn::parse_quote!(
        #[allow(dead_code, clippy::trivially_copy_pass_by_ref, clippy::unused_self)]
    ));
    item
}
