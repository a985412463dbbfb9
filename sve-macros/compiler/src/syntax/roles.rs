//! Roles of functions. An attribute gives a role; a misspelt attribute is reported, with the role
//! that it was probably meant to give.
//!
//! Input: the members of the `impl` block. Output: a [`Role`] for each member, and the user's
//! tokens without the attributes of roles.

use proc_macro2::{Delimiter, Group, Ident, TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::{Attribute, ImplItem, ItemImpl};

use crate::errors::{Errors, nearest};

/// The role of a function of the block.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Role {
    Lagrangian,
    Gamma,
    H1,
    /// An H₁ evaluated at the momentum projected onto the constraints, `#[h1(tangent)]`.
    TangentH1,
    Force,
    /// A force that acts with the increments of a Wiener process, `#[force(noise)]`.
    NoiseForce,
    Symmetry,
    Constraint,
    /// s of `dt = s(q) dτ`, `#[time_scale]`.
    TimeScale,
    Helper,
}

/// The argument of `#[h1(tangent)]`.
const TANGENT: &str = "tangent";

/// The argument of `#[force(noise)]`.
const NOISE: &str = "noise";

/// Returns the role of each member and removes the attributes of roles.
pub(crate) fn take_roles(item: &mut ItemImpl, errors: &mut Errors) -> Vec<Option<Role>> {
    item.items
        .iter_mut()
        .map(|member| match member {
            ImplItem::Fn(function) => {
                let found = take_attributes(&mut function.attrs, true, errors);
                Some(role(&function.sig.ident, &found, errors))
            }
            ImplItem::Const(constant) => {
                take_attributes(&mut constant.attrs, false, errors);
                None
            }
            _ => None,
        })
        .collect()
}

/// Returns the roles that the attributes of a member give, and removes these attributes.
fn take_attributes(
    attributes: &mut Vec<Attribute>,
    is_function: bool,
    errors: &mut Errors,
) -> Vec<Role> {
    if let Some(attribute) = attributes.iter().find(|a| a.path().is_ident("cfg")) {
        errors.push(
            attribute.span(),
            "whether this `cfg` holds is not known to the macro: put it on the whole block, or on two blocks",
        );
    }
    let mut found = Vec::new();
    attributes.retain(|attribute| {
        let Some(name) = attribute.path().get_ident().map(ToString::to_string) else {
            return true;
        };
        let Some(role) = Role::of_attribute(&name) else {
            let meant = Role::meant(&name);
            if let Some(role) = meant {
                errors.push(attribute.path().span(), no_role(&name, role));
            }
            return meant.is_none();
        };
        if !is_function {
            errors.push(
                attribute.span(),
                format!("`#[{name}]` belongs on a function"),
            );
        }
        let role = role.with_arguments(attribute).unwrap_or_else(|| {
            let message = match role {
                Role::H1 => format!("`#[{name}]` takes no argument but `{TANGENT}`, which puts the momentum along the constraints in the place of p: `#[{name}({TANGENT})]`"),
                Role::Force => format!("`#[{name}]` takes no argument but `{NOISE}`, which makes the force act with a Wiener process: `#[{name}({NOISE})]`"),
                _ => format!("`#[{name}]` takes no arguments: the signature says all"),
            };
            errors.push(attribute.span(), message);
            role
        });
        found.push(role);
        false
    });
    found
}

/// Returns the role of a function, from its name and the roles that its attributes give.
fn role(name: &Ident, found: &[Role], errors: &mut Errors) -> Role {
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
}

/// Returns the message for an attribute that gives no role.
fn no_role(name: &str, meant: Role) -> String {
    let all = Role::MARKED.map(|role| format!("`#[{}]`", role.attribute()));
    format!(
        "there is no attribute `#[{name}]`; did you mean `#[{}]`? The roles are {}",
        meant.attribute(),
        all.join(", ")
    )
}

impl Role {
    /// The roles that an attribute can give.
    const MARKED: [Self; 6] = [
        Self::Gamma,
        Self::H1,
        Self::Force,
        Self::Symmetry,
        Self::Constraint,
        Self::TimeScale,
    ];

    /// Returns the role that follows from the arguments of its attribute; `None` if the arguments
    /// have no meaning.
    fn with_arguments(self, attribute: &Attribute) -> Option<Self> {
        if attribute.meta.require_path_only().is_ok() {
            return Some(self);
        }
        let argument = attribute.parse_args::<Ident>().ok()?;
        match self {
            Self::H1 if argument == TANGENT => Some(Self::TangentH1),
            Self::Force if argument == NOISE => Some(Self::NoiseForce),
            _ => None,
        }
    }

    fn of_attribute(name: &str) -> Option<Self> {
        Self::MARKED
            .into_iter()
            .find(|role| role.attribute() == name)
    }

    /// Returns the role that a misspelt attribute was probably meant to give.
    fn meant(name: &str) -> Option<Self> {
        let lower = name.to_lowercase();
        let by_another_name = match lower.as_str() {
            "noise" | "wiener" => Some(Self::Gamma),
            "friction" | "damping" | "dissipation" => Some(Self::Force),
            _ => None,
        };
        // Attributes of other macros are left alone. A misspelt attribute must begin with the right
        // letter, and `h1` must not be misspelt: one different letter would be half of the name.
        let marks = Self::MARKED
            .map(Self::attribute)
            .into_iter()
            .filter(|mark| {
                *mark == lower || (mark.len() > 2 && mark.chars().next() == lower.chars().next())
            });
        let misspelt = || nearest(&lower, marks).and_then(Self::of_attribute);
        by_another_name.or_else(misspelt)
    }

    pub(crate) fn attribute(self) -> &'static str {
        match self {
            Self::Gamma => "gamma",
            Self::H1 | Self::TangentH1 => "h1",
            Self::Force | Self::NoiseForce => "force",
            Self::Symmetry => "symmetry",
            Self::Constraint => "constraint",
            Self::TimeScale => "time_scale",
            Self::Lagrangian | Self::Helper => "",
        }
    }

    /// Returns the signature that a function of this role must have.
    pub(crate) fn signature(self) -> &'static str {
        match self {
            Self::Lagrangian => "fn lagrangian(&self, q: [f64; N], v: [f64; N]) -> f64",
            Self::Gamma => "fn name(&self, q: [f64; N]) -> f64` or `-> [f64; M]",
            Self::H1 | Self::TangentH1 => {
                "fn name(&self, q: [f64; N], p: [f64; N]) -> f64` or `-> [f64; M]"
            }
            Self::Constraint => "fn name(&self, q: [f64; N]) -> f64` or `-> [f64; K]",
            Self::Force | Self::NoiseForce => {
                "fn name(&self, q: [f64; N], v: [f64; N]) -> [f64; N]"
            }
            Self::Symmetry => "fn name(&self, q: [f64; N]) -> [f64; N]",
            Self::TimeScale => "fn name(&self, q: [f64; N]) -> f64",
            Self::Helper => "",
        }
    }

    /// Returns the signature that a function of this role must have in a system with rotations. If
    /// there are a vector and a rotation, each quantity has two parts.
    pub(crate) fn signature_with_rotations(self, parts: usize) -> &'static str {
        match (self, parts) {
            (Self::Lagrangian | Self::Helper, 1) => {
                "fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64"
            }
            (Self::Lagrangian | Self::Helper, _) => {
                "fn lagrangian(&self, q: Vector3<f64>, r: Rotation3<f64>, v: Vector3<f64>, w: Vector3<f64>) -> f64"
            }
            (Self::Gamma | Self::Constraint | Self::TimeScale, 1) => {
                "fn name(&self, r: Rotation3<f64>) -> f64"
            }
            (Self::Gamma | Self::Constraint | Self::TimeScale, _) => {
                "fn name(&self, q: Vector3<f64>, r: Rotation3<f64>) -> f64"
            }
            (Self::H1 | Self::TangentH1, 1) => {
                "fn name(&self, r: Rotation3<f64>, pi: Vector3<f64>) -> f64"
            }
            (Self::H1 | Self::TangentH1, _) => {
                "fn name(&self, q: Vector3<f64>, r: Rotation3<f64>, p: Vector3<f64>, pi: Vector3<f64>) -> f64"
            }
            (Self::Force | Self::NoiseForce, 1) => {
                "fn name(&self, r: Rotation3<f64>, w: Vector3<f64>) -> Vector3<f64>"
            }
            (Self::Force | Self::NoiseForce, _) => {
                "fn name(&self, q: Vector3<f64>, r: Rotation3<f64>, v: Vector3<f64>, w: Vector3<f64>) -> (Vector3<f64>, Vector3<f64>)"
            }
            (Self::Symmetry, 1) => "fn name(&self, r: Rotation3<f64>) -> Vector3<f64>",
            (Self::Symmetry, _) => {
                "fn name(&self, q: Vector3<f64>, r: Rotation3<f64>) -> (Vector3<f64>, Vector3<f64>)"
            }
        }
    }

    /// Returns the names of the vector arguments after `&self` and the optional time, in order.
    pub(crate) fn quantities(self) -> &'static [&'static str] {
        match self {
            Self::Gamma | Self::Symmetry | Self::Constraint | Self::TimeScale => &["q"],
            Self::Lagrangian | Self::Force | Self::NoiseForce | Self::Helper => &["q", "v"],
            Self::H1 | Self::TangentH1 => &["q", "p"],
        }
    }

    /// Returns the number of vector arguments after `&self` and the optional time.
    pub(crate) fn vectors(self) -> usize {
        self.quantities().len()
    }
}

/// Returns the block in the form in which it is emitted: the user's tokens without the attributes
/// that only this macro understands.
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

/// Returns whether an attribute with this name gives a role.
pub(crate) fn is_role_name(name: &str) -> bool {
    Role::of_attribute(name).is_some() || Role::meant(name).is_some()
}

/// Returns whether `[…]` is an attribute of this macro.
fn is_role(group: &Group) -> bool {
    let mut inside = group.stream().into_iter();
    let name = match inside.next() {
        Some(TokenTree::Ident(name)) => name.to_string(),
        _ => return false,
    };
    let path = matches!(inside.next(), Some(TokenTree::Punct(punct)) if punct.as_char() == ':');
    !path && is_role_name(&name)
}
