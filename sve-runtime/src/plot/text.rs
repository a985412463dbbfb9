//! Texts of figures: their widths in the embedded font, and their division into lines.
//!
//! Input: a text with its size. Output: widths and lines in CSS pixels. Invariant: no line is wider
//! than the given width, unless a single character is wider.

use std::sync::Once;

use plotters::style::{FontDesc, FontStyle, IntoFont, register_font};

use super::numbers::exponent_digit;
use super::render::SCALE;

/// Height of a line of text, in units of its size.
pub(super) const LINE: f64 = 1.24;

/// Sizes of labels, names and titles, in CSS pixels.
pub(super) const LABEL: f64 = 11.0;
pub(super) const NAME: f64 = 12.0;
pub(super) const TITLE: f64 = 13.0;

/// Size of exponents, and the height of their baseline above the one of their text, in units of the
/// size of the text. The superscripts of fonts are half as high as their digits, and 10⁰ is not
/// distinguishable from 10°.
pub(super) const EXPONENT: f64 = 0.8;
pub(super) const RAISED: f64 = 0.4;

/// A part of a text: whether it is an exponent, and its characters. Exponents have ordinary digits.
pub(super) type Part = (bool, String);

/// Divides a text into exponents and the parts between them.
pub(super) fn parts(text: &str) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    for character in text.chars() {
        let digit = exponent_digit(character);
        match parts.last_mut() {
            Some((is_raised, part)) if *is_raised == digit.is_some() => {
                part.push(digit.unwrap_or(character));
            }
            _ => parts.push((digit.is_some(), digit.unwrap_or(character).into())),
        }
    }
    parts
}

/// Registers the embedded font, so that no font of the machine is used.
pub(super) fn prepare_font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for (style, font) in [
            (FontStyle::Normal, dejavu::sans::regular()),
            (FontStyle::Bold, dejavu::sans::bold()),
        ] {
            // The bytes are part of the program: a font that does not parse causes an error at the
            // first text.
            let _ = register_font("sans-serif", style, font);
        }
    });
}

/// Returns the font of a size; plotters measures a font by its line height.
pub(super) fn font(size: f64) -> FontDesc<'static> {
    ("sans-serif", LINE * size * f64::from(SCALE)).into_font()
}

/// Returns the font of a part of a text of this size.
pub(super) fn font_of((is_raised, _): &Part, size: f64) -> FontDesc<'static> {
    font(if *is_raised { EXPONENT * size } else { size })
}

/// Returns the width of a text.
pub(super) fn width(text: &str, size: f64) -> f64 {
    prepare_font();
    let widths = parts(text).into_iter().map(|part| {
        // A text without a size is an error where it is drawn.
        let (width, _) = font_of(&part, size).box_size(&part.1).unwrap_or_default();
        f64::from(width) / f64::from(SCALE)
    });
    widths.sum()
}

/// Divides a text into lines of at most this width: between words, not at a no-break space, or
/// within a word that is longer than a line. If the text needs more than `most` lines, the rest is
/// left out, and the last line ends with `…`.
pub(super) fn lines(text: &str, size: f64, widest: f64, most: usize) -> Vec<String> {
    let fits = |text: &str| width(text, size) <= widest;
    let mut lines = vec![String::new()];
    for word in text.split_ascii_whitespace() {
        let last = lines.last_mut().map_or(String::new(), std::mem::take);
        let joined = if last.is_empty() {
            word.to_owned()
        } else {
            format!("{last} {word}")
        };
        lines.pop();
        if fits(&joined) {
            lines.push(joined);
            continue;
        }
        if !last.is_empty() {
            lines.push(last);
        }
        let mut part = String::new();
        for character in word.chars() {
            part.push(character);
            if part.chars().count() > 1 && !fits(&part) {
                part.pop();
                lines.push(std::mem::replace(&mut part, character.to_string()));
            }
        }
        lines.push(part);
    }
    if lines.len() > most.max(1) {
        lines.truncate(most.max(1));
        if let Some(last) = lines.last_mut() {
            last.push('…');
            while last.chars().count() > 2 && !fits(last) {
                last.pop();
                last.pop();
                last.push('…');
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_parts_of_their_own() {
        let parts = |text| -> Vec<(bool, String)> { super::parts(text) };
        let (plain, raised) = (
            |text: &str| (false, text.into()),
            |text: &str| (true, text.into()),
        );
        assert_eq!(parts("10⁻¹² m"), [plain("10"), raised("−12"), plain(" m")]);
        assert_eq!(parts("q₀²"), [plain("q₀"), raised("2")]);
        assert!(parts("").is_empty());
        assert!(width("10⁰", LABEL) > width("10", LABEL) + 0.7 * width("0", LABEL));
    }

    #[test]
    fn long_texts_are_divided_between_words_and_within_long_ones() {
        assert_eq!(lines("two words", NAME, 500.0, 3), ["two words"]);
        assert_eq!(lines("two words", NAME, 45.0, 3), ["two", "words"]);
        assert_eq!(lines("", NAME, 45.0, 3), [""]);
        assert_eq!(
            lines("at h\u{a0}=\u{a0}1", NAME, 45.0, 3),
            ["at", "h\u{a0}=\u{a0}1"]
        );
        let name = "a_long_name_of_an_observable_without_any_space_in_it";
        let parts = lines(name, NAME, 90.0, 9);
        assert_eq!(parts.concat(), name);
        assert!(parts.len() > 2 && parts.iter().all(|part| width(part, NAME) <= 90.0));
        let short = lines(name, NAME, 90.0, 2);
        assert_eq!(short[0], parts[0]);
        assert!(short.len() == 2 && short[1].ends_with('…') && width(&short[1], NAME) <= 90.0);
        // The division ends for every width.
        assert_eq!(lines("ab", NAME, 0.0, 9), ["a", "b"]);
    }
}
