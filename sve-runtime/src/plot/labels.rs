//! Labels of axes: their places and their digits.
//!
//! Input: an axis and its range. Output: numbers with their texts. Invariant: the texts of an axis
//! differ, and all its numbers are finite.
//!
//! Labels are integers times a power of ten, so their texts are exact, even if floating-point
//! numbers have few digits: near the smallest numbers, and on short axes far from zero. On short
//! axes a round number is subtracted from all labels, and added to the name of the axis.

use std::f64::consts::PI;
use std::ops::Range;

use super::axes::length;
use super::figure::{Axis, Scale};
use super::numbers::{MOST_PLAIN, leading, plain, series, shortened, superscript, with_power};

/// Largest number of labels of an axis.
pub(super) const MOST_LABELS: usize = 1000;

/// Labels with more digits have a round number subtracted from them.
const MOST_DIGITS: i32 = 6;

/// Smallest power of ten that has all digits of an `f64`.
const SUBNORMAL: i32 = -307;

/// Length, in decades, from which an axis of powers has ticks at powers of ten only.
const MANY_DECADES: f64 = 6.0;

/// Length, in decades, from which an axis of powers has no ticks between labels: they would touch.
const TOO_MANY_DECADES: f64 = 60.0;

/// The labels of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Labels {
    /// The place of each label, and its text.
    pub(super) marks: Vec<(f64, String)>,
    /// The number that is subtracted from the labels, with its sign, as it follows the name:
    /// `− 10⁹`.
    pub(super) offset: Option<String>,
}

impl Labels {
    fn new(marks: impl IntoIterator<Item = (f64, String)>) -> Self {
        let mut labels = Self::default();
        for (at, text) in marks {
            let is_new = |(other, known): &(f64, String)| *other != at && *known != text;
            if at.is_finite() && labels.marks.iter().all(is_new) {
                labels.marks.push((at, text));
            }
        }
        labels
    }

    /// Returns the name of an axis with these labels.
    pub(super) fn name(&self, name: &str) -> String {
        match &self.offset {
            Some(offset) => format!("{name} {offset}").trim_start().to_owned(),
            None => name.to_owned(),
        }
    }
}

/// Returns the labels of an axis, about `count` of them: numbers, powers of ten, or parts of π.
pub(super) fn labels(axis: &Axis, range: &Range<f64>, count: usize) -> Labels {
    if count == 0 {
        return Labels::default();
    }
    match axis.scale {
        Scale::Linear => numbers(range, count),
        Scale::Angle => Labels::new(parts_of_pi(range, count)),
        Scale::Powers => powers(range, count),
    }
}

/// Returns the places of ticks without labels on an axis of powers: at multiples of the powers of
/// ten, or at the powers alone if there are many.
pub(super) fn ticks(axis: &Axis, range: &Range<f64>) -> Vec<f64> {
    if axis.scale != Scale::Powers || length(range) >= TOO_MANY_DECADES {
        return Vec::new();
    }
    let last = if length(range) < MANY_DECADES { 9 } else { 1 };
    let decades = range.start.floor() as i32..=range.end.ceil() as i32;
    decades
        .flat_map(|k| (1..=last).map(move |m| f64::from(k) + f64::from(m).log10()))
        .filter(|x| range.contains(x))
        .collect()
}

/// Multiples of a power of ten: the integers, and the power.
struct Round {
    multiples: Vec<i128>,
    exponent: i32,
}

impl Round {
    /// Returns multiples of 1, 2 or 5 times a power of ten in a range, about `count` of them.
    fn of(range: &Range<f64>, count: usize) -> Self {
        let count = count.clamp(1, MOST_LABELS);
        // Floating-point numbers in the range have at least this distance.
        let largest = range.start.abs().max(range.end.abs());
        let rough = (length(range) / count as f64).max(largest - largest.next_down());
        let decade = rough.log10().floor() as i32;
        let candidates = [(1, decade), (2, decade), (5, decade), (1, decade + 1)];
        let is_long = |&(factor, exponent): &(i128, i32)| float(factor, exponent) >= 0.8 * rough;
        let chosen = candidates.into_iter().find(is_long);
        let (factor, exponent) = chosen.unwrap_or((2, decade + 1));
        let step = float(factor, exponent);
        // A label may stand at the very end of the axis, up to rounding.
        let slack = 1e-9 * step;
        let within = range.start - slack..=range.end + slack;
        // If floating-point numbers have few digits, the quotients are not exact.
        let first = quotient(range.start, factor, exponent).floor() as i128 - 1;
        let last = quotient(range.end, factor, exponent).ceil() as i128 + 1;
        Self {
            multiples: (first..=last)
                .map(|multiple| multiple * factor)
                .filter(|&multiple| within.contains(&float(multiple, exponent)))
                .take(4 * count + 1)
                .collect(),
            exponent,
        }
    }

    /// Returns the roundest number that is not above the labels and not farther below them than the
    /// length of their range. Returns `None` if the labels are short without it.
    fn offset(&self) -> Option<i128> {
        let (first, last) = (*self.multiples.first()?, *self.multiples.last()?);
        let largest = first.abs().max(last.abs());
        if leading(largest, 0) < MOST_DIGITS {
            return None;
        }
        let least = first - (last - first).max(1);
        let powers = core::iter::successors(Some(1), |power: &i128| power.checked_mul(10));
        let rounded = powers
            .take_while(|&power| power <= 10 * largest)
            .map(|power| last.div_euclid(power) * power)
            .filter(|&number| number > least);
        rounded.last().filter(|&number| number != 0)
    }

    fn floats(&self) -> Vec<f64> {
        let multiples = self.multiples.iter();
        multiples
            .map(|&multiple| float(multiple, self.exponent))
            .collect()
    }
}

/// Returns a number divided by an integer times a power of ten. Subnormal numbers have fewer digits
/// than the quotient.
fn quotient(value: f64, factor: i128, exponent: i32) -> f64 {
    if exponent < SUBNORMAL {
        let scaled = value * float(1, -SUBNORMAL) * float(1, SUBNORMAL - exponent);
        return scaled / factor as f64;
    }
    value / float(factor, exponent)
}

/// Returns the number that is nearest to an integer times a power of ten.
fn float(mantissa: i128, exponent: i32) -> f64 {
    // The text of a number always parses as a number.
    format!("{mantissa}e{exponent}").parse().unwrap_or(f64::NAN)
}

/// Returns round numbers with the digits that distinguish them.
fn numbers(range: &Range<f64>, count: usize) -> Labels {
    let round = Round::of(range, count);
    let offset = round.offset();
    let shown: Vec<i128> = round
        .multiples
        .iter()
        .map(|m| m - offset.unwrap_or(0))
        .collect();
    let texts = series(&shown, round.exponent);
    let mut labels = Labels::new(round.floats().into_iter().zip(texts));
    labels.offset = offset.map(|offset| {
        let sign = if offset < 0 { '+' } else { '−' };
        let (mantissa, exponent) = shortened(offset.abs(), round.exponent);
        let power = leading(mantissa, exponent);
        let number = if (-MOST_PLAIN..=MOST_PLAIN).contains(&power) {
            plain(mantissa, exponent)
        } else {
            with_power(mantissa, exponent, power)
        };
        format!("{sign} {number}")
    });
    labels
}

/// Returns powers of ten whose logarithms are in the range. If there is one power at most, returns
/// round numbers between powers, none of them as a power beside a multiple of a power.
fn powers(range: &Range<f64>, count: usize) -> Labels {
    let decades = length(range);
    // Exponents are integers, so there is at most one label for each decade.
    let powers = (1..=count.min(MOST_LABELS)).take_while(|k| *k as f64 <= decades + 1.0);
    let mut exponents = Round::of(range, powers.count()).floats();
    exponents.retain(|x| x.fract() == 0.0);
    if exponents.len() > 1 || decades > 2.0 {
        return Labels::new(exponents.into_iter().map(|x| (x, power(x))));
    }
    let multiples = multiples_of_powers(range);
    if multiples.marks.len() > 1 {
        return multiples;
    }
    within_one_decade(range, count)
}

/// Returns 1, 2 and 5 times the powers of ten in a range, all with the same power.
fn multiples_of_powers(range: &Range<f64>) -> Labels {
    let decade = range.start.floor();
    let factors: [(f64, i128); 6] = [
        (0.0, 1),
        (2_f64.log10(), 2),
        (5_f64.log10(), 5),
        (1.0, 10),
        (1.0 + 2_f64.log10(), 20),
        (1.0 + 5_f64.log10(), 50),
    ];
    let inside: Vec<_> = factors
        .into_iter()
        .map(|(x, factor)| (decade + x, factor))
        .filter(|(x, _)| range.contains(x))
        .collect();
    let factors: Vec<i128> = inside.iter().map(|&(_, factor)| factor).collect();
    let texts = series(&factors, decade as i32);
    Labels::new(inside.into_iter().map(|(x, _)| x).zip(texts))
}

/// Returns round numbers whose logarithms are in a range.
fn within_one_decade(range: &Range<f64>, count: usize) -> Labels {
    // The power is factored out, so that no number overflows.
    let decade = range.start.floor();
    let round = Round::of(
        &(10_f64.powf(range.start - decade)..10_f64.powf(range.end - decade)),
        count,
    );
    let texts = series(
        &round.multiples,
        round.exponent.saturating_add(decade as i32),
    );
    let logarithms = round.floats().into_iter().map(|x| x.log10() + decade);
    Labels::new(logarithms.zip(texts))
}

/// Returns multiples of π/4, π/2, π or a round number of π in the range, about `count` of them;
/// multiples of smaller parts in a short range.
fn parts_of_pi(range: &Range<f64>, count: usize) -> Vec<(f64, String)> {
    let turns = range.start / PI..range.end / PI;
    let rough = length(&turns) / count.clamp(1, MOST_LABELS) as f64;
    let part = [0.125, 0.25, 0.5, 1.0]
        .into_iter()
        .find(|part| *part >= 0.8 * rough);
    match part {
        Some(part) if part / 8.0 < rough => {
            let first = (turns.start / part - 1e-9).ceil() as i64;
            let last = (turns.end / part + 1e-9).floor() as i64;
            let eighths = (8.0 * part) as i64;
            (first..=last)
                .map(|k| (k as f64 * part * PI, angle(k * eighths)))
                .collect()
        }
        // The range has many turns, or a small part of a turn.
        _ => {
            let round = Round::of(&turns, count);
            let texts = series(&round.multiples, round.exponent);
            let texts = texts.into_iter().map(|text| match text.as_str() {
                "0" => text,
                "1" => "π".to_owned(),
                "−1" => "−π".to_owned(),
                _ => format!("{text}π"),
            });
            let places = round.floats().into_iter().map(|turns| turns * PI);
            places.zip(texts).collect()
        }
    }
}

/// Returns a number of eighths of π as text.
fn angle(eighths: i64) -> String {
    let (mut above, mut below) = (eighths, 8);
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

/// Returns the power of ten with this exponent.
fn power(exponent: f64) -> String {
    format!("10{}", superscript(exponent as i64))
}

#[cfg(test)]
#[path = "labels_tests.rs"]
mod tests;
