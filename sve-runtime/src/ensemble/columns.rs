//! The statistics of a summary as a table: the columns of every format.
//!
//! Input: a [`Summary`]. Output: a row for each recorded time with `t`, `paths` and, of each
//! observable, `mean`, `variance`, `standard_error`, `min` and `max`. Invariant: a number that does
//! not exist is NaN.

use super::Summary;
use crate::table::{Table, Values, table_writers};

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

    fn table(&self) -> Table {
        Table {
            name: "summary",
            columns: self.columns(),
        }
    }
}

table_writers!(
    Summary,
    "the statistics, a row for each recorded time with `t`, `paths` (those that have not failed until then) and, for an observable called `x`, `x_mean`, `x_variance`, `x_standard_error`, `x_min` and `x_max`,"
);
