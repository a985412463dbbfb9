//! Four point vortices in a plane, without noise and in a strain that fluctuates.
//!
//! The Lagrangian is linear in all velocities: the two coordinates of a vortex are conjugate to
//! each other, and p = α(q). In the gauge ½Γ(y x' − x y') the one-form α is linear, so the step is
//! the implicit midpoint rule, which preserves the two-form Σ Γ dy ∧ dx and the quadratic
//! invariants. The noise is a γ: it moves the vortices, like an energy that fluctuates. A page with
//! the picture is written to `target/vortices`.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::envelope::range_of;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::hues;
use sve_examples::palette::{BLACK, BLUE, ORANGE, PURPLE};
use sve_examples::report::{one_row, report};
use sve_runtime::prelude::*;

type Plane = [[f64; 2]; 4];

/// Vortices of given circulations (in units of 2π).
#[derive(Clone, Copy, Debug)]
struct Vortices {
    gamma: [f64; 4],
    sigma: f64,
}

#[variational(midpoint)]
impl Vortices {
    fn lagrangian(&self, q: [[f64; 2]; 4], v: [[f64; 2]; 4]) -> f64 {
        let mut l = 0.0;
        for i in 0..4 {
            l += 0.5 * self.gamma[i] * (q[i][1] * v[i][0] - q[i][0] * v[i][1]);
            for j in 0..i {
                let square = (q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2);
                l += 0.5 * self.gamma[i] * self.gamma[j] * square.ln();
            }
        }
        l
    }

    /// The noises: a strain along the axes, and one along the diagonals.
    #[gamma]
    fn strain(&self, q: [[f64; 2]; 4]) -> [f64; 2] {
        let mut strain = [0.0; 2];
        for i in 0..4 {
            let [x, y] = q[i];
            strain[0] += 0.5 * self.sigma * self.gamma[i] * (x * x - y * y);
            strain[1] += self.sigma * self.gamma[i] * x * y;
        }
        strain
    }
}

impl Vortices {
    /// Returns Σ Γ x and Σ Γ y.
    fn centre(&self, q: &Plane) -> [f64; 2] {
        [0, 1].map(|k| (0..4).map(|i| self.gamma[i] * q[i][k]).sum())
    }

    /// Returns Σ Γ r².
    fn moment(&self, q: &Plane) -> f64 {
        let square = |i: usize| q[i][0] * q[i][0] + q[i][1] * q[i][1];
        (0..4).map(|i| self.gamma[i] * square(i)).sum()
    }

    /// Returns the largest change of the two-form Σ Γ dy ∧ dx by a tangent map.
    fn two_form_change(&self, tangent: &sve_runtime::Tangent<8>) -> f64 {
        let form = |a: &[f64; 8], b: &[f64; 8]| -> f64 {
            let of = |i: usize| a[2 * i + 1] * b[2 * i] - a[2 * i] * b[2 * i + 1];
            (0..4).map(|i| self.gamma[i] * of(i)).sum()
        };
        let unit = |k: usize| -> [f64; 8] { core::array::from_fn(|i| f64::from(u8::from(i == k))) };
        let image = |k: usize| -> [f64; 8] { core::array::from_fn(|i| tangent[i][k]) };
        let mut worst = 0.0f64;
        for a in 0..8 {
            for b in 0..8 {
                let change = form(&image(a), &image(b)) - form(&unit(a), &unit(b));
                worst = worst.max(change.abs());
            }
        }
        worst
    }
}

/// Returns a start whose centre is the origin.
fn start(vortices: &Vortices) -> Result<State<Plane>, StepError> {
    let mut q = [[1.0, 0.0], [-0.2, 0.9], [-1.0, -0.3], [0.3, -0.8]];
    let total: f64 = vortices.gamma.iter().sum();
    let [x, y] = vortices.centre(&q);
    for place in &mut q {
        place[0] -= x / total;
        place[1] -= y / total;
    }
    State::from_configuration(vortices, q)
}

const H: f64 = 0.05;
const STEPS: usize = 100_000;

/// Number of steps that are drawn: more turns would cover each other.
const DRAWN: usize = 160;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let still = Vortices {
        gamma: [1.0, 0.9, 1.1, 0.8],
        sigma: 0.0,
    };
    let noisy = Vortices {
        sigma: 0.06,
        ..still
    };
    let midpoint = Integrator::new(still, Midpoint);
    println!("{}\n", midpoint.plan());

    let first = start(&still)?;
    let energy = still.hamiltonian(&first)?;
    let mut errors = Vec::new();
    let (mut worst, mut centre, mut moment) = ([0.0f64; 5], 0.0f64, 0.0f64);
    for (at, state) in midpoint
        .trajectory(first, H, NoNoise)
        .take(STEPS)
        .enumerate()
    {
        let state = state?;
        let error = still.hamiltonian(&state)? - energy;
        let part = &mut worst[5 * at / STEPS];
        *part = part.max(error.abs());
        let [x, y] = still.centre(&state.q);
        centre = centre.max(x.abs()).max(y.abs());
        moment = moment.max((still.moment(&state.q) - still.moment(&first.q)).abs());
        errors.push((state.t, error));
    }

    let shaken = Integrator::new(noisy, Midpoint);
    let mut state = start(&noisy)?;
    let mut noise = Wiener::new(7);
    let mut tangent = sve_runtime::Tangent::identity();
    let mut wandering = 0.0f64;
    for k in 0..200 {
        let mut dw = [0.0; 2];
        noise.increments(k, H, &mut dw)?;
        let (step, _) = shaken.step_with_derivatives(&mut state, H, &dw)?;
        tangent = &step * &tangent;
        let [x, y] = noisy.centre(&state.q);
        wandering = wandering.max(x.abs()).max(y.abs());
    }
    let size = (0..8)
        .flat_map(|i| tangent[i].iter())
        .fold(0.0f64, |m, x| m.max(x.abs()));

    let checks = [
        Check::new("largest |ΔH|, first fifth", worst[0]).near(0.0, 6e-5, "order h²"),
        Check::new("last fifth over first", worst[4] / worst[0]).near(
            1.0,
            0.05,
            "no drift in 10⁵ steps",
        ),
        Check::new("|Σ Γ x|, |Σ Γ y|", centre).near(0.0, 2e-11, "linear invariants, rounding"),
        Check::new("change of Σ Γ r²", moment).near(0.0, 1e-8, "a quadratic invariant, rounding"),
        Check::new("the centre in the strain", wandering).near(
            0.0,
            1e-13,
            "the strain is linear: 0 stays 0",
        ),
        Check::new(
            "two-form after 200 noisy steps",
            noisy.two_form_change(&tangent) / size.powi(2),
        )
        .near(0.0, 1e-13, "relative to the square of the tangent map"),
        Check::new("largest entry of the tangent map", size)
            .reported("how far neighbours are apart"),
    ];
    let figure = figure(&midpoint, &shaken, &errors)?;
    let caption = "Left: four vortices until t = 8, h = 0.05; dots mark their starts. Middle: the same start in a strain that fluctuates, σ = 0.06, seed 7. \
        Right: the range of the energy error in each hundredth of the time, without noise; the line is its middle. The error does not drift.";
    report("Four point vortices", &figure, caption, &checks)
}

/// Draws the paths of the vortices.
fn paths(integrator: &Integrator<Vortices, Midpoint>, title: &str) -> Result<Panel, StepError> {
    let first = start(integrator.system())?;
    let states: Result<Vec<_>, _> = integrator
        .trajectory(first, H, Wiener::new(7))
        .take(DRAWN)
        .collect();
    let states = states?;
    let axis = |name| Axis::new(name, -1.6..1.6);
    let mut panel = Panel::new(title, axis("x"), axis("y")).equal();
    let (widths, mut starts) = ([1.2, 1.2, 1.2, 2.0], Vec::new());
    for (i, color) in [BLUE, ORANGE, BLACK, PURPLE].into_iter().enumerate() {
        let points = states.iter().map(|s| (s.q[i][0], s.q[i][1])).collect();
        let label = format!("Γ = {}", integrator.system().gamma[i]);
        panel = panel.with(Layer::new(label, points, Pen::line(color, widths[i])));
        let begin = vec![(first.q[i][0], first.q[i][1])];
        starts.push(Layer::new("start", begin, Pen::dots(color, 4.0)).unlisted());
    }
    Ok(starts.into_iter().fold(panel, Panel::with))
}

fn figure(
    still: &Integrator<Vortices, Midpoint>,
    noisy: &Integrator<Vortices, Midpoint>,
    errors: &[(f64, f64)],
) -> Result<Figure, StepError> {
    let left = paths(still, "Without noise")?.legend(Corner::BottomLeft);
    let middle = paths(noisy, "In a fluctuating strain")?;
    let largest = errors.iter().fold(0.0f64, |m, e| m.max(e.1.abs()));
    let right = Panel::new(
        format!("Range of the energy error, h = {H}"),
        Axis::new("time t", 0.0..H * STEPS as f64),
        Axis::new("energy error H − H₀", -1.2 * largest..1.2 * largest),
    )
    .with(range_of("midpoint", errors, 100, hues::MIDPOINT));
    Ok(one_row("vortices", [1140, 400], vec![left, middle, right]))
}
