//! Labels of axes: where they stand, and their digits.
//!
//! Input: an axis and its range. Output: numbers with their texts. Invariant: the texts of an axis differ.

use std::f64::consts::PI;
use std::ops::Range;

use super::axes::length;
use super::figure::{Axis, Scale};

/// Largest number of labels of an axis.
const MOST_LABELS: usize = 1000;

/// Axes of powers that are shorter have three, or two, labels a decade.
const ONE_DECADE: f64 = 1.5;
const FEW_DECADES: f64 = 3.0;
/// One that is longer has no ticks there.
const MANY_DECADES: f64 = 6.0;

/// Where the labels of an axis stand.
fn labelled(axis: &Axis, range: &Range<f64>) -> Vec<f64> {
    if axis.labels == 0 {
        return Vec::new();
    }
    match axis.scale {
        Scale::Linear => return round_numbers(range, axis.labels),
        Scale::Angle => return parts_of_pi(range, axis.labels),
        Scale::Powers => {}
    }
    let decades = length(range);
    if decades < ONE_DECADE {
        return within_decades(range, &[1.0, 2.0, 5.0]);
    }
    if decades < FEW_DECADES {
        return within_decades(range, &[1.0, 3.0]);
    }
    // exponents are whole, so at most one label a decade
    let count = (1..axis.labels.min(MOST_LABELS))
        .take_while(|k| *k as f64 <= decades)
        .count();
    let mut numbers = round_numbers(range, count);
    numbers.retain(|x| (x - x.round()).abs() < 1e-9);
    numbers
}

/// Where ticks without labels stand: between powers of ten, where there are not too many.
pub(super) fn ticks(axis: &Axis, range: &Range<f64>) -> Vec<f64> {
    if axis.scale == Scale::Powers && length(range) < MANY_DECADES {
        within_decades(range, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    } else {
        Vec::new()
    }
}

/// Decimal logarithms of some multiples of the powers of ten in a range.
fn within_decades(range: &Range<f64>, multiples: &[f64]) -> Vec<f64> {
    let decades = range.start.floor() as i32..=range.end.ceil() as i32;
    decades
        .flat_map(|k| multiples.iter().map(move |m| f64::from(k) + m.log10()))
        .filter(|x| range.contains(x))
        .collect()
}

/// Multiples of 1, 2 or 5 times a power of ten in the range, about `count` of them.
fn round_numbers(range: &Range<f64>, count: usize) -> Vec<f64> {
    let count = count.clamp(1, MOST_LABELS);
    let rough = length(range) / count as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|f| f * power >= 0.8 * rough);
    let step = factor.unwrap_or(10.0) * power;
    // a label may stand on the very end of the axis, up to rounding
    let first = (range.start / step - 1e-9).ceil();
    (0..=4 * count)
        .map(|k| (first + k as f64) * step)
        .take_while(|x| *x <= range.end + 1e-9 * step)
        .collect()
}

/// Multiples of π/4, π/2, π or a round number of π in the range, about `count` of them; of smaller parts in a short range.
fn parts_of_pi(range: &Range<f64>, count: usize) -> Vec<f64> {
    let turns = range.start / PI..range.end / PI;
    let rough = length(&turns) / count.clamp(1, MOST_LABELS) as f64;
    let part = [0.125, 0.25, 0.5, 1.0]
        .into_iter()
        .find(|part| *part >= 0.8 * rough);
    match part {
        Some(part) if part / 8.0 < rough => {
            let first = (turns.start / part - 1e-9).ceil() as i64;
            let last = (turns.end / part + 1e-9).floor() as i64;
            (first..=last).map(|k| k as f64 * part * PI).collect()
        }
        // many turns, or a small part of one
        _ => round_numbers(&turns, count)
            .iter()
            .map(|x| x * PI)
            .collect(),
    }
}

/// An angle in parts of π; `spacing` is that of the labels in these parts.
fn angle(value: f64, spacing: f64) -> String {
    let turns = value / PI;
    let eighths = 8.0 * turns;
    if (eighths - eighths.round()).abs() > 1e-9 {
        return format!("{}π", number(turns, spacing));
    }
    let (mut above, mut below) = (eighths.round() as i64, 8);
    while above % 2 == 0 && below > 1 {
        (above, below) = (above / 2, below / 2);
    }
    let sign = if above < 0 { "−" } else { "" };
    let above = match above.abs() {
        0 => return "0".to_owned(),
        1 => "π".to_owned(),
        k => format!("{k}π"),
    };
    match below {
        1 => format!("{sign}{above}"),
        _ => format!("{sign}{above}/{below}"),
    }
}

/// The labels of an axis and where they stand: numbers, powers of ten, or parts of π.
pub(super) fn labels(axis: &Axis, range: &Range<f64>) -> Vec<(f64, String)> {
    let values = labelled(axis, range);
    let spacing = match values.as_slice() {
        [first, second, ..] => second - first,
        [only] => only.abs(),
        [] => return Vec::new(),
    };
    let label = |value: f64| match axis.scale {
        Scale::Angle => angle(value, spacing / PI),
        Scale::Powers => power(value),
        Scale::Linear => number(value, spacing),
    };
    values.into_iter().map(|x| (x, label(x))).collect()
}

/// A power of ten, or a multiple of one, of which this is the logarithm.
fn power(logarithm: f64) -> String {
    let exponent = (logarithm + 1e-9).floor();
    let multiple = 10_f64.powf(logarithm - exponent).round() as i64;
    let power = format!("10{}", superscript(exponent as i64));
    match multiple {
        1 => power,
        multiple => format!("{multiple}·{power}"),
    }
}

/// A number with the digits that tell it from its neighbours, as a multiple of a power of ten if it is very small or large.
fn number(value: f64, spacing: f64) -> String {
    if value.abs() < 1e-9 * spacing {
        return "0".to_owned();
    }
    let last_digit = (spacing * (1.0 + 1e-9)).log10().floor() as i32;
    let first_digit = (value.abs() * (1.0 + 1e-9)).log10().floor() as i32;
    let digits = |value: f64, count: i32| {
        let count = usize::try_from(count).unwrap_or(0);
        let text = format!("{value:.count$}").replace('-', "−");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    };
    if last_digit >= -5 && first_digit < 6 {
        return digits(value, -last_digit);
    }
    let power = format!("10{}", superscript(i64::from(first_digit)));
    let factor = digits(value / 10_f64.powi(first_digit), first_digit - last_digit);
    match factor.as_str() {
        "1" => power,
        "−1" => format!("−{power}"),
        factor => format!("{factor}·{power}"),
    }
}

fn superscript(exponent: i64) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => digit
            .to_digit(10)
            .and_then(|d| char::from_u32(0x2070 + d))
            .unwrap_or(digit),
    };
    exponent.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_stand_at_round_numbers() {
        assert_eq!(
            round_numbers(&(0.0..2000.0), 6),
            [0.0, 500.0, 1000.0, 1500.0, 2000.0]
        );
        assert_eq!(
            round_numbers(&(-1.5..1.5), 6),
            [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5]
        );
        assert_eq!(
            round_numbers(&(-13.2..332.7), 6),
            [0.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0]
        );
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(number(-0.5, 0.5), "−0.5");
        assert_eq!(number(-1e-12, 0.5), "0");
        assert_eq!(number(2000.0, 500.0), "2000");
        assert_eq!(number(0.00015, 0.00005), "0.00015");
        assert_eq!(number(1.5e-6, 5e-7), "1.5·10⁻⁶");
        assert_eq!(number(-1e-7, 1e-7), "−10⁻⁷");
        assert_eq!(number(2.5e11, 5e10), "2.5·10¹¹");
        let mut many = Axis::new("", 0.0..1.0);
        many.labels = usize::MAX;
        assert!((100..10_000).contains(&labels(&many, &(0.0..1.0)).len()));
        assert_eq!(power(-10.0), "10⁻¹⁰");
        assert_eq!(power(2e-3_f64.log10()), "2·10⁻³");
    }

    #[test]
    fn angles_are_parts_of_pi() {
        let labels = |range: Range<f64>| -> Vec<String> {
            let axis = Axis::angle("", range);
            let labels = super::labels(&axis, &axis.range);
            labels.into_iter().map(|(_, label)| label).collect()
        };
        assert_eq!(labels(-PI..PI), ["−π", "−π/2", "0", "π/2", "π"]);
        assert_eq!(labels(0.0..1.0), ["0", "π/8", "π/4"]);
        assert_eq!(
            labels(0.0..40.0),
            ["0", "2π", "4π", "6π", "8π", "10π", "12π"]
        );
        assert_eq!(
            labels(0.0..0.01),
            [
                "0", "0.0005π", "0.001π", "0.0015π", "0.002π", "0.0025π", "0.003π"
            ]
        );
    }

    #[test]
    fn short_axes_of_powers_are_labelled_within_their_decades() {
        let axis = Axis::powers("", -3.1..-1.9);
        let labels = labels(&axis, &axis.range);
        let labels: Vec<String> = labels.into_iter().map(|(_, label)| label).collect();
        assert_eq!(labels, ["10⁻³", "2·10⁻³", "5·10⁻³", "10⁻²"]);
        let axis = Axis::powers("", -3.1..0.1);
        assert_eq!(labelled(&axis, &axis.range), [-3.0, -2.0, -1.0, 0.0]);
    }
}
