//! Draws a figure on any backend of plotters.
//!
//! All lengths of [`figure`](crate::figure) are CSS pixels; [`px`] makes them device units.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::clip;
use crate::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Shape, Symbols};
use crate::palette;
use crate::render::SCALE;

type Outcome = Result<(), Box<dyn Error>>;
type Area<DB> = DrawingArea<DB, Shift>;
type Axes<DB> = DrawingArea<DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Room for labels and titles around the axes, in CSS pixels.
const EDGE: u32 = 6;
const LEFT: u32 = 56;
const BOTTOM: u32 = 44;
const TOP: u32 = 30;
const RIGHT: u32 = 16;
/// Sizes of text, in CSS pixels (plotters measures a font by its line height, 1.24 times this).
const TICK: f64 = 11.0;
const NAME: f64 = 12.0;
const TITLE: f64 = 13.0;
/// Dots of one layer in an SVG, where each takes sixty bytes.
const DOTS: usize = 2_000;

/// How many points are drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Detail {
    /// All of them.
    Full,
    /// What can be told apart at the size of the figure: vector files grow with each point.
    Thinned,
}

fn px(length: f64) -> i32 {
    (length * f64::from(SCALE)).round() as i32
}

fn stroke(color: palette::Color, width: f64) -> ShapeStyle {
    rgb(color).stroke_width(px(width).unsigned_abs().max(1))
}

fn rgb((r, g, b): palette::Color) -> RGBColor {
    RGBColor(r, g, b)
}

fn font(size: f64, color: palette::Color) -> TextStyle<'static> {
    ("sans-serif", 1.24 * size * f64::from(SCALE))
        .into_font()
        .color(&rgb(color))
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
    let (width, height) = area.dim_in_pixel();
    let inner = (
        f64::from(width) - f64::from(SCALE * (EDGE + LEFT + RIGHT)),
        f64::from(height) - f64::from(SCALE * (BOTTOM + TOP)),
    );
    let (x, y) = ranges(panel, inner);
    let title = font(TITLE, palette::BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    area.draw(&Text::new(
        panel.title.clone(),
        (px(f64::from(EDGE + LEFT)), px(f64::from(TOP) / 2.0)),
        title,
    ))?;
    let mut chart = ChartBuilder::on(area)
        .margin_top(SCALE * TOP)
        .margin_left(SCALE * EDGE)
        .margin_right(SCALE * RIGHT)
        .set_label_area_size(LabelAreaPosition::Left, SCALE * LEFT)
        .set_label_area_size(LabelAreaPosition::Bottom, SCALE * BOTTOM)
        .build_cartesian_2d(x.clone(), y.clone())?;
    let (x_label, y_label) = (formatter(&panel.x), formatter(&panel.y));
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(panel.x.labels)
        .y_labels(panel.y.labels)
        .x_label_formatter(&x_label)
        .y_label_formatter(&y_label)
        .x_desc(panel.x.name.clone())
        .y_desc(panel.y.name.clone())
        .label_style(font(TICK, palette::BLACK))
        .axis_desc_style(font(NAME, palette::BLACK))
        .axis_style(stroke(palette::BLACK, 1.0))
        .set_all_tick_mark_size(SCALE * 4)
        .draw()?;
    let axes = chart.plotting_area();
    for layer in &panel.layers {
        draw_layer(axes, layer, (&x, &y), detail)?;
    }
    for note in &panel.notes {
        let style = font(TICK, note.color).pos(Pos::new(HPos::Left, VPos::Center));
        axes.draw(&Text::new(note.text.clone(), note.at, style))?;
    }
    if let Some(corner) = panel.legend {
        draw_legend(&axes.strip_coord_spec(), panel, corner)?;
    }
    Ok(())
}

/// The axes' ranges, widened to equal scales where the panel asks for them.
fn ranges(panel: &Panel, (width, height): (f64, f64)) -> (Range<f64>, Range<f64>) {
    let (x, y) = (panel.x.range.clone(), panel.y.range.clone());
    if !panel.equal {
        return (x, y);
    }
    let unit = ((x.end - x.start) / width).max((y.end - y.start) / height);
    let widened = |range: Range<f64>, pixels: f64| {
        let middle = f64::midpoint(range.start, range.end);
        middle - unit * pixels / 2.0..middle + unit * pixels / 2.0
    };
    (widened(x, width), widened(y, height))
}

fn formatter(axis: &Axis) -> impl Fn(&f64) -> String + use<> {
    let powers = axis.powers;
    move |&value| {
        if powers {
            return format!("10{}", superscript(value.round() as i64));
        }
        // labels stand at round numbers, up to rounding
        let text = format!("{value:.4}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0".to_owned() } else { text.replace('-', "−") }
    }
}

fn superscript(exponent: i64) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => digit
                .to_digit(10)
                .and_then(|d| char::from_u32(0x2070 + d))
                .unwrap_or(digit),
        })
        .collect()
}

fn draw_layer<DB>(
    axes: &Axes<DB>,
    layer: &Layer,
    (x, y): (&Range<f64>, &Range<f64>),
    detail: Detail,
) -> Outcome
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let canvas = axes.strip_coord_spec();
    let (left, top) = axes.get_base_pixel();
    let device = |point: &(f64, f64)| {
        let (u, v) = axes.map_coordinate(point);
        (u - left, v - top)
    };
    if let Some(line) = layer.pen.line {
        let style = stroke(layer.pen.color, line.width);
        for part in clip::polyline(&layer.points, x, y) {
            let mut path: Vec<_> = part.iter().map(device).collect();
            if detail == Detail::Thinned {
                path = clip::thin_line(&path, f64::from(SCALE) / 2.0);
            }
            draw_line(&canvas, path, line.dash, style)?;
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
            draw_symbol(&canvas, point, &layer.pen, symbols)?;
        }
    }
    Ok(())
}

fn draw_line<DB>(
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

fn draw_symbol<DB>(canvas: &Area<DB>, (x, y): (i32, i32), pen: &Pen, symbols: Symbols) -> Outcome
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let r = px(symbols.radius).max(1);
    let style = stroke(pen.color, 1.3);
    match symbols.shape {
        Shape::Disc => canvas.draw(&plotters::element::Circle::new((x, y), r, rgb(pen.color).filled()))?,
        Shape::Circle => {
            let corner = |k: i32| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 12.0).sin_cos();
                (x + (f64::from(r) * cos).round() as i32, y + (f64::from(r) * sin).round() as i32)
            };
            canvas.draw(&PathElement::new((0..=24).map(corner).collect::<Vec<_>>(), style))?;
        }
        Shape::Square => {
            let square = vec![(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r), (x - r, y - r)];
            canvas.draw(&PathElement::new(square, style))?;
        }
        Shape::Triangle => {
            let triangle = vec![(x, y - r), (x + r, y + r), (x - r, y + r), (x, y - r)];
            canvas.draw(&PathElement::new(triangle, style))?;
        }
        Shape::Cross => {
            canvas.draw(&PathElement::new(vec![(x - r, y - r), (x + r, y + r)], style))?;
            canvas.draw(&PathElement::new(vec![(x - r, y + r), (x + r, y - r)], style))?;
        }
    }
    Ok(())
}

fn draw_legend<DB>(canvas: &Area<DB>, panel: &Panel, corner: Corner) -> Outcome
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let (line, sample, gap) = (16.0, 30.0, 6.0);
    let listed: Vec<&Layer> = panel.layers.iter().filter(|layer| layer.listed).collect();
    let text = font(TICK, palette::BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    let mut widest = 0;
    for layer in &listed {
        widest = widest.max(canvas.estimate_text_size(&layer.label, &text)?.0);
    }
    let (width, height) = canvas.dim_in_pixel();
    // fonts of a browser may be wider than the embedded one: a tenth more
    let box_width = px(sample + 3.0 * gap) + (1.1 * f64::from(widest)) as i32;
    let box_height = px(line * listed.len() as f64 + gap);
    let left = match corner {
        Corner::TopLeft | Corner::BottomLeft => px(8.0),
        Corner::TopRight | Corner::BottomRight => i32::try_from(width)? - box_width - px(4.0),
    };
    let top = match corner {
        Corner::TopLeft | Corner::TopRight => px(4.0),
        Corner::BottomLeft | Corner::BottomRight => i32::try_from(height)? - box_height - px(4.0),
    };
    let frame = [(left, top), (left + box_width, top + box_height)];
    canvas.draw(&Rectangle::new(frame, WHITE.filled()))?;
    for (k, layer) in listed.into_iter().enumerate() {
        let y = top + px(gap / 2.0 + line * (k as f64 + 0.5));
        let (from, to) = (left + px(gap), left + px(gap + sample));
        if let Some(stroke_of) = layer.pen.line {
            let style = stroke(layer.pen.color, stroke_of.width.max(1.2));
            draw_line(canvas, vec![(from, y), (to, y)], stroke_of.dash, style)?;
        }
        if let Some(mut symbols) = layer.pen.symbol {
            symbols.radius = symbols.radius.max(1.5);
            draw_symbol(canvas, (i32::midpoint(from, to), y), &layer.pen, symbols)?;
        }
        canvas.draw(&Text::new(layer.label.clone(), (to + px(gap), y), text.clone()))?;
    }
    Ok(())
}
