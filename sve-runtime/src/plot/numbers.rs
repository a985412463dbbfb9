//! Numbers in readable form: 22.09, −0.5, 1.5·10⁻⁶. Axes and tables of all pages have the same
//! form.
//!
//! Input: a number and the number of its significant digits. Output: a text. Invariant: the digits
//! are the digits of the exact value, rounded once, also for subnormal numbers.

use std::ops::RangeInclusive;

/// Powers of ten of the first digit for which a number is written without a power of ten.
const PLAIN: RangeInclusive<i32> = -4..=5;

/// Power of ten of the last digit from which a series of numbers is written without a power of ten.
const LAST_PLAIN: i32 = -5;

/// Power of ten of the first digit up to which a number with many digits is written without a power
/// of ten.
pub(super) const MOST_PLAIN: i32 = 9;

/// Digits of a number in a table.
const MOST_DIGITS: usize = 6;

/// Largest distance of the first digit of a value from the last digit of its error, as powers of
/// ten, at which both share one power.
const MOST_SPREAD: i32 = 6;

/// Returns a number with at most so many significant digits: without zeros at the end, and as a
/// multiple of a power of ten if it is very small or large.
///
/// ```
/// use sve_runtime::plot::page::number;
/// assert_eq!(number(22.093_38, 5), "22.093");
/// assert_eq!(number(-0.5, 5), "−0.5");
/// assert_eq!(number(1.5e-310, 5), "1.5·10⁻³¹⁰");
/// ```
pub fn number(value: f64, digits: usize) -> String {
    let Some((mantissa, exponent)) = decimal(value, digits.max(1)) else {
        return not_finite(value);
    };
    in_words(mantissa, exponent)
}

/// Returns a value and its standard error, both up to the second digit of the error, and with the
/// same power of ten if they need a power.
///
/// ```
/// use sve_runtime::plot::page::with_error;
/// assert_eq!(with_error(22.093_38, 0.012_345), ("22.093".to_owned(), "0.012".to_owned()));
/// assert_eq!(with_error(-8.812e6, 3.44e5), ("−8.81·10⁶".to_owned(), "0.34·10⁶".to_owned()));
/// ```
pub fn with_error(value: f64, error: f64) -> (String, String) {
    let (Some(first), Some(of_error)) = (first_digit(value), first_digit(error)) else {
        return (number(value, MOST_DIGITS), number(error, 2));
    };
    let digits = usize::try_from(first - of_error + 2).unwrap_or(2);
    // Beyond this distance, an f64 has no digits for the error.
    let digits = digits.clamp(2, 15);
    let Some((value_parts, error_parts)) = decimal(value, digits).zip(decimal(error, 2)) else {
        return (number(value, digits), number(error, 2));
    };
    let last = value_parts.1.min(error_parts.1);
    let spread = first.max(of_error) - last;
    let is_plain =
        last >= LAST_PLAIN - 1 && (first <= *PLAIN.end() || last <= 0 && first <= MOST_PLAIN);
    if !is_plain && (spread > MOST_SPREAD || first < of_error) {
        return (number(value, digits), number(error, 2));
    }
    let write = |(mantissa, exponent): (i128, i32)| {
        if is_plain {
            plain(mantissa, exponent)
        } else {
            with_power(mantissa, exponent, first)
        }
    };
    (write(value_parts), write(error_parts))
}

/// Returns a number with the digits that distinguish values differing by about `scale`.
#[cfg(feature = "ensemble")]
pub(super) fn number_beside(value: f64, scale: f64) -> String {
    match (first_digit(value), first_digit(scale)) {
        (Some(first), Some(of_scale)) if first - of_scale > 2 => {
            let digits = usize::try_from(first - of_scale + 2).unwrap_or(1);
            exact_up_to(value, digits.clamp(MOST_DIGITS, 15))
        }
        _ => number(value, MOST_DIGITS),
    }
}

/// Writes a number with so many digits, without a power of ten if it is not too long.
#[cfg(feature = "ensemble")]
fn exact_up_to(value: f64, digits: usize) -> String {
    match decimal(value, digits) {
        Some((mantissa, exponent))
            if exponent >= LAST_PLAIN - 1 && leading(mantissa, exponent) <= MOST_PLAIN =>
        {
            plain(mantissa, exponent)
        }
        _ => number(value, digits),
    }
}

/// Returns a number with all digits that distinguish it from other numbers.
#[cfg(feature = "ensemble")]
pub(super) fn exact(value: f64) -> String {
    match read(&format!("{value:e}")) {
        Some((mantissa, exponent)) => in_words(mantissa, exponent),
        None => not_finite(value),
    }
}

/// Returns the power of ten of the first digit; `None` for 0 and for numbers that are not finite.
fn first_digit(value: f64) -> Option<i32> {
    let (mantissa, exponent) = decimal(value, 17)?;
    (mantissa != 0).then(|| leading(mantissa, exponent))
}

/// Returns the number with so many digits as an integer times a power of ten, without zeros at its
/// end; `None` unless the number is finite.
fn decimal(value: f64, digits: usize) -> Option<(i128, i32)> {
    // More digits than an f64 and an i128 have contain no information.
    let decimals = digits.clamp(1, 30) - 1;
    read(&format!("{value:.decimals$e}"))
}

/// Reads `1.5e-7` as an integer times a power of ten, without zeros at its end.
fn read(text: &str) -> Option<(i128, i32)> {
    let (mantissa, exponent) = text.split_once('e')?;
    let decimals = mantissa
        .split_once('.')
        .map_or(0, |(_, decimals)| decimals.len());
    let mantissa: i128 = mantissa.replace('.', "").parse().ok()?;
    let exponent: i32 = exponent.parse().ok()?;
    Some(shortened(mantissa, exponent - decimals as i32))
}

/// Moves the zeros at the end of an integer into the power of ten.
pub(super) fn shortened(mut mantissa: i128, mut exponent: i32) -> (i128, i32) {
    if mantissa == 0 {
        return (0, 0);
    }
    while mantissa % 10 == 0 {
        mantissa /= 10;
        exponent += 1;
    }
    (mantissa, exponent)
}

fn not_finite(value: f64) -> String {
    match value {
        f64::INFINITY => "∞",
        f64::NEG_INFINITY => "−∞",
        _ => "NaN",
    }
    .to_owned()
}

/// Writes an integer times a power of ten, in the form for its size.
fn in_words(mantissa: i128, exponent: i32) -> String {
    if PLAIN.contains(&leading(mantissa, exponent)) {
        plain(mantissa, exponent)
    } else {
        with_power(mantissa, exponent, leading(mantissa, exponent))
    }
}

/// Writes multiples of the same power of ten in one form: all of them without a power of ten, or
/// all but 0 as a factor times the power of the largest multiple.
pub(super) fn series(mantissas: &[i128], exponent: i32) -> Vec<String> {
    let largest = mantissas.iter().map(|m| m.abs()).max().unwrap_or(0);
    let first = leading(largest, exponent);
    let is_plain = largest == 0 || (PLAIN.contains(&first) && exponent >= LAST_PLAIN);
    let write = |&mantissa: &i128| match mantissa {
        _ if is_plain => plain(mantissa, exponent),
        0 => "0".to_owned(),
        _ => multiple(&plain(mantissa, exponent - first), first),
    };
    mantissas.iter().map(write).collect()
}

/// Returns the power of ten of the first digit.
pub(super) fn leading(mantissa: i128, exponent: i32) -> i32 {
    let digits = mantissa.unsigned_abs().checked_ilog10().unwrap_or(0);
    exponent + digits as i32
}

/// Writes an integer times a power of ten without the power.
pub(super) fn plain(mantissa: i128, exponent: i32) -> String {
    let (mantissa, exponent) = shortened(mantissa, exponent);
    let sign = if mantissa < 0 { "−" } else { "" };
    let digits = mantissa.unsigned_abs().to_string();
    let zeros = |count: i32| "0".repeat(usize::try_from(count).unwrap_or(0));
    if exponent >= 0 {
        return format!("{sign}{digits}{}", zeros(exponent));
    }
    let missing = 1 - exponent - digits.len() as i32;
    let digits = zeros(missing) + &digits;
    let (whole, part) = digits.split_at(digits.len() - exponent.unsigned_abs() as usize);
    format!("{sign}{whole}.{part}")
}

/// Writes an integer times a power of ten as a multiple of 10ᵖ; a factor of 1 is left out.
pub(super) fn with_power(mantissa: i128, exponent: i32, power: i32) -> String {
    let factor = plain(mantissa, exponent - power);
    match factor.as_str() {
        "0" => factor,
        "1" | "−1" => multiple(&factor, power).replace("1·", ""),
        factor => multiple(factor, power),
    }
}

fn multiple(factor: &str, power: i32) -> String {
    format!("{factor}·10{}", superscript(i64::from(power)))
}

/// Characters of exponents, with the characters that they stand for.
const EXPONENTS: [(char, char); 11] = [
    ('⁻', '−'),
    ('⁰', '0'),
    ('¹', '1'),
    ('²', '2'),
    ('³', '3'),
    ('⁴', '4'),
    ('⁵', '5'),
    ('⁶', '6'),
    ('⁷', '7'),
    ('⁸', '8'),
    ('⁹', '9'),
];

/// Returns the digit or the minus that a superscript stands for.
pub(super) fn exponent_digit(character: char) -> Option<char> {
    let found = EXPONENTS.iter().find(|(raised, _)| *raised == character);
    found.map(|&(_, digit)| digit)
}

pub(super) fn superscript(exponent: i64) -> String {
    let raised = |digit: char| {
        let found = EXPONENTS.iter().find(|(_, plain)| *plain == digit);
        found.map_or(digit, |&(raised, _)| raised)
    };
    let text = exponent.to_string().replace('-', "−");
    text.chars().map(raised).collect()
}

/// Returns whether a text is a number, or several with signs between them: `1.5·10⁻⁶`, `± 2`,
/// `22.09 ± 0.05`, `1e-3`.
pub(super) fn is_number(text: &str) -> bool {
    let is_part = |part: &str| {
        let text = part.replace('−', "-");
        let (factor, power) = text.rsplit_once("10").unwrap_or((&text, ""));
        let is_power = !power.is_empty() && power.chars().all(|c| exponent_digit(c).is_some());
        let factor = if is_power {
            factor.trim_end_matches('·')
        } else {
            &text
        };
        matches!(factor, "" | "-") && is_power
            || factor.parse::<f64>().is_ok()
            || factor.trim_start_matches('-') == "∞"
    };
    let mut parts = text
        .split_whitespace()
        .filter(|part| *part != "±")
        .peekable();
    parts.peek().is_some() && parts.all(is_part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_people_write_them() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (22.09338, "22.0934"),
            (100.0, "100"),
            (999_999.7, "10⁶"),
            (123_456.0, "123456"),
            (1_234_567.0, "1.23457·10⁶"),
            (-1e6, "−10⁶"),
            (0.000_123_456, "0.000123456"),
            (0.000_012_345, "1.2345·10⁻⁵"),
            (-1e-7, "−10⁻⁷"),
            (5e-324, "4.94066·10⁻³²⁴"),
            (f64::MAX, "1.79769·10³⁰⁸"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "−∞"),
            (1.0 / 3.0, "0.333333"),
        ] {
            assert_eq!(number(value, 6), text);
            assert!(is_number(text), "{text}");
        }
        assert_eq!(number(123_456.0, 2), "120000");
        assert_eq!(number(1.0 / 3.0, usize::MAX).len(), 32);
    }

    #[cfg(feature = "ensemble")]
    #[test]
    fn an_exact_number_has_all_its_digits() {
        for (value, text) in [
            (0.1, "0.1"),
            (0.1 + 0.2, "0.30000000000000004"),
            (1e-310, "10⁻³¹⁰"),
            (f64::INFINITY, "∞"),
        ] {
            assert_eq!(exact(value), text);
            assert!(is_number(text));
        }
    }

    #[test]
    fn a_value_has_the_digits_that_its_error_leaves() {
        let pair = |value, error| {
            let (value, error) = with_error(value, error);
            format!("{value} ± {error}")
        };
        assert_eq!(pair(22.09338, 0.01234), "22.093 ± 0.012");
        assert_eq!(pair(22.09338, 123.0), "22 ± 120");
        assert_eq!(pair(1e-9, 2.5e-12), "10⁻⁹ ± 0.0025·10⁻⁹");
        assert_eq!(pair(1.2345e-9, 2.5e-18), "1.2345·10⁻⁹ ± 2.5·10⁻¹⁸");
        assert_eq!(pair(-8.81e6, 3.4e5), "−8.81·10⁶ ± 0.34·10⁶");
        assert_eq!(pair(1234.5, 120.0), "1230 ± 120");
        assert_eq!(
            pair(999_999_999.999_119, 3.4e-5),
            "999999999.999119 ± 0.000034"
        );
        assert_eq!(pair(1e-9, 2.5e-6), "10⁻⁹ ± 2.5·10⁻⁶");
        assert_eq!(pair(1.25e9, 0.0), "1.25·10⁹ ± 0");
        assert_eq!(pair(0.0, 0.5), "0 ± 0.5");
        assert_eq!(pair(1.0, f64::NAN), "1 ± NaN");
        assert_eq!(pair(1e300, 1e-300), "10³⁰⁰ ± 10⁻³⁰⁰");
        assert!(is_number("22.093 ± 0.012") && is_number("± 2") && is_number("−1.5e-3"));
        assert!(!is_number("") && !is_number("±") && !is_number("holds") && !is_number("1.5 m"));
    }

    #[cfg(feature = "ensemble")]
    #[test]
    fn values_far_from_zero_are_told_apart() {
        assert_eq!(number_beside(999_999_999.998_765, 7e-4), "999999999.99876");
        assert_eq!(number_beside(1_000_000_000.001, 7e-4), "1000000000.001");
        assert_eq!(number_beside(0.002_487_18, 0.85), "0.00248718");
        assert_eq!(number_beside(1e-310, 0.0), "10⁻³¹⁰");
        assert_eq!(number_beside(1.5e300, 1e290), "1.5·10³⁰⁰");
    }

    #[test]
    fn a_series_has_one_power() {
        assert_eq!(series(&[-5, 0, 5], -1), ["−0.5", "0", "0.5"]);
        assert_eq!(series(&[5, 10, 15], -7), ["0.5·10⁻⁶", "1·10⁻⁶", "1.5·10⁻⁶"]);
        assert_eq!(series(&[5, 10, 15], 10), ["0.5·10¹¹", "1·10¹¹", "1.5·10¹¹"]);
        assert_eq!(series(&[0, 1], -5), ["0", "1·10⁻⁵"]);
    }
}
