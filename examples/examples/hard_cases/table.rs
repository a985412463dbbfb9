//! The table: rows with verdicts, found and expected.

use std::fmt;

/// The outcome of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// What has to be bounded or conserved is.
    Holds,
    /// The method leaves its range: the energy grows without bound.
    BlowsUp,
    /// A step ended with an error that names the place.
    Stops,
    /// Steps were finite, and the orbit is a wrong one.
    Unresolved,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Holds => "holds",
            Self::BlowsUp => "blows up",
            Self::Stops => "stops",
            Self::Unresolved => "unresolved",
        })
    }
}

struct Row {
    case: &'static str,
    hard: &'static str,
    method: &'static str,
    found: Verdict,
    expected: Verdict,
    numbers: String,
}

/// The rows so far.
#[derive(Default)]
pub(super) struct Table(Vec<Row>);

impl Table {
    /// Adds a row: the case with what makes it hard, the method, the verdict expected, and what came out.
    pub(super) fn add(
        &mut self,
        [case, hard, method]: [&'static str; 3],
        expected: Verdict,
        (found, numbers): (Verdict, String),
    ) {
        self.0.push(Row {
            case,
            hard,
            method,
            found,
            expected,
            numbers,
        });
    }

    /// Prints the rows; whether every verdict is the expected one.
    pub(super) fn print(&self) -> bool {
        let width = |text: fn(&Row) -> &str| {
            let longest = self.0.iter().map(|row| text(row).chars().count()).max();
            longest.unwrap_or(0)
        };
        let widths = [width(|r| r.case), width(|r| r.hard), width(|r| r.method)];
        let [case, hard, method] = widths;
        println!(
            "{:case$}  {:hard$}  {:method$}  {:10}  numbers",
            "case", "what makes it hard", "method", "verdict"
        );
        let mut good = true;
        for row in &self.0 {
            let as_expected = row.found == row.expected;
            good &= as_expected;
            print!(
                "{:case$}  {:hard$}  {:method$}  {:10}  {}",
                row.case, row.hard, row.method, row.found, row.numbers
            );
            if as_expected {
                println!();
            } else {
                println!("  << expected: {}", row.expected);
            }
        }
        good
    }
}
