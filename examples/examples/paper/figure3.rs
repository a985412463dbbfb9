//! Figure 3: the mean energy of the stochastic linear oscillator over many paths.

use std::error::Error;

use sve_examples::check::{Check, number};
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use sve_examples::gaussian::{ENERGY, Matrix, Scheme, standard_errors};
use sve_examples::report::one_row;
use sve_examples::{hues, palette};
use sve_runtime::plot::page;
use sve_runtime::prelude::*;

use crate::Report;
use crate::oscillator::{self, Entry, Exact, START, energy};
use crate::run::Run;
use crate::settings::{H, Options, step_of};

/// Times at which `examples/peers/paper.py` computes expected energies independently. The text
/// prints no energies.
const TIMES: [f64; 3] = [10.0, 100.0, 2000.0];
/// E[H] at these times by an independent moment recursion: first the schemes in the order of
/// [`oscillator::entries`], then the exact solution.
const INDEPENDENT: [[f64; 3]; 6] = [
    [9.876_476_061_818_382, 115_270.356_007_975_24, 1.471_76e87],
    [3.336_299_544_518_964, 4.999_785_296_694_256, 5.0],
    [
        5.487_531_172_069_843,
        50.375_311_720_699_36,
        998.006_234_414_838_6,
    ],
    [
        5.498_433_996_767_535,
        50.651_649_400_242_31,
        1_003.025_792_097_458_6,
    ],
    [
        5.529_280_993_840_45,
        50.599_043_290_997_86,
        1_002.986_534_292_542_2,
    ],
    [5.5, 50.5, 1000.5],
];
/// The entry that was stored with six digits only.
const SIX_DIGITS: (usize, usize) = (0, 2);

/// Energies of one method: sum over the paths at each step, and sum of squares.
#[derive(Default)]
struct Sums {
    energy: Vec<f64>,
    square: Vec<f64>,
    paths: f64,
}

impl Sums {
    /// Adds a run. If runs end early because they overflow, only their common part is kept.
    fn add(&mut self, run: &Run) -> Result<(), StepError> {
        let known = if self.paths == 0.0 {
            run.states.len()
        } else {
            self.energy.len()
        };
        let length = known.min(run.states.len());
        self.energy.resize(length, 0.0);
        self.square.resize(length, 0.0);
        for (k, z) in run.states[..length].iter().enumerate() {
            let energy = energy(z)?;
            self.energy[k] += energy;
            self.square[k] += energy * energy;
        }
        self.paths += 1.0;
        Ok(())
    }

    fn mean(&self, step: usize) -> f64 {
        self.energy
            .get(step)
            .map_or(f64::NAN, |sum| sum / self.paths)
    }

    /// Returns the standard error of the mean, from the sample.
    fn standard_error(&self, step: usize) -> f64 {
        let mean = self.mean(step);
        let square = self
            .square
            .get(step)
            .map_or(f64::NAN, |sum| sum / self.paths);
        ((square - mean * mean) / (self.paths - 1.0)).sqrt()
    }
}

pub(crate) fn report(options: &Options, tick: &dyn Fn()) -> Result<Report, Box<dyn Error>> {
    let entries = oscillator::entries();
    let exact = Exact::new();
    let mut sums: [Sums; 6] = Default::default();
    for number in 0..u64::from(options.paths) {
        let path = Wiener::new(options.seed).path(number);
        for (entry, sums) in entries.iter().zip(&mut sums) {
            sums.add(&entry.scheme.run(&path, options.steps())?)?;
        }
        sums[5].add(&exact.run(&path, options.steps()))?;
        tick();
    }
    let mut schemes = Vec::new();
    for entry in &entries {
        schemes.push(Scheme::driven(entry.scheme.linear()?, H));
    }
    schemes.push(exact.moments());
    let names: Vec<&str> = entries
        .iter()
        .map(|e| e.name)
        .chain(["exact solution"])
        .collect();
    let mut checks = Vec::new();
    for ((name, scheme), independent) in names.iter().zip(&schemes).zip(INDEPENDENT) {
        checks.push(recursion(name, scheme, independent));
    }
    checks.push(six_digits(&schemes[SIX_DIGITS.0]));
    for ((name, scheme), sums) in names.iter().zip(&schemes).zip(&sums) {
        checks.extend(means(options, name, scheme, sums));
    }
    for (index, entry) in entries.iter().enumerate().skip(2) {
        let joint = exact.beside(entry.scheme.linear()?);
        checks.push(paired(options, entry.name, &joint, &sums[index], &sums[5]));
    }
    Ok(Report {
        title: "Figure 3. Stochastic linear oscillator, mean energy",
        figure: draw(options, &entries, &schemes, &sums),
        caption: format!(
            "Mean energy over {} paths, h = {H}, T = {}, σ = 1, start (1, 0). The exact mean is H₀ + σ²t/2; the band \
             is one standard error of the mean of so many exact energies on either side. Right: the first part, with the \
             expectation of Euler's methods by the moment recursion M₁ = A M₀ Aᵀ + σ²h b bᵀ, A and b read off their own steps. \
             Below: the symplectic rules, whose means are not distinguishable from that of the exact solution above.",
            options.paths, options.horizon
        ),
        checks,
    })
}

/// Returns the expected energy after each step.
fn expected(scheme: &Scheme<2>, steps: usize) -> Vec<f64> {
    scheme
        .distributions(START)
        .take(steps + 1)
        .map(|law| law.quadratic(&ENERGY).0)
        .collect()
}

/// Compares the recursion of the scheme's own step with the independent recursion.
fn recursion(name: &str, scheme: &Scheme<2>, independent: [f64; 3]) -> Check {
    let energies = expected(scheme, step_of(TIMES[2]));
    let digits = |value: f64| value != INDEPENDENT[SIX_DIGITS.0][SIX_DIGITS.1];
    let worst = TIMES
        .into_iter()
        .zip(independent)
        .filter(|(_, value)| digits(*value))
        .map(|(t, value)| (energies[step_of(t)] / value - 1.0).abs())
        .fold(0.0, f64::max);
    Check::new(
        format!(
            "{name}: E[H] by recursion, relative difference from values computed independently"
        ),
        worst,
    )
    .near(0.0, 1e-10, "20 000 steps, a few roundings of A and M each")
}

fn six_digits(scheme: &Scheme<2>) -> Check {
    let energies = expected(scheme, step_of(TIMES[2]));
    let value = INDEPENDENT[SIX_DIGITS.0][SIX_DIGITS.1];
    Check::new(
        "forward Euler–Maruyama: E[H] by recursion at t = 2000",
        energies[step_of(TIMES[2])],
    )
    .near(
        value,
        5e-6 / 1.471_76 * value,
        "computed independently to six digits; half a unit of the last one",
    )
}

/// Returns the times at which means are compared: the times computed independently up to the
/// horizon, and the horizon.
fn times(options: &Options) -> Vec<f64> {
    let mut times: Vec<f64> = TIMES.into_iter().filter(|t| *t < options.horizon).collect();
    times.push(options.steps() as f64 * H);
    times
}

/// Compares mean energies over the paths with the recursion.
fn means(options: &Options, name: &str, scheme: &Scheme<2>, sums: &Sums) -> Vec<Check> {
    let laws: Vec<_> = scheme
        .distributions(START)
        .take(options.steps() + 1)
        .collect();
    let paths = f64::from(options.paths);
    let factor = standard_errors(paths);
    let expected = |t: f64| {
        let (mean, variance) = laws[step_of(t)].quadratic(&ENERGY);
        (mean, (variance / paths).sqrt())
    };
    let check = |t: f64| {
        let (mean, error) = expected(t);
        let measured = sums.mean(step_of(t));
        let score = (measured - mean) / error;
        Check::new(format!("{name}: mean energy at t = {t:.0}"), measured).near(mean, factor * error, format!("moment recursion; z = {}, {factor:.1} exact standard errors allowed (false alarm 10⁻⁴)", page::number(score, 2)))
        .only_if(
            (factor * error).is_finite() && measured.is_finite(),
            "energies or their squares overflow",
        )
    };
    let end = options.steps() as f64 * H;
    let error = Check::new(
        format!("{name}: standard error of that mean, from the sample"),
        sums.standard_error(step_of(end)),
    )
    .reported(format!("exact: {}", number(expected(end).1)));
    times(options)
        .into_iter()
        .map(check)
        .chain([error])
        .collect()
}

/// Compares the mean difference of energies on the same paths. This comparison is much sharper,
/// because the scatter of the paths cancels.
fn paired(options: &Options, name: &str, joint: &Scheme<4>, sums: &Sums, exact: &Sums) -> Check {
    let t = options.horizon.min(TIMES[1]);
    let step = step_of(t);
    let mut form: Matrix<4> = [[0.0; 4]; 4];
    for (i, sign) in [0.5, 0.5, -0.5, -0.5].into_iter().enumerate() {
        form[i][i] = sign;
    }
    let start = [START[0], START[1], START[0], START[1]];
    let (mean, variance) = joint.after(start, step).quadratic(&form);
    let paths = f64::from(options.paths);
    Check::new(
        format!(
            "{name}: mean energy less that of the exact solution on the same paths, t = {t:.0}"
        ),
        sums.mean(step) - exact.mean(step),
    )
    .near(
        mean,
        standard_errors(paths) * (variance / paths).sqrt(),
        "joint moment recursion of scheme and exact solution",
    )
}

fn draw(options: &Options, entries: &[Entry], schemes: &[Scheme<2>], sums: &[Sums]) -> Figure {
    let horizon = options.horizon;
    let top = 0.5 + 0.5 * horizon;
    let whole = Panel::new(
        format!("Mean energy over {} paths", options.paths),
        Axis::new("time t", 0.0..horizon),
        Axis::new("mean energy", 0.0..1.9 * top),
    );
    let early = horizon.min(100.0);
    let part = Panel::new(
        "The first part, with expectations",
        Axis::new("time t", 0.0..early),
        Axis::new("mean energy", 0.0..0.95 * early),
    );
    let mut figure = one_row(
        "figure3",
        [1110, 460],
        vec![
            curves(whole, options, entries, schemes, sums, horizon),
            curves(part, options, entries, schemes, sums, early),
        ],
    );
    figure.rows.push(Row {
        height: 320,
        panels: vec![differences(options, entries, sums, early)],
    });
    figure
}

/// Draws the mean energies of the symplectic rules less that of the exact solution on the same
/// paths, up to time `end`.
fn differences(options: &Options, entries: &[Entry], sums: &[Sums], end: f64) -> Panel {
    let steps = step_of(end).min(options.steps());
    let exact = &sums[5];
    let layers = entries.iter().zip(sums).skip(2).map(|(entry, sums)| {
        let last = sums.energy.len().min(exact.energy.len()).min(steps + 1);
        let points = (0..last).map(|k| (k as f64 * H, sums.mean(k) - exact.mean(k)));
        Layer::new(entry.name, points.collect(), entry.pen)
    });
    let layers: Vec<Layer> = layers.collect();
    let points = layers.iter().flat_map(|layer| &layer.points);
    let (least, greatest) = points.fold((-1e-3, 1e-3), |(least, greatest): (f64, f64), point| {
        (least.min(point.1), greatest.max(point.1))
    });
    let margin = 0.05 * (greatest - least);
    let panel = Panel::new(
        "Mean energy less that of the exact solution on the same paths",
        Axis::new("time t", 0.0..end),
        Axis::new("difference of means", least - margin..greatest + margin),
    );
    let panel = layers.into_iter().fold(panel, Panel::with);
    panel.legend(Corner::Below)
}

/// Draws the means of Euler's methods and of the exact solution, the exact mean with its standard
/// error, and expectations, up to time `end`.
fn curves(
    mut panel: Panel,
    options: &Options,
    entries: &[Entry],
    schemes: &[Scheme<2>],
    sums: &[Sums],
    end: f64,
) -> Panel {
    let steps = step_of(end).min(options.steps());
    let every = steps.div_ceil(1000).max(1);
    let time = |k: usize| k as f64 * H;
    let laws: Vec<_> = schemes[5].distributions(START).take(steps + 1).collect();
    let (mut line, mut band) = (Vec::new(), Vec::new());
    for k in (0..=steps).step_by(every) {
        let (mean, variance) = laws[k].quadratic(&ENERGY);
        let error = (variance / f64::from(options.paths)).sqrt();
        line.push((time(k), mean));
        band.push((mean - error, mean + error));
    }
    let exact = Layer::new(
        "H₀ + σ²t/2 ± one standard error",
        line,
        Pen::dashed(hues::EXACT, 1.0, (9.0, 4.0)),
    );
    panel = panel.with(exact.band(band));
    let means = |sums: &Sums, every: usize| -> Vec<(f64, f64)> {
        let last = sums.energy.len().min(steps + 1);
        (0..last)
            .step_by(every)
            .map(|k| (time(k), sums.mean(k)))
            .collect()
    };
    for (index, (entry, sums)) in entries.iter().zip(sums).enumerate().take(2) {
        // Forward Euler–Maruyama, the first entry, crosses the picture within a few points.
        let every = if index == 0 { 1 } else { every };
        panel = panel.with(Layer::new(entry.name, means(sums, every), entry.pen));
    }
    let same = Pen::line(hues::EXACT, 1.2);
    panel = panel.with(Layer::new(
        "exact solution, same paths",
        means(&sums[5], every),
        same,
    ));
    if end < options.horizon || options.horizon <= 100.0 {
        for (k, scheme) in schemes.iter().take(2).enumerate() {
            let points = expected(scheme, steps)
                .into_iter()
                .enumerate()
                .map(|(k, e)| (time(k), e));
            let layer = Layer::new(
                "expectation of Euler–Maruyama by recursion",
                points.collect(),
                Pen::dashed(palette::BLACK, 1.0, (3.0, 3.0)),
            );
            panel = panel.with(if k == 0 { layer } else { layer.unlisted() });
        }
    }
    panel.legend(Corner::TopRight)
}
