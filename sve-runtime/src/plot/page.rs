//! One HTML page without outside resources: figures inlined as SVG, numbers in tables.

use std::fmt::Write as _;

#[cfg(feature = "ensemble")]
use super::figure::Figure;
use super::numbers::is_number;
#[cfg(feature = "ensemble")]
pub(super) use super::numbers::{exact, number_beside};
pub use super::numbers::{number, with_error};
#[cfg(feature = "ensemble")]
use crate::description::SystemDescription;

const STYLE: &str = "
body { font: 16px/1.5 sans-serif; max-width: 1160px; margin: 2rem auto; padding: 0 1rem; color: #111; background: #fff; overflow-wrap: anywhere }
figure { margin: 1rem 0 }
svg { max-width: 100%; height: auto }
figcaption { max-width: 75ch }
.panels { display: flex; flex-wrap: wrap; gap: 0 1rem; align-items: flex-start }
.wide { overflow-x: auto }
.warning { border-left: 4px solid #d55e00; padding-left: .75rem; max-width: 75ch }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; margin: 1rem 0 2rem }
th, td { text-align: left; padding: .25rem .75rem .25rem 0; border-bottom: 1px solid #ccc; vertical-align: top }
.number { text-align: right }
th, .number { overflow-wrap: normal }
td.number { white-space: nowrap }
.wide td:first-child, .wide th:first-child { min-width: 9rem }
.facts th { font-weight: normal; color: #555; white-space: nowrap }
code { font-size: inherit }
.off td { font-weight: bold; background: #fbe3d6 }
@media print { section { break-inside: avoid } }
";

/// The text in a table for a missing number.
pub(super) const NONE: &str = "–";

/// Returns a page with a body of any markup.
pub fn document(title: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}\n</body>\n</html>\n"
    )
}

/// Returns a table of names and their values.
#[cfg(feature = "ensemble")]
pub(super) fn facts(facts: &[(&str, String)]) -> String {
    let mut text = String::from("<table class=\"facts\">\n<tbody>\n");
    for (name, value) in facts {
        // Writing into a String cannot fail.
        let _ = writeln!(
            text,
            "<tr><th>{}</th><td>{}</td></tr>",
            escape(name),
            with_code(value)
        );
    }
    text.push_str("</tbody>\n</table>\n");
    text
}

/// Returns the description of a system.
#[cfg(feature = "ensemble")]
pub(super) fn facts_of_system(system: &SystemDescription) -> Vec<(&'static str, String)> {
    let mut facts = vec![("system", format!("`{}`", system.name))];
    let values = system.parameters.iter().zip(&system.values);
    let mut parameters: Vec<_> = values
        .map(|(name, &value)| format!("`{name}` = {}", exact(value)))
        .collect();
    if system.others > 0 {
        parameters.push(format!("and {} more", system.others));
    }
    if !parameters.is_empty() {
        facts.push(("parameters", parameters.join(", ")));
    }
    facts
}

/// Returns the text of a number that may be missing.
#[cfg(feature = "ensemble")]
pub(super) fn known(value: Option<f64>, digits: usize) -> String {
    let value = value.filter(|value| !value.is_nan());
    value.map_or_else(|| NONE.to_owned(), |value| number(value, digits))
}

/// Returns the text of a number and its standard error, which may be missing.
#[cfg(feature = "ensemble")]
pub(super) fn known_with_error(value: Option<f64>, error: Option<f64>) -> [String; 2] {
    let known = |value: Option<f64>| value.filter(|value| !value.is_nan());
    match (known(value), known(error)) {
        (Some(value), Some(error)) => with_error(value, error).into(),
        (value, _) => [self::known(value, 6), NONE.to_owned()],
    }
}

/// Returns the text of a count with its noun.
#[cfg(feature = "ensemble")]
pub(super) fn count(number: u64, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{plural}")
}

/// Least width of a picture on a page, as a fraction of its own width: the texts of a picture that
/// is smaller are too small to be read.
const LEAST: f64 = 0.75;

/// Returns markup with an SVG document of this width in CSS pixels, which scrolls on a page that is
/// too narrow for it.
///
/// ```
/// use sve_runtime::plot::page::picture;
/// assert!(picture("<svg width=\"760\"></svg>", 760).contains("min-width: 570px"));
/// ```
pub fn picture(svg: &str, width: u32) -> String {
    let least = LEAST * f64::from(width);
    let sized = format!("<svg style=\"min-width: {least:.0}px\" ");
    let svg = svg.replacen("<svg ", &sized, 1);
    format!("<div class=\"wide\" style=\"max-width: 100%\">{svg}</div>\n")
}

/// Returns figures beside one another, as many as the page has room for, with a text.
#[cfg(feature = "ensemble")]
pub(super) fn panels(figures: &[Figure], caption: &str) -> Result<String, super::PlotError> {
    let mut text = String::from("<figure>\n<div class=\"panels\">\n");
    for figure in figures {
        text += &picture(&super::render::svg(figure)?, figure.width);
    }
    text += "</div>\n<figcaption>";
    text += &escape(caption);
    text += "</figcaption>\n</figure>\n";
    Ok(text)
}

/// Returns a table: a head, and rows with the class of each row, which may be empty. Columns of
/// numbers are aligned to the right, words between backticks are code.
pub fn table<T: AsRef<str>>(head: &[&str], rows: &[(&str, Vec<T>)]) -> String {
    let numbers: Vec<bool> = (0..head.len())
        .map(|column| {
            let cells = rows.iter().filter_map(|(_, cells)| cells.get(column));
            let mut cells = cells
                .map(AsRef::as_ref)
                .filter(|cell| !["", NONE].contains(cell));
            let mut has_numbers = false;
            cells.all(|cell| {
                has_numbers = true;
                is_number(cell)
            }) && has_numbers
        })
        .collect();
    let mut text = String::from("<div class=\"wide\"><table>\n<thead>");
    row(&mut text, "<tr>", "th", head, &numbers);
    text.push_str("</thead>\n<tbody>\n");
    for (class, cells) in rows {
        let open = if class.is_empty() {
            "<tr>".to_owned()
        } else {
            format!("<tr class=\"{class}\">")
        };
        row(&mut text, &open, "td", cells, &numbers);
    }
    text.push_str("</tbody>\n</table></div>\n");
    text
}

fn row<T: AsRef<str>>(text: &mut String, open: &str, cell: &str, cells: &[T], numbers: &[bool]) {
    text.push_str(open);
    for (column, content) in cells.iter().enumerate() {
        let class = if numbers.get(column) == Some(&true) {
            " class=\"number\""
        } else {
            ""
        };
        // Writing into a String cannot fail.
        let _ = write!(
            text,
            "<{cell}{class}>{}</{cell}>",
            with_code(content.as_ref())
        );
    }
    text.push_str("</tr>\n");
}

/// Returns a text as markup: a part between backticks is code. A backtick without a second one is
/// kept.
fn with_code(text: &str) -> String {
    let parts: Vec<String> = text.split('`').map(escape).collect();
    if parts.len().is_multiple_of(2) {
        return escape(text);
    }
    let parts = parts.into_iter().enumerate();
    parts
        .map(|(i, part)| {
            if i % 2 == 1 {
                format!("<code>{part}</code>")
            } else {
                part
            }
        })
        .collect()
}

/// Returns a text with the special characters of HTML escaped.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// Writes a page. If this fails, the file is unchanged.
#[cfg(feature = "ensemble")]
pub(super) fn write(path: &std::path::Path, page: &str) -> Result<(), super::PlotError> {
    use std::io::Write as _;

    Ok(crate::file::write(path, |file| {
        file.write_all(page.as_bytes())
    })?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_numbers_are_marked_and_words_between_backticks_are_code() {
        let rows = [
            ("", vec!["`midpoint`", "−1.5e-3", "± 2", "holds"]),
            ("off", vec!["a ` < b", "", "± 3", "2"]),
        ];
        let text = table(&["rule", "measured", "allowed", "verdict"], &rows);
        assert!(text.contains("<th>rule</th><th class=\"number\">measured</th>"));
        assert!(text.contains("<td><code>midpoint</code></td><td class=\"number\">−1.5e-3</td>"));
        assert!(text.contains("<td>a ` &lt; b</td><td class=\"number\"></td>"));
        assert!(text.contains("<td class=\"number\">± 3</td><td>2</td>"));
    }
}
