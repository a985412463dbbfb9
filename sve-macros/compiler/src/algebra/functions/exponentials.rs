//! Exponentials and logarithms.

use std::f64::consts::{LN_2, LN_10, LOG2_E, LOG10_E};

use super::super::elementary;
use super::{
    Bound, Domain, Entry, Form, Function, Notation, Parity, Sign, Stable, everywhere, positive,
};

pub(super) static EXP: Entry = Entry {
    name: "exp",
    value: |x, _| x.exp(),
    double: |x, _| elementary::exp(x),
    slope: |_, value, _| value,
    derivative: |_, _, value, _| value,
    parity: Parity::None,
    sign: Sign::Positive,
    domain: everywhere,
    bound: Bound::Growth {
        constant: 0.0,
        rate: 1.0,
    },
    notation: Notation::Name("exp"),
    stable: Stable {
        less_one: Some(Form {
            scale: 1.0,
            function: Function::ExpM1,
            factor: 1.0,
            power: 1,
            is_further_call: true,
        }),
        power_scales_argument: true,
        ..Stable::NONE
    },
    letter: 'f',
    is_instruction: false,
};

pub(super) static EXP2: Entry = Entry {
    name: "exp2",
    value: |x, _| x.exp2(),
    double: |x, _| elementary::exp2(x),
    slope: |_, value, _| LN_2 * value,
    derivative: |arena, _, value, _| arena.scale(LN_2, value),
    parity: Parity::None,
    sign: Sign::Positive,
    domain: everywhere,
    bound: Bound::Growth {
        constant: 0.0,
        rate: LN_2,
    },
    notation: Notation::PowerOf("2"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static EXP_M1: Entry = Entry {
    name: "exp_m1",
    value: |x, _| x.exp_m1(),
    double: |x, _| elementary::exp_m1(x),
    slope: |_, value, _| value + 1.0,
    derivative: |arena, _, value, _| arena.sum(1.0, &[(1.0, value)]),
    parity: Parity::None,
    sign: Sign::Unknown,
    domain: everywhere,
    bound: Bound::Growth {
        constant: 1.0,
        rate: 1.0,
    },
    notation: Notation::ExpMinusOne,
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static LN: Entry = Entry {
    name: "ln",
    value: |x, _| x.ln(),
    double: |x, _| elementary::ln(x),
    slope: |x, _, _| 1.0 / x,
    derivative: |arena, x, _, _| arena.pow(x, -1),
    parity: Parity::None,
    sign: Sign::Unknown,
    domain: positive,
    bound: Bound::Logarithm {
        shift: 0.0,
        scale: 1.0,
    },
    notation: Notation::Name("ln"),
    stable: Stable {
        of_one_plus: Some(Function::Ln1p),
        ..Stable::NONE
    },
    letter: 'f',
    is_instruction: false,
};

pub(super) static LN_1P: Entry = Entry {
    name: "ln_1p",
    value: |x, _| x.ln_1p(),
    double: |x, _| elementary::ln_1p(x),
    slope: |x, _, _| 1.0 / (1.0 + x),
    derivative: |arena, x, _, _| {
        let y = arena.sum(1.0, &[(1.0, x)]);
        arena.pow(y, -1)
    },
    parity: Parity::None,
    sign: Sign::Unknown,
    domain: |_| Domain::From {
        least: -1.0,
        is_closed: false,
    },
    bound: Bound::Logarithm {
        shift: 1.0,
        scale: 1.0,
    },
    notation: Notation::LogOfOnePlus,
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static LOG2: Entry = Entry {
    name: "log2",
    value: |x, _| x.log2(),
    double: |x, _| elementary::log2(x),
    slope: |x, _, _| 1.0 / (LN_2 * x),
    derivative: |arena, x, _, _| {
        let inverse = arena.pow(x, -1);
        arena.scale(LOG2_E, inverse)
    },
    parity: Parity::None,
    sign: Sign::Unknown,
    domain: positive,
    bound: Bound::Logarithm {
        shift: 0.0,
        scale: LOG2_E,
    },
    notation: Notation::Name("log₂"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};

pub(super) static LOG10: Entry = Entry {
    name: "log10",
    value: |x, _| x.log10(),
    double: |x, _| elementary::log10(x),
    slope: |x, _, _| 1.0 / (LN_10 * x),
    derivative: |arena, x, _, _| {
        let inverse = arena.pow(x, -1);
        arena.scale(LOG10_E, inverse)
    },
    parity: Parity::None,
    sign: Sign::Unknown,
    domain: positive,
    bound: Bound::Logarithm {
        shift: 0.0,
        scale: LOG10_E,
    },
    notation: Notation::Name("log₁₀"),
    stable: Stable::NONE,
    letter: 'f',
    is_instruction: false,
};
