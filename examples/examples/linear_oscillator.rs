//! The stochastic linear oscillator: its mean energy grows as H₀ + σ²t/2, and a symplectic rule
//! follows it.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::hues;
use sve_examples::report::{one_row, report};

use sve_runtime::baseline::{BackwardEulerMaruyama, EulerMaruyama};
use sve_runtime::prelude::*;

/// dq = p dt, dp = −q dt + σ dW.
#[derive(Clone, Copy, Debug)]
struct Oscillator {
    sigma: f64,
}

#[variational(endpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

const H: f64 = 0.1;
const PATHS: u64 = 2000;

/// Returns the mean energy over the paths after each number of steps in `stops`, with its standard
/// error.
fn mean_energies<I>(method: &I, stops: &[usize]) -> Result<Vec<(f64, f64)>, StepError>
where
    I: Method<System = Oscillator>,
{
    let mut sums = vec![(0.0, 0.0); stops.len()];
    for path in 0..PATHS {
        let noise = Wiener::new(42).path(path);
        let mut trajectory = method.trajectory(State::new([1.0], [0.0]), H, noise);
        let mut done = 0;
        for ((sum, squares), &stop) in sums.iter_mut().zip(stops) {
            for state in trajectory.by_ref().take(stop - done) {
                state?;
            }
            done = stop;
            let energy = method.system().hamiltonian(trajectory.state())?;
            *sum += energy;
            *squares += energy * energy;
        }
    }
    let n = PATHS as f64;
    let estimate = |(sum, squares): (f64, f64)| {
        let mean = sum / n;
        (mean, ((squares / n - mean * mean) / (n - 1.0)).sqrt())
    };
    Ok(sums.into_iter().map(estimate).collect())
}

fn figure(times: &[f64], methods: [(&str, &[(f64, f64)]); 3]) -> Figure {
    let exact = (0..=1040).map(|k| 0.1 * f64::from(k));
    let exact = exact.map(|t| (t, (0.5 + 0.5 * t).log10()));
    let panel = Panel::new(
        format!("Stochastic linear oscillator: mean energy of {PATHS} paths, h = {H}"),
        Axis::new("time t", 0.0..104.0),
        Axis::powers("mean energy", -1.0..6.0),
    )
    .with(Layer::new(
        "exact: H₀ + σ²t/2",
        exact.collect(),
        Pen::line(hues::EXACT, 1.0),
    ))
    .legend(Corner::TopLeft);
    let panel = methods
        .iter()
        .enumerate()
        .fold(panel, |panel, (k, (name, means))| {
            let points = times.iter().zip(*means);
            let points = points.map(|(&t, &(mean, _))| (t, mean.log10()));
            let bars = means
                .iter()
                .map(|(mean, error)| ((mean - 2.0 * error).log10(), (mean + 2.0 * error).log10()));
            let color = [hues::ENDPOINT, hues::EULER_MARUYAMA, hues::EULER_MARUYAMA][k];
            let pen = Pen {
                color,
                line: None,
                ..Pen::series(k)
            };
            panel.with(Layer::new(*name, points.collect(), pen).bars(bars.collect()))
        });
    one_row("linear_oscillator", [760, 420], vec![panel])
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let oscillator = Oscillator { sigma: 1.0 };
    let endpoint = Integrator::new(oscillator, Endpoint);
    println!("{}\n", endpoint.plan());

    let stops = [100, 200, 500, 1000];
    let by_endpoint = mean_energies(&endpoint, &stops)?;
    let forward = mean_energies(&EulerMaruyama::new(oscillator), &stops)?;
    let backward = mean_energies(&BackwardEulerMaruyama::new(oscillator), &stops)?;
    println!(
        "mean energy over {PATHS} paths, h = {H}; one standard error is about {:.1} %",
        100.0 / (PATHS as f64).sqrt()
    );
    println!(
        "{:>6} {:>13} {:>13} {:>13} {:>13}",
        "t", "H₀ + σ²t/2", "endpoint", "forward EM", "backward EM"
    );
    for (k, stop) in stops.iter().enumerate() {
        let t = *stop as f64 * H;
        let exact = 0.5 + 0.5 * oscillator.sigma.powi(2) * t;
        println!(
            "{t:>6} {exact:>13.3} {:>13.3} {:>13.3} {:>13.3}",
            by_endpoint[k].0, forward[k].0, backward[k].0
        );
    }
    let check = |(&stop, &(mean, error)): (&usize, &(f64, f64))| {
        let t = stop as f64 * H;
        // The mean energy of the endpoint rule differs from the exact one by less than 3 %.
        let why = "4.5 standard errors, and 3 % for the step size";
        let exact = 0.5 + 0.5 * t;
        Check::new(format!("endpoint rule, t = {t}: mean energy"), mean).near(
            exact,
            4.5 * error + 0.03 * exact,
            why,
        )
    };
    let checks: Vec<Check> = stops.iter().zip(&by_endpoint).map(check).collect();
    let times = stops.map(|stop| stop as f64 * H);
    let methods = [
        ("endpoint rule", &by_endpoint[..]),
        ("forward Euler–Maruyama", &forward),
        ("backward Euler–Maruyama", &backward),
    ];
    let caption = "σ = 1, seed 42. Bars, shorter than the symbols: two standard errors on either side. The mean energy of forward Euler–Maruyama grows like exp(ht); that of the backward method stays at a level.";
    report(
        "Stochastic linear oscillator",
        &figure(&times, methods),
        caption,
        &checks,
    )
}
