//! The table: rows with verdicts, found and expected.

use std::error::Error;
use std::path::Path;
use std::time::Duration;
use std::{fmt, fs};

use indicatif::{ProgressBar, ProgressStyle};
use sve_examples::figure::Figure;
use sve_examples::{page, render};
use sve_runtime::plot::page::table;

/// The outcome of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The quantities that have to be bounded or conserved are.
    Holds,
    /// The method leaves its range: the energy grows without bound.
    BlowsUp,
    /// A step ended with an error that names the place.
    Stops,
    /// Steps were finite, but the orbit is wrong.
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
pub(super) struct Table {
    rows: Vec<Row>,
    bar: ProgressBar,
}

impl Table {
    pub(super) fn new() -> Self {
        Self {
            rows: Vec::new(),
            bar: ProgressBar::no_length().with_style(ProgressStyle::default_spinner()),
        }
    }

    /// Shows which case is computed now.
    pub(super) fn begin(&self, case: &'static str) {
        self.bar.enable_steady_tick(Duration::from_millis(200));
        self.bar
            .set_message(format!("{} rows; {case}", self.rows.len()));
    }

    /// Adds a row: the case with its difficulty, the method, the expected verdict, and the outcome.
    pub(super) fn add(
        &mut self,
        [case, hard, method]: [&'static str; 3],
        expected: Verdict,
        (found, numbers): (Verdict, String),
    ) {
        self.rows.push(Row {
            case,
            hard,
            method,
            found,
            expected,
            numbers,
        });
    }

    /// Prints the rows. Returns whether every verdict is the expected one.
    pub(super) fn print(&self) -> bool {
        self.bar.finish_and_clear();
        let width = |text: fn(&Row) -> &str| {
            let longest = self.rows.iter().map(|row| text(row).chars().count()).max();
            longest.unwrap_or(0)
        };
        let widths = [width(|r| r.case), width(|r| r.hard), width(|r| r.method)];
        let [case, hard, method] = widths;
        println!(
            "{:case$}  {:hard$}  {:method$}  {:10}  numbers",
            "case", "what makes it hard", "method", "verdict"
        );
        let mut good = true;
        for row in &self.rows {
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

    /// Writes the page with the figure and the rows; verdicts that are not as expected are marked.
    pub(super) fn write(&self, figure: &Figure) -> Result<(), Box<dyn Error>> {
        let row = |row: &Row| {
            let expected = if row.found == row.expected { "" } else { "off" };
            let cells = [row.case, row.method, row.hard].map(str::to_owned);
            let verdict = [row.found.to_string(), row.numbers.clone()];
            (expected, cells.into_iter().chain(verdict).collect())
        };
        let rows: Vec<(&str, Vec<String>)> = self.rows.iter().map(row).collect();
        let head = ["case", "method", "what makes it hard", "verdict", "numbers"];
        let caption = "A line ends where the energy first grows without bound.";
        let body = format!(
            "<figure>\n{}\n<figcaption>{caption}</figcaption>\n</figure>\n{}",
            render::panels(figure)?,
            table(&head, &rows)
        );
        let folder = Path::new("target").join(figure.name);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join("hard_cases.png"), render::png(figure)?)?;
        let path = folder.join("index.html");
        fs::write(&path, page::document("Hard cases", &body))?;
        println!("page: {}", path.display());
        Ok(())
    }
}
