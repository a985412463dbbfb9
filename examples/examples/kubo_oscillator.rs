//! The Kubo oscillator, a rotation whose speed is noisy: the midpoint rule keeps its radius, Euler–Maruyama does not.

use std::error::Error;

use sve_runtime::baseline::EulerMaruyama;
use sve_runtime::prelude::*;

/// dq = p (a dt + σ ∘ dW), dp = −q (a dt + σ ∘ dW).
#[derive(Clone, Copy, Debug)]
struct Kubo {
    a: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - self.a / 2.0 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.sigma / 2.0 * (q * q + p * p)
    }
}

const H: f64 = 0.01;

/// Radius at the end of `steps` steps.
fn radius<I: Method<System = Kubo>>(method: &I, steps: usize) -> Result<f64, StepError> {
    let mut trajectory = method.trajectory(State::new([1.0], [0.0]), H, Wiener::new(42));
    for state in trajectory.by_ref().take(steps) {
        state?;
    }
    let state = trajectory.state();
    Ok(state.q[0].hypot(state.p[0]))
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let midpoint = Integrator::new(system, Midpoint);
    let euler = EulerMaruyama::new(system);
    println!("{}\n", midpoint.plan());

    println!("radius after t on one path, h = {H}; it is 1");
    println!(
        "{:>6} {:>20} {:>16} {:>16}",
        "t", "midpoint − 1", "EM, uncorrected", "EM, corrected"
    );
    for t in [1, 10, 100, 1000] {
        let steps = 100 * t;
        println!(
            "{t:>6} {:>20.1e} {:>16.6e} {:>16.6e}",
            radius(&midpoint, steps)? - 1.0,
            radius(&euler.uncorrected(), steps)?,
            radius(&euler, steps)?
        );
    }
    Ok(())
}
