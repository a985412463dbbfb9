//! Figure 4: the Kubo oscillator on one path, exact, by the midpoint rule, and by Euler–Maruyama.

use std::error::Error;
use std::ops::Range;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row, Shape};
use sve_examples::gaussian::expectation;
use sve_examples::hues;
use sve_runtime::baseline::EulerMaruyama;
use sve_runtime::prelude::*;

use crate::Report;
use crate::run::{Run, ln_radius, run};
use crate::settings::{H, Options};
use crate::systems::Kubo;

const KUBO: Kubo = Kubo { a: 1.0, sigma: 1.0 };
/// Half the side of the pictures of orbits. Euler–Maruyama is drawn up to this border.
const PICTURE: f64 = 4.0;
/// The decades of the radius that are drawn.
const DECADES: Range<f64> = -2.0..15.0;
/// Largest allowed deviation of a sum of many independent terms, in standard deviations: a false
/// alarm in a million.
const DEVIATIONS: f64 = 5.0;

struct Runs {
    exact: Run,
    midpoint: Run,
    euler: Run,
    corrected: Run,
}

pub(crate) fn report(options: &Options, tick: &dyn Fn()) -> Result<Report, Box<dyn Error>> {
    let start = State::new([1.0], [0.0]);
    let path = || Wiener::new(options.seed);
    let steps = options.steps();
    let midpoint = Integrator::new(KUBO, Midpoint);
    let euler = EulerMaruyama::new(KUBO);
    let runs = Runs {
        exact: rotation(start, &path(), steps),
        midpoint: run(&midpoint, start, H, path(), steps)?,
        euler: run(&euler.uncorrected(), start, H, path(), steps)?,
        corrected: run(&euler, start, H, path(), steps)?,
    };
    tick();
    let left = runs.euler.inside(PICTURE).last().map_or(0.0, |z| z.t);
    let overflow = match runs.euler.overflow {
        Some(t) => format!("overflows the range of f64 at t = {t:.1}"),
        None => "stays within the range of f64 up to the horizon".to_owned(),
    };
    Ok(Report {
        title: "Figure 4. Kubo oscillator, one path",
        figure: draw(options, &runs, left),
        caption: format!(
            "a = σ = 1, start (1, 0), h = {H}, T = {}, the same Wiener path everywhere. Exact: rotation by \
             θ = at + σW(t). Euler–Maruyama is applied to the Stratonovich equation as it stands, as in the text; it \
             leaves the picture at t = {left:.1} and {overflow}. With the Itô correction of the drift (below) it solves the \
             right equation, and still does not keep the radius.",
            options.horizon
        ),
        checks: checks(options, &runs),
    })
}

/// Returns the exact solution on the path: the rotation by θ = at + σW(t).
fn rotation(start: State<[f64; 1]>, path: &Wiener, steps: usize) -> Run {
    let mut states = vec![start];
    let mut w = 0.0;
    for step in 0..steps {
        w += path.increment(step as u64, 0, H);
        let t = (step + 1) as f64 * H;
        let (sin, cos) = (KUBO.a * t + KUBO.sigma * w).sin_cos();
        let (q, p) = (start.q[0], start.p[0]);
        states.push(State::at(t, [q * cos + p * sin], [p * cos - q * sin]));
    }
    Run {
        states,
        overflow: None,
    }
}

/// Returns mean and variance of f at the angle of a step, `x = ah + σΔW`.
fn of_angle(f: impl Fn(f64) -> f64) -> (f64, f64) {
    let (mean, deviation) = (KUBO.a * H, KUBO.sigma * H.sqrt());
    let first = expectation(mean, deviation, &f);
    (
        first,
        expectation(mean, deviation, |x| (f(x) - first).powi(2)),
    )
}

fn checks(options: &Options, runs: &Runs) -> Vec<Check> {
    let steps = options.steps() as f64;
    let worst = runs
        .midpoint
        .states
        .iter()
        .map(|z| (z.q[0].powi(2) + z.p[0].powi(2) - 1.0).abs());
    let mut checks = vec![
        Check::new("midpoint: largest |q² + p² − 1|", worst.fold(0.0, f64::max)).near(
            0.0,
            4.0 * f64::EPSILON * steps,
            "conserved exactly: four roundings a step",
        ),
        lag(&runs.midpoint, &runs.exact, steps),
    ];
    checks.extend(overflow(options, &runs.euler));
    let left = runs.euler.inside(PICTURE).last().map_or(f64::NAN, |z| z.t);
    checks.push(
        Check::new("Euler–Maruyama: leaves the picture at t", left)
            .reported(format!("first |q| or |p| above {PICTURE}")),
    );
    let (growth, variance) =
        of_angle(|x| 0.5 * ((1.0 - 0.5 * KUBO.sigma.powi(2) * H).powi(2) + x * x).ln());
    let end = runs.corrected.states.last().map_or(f64::NAN, ln_radius);
    checks.push(
        Check::new("corrected Euler–Maruyama: ln radius at the horizon", end).near(
            steps * growth,
            DEVIATIONS * (steps * variance).sqrt(),
            "N E ½ln((1 − σ²h/2)² + x²), x ~ N(ah, σ²h), by quadrature; 5 standard deviations",
        ),
    );
    checks
}

/// Checks the lag of the midpoint rule behind the exact solution: it turns by 2 atan(x/2) a step
/// instead of x.
fn lag(midpoint: &Run, exact: &Run, steps: f64) -> Check {
    let turned = |run: &Run| -> f64 {
        let angle = |z: &[State<[f64; 1]>]| {
            let (q0, p0, q1, p1) = (z[0].q[0], z[0].p[0], z[1].q[0], z[1].p[0]);
            (p0 * q1 - q0 * p1).atan2(q0 * q1 + p0 * p1)
        };
        run.states.windows(2).map(angle).sum()
    };
    let (mean, variance) = of_angle(|x| 2.0 * (x / 2.0).atan() - x);
    Check::new(
        "midpoint: angle turned, less that of the exact solution",
        turned(midpoint) - turned(exact),
    )
    .near(
        steps * mean,
        DEVIATIONS * (steps * variance).sqrt(),
        "N E(2 atan(x/2) − x), x ~ N(ah, σ²h), by quadrature; 5 standard deviations",
    )
}

/// Checks the time at which |z| = Π √(1 + x²) leaves the range of f64.
fn overflow(options: &Options, euler: &Run) -> [Check; 2] {
    let (growth, variance) = of_angle(|x| 0.5 * (x * x).ln_1p());
    let steps = f64::MAX.ln() / growth;
    let allowed = H * DEVIATIONS * (steps * variance).sqrt() / growth;
    let expected = H * steps;
    let what = "Euler–Maruyama: overflow at t";
    let time = match euler.overflow {
        Some(t) => Check::new(what, t).near(
            expected,
            allowed,
            "h ln(f64::MAX) / E ½ln(1 + x²) by quadrature; 5 standard deviations of the time",
        ),
        None => Check::new(what, f64::NAN)
            .near(expected, allowed, "has to overflow before the horizon")
            .only_if(
                options.horizon > expected + allowed,
                &format!("expected near t = {expected:.0}, which the horizon need not reach"),
            ),
    };
    let last = euler.states.last().map_or(f64::NAN, ln_radius) / std::f64::consts::LN_10;
    let finite = Check::new("Euler–Maruyama: decimal exponent of the last radius", last)
        .reported("never NaN: the step returns an error");
    [time, finite]
}

fn draw(options: &Options, runs: &Runs, left: f64) -> Figure {
    let panel = |title: &str| {
        let [q, p] = ["q", "p"].map(|name| Axis::new(name, -PICTURE..PICTURE));
        Panel::new(title, q, p).equal()
    };
    let exact = panel("Exact solution").with(Layer::new(
        "exact",
        runs.exact.orbit(),
        Pen::dots(hues::EXACT, 0.8),
    ));
    let midpoint = panel("Variational, midpoint rule").with(Layer::new(
        "midpoint rule",
        runs.midpoint.orbit(),
        Pen::dots(hues::MIDPOINT, 0.8),
    ));
    let spiral: Vec<_> = runs
        .euler
        .inside(PICTURE)
        .iter()
        .map(|z| (z.q[0], z.p[0]))
        .collect();
    let circle = (0..=120)
        .map(|k| (f64::from(k) * std::f64::consts::PI / 60.0).sin_cos())
        .collect();
    let mut pen = Pen::line(hues::EULER_MARUYAMA, 1.0).symbols(Shape::Disc, spiral.len());
    if let Some(symbols) = &mut pen.symbol {
        symbols.radius = 1.8;
    }
    let euler = panel("Euler–Maruyama, uncorrected")
        .with(Layer::new(
            "exact circle",
            circle,
            Pen::dashed(hues::EXACT, 1.2, (5.0, 3.0)),
        ))
        .with(Layer::new("Euler–Maruyama", spiral, pen))
        .note(
            (-0.2 * PICTURE, 0.55 * PICTURE),
            format!("leaves the picture at t = {left:.1}"),
            hues::EULER_MARUYAMA,
        )
        .legend(Corner::TopRight);
    Figure {
        name: "figure4",
        width: 1110,
        rows: vec![
            Row {
                height: 370,
                panels: vec![exact, midpoint, euler],
            },
            Row {
                height: 300,
                panels: vec![radii(options, runs)],
            },
        ],
    }
}

fn radii(options: &Options, runs: &Runs) -> Panel {
    let every = options.steps().div_ceil(2000).max(1);
    let decades = |run: &Run| -> Vec<(f64, f64)> {
        let all = run.over_time(|z| ln_radius(z) / std::f64::consts::LN_10);
        let last = all.last().copied();
        all.into_iter().step_by(every).chain(last).collect()
    };
    let euler = decades(&runs.euler);
    let mut panel = Panel::new(
        "Radius √(q² + p²) against time, logarithmic",
        Axis::new("time t", 0.0..options.horizon),
        Axis::powers("radius", DECADES),
    )
    .note(
        (0.4 * options.horizon, -1.3),
        "midpoint rule and exact solution: 1".to_owned(),
        hues::MIDPOINT,
    )
    .note(
        (0.3 * options.horizon, 7.0),
        "Euler–Maruyama, corrected".to_owned(),
        hues::EULER_MARUYAMA,
    );
    let above = euler.iter().find(|&&(_, decade)| decade > DECADES.end);
    if let (Some(t), Some(&(left, _))) = (runs.euler.overflow, above) {
        panel = panel.note(
            (left + 0.01 * options.horizon, DECADES.end - 1.0),
            format!("Euler–Maruyama, uncorrected: goes on to the overflow of f64 at t = {t:.1}"),
            hues::EULER_MARUYAMA,
        );
    }
    panel
        .with(Layer::new(
            "Euler–Maruyama, uncorrected",
            euler,
            Pen::dashed(hues::EULER_MARUYAMA, 1.6, (6.0, 3.0)),
        ))
        .with(Layer::new(
            "Euler–Maruyama, corrected",
            decades(&runs.corrected),
            Pen::line(hues::EULER_MARUYAMA, 1.4).symbols(Shape::Triangle, 12),
        ))
        .with(Layer::new(
            "midpoint rule (stays at 1)",
            decades(&runs.midpoint),
            Pen::line(hues::MIDPOINT, 1.6).symbols(Shape::Circle, 9),
        ))
        .with(Layer::new(
            "exact (1)",
            decades(&runs.exact),
            Pen::dashed(hues::EXACT, 1.2, (5.0, 3.0)),
        ))
}
