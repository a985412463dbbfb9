//! The phase of the Kubo oscillator: its histogram against the wrapped normal density.
//!
//! dq = p (a dt + σ ∘ dW), dp = −q (a dt + σ ∘ dW) turns by θ = at + σW(t), so the phase at time t
//! is normal with mean at and variance σ²t, wrapped around the circle. A step of the midpoint rule
//! turns by 2 atan(x/2), x ~ N(ah, σ²h). Steps are independent, so the Fourier coefficients of the
//! density are powers of E exp(2ik atan(x/2)), and the distribution of the rule is known exactly
//! too.

use std::error::Error;
use std::f64::consts::{PI, TAU};

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::gaussian::expectation;
use sve_examples::report::one_row;
use sve_examples::{hues, palette};
use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

use crate::{Options, Report, known_difference, mean};

#[derive(Clone, Copy, Debug)]
struct Kubo {
    a: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - 0.5 * self.a * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

const KUBO: Kubo = Kubo { a: 1.0, sigma: 1.0 };
const H: f64 = 0.01;
const STEPS: u64 = 200;
const TIME: f64 = STEPS as f64 * H;
const BINS: usize = 60;
const WIDTH: f64 = TAU / BINS as f64;
/// Number of Fourier coefficients: the next one is below e⁻¹⁰⁰.
const ORDERS: usize = 14;

/// Fourier coefficients E exp(ikθ) of a distribution on the circle, as real and imaginary parts, k
/// from 1.
struct Distribution(Vec<(f64, f64)>);

impl Distribution {
    /// Returns a wrapped normal distribution.
    fn normal(mean: f64, variance: f64) -> Self {
        let of = |k: usize| {
            let k = k as f64;
            let size = (-0.5 * k * k * variance).exp();
            let (sin, cos) = (k * mean).sin_cos();
            (size * cos, size * sin)
        };
        Self((1..=ORDERS).map(of).collect())
    }

    /// Returns the distribution of the exact solution.
    fn exact() -> Self {
        Self::normal(KUBO.a * TIME, KUBO.sigma.powi(2) * TIME)
    }

    /// Returns the distribution of the exact solution, corrected by the leading error of the
    /// midpoint rule: a step lags by x³/12, so in unit time the mean by aσ²h/4 and the variance by
    /// σ⁴h/2.
    fn expanded() -> Self {
        let (a, square) = (KUBO.a, KUBO.sigma.powi(2));
        Self::normal(
            TIME * a * (1.0 - square * H / 4.0),
            TIME * square * (1.0 - square * H / 2.0),
        )
    }

    /// Returns the distribution of the midpoint rule.
    fn midpoint() -> Self {
        let (mean, deviation) = (KUBO.a * H, KUBO.sigma * H.sqrt());
        let of = |k: usize| {
            let angle = |x: f64| 2.0 * k as f64 * (0.5 * x).atan();
            let re = expectation(mean, deviation, |x| angle(x).cos());
            let im = expectation(mean, deviation, |x| angle(x).sin());
            let (size, turn) = (re.hypot(im).powi(STEPS as i32), STEPS as f64 * im.atan2(re));
            (size * turn.cos(), size * turn.sin())
        };
        Self((1..=ORDERS).map(of).collect())
    }

    fn density(&self, theta: f64) -> f64 {
        let term = |(k, (re, im)): (usize, &(f64, f64))| {
            let (sin, cos) = ((k + 1) as f64 * theta).sin_cos();
            2.0 * (re * cos + im * sin)
        };
        (1.0 + self.0.iter().enumerate().map(term).sum::<f64>()) / TAU
    }

    /// Returns the probability of an interval, by integrating the series.
    fn probability(&self, from: f64, to: f64) -> f64 {
        let term = |(k, (re, im)): (usize, &(f64, f64))| {
            let k = (k + 1) as f64;
            let ((s0, c0), (s1, c1)) = ((k * from).sin_cos(), (k * to).sin_cos());
            2.0 * (re * (s1 - s0) - im * (c1 - c0)) / k
        };
        (to - from + self.0.iter().enumerate().map(term).sum::<f64>()) / TAU
    }
}

pub(crate) fn report(options: &Options) -> Result<Report, Box<dyn Error>> {
    let integrator = Integrator::new(KUBO, Midpoint);
    // From (1, 0), q = cos θ and p = −sin θ.
    let phase = |state: &State<[f64; 1]>| (-state.p[0]).atan2(state.q[0]);
    let summary = Ensemble::new(&integrator)
        .paths(options.paths)
        .seed(options.seed)
        .steps(H, STEPS)
        .start(State::new([1.0], [0.0]))
        .observe("phase", move |_, state| phase(state))
        .observe("cos", |_, state| state.q[0])
        .observe("sin", |_, state| -state.p[0])
        .observe("radius", |_, state| state.q[0].hypot(state.p[0]))
        .histogram("phase", -PI..PI, Bins::at_end(BINS))
        .stop_on_failure(true)
        .run()?;
    let histogram = summary.histogram("phase").ok_or("no histogram")?;
    let counts = histogram.counts();
    let (exact, expanded, rule) = (
        Distribution::exact(),
        Distribution::expanded(),
        Distribution::midpoint(),
    );
    let last = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
    let mut checks = vec![
        fit(
            "the wrapped normal",
            counts,
            &exact,
            &expanded,
            options.paths,
        ),
        fit(
            "the midpoint rule's distribution",
            counts,
            &rule,
            &rule,
            options.paths,
        ),
    ];
    for (name, expected, expanded, of_rule) in [
        ("cos", exact.0[0].0, expanded.0[0].0, rule.0[0].0),
        ("sin", exact.0[0].1, expanded.0[0].1, rule.0[0].1),
    ] {
        let (value, error) = (
            last(summary[name].mean()),
            last(&summary[name].standard_error()),
        );
        checks.push(mean(
            format!("mean of {name} θ, midpoint rule"),
            value,
            of_rule,
            error,
            options.paths,
            "the rule's own distribution",
        ));
        checks.push(known_difference(
            format!("mean of {name} θ, exact solution"),
            value,
            expected,
            error,
            (
                (expanded - expected).abs(),
                "the rule's error to first order",
            ),
        ));
    }
    let radius = &summary["radius"];
    let off = (last(radius.max()) - 1.0).max(1.0 - last(radius.min()));
    checks.push(Check::new("largest |radius − 1| of all paths", off).near(
        0.0,
        4.0 * f64::EPSILON * STEPS as f64,
        "conserved exactly: four roundings a step",
    ));
    Ok(Report {
        title: "Phase of the Kubo oscillator",
        figure: draw(counts, options.paths, &exact, &rule),
        caption: format!(
            "a = σ = 1, start (1, 0), h = {H}, t = {:.0}, {} paths. The phase of the exact solution is a wrapped normal of mean a·t and \
             variance σ²t. The midpoint rule turns by 2 atan(x/2) where the solution turns by x, so its distribution differs by O(h), \
             less than can be seen here; right, what is left when the wrapped normal is taken away.",
            TIME, options.paths
        ),
        checks,
    })
}

fn edge(bin: usize) -> f64 {
    -PI + bin as f64 * WIDTH
}

/// Compares the histogram with a distribution by Pearson's χ², as a z-score. If the paths have the
/// distribution of the rule instead, χ² is larger on average by the difference of the two
/// distributions.
fn fit(
    name: &str,
    counts: &[u64],
    expected: &Distribution,
    rule: &Distribution,
    paths: u64,
) -> Check {
    let count = |distribution: &Distribution, bin: usize| {
        paths as f64 * distribution.probability(edge(bin), edge(bin + 1))
    };
    let distance = |measured: &dyn Fn(usize) -> f64| -> f64 {
        (0..BINS)
            .map(|bin| (measured(bin) - count(expected, bin)).powi(2) / count(expected, bin))
            .sum()
    };
    let chi2 = distance(&|bin| counts[bin] as f64);
    let (freedom, expected_difference) = ((BINS - 1) as f64, distance(&|bin| count(rule, bin)));
    let deviation = (2.0 * freedom + 4.0 * expected_difference).sqrt();
    let z = (chi2 - freedom - expected_difference) / deviation;
    Check::new(
        format!("χ² of the histogram against {name} (z = {})", number(z, 2)),
        chi2,
    )
    .near(
        freedom + expected_difference,
        // The tail of χ² is longer than a normal's: it exceeds 5.1 deviations with probability
        // 1e-5.
        5.1 * deviation,
        "degrees of freedom, and the error of the rule's distribution; false alarm about 10⁻⁵",
    )
}

fn draw(counts: &[u64], paths: u64, exact: &Distribution, rule: &Distribution) -> Figure {
    let heights = counts
        .iter()
        .map(|&count| count as f64 / (paths as f64 * WIDTH));
    let bars = heights
        .clone()
        .enumerate()
        .flat_map(|(bin, height)| [(edge(bin), height), (edge(bin + 1), height)]);
    let fine = |f: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..=600)
            .map(|k| -PI + TAU * f64::from(k) / 600.0)
            .map(|theta| (theta, f(theta)))
            .collect()
    };
    let histogram = Panel::new(
        "Kubo oscillator: phase",
        Axis::angle("phase θ", -PI..PI),
        Axis::new("probability density", 0.0..0.4),
    )
    .legend(Corner::TopLeft)
    .with(
        Layer::new(
            "midpoint rule, histogram",
            bars.collect(),
            Pen::line(hues::MIDPOINT, 1.5),
        )
        .filled(0.0),
    )
    .with(Layer::new(
        "exact: wrapped normal",
        fine(&|theta| exact.density(theta)),
        Pen::line(hues::EXACT, 1.2),
    ));
    let error = |bin: usize| {
        let p = exact.probability(edge(bin), edge(bin + 1));
        (p * (1.0 - p) / paths as f64).sqrt() / WIDTH
    };
    let middle = |bin: usize| edge(bin) + 0.5 * WIDTH;
    let less = |bin: usize| exact.probability(edge(bin), edge(bin + 1)) / WIDTH;
    let dots = heights
        .enumerate()
        .map(|(bin, height)| (middle(bin), height - less(bin)));
    let band = |sign: f64| (0..BINS).map(move |bin| (middle(bin), sign * error(bin)));
    let dashed = Pen::dashed(palette::BLACK, 1.0, (3.0, 3.0));
    let difference = Panel::new(
        "Kubo oscillator: density less the wrapped normal",
        Axis::angle("phase θ", -PI..PI),
        Axis::new("difference", -0.012..0.012),
    )
    .legend(Corner::TopLeft)
    .with(Layer::new(
        "± one standard error",
        band(1.0).collect(),
        dashed,
    ))
    .with(Layer::new("", band(-1.0).collect(), dashed).unlisted())
    .with(Layer::new(
        "midpoint rule, its distribution",
        fine(&|theta| rule.density(theta) - exact.density(theta)),
        Pen::line(hues::MIDPOINT, 1.2),
    ))
    .with(Layer::new(
        "midpoint rule, histogram",
        dots.collect(),
        Pen::dots(hues::MIDPOINT, 2.0),
    ));
    one_row("phase", [1110, 400], vec![histogram, difference])
}
