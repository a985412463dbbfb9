//! The stochastic linear oscillator: its mean energy grows as H₀ + σ²t/2, and a symplectic rule follows it.

use std::error::Error;

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

/// Mean energy over the paths after each number of steps in `stops`.
fn mean_energies<I>(method: &I, stops: &[usize]) -> Result<Vec<f64>, StepError>
where
    I: Method<System = Oscillator>,
{
    let mut sums = vec![0.0; stops.len()];
    for path in 0..PATHS {
        let noise = Wiener::new(42).path(path);
        let mut trajectory = method.trajectory(State::new([1.0], [0.0]), H, noise);
        let mut done = 0;
        for (sum, &stop) in sums.iter_mut().zip(stops) {
            for state in trajectory.by_ref().take(stop - done) {
                state?;
            }
            done = stop;
            *sum += method.system().hamiltonian(trajectory.state())?;
        }
    }
    Ok(sums.into_iter().map(|sum| sum / PATHS as f64).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
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
            by_endpoint[k], forward[k], backward[k]
        );
    }
    Ok(())
}
