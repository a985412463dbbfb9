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
use sve_examples::hues;
use sve_examples::palette::GREY;
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

/// Number of parts of a path.
const PARTS: usize = 100;

/// The largest relative energy error in each part of a path.
struct Errors {
    parts: [f64; PARTS],
}

impl Errors {
    fn new() -> Self {
        Self {
            parts: [0.0; PARTS],
        }
    }

    fn add(&mut self, at: usize, error: f64) {
        let part = &mut self.parts[PARTS * at / STEPS];
        *part = part.max(error.abs());
    }

    /// Returns the largest error of the first steps.
    fn largest(&self, steps: usize) -> f64 {
        let parts = &self.parts[..PARTS * steps / STEPS];
        parts.iter().fold(0.0, |m: f64, x| m.max(*x))
    }

    /// Returns the end of each part and its largest error, as a power of ten.
    fn drawn(&self) -> Vec<(f64, f64)> {
        let end = |part: usize| ((part + 1) * STEPS / PARTS) as f64;
        let parts = self.parts.iter().enumerate();
        parts
            .map(|(part, error)| (end(part), error.log10()))
            .collect()
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

    let tenth = ours.largest(STEPS / 10);
    let kind = midpoint.plan().degenerate;
    let is_projected = kind == Some(DegenerateStep::Projected);
    let checks = [
        Check::new("symmetric projection", f64::from(u8::from(is_projected))).near(
            1.0,
            0.0,
            "what the plan says",
        ),
        Check::new("largest |ΔH/H|, 10⁵ steps", tenth).near(0.0, 4e-3, "order h²"),
        Check::new("3·10⁵ steps over 10⁵", ours.largest(CHECKED) / tenth)
            .near(1.0, 0.01, "no drift"),
        Check::new("10⁶ steps over 10⁵", ours.largest(STEPS) / tenth).reported("reported"),
        Check::new("change of the toroidal momentum", apart).near(
            0.0,
            1e-13,
            "a translation: conserved to rounding",
        ),
        Check::new(
            "Runge–Kutta, largest |ΔH/H|, 10⁵ steps",
            theirs.largest(STEPS / 10),
        )
        .reported("drifts"),
        Check::new("Runge–Kutta, 10⁶ steps", theirs.largest(STEPS)).reported("drifts"),
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
        "Poloidal plane",
        Axis::new("R", 0.78..1.22),
        Axis::new("Z", -0.22..0.22),
    )
    .equal()
    .legend(Corner::Below);
    for r in [0.05, 0.1, 0.15, 0.2] {
        let layer = Layer::new(
            "flux surfaces",
            surface(r),
            Pen::dashed(GREY, 0.5, (3.0, 3.0)),
        );
        left = left.with(if r == 0.2 { layer } else { layer.unlisted() });
    }
    left = left
        .with(Layer::new(
            "orbit in a fluctuating potential",
            points(shaken?),
            Pen::line(hues::WITH_NOISE, 0.6),
        ))
        .with(Layer::new(
            "orbit without noise",
            points(quiet?),
            Pen::line(hues::MIDPOINT, 1.2),
        ));
    let right = Panel::new(
        format!("Largest energy error in each hundredth of the time, h\u{a0}=\u{a0}{H}"),
        Axis::new("steps", 0.0..STEPS as f64),
        Axis::powers("|H − H₀|/H₀", -3.6..-1.4),
    )
    .legend(Corner::Below)
    .with(Layer::new(
        "Runge–Kutta 4",
        theirs.drawn(),
        Pen::dashed(hues::RUNGE_KUTTA_4, 1.5, (6.0, 3.0)),
    ))
    .with(Layer::new(
        "midpoint rule",
        ours.drawn(),
        Pen::line(hues::MIDPOINT, 1.5),
    ));
    Ok(one_row("guiding_centre", [1000, 480], vec![left, right]))
}
