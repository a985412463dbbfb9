//! A comet of eccentricity 0.99, with a time scale: a thousand periods with equal steps of τ, where
//! dt = r^{3/2} dτ.
//!
//! L = ½|v|² + 1/r. Equal steps of t would have to resolve the perihelion, where the comet is two
//! hundred times as fast as at the aphelion. Steps of τ are as many near the sun as far away. They
//! are those of the rule for the Lagrangian r^{3/2} (L + E), so the energy oscillates without a
//! drift; the program measures it, and the place after a thousand periods against the exact one.
//! Status 1 if a number is off. Writes `target/comet/`.

use std::error::Error;
use std::f64::consts::TAU;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::report::{one_row, report};
use sve_examples::{hues, palette};
use sve_runtime::prelude::*;

struct Comet;

#[variational(gauss(8))]
impl Comet {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / q[0].hypot(q[1])
    }

    #[time_scale]
    fn scale(&self, q: [f64; 2]) -> f64 {
        q[0].hypot(q[1]).powf(1.5)
    }

    #[symmetry]
    fn turn(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0]]
    }
}

const ECCENTRICITY: f64 = 0.99;
const PERIODS: u32 = 1000;
/// Length of a step in τ.
const H: f64 = 0.8;

/// The numbers of a path.
#[derive(Default)]
struct Path {
    /// Number of steps.
    steps: u64,
    /// Largest |H − E| in five periods, over |E|.
    energies: Vec<(f64, f64)>,
    /// Largest change of the angular momentum.
    angular: f64,
    /// Distance from the perihelion after each period.
    distances: Vec<(f64, f64)>,
}

impl Path {
    fn steps_a_period(&self) -> f64 {
        self.steps as f64 / f64::from(PERIODS)
    }
}

fn perihelion() -> Result<TimedState<[f64; 2]>, StepError> {
    let speed = ((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY)).sqrt();
    TimedState::new(&Comet, [1.0 - ECCENTRICITY, 0.0], [0.0, speed])
}

fn follow() -> Result<Path, StepError> {
    let comet = Integrator::new(Comet, Gauss::<8>);
    let start = perihelion()?;
    let mut found = Path::default();
    let mut path = comet.trajectory(start, H, NoNoise);
    let (mut most, mut next) = (0.0_f64, 5.0);
    while next <= f64::from(PERIODS) {
        let state = path.advance(1)?;
        let excess = Comet.hamiltonian(state)? / start.energy() - 1.0;
        let turned = Comet.turn_momentum(state) - Comet.turn_momentum(&start);
        most = most.max(excess.abs());
        found.angular = found.angular.max(turned.abs());
        if state.t > next * TAU {
            found.energies.push((next, most));
            (most, next) = (0.0, next + 5.0);
        }
    }
    found.steps = path.step();
    let times = (1..=PERIODS).map(|period| f64::from(period) * TAU);
    for state in comet.trajectory(start, H, NoNoise).at(times) {
        let state = state?;
        let distance = (state.q[0] - start.q[0]).hypot(state.q[1]);
        found.distances.push(((state.t / TAU).round(), distance));
    }
    Ok(found)
}

/// Returns the places on the orbit after steps of a period.
fn places(h: f64) -> Result<Vec<(f64, f64)>, StepError> {
    let comet = Integrator::new(Comet, Gauss::<8>);
    let path = comet.trajectory(perihelion()?, h, NoNoise);
    let states = path.every(1).until(TAU);
    states
        .map(|state| state.map(|state| (state.q[0], state.q[1])))
        .collect()
}

fn figure(path: &Path) -> Result<Figure, StepError> {
    let (steps, orbit) = (places(H)?, places(0.01 * H)?);
    let plane = Panel::new(
        format!("A period in {:.1} steps", path.steps_a_period()),
        Axis::new("x", -2.05..0.1),
        Axis::new("y", -0.17..0.17),
    )
    .equal()
    .with(Layer::new("orbit", orbit, Pen::line(palette::SKY, 1.0)))
    .with(Layer::new("steps", steps, Pen::dots(hues::GAUSS, 2.0)))
    .with(Layer::new(
        "sun",
        vec![(0.0, 0.0)],
        Pen::dots(palette::ORANGE, 3.0),
    ))
    .legend(Corner::Below);
    let panel = |title: &str, y: Axis, list: &[(f64, f64)]| {
        let points = list.iter().map(|&(x, y)| (x, y.log10()));
        let pen = Pen::line(hues::GAUSS, 1.2);
        Panel::new(title, Axis::new("periods", 0.0..f64::from(PERIODS)), y).with(Layer::new(
            title,
            points.collect(),
            pen,
        ))
    };
    let energy = panel(
        "Largest energy error in five periods",
        Axis::powers("|H − E|/|E|", -13.0..-10.0),
        &path.energies,
    );
    let place = panel(
        "Distance from the perihelion after each period",
        Axis::powers("distance", -14.0..-9.0),
        &path.distances,
    );
    let mut figure = one_row("comet", [900, 260], vec![plane]);
    figure
        .rows
        .extend(one_row("", [900, 300], vec![energy, place]).rows);
    Ok(figure)
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    println!("{}\n", Integrator::new(Comet, Gauss::<8>).plan());
    let path = follow()?;
    let largest = |list: &[(f64, f64)]| list.iter().fold(0.0_f64, |most, (_, x)| most.max(*x));
    let half = path.energies.len() / 2;
    let [first, second] = [&path.energies[..half], &path.energies[half..]].map(largest);
    let rounding = "K = s (H − E) walks by rounding errors, and s is 10⁻³ at the perihelion";
    let checks = [
        Check::new("steps a period", path.steps_a_period())
            .reported("equal steps of t would be some thousands"),
        Check::new("largest |H − E|/|E|, first half", first).near(0.0, 1e-10, rounding),
        Check::new("largest |H − E|/|E|, second half", second).near(
            0.0,
            1e-10,
            "as in the first half",
        ),
        Check::new("largest change of the angular momentum", path.angular).near(
            0.0,
            1e-13,
            "s and L are invariant, so each step keeps it to rounding",
        ),
        Check::new("largest distance from the perihelion", largest(&path.distances)).near(
            0.0,
            1e-7,
            "far from the sun the energy error is below 10⁻¹³; it changes the period, and the comet moves by 14 in a unit of time at the perihelion",
        ),
    ];
    let caption = "Steps of the Gauss rule with 8 stages have the length 0.8 in τ: the time of a step follows r√r, so that few steps resolve the perihelion, and few the rest of the orbit. The energy error walks by rounding. It is largest at the perihelion, below 4·10⁻¹¹, and below 10⁻¹³ where r > 1. The error of the place grows with the number of periods, as the errors of the energy add up in the phase.";
    report("A comet", &figure(&path)?, caption, &checks)
}
