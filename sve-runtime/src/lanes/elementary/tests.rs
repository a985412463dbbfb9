//! The functions against values of many digits (`tests/data/elementary`), their symmetries, ranges,
//! exact values and bits.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::*;

/// Arguments, value, and the error of this value in units of the last place.
struct Record {
    arguments: [f64; 2],
    value: f64,
    rest: f64,
}

/// Reads the values of a function of one or two arguments, as `values.py` writes them.
fn records(name: &str, arguments: usize) -> Vec<Record> {
    let path = format!(
        "{}/tests/data/elementary/{name}.bin",
        env!("CARGO_MANIFEST_DIR")
    );
    let bytes = std::fs::read(&path).expect(&path);
    let size = 8 * (arguments + 1) + 1;
    assert_eq!(bytes.len() % size, 0);
    let number = |record: &[u8], i: usize| {
        f64::from_le_bytes(record[8 * i..8 * (i + 1)].try_into().expect("eight bytes"))
    };
    let read = |record: &[u8]| Record {
        arguments: [number(record, 0), number(record, arguments - 1)],
        value: number(record, arguments),
        rest: f64::from(record[size - 1].cast_signed()) / 256.0,
    };
    bytes.chunks_exact(size).map(read).collect()
}

/// Returns one unit in the last place of a normal number.
fn unit(x: f64) -> f64 {
    let size = x.abs();
    f64::from_bits(size.to_bits() + 1) - size
}

/// Returns the largest error over the table of a function, in units of the last place, and its
/// arguments.
fn worst(name: &str, arguments: usize, f: impl Fn([f64; 2]) -> f64) -> (f64, [f64; 2]) {
    let mut worst = (0.0, [f64::NAN; 2]);
    let table = records(name, arguments);
    assert!(table.len() > 1000, "{name}: {}", table.len());
    for Record {
        arguments,
        value,
        rest,
    } in table
    {
        let got = f(arguments);
        if value == 0.0 {
            assert_eq!(got, value, "{name} {arguments:?}");
            continue;
        }
        let error = ((got - value) / unit(value) - rest).abs();
        assert!(
            error < f64::INFINITY,
            "{name} {arguments:?}: {got:e} for {value:e}"
        );
        if error > worst.0 {
            worst = (error, arguments);
        }
    }
    worst
}

/// Asserts the bounds that the documentation states.
macro_rules! accurate {
    ($($test:ident: $f:ident($($x:ident),*), $bound:literal;)*) => {$(
        #[test]
        fn $test() {
            let count = [$(stringify!($x)),*].len();
            let (error, at) = worst(stringify!($f), count, |[$($x),*, ..]| $f($($x),*));
            println!("{} {error:.3} at {at:?}", stringify!($f));
            assert!(error <= $bound, "{error} units at {at:?}");
        }
    )*};
}

accurate! {
    sines: sin(x), 1.1;
    cosines: cos(x), 1.1;
    tangents: tan(x), 2.5;
    exponentials: exp(x), 0.9;
    exponentials_of_two: exp2(x), 1.2;
    exponentials_less_one: exp_m1(x), 1.5;
    logarithms: ln(x), 0.9;
    logarithms_of_one_more: ln_1p(x), 1.0;
    logarithms_to_two: log2(x), 1.0;
    logarithms_to_ten: log10(x), 1.0;
    hyperbolic_sines: sinh(x), 2.0;
    hyperbolic_cosines: cosh(x), 1.5;
    hyperbolic_tangents: tanh(x), 2.5;
    areas_of_sine: asinh(x), 2.0;
    areas_of_cosine: acosh(x), 2.0;
    areas_of_tangent: atanh(x), 2.0;
    arcs_of_sine: asin(x), 2.0;
    arcs_of_cosine: acos(x), 2.0;
    arcs_of_tangent: atan(x), 2.0;
    cube_roots: cbrt(x), 0.7;
    angles: atan2(x, y), 2.0;
    lengths: hypot(x, y), 1.3;
    powers: powf(x, y), 1.3;
}

type Real = fn(f64) -> f64;

/// The functions of one argument, the functions of the library, and their parity: 1 if
/// `f(−x) = f(x)`, −1 if `f(−x) = −f(x)`.
const ALL: [(&str, Real, Real, i8); 20] = [
    ("sin", sin, f64::sin, -1),
    ("cos", cos, f64::cos, 1),
    ("tan", tan, f64::tan, -1),
    ("exp", exp, f64::exp, 0),
    ("exp_m1", exp_m1, f64::exp_m1, 0),
    ("exp2", exp2, f64::exp2, 0),
    ("ln", ln, f64::ln, 0),
    ("ln_1p", ln_1p, f64::ln_1p, 0),
    ("log2", log2, f64::log2, 0),
    ("log10", log10, f64::log10, 0),
    ("sinh", sinh, f64::sinh, -1),
    ("cosh", cosh, f64::cosh, 1),
    ("tanh", tanh, f64::tanh, -1),
    ("asinh", asinh, f64::asinh, -1),
    ("acosh", acosh, f64::acosh, 0),
    ("atanh", atanh, f64::atanh, -1),
    ("asin", asin, f64::asin, -1),
    ("acos", acos, f64::acos, 0),
    ("atan", atan, f64::atan, -1),
    ("cbrt", cbrt, f64::cbrt, -1),
];

/// Returns numbers of every size and both signs, the ends of the ranges, zeros, infinities, NaN.
fn numbers() -> Vec<f64> {
    let mut list = vec![
        0.0,
        0.5,
        1.0,
        2.0,
        709.0,
        709.8,
        745.1,
        1021.0,
        1074.9,
        131_072.0,
        1e150,
        f64::MAX,
        f64::INFINITY,
        f64::NAN,
    ];
    let mut state = 1u64;
    for _ in 0..20_000 {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        // Numbers with any bits, and numbers of moderate size.
        let any = f64::from_bits(state ^ state >> 29);
        let fraction = (state >> 11) as f64 * 0.5f64.powi(53);
        list.extend([any, fraction, 4.0 * fraction, 1000.0 * fraction]);
    }
    list.iter().flat_map(|&x| [x, -x]).collect()
}

#[test]
fn odd_and_even_functions_are_so_to_the_bit() {
    for (name, f, _, parity) in ALL.into_iter().filter(|f| f.3 != 0) {
        for x in numbers() {
            let (left, right) = (f(-x), f(x) * f64::from(parity));
            let same = left.to_bits() == right.to_bits() || left.is_nan() && right.is_nan();
            assert!(same, "{name} {x:e}: {left:e}, {right:e}");
        }
    }
}

#[test]
fn a_result_is_right_or_not_a_number() {
    for (name, f, library, _) in ALL {
        let mut known = 0;
        for x in numbers() {
            let (got, expected) = (f(x), library(x));
            if got.is_nan() {
                continue;
            }
            known += 1;
            // The library's inverse hyperbolic functions lose digits; the tables above test the
            // last digits.
            let unit = f64::MIN_POSITIVE * f64::EPSILON;
            let near = (got - expected).abs() <= 1e-7 * expected.abs() + unit || got == expected;
            assert!(near, "{name} {x:e}: {got:e}, {expected:e}");
        }
        assert!(known > 20_000, "{name}: {known}");
    }
}

/// Checks the last argument with a value and the first argument without one.
#[test]
fn ranges_end_where_they_are_said_to() {
    let up = f64::next_up;
    let ends: [(Real, f64, f64); 14] = [
        (sin, 131_072.0, up(131_072.0)),
        (cos, -131_072.0, -up(131_072.0)),
        (ln, f64::MIN_POSITIVE, f64::MIN_POSITIVE / 2.0),
        (ln, f64::MAX, f64::INFINITY),
        (log2, f64::MIN_POSITIVE, 0.0),
        (log10, f64::MIN_POSITIVE, -1.0),
        (ln_1p, up(-1.0), -1.0),
        (sinh, 709.0, up(709.0)),
        (cosh, -709.0, -up(709.0)),
        (asinh, 1e150, up(1e150)),
        (acosh, 1.0, 1.0f64.next_down()),
        (atanh, 1.0f64.next_down(), 1.0),
        (asin, 1.0, up(1.0)),
        (cbrt, f64::MIN_POSITIVE, f64::MIN_POSITIVE / 2.0),
    ];
    for (i, (f, last, beyond)) in ends.into_iter().enumerate() {
        assert!(f(last).is_finite() && f(beyond).is_nan(), "{i}: {last:e}");
    }
    for (name, f, ..) in ALL {
        assert!(f(f64::NAN).is_nan(), "{name}");
    }
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    for (y, x) in [
        (0.0, 0.0),
        (inf, 1.0),
        (1.0, -inf),
        (nan, 1.0),
        (1.0, nan),
        (1e-200, 1e200),
    ] {
        assert!(atan2(y, x).is_nan(), "{y} {x}");
    }
    for (x, y) in [
        (5e-324, 1.0),
        (0.0, nan),
        (-2.0, 2.0),
        (nan, 0.0),
        (1.0, nan),
        (1.0, inf),
        (inf, 1.0),
    ] {
        assert!(
            powf(x, y).is_nan() && power_log(x, y, 1).is_nan(),
            "{x} {y}"
        );
    }
    for (x, y) in [
        (0.0, 0.0),
        (1e-136, 0.0),
        (1e155, 0.0),
        (nan, 1.0),
        (inf, 1.0),
    ] {
        assert!(hypot(x, y).is_nan(), "{x} {y}");
    }
}

/// Exponentials that overflow, are subnormal or vanish.
#[test]
fn exponentials_have_values_at_all_arguments() {
    let inf = f64::INFINITY;
    for x in [709.8, 746.0, 1e3, 2f64.powi(60), 1e300, f64::MAX, inf] {
        assert_eq!((exp(x), exp(-x)), (x.exp(), (-x).exp()), "{x:e}");
        assert_eq!((exp_m1(x), exp_m1(-x)), (inf, -1.0), "{x:e}");
    }
    for x in [1076.0, 1100.5, 1e4, 1e300, f64::MAX, inf] {
        assert_eq!((exp2(x), exp2(-x)), (inf, 0.0), "{x:e}");
    }
    for (x, y) in [(2.0, 1080.0), (0.25, -1e300), (1.0f64.next_up(), 1e300)] {
        assert_eq!((powf(x, y), powf(x, -y)), (inf, 0.0), "{x} {y:e}");
        assert_eq!(power_log(x, -y, 1), 0.0, "{x} {y:e}");
    }
    for k in -1074..=1023 {
        // the product of a normal and an exact number
        let x = f64::from(k);
        let power = 2f64.powi(k / 2) * 2f64.powi(k - k / 2);
        assert_eq!((exp2(x), powf(2.0, x)), (power, power), "{k}");
    }
    let unit = f64::MIN_POSITIVE * f64::EPSILON;
    for i in 0..20_000 {
        let x = -746.0 + 1e-3 * f64::from(i) * 2.0;
        let (got, expected) = (exp(x), x.exp());
        let bound = (2.0 * f64::EPSILON * expected).max(unit);
        assert!(
            (got - expected).abs() <= bound,
            "{x}: {got:e}, {expected:e}"
        );
    }
}

#[test]
fn zeros_ones_and_tiny_numbers_are_exact() {
    for f in [
        sin, tan, exp_m1, ln_1p, sinh, tanh, asinh, atanh, asin, atan,
    ] {
        for x in [
            0.0,
            -0.0,
            1e-200,
            -1e-30,
            3e-9 * 0.5f64.powi(30),
            f64::MIN_POSITIVE,
            5e-324,
        ] {
            assert_eq!(f(x).to_bits(), x.to_bits(), "{x:e}");
        }
    }
    for f in [cos, exp, exp2, cosh] {
        for x in [0.0, -0.0, 1e-200, -1e-30] {
            assert_eq!(f(x), 1.0);
        }
    }
    for f in [ln, log2, log10, acosh, acos] {
        assert_eq!(f(1.0).to_bits(), 0);
    }
    for k in -1022..=1023 {
        assert_eq!(log2(2.0f64.powi(k)), f64::from(k));
    }
    assert_eq!((atan2(0.0, 1.0).to_bits(), atan2(-0.0, 1.0)), (0, 0.0));
    assert!(atan2(-0.0, 1.0).is_sign_negative());
    assert_eq!((atan2(0.0, -1.0), atan2(-0.0, -1.0)), (PI, -PI));
    assert_eq!(
        (atan2(2.0, 0.0), atan2(-2.0, -0.0)),
        (FRAC_PI_2, -FRAC_PI_2)
    );
    assert_eq!(
        (atan2(2.0, 2.0), atan(f64::INFINITY), acos(-1.0)),
        (FRAC_PI_4, FRAC_PI_2, PI)
    );
    assert_eq!(
        (
            powf(1.0, -3.7),
            powf(0.3, 0.0),
            powf(4.0, 1.5),
            hypot(3.0, -4.0)
        ),
        (1.0, 1.0, 8.0, 5.0)
    );
    assert_eq!(
        (tanh(20.0), tanh(-f64::INFINITY), cbrt(-27.0)),
        (1.0, -1.0, -3.0)
    );
    assert_eq!((cbrt(0.0).to_bits(), cbrt(-0.0).to_bits()), (0, SIGN));
    assert_eq!(
        (powf(0.0, 1.3), powf(-0.0, -0.7), powf(0.0, 0.0)),
        (0.0, f64::INFINITY, 1.0)
    );
    let (x, y) = (2.5, -0.4);
    assert_eq!(power_log(x, y, 0), powf(x, y));
    assert_eq!(power_log(x, y, 2), powf(x, y) * ln(x) * ln(x));
}

#[test]
fn angles_are_added() {
    let mut worst: f64 = 0.0;
    for i in 0..200 {
        let (sin, cos) = (0.037 * f64::from(i) - 3.0).sin_cos();
        for j in -785..=785 {
            let by = 0.001 * f64::from(j) * 0.5f64.powi(i % 40);
            let (s, c) = sin_cos_of_sum(sin, cos, by);
            worst = worst.max((s - (sin * by.cos() + cos * by.sin())).abs());
            worst = worst.max((c - (cos * by.cos() - sin * by.sin())).abs());
        }
        assert_eq!(sin_cos_of_sum(sin, cos, 0.0), (sin, cos));
    }
    // The bound has three roundings of numbers up to 1, and two of the comparison.
    assert!(worst <= 3.0 * f64::EPSILON, "{worst:e}");
    for by in [
        FRAC_PI_4.next_up(),
        -FRAC_PI_4.next_up(),
        f64::INFINITY,
        f64::NAN,
    ] {
        let (s, c) = sin_cos_of_sum(0.6, 0.8, by);
        assert!(s.is_nan() && c.is_nan());
    }
}

#[cfg(feature = "ensemble")]
mod widths;
