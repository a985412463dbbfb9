//! The same step in two charts: the exponential one of `sve`, and Cayley's, written by hand.
//!
//! In Cayley's chart the increment of an attitude is x, and the turn is `(1 + x̂/2)(1 − x̂/2)⁻¹`,
//! of length 2 tan(θ/2). The equations of the midpoint rule are, with g = I x/h, the torque τ at
//! the middle of the geodesic, and T = ½/(1 + √(1 + |x|²/4)),
//!
//! ```text
//! Π₀ = g + ½ x × g + ¼ x (x·g) − ½ h (τ + T x × τ),    Π₁ = Π₀ − x × g + h τ
//! ```

use sve_examples::figure::{Axis, Corner, Layer, Panel, Pen, Shape};
use sve_examples::hues;
use sve_runtime::nalgebra::Quaternion;
use sve_runtime::prelude::*;

use super::Top;

/// Time over which errors are compared.
const TIME: f64 = 2.0;

/// Steps over this time.
const STEPS: [u32; 5] = [80, 160, 320, 640, 1280];

type Body = State<UnitQuaternion<f64>>;

/// Returns the rotation of a Cayley vector.
fn cayley(x: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::from_parts(1.0, 0.5 * x))
}

/// Makes a step of the midpoint rule in Cayley's chart, by fixed-point iterations.
fn cayley_step(top: &Top, state: &Body, h: f64) -> Body {
    let inertia = Vector3::new(top.a, top.a, top.c);
    let (mut x, mut end) = (h * state.p.component_div(&inertia), state.p);
    for _ in 0..200 {
        let g = inertia.component_mul(&x) / h;
        let t = 0.5 / (1.0 + (1.0 + 0.25 * x.norm_squared()).sqrt());
        let middle = state.q * cayley(2.0 * t * x);
        // the weight pulls along the vertical, at the axis of the top
        let torque = -top.weight * Vector3::z().cross(&(middle.inverse() * Vector3::z()));
        let across = x.cross(&g);
        let balance = g + 0.5 * across + 0.25 * x * x.dot(&g)
            - 0.5 * h * (torque + t * x.cross(&torque))
            - state.p;
        end = state.p - across + h * torque;
        let change = h * balance.component_div(&inertia);
        x -= change;
        if change.norm() < 1e-15 * x.norm() {
            break;
        }
    }
    State::at(state.t + h, state.q * cayley(x), end)
}

/// The angle between the attitude at the end and the exact one, for each number of steps.
pub(crate) struct Errors {
    pub(crate) cayley: Vec<f64>,
    pub(crate) exponential: Vec<f64>,
    pub(crate) verlet: Vec<f64>,
}

/// Compares the ends of paths of both charts.
pub(crate) fn errors(top: Top, start: Body) -> Result<Errors, StepError> {
    let composed = Integrator::new(top, Composed::new(Midpoint, KahanLi8));
    let midpoint = Integrator::new(top, Midpoint);
    let verlet = Integrator::new(top, StormerVerlet);
    let mut exact = start;
    for _ in 0..1000 {
        composed.step(&mut exact, TIME / 1000.0, &[0.0])?;
    }
    let mut errors = Errors {
        cayley: Vec::new(),
        exponential: Vec::new(),
        verlet: Vec::new(),
    };
    for steps in STEPS {
        let h = TIME / f64::from(steps);
        let (mut by_hand, mut state, mut explicit) = (start, start, start);
        for _ in 0..steps {
            by_hand = cayley_step(&top, &by_hand, h);
            midpoint.step(&mut state, h, &[0.0])?;
            verlet.step(&mut explicit, h, &[0.0])?;
        }
        let error = |state: &Body| (exact.q.inverse() * state.q).angle();
        errors.cayley.push(error(&by_hand));
        errors.exponential.push(error(&state));
        errors.verlet.push(error(&explicit));
    }
    Ok(errors)
}

/// Draws the errors against the angle of a step, with which the work is the same for both charts.
pub(crate) fn panel(errors: &Errors, rate: f64) -> Panel {
    let points = |errors: &[f64]| {
        let degrees = STEPS.map(|steps| (rate * TIME / f64::from(steps)).to_degrees());
        let pairs = degrees.into_iter().zip(errors);
        pairs.map(|(x, error)| (x.log10(), error.log10())).collect()
    };
    let layer = |name, errors: &[f64], color, shape| {
        let pen = Pen::line(color, 1.4).symbols(shape, STEPS.len());
        Layer::new(name, points(errors), pen)
    };
    let (cayley, midpoint, verlet) = (&errors.cayley, &errors.exponential, &errors.verlet);
    Panel::new(
        "Error of the attitude at t = 2",
        Axis::powers("turn in a step, degrees", 0.0..1.5),
        Axis::powers("error of the attitude (rad)", -6.0..1.0),
    )
    .legend(Corner::Below)
    .with(layer(
        "midpoint, Cayley chart",
        cayley,
        hues::MIDPOINT,
        Shape::Triangle,
    ))
    .with(layer(
        "midpoint, exponential chart",
        midpoint,
        hues::MIDPOINT,
        Shape::Disc,
    ))
    .with(layer(
        "Störmer–Verlet",
        verlet,
        hues::STORMER_VERLET,
        Shape::Square,
    ))
}
