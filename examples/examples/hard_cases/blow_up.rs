//! The picture: the largest energy of stiff oscillators against ωh, by rule.

use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Shape};
use sve_examples::hues;
use sve_examples::report::one_row;
use sve_runtime::prelude::*;

use super::stiff::{Linear, Quartic, largest_energy};

/// Number of steps of a run: few, since every run is one point.
const STEPS: usize = 2000;
/// Number of points in a decade of ωh.
const DENSITY: i32 = 16;

/// Returns the points of a rule, up to the point where the energy passes a million times its first
/// value.
fn points(run: impl Fn(f64) -> Option<f64>) -> Vec<(f64, f64)> {
    let exponents = (-DENSITY..=3 * DENSITY).map(|k| f64::from(k) / f64::from(DENSITY));
    exponents
        .map_while(|x| Some((x, run(10_f64.powf(x))?.log10())))
        .collect()
}

/// Rules by their names, with their points.
type Curves = [(&'static str, Vec<(f64, f64)>); 3];

fn panel(title: &str, curves: Curves) -> Panel {
    let empty = Panel::new(
        format!("{title}: largest energy of {STEPS} steps over the first"),
        Axis::powers("frequency times step, ωh", -1.0..3.0),
        Axis::powers("energy / first energy", -0.1..2.2),
    );
    // The curve of the initial point lies on the curve of the endpoint, which is wider.
    let looks = [
        (hues::MIDPOINT, 1.6, Shape::Disc),
        (hues::ENDPOINT, 5.0, Shape::Circle),
        (hues::INITIAL_POINT, 1.6, Shape::Square),
    ];
    let all = curves.into_iter().zip(looks);
    all.fold(empty, |panel, ((name, points), (color, width, shape))| {
        let pen = Pen::line(color, width).symbols(shape, points.len());
        panel.with(Layer::new(name, points, pen))
    })
    .legend(Corner::TopRight)
}

pub(super) fn figure() -> Figure {
    let linear = |omega| Linear { omega };
    let quartic = |omega| Quartic { omega };
    let panels = vec![
        panel(
            "Linear oscillator",
            [
                (
                    "midpoint",
                    points(|x| largest_energy(linear(x), Midpoint, STEPS)),
                ),
                (
                    "endpoint",
                    points(|x| largest_energy(linear(x), Endpoint, STEPS)),
                ),
                (
                    "initial point",
                    points(|x| largest_energy(linear(x), InitialPoint, STEPS)),
                ),
            ],
        ),
        panel(
            "Quartic oscillator",
            [
                (
                    "midpoint",
                    points(|x| largest_energy(quartic(x), Midpoint, STEPS)),
                ),
                (
                    "endpoint",
                    points(|x| largest_energy(quartic(x), Endpoint, STEPS)),
                ),
                (
                    "initial point",
                    points(|x| largest_energy(quartic(x), InitialPoint, STEPS)),
                ),
            ],
        ),
    ];
    one_row("hard_cases", [1080, 420], panels)
}
