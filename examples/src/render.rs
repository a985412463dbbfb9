//! Figures as SVG and PNG, drawn if no two of their series differ by their hue alone.

use sve_runtime::plot::figure::{Figure, Row};
use sve_runtime::plot::{PlotError, page, render};

/// Returns the figure as an SVG document that can also stand inside an HTML page.
///
/// # Errors
/// If it cannot be drawn, or two of its series differ by their hue alone.
pub fn svg(figure: &Figure) -> Result<String, PlotError> {
    figure.check_series()?;
    render::svg(figure)
}

/// Returns the panels of a figure as SVG documents in markup, a row beside one another if the page
/// is wide enough, so that texts keep their size on a narrow page.
///
/// # Errors
/// If a panel cannot be drawn, or two of its series differ by their hue alone.
pub fn panels(figure: &Figure) -> Result<String, PlotError> {
    let mut text = String::new();
    for row in &figure.rows {
        text.push_str("<div class=\"panels\" style=\"gap: 0\">\n");
        let count = u32::try_from(row.panels.len()).unwrap_or(1).max(1);
        for panel in &row.panels {
            let panels = vec![panel.clone()];
            let single = Figure {
                name: figure.name,
                width: figure.width / count,
                rows: vec![Row {
                    height: row.height,
                    panels,
                }],
            };
            text += &page::picture(&svg(&single)?, single.width);
        }
        text.push_str("</div>\n");
    }
    Ok(text)
}

/// Returns the figure as a PNG file.
///
/// # Errors
/// If it cannot be drawn, or two of its series differ by their hue alone.
pub fn png(figure: &Figure) -> Result<Vec<u8>, PlotError> {
    figure.check_series()?;
    render::png(figure)
}
