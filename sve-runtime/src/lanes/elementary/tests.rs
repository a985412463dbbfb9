//! The functions against values of many digits (`tests/data/elementary`), their symmetries, ranges, exact values and bits.

use super::*;

/// Arguments, value, and what is missing to it in units of the last place.
struct Record {
    arguments: [f64; 2],
    value: f64,
    rest: f64,
}

/// The values of a function of one or two arguments, as `values.py` writes them.
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

/// One unit in the last place of a normal number.
fn unit(x: f64) -> f64 {
    let size = x.abs();
    f64::from_bits(size.to_bits() + 1) - size
}

/// The largest error over the table of a function, in units of the last place, and where.
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
    ($($test:ident: $f:ident, $bound:literal;)*) => {$(
        #[test]
        fn $test() {
            let (error, at) = worst(stringify!($f), 1, |[x, _]| $f(x));
            println!("{} {error:.3} at {at:?}", stringify!($f));
            assert!(error <= $bound, "{error} units at {at:?}");
        }
    )*};
}

accurate! {
    sines: sin, 0.8;
    cosines: cos, 0.8;
    tangents: tan, 2.0;
    exponentials: exp, 0.9;
    exponentials_of_two: exp2, 1.1;
    exponentials_less_one: exp_m1, 1.5;
    logarithms: ln, 0.9;
    logarithms_of_one_more: ln_1p, 1.5;
    logarithms_to_two: log2, 1.0;
    logarithms_to_ten: log10, 1.0;
}
