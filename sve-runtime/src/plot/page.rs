//! One HTML page without outside resources: figures inlined as SVG, numbers in tables.

use std::fmt::Write as _;

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

/// A table: a head, and rows with the class of each, which may be empty.
pub fn table<T: AsRef<str>>(head: &[&str], rows: &[(&str, Vec<T>)]) -> String {
    let mut text = String::from("<table>\n<thead>");
    row(&mut text, "<tr>", "th", head);
    text.push_str("</thead>\n<tbody>\n");
    for (class, cells) in rows {
        let open = if class.is_empty() {
            "<tr>".to_owned()
        } else {
            format!("<tr class=\"{class}\">")
        };
        row(&mut text, &open, "td", cells);
    }
    text.push_str("</tbody>\n</table>\n");
    text
}

fn row<T: AsRef<str>>(text: &mut String, open: &str, cell: &str, cells: &[T]) {
    text.push_str(open);
    for content in cells {
        // writing into a String cannot fail
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

/// Writes a page, or leaves the file as it was.
#[cfg(feature = "ensemble")]
pub(super) fn write(path: &std::path::Path, page: &str) -> Result<(), super::PlotError> {
    use std::io::Write as _;

    Ok(crate::file::write(path, |file| {
        file.write_all(page.as_bytes())
    })?)
}
