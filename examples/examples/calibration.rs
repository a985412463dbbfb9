//! Calibration of a noisy oscillator: the method of Gauss and Newton, with gradients of means,
//! finds its stiffness k and the strength σ of its noise from data.
//!
//! The program makes the data itself: at each of twelve times another sample of oscillators is
//! measured, and the means of q and q² are kept. The model's means, their covariances and their
//! derivatives by k and σ come from `Ensemble::gradient`. All iterations have the same paths, so
//! the sum of squares is a smooth function and they converge. The result is compared with the same
//! fit with exact means, and with the values that made the data. The figure is written to
//! `target/calibration/`; the program exits with status 1 if a number is off.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Shape};
use sve_examples::gaussian::{Gaussian, Scheme};
use sve_examples::palette;
use sve_examples::report::{one_row, report};
use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

#[derive(Clone, Copy, Debug)]
struct Oscillator {
    k: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * self.k * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

const H: f64 = 0.02;
/// Number of steps between two times of the data.
const STEPS: u64 = 25;
const TIMES: usize = 12;
/// The values of k and σ that make the data.
const TRUTH: [f64; 2] = [1.7, 0.45];
const GUESS: [f64; 2] = [1.2, 0.8];
const START: State<[f64; 1]> = State::new([1.0], [0.0]);
/// Number of oscillators in a sample, and number of paths of the model.
const SAMPLE: u64 = 400;
const PATHS: u64 = 20_000;

/// The means of q and q² of a sample, and their standard errors.
struct Measurement {
    means: Vector2<f64>,
    errors: Vector2<f64>,
}

/// The means of q and q² at a time, their covariance over oscillators, and their derivatives by k
/// and σ.
#[derive(Clone, Copy)]
struct Prediction {
    means: Vector2<f64>,
    covariance: Matrix2<f64>,
    slopes: Matrix2<f64>,
}

/// Means at each time of the data for k and σ.
type Model = dyn Fn(Vector2<f64>) -> Result<Vec<Prediction>, EnsembleError>;

/// A result of the method of Gauss and Newton.
struct Fit {
    /// The iterates, from the guess on.
    iterates: Vec<Vector2<f64>>,
    covariance: Matrix2<f64>,
    /// Sum of squares of the residuals in units of their errors.
    chi_squared: f64,
}

impl Fit {
    fn last(&self) -> Vector2<f64> {
        self.iterates[self.iterates.len() - 1]
    }

    fn error(&self, i: usize) -> f64 {
        self.covariance[(i, i)].sqrt()
    }
}

fn oscillator(values: Vector2<f64>) -> Integrator<Oscillator, Midpoint> {
    let [k, sigma] = values.into();
    Integrator::new(Oscillator { k, sigma }, Midpoint)
}

/// Measures another sample of oscillators at each time.
fn measure() -> Result<Vec<Measurement>, EnsembleError> {
    let truth = oscillator(TRUTH.into());
    let sample = |time: u64| {
        let summary = Ensemble::new(&truth)
            .paths(SAMPLE)
            .seed(100 + time)
            .steps(H, STEPS * time)
            .start(START)
            .observe("q", |_, s| s.q[0])
            .observe("q²", |_, s| s.q[0].powi(2))
            .run()?;
        let [q, square] = [&summary["q"], &summary["q²"]];
        Ok(Measurement {
            means: Vector2::new(q.mean()[1], square.mean()[1]),
            errors: Vector2::new(q.standard_error()[1], square.standard_error()[1]),
        })
    };
    (1..=TIMES as u64).map(sample).collect()
}

/// Runs the model's paths, which are the same for all values.
fn run(values: Vector2<f64>) -> Result<Summary, EnsembleError> {
    let model = oscillator(values);
    Ensemble::new(&model)
        .paths(PATHS)
        .seed(1)
        .steps(H, STEPS * TIMES as u64)
        .every(STEPS)
        .start(START)
        .gradient("q", ["k", "sigma"], |s| s.q[0])
        .gradient("q²", ["k", "sigma"], |s| s.q[0].powi(2))
        .observe("q³", |_, s| s.q[0].powi(3))
        .run()
}

/// Returns the means of the model by Monte Carlo.
fn by_paths(values: Vector2<f64>) -> Result<Vec<Prediction>, EnsembleError> {
    let summary = run(values)?;
    let slope = |name, by, time: usize| {
        let derivative = summary.derivative(name, by);
        derivative.map_or(f64::NAN, |derivative| derivative.mean()[time])
    };
    let mean = |name: &str, time: usize| summary[name].mean()[time];
    let variance = |name: &str, time: usize| summary[name].variance()[time];
    let mixed = |time| mean("q³", time) - mean("q", time) * mean("q²", time);
    let at = |time: usize| Prediction {
        means: Vector2::new(mean("q", time), mean("q²", time)),
        covariance: Matrix2::new(
            variance("q", time),
            mixed(time),
            mixed(time),
            variance("q²", time),
        ),
        slopes: Matrix2::new(
            slope("q", "k", time),
            slope("q", "sigma", time),
            slope("q²", "k", time),
            slope("q²", "sigma", time),
        ),
    };
    Ok((1..=TIMES).map(at).collect())
}

/// Returns the exact law of the state at all steps of the midpoint rule, whose step is linear:
/// `p₁ − p₀ = −hk(q₀ + q₁)/2 + σΔW`, `q₁ − q₀ = h(p₀ + p₁)/2`.
fn exact_laws(values: Vector2<f64>) -> impl Iterator<Item = Gaussian<2>> {
    let [k, sigma] = values.into();
    let x = 0.25 * H * H * k;
    let scale = 1.0 / (1.0 + x);
    let a = [[1.0 - x, H], [-H * k, 1.0 - x]];
    let b = [0.5 * H * sigma * scale, sigma * scale];
    let scheme = Scheme {
        a: a.map(|row| row.map(|a| scale * a)),
        noise: b.map(|first| b.map(|second| H * first * second)),
    };
    let first = Gaussian::certain([START.q[0], START.p[0]]);
    std::iter::successors(Some(first), move |y| Some(scheme.step(y)))
}

/// Returns the means of q and q².
fn means_of(law: &Gaussian<2>) -> Vector2<f64> {
    let (mean, variance) = (law.mean[0], law.covariance[0][0]);
    Vector2::new(mean, mean * mean + variance)
}

/// Returns the exact means of the model, with derivatives by central differences, which have nine
/// correct digits.
fn exactly(values: Vector2<f64>) -> Vec<Prediction> {
    let at_times = |values| {
        let all = exact_laws(values).step_by(STEPS as usize);
        all.skip(1).take(TIMES).collect::<Vec<_>>()
    };
    let slopes = [Vector2::x(), Vector2::y()].map(|direction| {
        let d = 1e-5;
        let both = [values + d * direction, values - d * direction].map(at_times);
        let pairs = both[0].iter().zip(&both[1]);
        pairs
            .map(|(a, b)| (means_of(a) - means_of(b)) / (2.0 * d))
            .collect::<Vec<_>>()
    });
    let slopes = slopes[0].iter().zip(&slopes[1]);
    let all = at_times(values)
        .into_iter()
        .zip(slopes)
        .map(|(law, (k, sigma))| {
            let (m, v) = (law.mean[0], law.covariance[0][0]);
            Prediction {
                means: means_of(&law),
                covariance: Matrix2::new(
                    v,
                    2.0 * m * v,
                    2.0 * m * v,
                    4.0 * m * m * v + 2.0 * v * v,
                ),
                slopes: Matrix2::from_columns(&[*k, *sigma]),
            }
        });
    all.collect()
}

/// Minimises the sum of squares of the residuals in units of their errors. The errors come from the
/// model, since the errors of a sample are smaller where its mean happens to be small. `share` is
/// the part of their squares that the model's own sampling adds.
fn fit(data: &[Measurement], model: &Model, share: f64) -> Result<Fit, Box<dyn Error>> {
    let mut iterates = vec![Vector2::from(GUESS)];
    loop {
        let at = iterates[iterates.len() - 1];
        let (mut normal, mut right, mut chi_squared) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
        for (measured, predicted) in data.iter().zip(model(at)?) {
            let covariance = predicted.covariance * ((1.0 + share) / SAMPLE as f64);
            let weights = covariance.try_inverse().ok_or("a mean without noise")?;
            let residual = measured.means - predicted.means;
            let weighted = predicted.slopes.transpose() * weights;
            normal += weighted * predicted.slopes;
            right += weighted * residual;
            chi_squared += residual.dot(&(weights * residual));
        }
        let covariance = normal
            .try_inverse()
            .ok_or("data that do not tell k and σ")?;
        let change = covariance * right;
        // The change is measured in units of the errors.
        if change.dot(&(normal * change)) < 1e-6 {
            return Ok(Fit {
                iterates,
                covariance,
                chi_squared,
            });
        }
        if iterates.len() == 20 {
            return Err("the iteration does not converge".into());
        }
        iterates.push(at + change);
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let data = measure()?;
    let share = SAMPLE as f64 / PATHS as f64;
    let start = Instant::now();
    let found = fit(&data, &by_paths, share)?;
    let seconds = start.elapsed().as_secs_f64();
    let exact = fit(&data, &|values| Ok(exactly(values)), 0.0)?;
    println!("iteration          k          σ");
    for (number, values) in found.iterates.iter().enumerate() {
        println!("{number:>9} {:>10.6} {:>10.6}", values[0], values[1]);
    }
    println!("{PATHS} paths an iteration, {seconds:.2} s for all\n");
    let (checks, caption) = (checks(&found, &exact)?, caption(&found));
    let figure = figure(&data, &found);
    report(
        "Calibration of a noisy oscillator",
        &figure,
        &caption,
        &checks,
    )
}

fn caption(fit: &Fit) -> String {
    format!(
        "Left and middle: means of q and q² over {SAMPLE} oscillators at each time, with bars of one standard error on either side, and the means of the midpoint rule, h = {H}, for the first guess and for the fit. \
         Right: the iterates of the method of Gauss and Newton with {PATHS} paths, the first of which lie outside the picture, and the ellipses of one and two standard errors: k = {:.4} ± {:.4}, σ = {:.4} ± {:.4}. \
         Seeds: 1 of the model's paths, 101 to 112 of the data.",
        fit.last()[0],
        fit.error(0),
        fit.last()[1],
        fit.error(1)
    )
}

fn checks(found: &Fit, exact: &Fit) -> Result<Vec<Check>, EnsembleError> {
    let mut checks = Vec::new();
    for (i, name) in ["k", "σ"].into_iter().enumerate() {
        let (value, error) = (found.last()[i], found.error(i));
        let what = format!("{name} against the value of the data");
        let why = format!("4 errors of {}", number(error, 2));
        checks.push(Check::new(what, value).near(TRUTH[i], 4.0 * error, why));
        // The variance of the model's means, beside the variance of the data.
        let own = error * (SAMPLE as f64 / PATHS as f64).sqrt();
        let what = format!("{name} against the fit with exact means");
        let why = "4 errors of the paths";
        checks.push(Check::new(what, value).near(exact.last()[i], 4.0 * own, why));
    }
    let freedom = (2 * TIMES - 2) as f64;
    let why = format!("{freedom} degrees of freedom; 4 standard deviations");
    let allowed = 4.0 * (2.0 * freedom).sqrt();
    checks.push(Check::new("χ²", found.chi_squared).near(freedom, allowed, why));
    let (summary, exact) = (run(found.last())?, exactly(found.last()));
    for (column, (by, name)) in [("k", "k"), ("sigma", "σ")].into_iter().enumerate() {
        let Some(derivative) = summary.derivative("q²", by) else {
            continue;
        };
        let (mean, error) = (derivative.mean()[TIMES], derivative.standard_error()[TIMES]);
        let expected = exact[TIMES - 1].slopes[(1, column)];
        let why = "the exact derivative at the last time; 4.5 standard errors";
        let what = format!("∂E[q²]/∂{name}");
        checks.push(Check::new(what, mean).near(expected, 4.5 * error, why));
    }
    let iterations = (found.iterates.len() - 1) as f64;
    let why = "quadratic convergence where the fit is good";
    checks.push(Check::new("iterations", iterations).near(5.0, 3.0, why));
    Ok(checks)
}

fn figure(data: &[Measurement], fit: &Fit) -> Figure {
    let end = H * (STEPS as usize * TIMES) as f64;
    let panel = |number: usize, name: &str, range| {
        let time = |at: usize| H * (STEPS as usize * (at + 1)) as f64;
        let points = data.iter().enumerate();
        let dots = points.map(|(at, m)| (time(at), m.means[number]));
        let bars = data.iter().map(|m| {
            let (mean, error) = (m.means[number], m.errors[number]);
            (mean - error, mean + error)
        });
        let curve = |values: Vector2<f64>| {
            let all = exact_laws(values)
                .enumerate()
                .take(STEPS as usize * TIMES + 1);
            all.map(|(step, law)| (H * step as f64, means_of(&law)[number]))
                .collect()
        };
        let guess = Pen::dashed(palette::GREY, 1.5, (5.0, 4.0));
        Panel::new(
            format!("Noisy oscillator: mean of {name}"),
            Axis::new("time t", 0.0..end + 0.2),
            Axis::new(format!("mean of {name}"), range),
        )
        .with(Layer::new("first guess", curve(fit.iterates[0]), guess))
        .with(Layer::new(
            "fit",
            curve(fit.last()),
            Pen::line(palette::BLUE, 1.5),
        ))
        .with(
            Layer::new("data", dots.collect(), Pen::dots(palette::VERMILION, 3.0))
                .bars(bars.collect()),
        )
    };
    one_row(
        "calibration",
        [1260, 400],
        vec![
            panel(0, "q", -1.3..1.6).legend(Corner::TopRight),
            panel(1, "q²", 0.0..2.6).legend(Corner::TopLeft),
            iterates(fit),
        ],
    )
}

/// Draws the last iterates in the plane of k and σ, with the ellipses of one and two standard
/// errors.
fn iterates(fit: &Fit) -> Panel {
    let (last, errors) = (fit.last(), [fit.error(0), fit.error(1)]);
    let range = |i: usize| last[i] - 4.0 * errors[i]..last[i] + 4.0 * errors[i];
    let root = fit.covariance.cholesky().map(|factors| factors.l());
    let ellipse = |size: f64| {
        let angles = (0..=120).map(|i| std::f64::consts::TAU * f64::from(i) / 120.0);
        let root = root.unwrap_or_default();
        angles
            .map(|angle| last + size * (root * Vector2::new(angle.cos(), angle.sin())))
            .map(|x| (x[0], x[1]))
            .collect()
    };
    let path = fit.iterates.iter().map(|x| (x[0], x[1])).collect();
    let cross = Pen {
        line: None,
        ..Pen::line(palette::BLACK, 1.0).symbols(Shape::Cross, 1)
    };
    let walk = Pen {
        symbol: Pen::dots(palette::BLUE, 3.0).symbol,
        ..Pen::line(palette::BLUE, 1.0)
    };
    let line = Pen::line(palette::GREEN, 1.5);
    Panel::new(
        "Noisy oscillator: last iterates",
        Axis::new("k", range(0)),
        Axis::new("σ", range(1)),
    )
    .legend(Corner::BottomRight)
    .with(Layer::new("1 and 2 standard errors", ellipse(1.0), line))
    .with(Layer::new("", ellipse(2.0), line).unlisted())
    .with(Layer::new("Gauss–Newton", path, walk))
    .with(Layer::new("values of the data", vec![TRUTH.into()], cross))
}
