//! The time that a mean costs by the multilevel method and by plain Monte Carlo, on one thread.
//!
//! ```text
//! 1.  dq = p (a dt + σ∘dW),  dp = −q (a dt + σ∘dW)
//!     E q = exp(−½σ²t) cos at              `midpoint`, weak order 1
//! 2.  dq = p dt,  dp = −q dt + σ dW
//!     E q² = cos²t + ½σ²(t − sin t cos t)  `midpoint`, weak order 2
//! ```
//!
//! The multilevel method wins if a small bias needs many steps, as in the first problem. In the
//! second problem a few steps have a smaller bias than the wanted errors, so there is little to
//! win. Both methods leave half of the squared error to the bias. Plain Monte Carlo is given the
//! longest step with so small a bias; the multilevel method has to estimate its bias. The errors of
//! the multilevel method are checked against closed forms. Status 1 if a number is off. Writes
//! `target/multilevel/`.

use std::error::Error;
use std::f64::consts::SQRT_2;
use std::process::ExitCode;
use std::time::Instant;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row, Shape};
use sve_examples::palette;
use sve_examples::report::report;
use sve_runtime::ensemble::{Level, MultilevelEstimate};
use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

/// The time of the mean.
const TIME: f64 = 2.0;
/// Wanted errors.
const ERRORS: [f64; 6] = [0.03, 0.01, 3e-3, 1e-3, 5e-4, 3e-4];
/// Number of path-steps in a measurement of the time of a plain path.
const PATH_STEPS: u64 = 1_000_000;
/// Seconds for which runs are repeated.
const REPEATED: f64 = 0.2;

/// A rotation whose speed is noisy.
struct Kubo {
    a: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v.powi(2) / (2.0 * self.a) - self.a / 2.0 * q.powi(2)
    }
    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.sigma / 2.0 * (q.powi(2) + p.powi(2))
    }
}

/// An oscillator that is pushed at random.
struct Oscillator {
    sigma: f64,
}

#[variational(midpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// A problem with its exact mean.
struct Problem<I> {
    name: &'static str,
    method: I,
    /// Number of steps of the coarsest level.
    steps: u64,
    weak_order: f64,
    observable: fn(f64) -> f64,
    exact: f64,
    /// The exact mean of the rule after so many steps.
    mean_of_rule: Box<dyn Fn(u64) -> f64>,
}

/// Times of one problem.
struct Times {
    /// Wanted error, and the shortest and the median time in seconds.
    multilevel: Vec<(f64, [f64; 2])>,
    plain: Vec<(f64, [f64; 2])>,
    finest: MultilevelEstimate,
    checks: Vec<Check>,
}

fn kubo() -> Problem<Integrator<Kubo, Midpoint>> {
    let (a, sigma) = (2.0, 0.6);
    Problem {
        name: "Kubo oscillator",
        method: Integrator::new(Kubo { a, sigma }, Midpoint),
        steps: 4,
        weak_order: 1.0,
        observable: |q| q,
        exact: (-0.5 * sigma * sigma * TIME).exp() * (a * TIME).cos(),
        mean_of_rule: Box::new(move |steps| {
            // A step turns q + ip by −2 atan(x/2), x = ah + σΔW. Its mean is computed by the
            // trapezoidal rule, which is exact to rounding here.
            let h = TIME / steps as f64;
            let (mut re, mut im, mut all) = (0.0, 0.0, 0.0);
            for i in -2000..=2000 {
                let z = f64::from(i) / 200.0;
                let weight = (-0.5 * z * z).exp();
                let angle = -2.0 * (0.5 * (a * h + sigma * h.sqrt() * z)).atan();
                re += weight * angle.cos();
                im += weight * angle.sin();
                all += weight;
            }
            let (length, angle) = ((re / all).hypot(im / all), im.atan2(re));
            let n = steps as f64;
            length.powf(n) * (n * angle).cos()
        }),
    }
}

fn oscillator() -> Problem<Integrator<Oscillator, Midpoint>> {
    let sigma = 1.0;
    let (sin, cos) = TIME.sin_cos();
    Problem {
        name: "pushed oscillator",
        method: Integrator::new(Oscillator { sigma }, Midpoint),
        steps: 4,
        weak_order: 2.0,
        observable: |q| q * q,
        exact: cos * cos + 0.5 * sigma * sigma * (TIME - sin * cos),
        mean_of_rule: Box::new(move |steps| {
            // A step is a rotation by θ = 2 atan(h/2) and the push b = σ(h/2, 1)/(1 + h²/4).
            let h = TIME / steps as f64;
            let theta = 2.0 * (0.5 * h).atan();
            let scale = sigma / (1.0 + 0.25 * h * h);
            let turned = |k: u64| {
                let (sin, cos) = (theta * k as f64).sin_cos();
                scale * (0.5 * h * cos + sin)
            };
            let noise: f64 = (0..steps).map(|k| h * turned(k).powi(2)).sum();
            (theta * steps as f64).cos().powi(2) + noise
        }),
    }
}

/// Returns the result of a function, and the shortest and the median of its times in seconds.
fn timed<T, E>(run: impl Fn() -> Result<T, E>) -> Result<(T, [f64; 2]), E> {
    let (begin, mut times) = (Instant::now(), Vec::new());
    loop {
        let start = Instant::now();
        let result = run()?;
        times.push(start.elapsed().as_secs_f64());
        if begin.elapsed().as_secs_f64() > REPEATED {
            times.sort_by(f64::total_cmp);
            return Ok((result, [times[0], times[times.len() / 2]]));
        }
    }
}

impl<I, S> Problem<I>
where
    I: Method<System = S> + Sync,
    S: sve_runtime::system::System<Dims = sve_runtime::system::Dims<1, 1>>,
{
    fn ensemble(&self, steps: u64, paths: u64, seed: u64) -> Ensemble<'_, I> {
        let observable = self.observable;
        Ensemble::new(&self.method)
            .paths(paths)
            .seed(seed)
            .threads(1)
            .steps(TIME / steps as f64, steps)
            .start(State::new([1.0], [0.0]))
            .observe("f", move |_, state| observable(state.q[0]))
    }

    fn multilevel(&self, error: f64, seed: u64) -> Result<MultilevelEstimate, EnsembleError> {
        let ensemble = self.ensemble(self.steps, 1024, seed);
        let estimate = ensemble.multilevel("f").weak_order(self.weak_order);
        estimate.run(error)
    }

    /// Returns the seconds of plain Monte Carlo: the time of a path, with the longest step whose
    /// bias is small enough, times the number of paths.
    fn plain(&self, error: f64) -> Result<([f64; 2], u64), EnsembleError> {
        let mut steps = self.steps;
        while ((self.mean_of_rule)(steps) - self.exact).abs() > error / SQRT_2 {
            steps += 1;
        }
        let paths = (PATH_STEPS / steps).next_multiple_of(64);
        let ensemble = self.ensemble(steps, paths, 2);
        let (summary, seconds) = timed(|| ensemble.run())?;
        let variance = summary["f"].variance()[1];
        let wanted = 2.0 * variance / (error * error);
        Ok((seconds.map(|x| x / paths as f64 * wanted), steps))
    }

    fn measure(&self) -> Result<Times, Box<dyn Error>> {
        let (mut multilevel, mut plain, mut checks) = (Vec::new(), Vec::new(), Vec::new());
        let mut finest = self.multilevel(ERRORS[0], 1)?;
        for error in ERRORS {
            let seconds;
            (finest, seconds) = timed(|| self.multilevel(error, 1))?;
            multilevel.push((error, seconds));
            let (seconds, steps) = self.plain(error)?;
            plain.push((error, seconds));
            let deepest = self.steps << (finest.levels().len() - 1);
            let bias = ((self.mean_of_rule)(deepest) - self.exact).abs();
            checks.push(Check::new(format!("{}: mean for an error of {}, {deepest} steps on the last level, {steps} of plain paths", self.name, number(error, 1)), finest.mean()).near(self.exact, bias + 4.5 * finest.standard_error(), "the exact bias of the last level and 4.5 standard errors"));
        }
        println!("{}\n{finest}\n", self.name);
        checks.extend(self.check_errors()?);
        Ok(Times {
            multilevel,
            plain,
            finest,
            checks,
        })
    }

    /// Compares the root of the mean squared error over several seeds with the wanted error.
    fn check_errors(&self) -> Result<Option<Check>, EnsembleError> {
        let (error, seeds) = (0.01, 32);
        let mut squares = 0.0;
        for seed in 0..seeds {
            squares += (self.multilevel(error, 100 + seed)?.mean() - self.exact).powi(2);
        }
        let found = (squares / seeds as f64).sqrt() / error;
        Ok(Some(
            Check::new(
                format!(
                    "{}: root of the mean squared error of {seeds} runs over the wanted error",
                    self.name
                ),
                found,
            )
            .near(
                0.75,
                0.75,
                "at most 1 in the mean, and 4 standard deviations of 32 values more",
            ),
        ))
    }
}

/// Draws the times of a problem of a weak order, which determines the slope of the time of plain
/// paths.
fn panel(name: &str, times: &Times, order: f64) -> Panel {
    let layer = |name: &str, times: &[(f64, [f64; 2])], color, shape| {
        let points = times.iter().map(|(x, y)| (x.log10(), y[0].log10()));
        let bars = times.iter().map(|(_, y)| (y[0].log10(), y[1].log10()));
        let pen = Pen::line(color, 1.5).symbols(shape, ERRORS.len());
        Layer::new(name, points.collect(), pen).bars(bars.collect())
    };
    let all: Vec<f64> = (times.multilevel.iter().chain(&times.plain))
        .flat_map(|(_, seconds)| seconds.map(f64::log10))
        .collect();
    let low = all.iter().copied().fold(f64::INFINITY, f64::min).floor();
    let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max).ceil();
    let guide = |times: &[(f64, [f64; 2])], slope: f64| {
        let [.., (error, seconds)] = times else {
            return Vec::new();
        };
        // beside the curve, which would hide it
        let (x, y) = (error.log10(), seconds[0].log10() - 0.4);
        vec![(x, y), (x + 1.5, y + 1.5 * slope)]
    };
    let slope = -2.0 - 1.0 / order;
    let grey = Pen::dashed(palette::GREY, 1.2, (5.0, 3.0));
    let slopes = format!("slopes {} and −2", number(slope, 2));
    Panel::new(
        format!("Time to error, {name}"),
        Axis::powers("root of the mean squared error", -3.7..-1.4),
        Axis::powers("seconds, one thread", low..high),
    )
    .legend(Corner::TopRight)
    .with(Layer::new(slopes, guide(&times.plain, slope), grey))
    .with(Layer::new("", guide(&times.multilevel, -2.0), grey).unlisted())
    .with(layer(
        "plain Monte Carlo",
        &times.plain,
        palette::VERMILION,
        Shape::Square,
    ))
    .with(layer(
        "multilevel",
        &times.multilevel,
        palette::BLUE,
        Shape::Circle,
    ))
}

/// Draws a quantity of the levels of both problems, as powers.
fn levels(
    quantity: &str,
    estimates: [(&str, &MultilevelEstimate); 2],
    value: fn(&Level) -> f64,
) -> Panel {
    let pens = [
        (palette::GREEN, Shape::Triangle),
        (palette::PURPLE, Shape::Circle),
    ];
    let series = estimates.map(|(name, estimate)| {
        let levels = estimate.levels().iter().enumerate();
        let points = levels.map(|(l, level)| (l as f64, value(level).log10()));
        (name, points.collect::<Vec<_>>())
    });
    let all = series.iter().flat_map(|(_, points)| points);
    let (last, low) = all.fold((0.0, 0.0), |(last, low): (f64, f64), point| {
        (last.max(point.0), low.min(point.1))
    });
    let mut panel = Panel::new(
        format!("Level 0 and differences: {quantity}"),
        Axis::new("level", -0.3..last + 0.3),
        Axis::powers(quantity, low - 0.3..0.8),
    )
    .legend(Corner::TopRight);
    for ((name, points), (color, shape)) in series.into_iter().zip(pens) {
        let pen = Pen::line(color, 1.5).symbols(shape, points.len());
        panel = panel.with(Layer::new(name, points, pen));
    }
    panel
}

/// Returns checks of the ratios of times, and of the decrease of the variances.
fn compare(name: &str, times: &Times) -> Vec<Check> {
    let pairs = times.multilevel.iter().zip(&times.plain);
    let mut checks: Vec<_> = pairs
        .map(|(multilevel, plain)| {
            Check::new(
                format!(
                    "{name}: time of plain Monte Carlo over that of levels, error {}",
                    number(plain.0, 1)
                ),
                plain.1[0] / multilevel.1[0],
            )
            .reported("measured in this run")
        })
        .collect();
    let levels = times.finest.levels();
    let [first, .., last] = &levels[levels.len() - 4..] else {
        return checks;
    };
    checks.push(
        Check::new(
            format!("{name}: fall of the variance from level to level, last four"),
            (first.variance / last.variance).cbrt(),
        )
        .near(
            4.0,
            0.6,
            "strong order 1; a variance of a thousand paths is known to 10 %",
        ),
    );
    checks
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (kubo, oscillator) = (kubo(), oscillator());
    let (first, second) = (kubo.measure()?, oscillator.measure()?);
    let both = [
        (kubo.name, &first.finest),
        (oscillator.name, &second.finest),
    ];
    let figure = Figure {
        name: "multilevel",
        width: 1080,
        rows: vec![
            Row {
                height: 400,
                panels: vec![
                    panel(kubo.name, &first, kubo.weak_order),
                    panel(oscillator.name, &second, oscillator.weak_order),
                ],
            },
            Row {
                height: 340,
                panels: vec![
                    levels("variance of a path", both, |level| level.variance),
                    levels("|mean|", both, |level| level.mean.abs()),
                ],
            },
        ],
    };
    let mut checks = compare(kubo.name, &first);
    checks.extend(compare(oscillator.name, &second));
    checks.extend(first.checks);
    checks.extend(second.checks);
    let caption = "Above: the time that an error costs, seed 1 of the levels and 2 of plain paths. Half of the squared error is bias, half is sampling. Symbols are the shortest of repeated runs; bars end at the median. \
        Plain Monte Carlo is given the longest step whose bias is small enough; its time is computed from that of a path. Left: weak order 1; the time of plain paths grows like the inverse cube of the error, and that of levels, once the error is small, like the inverse square. \
        Right: weak order 2; a few steps are enough for plain paths, and there is little to win. Below: variance and mean of level 0, then of the differences between levels, in the run with the smallest error.";
    report("The multilevel method", &figure, caption, &checks)
}
