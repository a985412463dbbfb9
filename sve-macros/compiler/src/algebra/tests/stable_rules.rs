//! The stable forms, each with its plain expression and its exact value.

use crate::algebra::elementary::{self as exact, Double, of, square};
use crate::algebra::{Arena, Binary, Expr, Function};

/// An expression in x and y with its value.
pub(super) struct Rule {
    pub(super) name: &'static str,
    /// `f` and `value` of a difference `f − value`. If `value` is 0, `f` is the whole expression.
    pub(super) plain: fn(&mut Arena, Expr, Expr) -> (Expr, f64),
    pub(super) exact: fn(Double, Double) -> Double,
    /// Points next to which the plain expression cancels.
    pub(super) cancels: &'static [(f64, f64)],
}

pub(super) fn call(arena: &mut Arena, function: Function, x: Expr, k: i32) -> Expr {
    let value = arena.call(function, x);
    arena.pow(value, k)
}

/// Returns `√(u² + xy)`.
pub(super) fn root(arena: &mut Arena, u: f64, x: Expr, y: Expr) -> Expr {
    let product = arena.mul(x, y);
    let radicand = arena.sum(u * u, &[(1.0, product)]);
    arena.call(Function::Sqrt, radicand)
}

pub(super) fn exact_root(u: f64, x: Double, y: Double) -> Double {
    exact::sqrt(of(u * u) + x * y)
}

pub(super) fn leg(arena: &mut Arena, x: Expr, y: Expr) -> Expr {
    let hypot = arena.call2(Binary::Hypot, x, y);
    arena.product(&[(x, 2), (hypot, -2)])
}

pub(super) const ONE: Double = Double::ONE;
const ZERO: &[(f64, f64)] = &[(0.0, 1.0)];

/// Every row of the table in `stable`.
pub(super) const RULES: &[Rule] = &[
    Rule {
        name: "cos x − 1",
        plain: |a, x, _| (call(a, Function::Cos, x, 1), 1.0),
        exact: |x, _| of(-2.0) * square(exact::sin(of(0.5) * x)),
        cancels: ZERO,
    },
    Rule {
        name: "cos² x − 1",
        plain: |a, x, _| (call(a, Function::Cos, x, 2), 1.0),
        exact: |x, _| -square(exact::sin(x)),
        cancels: ZERO,
    },
    Rule {
        name: "sin² x − 1",
        plain: |a, x, _| (call(a, Function::Sin, x, 2), 1.0),
        exact: |x, _| -square(exact::cos(x)),
        cancels: &[(std::f64::consts::FRAC_PI_2, 1.0)],
    },
    Rule {
        name: "cosh x − 1",
        plain: |a, x, _| (call(a, Function::Cosh, x, 1), 1.0),
        exact: |x, _| of(2.0) * square(exact::sinh(of(0.5) * x)),
        cancels: ZERO,
    },
    Rule {
        name: "cosh² x − 1",
        plain: |a, x, _| (call(a, Function::Cosh, x, 2), 1.0),
        exact: |x, _| square(exact::sinh(x)),
        cancels: ZERO,
    },
    Rule {
        name: "tanh² x − 1",
        plain: |a, x, _| (call(a, Function::Tanh, x, 2), 1.0),
        exact: |x, _| -ONE / square(exact::cosh(x)),
        cancels: &[(16.0, 1.0)],
    },
    Rule {
        name: "sinh² x / cosh² x − 1",
        plain: |a, x, _| {
            let (s, c) = (
                call(a, Function::Sinh, x, 2),
                call(a, Function::Cosh, x, -2),
            );
            (a.mul(s, c), 1.0)
        },
        exact: |x, _| -ONE / square(exact::cosh(x)),
        cancels: &[(16.0, 1.0)],
    },
    Rule {
        name: "exp x − 1",
        plain: |a, x, _| (call(a, Function::Exp, x, 1), 1.0),
        exact: |x, _| exact::exp_m1(x),
        cancels: ZERO,
    },
    Rule {
        name: "exp(x)² − 1",
        plain: |a, x, _| (call(a, Function::Exp, x, 2), 1.0),
        exact: |x, _| exact::exp_m1(of(2.0) * x),
        cancels: ZERO,
    },
    Rule {
        name: "1/exp x − 1",
        plain: |a, x, _| (call(a, Function::Exp, x, -1), 1.0),
        exact: |x, _| exact::exp_m1(-x),
        cancels: ZERO,
    },
    Rule {
        name: "√(1 + xy) − 1",
        plain: |a, x, y| (root(a, 1.0, x, y), 1.0),
        exact: |x, y| x * y / (exact_root(1.0, x, y) + ONE),
        cancels: ZERO,
    },
    Rule {
        name: "√(4 + xy) − 2",
        plain: |a, x, y| (root(a, 2.0, x, y), 2.0),
        exact: |x, y| x * y / (exact_root(2.0, x, y) + of(2.0)),
        cancels: ZERO,
    },
    Rule {
        name: "1/√(1 + xy) − 1",
        plain: |a, x, y| {
            let root = root(a, 1.0, x, y);
            (a.pow(root, -1), 1.0)
        },
        exact: |x, y| {
            let root = exact_root(1.0, x, y);
            -(x * y) / (root + ONE) / root
        },
        cancels: ZERO,
    },
    Rule {
        name: "x² / hypot(x, y)² − 1",
        plain: |a, x, y| (leg(a, x, y), 1.0),
        exact: |x, y| -square(y) / (square(x) + square(y)),
        cancels: &[(1.5, 0.0)],
    },
    Rule {
        name: "y² / hypot(x, y)² − 1",
        plain: |a, x, y| (leg(a, y, x), 1.0),
        exact: |y, x| -square(y) / (square(x) + square(y)),
        cancels: ZERO,
    },
    Rule {
        name: "x² / hypot(−2x, y)² − ¼",
        plain: |a, x, y| {
            let scaled = a.scale(-2.0, x);
            let hypot = a.call2(Binary::Hypot, scaled, y);
            (a.product(&[(x, 2), (hypot, -2)]), 0.25)
        },
        exact: |x, y| of(-0.25) * square(y) / (square(of(2.0) * x) + square(y)),
        cancels: &[(1.5, 0.0)],
    },
    Rule {
        name: "x y / hypot(−2x, y)²",
        plain: |a, x, y| {
            let scaled = a.scale(-2.0, x);
            let hypot = a.call2(Binary::Hypot, scaled, y);
            (a.product(&[(x, 1), (y, 1), (hypot, -2)]), 0.0)
        },
        exact: |x, y| x * y / (square(of(2.0) * x) + square(y)),
        cancels: &[],
    },
    Rule {
        name: "ln(1 + x)",
        plain: |a, x, _| {
            let y = a.sum(1.0, &[(1.0, x)]);
            (call(a, Function::Ln, y, 1), 0.0)
        },
        exact: |x, _| exact::ln_1p(x),
        cancels: ZERO,
    },
    Rule {
        name: "ln(1 − x²)",
        plain: |a, x, _| {
            let square = a.pow(x, 2);
            let y = a.sum(1.0, &[(-1.0, square)]);
            (call(a, Function::Ln, y, 1), 0.0)
        },
        exact: |x, _| exact::ln_1p(-square(x)),
        cancels: ZERO,
    },
    Rule {
        name: "ln cosh x",
        plain: |a, x, _| {
            let cosh = a.call(Function::Cosh, x);
            (call(a, Function::Ln, cosh, 1), 0.0)
        },
        exact: |x, _| exact::ln_1p(of(2.0) * square(exact::sinh(of(0.5) * x))),
        cancels: ZERO,
    },
    Rule {
        name: "1 − x²",
        plain: |a, x, _| {
            let square = a.pow(x, 2);
            (a.sum(1.0, &[(-1.0, square)]), 0.0)
        },
        exact: |x, _| (ONE - x) * (ONE + x),
        cancels: &[(1.0, 1.0), (-1.0, 1.0)],
    },
    Rule {
        name: "sinh x / cosh x",
        plain: |a, x, _| {
            let (s, c) = (
                call(a, Function::Sinh, x, 1),
                call(a, Function::Cosh, x, -1),
            );
            (a.mul(s, c), 0.0)
        },
        exact: |x, _| exact::sinh(x) / exact::cosh(x),
        cancels: &[],
    },
    Rule {
        name: "x y / hypot(x, y)²",
        plain: |a, x, y| {
            let hypot = a.call2(Binary::Hypot, x, y);
            (a.product(&[(x, 1), (y, 1), (hypot, -2)]), 0.0)
        },
        exact: |x, y| x * y / (square(x) + square(y)),
        cancels: &[],
    },
];
