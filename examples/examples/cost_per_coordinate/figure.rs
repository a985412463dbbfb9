//! The picture: costs against the number of coordinates, with names beside the curves.

use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row, Shape, Stroke};
use sve_examples::palette::{BLACK, BLUE, Color, GREEN, GREY, VERMILION};

use crate::ways::KINDS;
use crate::{Measured, NAMES};

const PENS: [(Color, Shape); 4] = [
    (BLUE, Shape::Disc),
    (GREEN, Shape::Square),
    (VERMILION, Shape::Triangle),
    (BLACK, Shape::Diamond),
];

/// Dash and gap of the curves of single steps.
const DASH: (f64, f64) = (6.0, 4.0);

pub(crate) fn figure(all: &[Measured]) -> Figure {
    let times = |way: usize| move |m: &Measured| m.ways[way].time.log10();
    let mut above = Panel::new(
        "Cost of a coordinate",
        Axis::powers("coordinates", 1.8..7.0),
        Axis::powers("nanoseconds a coordinate and step", -0.3..2.9),
    )
    .legend(Corner::TopRight)
    .with(Layer::new(NAMES[0], Vec::new(), Pen::line(GREY, 1.6)))
    .with(Layer::new(
        NAMES[1],
        Vec::new(),
        Pen::dashed(GREY, 1.6, DASH),
    ));
    let pens = [Some(DASH), None];
    for (way, dash) in [1, 0].into_iter().zip(pens) {
        above = with_curves(above, all, dash, times(way), way == 0);
    }
    let ratios = all.iter().flat_map(|m| [m.ways[2].ratio, m.ways[3].ratio]);
    let most = ratios.fold(1.0, |most: f64, ratio| most.max(1.0 / ratio));
    let ratio = |way: usize| {
        // the axis goes on to the right of the last point, for the names of the curves
        let panel = Panel::new(
            format!("Trajectory / {} by hand", NAMES[way]),
            Axis::powers("coordinates", 1.8..7.9),
            Axis::new("ratio of times", 0.0..1.1 * most),
        );
        let even = Layer::new("", vec![(2.0, 1.0), (6.0, 1.0)], Pen::line(GREY, 0.8));
        with_curves(
            panel.with(even),
            all,
            None,
            move |m| 1.0 / m.ways[way].ratio,
            true,
        )
    };
    Figure {
        name: "cost_per_coordinate",
        width: 980,
        rows: vec![
            Row {
                height: 440,
                panels: vec![above],
            },
            Row {
                height: 360,
                panels: vec![ratio(2), ratio(3)],
            },
        ],
    }
}

/// Draws a curve for each kind of system, with its name at its end if asked for.
fn with_curves(
    mut panel: Panel,
    all: &[Measured],
    dash: Option<(f64, f64)>,
    value: impl Fn(&Measured) -> f64,
    is_named: bool,
) -> Panel {
    let mut names = Vec::new();
    for (kind, (color, shape)) in PENS.into_iter().enumerate() {
        let own = all.iter().filter(|m| m.kind == kind);
        let points: Vec<(f64, f64)> = own
            .map(|m| ((m.coordinates as f64).log10(), value(m)))
            .collect();
        names.push((points[points.len() - 1].1, KINDS[kind].name, color));
        let mut pen = Pen::line(color, 1.6).symbols(shape, points.len());
        pen.line = Some(Stroke { width: 1.6, dash });
        panel = panel.with(Layer::new("", points, pen).unlisted());
    }
    if !is_named {
        return panel;
    }
    // names keep a distance from each other
    let apart = 0.055 * (panel.y.range.end - panel.y.range.start);
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut least = f64::NEG_INFINITY;
    for (end, name, color) in names {
        let y = end.max(least);
        least = y + apart;
        panel = panel.note((6.12, y), name, color);
    }
    panel
}
