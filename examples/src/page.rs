//! One HTML page without outside resources: figures inlined as SVG, numbers in tables.

use std::fmt::Write as _;

use sve_runtime::plot::page as plot;
pub use sve_runtime::plot::page::{document, escape};

use crate::check::{COLUMNS, Check};

/// A figure on the page.
#[derive(Clone, Debug)]
pub struct Section<'a> {
    /// Heading.
    pub title: &'a str,
    /// SVG document of the figure.
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

fn table(checks: &[Check]) -> String {
    let class = |check: &Check| if check.failed() { "off" } else { "" };
    let rows: Vec<_> = checks
        .iter()
        .map(|check| (class(check), check.cells().to_vec()))
        .collect();
    plot::table(&COLUMNS, &rows)
}
