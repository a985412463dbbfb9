//! Hyperbolic functions and their inverses.

use super::super::elementary;
use super::{Bound, Domain, Entry, Form, Function, Notation, Parity, Sign, Stable, everywhere};

pub(super) static SINH: Entry = Entry {
    name: "sinh",
    value: |x, _| x.sinh(),
    double: |x, _| elementary::sinh(x),
    slope: |x, _, _| x.cosh(),
    derivative: |arena, x, _, _| arena.call(Function::Cosh, x),
    parity: Parity::Odd,
    sign: Sign::Unknown,
    domain: everywhere,
    bound: Bound::Growth {
        constant: 1.0,
        rate: 1.0,
    },
    notation: Notation::Name("sinh"),
    stable: Stable {
        quotient: Some((Function::Cosh, Function::Tanh)),
        ..Stable::NONE
    },
    letter: 'f',
    is_instruction: false,
};

pub(super) static COSH: Entry = Entry {
    name: "cosh",
    value: |x, _| x.cosh(),
    double: |x, _| elementary::cosh(x),
    slope: |x, _, _| x.sinh(),
    derivative: |arena, x, _, _| arena.call(Function::Sinh, x),
    parity: Parity::Even,
    sign: Sign::Positive,
    domain: everywhere,
    bound: Bound::Growth {
        constant: 0.0,
        rate: 1.0,
    },
    notation: Notation::Name("cosh"),
    stable: Stable {
        less_one: Some(Form {
            scale: 2.0,
            function: Function::Sinh,
            factor: 0.5,
            power: 2,
            is_further_call: true,
        }),
        square_less_one: Some(Form {
            scale: 1.0,
            function: Function::Sinh,
            factor: 1.0,
            power: 2,
            is_further_call: true,
        }),
        is_at_least_one: true,
        ..Stable::NONE
    },
    letter: 'f',
    is_instruction: false,
};

pub(super) static TANH: Entry = Entry {
    name: "tanh",
    value: |x, _| x.tanh(),
    double: |x, _| elementary::tanh(x),
    slope: |x, _, _| x.cosh().powi(-2),
    derivative: |arena, _, value, _| {
        let square = arena.pow(value, 2);
        arena.sum(1.0, &[(-1.0, square)])
    },
    parity: Parity::Odd,
    sign: Sign::Unknown,
    domain: everywhere,
    bound: Bound::Slope,
    notation: Notation::Name("tanh"),
    stable: Stable {
        square_less_one: Some(Form {
            scale: -1.0,
            function: Function::Cosh,
            factor: 1.0,
            power: -2,
            is_further_call: true,
        }),
        ..Stable::NONE
    },
    letter: 'f',
    is_instruction: false,
};

pub(super) static ASINH: Entry = Entry {
    name: "asinh",
    value: |x, _| x.asinh(),
    double: |x, _| elementary::asinh(x),
    slope: |x, _, _| 1.0 / x.hypot(1.0),
    derivative: |arena, x, _, _| {
        let y = arena.one_and_square(x);
        arena.inverse_root(y)
    },
    parity: Parity::Odd,
    sign: Sign::Unknown,
    domain: everywhere,
    bound: Bound::Slope,
    notation: Notation::Name("asinh"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static ACOSH: Entry = Entry {
    name: "acosh",
    value: |x, _| x.acosh(),
    double: |x, _| elementary::acosh(x),
    slope: |x, _, _| 1.0 / ((x - 1.0) * (x + 1.0)).sqrt(),
    derivative: |arena, x, _, _| {
        let y = arena.factored(-1.0, 1.0, x);
        arena.inverse_root(y)
    },
    parity: Parity::None,
    sign: Sign::NonNegative,
    domain: |_| Domain::From {
        least: 1.0,
        is_closed: true,
    },
    bound: Bound::None,
    notation: Notation::Name("acosh"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static ATANH: Entry = Entry {
    name: "atanh",
    value: |x, _| x.atanh(),
    double: |x, _| elementary::atanh(x),
    slope: |x, _, _| 1.0 / ((1.0 - x) * (1.0 + x)),
    derivative: |arena, x, _, _| {
        let y = arena.factored(1.0, -1.0, x);
        arena.pow(y, -1)
    },
    parity: Parity::Odd,
    sign: Sign::Unknown,
    domain: |_| Domain::WithinOne { is_closed: false },
    bound: Bound::Arc { is_root: false },
    notation: Notation::Name("atanh"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};
