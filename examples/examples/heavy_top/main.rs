//! A heavy symmetric top: steady precession against its closed form, nutation, and vertical shaking
//! of its support.
//!
//! The attitude is a rotation: there are no Euler angles, and the upright position is not singular.
//! The shaking is a noise in the weight, γ = s R₃₃: it changes the energy and keeps the momenta
//! about the vertical and about the figure axis, as every step does. Steps in the exponential chart
//! of rotations are compared with steps in Cayley's, which are written by hand.
//!
//! `cargo run --release --example heavy_top` writes a page with the pictures to `target/heavy_top`,
//! and exits with status 1 if a number is off.

mod charts;

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use sve_examples::palette;
use sve_examples::report::report;
use sve_runtime::prelude::*;

/// A top with the moments of inertia `a` across and `c` along its axis, and the weight times the
/// distance of its centre from the support.
#[derive(Clone, Copy, Debug)]
struct Top {
    a: f64,
    c: f64,
    weight: f64,
    s: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Top {
    fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        let axis = r * Vector3::z();
        0.5 * (self.a * (w.x * w.x + w.y * w.y) + self.c * w.z * w.z) - self.weight * axis.z
    }
    #[gamma]
    fn shaking(&self, r: Rotation3<f64>) -> f64 {
        self.s * r[(2, 2)]
    }
    /// Turns space about the vertical.
    #[symmetry]
    fn vertical(&self, r: Rotation3<f64>) -> Vector3<f64> {
        r.inverse() * Vector3::z()
    }
    /// Turns the top about its axis.
    #[symmetry]
    fn figure(&self, _r: Rotation3<f64>) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, 1.0)
    }
}

const H: f64 = 0.01;
const STEPS: usize = 100_000;
/// Number of steps that are drawn.
const DRAWN: usize = 3000;
/// Angle of the axis from the vertical at the start.
const TILT: f64 = 0.5;
/// Spin about the axis.
const SPIN: f64 = 12.0;

/// The properties of a path.
struct Motion {
    /// The axis of the top in space, at the steps that are drawn.
    axis: Vec<Vector3<f64>>,
    /// Largest changes of the momenta about the vertical and the axis.
    momenta: [f64; 2],
    /// Largest change of the energy.
    energy: f64,
    /// Largest change of the angle from the vertical.
    tilt: f64,
    /// The angle about the vertical through which the axis has moved.
    precession: f64,
}

fn run(top: Top, start: State<UnitQuaternion<f64>>) -> Result<Motion, StepError> {
    let integrator = Integrator::new(top, Midpoint);
    let energy = top.hamiltonian(&start)?;
    let momenta = [top.vertical_momentum(&start), top.figure_momentum(&start)];
    let mut motion = Motion {
        axis: Vec::new(),
        momenta: [0.0; 2],
        energy: 0.0,
        tilt: 0.0,
        precession: 0.0,
    };
    let mut before = start.q * Vector3::z();
    for (step, state) in integrator
        .trajectory(start, H, Wiener::new(5))
        .take(STEPS)
        .enumerate()
    {
        let state = state?;
        let axis = state.q * Vector3::z();
        if step < DRAWN {
            motion.axis.push(axis);
        }
        let now = [top.vertical_momentum(&state), top.figure_momentum(&state)];
        for (worst, (now, start)) in motion.momenta.iter_mut().zip(now.into_iter().zip(momenta)) {
            *worst = worst.max((now - start).abs());
        }
        motion.energy = motion.energy.max((top.hamiltonian(&state)? - energy).abs());
        motion.tilt = motion
            .tilt
            .max((axis.z.clamp(-1.0, 1.0).acos() - TILT).abs());
        motion.precession +=
            (before.x * axis.y - before.y * axis.x).atan2(before.x * axis.x + before.y * axis.y);
        before = axis;
    }
    Ok(motion)
}

/// Returns the top tilted about the first axis, spinning with `SPIN` about its axis and turning
/// with `precession` about the vertical.
fn start(top: Top, precession: f64) -> State<UnitQuaternion<f64>> {
    let tilted = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), TILT);
    let vertical = tilted.inverse() * Vector3::z();
    let mut w = precession * vertical;
    w.z = SPIN;
    let p = Vector3::new(top.a * w.x, top.a * w.y, top.c * w.z);
    State::new(tilted, p)
}

/// Returns the slow root of `a Ω² cos θ − c ω Ω + weight = 0`, the rate of steady precession.
fn steady_precession(top: Top) -> f64 {
    let (square, linear) = (top.a * TILT.cos(), top.c * SPIN);
    2.0 * top.weight / (linear + (linear * linear - 4.0 * square * top.weight).sqrt())
}

/// Draws the path of the axis as seen from above.
fn view(title: &str, axis: &[Vector3<f64>], color: palette::Color, size: f64) -> Panel {
    let points = axis.iter().map(|a| (a.x, a.y)).collect();
    let circle = (0..=200).map(|k| f64::from(k) * core::f64::consts::TAU / 200.0);
    let start = circle
        .map(|a| (TILT.sin() * a.cos(), TILT.sin() * a.sin()))
        .collect();
    let axis = |name| Axis::new(name, -size..size);
    Panel::new(title, axis("x of the axis"), axis("y of the axis"))
        .equal()
        .with(Layer::new("start", start, Pen::dashed(palette::GREY, 1.0, (4.0, 4.0))).unlisted())
        .with(Layer::new("axis", points, Pen::line(color, 1.1)).unlisted())
}

fn figure(motions: [&Motion; 3], errors: Panel) -> Figure {
    let colors = [palette::GREEN, palette::ORANGE, palette::BLACK];
    let titles = ["Steady precession", "Nutation from rest", "Support shaken"];
    let views = titles
        .iter()
        .zip(motions)
        .zip(colors)
        .zip([0.65, 0.65, 1.1]);
    let views =
        views.map(|(((title, motion), color), size)| view(title, &motion.axis, color, size));
    let mut tilt = Panel::new(
        "Angle between axis and vertical",
        Axis::new("time t", 0.0..DRAWN as f64 * H),
        Axis::angle("angle θ", 0.0..core::f64::consts::PI),
    )
    .legend(Corner::Below);
    let pens = colors.into_iter().zip([2.0, 1.2, 1.2]);
    for ((title, motion), (color, width)) in titles.iter().zip(motions).zip(pens) {
        let points = motion.axis.iter().enumerate();
        let points = points.map(|(k, a)| ((k + 1) as f64 * H, a.z.clamp(-1.0, 1.0).acos()));
        tilt = tilt.with(Layer::new(
            *title,
            points.collect(),
            Pen::line(color, width),
        ));
    }
    Figure {
        name: "heavy_top",
        width: 960,
        rows: vec![
            Row {
                height: 330,
                panels: views.collect(),
            },
            Row {
                height: 320,
                panels: vec![tilt, errors],
            },
        ],
    }
}

const CAPTION: &str = "Above: the end of the axis, seen from above, by the midpoint rule up to t = 30; the dashed circle has the angle θ = 0.5 of the start. The spin is 12. The support is shaken with the strength s = 1, seed 5; the axis then falls below the horizontal, where θ > π/2, which x and y do not tell. Below: θ, and the error of the attitude without noise against the angle 12 h; the Cayley chart is written by hand.";

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let top = Top {
        a: 1.0,
        c: 0.5,
        weight: 3.0,
        s: 0.0,
    };
    let shaken = Top { s: 1.0, ..top };
    println!("{}\n", Integrator::new(shaken, Midpoint).plan());
    let rate = steady_precession(top);
    let steady = run(top, start(top, rate))?;
    let nutating = run(top, start(top, 0.0))?;
    let noisy = run(shaken, start(shaken, 0.0))?;

    let errors = charts::errors(top, start(top, 0.0))?;
    let gain = |errors: &[f64], over: &[f64]| errors[errors.len() - 1] / over[over.len() - 1];
    let over_cayley = gain(&errors.cayley, &errors.exponential);
    let over_midpoint = gain(&errors.exponential, &errors.verlet);

    let time = STEPS as f64 * H;
    let kept = "kept by every step, to rounding over 10⁵ steps";
    let second_order = "bounded, of the order h²";
    let checks = [
        Check::new("steady: rate of precession", steady.precession / time).near(
            rate,
            1e-3 * rate,
            "closed form; the error is of the order h²",
        ),
        Check::new("steady: change of the angle", steady.tilt).near(0.0, 2e-3, second_order),
        Check::new("momentum about the vertical, change", nutating.momenta[0])
            .near(0.0, 1e-11, kept),
        Check::new("momentum about the axis, change", nutating.momenta[1]).near(0.0, 1e-11, kept),
        Check::new("nutation: energy, change", nutating.energy).near(0.0, 1e-2, second_order),
        Check::new(
            "shaken: momentum about the vertical, change",
            noisy.momenta[0],
        )
        .near(0.0, 1e-11, kept),
        Check::new("shaken: momentum about the axis, change", noisy.momenta[1])
            .near(0.0, 1e-11, kept),
        Check::new("shaken: energy, change", noisy.energy).reported("the noise changes the energy"),
        Check::new(
            "error of the attitude, Cayley over exponential chart",
            over_cayley,
        )
        .near(450.0, 50.0, "the same small steps"),
        Check::new(
            "error of the attitude, midpoint over Störmer–Verlet",
            over_midpoint,
        )
        .near(1.3, 0.2, "the same small steps"),
    ];
    let figure = figure([&steady, &nutating, &noisy], charts::panel(&errors, SPIN));
    report("Heavy top, h = 0.01, 10⁵ steps", &figure, CAPTION, &checks)
}
