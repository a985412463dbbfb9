//! Bars and areas around the points of a layer, cut at the axes.

use std::error::Error;

use plotters::prelude::*;

use super::axes::Frame;
use super::draw::{Area, px, rgb, stroke};
use super::figure::{Layer, Spread};

/// Opacity of areas, under which lines stay visible.
const OPACITY: f64 = 0.22;
/// Half the width of the ends of a bar, in CSS pixels.
const CAP: f64 = 2.5;

/// Draws bars and areas around the points of a layer.
pub(crate) fn draw<DB>(area: &Area<DB>, frame: &Frame, layer: &Layer) -> Result<(), Box<dyn Error>>
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let points = &layer.points;
    match &layer.spread {
        Spread::None => Ok(()),
        Spread::Bars(ends) => {
            for (&(x, _), &(low, high)) in points.iter().zip(ends) {
                draw_bar(area, frame, layer, (x, low, high))?;
            }
            Ok(())
        }
        Spread::Band(ends) => {
            let edges = points.iter().zip(ends);
            let edges: Vec<_> = edges
                .map(|(&(x, _), &(low, high))| (x, low, high))
                .collect();
            draw_area(area, frame, layer, &edges)
        }
        Spread::Filled(to) => {
            let edges: Vec<_> = points.iter().map(|&(x, y)| (x, *to, y)).collect();
            draw_area(area, frame, layer, &edges)
        }
    }
}

/// Returns the look of a layer's areas.
pub(crate) fn style(layer: &Layer) -> ShapeStyle {
    rgb(layer.pen.color).mix(OPACITY).filled()
}

fn draw_bar<DB>(
    area: &Area<DB>,
    frame: &Frame,
    layer: &Layer,
    (x, low, high): (f64, f64, f64),
) -> Result<(), Box<dyn Error>>
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let visible = frame.x.contains(&x) && low <= frame.y.end && high >= frame.y.start;
    // Comparisons with NaN are false.
    if !visible {
        return Ok(());
    }
    let style = stroke(layer.pen.color, 1.1);
    let at = |y: f64| frame.device(&(x, y.clamp(frame.y.start, frame.y.end)));
    let (bottom, top) = (at(low), at(high));
    area.draw(&PathElement::new(vec![bottom, top], style))?;
    // An end outside of the axes has no cap.
    for (y, (u, v)) in [(low, bottom), (high, top)] {
        if frame.y.contains(&y) {
            let cap = vec![(u - px(CAP), v), (u + px(CAP), v)];
            area.draw(&PathElement::new(cap, style))?;
        }
    }
    Ok(())
}

/// Fills the area between the lower and upper edges, in one part for each stretch of points within
/// the axes.
fn draw_area<DB>(
    area: &Area<DB>,
    frame: &Frame,
    layer: &Layer,
    edges: &[(f64, f64, f64)],
) -> Result<(), Box<dyn Error>>
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let inside = |&(x, low, high): &(f64, f64, f64)| {
        (frame.x.start..=frame.x.end).contains(&x) && low.is_finite() && high.is_finite()
    };
    let clamped = |x: f64, y: f64| frame.device(&(x, y.clamp(frame.y.start, frame.y.end)));
    for part in edges
        .split(|edge| !inside(edge))
        .filter(|part| part.len() > 1)
    {
        let upper = part.iter().map(|&(x, _, high)| clamped(x, high));
        let lower = part.iter().rev().map(|&(x, low, _)| clamped(x, low));
        let outline: Vec<_> = upper.chain(lower).collect();
        area.draw(&Polygon::new(outline, style(layer)))?;
    }
    Ok(())
}
