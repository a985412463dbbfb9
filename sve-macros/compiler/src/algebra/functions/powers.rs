//! Roots, powers with constant exponents, and the magnitude.

use super::super::elementary;
use super::{Bound, Domain, Entry, Notation, Parity, Sign, Stable, everywhere};

pub(super) static SQRT: Entry = Entry {
    name: "sqrt",
    value: |x, _| x.sqrt(),
    double: |x, _| elementary::sqrt(x),
    slope: |_, value, _| 0.5 / value,
    derivative: |arena, _, value, _| {
        let inverse = arena.pow(value, -1);
        arena.scale(0.5, inverse)
    },
    parity: Parity::None,
    sign: Sign::NonNegative,
    domain: |_| Domain::From {
        least: 0.0,
        is_closed: true,
    },
    bound: Bound::Root,
    notation: Notation::Radical("√"),
    stable: Stable::NONE,
    letter: 'r',
    is_instruction: true,
};

pub(super) static CBRT: Entry = Entry {
    name: "cbrt",
    value: |x, _| x.cbrt(),
    double: |x, _| elementary::cbrt(x),
    slope: |x, value, _| value / (3.0 * x),
    derivative: |arena, _, value, _| {
        let inverse = arena.pow(value, -2);
        arena.scale(1.0 / 3.0, inverse)
    },
    parity: Parity::Odd,
    sign: Sign::Unknown,
    domain: everywhere,
    bound: Bound::CubeRoot,
    notation: Notation::Radical("∛"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static POWF: Entry = Entry {
    name: "powf",
    value: f64::powf,
    double: |x, k| elementary::pow(x, elementary::of(k)),
    slope: |x, value, k| k * value / x,
    derivative: |arena, x, _, k| {
        let lower = arena.constant_power(x, k - 1.0);
        arena.scale(k, lower)
    },
    parity: Parity::None,
    sign: Sign::Unknown,
    domain: |k| Domain::From {
        least: 0.0,
        is_closed: k > 0.0,
    },
    bound: Bound::Power,
    notation: Notation::Power,
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static ABS: Entry = Entry {
    name: "abs",
    value: |x, _| x.abs(),
    double: |x, _| x.abs(),
    slope: |_, _, _| 1.0,
    derivative: // the sign, which is NaN at 0
    |arena, x, value, _| arena.div(x, value),
    parity: Parity::Even,
    sign: Sign::NonNegative,
    domain: everywhere,
    bound: Bound::Slope,
    notation: Notation::Name("abs"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};
