//! The guiding centre of a charged particle in the field of a tokamak, for many bounces of a
//! trapped orbit.
//!
//! L = ⟨A(x) + u b(x), x'⟩ − u²/2 − μ B(x) in the coordinates R, Z, φ and u, the velocity along the
//! field. It is linear in all velocities, and neither of its one-forms can be brought into the form
//! without half of them, so the step is projected symmetrically to p = α(q). Its energy error does
//! not drift, while the energy error of the Runge–Kutta method of order 4 does. A second particle
//! feels a fluctuating electric potential. A page is written to `target/guiding_centre`.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::palette::{BLUE, GREY, ORANGE};
use sve_examples::report::{one_row, report};
use sve_runtime::plan::DegenerateStep;
use sve_runtime::prelude::*;

/// A field with circular flux surfaces around R = R₀; lengths in R₀, fields in B₀, times in
/// gyrations over 2π.
#[derive(Clone, Copy, Debug)]
struct Tokamak {
    /// Safety factor.
    safety: f64,
    /// Magnetic moment.
    mu: f64,
    /// Strength of the fluctuating potential.
    sigma: f64,
}

#[variational(midpoint)]
impl Tokamak {
    /// √(1 + r²/q²), r the distance from the magnetic axis.
    fn twist(&self, r: f64, z: f64) -> f64 {
        (1.0 + ((r - 1.0).powi(2) + z * z) / self.safety.powi(2)).sqrt()
    }

    fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 {
        let [r, z, _, u] = q;
        let twist = self.twist(r, z);
        let strength = twist / r;
        let flux = -((r - 1.0).powi(2) + z * z) / (2.0 * self.safety);
        let along_r = u * z / (self.safety * twist);
        let along_z = -r.ln() - u * (r - 1.0) / (self.safety * twist);
        let along_phi = flux + u * r / twist;
        along_r * v[0] + along_z * v[1] + along_phi * v[2] - 0.5 * u * u - self.mu * strength
    }

    /// An electric potential with two modes.
    #[gamma]
    fn potential(&self, q: [f64; 4]) -> f64 {
        self.sigma * ((8.0 * q[0]).cos() + (8.0 * q[1]).sin())
    }

    /// Turns the torus, which has no preferred angle.
    #[symmetry]
    fn turn(&self, _q: [f64; 4]) -> [f64; 4] {
        [0.0, 0.0, 1.0, 0.0]
    }
}

/// A trapped particle on the outer side.
const START: [f64; 4] = [1.15, 0.0, 0.0, 1.2e-3];

/// Step size: about 30 steps a bounce.
const H: f64 = 400.0;

/// Number of steps whose energy error is checked, and number of steps in all.
const CHECKED: usize = 300_000;
const STEPS: usize = 1_000_000;

/// Makes a step of the Runge–Kutta method of order 4 for q' = v(q).
fn runge_kutta(tokamak: &Tokamak, q: [f64; 4], h: f64) -> Result<[f64; 4], StepError> {
    let velocity = |q: [f64; 4]| {
        let state = State::from_configuration(tokamak, q)?;
        tokamak.velocity(&state)
    };
    let moved = |k: &[f64; 4], h: f64| core::array::from_fn(|i| q[i] + h * k[i]);
    let a = velocity(q)?;
    let b = velocity(moved(&a, 0.5 * h))?;
    let c = velocity(moved(&b, 0.5 * h))?;
    let d = velocity(moved(&c, h))?;
    Ok(core::array::from_fn(|i| {
        q[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i])
    }))
}

/// Relative energy errors along a path: the errors that are drawn, and the largest error in each of
/// ten parts.
struct Errors {
    drawn: Vec<(f64, f64)>,
    parts: [f64; 10],
}

impl Errors {
    fn new() -> Self {
        Self {
            drawn: Vec::new(),
            parts: [0.0; 10],
        }
    }

    fn add(&mut self, at: usize, error: f64) {
        let part = &mut self.parts[10 * at / STEPS];
        *part = part.max(error.abs());
        if at % 1000 < 100 && at.is_multiple_of(20) {
            self.drawn.push(((at + 1) as f64 * 1e-6, 1e4 * error));
        }
    }

    /// Returns the largest of the first so many parts.
    fn largest(&self, parts: usize) -> f64 {
        self.parts[..parts].iter().fold(0.0, |m: f64, x| m.max(*x))
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let tokamak = Tokamak {
        safety: 2.0,
        mu: 1.1e-5,
        sigma: 0.0,
    };
    let midpoint = Integrator::new(tokamak, Midpoint);
    println!("{}\n", midpoint.plan());
    let start = State::from_configuration(&tokamak, START)?;
    let energy = tokamak.hamiltonian(&start)?;
    let momentum = tokamak.turn_momentum(&start);

    let (mut ours, mut theirs) = (Errors::new(), Errors::new());
    let mut apart = 0.0f64;
    for (at, state) in midpoint
        .trajectory(start, H, NoNoise)
        .take(STEPS)
        .enumerate()
    {
        let state = state?;
        ours.add(at, tokamak.hamiltonian(&state)? / energy - 1.0);
        apart = apart.max((tokamak.turn_momentum(&state) - momentum).abs());
    }
    let mut q = START;
    for at in 0..STEPS {
        q = runge_kutta(&tokamak, q, H)?;
        let state = State::from_configuration(&tokamak, q)?;
        theirs.add(at, tokamak.hamiltonian(&state)? / energy - 1.0);
    }

    let tenth = ours.parts[0];
    let kind = midpoint.plan().degenerate;
    let is_projected = kind == Some(DegenerateStep::Projected);
    let checks = [
        Check::new("symmetric projection", f64::from(u8::from(is_projected))).near(
            1.0,
            0.0,
            "what the plan says",
        ),
        Check::new("largest |ΔH/H|, 10⁵ steps", tenth).near(0.0, 4e-3, "order h²"),
        Check::new(
            "3·10⁵ steps over 10⁵",
            ours.largest(10 * CHECKED / STEPS) / tenth,
        )
        .near(1.0, 0.01, "no drift"),
        Check::new("10⁶ steps over 10⁵", ours.largest(10) / tenth).reported("reported"),
        Check::new("change of the toroidal momentum", apart).near(
            0.0,
            1e-13,
            "a translation: conserved to rounding",
        ),
        Check::new("Runge–Kutta, largest |ΔH/H|, 10⁵ steps", theirs.parts[0]).reported("drifts"),
        Check::new("Runge–Kutta, 10⁶ steps", theirs.largest(10)).reported("drifts"),
    ];
    let figure = figure(&midpoint, start, &ours, &theirs)?;
    let caption = "Left: a trapped orbit in the poloidal plane for some 70 bounces, and the same particle in a fluctuating potential. Right: the relative energy error for 10⁶ steps by the projected midpoint rule and by the Runge–Kutta method of order 4 with the same step.";
    report("A guiding centre in a tokamak", &figure, caption, &checks)
}

fn figure(
    midpoint: &Integrator<Tokamak, Midpoint>,
    start: State<[f64; 4]>,
    ours: &Errors,
    theirs: &Errors,
) -> Result<Figure, StepError> {
    let points = |path: Vec<State<[f64; 4]>>| path.iter().map(|s| (s.q[0], s.q[1])).collect();
    let quiet: Result<Vec<_>, _> = midpoint.trajectory(start, H, NoNoise).take(2000).collect();
    let noisy = Tokamak {
        sigma: 2e-6,
        ..*midpoint.system()
    };
    let noisy = Integrator::new(noisy, Midpoint);
    let shaken: Result<Vec<_>, _> = noisy
        .trajectory(start, H, Wiener::new(3))
        .take(2000)
        .collect();
    let surface = |r: f64| {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / 200.0;
        (0..=200)
            .map(|k| (1.0 + r * angle(k).cos(), r * angle(k).sin()))
            .collect()
    };
    let mut left = Panel::new(
        "poloidal plane",
        Axis::new("R", 0.78..1.22),
        Axis::new("Z", -0.29..0.22),
    )
    .equal()
    .legend(Corner::BottomLeft);
    for r in [0.05, 0.1, 0.15, 0.2] {
        let layer = Layer::new(
            "flux surface",
            surface(r),
            Pen::dashed(GREY, 0.5, (3.0, 3.0)),
        );
        left = left.with(layer.unlisted());
    }
    left = left
        .with(Layer::new(
            "fluctuating potential",
            points(shaken?),
            Pen::line(ORANGE, 0.6),
        ))
        .with(Layer::new("no noise", points(quiet?), Pen::line(BLUE, 1.2)));
    let both = ours.drawn.iter().chain(&theirs.drawn);
    let (least, most) = both.fold((0.0f64, 0.0f64), |(a, b), e| (a.min(e.1), b.max(e.1)));
    let margin = 0.1 * (most - least);
    let right = Panel::new(
        "energy error",
        Axis::new("10⁶ steps", 0.0..1.0),
        Axis::new("10⁴ ΔH/H", least - margin..most + 3.0 * margin),
    )
    .legend(Corner::TopRight)
    .with(Layer::new(
        "Runge–Kutta 4",
        theirs.drawn.clone(),
        Pen::line(ORANGE, 0.8),
    ))
    .with(Layer::new(
        "midpoint",
        ours.drawn.clone(),
        Pen::line(BLUE, 0.8),
    ));
    Ok(one_row("guiding_centre", [1000, 420], vec![left, right]))
}
