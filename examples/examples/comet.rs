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
use sve_examples::palette;
use sve_examples::report::{one_row, report};
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
    /// Largest |H − E| in each tenth of a period, over |E|.
    energies: Vec<(f64, f64)>,
    /// Largest change of the angular momentum.
    angular: f64,
    /// Distance from the perihelion after each period.
    distances: Vec<(f64, f64)>,
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

/// Returns points of a panel whose axis shows powers of ten.
fn exponents(list: &[(f64, f64)]) -> Vec<(f64, f64)> {
    list.iter()
        .map(|&(x, y)| (x, y.max(1e-17).log10()))
        .collect()
}

fn figure(path: &Path) -> Result<Figure, StepError> {
    let (steps, orbit) = (places(H)?, places(0.1 * H)?);
    let title = format!("A period in {} steps", steps.len() - 1);
    let plane = Panel::new(title, Axis::new("x", -2.2..0.3), Axis::new("y", -0.3..0.3))
        .with(Layer::new("orbit", orbit, Pen::line(palette::SKY, 1.0)))
        .with(Layer::new("steps", steps, Pen::dots(palette::BLUE, 3.0)))
        .with(Layer::new(
            "sun",
            vec![(0.0, 0.0)],
            Pen::dots(palette::ORANGE, 5.0),
        ))
        .legend(Corner::TopLeft);
    let axis = Axis::new("periods", 0.0..f64::from(PERIODS));
    let errors = Panel::new(
        "Along a thousand periods",
        axis,
        Axis::powers("distance, relative energy error", -17.0..-6.0),
    )
    .with(Layer::new(
        "distance from the perihelion",
        exponents(&path.distances),
        Pen::line(palette::VERMILION, 1.0),
    ))
    .with(Layer::new(
        "largest |H − E|/|E| in five periods",
        exponents(&path.energies),
        Pen::line(palette::BLUE, 1.5),
    ))
    .legend(Corner::TopLeft);
    Ok(one_row("comet", [1080, 440], vec![plane, errors]))
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    println!("{}\n", Integrator::new(Comet, Gauss::<8>).plan());
    let path = follow()?;
    let largest = |list: &[(f64, f64)]| list.iter().fold(0.0_f64, |most, (_, x)| most.max(*x));
    let half = path.energies.len() / 2;
    let [first, second] = [&path.energies[..half], &path.energies[half..]].map(largest);
    let rounding = "K = s (H − E) walks by rounding errors, and s is 1e-3 at the perihelion";
    let checks = [
        Check::new("steps a period", path.steps as f64 / f64::from(PERIODS))
            .reported("equal steps of t would be some thousands"),
        Check::new("largest |H − E|/|E|, first half", first).near(0.0, 1e-10, rounding),
        Check::new("largest |H − E|/|E|, second half", second).near(
            0.0,
            1e-10,
            "no drift: as in the first half",
        ),
        Check::new("largest change of the angular momentum", path.angular).near(
            0.0,
            1e-13,
            "s and L are invariant, so each step keeps it to rounding",
        ),
        Check::new("largest distance from the perihelion", largest(&path.distances)).near(
            0.0,
            1e-7,
            "an error of the energy of 1e-13 changes the period; the comet moves by 14 in a unit of time there",
        ),
    ];
    let caption = "Left: the steps are as dense in the angle near the sun as in the distance far away. Right: the energy walks by rounding and has no drift; the error of the place grows with the number of periods, as the errors of the energy add up in the phase.";
    report("A comet", &figure(&path)?, caption, &checks)
}
