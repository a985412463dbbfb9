//! A reader of printed formulas by the usual rules of precedence, for tests of formulas that users
//! see.
//!
//! Input: a formula and the values of its names. Output: its value, or `None` if a name or a
//! function is unknown. The reader shares no code with the printer of formulas.

use std::collections::HashMap;
use std::iter::Peekable;
use std::str::Chars;

const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/// Returns the value of a formula.
pub(crate) fn read(text: &str, values: &HashMap<String, f64>) -> Option<f64> {
    let mut reader = Reader {
        rest: text.chars().peekable(),
        values,
    };
    let value = reader.sum()?;
    assert_eq!(reader.rest.next(), None, "the end of {text}");
    Some(value)
}

struct Reader<'a> {
    rest: Peekable<Chars<'a>>,
    values: &'a HashMap<String, f64>,
}

impl Reader<'_> {
    fn takes(&mut self, c: char) -> bool {
        self.rest.next_if_eq(&c).is_some()
    }

    fn word(&mut self, wanted: impl Fn(char) -> bool) -> String {
        let mut word = String::new();
        while let Some(c) = self.rest.next_if(|&c| wanted(c)) {
            word.push(c);
        }
        word
    }

    fn sum(&mut self) -> Option<f64> {
        let mut value = if self.takes('−') {
            -self.term()?
        } else {
            self.term()?
        };
        while self.takes(' ') {
            let subtract = self.rest.next() == Some('−');
            assert!(self.takes(' '));
            let term = self.term()?;
            value = if subtract { value - term } else { value + term };
        }
        Some(value)
    }

    fn term(&mut self) -> Option<f64> {
        let mut value = self.power()?;
        loop {
            if self.takes('·') {
                value *= self.power()?;
            } else if self.takes('/') {
                value /= self.power()?;
            } else {
                return Some(value);
            }
        }
    }

    fn power(&mut self) -> Option<f64> {
        let base = self.atom()?;
        if self.takes('^') {
            return Some(base.powf(self.atom()?));
        }
        let raised = self.word(|c| c == '⁻' || RAISED.contains(c));
        let mut exponent = 0;
        for c in raised.chars().filter(|&c| c != '⁻') {
            let digit = RAISED.chars().position(|d| d == c);
            exponent = 10 * exponent + i32::try_from(digit?).ok()?;
        }
        Some(match raised.as_str() {
            "" => base,
            _ if raised.starts_with('⁻') => base.powi(-exponent),
            _ => base.powi(exponent),
        })
    }

    fn atom(&mut self) -> Option<f64> {
        match self.rest.peek()? {
            '(' => {
                self.takes('(');
                let value = self.sum()?;
                assert!(self.takes(')'));
                Some(value)
            }
            '√' => {
                self.takes('√');
                Some(self.atom()?.sqrt())
            }
            '∛' => {
                self.takes('∛');
                Some(self.atom()?.cbrt())
            }
            c if c.is_ascii_digit() => {
                let number = self.word(|c| c.is_ascii_digit() || c == '.');
                number.parse().ok()
            }
            _ => self.named(),
        }
    }

    fn named(&mut self) -> Option<f64> {
        let is_part = |c: char| c.is_alphanumeric() && !RAISED.contains(c);
        // letters with a bar or a hat are two characters each
        let name = self.word(|c| is_part(c) || "_.[]\u{304}\u{302}".contains(c));
        if !self.takes('(') {
            return match name.as_str() {
                "π" => Some(std::f64::consts::PI),
                _ => self.values.get(&name).copied(),
            };
        }
        let x = self.sum()?;
        let y = if self.takes(',') {
            assert!(self.takes(' '));
            Some(self.sum()?)
        } else {
            None
        };
        assert!(self.takes(')'));
        apply(&name, x, y)
    }
}

fn apply(name: &str, x: f64, y: Option<f64>) -> Option<f64> {
    Some(match (name, y) {
        ("atan2", Some(y)) => x.atan2(y),
        ("hypot", Some(y)) => x.hypot(y),
        ("exp", None) => x.exp(),
        ("ln", None) => x.ln(),
        ("log₂", None) => x.log2(),
        ("log₁₀", None) => x.log10(),
        ("sin", None) => x.sin(),
        ("cos", None) => x.cos(),
        ("tan", None) => x.tan(),
        ("asin", None) => x.asin(),
        ("acos", None) => x.acos(),
        ("atan", None) => x.atan(),
        ("sinh", None) => x.sinh(),
        ("cosh", None) => x.cosh(),
        ("tanh", None) => x.tanh(),
        ("asinh", None) => x.asinh(),
        ("acosh", None) => x.acosh(),
        ("atanh", None) => x.atanh(),
        _ => return None,
    })
}
