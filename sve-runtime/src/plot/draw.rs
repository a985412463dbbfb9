//! Draws a figure on any backend of plotters.
//!
//! All lengths of [`figure`](super::figure) are in CSS pixels; [`px`] converts them to device
//! units.

use std::error::Error;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axes::Frame;
use super::clip;
use super::figure::{Figure, Layer, Panel, Pen, Shape, Symbols};
use super::palette;
use super::render::SCALE;
use super::spread;
use super::text::{self, LABEL};

type Outcome = Result<(), Box<dyn Error>>;
/// An area of device units.
pub(crate) type Area<DB> = DrawingArea<DB, Shift>;

/// Largest number of dots of one layer in an SVG, where each takes sixty bytes.
const DOTS: usize = 2_000;

/// The number of points that are drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Detail {
    /// All points.
    Full,
    /// The points that are distinguishable at the size of the figure: vector files grow with each
    /// point.
    Thinned,
}

/// Returns the device units of a length in CSS pixels.
pub(crate) fn px(length: f64) -> i32 {
    (length * f64::from(SCALE)).round() as i32
}

/// Returns a line of a width in CSS pixels.
pub(crate) fn stroke(color: palette::Color, width: f64) -> ShapeStyle {
    rgb(color).stroke_width(px(width).unsigned_abs().max(1))
}

pub(crate) fn rgb((r, g, b): palette::Color) -> RGBColor {
    RGBColor(r, g, b)
}

/// Returns text of a size in CSS pixels.
pub(crate) fn font(size: f64, color: palette::Color) -> TextStyle<'static> {
    text::font(size).color(&rgb(color))
}

/// Draws the whole figure.
pub(crate) fn figure<DB>(area: &Area<DB>, figure: &Figure, detail: Detail) -> Outcome
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    area.fill(&WHITE)?;
    let mut rest = area.clone();
    for row in &figure.rows {
        let (this, below) = rest.split_vertically(px(f64::from(row.height)));
        let areas = this.split_evenly((1, row.panels.len()));
        for (area, panel) in areas.iter().zip(&row.panels) {
            draw_panel(area, panel, detail)?;
        }
        rest = below;
    }
    Ok(())
}

fn draw_panel<DB>(area: &Area<DB>, panel: &Panel, detail: Detail) -> Outcome
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let frame = Frame::new(panel, area.dim_in_pixel())?;
    // Areas are drawn under all lines.
    for layer in &panel.layers {
        spread::draw(area, &frame, layer)?;
    }
    for layer in &panel.layers {
        draw_layer(area, &frame, layer, detail)?;
    }
    for note in &panel.notes {
        let style = font(LABEL, note.color).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(note.text.clone(), frame.device(&note.at), style))?;
    }
    if let Some(legend) = &frame.legend {
        legend.draw(area, frame.edges, &panel.layers)?;
    }
    frame.draw(area, panel)
}

fn draw_layer<DB>(area: &Area<DB>, frame: &Frame, layer: &Layer, detail: Detail) -> Outcome
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let (x, y) = (&frame.x, &frame.y);
    let device = |point: &(f64, f64)| frame.device(point);
    if let Some(line) = layer.pen.line {
        let style = stroke(layer.pen.color, line.width);
        for part in clip::polyline(&layer.points, x, y) {
            let mut path: Vec<_> = part.iter().map(device).collect();
            if detail == Detail::Thinned {
                path = clip::thin_line(&path, f64::from(SCALE) / 2.0);
            }
            draw_line(area, path, line.dash, style)?;
        }
    }
    if let Some(symbols) = layer.pen.symbol {
        let stride = symbols
            .count
            .map_or(1, |count| layer.points.len().div_ceil(count.max(1)).max(1));
        let mut points: Vec<_> = layer
            .points
            .iter()
            .skip(stride / 2)
            .step_by(stride)
            .filter(|(u, v)| x.contains(u) && y.contains(v))
            .map(device)
            .collect();
        if detail == Detail::Thinned {
            points = clip::thin_dots(&points, px(0.75), DOTS);
        }
        for point in points {
            draw_symbol(area, point, &layer.pen, symbols)?;
        }
    }
    Ok(())
}

pub(crate) fn draw_line<DB>(
    canvas: &Area<DB>,
    path: Vec<(i32, i32)>,
    dash: Option<(f64, f64)>,
    style: ShapeStyle,
) -> Outcome
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    match dash {
        None => canvas.draw(&PathElement::new(path, style))?,
        Some((dash, gap)) => {
            canvas.draw(&DashedPathElement::new(path, px(dash), px(gap), style))?;
        }
    }
    Ok(())
}

pub(crate) fn draw_symbol<DB>(
    canvas: &Area<DB>,
    (x, y): (i32, i32),
    pen: &Pen,
    symbols: Symbols,
) -> Outcome
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let r = px(symbols.radius).max(1);
    let style = stroke(pen.color, 1.3);
    match symbols.shape {
        Shape::Disc => canvas.draw(&plotters::element::Circle::new(
            (x, y),
            r,
            rgb(pen.color).filled(),
        ))?,
        Shape::Circle => {
            let corner = |k: i32| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 12.0).sin_cos();
                (
                    x + (f64::from(r) * cos).round() as i32,
                    y + (f64::from(r) * sin).round() as i32,
                )
            };
            canvas.draw(&PathElement::new(
                (0..=24).map(corner).collect::<Vec<_>>(),
                style,
            ))?;
        }
        Shape::Square => {
            let square = vec![
                (x - r, y - r),
                (x + r, y - r),
                (x + r, y + r),
                (x - r, y + r),
                (x - r, y - r),
            ];
            canvas.draw(&PathElement::new(square, style))?;
        }
        Shape::Triangle => {
            let triangle = vec![(x, y - r), (x + r, y + r), (x - r, y + r), (x, y - r)];
            canvas.draw(&PathElement::new(triangle, style))?;
        }
        Shape::Limit => {
            let (tip, wing) = ((x, y + 3 * r), px(1.6));
            let bar = vec![(x - r, y), (x + r, y)];
            canvas.draw(&PathElement::new(bar, style))?;
            canvas.draw(&PathElement::new(vec![(x, y), tip], style))?;
            let head = vec![
                (x - wing, tip.1 - 2 * wing),
                tip,
                (x + wing, tip.1 - 2 * wing),
            ];
            canvas.draw(&PathElement::new(head, style))?;
        }
        Shape::Diamond => {
            let corners = [(0, -r), (r, 0), (0, r), (-r, 0), (0, -r)];
            let diamond = corners.map(|(u, v)| (x + u, y + v)).to_vec();
            canvas.draw(&PathElement::new(diamond, style))?;
        }
        Shape::Plus => {
            canvas.draw(&PathElement::new(vec![(x - r, y), (x + r, y)], style))?;
            canvas.draw(&PathElement::new(vec![(x, y - r), (x, y + r)], style))?;
        }
        Shape::Cross => {
            canvas.draw(&PathElement::new(
                vec![(x - r, y - r), (x + r, y + r)],
                style,
            ))?;
            canvas.draw(&PathElement::new(
                vec![(x - r, y + r), (x + r, y - r)],
                style,
            ))?;
        }
    }
    Ok(())
}
