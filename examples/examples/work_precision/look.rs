//! The looks of methods, the same in all figures.
//!
//! Variational rules have solid lines, which are thin for stage noise, methods for comparison
//! dashed lines, other programs dotted lines.

use sve_examples::figure::{Pen, Shape, Stroke, Symbols};
use sve_examples::hues;
use sve_examples::palette::{self, Color};

use crate::plots::Series;

/// The methods for comparison.
const BASELINES: [&str; 6] = [
    "Heun",
    "Runge–Kutta 4",
    "Taylor series 2",
    "Euler",
    "Euler–Maruyama",
    "backward Euler–Maruyama",
];

/// Returns the hue of another program's method: that of the method of sve, where there is one.
fn hue(name: &str, number: usize) -> Color {
    let method = name.split_once(": ").map_or(name, |(_, method)| method);
    match method {
        "midpoint" | "LeapfrogMidpoint" => hues::MIDPOINT,
        "Heun" | "EulerHeun" => hues::HEUN,
        "Euler–Maruyama" => hues::EULER_MARUYAMA,
        "symplectic Euler" | "SemiImplicitEuler" => hues::INITIAL_POINT,
        "SPaRK" | "ShARK" | "SlowRK" => palette::BLACK,
        _ => palette::CYCLE[(number + 3) % palette::CYCLE.len()],
    }
}

/// Returns the look of a method, the same in all figures; the look of other programs follows their
/// number. Methods with the same look occur in no figure together.
#[allow(clippy::match_same_arms)] // a line for each method
pub(crate) fn pen(series: &Series, number: usize) -> Pen {
    let (color, shape) = match series.name.as_str() {
        "midpoint" => (hues::MIDPOINT, Shape::Disc),
        "midpoint, Kahan–Li 8" => (hues::MIDPOINT, Shape::Circle),
        "Störmer–Verlet" => (hues::STORMER_VERLET, Shape::Square),
        "Störmer–Verlet, weak2" => (hues::STORMER_VERLET, Shape::Plus),
        "Störmer–Verlet, Kahan–Li 8" => (hues::STORMER_VERLET, Shape::Cross),
        "Gauss 2" | "Gauss 4" => (hues::GAUSS, Shape::Triangle),
        "Gauss 2, stage noise" => (hues::GAUSS, Shape::Plus),
        "Gauss 3, stage noise" => (hues::GAUSS, Shape::Cross),
        "Gauss 4, stage noise" => (hues::GAUSS, Shape::Square),
        "Gauss 6" => (hues::GAUSS, Shape::Diamond),
        "Gauss 8" => (hues::GAUSS, Shape::Plus),
        "Gauss 8, compensated" => (hues::GAUSS, Shape::Circle),
        "Blanes–Moan 4" => (palette::BLACK, Shape::Triangle),
        "Blanes–Moan RKN 6" => (palette::BLACK, Shape::Disc),
        "endpoint" | "endpoint, uncorrected" => (hues::ENDPOINT, Shape::Circle),
        "initial point" | "initial point, uncorrected" => (hues::INITIAL_POINT, Shape::Diamond),
        "taylor2" => (hues::TAYLOR, Shape::Diamond),
        "Heun" => (hues::HEUN, Shape::Circle),
        "Runge–Kutta 4" => (hues::RUNGE_KUTTA_4, Shape::Square),
        "Euler–Maruyama" => (hues::EULER_MARUYAMA, Shape::Cross),
        "backward Euler–Maruyama" => (hues::EULER_MARUYAMA, Shape::Triangle),
        "heyoka: Taylor" => (hues::HEYOKA, Shape::Disc),
        "heyoka: Taylor, compensated" => (hues::HEYOKA, Shape::Circle),
        "scipy: DOP853" => (palette::GREY, Shape::Diamond),
        "numba: Runge–Kutta 4" => (hues::RUNGE_KUTTA_4, Shape::Cross),
        name => {
            let shapes = [
                Shape::Triangle,
                Shape::Square,
                Shape::Plus,
                Shape::Disc,
                Shape::Circle,
                Shape::Diamond,
                Shape::Cross,
            ];
            (hue(name, number), shapes[number % shapes.len()])
        }
    };
    let (width, dash) = if series.is_peer {
        // The number of gaps is the number of rounds of shapes.
        (1.6, Some((1.5, 3.0 * (1 + number / 7) as f64)))
    } else if series.name.ends_with("uncorrected") {
        (1.6, Some((2.0, 4.0)))
    } else if BASELINES.contains(&&*series.name) {
        (1.4, Some((7.0, 4.0)))
    } else if series.name.ends_with("stage noise") {
        (1.4, None)
    } else {
        (2.2, None)
    };
    Pen {
        color,
        line: Some(Stroke { width, dash }),
        symbol: Some(Symbols {
            shape,
            radius: 3.2,
            count: None,
        }),
    }
}
