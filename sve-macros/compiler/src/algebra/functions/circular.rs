//! Circular functions and their inverses.

use super::super::elementary;
use super::{Bound, Entry, Form, Function, Notation, Parity, Sign, Stable, everywhere, within_one};

pub(super) static SIN: Entry = Entry {
    name: "sin",
    value: |x, _| x.sin(),
    double: |x, _| elementary::sin(x),
    slope: |x, _, _| x.cos(),
    derivative: |arena, x, _, _| arena.call(Function::Cos, x),
    parity: Parity::Odd,
    sign: Sign::Unknown,
    domain: everywhere,
    bound: Bound::Wave,
    notation: Notation::Name("sin"),
    stable: Stable {
        square_less_one: Some(Form {
            scale: -1.0,
            function: Function::Cos,
            factor: 1.0,
            power: 2,
            is_further_call: false,
        }),
        ..Stable::NONE
    },
    letter: 's',
    is_instruction: false,
};

pub(super) static COS: Entry = Entry {
    name: "cos",
    value: |x, _| x.cos(),
    double: |x, _| elementary::cos(x),
    slope: |x, _, _| x.sin(),
    derivative: |arena, x, _, _| {
        let sin = arena.call(Function::Sin, x);
        arena.neg(sin)
    },
    parity: Parity::Even,
    sign: Sign::Unknown,
    domain: everywhere,
    bound: Bound::Wave,
    notation: Notation::Name("cos"),
    stable: Stable {
        less_one: Some(Form {
            scale: -2.0,
            function: Function::Sin,
            factor: 0.5,
            power: 2,
            is_further_call: false,
        }),
        square_less_one: Some(Form {
            scale: -1.0,
            function: Function::Sin,
            factor: 1.0,
            power: 2,
            is_further_call: false,
        }),
        ..Stable::NONE
    },
    letter: 'c',
    is_instruction: false,
};

pub(super) static TAN: Entry = Entry {
    name: "tan",
    value: |x, _| x.tan(),
    double: |x, _| elementary::tan(x),
    slope: |_, value, _| 1.0 + value * value,
    derivative: |arena, _, value, _| {
        let square = arena.pow(value, 2);
        arena.sum(1.0, &[(1.0, square)])
    },
    parity: Parity::Odd,
    sign: Sign::Unknown,
    domain: everywhere,
    bound: Bound::None,
    notation: Notation::Name("tan"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static ASIN: Entry = Entry {
    name: "asin",
    value: |x, _| x.asin(),
    double: |x, _| elementary::asin(x),
    slope: |x, _, _| 1.0 / ((1.0 - x) * (1.0 + x)).sqrt(),
    derivative: |arena, x, _, _| {
        let y = arena.factored(1.0, -1.0, x);
        arena.inverse_root(y)
    },
    parity: Parity::Odd,
    sign: Sign::Unknown,
    domain: within_one,
    bound: Bound::Arc { is_root: true },
    notation: Notation::Name("asin"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static ACOS: Entry = Entry {
    name: "acos",
    value: |x, _| x.acos(),
    double: |x, _| elementary::acos(x),
    slope: |x, _, _| 1.0 / ((1.0 - x) * (1.0 + x)).sqrt(),
    derivative: |arena, x, _, _| {
        let y = arena.factored(1.0, -1.0, x);
        let asin = arena.inverse_root(y);
        arena.neg(asin)
    },
    parity: Parity::None,
    sign: Sign::NonNegative,
    domain: within_one,
    bound: Bound::Arc { is_root: true },
    notation: Notation::Name("acos"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static ATAN: Entry = Entry {
    name: "atan",
    value: |x, _| x.atan(),
    double: |x, _| elementary::atan(x),
    slope: |x, _, _| 1.0 / (1.0 + x * x),
    derivative: |arena, x, _, _| {
        let y = arena.one_and_square(x);
        arena.pow(y, -1)
    },
    parity: Parity::Odd,
    sign: Sign::Unknown,
    domain: everywhere,
    bound: Bound::Slope,
    notation: Notation::Name("atan"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};
