//! Measured numbers beside expected ones.
//!
//! A check has an expected value, a tolerance and the reason for the tolerance. A check that does
//! not apply to the options of a run reports the reason and cannot fail.

use std::fmt::Write as _;

use sve_runtime::plot::page;

/// One measured number.
#[derive(Clone, Debug)]
pub struct Check {
    /// The measured quantity.
    pub what: String,
    /// The measured value.
    pub measured: f64,
    /// The comparison with the expected value.
    pub verdict: Verdict,
}

/// The comparison of a measured number with its expected value.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// The number is compared with `expected`; it agrees if it is within `tolerance`.
    Compared {
        /// The expected value.
        expected: f64,
        /// Largest difference allowed.
        tolerance: f64,
        /// The reason for the value and the tolerance.
        reason: String,
    },
    /// The number is only reported, or the check does not apply with these options. The text gives
    /// the reason.
    Reported(String),
}

impl Check {
    /// Returns a measured number that is reported and not compared.
    pub fn new(what: impl Into<String>, measured: f64) -> Self {
        Self {
            what: what.into(),
            measured,
            verdict: Verdict::Reported(String::new()),
        }
    }

    /// Requires that the number is within `tolerance` of `expected`.
    #[must_use]
    pub fn near(mut self, expected: f64, tolerance: f64, reason: impl Into<String>) -> Self {
        self.verdict = Verdict::Compared {
            expected,
            tolerance,
            reason: reason.into(),
        };
        self
    }

    /// Reports the number without a comparison.
    #[must_use]
    pub fn reported(mut self, why: impl Into<String>) -> Self {
        self.verdict = Verdict::Reported(why.into());
        self
    }

    /// Keeps the comparison if `applies`; otherwise reports the number with the given reason.
    #[must_use]
    pub fn only_if(mut self, applies: bool, otherwise: &str) -> Self {
        if !applies {
            self.verdict = Verdict::Reported(format!("not applicable: {otherwise}"));
        }
        self
    }

    /// Returns whether the number was compared and does not agree. A number that is not finite
    /// agrees with nothing, and no number agrees where the tolerance is NaN.
    pub fn failed(&self) -> bool {
        match self.verdict {
            Verdict::Compared {
                expected,
                tolerance,
                ..
            } => {
                let agrees = (self.measured - expected).abs() <= tolerance;
                !agrees
            }
            Verdict::Reported(_) => false,
        }
    }

    /// Returns the cells of the row: quantity, measured, expected, allowed, verdict, reason.
    pub fn cells(&self) -> [String; 6] {
        let what = self.what.clone();
        match &self.verdict {
            Verdict::Compared {
                expected,
                tolerance,
                reason,
            } => [
                what,
                number(self.measured),
                number(*expected),
                format!("± {}", page::number(*tolerance, 2)),
                if self.failed() { "OFF" } else { "ok" }.to_owned(),
                reason.clone(),
            ],
            Verdict::Reported(why) => {
                let measured = if self.measured.is_finite() {
                    number(self.measured)
                } else {
                    "—".to_owned()
                };
                [
                    what,
                    measured,
                    String::new(),
                    String::new(),
                    "—".to_owned(),
                    why.clone(),
                ]
            }
        }
    }
}

/// Names of the columns of [`Check::cells`].
pub const COLUMNS: [&str; 6] = [
    "quantity", "measured", "expected", "allowed", "verdict", "reason",
];

/// Returns a number as a table shows it, with six significant digits.
pub fn number(x: f64) -> String {
    page::number(x, 6)
}

/// Returns the table of one figure as text. It omits the reasons if numbers agree, since lines have
/// to fit a terminal.
pub fn table(title: &str, checks: &[Check]) -> String {
    let row = |check: &Check| {
        let mut cells = check.cells();
        if !check.failed() && matches!(check.verdict, Verdict::Compared { .. }) {
            cells[5].clear();
        }
        cells
    };
    let rows: Vec<[String; 6]> = checks.iter().map(row).collect();
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.max().unwrap_or(0).max(COLUMNS[column].len())
    };
    let widths: [usize; 5] = std::array::from_fn(width);
    let mut text = format!("{title}\n");
    let mut line = |cells: [&str; 6]| {
        let [what, measured, expected, allowed, verdict, reason] = cells;
        let [a, b, c, d, e] = widths;
        // Writing into a String cannot fail.
        let line = format!(
            "  {what:a$}  {measured:>b$}  {expected:>c$}  {allowed:d$}  {verdict:e$}  {reason}"
        );
        let _ = writeln!(text, "{}", line.trim_end());
    };
    let [what, measured, expected, allowed, verdict, _] = COLUMNS;
    line([what, measured, expected, allowed, verdict, ""]);
    for row in &rows {
        line(row.each_ref().map(String::as_str));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_agrees_with_nothing() {
        assert!(Check::new("x", f64::NAN).near(0.0, 1.0, "").failed());
        assert!(Check::new("x", 0.0).near(0.0, f64::NAN, "").failed());
        assert!(
            Check::new("x", f64::INFINITY)
                .near(0.0, f64::MAX, "")
                .failed()
        );
        assert!(!Check::new("x", 1.0).near(0.5, 0.5, "").failed());
        assert!(
            !Check::new("x", 9.0)
                .near(0.0, 1.0, "")
                .only_if(false, "short run")
                .failed()
        );
    }

    #[test]
    fn numbers_of_a_table_have_a_minus_and_powers() {
        let check = Check::new("x", -5.294_962_7).near(-5.3, 0.000_05, "");
        let text = table("t", &[check, Check::new("y", 1.471_76e87)]);
        assert!(
            text.contains("−5.29496") && text.contains("± 5·10⁻⁵"),
            "{text}"
        );
        assert!(text.contains("1.47176·10⁸⁷"), "{text}");
    }
}
