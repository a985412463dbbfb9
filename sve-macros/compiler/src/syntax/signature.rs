//! The arguments of a function with a role. Their order decides their meaning.
//!
//! Input: the role of a function and its arguments after `&self`. Output: whether the first
//! argument is the time, or an error. Types do not distinguish the arguments of a scalar system, so
//! the four names of the documentation are checked: an argument called `t`, `q`, `v` or `p` must
//! stand in the place of this quantity. Other names are not interpreted.

use proc_macro2::Ident;
use syn::spanned::Spanned;
use syn::{Pat, Type};

use crate::syntax::nalgebra::{Kind, Written};
use crate::syntax::parse::is_f64;
use crate::syntax::roles::Role;
use crate::syntax::{bare, readable};

/// Quantities of the arguments: the name in signatures, and its meaning.
const QUANTITIES: [(&str, &str); 4] = [
    ("t", "time"),
    ("q", "position"),
    ("v", "velocity"),
    ("p", "momentum"),
];

/// Returns whether the first argument is the time, or the error of the arguments.
pub(crate) fn is_timed(
    name: &Ident,
    role: Role,
    parts: usize,
    arguments: &[(Pat, Type)],
    expected: &str,
) -> syn::Result<bool> {
    if arguments.iter().any(|(_, ty)| is_rotation(ty)) {
        return is_timed_with_rotations(name, role, parts, arguments);
    }
    let count = arguments.len();
    let timed = count == role.vectors() + 1;
    if !timed && count != role.vectors() {
        let hint = match role {
            Role::H1 | Role::TangentH1 if count == 1 => {
                "; a noise that depends on q alone is `#[gamma]`"
            }
            _ => "",
        };
        let count = match count {
            1 => "one argument".to_owned(),
            n => format!("{n} arguments"),
        };
        let message = format!("`{name}` has {count} after `&self`: {expected}{hint}");
        return Err(syn::Error::new(name.span(), message));
    }
    if timed && role.vectors() == 1 && is_momentum(&arguments[1].0) {
        return Err(depends_on_more(role, arguments, expected));
    }
    check_order(name, role, timed, arguments)?;
    if timed && !is_f64(&arguments[0].1) {
        if role.vectors() == 1 {
            return Err(depends_on_more(role, arguments, expected));
        }
        let message = format!("of three arguments the first is the time, `t: f64`: {expected}");
        return Err(syn::Error::new(arguments[0].1.span(), message));
    }
    Ok(timed)
}

/// Returns the type of the entries of a slice, `&[T]`.
pub(crate) fn entry_of_slice(ty: &Type) -> Option<&Type> {
    match bare(ty) {
        Type::Reference(reference) if reference.mutability.is_none() => {
            match bare(&reference.elem) {
                Type::Slice(slice) => Some(&slice.elem),
                _ => None,
            }
        }
        _ => None,
    }
}

/// Returns the type of the entries of a `Vec<T>`.
pub(crate) fn entry_of_vec(ty: &Type) -> Option<&Type> {
    let Type::Path(path) = bare(ty) else {
        return None;
    };
    let last = path
        .path
        .segments
        .last()
        .filter(|last| last.ident == "Vec")?;
    match &last.arguments {
        syn::PathArguments::AngleBracketed(generics) => match generics.args.first() {
            Some(syn::GenericArgument::Type(entry)) => Some(entry),
            _ => None,
        },
        _ => None,
    }
}

/// Returns whether a type is a rotation, or an array of rotations.
pub(crate) fn is_rotation(ty: &Type) -> bool {
    match bare(ty) {
        Type::Array(array) => is_rotation(&array.elem),
        other => Written::of_type(other).is_some_and(|written| written.kind == Kind::Rotation),
    }
}

/// Returns the number of arguments of each quantity: two if there are a vector and a rotation,
/// otherwise one.
pub(crate) fn parts(role: Role, arguments: &[(Pat, Type)]) -> syn::Result<usize> {
    let Some(at) = arguments.iter().position(|(_, ty)| is_rotation(ty)) else {
        return Ok(1);
    };
    let is_time = |at: usize| at == 0 && is_f64(&arguments[at].1);
    let before = (0..at).filter(|&at| !is_time(at)).count();
    let is_single = role.quantities().len() == 1;
    let is_reversed = arguments.len() >= at + 4
        || is_single
            && arguments
                .get(at + 1)
                .is_some_and(|next| named(&next.0, "q"));
    if before == 0 && is_reversed {
        let message = "a rotation stands behind the vector beside it: write `q: Vector3<f64>, r: Rotation3<f64>`";
        return Err(syn::Error::new(arguments[at].1.span(), message));
    }
    let has_parts = !is_single && arguments.len() >= at + 3;
    if at == 1 && is_time(0) && (has_parts || named(&arguments[0].0, "q")) {
        let message = "one coordinate beside a rotation is written `q: [f64; 1]`";
        return Err(syn::Error::new(arguments[0].1.span(), message));
    }
    Ok(1 + before.min(1))
}

/// Returns whether an argument has this name.
fn named(pattern: &Pat, name: &str) -> bool {
    matches!(pattern, Pat::Ident(ident) if ident.ident == name)
}

/// Returns whether the first argument is the time, in a system with rotations, or the error of the
/// arguments.
fn is_timed_with_rotations(
    name: &Ident,
    role: Role,
    parts: usize,
    arguments: &[(Pat, Type)],
) -> syn::Result<bool> {
    let is_timed = is_f64(&arguments[0].1);
    let count = parts * role.quantities().len();
    let expected = role.signature_with_rotations(parts);
    if arguments.len() != count + usize::from(is_timed) {
        let count = match arguments.len() {
            1 => "one argument".to_owned(),
            n => format!("{n} arguments"),
        };
        let hint = match role {
            Role::Gamma if arguments.len() == 2 * parts => {
                "; a noise that depends on the momentum is `#[h1]`"
            }
            Role::H1 if arguments.len() == parts => {
                "; a noise that depends on the configuration alone is `#[gamma]`"
            }
            _ => "",
        };
        let message = format!(
            "`{name}` has {count} after `&self`: expected `{expected}` (`t: f64` may come first){hint}"
        );
        return Err(syn::Error::new(name.span(), message));
    }
    let arguments = &arguments[usize::from(is_timed)..];
    // the velocity of a rotation must not have the name of the velocity of a vector
    let places: Vec<&str> = role
        .quantities()
        .iter()
        .flat_map(|&quantity| {
            &PARTS[QUANTITIES.iter().position(|q| q.0 == quantity).unwrap_or(1)][2 - parts..]
        })
        .copied()
        .collect();
    for ((pattern, _), place) in arguments.iter().zip(places) {
        let Pat::Ident(ident) = pattern else { continue };
        let found = ident.ident.to_string();
        let is_known = PARTS.as_flattened().contains(&found.as_str());
        if is_known && found != place {
            let message = format!(
                "`{found}` stands in the place of `{place}`, the {}: arguments are told apart by their order, not by their names; \
                 write `{expected}`, or call this argument otherwise",
                meaning_with_rotations(place),
            );
            return Err(syn::Error::new(ident.ident.span(), message));
        }
    }
    Ok(is_timed)
}

/// Names of the arguments of a vector and of a rotation, in the order of [`QUANTITIES`].
const PARTS: [[&str; 2]; 4] = [["t", "t"], ["q", "r"], ["v", "w"], ["p", "pi"]];

/// Returns the meaning of a name in a system with rotations.
fn meaning_with_rotations(name: &str) -> &'static str {
    match name {
        "r" => "rotation",
        "w" => "angular velocity in the body frame",
        "pi" => "angular momentum in the body frame",
        other => meaning(other).unwrap_or_default(),
    }
}

/// Returns the error of a second argument of a function that takes the position only.
fn depends_on_more(role: Role, arguments: &[(Pat, Type)], expected: &str) -> syn::Error {
    let hint = match role {
        Role::Gamma => "; a noise that depends on the momentum is `#[h1]`",
        _ => "",
    };
    let message = format!(
        "`#[{}]` depends on q alone: {expected}{hint}",
        role.attribute()
    );
    syn::Error::new(arguments[1].0.span(), message)
}

/// Returns whether an argument has the name of a velocity or a momentum. Then the argument before
/// it is not the time.
fn is_momentum(pattern: &Pat) -> bool {
    let Pat::Ident(name) = pattern else {
        return false;
    };
    matches!(name.ident.to_string().trim_start_matches('_'), "v" | "p")
}

/// Checks that each argument called `t`, `q`, `v` or `p` stands in the place of this quantity.
/// Reports the first one that does not.
fn check_order(
    name: &Ident,
    role: Role,
    timed: bool,
    arguments: &[(Pat, Type)],
) -> syn::Result<()> {
    let order: Vec<&str> = timed
        .then_some("t")
        .into_iter()
        .chain(role.quantities().iter().copied())
        .collect();
    for ((pattern, _), &place) in arguments.iter().zip(&order) {
        let Pat::Ident(ident) = pattern else { continue };
        let found = ident.ident.to_string();
        if found == place || meaning(&found).is_none() {
            continue;
        }
        let message = format!(
            "`{found}` stands in the place of the {}: arguments are told apart by their order, not by their names; \
             write `{}`, or call this argument otherwise if it is the {}",
            meaning(place).unwrap_or_default(),
            in_order(name, role, timed, arguments),
            meaning(place).unwrap_or_default(),
        );
        return Err(syn::Error::new(ident.ident.span(), message));
    }
    Ok(())
}

/// Returns the meaning of a name of the documentation; `None` for other names.
fn meaning(name: &str) -> Option<&'static str> {
    QUANTITIES
        .iter()
        .find(|quantity| quantity.0 == name)
        .map(|quantity| quantity.1)
}

/// Returns the head of the function with its arguments in the right order. The types are the
/// user's.
fn in_order(name: &Ident, role: Role, timed: bool, arguments: &[(Pat, Type)]) -> String {
    let is_time = |pattern: &Pat| matches!(pattern, Pat::Ident(ident) if ident.ident == "t");
    // in a vector system only the time is a number
    let vector = arguments
        .iter()
        .map(|argument| &argument.1)
        .find(|ty| !is_f64(ty))
        .map_or_else(|| "f64".to_owned(), readable);
    let timed = timed || arguments.iter().any(|argument| is_time(&argument.0));
    let time = if timed { "t: f64, " } else { "" };
    let vectors: Vec<String> = role
        .quantities()
        .iter()
        .map(|quantity| format!("{quantity}: {vector}"))
        .collect();
    format!("fn {name}(&self, {time}{})", vectors.join(", "))
}

#[cfg(test)]
mod tests {
    use proc_macro2::TokenStream;

    use crate::errors::Errors;
    use crate::syntax::parse;

    /// A role: its attribute, the name of a function, the arguments in order, and the result of
    /// such a function.
    const ROLES: [(&str, &str, &[&str], &str); 6] = [
        ("", "lagrangian", &["q", "v"], "{ x * x + y * y }"),
        ("#[gamma]", "push", &["q"], "{ x }"),
        ("#[h1]", "kick", &["q", "p"], "{ y }"),
        ("#[force]", "drag", &["q", "v"], "{ -y }"),
        ("#[symmetry]", "shift", &["q"], "{ 1.0 }"),
        ("#[constraint]", "rod", &["q"], "{ x }"),
    ];

    /// Returns the errors of a block in which one function has arguments with these names.
    fn errors(role: usize, names: &[&str]) -> Vec<String> {
        let (attribute, function, order, _) = ROLES[role];
        let list: Vec<String> = names.iter().map(|name| format!("{name}: f64")).collect();
        let last = names.last().copied().unwrap_or_default();
        let value = match order.len() {
            2 => format!("{last} * {last}"),
            _ if attribute == "#[symmetry]" => "1.0".to_owned(),
            _ => last.to_owned(),
        };
        let mut block = format!(
            "{attribute} fn {function}(&self, {}) -> f64 {{ {value} }}",
            list.join(", ")
        );
        if role != 0 {
            block.push_str("fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v }");
        }
        let tokens = |text: &str| -> TokenStream { text.parse().expect("tokens") };
        let item = syn::parse2(tokens(&format!("impl P {{ {block} }}"))).expect("a block");
        let mut errors = Errors::new();
        let read = parse::annotated(tokens("midpoint"), item, &mut errors);
        match errors.finish(read) {
            Ok(_) => Vec::new(),
            Err(all) => all.into_iter().map(|error| error.to_string()).collect(),
        }
    }

    /// Returns all lists of `length` different names.
    fn lists<'a>(names: &[&'a str], length: usize) -> Vec<Vec<&'a str>> {
        let mut lists = vec![Vec::new()];
        for _ in 0..length {
            let longer = |list: Vec<&'a str>| {
                let more = names.iter().filter(|&name| !list.contains(name));
                more.map(|&name| [list.as_slice(), &[name]].concat())
                    .collect::<Vec<_>>()
            };
            lists = lists.into_iter().flat_map(longer).collect();
        }
        lists
    }

    /// Tests every choice of the four names for every role, with and without time: only the order
    /// of the documentation is accepted.
    #[test]
    fn a_quantity_in_the_place_of_another_is_refused() {
        for (role, (attribute, function, order, _)) in ROLES.iter().enumerate() {
            let timed: Vec<&str> = ["t"].iter().chain(*order).copied().collect();
            for right in [order.to_vec(), timed] {
                for names in lists(&["t", "q", "v", "p"], right.len()) {
                    let found = errors(role, &names);
                    if names == right {
                        // a generator or a drift may still be refused because of its values
                        let read = found.iter().all(|error| !error.contains("in the place of"));
                        assert!(read, "{attribute} {names:?}: {found:?}");
                        continue;
                    }
                    assert_eq!(found.len(), 1, "{attribute} {names:?}: {found:?}");
                    let says_order = found[0].contains(&format!("fn {function}(&self, "))
                        && found[0].contains("in the place of")
                        || found[0].contains("depends on q alone");
                    assert!(says_order, "{attribute} {names:?}: {found:?}");
                }
            }
        }
    }

    /// The lists contain any two of these names in any two places, since 11 is a prime number.
    #[test]
    fn other_names_say_nothing() {
        let names = [
            "theta", "pos", "q_dot", "_q", "_t", "time", "Q", "qv", "p0", "x", "h",
        ];
        for (role, (attribute, _, order, _)) in ROLES.iter().enumerate() {
            for length in [order.len(), order.len() + 1] {
                for (first, stride) in (0..11).flat_map(|first| (1..11).map(move |k| (first, k))) {
                    let list = (0..length).map(|at| names[(first + at * stride) % 11]);
                    let list: Vec<&str> = list.collect();
                    let found = errors(role, &list);
                    let silent = found.iter().all(|e| !e.contains("in the place of"));
                    assert!(silent, "{attribute} {list:?}: {found:?}");
                }
            }
        }
    }
}
