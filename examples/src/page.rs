//! One HTML page without outside resources: figures inlined as SVG, numbers in tables.

use std::fmt::Write as _;

use sve_runtime::plot::page as plot;
pub use sve_runtime::plot::page::{document, escape};

use crate::check::{COLUMNS, Check};

/// The column of the reasons, and the length of a reason that may stand in many rows.
const REASON: usize = 5;
const SHORT: usize = 30;

/// A figure on the page.
#[derive(Clone, Debug)]
pub struct Section<'a> {
    /// Heading.
    pub title: &'a str,
    /// SVG document of the figure, or the documents of its panels in markup.
    pub svg: &'a str,
    /// Text under the figure; may contain markup.
    pub caption: &'a str,
    /// Numbers of the figure.
    pub checks: &'a [Check],
}

/// Returns a page of figures with their numbers. A figure with the title of the page has no heading
/// of its own. `head` and `foot` may contain markup.
pub fn html(title: &str, head: &str, sections: &[Section<'_>], foot: &str) -> String {
    let mut body = format!("{head}\n");
    for section in sections {
        let heading = if section.title == title {
            String::new()
        } else {
            format!("<h2>{}</h2>\n", escape(section.title))
        };
        // Writing into a String cannot fail.
        let _ = write!(
            body,
            "<section>\n{heading}<figure>\n{}\n<figcaption>{}</figcaption>\n</figure>\n{}</section>\n",
            section.svg,
            section.caption,
            table(section.checks)
        );
    }
    body.push_str(foot);
    document(title, &body)
}

/// Returns the table of the numbers. A reason of several rows stands below the table, once.
fn table(checks: &[Check]) -> String {
    let class = |check: &Check| if check.failed() { "off" } else { "" };
    let rows = checks.iter();
    let mut rows: Vec<_> = rows.map(|check| (class(check), check.cells())).collect();
    let mut shared: Vec<String> = Vec::new();
    for (_, cells) in &rows {
        let reason = &cells[REASON];
        let count = rows.iter().filter(|row| row.1[REASON] == *reason).count();
        if count > 2 && reason.len() > SHORT && !shared.contains(reason) {
            shared.push(reason.clone());
        }
    }
    for (_, cells) in &mut rows {
        if let Some(k) = shared.iter().position(|reason| *reason == cells[REASON]) {
            cells[REASON] = format!("[{}]", k + 1);
        }
    }
    let rows: Vec<_> = rows
        .into_iter()
        .map(|(class, cells)| (class, cells.to_vec()))
        .collect();
    let mut text = plot::table(&COLUMNS, &rows);
    for (k, reason) in shared.iter().enumerate() {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "<p>[{}] {}</p>", k + 1, escape(reason));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_of_many_rows_stands_below_the_table_once() {
        let why = "moment recursion; 4.1 standard errors allowed";
        let checks = [-1.5, 2.0, 3e-9].map(|x| Check::new("x", x).near(x, 1e-7, why));
        let text = table(&checks);
        assert_eq!(text.matches(why).count(), 1, "{text}");
        assert_eq!(text.matches("[1]").count(), 4, "{text}");
        assert!(text.contains("−1.5") && text.contains("3·10⁻⁹"), "{text}");
        assert_eq!(table(&checks[..2]).matches(why).count(), 2);
    }
}
