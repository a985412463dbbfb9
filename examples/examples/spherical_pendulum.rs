//! A spherical pendulum in Cartesian coordinates: the constraint |q| = 1 replaces angles, and the
//! poles are not singular.
//!
//! The midpoint rule keeps the constraint and the momentum about the vertical to rounding, with
//! noise too. A pendulum that swings over the upper pole moves like a pendulum in an angle. In a
//! heat bath it has the heights of the canonical distribution, `E z = 1/β − coth β` with β = g/kT.
//! The picture is written to `target/spherical_pendulum/`.

use std::error::Error;
use std::f64::consts::FRAC_PI_4;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Layer, Panel, Pen, Row};
use sve_examples::report::{one_row, report};
use sve_examples::{hues, palette};
use sve_runtime::prelude::*;

/// A heavy particle on the unit sphere. Noise pulls along the vertical, so that the momentum about
/// the vertical stays constant.
#[derive(Clone, Copy, Debug)]
struct Spherical {
    g: f64,
    sigma: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Spherical {
    fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    #[gamma]
    fn lift(&self, q: Vector3<f64>) -> f64 {
        self.sigma * q.z
    }

    #[symmetry]
    fn turn(&self, q: Vector3<f64>) -> Vector3<f64> {
        Vector3::new(-q.y, q.x, 0.0)
    }

    #[constraint]
    fn sphere(&self, q: Vector3<f64>) -> f64 {
        0.5 * (q.norm_squared() - 1.0)
    }
}

/// The same particle in a heat bath.
#[derive(Clone, Copy, Debug)]
struct Bath {
    g: f64,
    nu: f64,
    kt: f64,
}

#[variational(midpoint)]
impl Bath {
    fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    #[force]
    fn friction(&self, _q: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {
        v * -self.nu
    }

    #[gamma]
    fn kicks(&self, q: Vector3<f64>) -> Vector3<f64> {
        q * (2.0 * self.nu * self.kt).sqrt()
    }

    #[constraint]
    fn sphere(&self, q: Vector3<f64>) -> f64 {
        0.5 * (q.norm_squared() - 1.0)
    }
}

/// A pendulum in the angle from its lowest point.
#[derive(Clone, Copy, Debug)]
struct Planar {
    g: f64,
}

#[variational(midpoint)]
impl Planar {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

const G: f64 = 1.0;
const H: f64 = 0.02;

type Path3 = Vec<State<Vector3<f64>>>;

fn path(sigma: f64, h: f64, start: State<Vector3<f64>>, steps: usize) -> Result<Path3, StepError> {
    let midpoint = Integrator::new(Spherical { g: G, sigma }, Midpoint);
    let start = midpoint.consistent(start)?;
    let rest: Result<Path3, StepError> = midpoint
        .trajectory(start, h, Wiener::new(2))
        .take(steps)
        .collect();
    Ok([vec![start], rest?].concat())
}

fn largest(path: &Path3, of: impl Fn(&State<Vector3<f64>>) -> f64) -> f64 {
    path.iter().map(|state| of(state).abs()).fold(0.0, f64::max)
}

/// Checks the quantities that the path with noise keeps.
fn kept(path: &Path3) -> [Check; 3] {
    let system = Spherical { g: G, sigma: 0.3 };
    let moment = system.turn_momentum(&path[0]);
    let rounding = "rounding";
    let drift = largest(path, |s| system.turn_momentum(s) - moment);
    [
        Check::new(
            "largest |q|² − 1",
            largest(path, |s| s.q.norm_squared() - 1.0),
        )
        .near(0.0, 2e-15, rounding),
        Check::new("largest ⟨q, p⟩", largest(path, |s| s.q.dot(&s.p))).near(0.0, 4e-15, rounding),
        Check::new("change of the momentum about the vertical", drift).near(0.0, 1e-13, rounding),
    ]
}

/// Checks the energy without noise, in both halves of a long run.
fn energy(path: &Path3) -> Result<[Check; 2], StepError> {
    let system = Spherical { g: G, sigma: 0.0 };
    let energies: Result<Vec<f64>, StepError> =
        path.iter().map(|s| system.hamiltonian(s)).collect();
    let energies = energies?;
    let worst = |half: &[f64]| {
        half.iter()
            .map(|e| (e - energies[0]).abs())
            .fold(0.0, f64::max)
    };
    let (first, second) = energies.split_at(energies.len() / 2);
    Ok([
        Check::new("largest energy error", worst(&energies)).near(
            0.0,
            1e-4,
            "h² times a constant of the motion",
        ),
        Check::new(
            "second half of it over the first",
            worst(second) / worst(first),
        )
        .near(1.0, 0.02, "no drift"),
    ])
}

/// Returns the heights of a swing over the upper pole, and the heights of the pendulum in an angle.
fn over_the_pole(h: f64) -> Result<[Vec<(f64, f64)>; 2], StepError> {
    #[allow(clippy::cast_sign_loss)] // h is positive
    let steps = (20.0 / h).round() as usize;
    let speed = 2.2;
    let start = State::new(Vector3::new(0.0, 0.0, -1.0), Vector3::new(speed, 0.0, 0.0));
    let planar = Integrator::new(Planar { g: G }, Midpoint);
    // The step is so fine that its own error is negligible.
    let fine = 20_u8;
    let angle: Result<Vec<_>, StepError> = planar
        .trajectory(State::new([0.0], [speed]), h / f64::from(fine), NoNoise)
        .skip(usize::from(fine) - 1)
        .step_by(usize::from(fine))
        .take(steps)
        .collect();
    let sphere = path(0.0, h, start, steps)?;
    let mut heights = [Vec::new(), Vec::new()];
    heights[0].extend(sphere.iter().skip(1).map(|s| (s.t, s.q.z)));
    heights[1].extend(angle?.iter().map(|s| (s.t, -s.q[0].cos())));
    Ok(heights)
}

/// Checks mean height and kinetic energy in a heat bath, by an ensemble.
fn bath() -> Result<[Check; 2], Box<dyn Error>> {
    let system = Bath {
        g: G,
        nu: 1.0,
        kt: 1.0,
    };
    let midpoint = Integrator::new(system, Midpoint);
    let start = State::new(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros());
    let (mut height, mut kinetic, paths) = (Vec::new(), Vec::new(), 200);
    for number in 0..paths {
        let path = midpoint.trajectory(start, 0.05, Wiener::new(7).path(number));
        let (mut z, mut square, count) = (0.0, 0.0, 4000);
        for state in path.skip(200).take(count) {
            let state = state?;
            z += state.q.z / count as f64;
            square += state.p.norm_squared() / count as f64;
        }
        height.push(z);
        kinetic.push(square);
    }
    let check = |what: &str, list: &[f64], expected: f64, bias: f64| {
        let n = list.len() as f64;
        let mean = list.iter().sum::<f64>() / n;
        let error = (list.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
        let reason = format!("4 standard errors of {error:.4}, and h² of the rule");
        Check::new(what, mean).near(expected, 4.0 * error + bias, reason)
    };
    let beta = system.g / system.kt;
    Ok([
        check(
            "mean height at kT = g",
            &height,
            1.0 / beta - 1.0 / beta.tanh(),
            0.002,
        ),
        check("mean |p|² at kT = g", &kinetic, 2.0 * system.kt, 0.008),
    ])
}

/// Returns a polyline as its visible and its hidden part, seen from a point above the equator;
/// breaks are NaN.
fn seen(points: impl Iterator<Item = Vector3<f64>>) -> [Vec<(f64, f64)>; 2] {
    let tilt: f64 = 0.35;
    let mut parts = [Vec::new(), Vec::new()];
    for q in points {
        let depth = q.y * tilt.cos() - q.z * tilt.sin();
        let at = (q.x, q.z * tilt.cos() + q.y * tilt.sin());
        let gap = (f64::NAN, f64::NAN);
        let is_hidden = depth > 0.0;
        parts[usize::from(is_hidden)].push(at);
        parts[usize::from(!is_hidden)].push(gap);
    }
    parts
}

fn sphere(title: &str, path: &Path3, color: palette::Color) -> Panel {
    let circle = |f: &dyn Fn(f64) -> Vector3<f64>| {
        let angles = (0..=180).map(|k| f64::from(k) * std::f64::consts::TAU / 180.0);
        seen(angles.map(f))[0].clone()
    };
    let grey = Pen::line((205, 205, 205), 0.8);
    let outline: Vec<(f64, f64)> = (0..=180)
        .map(|k| f64::from(k) * std::f64::consts::TAU / 180.0)
        .map(|a| (a.cos(), a.sin()))
        .collect();
    let mut panel = Panel::new(
        title,
        Axis::new("x", -1.1..1.1),
        Axis::new("height, seen from 20° above", -1.1..1.1),
    );
    panel = panel
        .equal()
        .with(Layer::new("sphere", outline, Pen::line(palette::GREY, 1.0)).unlisted());
    for latitude in [-0.6f64, 0.0, 0.6] {
        let (z, r) = latitude.sin_cos();
        let points = circle(&|a| Vector3::new(r * a.cos(), r * a.sin(), z));
        panel = panel.with(Layer::new("latitude", points, grey).unlisted());
    }
    for quarter in 0..4 {
        let longitude = f64::from(quarter) * FRAC_PI_4;
        let points = circle(&|a| {
            Vector3::new(
                a.cos() * longitude.cos(),
                a.cos() * longitude.sin(),
                a.sin(),
            )
        });
        panel = panel.with(Layer::new("longitude", points, grey).unlisted());
    }
    let pale = |x: u8| x / 3 + 170;
    let faint = (pale(color.0), pale(color.1), pale(color.2));
    let [front, back] = seen(path.iter().map(|s| s.q));
    panel
        .with(Layer::new("behind", back, Pen::line(faint, 0.8)).unlisted())
        .with(Layer::new("path", front, Pen::line(color, 1.2)).unlisted())
}

/// Draws the swing over the upper pole, and its difference from the pendulum in an angle.
fn swings([cartesian, angle]: [Vec<(f64, f64)>; 2]) -> [Panel; 2] {
    let differences = cartesian.iter().zip(&angle).map(|(a, b)| (a.0, a.1 - b.1));
    let differences: Vec<(f64, f64)> = differences.collect();
    let largest = differences
        .iter()
        .fold(0.0, |most: f64, x| most.max(x.1.abs()));
    let time = || Axis::new("time t", 0.0..20.0);
    let pen = Pen::line(hues::MIDPOINT, 1.2);
    let height = Axis::new("height", -1.1..1.1);
    let difference = Axis::new("difference of heights", -1.1 * largest..1.1 * largest);
    [
        Panel::new(
            "Over the upper pole, in Cartesian coordinates",
            time(),
            height,
        )
        .with(Layer::new("Cartesian", cartesian, pen)),
        Panel::new(
            "Its height less that of the pendulum in an angle",
            time(),
            difference,
        )
        .with(Layer::new("difference", differences, pen)),
    ]
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let start = State::new(Vector3::new(0.9, 0.0, -0.44), Vector3::new(0.0, 0.45, 0.0));
    println!(
        "{}\n",
        Integrator::new(Spherical { g: G, sigma: 0.3 }, Midpoint).plan()
    );
    let quiet = path(0.0, H, start, 20_000)?;
    let noisy = path(0.3, H, start, 20_000)?;
    let swing = over_the_pole(H)?;
    let apart = |[a, b]: &[Vec<(f64, f64)>; 2]| {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max)
    };
    let ratio = apart(&swing) / apart(&over_the_pole(0.5 * H)?);
    let mut checks: Vec<Check> = kept(&noisy).into();
    checks.extend(energy(&quiet)?);
    let highest = swing[0].iter().map(|x| x.1).fold(-1.0, f64::max);
    checks.push(
        Check::new("highest point of the swing over the pole", highest).near(
            1.0,
            1e-3,
            "a point within a step of the pole",
        ),
    );
    checks.push(
        Check::new(
            "its distance from the pendulum in an angle, h over h/2",
            ratio,
        )
        .near(4.0, 0.1, "order 2, with both poles on the way"),
    );
    checks.extend(bath()?);

    let mut figure = one_row(
        "spherical_pendulum",
        [1000, 500],
        vec![
            sphere("Without noise", &quiet[..3000].to_vec(), hues::MIDPOINT),
            sphere(
                "With noise along the vertical",
                &noisy[..3000].to_vec(),
                hues::WITH_NOISE,
            ),
        ],
    );
    figure.rows.push(Row {
        height: 320,
        panels: swings(swing).into(),
    });
    let caption = "Midpoint rule, h = 0.02, g = 1. Above: 3,000 steps from one start, without noise and with σ = 0.3, seed 2; pale: the far side. Below: a swing through the upper pole, and its difference from a pendulum in an angle.";
    report("Spherical pendulum", &figure, caption, &checks)
}
