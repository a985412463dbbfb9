//! Functions of a reduced system, that is, of a rigid body without its attitude.
//!
//! Input: a function of the body velocity or of the body momentum, `(&self, w: Vector3<f64>)`.
//! Output: the function with the rotation as its first argument, which no body reads. All later
//! stages derive the step of the rotation.

use std::rc::Rc;

use syn::spanned::Spanned;
use syn::{FnArg, ImplItemFn, Type, parse_quote};

use super::inputs::last_input;
use super::parse::{RoleFunction, role_function};
use super::roles::Role;
use super::signature::is_rotation;

/// Parses a function with a role in a reduced system. The error shows the expected signature.
pub(super) fn role_function_of(function: &Rc<ImplItemFn>, role: Role) -> syn::Result<RoleFunction> {
    let name = &function.sig.ident;
    let expected = match role {
        Role::Lagrangian | Role::Helper => "fn lagrangian(&self, w: Vector3<f64>) -> f64",
        Role::H1 => "fn name(&self, pi: Vector3<f64>) -> f64` or `-> [f64; M]",
        Role::Force | Role::NoiseForce => "fn name(&self, w: Vector3<f64>) -> Vector3<f64>",
        Role::Gamma | Role::TangentH1 | Role::Symmetry | Role::Constraint | Role::TimeScale => {
            let message = format!(
                "a reduced system has no attitude, on which `{name}` could depend: write `#[h1]` with the momentum `pi`, or leave `reduced` out"
            );
            return Err(syn::Error::new(name.span(), message));
        }
    };
    let types: Vec<&Type> = function.sig.inputs.iter().filter_map(typed).collect();
    if let Some(rotation) = types.iter().find(|ty| is_rotation(ty)) {
        let message = format!(
            "a reduced system has no attitude: expected `{expected}`, or leave `reduced` out"
        );
        return Err(syn::Error::new(rotation.span(), message));
    }
    let behind = usize::from(last_input(function, 1).is_some());
    let [.., vector] = &types[..types.len().saturating_sub(behind)] else {
        let message = format!("`{name}` has no argument after `&self`: expected `{expected}`");
        return Err(syn::Error::new(name.span(), message));
    };
    let rotation = rotation(vector);
    let mut with_rotation = ImplItemFn::clone(function);
    let place = with_rotation.sig.inputs.len() - 1 - behind;
    let argument: FnArg = parse_quote!(_: #rotation);
    with_rotation.sig.inputs.insert(place, argument);
    role_function(&Rc::new(with_rotation), role).map_err(|error| {
        syn::Error::new(
            error.span(),
            format!("expected `{expected}` (`t: f64` may come first)"),
        )
    })
}

fn typed(input: &FnArg) -> Option<&Type> {
    match input {
        FnArg::Typed(typed) => Some(&typed.ty),
        FnArg::Receiver(_) => None,
    }
}

/// Returns the type of the rotations to which velocities or momenta belong. There are as many
/// rotations as vectors.
fn rotation(vector: &Type) -> Type {
    match vector {
        Type::Array(array) => {
            let (inner, length) = (rotation(&array.elem), &array.len);
            parse_quote!([#inner; #length])
        }
        _ => parse_quote!(Rotation3<f64>),
    }
}
