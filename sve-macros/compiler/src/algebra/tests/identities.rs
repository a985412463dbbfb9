//! Identities that vanish, similar expressions that do not, and equal expressions that have equal
//! names.

use crate::algebra::{Arena, Binary, Expr, Function, Symbol};

/// A small language for identities.
struct Write(Arena);

impl Write {
    fn new() -> (Self, Expr, Expr) {
        let mut arena = Arena::new();
        let [x, y] = [0, 1].map(|i| arena.symbol(Symbol(i)));
        (Self(arena), x, y)
    }

    fn call(&mut self, f: Function, x: Expr) -> Expr {
        self.0.call(f, x)
    }

    fn square(&mut self, f: Function, x: Expr) -> Expr {
        let value = self.0.call(f, x);
        self.0.pow(value, 2)
    }
}

#[test]
fn known_identities_are_zero() {
    let (mut w, x, y) = Write::new();
    let (s, c) = (w.square(Function::Sin, x), w.square(Function::Cos, x));
    let pythagoras = w.0.sum(-1.0, &[(1.0, s), (1.0, c)]);
    let (s, c) = (w.square(Function::Sinh, x), w.square(Function::Cosh, x));
    let hyperbola = w.0.sum(-1.0, &[(1.0, c), (-1.0, s)]);
    let sum = w.0.add(x, y);
    let (xx, xy, yy, whole) = (w.0.pow(x, 2), w.0.mul(x, y), w.0.pow(y, 2), w.0.pow(sum, 2));
    let binomial =
        w.0.sum(0.0, &[(1.0, whole), (-1.0, xx), (-2.0, xy), (-1.0, yy)]);
    let (ex, ey, exy) = (
        w.call(Function::Exp, x),
        w.call(Function::Exp, y),
        w.call(Function::Exp, sum),
    );
    let product = w.0.mul(ex, ey);
    let exponential = w.0.sub(exy, product);
    let double = w.0.scale(2.0, x);
    let s2 = w.call(Function::Sin, double);
    let (s, c) = (w.call(Function::Sin, x), w.call(Function::Cos, x));
    let sc = w.0.mul(s, c);
    let angle = w.0.sum(0.0, &[(1.0, s2), (-2.0, sc)]);
    let root = w.call(Function::Sqrt, xx);
    let squared = w.0.pow(root, 2);
    let modulus = w.0.sub(squared, xx);
    for (name, zero) in [
        ("sin² + cos² − 1", pythagoras),
        ("cosh² − sinh² − 1", hyperbola),
        ("(x+y)² − x² − 2xy − y²", binomial),
        ("exp(x+y) − exp x exp y", exponential),
        ("sin 2x − 2 sin x cos x", angle),
        ("√(x²)² − x²", modulus),
    ] {
        assert!(w.0.is_zero(zero), "{name}");
    }
}

#[test]
fn near_identities_are_not_zero() {
    let (mut w, x, y) = Write::new();
    let s = w.call(Function::Sin, x);
    let sine = w.0.sub(s, x);
    let small = w.0.scale(1e-9, x);
    let tiny = w.0.scale(1e-300, x);
    let xx = w.0.pow(x, 2);
    let root = w.call(Function::Sqrt, xx);
    let modulus = w.0.sub(root, x);
    let (s, c) = (w.square(Function::Sin, x), w.square(Function::Cos, x));
    let shifted = w.0.sum(-1.0 + 1e-12, &[(1.0, s), (1.0, c)]);
    let difference = w.0.sub(x, y);
    let power = w.0.pow(difference, 12);
    let logarithm = w.call(Function::Ln, x);
    for (name, expr) in [
        ("sin x − x", sine),
        ("1e-9 x", small),
        ("1e-300 x", tiny),
        ("√(x²) − x", modulus),
        ("sin² + cos² − 1 + 1e-12", shifted),
        ("(x − y)¹²", power),
        ("ln x", logarithm),
    ] {
        assert!(!w.0.is_zero(expr), "{name}");
    }
}

#[test]
fn equal_expressions_have_equal_names() {
    let (mut w, x, y) = Write::new();
    let arena = &mut w.0;
    assert_eq!(arena.add(x, y), arena.add(y, x));
    assert_eq!(arena.mul(x, y), arena.mul(y, x));
    let (xy, yx) = (arena.sub(x, y), arena.sub(y, x));
    assert_eq!(arena.pow(xy, 2), arena.pow(yx, 2));
    assert_eq!(arena.call(Function::Cos, xy), arena.call(Function::Cos, yx));
    let zero = arena.constant(0.0);
    let one = arena.constant(1.0);
    assert_eq!(arena.sub(x, x), zero);
    assert_eq!(arena.div(x, x), one);
    assert_eq!(arena.constant(-0.0), zero);
    assert_eq!(arena.mul(x, zero), zero);
    assert_eq!(arena.mul(x, one), x);
    assert_eq!(arena.pow(x, 0), one);
}

#[test]
fn exponents_do_not_overflow() {
    let (mut w, x, _) = Write::new();
    let mut power = x;
    for _ in 0..8 {
        power = w.0.pow(power, 1000);
        power = w.0.mul(power, power);
    }
    assert_eq!(w.0.evaluate(power, |_| 1.0), 1.0);
    let derivative = w.0.diff(power, Symbol(0));
    assert!(w.0.evaluate(derivative, |_| 1.0) > 1e20);
}

/// A power of the literal zero has a derivative in its exponent, which is zero.
#[test]
fn powers_of_zero() {
    let mut arena = Arena::new();
    let (zero, x) = (arena.constant(0.0), arena.symbol(Symbol(0)));
    let power = arena.call2(Binary::Pow, zero, x);
    let derivative = arena.diff(power, Symbol(0));
    assert_eq!(arena.evaluate(power, |_| 1.5), 0.0);
    assert_eq!(arena.evaluate(derivative, |_| 1.5), 0.0);
}
