//! The argument `u`: values that are held over a step.
//!
//! Input: the arguments of a function with a role. Output: its arguments without `u`, and that of
//! the block, which has one type in all functions.

use syn::spanned::Spanned;
use syn::{FnArg, ImplItemFn, Pat, Type};

use super::parse::RoleFunction;
use super::readable;
use super::roles::Role;
use crate::errors::Errors;

/// Returns whether an argument is called `u` or `_u`.
fn is_input(pattern: &Pat) -> bool {
    match pattern {
        Pat::Ident(name) => name.ident == "u" || name.ident == "_u",
        _ => false,
    }
}

/// Returns the type of the last argument of a function, if it is called `u` or `_u` and stands
/// behind at least `others` other arguments.
pub(crate) fn last_input(function: &ImplItemFn, others: usize) -> Option<&Type> {
    let inputs = &function.sig.inputs;
    match inputs.last() {
        // the first argument is `&self`
        Some(FnArg::Typed(last)) if inputs.len() > 1 + others && is_input(&last.pat) => {
            Some(&last.ty)
        }
        _ => None,
    }
}

/// Takes the argument `u` or `_u` from the end of the arguments of a function with more arguments
/// than its quantities have.
pub(super) fn take_input(
    role: Role,
    parts: usize,
    arguments: &mut Vec<(Pat, Type)>,
) -> syn::Result<Option<(Pat, Type)>> {
    let needed = role.vectors() * parts;
    if arguments.len() <= needed {
        return Ok(None);
    }
    let Some(at) = arguments.iter().position(|(pattern, _)| is_input(pattern)) else {
        return Ok(None);
    };
    let refuse = |message: &str| Err(syn::Error::new(arguments[at].0.span(), message));
    if at + 1 < arguments.len() {
        return refuse("the input `u` is the last argument: `(t, q, v, u)`");
    }
    match role {
        Role::Constraint => refuse(
            "a constraint with an input would have to move q where the input jumps: write `t`, or a stiff potential of the input",
        ),
        Role::Symmetry => refuse(
            "a generator of a symmetry has no input: each value of `u` has the same symmetry",
        ),
        Role::TimeScale => refuse(
            "a time scale with an input would jump with it, and the energy on which the path stays is that of its start: leave `u` out",
        ),
        _ => Ok(arguments.pop()),
    }
}

/// Returns the arguments without a last one that is called `u` or `_u`.
pub(super) fn without_last_input(arguments: &[(Pat, Type)]) -> &[(Pat, Type)] {
    match arguments {
        [others @ .., (last, _)] if is_input(last) => others,
        all => all,
    }
}

/// Returns the type of the inputs of a block; `None` if no function has any. Reports a function
/// whose inputs are of another type.
pub(super) fn input_type<'a>(
    functions: impl Iterator<Item = &'a RoleFunction>,
    errors: &mut Errors,
) -> Option<Type> {
    let mut first: Option<Type> = None;
    for function in functions {
        let Some((_, ty)) = &function.input else {
            continue;
        };
        match &first {
            None => first = Some(ty.clone()),
            Some(first) if readable(first) != readable(ty) => {
                let message = format!(
                    "the inputs of all functions are of one type: here `{}`, there `{}`",
                    readable(ty),
                    readable(first)
                );
                errors.push(ty.span(), message);
            }
            Some(_) => {}
        }
    }
    first
}
