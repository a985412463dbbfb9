//! The statistics of a summary as a table: the columns of every format, and CSV.
//!
//! Input: a [`Summary`]. Output: a row for each recorded time with `t`, `paths` and, of each observable, `mean`, `variance`, `standard_error`, `min` and
//! `max`. Invariant: numbers are written with the digits that give back their bits; a number that does not exist is an empty field.

use std::io::{self, Write};
use std::path::Path;

use super::Summary;

/// A column of the table.
pub(super) enum Values {
    Counts(Vec<u64>),
    Numbers(Vec<f64>),
}

impl Summary {
    /// The columns of the table, with their names.
    pub(super) fn columns(&self) -> Vec<(String, Values)> {
        let mut columns = vec![
            ("t".to_owned(), Values::Numbers(self.times().to_vec())),
            ("paths".to_owned(), Values::Counts(self.counts().to_vec())),
        ];
        for s in self.statistics() {
            for (what, values) in [
                ("mean", s.mean().to_vec()),
                ("variance", s.variance()),
                ("standard_error", s.standard_error()),
                ("min", s.min().to_vec()),
                ("max", s.max().to_vec()),
            ] {
                let name = format!("{}_{what}", s.name());
                columns.push((name, Values::Numbers(values)));
            }
        }
        columns
    }

    /// Writes the statistics as CSV: a line of names, then one for each recorded time.
    ///
    /// The columns are `t`, `paths` (those that have not failed until then) and, for an observable called `x`, `x_mean`, `x_variance`,
    /// `x_standard_error`, `x_min`, `x_max`. A mean of no paths and a variance of one are empty fields.
    ///
    /// # Errors
    /// The errors of the writer.
    pub fn write_csv(&self, mut to: impl Write) -> io::Result<()> {
        let columns = self.columns();
        let names = columns.iter().map(|(name, _)| quoted(name));
        writeln!(to, "{}", names.collect::<Vec<_>>().join(","))?;
        for row in 0..self.times().len() {
            let field = |(_, values): &(String, Values)| match values {
                Values::Counts(counts) => counts[row].to_string(),
                Values::Numbers(numbers) if numbers[row].is_nan() => String::new(),
                Values::Numbers(numbers) => format!("{:?}", numbers[row]),
            };
            let fields: Vec<_> = columns.iter().map(field).collect();
            writeln!(to, "{}", fields.join(","))?;
        }
        to.flush()
    }

    /// Writes the statistics as CSV into a file; see [`write_csv`](Self::write_csv). The file is complete or not
    /// written at all: it replaces an existing one atomically.
    ///
    /// # Errors
    /// If the file cannot be written; the error names its path, and nothing of the file remains.
    pub fn to_csv(&self, path: impl AsRef<Path>) -> io::Result<()> {
        crate::file::write(path.as_ref(), |file| self.write_csv(file))
    }
}

/// Quotes a name as a field.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
