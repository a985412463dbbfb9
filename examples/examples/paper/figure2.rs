//! Figure 2: the stochastic linear oscillator on one path.

use std::error::Error;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use sve_examples::gaussian::{ENERGY, Linear, Scheme, product, standard_errors};
use sve_examples::{hues, palette};
use sve_runtime::prelude::*;

use crate::Report;
use crate::oscillator::{self, Entry, Exact, OSCILLATOR, START, energy};
use crate::run::{Run, ln_radius};
use crate::settings::{H, Options};

/// A χ²₂ variable exceeds this value with probability 1e-4.
const SURPRISE: f64 = 18.42;

/// Length of the time on which energies are compared with the exact one.
const LAST: f64 = 30.0;

/// Indices of the entries of [`oscillator::entries`] by their expected behaviour.
const FORWARD: usize = 0;
const BACKWARD: usize = 1;
const MIDPOINT: usize = 2;
const INITIAL_POINT: usize = 3;
const ENDPOINT: usize = 4;

pub(crate) fn report(options: &Options, tick: &dyn Fn()) -> Result<Report, Box<dyn Error>> {
    let entries = oscillator::entries();
    let path = Wiener::new(options.seed);
    let mut runs = Vec::new();
    for entry in &entries {
        runs.push(entry.scheme.run(&path, options.steps())?);
        tick();
    }
    let exact = Exact::new();
    let solution = exact.run(&path, options.steps());
    let picture = Picture::of(&runs, &solution)?;
    let mut checks = vec![growth(&runs[FORWARD])];
    checks.push(
        Check::new(
            "forward Euler–Maruyama: leaves the picture at t",
            picture.left.unwrap_or(f64::NAN),
        )
        .reported(format!("first |q| or |p| above {:.0}", picture.size)),
    );
    checks.push(settled(
        options,
        entries[BACKWARD].scheme.linear()?,
        &runs[BACKWARD],
    )?);
    for index in [MIDPOINT, INITIAL_POINT, ENDPOINT] {
        let joint = exact.beside(entries[index].scheme.linear()?);
        checks.extend(near_exact(&entries[index], &joint, &runs[index], &solution));
    }
    checks.push(law(&exact.moments(), &solution));
    for (name, run) in entries
        .iter()
        .map(|e| e.name)
        .zip(&runs)
        .chain([("exact solution", &solution)])
    {
        checks.push(energy_at_end(name, run)?);
    }
    let left = match picture.left {
        Some(t) => format!("leaves the picture at t = {t:.1}"),
        None => "stays in the picture up to this horizon".to_owned(),
    };
    Ok(Report {
        title: "Figure 2. Stochastic linear oscillator, one path",
        figure: draw(options, &entries, &runs, &solution, &picture)?,
        caption: format!(
            "σ = 1, start (1, 0), h = {H}, T = {}, the same Wiener path everywhere. All phase plots have the same scale, \
             except that of backward Euler–Maruyama. \
             Forward Euler–Maruyama {left}; backward Euler–Maruyama, which the text prints as “symplectic \
             Euler–Maruyama”, dissipates. The endpoint and initial-point rules are the symplectic methods; the exact \
             solution is drawn jointly with the increments of the path. Below: the energies of the endpoint and \
             the initial-point rule oscillate in opposite phases.",
            options.horizon
        ),
        checks,
    })
}

/// The ranges of the panels.
struct Picture {
    /// Largest energy of the panel of energies.
    energy: f64,
    /// Largest |q| and |p|.
    size: f64,
    /// Largest |q| and |p| of backward Euler–Maruyama.
    backward: f64,
    /// Time at which forward Euler–Maruyama leaves this range.
    left: Option<f64>,
}

impl Picture {
    fn of(runs: &[Run], solution: &Run) -> Result<Self, StepError> {
        let mut highest: f64 = 0.0;
        for z in runs[INITIAL_POINT]
            .states
            .iter()
            .chain(&runs[ENDPOINT].states)
            .chain(&solution.states)
        {
            highest = highest.max(energy(z)?);
        }
        let size = (2.4 * highest).sqrt();
        let inside = runs[FORWARD].inside(size);
        let leaves = inside.len() < runs[FORWARD].states.len();
        let backward = runs[BACKWARD].states.iter();
        let backward = backward.fold(0.0, |largest: f64, z| {
            largest.max(z.q[0].abs()).max(z.p[0].abs())
        });
        Ok(Self {
            // Leaves room for the legend.
            energy: 1.6 * highest,
            size,
            backward: 1.1 * backward,
            left: inside.last().filter(|_| leaves).map(|z| z.t),
        })
    }
}

/// Checks the rate at which forward Euler–Maruyama finally grows: its map is a rotation times √(1 +
/// h²).
fn growth(run: &Run) -> Check {
    let last = run.states.len() - 1;
    let (from, to) = (&run.states[last / 2], &run.states[last]);
    let rate = 2.0 * (ln_radius(to) - ln_radius(from)) / (to.t - from.t);
    let expected = (H * H).ln_1p() / H;
    // The noise of the second half adds a variance of σ² h (1 + h²)/h² in units of the radius at
    // its start.
    let noise = 2.0 * OSCILLATOR.sigma * ((1.0 + H * H) / H).sqrt()
        / ln_radius(from).exp()
        / (to.t - from.t);
    Check::new(
        "forward Euler–Maruyama: growth rate of the energy, second half",
        rate,
    )
    .near(
        expected,
        5.0 * noise + 1e-12,
        "ln(1 + h²)/h; 5 standard deviations of the noise added since, and rounding",
    )
}

/// Checks the time average of the backward method's energy over the second half.
fn settled(options: &Options, linear: Linear<2>, run: &Run) -> Result<Check, StepError> {
    let a = linear.0;
    let scheme = Scheme::driven(linear, H);
    let half = run.states.len() / 2;
    let count = (run.states.len() - half) as f64;
    let mut average = 0.0;
    for z in &run.states[half..] {
        average += energy(z)? / count;
    }
    let mut expected = 0.0;
    let mut last = sve_examples::gaussian::Gaussian::certain(START);
    for (k, law) in scheme
        .distributions(START)
        .take(run.states.len())
        .enumerate()
    {
        if k >= half {
            expected += law.quadratic(&ENERGY).0 / count;
        }
        last = law;
    }
    // The covariance for a stationary Gaussian is cov(H_k, H_{k+l}) = ½ tr(C Cᵀ), C = A^l Σ.
    let mut c = last.covariance;
    let mut variance = 0.0;
    for lag in 0..run.states.len() - half {
        let covariance = 0.5 * c.iter().flatten().map(|x| x * x).sum::<f64>();
        variance += covariance * if lag == 0 { 1.0 } else { 2.0 } / count;
        c = product(&a, &c);
    }
    let independent = last.quadratic(&ENERGY).1 / variance;
    Ok(Check::new("backward Euler–Maruyama: mean energy, second half", average).near(expected, standard_errors(independent) * variance.sqrt(), format!("moment recursion (it tends to 5); worth {independent:.0} independent values, false alarm 10⁻⁴"))
    .only_if(options.horizon >= 200.0, "not settled before t = 100"))
}

/// Checks the distance of a symplectic run from the exact solution on the same path.
fn near_exact(entry: &Entry, joint: &Scheme<4>, run: &Run, solution: &Run) -> [Check; 2] {
    let start = [START[0], START[1], START[0], START[1]];
    let steps = run.states.len() - 1;
    let (ours, exact) = (run.states[steps], solution.states[steps]);
    let error = [ours.q[0] - exact.q[0], ours.p[0] - exact.p[0]];
    let law = oscillator::difference(&joint.after(start, steps));
    let surprise = law.surprise(error);
    let rms = law.quadratic(&[[1.0, 0.0], [0.0, 1.0]]).0.sqrt();
    [
        Check::new(
            format!(
                "{}: error at the horizon, squared, in units of its covariance",
                entry.name
            ),
            surprise,
        )
        .near(
            2.0,
            SURPRISE - 2.0,
            "χ² with 2 degrees of freedom, exact covariance by recursion; false alarm 10⁻⁴",
        ),
        Check::new(
            format!(
                "{}: distance from the exact solution at the horizon",
                entry.name
            ),
            error[0].hypot(error[1]),
        )
        .reported(format!(
            "root mean square over all paths, by recursion: {rms:.4}"
        )),
    ]
}

/// Checks that the exact solution has the right law.
fn law(scheme: &Scheme<2>, solution: &Run) -> Check {
    let steps = solution.states.len() - 1;
    let z = solution.states[steps];
    let surprise = scheme.after(START, steps).surprise([z.q[0], z.p[0]]);
    Check::new(
        "exact solution at the horizon, squared, in units of its covariance",
        surprise,
    )
    .near(
        2.0,
        SURPRISE - 2.0,
        "χ² with 2 degrees of freedom; false alarm 10⁻⁴",
    )
}

fn energy_at_end(name: &str, run: &Run) -> Result<Check, StepError> {
    let (t, energy) = match run.states.last() {
        Some(z) => (z.t, energy(z)?),
        None => (f64::NAN, f64::NAN),
    };
    Ok(Check::new(format!("{name}: energy at t = {t:.0}"), energy).reported("this path"))
}

fn draw(
    options: &Options,
    entries: &[Entry],
    runs: &[Run],
    solution: &Run,
    picture: &Picture,
) -> Result<Figure, StepError> {
    let phase = |title: &str, size: f64, states: &[State<[f64; 1]>], color| {
        let axis = |name| Axis::new(name, -size..size);
        let orbit = states.iter().map(|z| (z.q[0], z.p[0])).collect();
        Panel::new(title, axis("q"), axis("p"))
            .equal()
            .with(Layer::new(title, orbit, Pen::line(color, 0.5)))
    };
    let title = |index: usize, what: &str| {
        let name = entries[index].name;
        let (first, rest) = name.split_at(1);
        format!("{}{rest}{what}", first.to_uppercase())
    };
    let color = |index: usize| entries[index].pen.color;
    let of = |index: usize, what: &str, size: f64| {
        let states = runs[index].inside(size);
        phase(&title(index, what), size, states, color(index))
    };
    let until = picture.left.map(|t| format!(" up to t = {t:.1}"));
    let size = picture.size;
    Ok(Figure {
        name: "figure2",
        width: 1110,
        rows: vec![
            Row {
                height: 370,
                panels: vec![
                    of(FORWARD, &until.unwrap_or_default(), size),
                    of(BACKWARD, ", enlarged", picture.backward),
                    energies(options, entries, runs, solution, picture)?,
                ],
            },
            Row {
                height: 370,
                panels: vec![
                    of(ENDPOINT, " (symplectic)", size),
                    of(INITIAL_POINT, " (symplectic)", size),
                    phase(
                        "Exact solution, same path",
                        size,
                        &solution.states,
                        palette::BLACK,
                    ),
                ],
            },
            Row {
                height: 320,
                panels: vec![differences(options, entries, runs, solution)?],
            },
        ],
    })
}

/// Draws the energies of the symplectic rules less that of the exact solution, on the last part of
/// the path.
fn differences(
    options: &Options,
    entries: &[Entry],
    runs: &[Run],
    solution: &Run,
) -> Result<Panel, StepError> {
    let from = (options.horizon - LAST).max(0.0);
    let (mut least, mut greatest) = (0.0_f64, 0.0_f64);
    let mut layers = Vec::new();
    for index in [MIDPOINT, INITIAL_POINT, ENDPOINT] {
        let mut points = Vec::new();
        let pairs = runs[index].states.iter().zip(&solution.states);
        for (ours, exact) in pairs.filter(|(z, _)| z.t >= from) {
            let difference = energy(ours)? - energy(exact)?;
            (least, greatest) = (least.min(difference), greatest.max(difference));
            points.push((ours.t, difference));
        }
        layers.push(Layer::new(entries[index].name, points, entries[index].pen));
    }
    let margin = 0.05 * (greatest - least);
    let panel = Panel::new(
        format!("Energy less that of the exact solution, the last {LAST} time units"),
        Axis::new("time t", from..options.horizon),
        Axis::new("difference of energies", least - margin..greatest + margin),
    );
    let panel = layers.into_iter().fold(panel, Panel::with);
    Ok(panel.legend(Corner::Below))
}

fn energies(
    options: &Options,
    entries: &[Entry],
    runs: &[Run],
    solution: &Run,
    picture: &Picture,
) -> Result<Panel, StepError> {
    let curve = |run: &Run, every: usize| -> Result<Vec<(f64, f64)>, StepError> {
        run.states
            .iter()
            .step_by(every)
            .map(|z| Ok((z.t, energy(z)?)))
            .collect()
    };
    let every = options.steps().div_ceil(1000).max(1);
    let mut panel = Panel::new(
        "Energy against time",
        Axis::new("time t", 0.0..options.horizon),
        Axis::new("energy H", 0.0..picture.energy),
    )
    .legend(Corner::TopRight);
    panel.x.labels = 5;
    let mean = vec![(0.0, 0.5), (options.horizon, 0.5 + 0.5 * options.horizon)];
    panel = panel
        .with(Layer::new(
            "mean H₀ + σ²t/2",
            mean,
            Pen::dashed(hues::EXACT, 1.0, (9.0, 4.0)),
        ))
        .with(Layer::new(
            "exact, this path",
            curve(solution, every)?,
            Pen::line(hues::EXACT, 2.2),
        ));
    for index in [FORWARD, BACKWARD] {
        // Forward Euler–Maruyama crosses the picture within a few points.
        let points = curve(&runs[index], if index == FORWARD { 1 } else { every })?;
        panel = panel.with(Layer::new(entries[index].name, points, entries[index].pen));
    }
    Ok(panel)
}
