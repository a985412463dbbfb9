//! Two bodies in space whose attraction fluctuates: energy wanders, angular and linear momentum
//! stay.
//!
//! L = ½m₁|v₁|² + ½m₂|v₂|² + k/r, γ = σ/r, in vectors of nalgebra. The rotations about three axes
//! and the three shifts are declared as symmetries, so the macro checks that L and the noise have
//! them and gives their momenta. The midpoint rule keeps all six to rounding, whatever the path.
//! Heun’s method, of the same order, keeps linear momentum and loses angular momentum. The noise
//! makes the motion chaotic: the energies after t ≈ 120 change with the last bits of the start, the
//! momenta do not.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::envelope::envelope;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Shape};
use sve_examples::report::{one_row, report};
use sve_examples::{hues, palette};

use sve_runtime::baseline::Heun;
use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

#[derive(Clone, Copy, Debug)]
struct Kepler {
    m: [f64; 2],
    k: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kepler {
    fn lagrangian(&self, q: [Vector3<f64>; 2], v: [Vector3<f64>; 2]) -> f64 {
        let [m1, m2] = self.m;
        let kinetic = 0.5 * m1 * v[0].norm_squared() + 0.5 * m2 * v[1].norm_squared();
        kinetic + self.k / (q[1] - q[0]).norm()
    }

    #[gamma]
    fn attraction(&self, q: [Vector3<f64>; 2]) -> f64 {
        self.sigma / (q[1] - q[0]).norm()
    }

    #[symmetry]
    fn rotation_x(&self, q: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
        q.map(|body| Vector3::x().cross(&body))
    }

    #[symmetry]
    fn rotation_y(&self, q: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
        q.map(|body| Vector3::y().cross(&body))
    }

    #[symmetry]
    fn rotation_z(&self, q: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
        q.map(|body| Vector3::z().cross(&body))
    }

    #[symmetry]
    fn shift_x(&self, _q: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
        [Vector3::x(); 2]
    }

    #[symmetry]
    fn shift_y(&self, _q: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
        [Vector3::y(); 2]
    }

    #[symmetry]
    fn shift_z(&self, _q: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
        [Vector3::z(); 2]
    }
}

type Bodies = State<[Vector3<f64>; 2]>;

const H: f64 = 0.01;
const STEPS: usize = 20_000;

impl Kepler {
    /// Returns the far end of an inclined orbit of eccentricity `e` and semi-major axis 1, with a
    /// slowly moving centre of mass.
    fn start(&self, e: f64) -> Bodies {
        let [m1, m2] = self.m;
        let (total, reduced) = (m1 + m2, m1 * m2 / (m1 + m2));
        let (distance, speed) = (1.0 + e, (self.k / reduced * (1.0 - e) / (1.0 + e)).sqrt());
        let inclination = Rotation3::from_euler_angles(0.6, 0.3, 0.0);
        let separation = inclination * Vector3::x() * distance;
        let momentum = inclination * Vector3::y() * (reduced * speed);
        let drift = Vector3::new(0.05, 0.0, -0.02);
        State::new(
            [-separation * m2 / total, separation * m1 / total],
            [drift * m1 - momentum, drift * m2 + momentum],
        )
    }

    fn angular_momentum(&self, state: &Bodies) -> Vector3<f64> {
        Vector3::new(
            self.rotation_x_momentum(state),
            self.rotation_y_momentum(state),
            self.rotation_z_momentum(state),
        )
    }

    fn linear_momentum(&self, state: &Bodies) -> Vector3<f64> {
        Vector3::new(
            self.shift_x_momentum(state),
            self.shift_y_momentum(state),
            self.shift_z_momentum(state),
        )
    }
}

/// Largest changes along a path.
#[derive(Clone, Copy, Debug, Default)]
struct Changes {
    angular: f64,
    linear: f64,
}

/// Prints the energy and the largest changes of the momenta after each fifth of the time. Returns
/// the changes over the whole time.
fn follow<I: Method<System = Kepler>>(name: &str, method: &I) -> Result<Changes, StepError> {
    let system = method.system();
    let start = system.start(0.6);
    println!("{name}");
    println!(
        "{:>6} {:>10} {:>18} {:>18}",
        "t", "energy", "angular momentum", "linear momentum"
    );
    let mut worst = Changes::default();
    let trajectory = method.trajectory(start, H, Wiener::new(42));
    for (step, state) in (1..=STEPS).zip(trajectory) {
        let state = state?;
        let angular = system.angular_momentum(&state) - system.angular_momentum(&start);
        let linear = system.linear_momentum(&state) - system.linear_momentum(&start);
        worst.angular = worst.angular.max(angular.norm());
        worst.linear = worst.linear.max(linear.norm());
        if step % (STEPS / 5) == 0 {
            let energy = system.hamiltonian(&state)?;
            println!(
                "{:>6.0} {:>10} {:>18} {:>18}",
                state.t,
                number(energy, 5),
                number(worst.angular, 2),
                number(worst.linear, 2)
            );
        }
    }
    println!();
    Ok(worst)
}

/// Returns the separation of the bodies along a path, seen from above its first plane.
fn orbit(
    midpoint: &Integrator<Kepler, Midpoint>,
    sigma: f64,
    steps: usize,
) -> Result<Vec<(f64, f64)>, StepError> {
    let system = Kepler {
        sigma,
        ..*midpoint.system()
    };
    let turned = Rotation3::from_euler_angles(0.6, 0.3, 0.0).inverse();
    let path = Integrator::new(system, Midpoint);
    let trajectory = path.trajectory(system.start(0.6), H, Wiener::new(42));
    let point = |state: Result<Bodies, StepError>| {
        let state = state?;
        let separation = turned * (state.q[1] - state.q[0]);
        Ok((separation.x, separation.y))
    };
    trajectory.take(steps).map(point).collect()
}

/// Returns the largest change of the angular momentum in each two-hundredth of the time.
fn changes<I: Method<System = Kepler>>(method: &I) -> Result<Vec<(f64, f64)>, StepError> {
    let system = method.system();
    let start = system.start(0.6);
    let first = system.angular_momentum(&start);
    let change = |state: Result<Bodies, StepError>| {
        let state = state?;
        Ok((state.t, (system.angular_momentum(&state) - first).norm()))
    };
    envelope(
        method
            .trajectory(start, H, Wiener::new(42))
            .take(STEPS)
            .map(change),
        STEPS / 200,
    )
}

fn figure(midpoint: &Integrator<Kepler, Midpoint>) -> Result<Figure, StepError> {
    let axis = |name| Axis::new(name, -2.0..2.0);
    let plane = Panel::new("Separation of the bodies, t ≤ 25", axis("x"), axis("y"))
        .equal()
        .with(Layer::new(
            "with noise",
            orbit(midpoint, 0.015, 2500)?,
            Pen::dashed(hues::WITH_NOISE, 1.0, (7.0, 2.0)),
        ))
        .with(Layer::new(
            "without",
            orbit(midpoint, 0.0, 2500)?,
            Pen::line(hues::MIDPOINT, 1.0),
        ))
        .with(Layer::new("", vec![(0.0, 0.0)], Pen::dots(palette::BLACK, 3.0)).unlisted())
        .legend(Corner::TopRight);
    let momentum = Panel::new(
        format!("Change of the angular momentum on one path, h = {H}"),
        Axis::new("time t", 0.0..H * STEPS as f64),
        Axis::powers("largest |L − L₀| in each 1/200 of the time", -17.0..0.0),
    )
    .with(Layer::new(
        "Heun",
        changes(&Heun::new(*midpoint.system()))?,
        Pen::dashed(hues::HEUN, 1.5, (6.0, 3.0)),
    ))
    .with(Layer::new(
        "midpoint rule",
        changes(midpoint)?,
        Pen::line(hues::MIDPOINT, 1.5).symbols(Shape::Disc, 8),
    ))
    .legend(Corner::TopRight);
    Ok(one_row("kepler", [1080, 480], vec![plane, momentum]))
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let system = Kepler {
        m: [1.0, 0.5],
        k: 1.0,
        sigma: 0.01,
    };
    let midpoint = Integrator::new(system, Midpoint);
    println!("{}\n", midpoint.plan());
    println!("largest change of each momentum so far, h = {H}\n");
    let kept = follow("midpoint rule", &midpoint)?;
    let lost = follow("Heun's method", &Heun::new(system))?;

    let why = "20,000 rounding errors of 10⁻¹⁶, all of one sign, would add up to 2·10⁻¹²";
    let checks = [
        Check::new(
            "midpoint rule: largest change of the angular momentum",
            kept.angular,
        )
        .near(0.0, 2e-12, why),
        Check::new(
            "midpoint rule: largest change of the linear momentum",
            kept.linear,
        )
        .near(0.0, 2e-12, why),
        Check::new("Heun: largest change of the angular momentum", lost.angular)
            .reported("a method that keeps no momentum map of a rotation"),
    ];
    let caption = "Left: the orbit turns slowly, by the error of the rule, and wanders with noise σ = 0.015. Right, with σ = 0.01: the midpoint rule keeps the angular momentum to rounding. Seed 42.";
    report("Two bodies", &figure(&midpoint)?, caption, &checks)
}
