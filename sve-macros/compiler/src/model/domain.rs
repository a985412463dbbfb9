//! The domain of the functions in L and in the noises.
//!
//! Input: expressions. Output: for each function in them that is not defined everywhere, an
//! expression that must be positive, or nonnegative, with its text. Invariant: an expression that
//! is nonnegative by its form (a sum of squares under a root) is not listed, so a step does not
//! compute it.

use crate::algebra::{Arena, Domain, Expr, Node, Sign};

/// A condition under which a function is defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Condition<T> {
    /// The expression that must be positive.
    pub(crate) value: T,
    /// True if 0 is allowed too.
    pub(crate) is_closed: bool,
    /// The same expression as it occurs in the action, for messages.
    pub(crate) text: Expr,
}

/// Returns the conditions of all functions in these expressions.
pub(crate) fn conditions(roots: &[Expr], arena: &mut Arena) -> Vec<Condition<Expr>> {
    let mut found: Vec<Condition<Expr>> = Vec::new();
    for call in arena.reachable(roots, |_| true) {
        let Some((value, is_closed)) = condition(call, arena) else {
            continue;
        };
        let sign = sign(value, arena);
        let holds = sign == Sign::Positive || (is_closed && sign == Sign::NonNegative);
        if !holds
            && found
                .iter()
                .all(|c| (c.value, c.is_closed) != (value, is_closed))
        {
            found.push(Condition {
                value,
                is_closed,
                text: value,
            });
        }
    }
    found
}

/// Returns the expression that must be positive for a call to be defined, and whether 0 is allowed.
fn condition(call: Expr, arena: &mut Arena) -> Option<(Expr, bool)> {
    match *arena.node(call) {
        Node::Call(function, x) => match function.domain() {
            Domain::Everywhere => None,
            Domain::From { least, is_closed } => {
                let distance = arena.sum(0.0 - least, &[(1.0, x)]);
                Some((distance, is_closed))
            }
            Domain::WithinOne { is_closed } => {
                let square = arena.pow(x, 2);
                Some((arena.sum(1.0, &[(-1.0, square)]), is_closed))
            }
        },
        Node::Call2(function, x, _) if function.entry().needs_nonnegative => Some((x, true)),
        _ => None,
    }
}

fn sign_of_number(x: f64) -> Sign {
    if x > 0.0 {
        Sign::Positive
    } else if x == 0.0 {
        Sign::NonNegative
    } else {
        Sign::Unknown
    }
}

/// Returns the sign of an expression, as far as its form shows it.
fn sign(expr: Expr, arena: &Arena) -> Sign {
    let mut signs: std::collections::HashMap<Expr, Sign> = std::collections::HashMap::new();
    for e in arena.reachable(&[expr], |_| true) {
        let of = |x: &Expr| signs[x];
        let sign = match arena.node(e) {
            Node::Constant(bits) => sign_of_number(bits.get()),
            Node::Symbol(_) | Node::Call2(..) => Sign::Unknown,
            Node::Opaque(x, _) => of(x),
            Node::Sum(constant, terms) => {
                let mut parts: Vec<Sign> = terms
                    .iter()
                    .map(|(x, c)| if c.get() > 0.0 { of(x) } else { Sign::Unknown })
                    .collect();
                parts.push(sign_of_number(constant.get()));
                if parts.contains(&Sign::Unknown) {
                    Sign::Unknown
                } else if parts.contains(&Sign::Positive) {
                    Sign::Positive
                } else {
                    Sign::NonNegative
                }
            }
            Node::Product(factors) => factors.iter().fold(Sign::Positive, |all, (x, k)| {
                let of_factor = match of(x) {
                    Sign::Unknown if k % 2 == 0 => Sign::NonNegative,
                    other => other,
                };
                match (all, of_factor) {
                    (Sign::Unknown, _) | (_, Sign::Unknown) => Sign::Unknown,
                    (Sign::Positive, Sign::Positive) => Sign::Positive,
                    _ => Sign::NonNegative,
                }
            }),
            Node::Call(function, _) => function.entry().sign,
        };
        signs.insert(e, sign);
    }
    // at the limit of work nothing is reachable
    signs.get(&expr).copied().unwrap_or(Sign::Unknown)
}
