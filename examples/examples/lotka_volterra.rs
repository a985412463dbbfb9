//! Predator and prey as a Lagrangian system: the form of L decides which quantities the step
//! preserves.
//!
//! The equations x' = x (y − 2), y' = y (1 − x) have the energy H = x + y − ln x − 2 ln y and the
//! two-form dx ∧ dy/(xy), and follow from L = (ln y / x) x' − H. In this L the velocity of y does
//! not occur: y is a variable of the node, and the two-form is preserved to rounding. A total
//! derivative does not change the equations of motion, but if it is cubic the step can only be
//! projected; it preserves the two-form to O(h⁵), and the energy drifts. A page with the picture is
//! written to `target/lotka_volterra`.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::envelope::range_of;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::hues;
use sve_examples::palette::{BLACK, BLUE};
use sve_examples::report::{one_row, report};
use sve_runtime::Variational;
use sve_runtime::plan::DegenerateStep;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// The Lagrangian without the velocity of y, and weather that favours one species or the other.
#[derive(Clone, Copy, Debug)]
struct Written {
    sigma: f64,
}

#[variational(midpoint, endpoint)]
impl Written {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        y.ln() / x * v[0] - (x + y - x.ln() - 2.0 * y.ln())
    }

    #[gamma]
    fn weather(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[0].ln()
    }
}

/// The same system with the total derivative of x²y + y³/3.
#[derive(Clone, Copy, Debug)]
struct Disguised;

#[variational(midpoint)]
impl Disguised {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        let total = 2.0 * x * y * v[0] + (x * x + y * y) * v[1];
        y.ln() / x * v[0] + total - (x + y - x.ln() - 2.0 * y.ln())
    }
}

const START: [f64; 2] = [1.5, 0.8];
const H: f64 = 0.1;
const STEPS: usize = 100_000;

/// Points of a curve.
type Curve = Vec<(f64, f64)>;

/// Returns energy errors along a path: the errors that are drawn, and the largest errors in the
/// first and the last tenth.
fn energies<S, R, const M: usize>(
    integrator: &Integrator<S, R>,
) -> Result<(Curve, [f64; 2]), StepError>
where
    S: Variational<R> + System<Dims = Dims<2, M>>,
{
    let system = integrator.system();
    let start = State::from_configuration(system, START)?;
    let energy = system.hamiltonian(&start)?;
    let (mut drawn, mut worst) = (Vec::new(), [0.0f64; 2]);
    for (at, state) in integrator
        .trajectory(start, H, NoNoise)
        .take(STEPS)
        .enumerate()
    {
        let error = system.hamiltonian(&state?)? - energy;
        match 10 * at / STEPS {
            0 => worst[0] = worst[0].max(error.abs()),
            9 => worst[1] = worst[1].max(error.abs()),
            _ => {}
        }
        drawn.push((H * (at + 1) as f64, error));
    }
    Ok((drawn, worst))
}

/// Returns the relative change of the two-form dx ∧ dy/(xy) in a step.
fn area_change<S, R, const M: usize>(
    integrator: &Integrator<S, R>,
    h: f64,
) -> Result<f64, StepError>
where
    S: Variational<R> + System<Dims = Dims<2, M>>,
{
    let mut state = State::from_configuration(integrator.system(), START)?;
    let (tangent, _) = integrator.step_with_derivatives(&mut state, h, &[0.0; M])?;
    let determinant = tangent[0][0] * tangent[1][1] - tangent[0][1] * tangent[1][0];
    let [x, y] = state.q;
    Ok(determinant * START[0] * START[1] / (x * y) - 1.0)
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let quiet = Written { sigma: 0.0 };
    let written = Integrator::new(quiet, Midpoint);
    let disguised = Integrator::new(Disguised, Midpoint);
    println!("{}\n\n{}\n", written.plan(), disguised.plan().structure());

    let (exact, [exact_first, exact_last]) = energies(&written)?;
    let (drifting, [drifting_first, drifting_last]) = energies(&disguised)?;
    let (coarse, fine) = (
        area_change(&disguised, 0.04)?,
        area_change(&disguised, 0.02)?,
    );
    let one = |is: bool| f64::from(u8::from(is));
    let keeps =
        |kind: Option<DegenerateStep>| one(kind.is_some_and(DegenerateStep::keeps_two_form));
    let checks = [
        Check::new(
            "as written: the plan keeps the two-form (1 yes, 0 no)",
            keeps(written.plan().degenerate),
        )
        .near(1.0, 0.0, "what the plan says"),
        Check::new(
            "as written: change of the two-form in a step",
            area_change(&written, H)?,
        )
        .near(0.0, 1e-14, "rounding"),
        Check::new("as written: largest |ΔH|, first tenth", exact_first).near(
            0.0,
            0.013,
            "order h²",
        ),
        Check::new(
            "as written: |ΔH|, last tenth over first",
            exact_last / exact_first,
        )
        .near(1.0, 1e-3, "no drift in 10⁵ steps"),
        Check::new(
            "disguised: the plan keeps the two-form (1 yes, 0 no)",
            keeps(disguised.plan().degenerate),
        )
        .near(0.0, 0.0, "what the plan says"),
        Check::new(
            "disguised: order of the change of the two-form",
            (coarse / fine).log2(),
        )
        .near(5.0, 0.3, "O(h⁵)"),
        Check::new("disguised: largest |ΔH|, first tenth", drifting_first).reported("drifts"),
        Check::new("disguised: largest |ΔH|, last tenth", drifting_last).reported("drifts"),
    ];
    let figure = figure(&written, &exact, &drifting)?;
    let caption = "Left: orbits by L without the velocity of y, h = 0.02, and one path with noise, σ = 0.15, seed 4, until t = 30. \
        Right: the range of the energy error in each hundredth of the time, by two Lagrangians with the same equations; lines are its middle. \
        The table calls L without the velocity of y “as written”, and L with a cubic total derivative “disguised”.";
    report("Predator and prey", &figure, caption, &checks)
}

fn figure(
    written: &Integrator<Written, Midpoint>,
    exact: &[(f64, f64)],
    drifting: &[(f64, f64)],
) -> Result<Figure, StepError> {
    let mut left = Panel::new(
        "Orbits, with and without noise",
        Axis::new("prey x", 0.0..4.2),
        Axis::new("predators y", 0.0..6.6),
    )
    .legend(Corner::Below);
    let noisy = Integrator::new(Written { sigma: 0.15 }, Midpoint);
    let start = State::from_configuration(noisy.system(), START)?;
    let path: Result<Vec<_>, _> = noisy
        .trajectory(start, 0.02, Wiener::new(4))
        .take(1500)
        .collect();
    let points = |path: Vec<State<[f64; 2]>>| path.iter().map(|s| (s.q[0], s.q[1])).collect();
    left = left.with(Layer::new(
        "with noise",
        points(path?),
        Pen::dashed(hues::WITH_NOISE, 1.0, (7.0, 2.0)),
    ));
    for (at, x) in [1.2, 1.5, 1.9, 2.4].into_iter().enumerate() {
        let start = State::from_configuration(written.system(), [x, 0.8 + 0.3 * (1.5 - x)])?;
        let orbit: Result<Vec<_>, _> = written.trajectory(start, 0.02, NoNoise).take(380).collect();
        let layer = Layer::new("no noise", points(orbit?), Pen::line(BLUE, 1.0));
        left = left.with(if at == 0 { layer } else { layer.unlisted() });
    }
    let right = Panel::new(
        format!("Range of the energy error, h = {H}"),
        Axis::new("time t", 0.0..H * STEPS as f64),
        Axis::new("energy error H − H₀", -0.8..0.1),
    )
    .legend(Corner::Below)
    .with(range_of(
        "L with a cubic total derivative",
        drifting,
        100,
        BLACK,
    ))
    .with(range_of("L without the velocity of y", exact, 100, BLUE));
    Ok(one_row("lotka_volterra", [1000, 460], vec![left, right]))
}
