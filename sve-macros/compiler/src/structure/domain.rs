//! Where the functions in L and in the noises are defined.
//!
//! Input: expressions. Output: for each function in them that is not defined everywhere, an expression that has to be
//! positive, or not negative, with its text. Invariant: what cannot be negative by its form (a sum of squares under a root) is not
//! listed, so that a step does not compute it.

use crate::algebra::{Arena, Binary, Expr, Function, Node};

/// A condition on where a function is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Condition<T> {
    /// What has to be positive.
    pub(crate) value: T,
    /// Whether 0 is allowed too.
    pub(crate) is_closed: bool,
    /// The same as it stands in the action, for messages.
    pub(crate) text: Expr,
}

/// The conditions of all functions in these expressions.
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

/// What has to be positive where a function is called, and whether 0 is allowed.
fn condition(call: Expr, arena: &mut Arena) -> Option<(Expr, bool)> {
    match *arena.node(call) {
        Node::Call(function, x) => match function {
            Function::Sqrt => Some((x, true)),
            Function::Powf(k) => Some((x, k.get() > 0.0)),
            Function::Ln | Function::Log2 | Function::Log10 => Some((x, false)),
            Function::Ln1p => Some((arena.sum(1.0, &[(1.0, x)]), false)),
            Function::Acosh => Some((arena.sum(-1.0, &[(1.0, x)]), true)),
            Function::Asin | Function::Acos | Function::Atanh => {
                let square = arena.pow(x, 2);
                let left = arena.sum(1.0, &[(-1.0, square)]);
                Some((left, function != Function::Atanh))
            }
            Function::Cbrt
            | Function::Exp
            | Function::Exp2
            | Function::ExpM1
            | Function::Sin
            | Function::Cos
            | Function::Tan
            | Function::Atan
            | Function::Sinh
            | Function::Cosh
            | Function::Tanh
            | Function::Asinh
            | Function::Abs => None,
        },
        Node::Call2(Binary::Pow, x, _) => Some((x, true)),
        _ => None,
    }
}

/// What is known of the sign of an expression from its form.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sign {
    Positive,
    NonNegative,
    Unknown,
}

impl Sign {
    fn of_number(x: f64) -> Self {
        if x > 0.0 {
            Self::Positive
        } else if x == 0.0 {
            Self::NonNegative
        } else {
            Self::Unknown
        }
    }
}

fn sign(expr: Expr, arena: &Arena) -> Sign {
    let mut signs: std::collections::HashMap<Expr, Sign> = std::collections::HashMap::new();
    for e in arena.reachable(&[expr], |_| true) {
        let of = |x: &Expr| signs[x];
        let sign = match arena.node(e) {
            Node::Constant(bits) => Sign::of_number(bits.get()),
            Node::Symbol(_) | Node::Call2(..) => Sign::Unknown,
            Node::Opaque(x, _) => of(x),
            Node::Sum(constant, terms) => {
                let mut parts: Vec<Sign> = terms
                    .iter()
                    .map(|(x, c)| if c.get() > 0.0 { of(x) } else { Sign::Unknown })
                    .collect();
                parts.push(Sign::of_number(constant.get()));
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
            Node::Call(function, _) => match function {
                Function::Exp | Function::Exp2 | Function::Cosh => Sign::Positive,
                Function::Sqrt | Function::Acosh | Function::Abs | Function::Acos => {
                    Sign::NonNegative
                }
                _ => Sign::Unknown,
            },
        };
        signs.insert(e, sign);
    }
    signs[&expr]
}
