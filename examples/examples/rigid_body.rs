//! Dzhanibekov's flip: a body that spins about its middle axis of inertia turns over, again and
//! again, and noise makes it turn over at random times.
//!
//! The body is a rotation with its angular momentum in the body frame. Without noise the momentum
//! runs along the curve in which the energy ellipsoid cuts the sphere of constant |Π|. Noise H₁ =
//! χ·Π turns the body at random about the axis χ: the momentum leaves the ellipsoid and stays on
//! the sphere, and the momentum in space is kept to rounding.
//!
//! `cargo run --release --example rigid_body` draws `target/rigid_body/rigid_body.svg` and `.png`,
//! and exits with status 1 if a number is off.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use sve_examples::report::report;
use sve_examples::{hues, palette};
use sve_runtime::prelude::*;

/// A free rigid body with principal moments of inertia `i`.
#[derive(Clone, Copy, Debug)]
struct Body {
    i: Vector3<f64>,
    chi: Vector3<f64>,
}

#[variational(midpoint)]
impl Body {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * w.dot(&self.i.component_mul(&w))
    }
    #[h1]
    fn tremor(&self, _r: Rotation3<f64>, pi: Vector3<f64>) -> f64 {
        self.chi.dot(&pi)
    }
}

const H: f64 = 0.01;
const STEPS: usize = 100_000;
/// Number of steps that are drawn.
const DRAWN: usize = 12_000;

/// The properties of a path.
struct Spin {
    momenta: Vec<Vector3<f64>>,
    /// Largest relative change of |Π|².
    casimir: f64,
    /// Largest relative change of RΠ.
    spatial: f64,
    /// Largest relative change of the energy.
    energy: f64,
    /// Times at which the spin about the middle axis changes its sign.
    flips: Vec<f64>,
}

fn run(body: Body, start: State<UnitQuaternion<f64>>) -> Result<Spin, StepError> {
    let integrator = Integrator::new(body, Midpoint);
    let (casimir, spatial) = (start.p.norm_squared(), start.q * start.p);
    let energy = body.hamiltonian(&start)?;
    let mut path = Spin {
        momenta: vec![start.p],
        casimir: 0.0,
        spatial: 0.0,
        energy: 0.0,
        flips: Vec::new(),
    };
    let mut before = start;
    for state in integrator.trajectory(start, H, Wiener::new(11)).take(STEPS) {
        let state = state?;
        let changes = [
            (state.p.norm_squared() / casimir - 1.0).abs(),
            (state.q * state.p - spatial).norm() / spatial.norm(),
            (body.hamiltonian(&state)? / energy - 1.0).abs(),
        ];
        path.casimir = path.casimir.max(changes[0]);
        path.spatial = path.spatial.max(changes[1]);
        path.energy = path.energy.max(changes[2]);
        if before.p.y * state.p.y < 0.0 {
            let part = before.p.y / (before.p.y - state.p.y);
            path.flips.push(before.t + part * H);
        }
        path.momenta.push(state.p);
        before = state;
    }
    Ok(path)
}

/// Returns the complete elliptic integral of the first kind, by the arithmetic-geometric mean.
fn elliptic(m: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - m).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    core::f64::consts::FRAC_PI_2 / a
}

/// Returns the time between two flips of a free body, half of the period of Euler's equations.
/// Source: Landau, Lifshitz, *Mechanics*, § 37.
fn time_between_flips(i: Vector3<f64>, pi: Vector3<f64>) -> f64 {
    let twice_energy = pi.dot(&pi.component_div(&i));
    let square = pi.norm_squared();
    // The momentum runs about the axis of the largest moment if |Π|² > 2 E I₂, otherwise about the
    // axis of the smallest one.
    let (low, high) = if square > twice_energy * i.y {
        (i.x, i.z)
    } else {
        (i.z, i.x)
    };
    let rate = ((high - i.y) * (square - twice_energy * low) / (i.x * i.y * i.z)).sqrt();
    let m = (i.y - low) * (twice_energy * high - square)
        / ((high - i.y) * (square - twice_energy * low));
    2.0 * elliptic(m) / rate
}

/// Projects the sphere of momenta orthographically: right, up, and towards the eye.
fn seen(pi: Vector3<f64>) -> [f64; 3] {
    let eye = Vector3::new(0.62, 0.52, 0.59).normalize();
    let right = eye.cross(&Vector3::z()).normalize() * -1.0;
    let up = eye.cross(&right);
    [pi.dot(&right), pi.dot(&up), pi.dot(&eye)]
}

/// Returns a curve on the sphere, cut where it passes behind: gaps are points that are not drawn.
fn curve(momenta: &[Vector3<f64>], is_front: bool) -> Vec<(f64, f64)> {
    let points = momenta.iter().map(|&pi| {
        let [x, y, depth] = seen(pi);
        if (depth >= 0.0) == is_front {
            (x, y)
        } else {
            (f64::NAN, f64::NAN)
        }
    });
    points.collect()
}

fn sphere(
    title: &str,
    radius: f64,
    levels: &[Vec<Vector3<f64>>],
    path: &[Vector3<f64>],
    color: palette::Color,
) -> Panel {
    let range = -1.08 * radius..1.08 * radius;
    let mut panel = Panel::new(
        title,
        Axis::new("Π, to the right; pale: on the far side", range.clone()),
        Axis::new("Π, upwards", range),
    )
    .equal();
    let circle = (0..=200).map(|k| f64::from(k) * core::f64::consts::TAU / 200.0);
    let circle = circle
        .map(|a| (radius * a.cos(), radius * a.sin()))
        .collect();
    panel = panel.with(Layer::new("sphere", circle, Pen::line(palette::GREY, 1.0)).unlisted());
    for level in levels {
        let front = Layer::new("level", curve(level, true), Pen::line((205, 205, 205), 0.8));
        panel = panel.with(front.unlisted());
    }
    let pale = |c: u8| 255 - (255 - c) / 4;
    let behind = (pale(color.0), pale(color.1), pale(color.2));
    panel = panel.with(Layer::new("behind", curve(path, false), Pen::line(behind, 0.9)).unlisted());
    panel.with(Layer::new("path", curve(path, true), Pen::line(color, 1.2)).unlisted())
}

fn figure(quiet: &Spin, noisy: &Spin, levels: &[Vec<Vector3<f64>>]) -> Figure {
    let radius = quiet.momenta[0].norm();
    let (without, with) = (hues::MIDPOINT, hues::WITH_NOISE);
    let time = |path: &Spin| -> Vec<(f64, f64)> {
        let points = path.momenta.iter().take(DRAWN).enumerate().step_by(4);
        points.map(|(k, pi)| (k as f64 * H, pi.y)).collect()
    };
    let spin = Panel::new(
        "Rigid body: spin about the middle axis",
        Axis::new("time t", 0.0..DRAWN as f64 * H),
        Axis::new("momentum Π₂", -1.1 * radius..1.1 * radius),
    )
    .legend(Corner::Below)
    .with(Layer::new(
        "without noise",
        time(quiet),
        Pen::line(without, 1.3),
    ))
    .with(Layer::new(
        "with noise χ·Π",
        time(noisy),
        Pen::dashed(with, 1.6, (7.0, 3.0)),
    ));
    Figure {
        name: "rigid_body",
        width: 900,
        rows: vec![
            Row {
                height: 440,
                panels: vec![
                    sphere(
                        "Rigid body without noise: Π on one energy ellipsoid",
                        radius,
                        levels,
                        &quiet.momenta[..DRAWN],
                        without,
                    ),
                    sphere(
                        "Rigid body with noise: Π on the sphere |Π| = const",
                        radius,
                        levels,
                        &noisy.momenta[..DRAWN],
                        with,
                    ),
                ],
            },
            Row {
                height: 300,
                panels: vec![spin],
            },
        ],
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let quiet = Body {
        i: Vector3::new(1.0, 2.0, 3.0),
        chi: Vector3::zeros(),
    };
    let noisy = Body {
        chi: Vector3::new(0.06, 0.02, 0.04),
        ..quiet
    };
    println!("{}\n", Integrator::new(noisy, Midpoint).plan());
    // The spin is almost about the middle axis.
    let start = State::new(UnitQuaternion::identity(), Vector3::new(0.02, 2.0, 0.01));
    let without = run(quiet, start)?;
    let with = run(noisy, start)?;

    let between = without.flips.windows(2).map(|pair| pair[1] - pair[0]);
    let between = between.sum::<f64>() / (without.flips.len() - 1) as f64;
    let exact = time_between_flips(quiet.i, start.p);
    let gaps: Vec<f64> = with
        .flips
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .collect();
    let spread =
        gaps.iter().fold(0.0f64, |m, &g| m.max(g)) / gaps.iter().fold(f64::MAX, |m, &g| m.min(g));
    let kept = "kept by every step, to rounding over 10⁵ steps";
    let checks = [
        Check::new("Casimir |Π|², relative change", without.casimir).near(0.0, 1e-12, kept),
        Check::new("… with noise", with.casimir).near(0.0, 1e-12, kept),
        Check::new("momentum in space RΠ, relative change", without.spatial).near(0.0, 1e-12, kept),
        Check::new("… with noise", with.spatial).near(0.0, 1e-12, kept),
        Check::new("energy, relative change", without.energy).near(
            0.0,
            1e-4,
            "bounded, of the order h²",
        ),
        Check::new("energy with noise, relative change", with.energy).near(
            0.55,
            0.45,
            "between 0.1 and 1: the noise changes the energy, within the bounds of the sphere",
        ),
        Check::new("time between flips", between).near(
            exact,
            2e-3 * exact,
            "elliptic integral; the rule has an error of the order h²",
        ),
        Check::new(
            "longest over shortest time between flips with noise",
            spread.min(50.0),
        )
        .near(30.0, 28.0, "flips at random times"),
    ];
    let levels = levels(quiet, start.p.norm())?;
    let caption = "A body with the moments of inertia 1, 2, 3 by the midpoint rule, h = 0.01, that turns almost about its middle axis; 10⁵ steps were checked. Noise: H₁ = χ·Π with χ = (0.06, 0.02, 0.04), seed 11. Grey: intersections of energy ellipsoids with the sphere.";
    let figure = figure(&without, &with, &levels);
    report("Rigid body", &figure, caption, &checks)
}

/// Returns the curves in which energy ellipsoids cut the sphere, as paths of the body without
/// noise.
fn levels(body: Body, radius: f64) -> Result<Vec<Vec<Vector3<f64>>>, StepError> {
    let integrator = Integrator::new(body, Midpoint);
    let mut levels = Vec::new();
    for k in 1..6 {
        let angle = f64::from(k) * 0.25;
        for axis in [Vector3::x(), -Vector3::x(), Vector3::z(), -Vector3::z()] {
            let pi = radius * (axis * angle.cos() + Vector3::y() * angle.sin());
            let mut state = State::new(UnitQuaternion::identity(), pi);
            let mut level = vec![pi];
            for _ in 0..3000 {
                integrator.step(&mut state, H, &[0.0])?;
                level.push(state.p);
            }
            levels.push(level);
        }
    }
    Ok(levels)
}
