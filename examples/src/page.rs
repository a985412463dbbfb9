//! One HTML page without outside resources: figures inlined as SVG, numbers in tables.

use std::fmt::Write as _;

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
    /// Its numbers.
    pub checks: &'a [Check],
}

const STYLE: &str = "
body { font: 16px/1.5 sans-serif; max-width: 1160px; margin: 2rem auto; padding: 0 1rem; color: #111; background: #fff }
figure { margin: 1rem 0 }
svg { max-width: 100%; height: auto }
figcaption { max-width: 75ch }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; margin: 1rem 0 2rem }
th, td { text-align: left; padding: .25rem .75rem .25rem 0; border-bottom: 1px solid #ccc; vertical-align: top }
td:nth-child(2), td:nth-child(3), th:nth-child(2), th:nth-child(3) { text-align: right }
td:nth-child(2), td:nth-child(3), td:nth-child(4) { white-space: nowrap }
.off td { font-weight: bold; background: #fbe3d6 }
@media print { section { break-inside: avoid } }
";

/// A page with a body of any markup.
pub fn document(title: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}\n</body>\n</html>\n"
    )
}

/// A page of figures with their numbers. `head` and `foot` may contain markup.
pub fn html(title: &str, head: &str, sections: &[Section<'_>], foot: &str) -> String {
    let mut body = format!("{head}\n");
    for section in sections {
        // writing into a String cannot fail
        let _ = write!(
            body,
            "<section>\n<h2>{}</h2>\n<figure>\n{}\n<figcaption>{}</figcaption>\n</figure>\n{}</section>\n",
            escape(section.title),
            section.svg,
            section.caption,
            table(section.checks)
        );
    }
    body.push_str(foot);
    document(title, &body)
}

fn table(checks: &[Check]) -> String {
    let mut text = String::from("<table>\n<thead>");
    row(&mut text, "<tr>", "th", &COLUMNS);
    text.push_str("</thead>\n<tbody>\n");
    for check in checks {
        let open = if check.failed() {
            "<tr class=\"off\">"
        } else {
            "<tr>"
        };
        row(&mut text, open, "td", &check.cells());
    }
    text.push_str("</tbody>\n</table>\n");
    text
}

fn row<T: AsRef<str>>(text: &mut String, open: &str, cell: &str, cells: &[T]) {
    text.push_str(open);
    for content in cells {
        let _ = write!(text, "<{cell}>{}</{cell}>", escape(content.as_ref()));
    }
    text.push_str("</tr>\n");
}

/// Text with the characters escaped that HTML gives a meaning.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
