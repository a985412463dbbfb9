//! Tables as CSV.
//!
//! Input: a table. Output: a line of names, then one line for each row. Invariant: numbers are
//! written with the digits that give back their bits; a number that does not exist is an empty
//! field.

use std::io::{self, Write};

use super::{Table, Values};

impl Table {
    pub(crate) fn write_csv(&self, mut to: impl Write) -> io::Result<()> {
        let names = self.columns.iter().map(|(name, _)| quoted(name));
        writeln!(to, "{}", names.collect::<Vec<_>>().join(","))?;
        for row in 0..self.rows() {
            let field = |(_, values): &(String, Values)| match values {
                Values::Counts(counts) => counts[row].to_string(),
                Values::Numbers(numbers) if numbers[row].is_nan() => String::new(),
                Values::Numbers(numbers) => format!("{:?}", numbers[row]),
            };
            let fields: Vec<_> = self.columns.iter().map(field).collect();
            writeln!(to, "{}", fields.join(","))?;
        }
        to.flush()
    }
}

/// Quotes a name as a field.
pub(crate) fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
