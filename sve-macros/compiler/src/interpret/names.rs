//! Names of coordinates and momenta, taken from the source of L.
//!
//! Input: the arguments of L for its configuration, their shapes, and the body. Output: a name for
//! each number that a state stores. `q: [f64; 2]` has `q[0]` and `q[1]`, a vector `q.x` and so on,
//! a rotation the components of its quaternion, `r.w` to `r.k`. If the argument or a `let` at the
//! top of the body destructures the coordinates, `let [x, y] = q`, the names come from this
//! pattern.

use std::collections::HashSet;

use syn::{Expr as Syntax, Pat, Stmt};

use super::matrices::{COMPONENTS, Kind};
use super::types::Shape;
use crate::model::CoordinateNames;
use crate::syntax::parse::RoleFunction;

/// Names of columns other than coordinates.
const TAKEN: [&str; 2] = ["t", "path"];

/// Returns the names of the numbers of a state. `has_configuration` says whether states store the
/// configuration.
pub(super) fn names(
    lagrangian: &RoleFunction,
    shapes: &[Shape],
    has_configuration: bool,
) -> CoordinateNames {
    let patterns = &lagrangian.arguments[usize::from(lagrangian.is_timed)..];
    let of = |takes_apart: bool| {
        let mut names = CoordinateNames::default();
        for ((pattern, _), shape) in patterns.iter().zip(shapes) {
            let pattern = inner(pattern, lagrangian, takes_apart);
            add(pattern, shape, &mut names);
        }
        if !has_configuration {
            names.configuration.clear();
        }
        names
    };
    let names = of(true);
    if are_distinct(&names) {
        names
    } else {
        of(false)
    }
}

/// Returns the pattern that destructures an argument, if there is one.
fn inner<'a>(pattern: &'a Pat, function: &'a RoleFunction, takes_apart: bool) -> Option<&'a Pat> {
    let Pat::Ident(argument) = pattern else {
        return takes_apart.then_some(pattern);
    };
    let taken_apart = function.item.block.stmts.iter().find_map(|statement| {
        let Stmt::Local(local) = statement else {
            return None;
        };
        match &*local.init.as_ref()?.expr {
            Syntax::Path(path) if path.path.is_ident(&argument.ident) => match &local.pat {
                Pat::Type(typed) => Some(&*typed.pat),
                other => Some(other),
            },
            _ => None,
        }
    });
    taken_apart.filter(|_| takes_apart).or(Some(pattern))
}

/// Adds the names of an argument.
fn add(pattern: Option<&Pat>, shape: &Shape, names: &mut CoordinateNames) {
    let mut leaves = Vec::new();
    if !pattern.is_some_and(|pattern| collect(pattern, shape, &mut leaves)) {
        let name = if shape.has_rotations() { "r" } else { "q" };
        leaves = vec![(name.to_owned(), shape.clone())];
    }
    for (name, shape) in leaves {
        let momentum = match name.as_str() {
            "q" => "p".to_owned(),
            "r" => "pi".to_owned(),
            other => format!("p_{other}"),
        };
        entries(&name, &shape, &mut names.configuration);
        entries(&momentum, &shape.velocity(), &mut names.momenta);
    }
}

/// Collects the variables of a pattern with their shapes. Returns whether the pattern names every
/// entry.
fn collect(pattern: &Pat, shape: &Shape, leaves: &mut Vec<(String, Shape)>) -> bool {
    match (pattern, shape) {
        (Pat::Ident(variable), _) if variable.subpat.is_none() => {
            let name = variable.ident.to_string();
            let name = name
                .trim_start_matches("r#")
                .trim_start_matches('_')
                .to_owned();
            let is_name = !name.is_empty();
            leaves.push((name, shape.clone()));
            is_name
        }
        (Pat::Slice(slice), Shape::Array(n, inner)) if slice.elems.len() == *n => slice
            .elems
            .iter()
            .all(|element| collect(element, inner, leaves)),
        _ => false,
    }
}

/// Adds the names of the entries of a variable.
pub(super) fn entries(name: &str, shape: &Shape, to: &mut Vec<String>) {
    let components = |of: &[&str]| of.iter().map(|c| format!("{name}.{c}")).collect::<Vec<_>>();
    match shape {
        Shape::Scalar => to.push(name.to_owned()),
        Shape::Vector(ty) if ty.kind == Kind::Rotation => {
            to.extend(components(&["w", "i", "j", "k"]));
        }
        Shape::Vector(ty) if ty.len() <= COMPONENTS.len() => {
            to.extend(components(&COMPONENTS[..ty.len()]));
        }
        Shape::Vector(ty) => to.extend((0..ty.len()).map(|i| format!("{name}[{i}]"))),
        Shape::Array(n, inner) => {
            (0..*n).for_each(|i| entries(&format!("{name}[{i}]"), inner, to));
        }
    }
}

/// Returns whether all names differ, also from those of other columns.
fn are_distinct(names: &CoordinateNames) -> bool {
    let mut seen: HashSet<&str> = TAKEN.into();
    let mut all = names.configuration.iter().chain(&names.momenta);
    all.all(|name| seen.insert(name))
}
