//! A quadrotor in gusts: attitude and height under a digital controller.
//!
//! The vehicle is a body with a place. Its controller reads the state at the start of each step and
//! holds a thrust along the axis of the body and a torque over it: four inputs. Gusts are torques
//! in the frame of the body, noises that no potential has. The attitude is a rotation, so that the
//! controller rights the vehicle from a tilt of 150 degrees.
//!
//! `cargo run --release --example quadrotor` draws `target/quadrotor/quadrotor.svg` and `.png`, and
//! exits with status 1 if a number is off.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::palette;
use sve_examples::report::{one_row, report};
use sve_runtime::nalgebra::{Matrix2, Vector2};
use sve_runtime::prelude::*;

/// Mass, moments of inertia, weight, and the strength of the gusts about each axis.
#[derive(Clone, Copy, Debug)]
struct Quadrotor {
    m: f64,
    inertia: Vector3<f64>,
    g: f64,
    gust: f64,
}

type Place = (Vector3<f64>, UnitQuaternion<f64>);

#[variational(stormer_verlet)]
impl Quadrotor {
    fn lagrangian(
        &self,
        q: Vector3<f64>,
        _r: Rotation3<f64>,
        v: Vector3<f64>,
        w: Vector3<f64>,
    ) -> f64 {
        0.5 * self.m * v.norm_squared() + 0.5 * w.dot(&self.inertia.component_mul(&w))
            - self.m * self.g * q.z
    }
    /// The thrust along the axis of the body, and the torques of the propellers.
    #[force]
    fn propellers(
        &self,
        _q: Vector3<f64>,
        r: Rotation3<f64>,
        _v: Vector3<f64>,
        _w: Vector3<f64>,
        u: [f64; 4],
    ) -> (Vector3<f64>, Vector3<f64>) {
        let axis = r * Vector3::z();
        (axis * u[0], Vector3::new(u[1], u[2], u[3]))
    }
    #[force(noise)]
    fn roll(
        &self,
        _q: Vector3<f64>,
        _r: Rotation3<f64>,
        _v: Vector3<f64>,
        _w: Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        (
            Vector3::new(0.0, 0.0, 0.0),
            Vector3::new(self.gust, 0.0, 0.0),
        )
    }
    #[force(noise)]
    fn pitch(
        &self,
        _q: Vector3<f64>,
        _r: Rotation3<f64>,
        _v: Vector3<f64>,
        _w: Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        (
            Vector3::new(0.0, 0.0, 0.0),
            Vector3::new(0.0, self.gust, 0.0),
        )
    }
    #[force(noise)]
    fn yaw(
        &self,
        _q: Vector3<f64>,
        _r: Rotation3<f64>,
        _v: Vector3<f64>,
        _w: Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        (
            Vector3::new(0.0, 0.0, 0.0),
            Vector3::new(0.0, 0.0, self.gust),
        )
    }
}

const QUADROTOR: Quadrotor = Quadrotor {
    m: 1.0,
    inertia: Vector3::new(0.01, 0.01, 0.02),
    g: 9.81,
    gust: 0.002,
};

/// Length of a step, which the controller holds.
const H: f64 = 0.005;
/// Gains of the attitude: stiffness and damping of an oscillation for the moments of inertia.
const STIFFNESS: f64 = 60.0;
const DAMPING: f64 = 12.0;

/// Returns the thrust and the torques for a state: level, without yaw, at the height 0.
fn controller(state: &State<Place>) -> [f64; 4] {
    let ((place, attitude), (momentum, spin)) = (state.q, state.p);
    let r = attitude.to_rotation_matrix();
    let inertia = QUADROTOR.inertia;
    // the vector of (R − Rᵀ)/2, in the frame of the body
    let tilt = 0.5
        * Vector3::new(
            r[(2, 1)] - r[(1, 2)],
            r[(0, 2)] - r[(2, 0)],
            r[(1, 0)] - r[(0, 1)],
        );
    let torque = -STIFFNESS * inertia.component_mul(&tilt) - DAMPING * spin;
    let climb = QUADROTOR.g - 4.0 * place.z - 4.0 * momentum.z / QUADROTOR.m;
    // the propellers only push, and cannot lift a vehicle that is upside down
    let thrust = QUADROTOR.m * climb.clamp(0.0, 2.0 * QUADROTOR.g) * r[(2, 2)].max(0.0);
    [thrust, torque.x, torque.y, torque.z]
}

/// The angle of the axis of the body from the vertical, in degrees.
fn tilt(state: &State<Place>) -> f64 {
    let axis = state.q.1 * Vector3::z();
    axis.z.clamp(-1.0, 1.0).acos().to_degrees()
}

/// Returns a start that is tilted about the first axis.
fn start(degrees: f64) -> State<Place> {
    let attitude = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), degrees.to_radians());
    State::new(
        (Vector3::zeros(), attitude),
        (Vector3::zeros(), Vector3::zeros()),
    )
}

/// Returns a path of a controlled or free vehicle.
fn path(
    start: State<Place>,
    is_controlled: bool,
    seed: u64,
    steps: usize,
) -> Result<Vec<State<Place>>, StepError> {
    let hover = [QUADROTOR.m * QUADROTOR.g, 0.0, 0.0, 0.0];
    let integrator = Integrator::new(QUADROTOR, StormerVerlet);
    let path = integrator.trajectory(start, H, Wiener::new(seed));
    let path = path.inputs(|_, state| {
        if is_controlled {
            controller(state)
        } else {
            hover
        }
    });
    path.take(steps).collect()
}

/// The closed form of the mean squares of the angle and of the spin about the first axis, for small
/// angles: one step is a linear map x₁ = A x + b ΔW, and the covariance is the fixed point of
/// C = A C Aᵀ + h b bᵀ.
fn stationary() -> [f64; 2] {
    let j = QUADROTOR.inertia.x;
    // the torque u = −J k a − c Π is held over the step, whose halves are kicks of h u + σ ΔW
    let torque = Vector2::new(-STIFFNESS * j, -DAMPING) * H;
    let spin = torque + Vector2::y();
    let angle = (0.5 * torque + Vector2::y()) * (H / j) + Vector2::x();
    let map = Matrix2::from_rows(&[angle.transpose(), spin.transpose()]);
    let noise = Vector2::new(0.5 * H / j, 1.0) * QUADROTOR.gust;
    let source = noise * noise.transpose() * H;
    let mut covariance = Matrix2::zeros();
    // the slowest mode decays at a rate above 5, so 4000 steps leave nothing of the start
    for _ in 0..4000 {
        covariance = map * covariance * map.transpose() + source;
    }
    [covariance[(0, 0)], covariance[(1, 1)]]
}

/// Returns the mean squares of the first component of the tilt vector and of the spin momentum,
/// from one long path after it has forgotten its start.
fn mean_squares() -> Result<[f64; 2], StepError> {
    let states = path(start(0.0), true, 3, 400_000)?;
    let settled = &states[2000..];
    let mut sums = [0.0; 2];
    for state in settled {
        let r = state.q.1.to_rotation_matrix();
        let angle = 0.5 * (r[(2, 1)] - r[(1, 2)]);
        sums[0] += angle * angle;
        sums[1] += state.p.1.x * state.p.1.x;
    }
    Ok(sums.map(|sum| sum / settled.len() as f64))
}

/// The mean energy of a free body grows by ½ Σ f·J⁻¹f t under torques f of its frame.
fn mean_energy() -> Result<[f64; 2], StepError> {
    let (paths, steps) = (4000_u64, 100);
    let integrator = Integrator::new(QUADROTOR, StormerVerlet);
    let weight = [QUADROTOR.m * QUADROTOR.g, 0.0, 0.0, 0.0];
    let mut energies = Vec::new();
    for seed in 0..paths {
        let path = integrator.trajectory(start(0.0), H, Wiener::new(7).path(seed));
        let end = path.inputs(|_, _| weight).take(steps).last();
        let Some(end) = end else { continue };
        let spin = end?.p.1;
        energies.push(0.5 * spin.dot(&spin.component_div(&QUADROTOR.inertia)));
    }
    let count = energies.len() as f64;
    let mean = energies.iter().sum::<f64>() / count;
    let variance = energies.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (count - 1.0);
    Ok([mean, (variance / count).sqrt()])
}

/// Returns a line of a number of each state against the time.
fn line(
    label: &str,
    states: &[State<Place>],
    number: impl Fn(&State<Place>) -> f64,
    color: palette::Color,
) -> Layer {
    let points: Vec<_> = states
        .iter()
        .map(|state| (state.t, number(state)))
        .collect();
    Layer::new(label, points, Pen::line(color, 1.6))
}

fn figure(righted: &[State<Place>]) -> Result<Figure, StepError> {
    let [held, free] = [true, false].map(|is_controlled| path(start(0.0), is_controlled, 2, 2000));
    let righting = Panel::new(
        "Righted from a tilt of 150°",
        Axis::new("time t", 0.0..5.0),
        Axis::new("tilt in degrees", 0.0..160.0),
    )
    .with(line("tilt", righted, tilt, palette::BLUE));
    let lowest = righted.iter().map(|state| state.q.0.z).fold(0.0, f64::min);
    let height = Panel::new(
        "Its height",
        Axis::new("time t", 0.0..5.0),
        Axis::new("height", (1.15 * lowest)..0.5),
    )
    .with(line("height", righted, |state| state.q.0.z, palette::BLUE));
    let gusts = Panel::new(
        "The same gusts, with the controller and without",
        Axis::new("time t", 0.0..10.0),
        Axis::new("tilt in degrees", 0.0..60.0),
    )
    .with(line("without", &free?, tilt, palette::ORANGE))
    .with(line("controlled", &held?, tilt, palette::BLUE))
    .legend(Corner::TopLeft);
    let panels = vec![righting, height, gusts];
    Ok(one_row("quadrotor", [1320, 440], panels))
}

fn checks(righted: &[State<Place>]) -> Result<Vec<Check>, StepError> {
    let found = mean_squares()?;
    let closed = stationary();
    // 2000 units of time hold about 10 000 independent angles
    let ratio = |name, i: usize| {
        Check::new(name, found[i] / closed[i]).near(
            1.0,
            0.06,
            "4 standard errors of one path of 400 000 steps",
        )
    };
    let [energy, error] = mean_energy()?;
    let rate = 0.5 * QUADROTOR.gust.powi(2) * QUADROTOR.inertia.map(f64::recip).sum();
    let expected = rate * 100.0 * H;
    let end = righted.last().map_or(f64::NAN, tilt);
    Ok(vec![
        Check::new("tilt at the end of the righting, in degrees", end).near(
            0.0,
            1.0,
            "the gusts tilt it by 0.4° in the root mean square",
        ),
        ratio("mean square of an angle over the closed form", 0),
        ratio("mean square of a spin over the closed form", 1),
        Check::new(
            "mean energy of the spin without control over ½ Σ f·J⁻¹f t",
            energy / expected,
        )
        .near(
            1.0,
            4.0 * error / expected,
            "4 standard errors of 4000 paths",
        ),
    ])
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let integrator = Integrator::new(QUADROTOR, StormerVerlet);
    println!("{}\n", integrator.plan().structure());
    let righted = path(start(150.0), true, 1, 1000)?;
    let caption = "A controller reads the state once a step of 0.005 and holds the thrust and three torques over it. Left: it rights the vehicle from a tilt of 150 degrees; the propellers only push, so it falls meanwhile. Right: the torques of the gusts act in the frame of the body. Seed 1, and 2 on the right.";
    report("Quadrotor", &figure(&righted)?, caption, &checks(&righted)?)
}
