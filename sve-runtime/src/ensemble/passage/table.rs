//! First passages as a table: the columns of every format.
//!
//! Input: [`Passages`]. Output: a row for each recorded time. Invariant: in each row `passed`,
//! `censored` and `at_risk` sum up to all paths; a number that is unknown is NaN.

use super::Passages;
use crate::table::{Table, Values, table_writers};

impl Passages {
    fn table(&self) -> Table {
        let counts = [
            ("passed", self.passed()),
            ("censored", self.censored()),
            ("at_risk", self.at_risk()),
        ];
        let known = |values: Vec<Option<f64>>| {
            let values = values.into_iter();
            values.map(|value| value.unwrap_or(f64::NAN)).collect()
        };
        let numbers = [
            ("survival", known(self.survival())),
            ("survival_standard_error", known(self.survival_error())),
        ];
        let mut columns = vec![("t".to_owned(), Values::Numbers(self.times().to_vec()))];
        columns.extend(counts.map(|(name, counts)| (name.to_owned(), Values::Counts(counts))));
        columns.extend(numbers.map(|(name, values)| (name.to_owned(), Values::Numbers(values))));
        let name = "passages";
        Table { name, columns }
    }
}

table_writers!(
    Passages,
    "the passages, a row for each recorded time with `t`, the paths that have `passed`, those `censored` and those still `at_risk`, `survival` and `survival_standard_error`,"
);
