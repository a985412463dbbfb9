//! Three equal masses that chase one another along a figure eight, a first program with vectors;
//! and three masses that meet closely, with a time scale.
//!
//! L = Σ ½mᵢ|vᵢ|² + Σ g mᵢmⱼ/|qᵢ − qⱼ|. The figure eight was found by Chenciner and Montgomery
//! (Annals of Mathematics 152, 2000); the initial values are by Simó. After one period the bodies
//! are back where they started, up to the error of the midpoint rule, which is of order 2. The
//! energy error stays bounded, and the momenta are kept to rounding. The Pythagorean problem of
//! Burrau has steps of equal lengths in τ, where dt = (Σ (mᵢ + mⱼ)/r³)^{−½} dτ. Status 1 if a
//! number is off. Writes `target/three_body/`.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use sve_examples::palette;
use sve_examples::report::report;
use sve_runtime::prelude::*;

struct ThreeBody {
    m: [f64; 3],
    g: f64,
}

#[variational(midpoint)]
impl ThreeBody {
    fn lagrangian(&self, q: [Vector2<f64>; 3], v: [Vector2<f64>; 3]) -> f64 {
        let mut l = 0.0;
        for i in 0..3 {
            l += 0.5 * self.m[i] * v[i].norm_squared();
            for j in 0..i {
                l += self.g * self.m[i] * self.m[j] / (q[i] - q[j]).norm();
            }
        }
        l
    }

    #[symmetry]
    fn rotation(&self, q: [Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
        q.map(|body| Vector2::new(-body.y, body.x))
    }

    #[symmetry]
    fn shift_x(&self, _q: [Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
        [Vector2::x(); 3]
    }

    #[symmetry]
    fn shift_y(&self, _q: [Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
        [Vector2::y(); 3]
    }
}

type Bodies = State<[Vector2<f64>; 3]>;

const PERIOD: f64 = 6.325_913_98;

/// Returns the start of the figure eight for unit masses and g = 1: one body in the centre, the
/// others opposite each other.
fn figure_eight() -> Bodies {
    let q = Vector2::new(0.970_004_36, -0.243_087_53);
    let p = Vector2::new(-0.932_407_37, -0.864_731_46);
    State::new([q, -q, Vector2::zeros()], [-p / 2.0, -p / 2.0, p])
}

/// Returns the largest distance of a body from its place in the other state.
fn distance(a: &Bodies, b: &Bodies) -> f64 {
    let distances = a.q.iter().zip(&b.q).map(|(a, b)| (a - b).norm());
    distances.fold(0.0, f64::max)
}

/// Steps through one period with two step sizes. Returns the order at which the distance from the
/// start vanishes.
fn close_the_orbit(method: &Integrator<ThreeBody, Midpoint>) -> Result<f64, StepError> {
    let start = figure_eight();
    println!("{:>16} {:>20}", "steps a period", "distance from start");
    let mut gaps = [0.0; 2];
    for (gap, steps) in gaps.iter_mut().zip([1000, 2000]) {
        let mut state = start;
        for _ in 0..steps {
            method.step(&mut state, PERIOD / f64::from(steps), &[])?;
        }
        *gap = distance(&state, &start);
        println!("{steps:>16} {gap:>20.2e}");
    }
    let order = (gaps[0] / gaps[1]).log2();
    println!("observed order: {order:.2}\n");
    Ok(order)
}

/// Follows the orbit for 100 periods of 1000 steps. Returns the largest changes of energy, angular
/// momentum and linear momentum.
fn follow(method: &Integrator<ThreeBody, Midpoint>) -> Result<[f64; 3], StepError> {
    let system = method.system();
    let start = figure_eight();
    let first = system.hamiltonian(&start)?;
    println!("largest change so far of");
    println!(
        "{:>8} {:>10} {:>18} {:>17}",
        "periods", "energy", "angular momentum", "linear momentum"
    );
    let mut worst = [0.0_f64; 3];
    let trajectory = method.trajectory(start, PERIOD / 1000.0, NoNoise);
    for (step, state) in (1..=100_000).zip(trajectory) {
        let state = state?;
        let linear = Vector2::new(
            system.shift_x_momentum(&state),
            system.shift_y_momentum(&state),
        );
        // The momenta are zero at the start.
        let changes = [
            (system.hamiltonian(&state)? - first).abs(),
            system.rotation_momentum(&state).abs(),
            linear.norm(),
        ];
        for (worst, change) in worst.iter_mut().zip(changes) {
            *worst = worst.max(change);
        }
        if step % 20_000 == 0 {
            let [energy, angular, linear] = worst;
            println!(
                "{:>8} {energy:>10.1e} {angular:>18.1e} {linear:>17.1e}",
                step / 1000
            );
        }
    }
    Ok(worst)
}

/// Three bodies whose steps are short at close encounters.
struct Pythagorean {
    m: [f64; 3],
}

#[variational(gauss(8))]
impl Pythagorean {
    fn lagrangian(&self, q: [Vector2<f64>; 3], v: [Vector2<f64>; 3]) -> f64 {
        let mut l = 0.0;
        for i in 0..3 {
            l += 0.5 * self.m[i] * v[i].norm_squared();
            for j in 0..i {
                l += self.m[i] * self.m[j] / (q[i] - q[j]).norm();
            }
        }
        l
    }

    #[time_scale]
    fn scale(&self, q: [Vector2<f64>; 3]) -> f64 {
        let mut rate = 0.0;
        for i in 0..3 {
            for j in 0..i {
                let r = (q[i] - q[j]).norm();
                rate += (self.m[i] + self.m[j]) / (r * r * r);
            }
        }
        1.0 / rate.sqrt()
    }
}

/// Length of a step in τ, and the end of the path in t.
const H: f64 = 0.2;
const END: f64 = 70.0;

/// A path of the Pythagorean problem.
struct Encounter {
    masses: [f64; 3],
    states: Vec<Bodies>,
    /// The state at the end.
    end: Bodies,
    /// The time of each step, and |H − E|/|E|, as powers of ten.
    lengths: Vec<(f64, f64)>,
    errors: Vec<(f64, f64)>,
    largest: f64,
    /// The least distance of two bodies, and its time.
    closest: (f64, f64),
}

/// Follows bodies of masses 3, 4 and 5, at rest in the corners of a triangle with these sides
/// opposite of them, with steps of this length in τ.
fn encounter(h: f64) -> Result<Encounter, StepError> {
    let masses = [3.0, 4.0, 5.0];
    let bodies = Integrator::new(Pythagorean { m: masses }, Gauss::<8>);
    let corners = [(1.0, 3.0), (-2.0, -1.0), (1.0, -1.0)].map(|(x, y)| Vector2::new(x, y));
    let start = TimedState::new(bodies.system(), corners, [Vector2::zeros(); 3])?;
    let path = bodies.trajectory(start, h, NoNoise).every(1).until(END);
    let states: Vec<Bodies> = path.collect::<Result<_, _>>()?;
    let (mut lengths, mut errors) = (Vec::new(), Vec::new());
    let (mut largest, mut closest) = (0.0_f64, (f64::INFINITY, 0.0));
    for (before, state) in states.iter().zip(&states[1..]) {
        let error = (bodies.system().hamiltonian(state)? / start.energy() - 1.0).abs();
        largest = largest.max(error);
        errors.push((state.t, error.log10()));
        lengths.push((state.t, (state.t - before.t).log10()));
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let distance = (state.q[i] - state.q[j]).norm();
            if distance < closest.0 {
                closest = (distance, state.t);
            }
        }
    }
    // The last step ends at the end of the path.
    lengths.pop();
    let end = states[states.len() - 1];
    Ok(Encounter {
        masses,
        states,
        end,
        lengths,
        errors,
        largest,
        closest,
    })
}

/// Returns the places of each body along a path.
fn orbits(states: &[Bodies]) -> [Vec<(f64, f64)>; 3] {
    core::array::from_fn(|i| {
        states
            .iter()
            .map(|state| (state.q[i].x, state.q[i].y))
            .collect()
    })
}

/// Draws the paths of the bodies, with a dot where each body is at the start.
fn plane(title: &str, [x, y]: [Axis; 2], m: [f64; 3], states: &[Bodies]) -> Panel {
    let mut panel = Panel::new(title, x, y).equal().legend(Corner::Below);
    let colors = [palette::BLUE, palette::ORANGE, palette::BLACK];
    for ((i, points), color) in orbits(states).into_iter().enumerate().zip(colors) {
        let start = vec![points[0]];
        panel = panel.with(Layer::new(
            format!("body {}, m = {}", i + 1, m[i]),
            points,
            Pen::line(color, 1.0),
        ));
        panel = panel.with(Layer::new("start", start, Pen::dots(color, 4.0)).unlisted());
    }
    panel
}

fn figure(eight: &[Bodies], close: &Encounter) -> Figure {
    let axis = |name: &str, low: f64, high: f64| Axis::new(name, low..high);
    let first = plane(
        "Figure eight, a third of the period",
        [axis("x", -1.2, 1.2), axis("y", -0.6, 0.6)],
        [1.0; 3],
        eight,
    );
    let second = plane(
        &format!("Pythagorean problem, t ≤ {END}"),
        [axis("x", -5.0, 5.0), axis("y", -4.0, 4.0)],
        close.masses,
        &close.states,
    );
    let time = || Axis::new("time t", 0.0..END);
    let steps = Panel::new(
        "Pythagorean problem: time of a step",
        time(),
        Axis::powers("time of a step", -7.0..1.0),
    )
    .with(Layer::new(
        "step",
        close.lengths.clone(),
        Pen::line(palette::BLUE, 1.0),
    ));
    let errors = Panel::new(
        "Pythagorean problem: energy error",
        time(),
        Axis::powers("|H − E|/|E|", -17.0..-8.0),
    )
    .with(Layer::new(
        "error",
        close.errors.clone(),
        Pen::dots(palette::BLUE, 1.2),
    ));
    let row = |height, panels| Row { height, panels };
    Figure {
        name: "three_body",
        width: 1080,
        rows: vec![row(400, vec![first, second]), row(300, vec![steps, errors])],
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let system = ThreeBody {
        m: [1.0; 3],
        g: 1.0,
    };
    let midpoint = Integrator::new(system, Midpoint);
    println!("{}\n", midpoint.plan());
    let order = close_the_orbit(&midpoint)?;
    let [energy, angular, linear] = follow(&midpoint)?;
    let eight = midpoint.trajectory(figure_eight(), PERIOD / 1000.0, NoNoise);
    let eight: Vec<Bodies> = eight.take(334).collect::<Result<_, _>>()?;

    let (coarse, fine) = (encounter(H)?, encounter(0.5 * H)?);
    let (least, time) = coarse.closest;
    let apart = distance(&coarse.end, &fine.end);
    let rounding = "100,000 rounding errors of 10⁻¹⁶, all of one sign, would add up to 10⁻¹¹";
    let checks = [
        Check::new("figure eight: order of its closing", order).near(
            2.0,
            0.05,
            "the midpoint rule",
        ),
        Check::new("figure eight: largest energy error", energy).near(
            0.0,
            1e-4,
            "bounded, order h²",
        ),
        Check::new("figure eight: angular momentum", angular).near(0.0, 1e-11, rounding),
        Check::new("figure eight: linear momentum", linear).near(0.0, 1e-11, rounding),
        Check::new("Pythagorean: steps", coarse.states.len() as f64 - 1.0)
            .reported("equal steps of t would have to resolve the closest encounter"),
        Check::new("Pythagorean: time of the closest encounter", time).near(
            15.83,
            5e-3,
            "Szebehely and Peters, Astronomical Journal 72 (1967)",
        ),
        Check::new("Pythagorean: least distance", least).reported("at the steps"),
        Check::new("Pythagorean: largest |H − E|/|E|", coarse.largest).near(
            0.0,
            1e-6,
            "at the closest encounter",
        ),
        Check::new(
            "Pythagorean: distance at the end from steps half as long",
            apart,
        )
        .near(0.0, 1e-3, "encounters amplify the error of each step"),
    ];
    let caption = format!(
        "Above: the paths; dots are the starts. The figure eight is by the midpoint rule with 1000 steps a period; the bodies follow one another on it. The bodies of the Pythagorean problem start at rest; after many encounters the lightest one escapes, the others are a binary, and all leave the frame. Below: the time of a step of equal length in τ, and the energy error. The {} steps are by the Gauss rule of 8 stages, h = {H} in τ. The energy error is largest at encounters; between them it grows from 10⁻¹⁶ to 10⁻¹⁴ and more.",
        coarse.states.len() - 1
    );
    report("Three bodies", &figure(&eight, &coarse), &caption, &checks)
}
