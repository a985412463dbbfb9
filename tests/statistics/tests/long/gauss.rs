//! Energies of long trajectories by the Gauss rules: their errors are those of rounding, and grow like the square root of the time (Brouwer's law).

use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

struct Pendulum {
    g: f64,
}

#[variational(gauss(3), gauss(4), gauss(8))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

const STEPS: usize = 1_000_000;

/// Root mean square of the energy errors after so many steps, in random walks of rounding, ε|H|√n/2, over several starts. A walk gives about 1, and a drift of a
/// hundredth of a unit of rounding in a step would give 20 at the end.
fn walks<R>(rule: R, h: f64) -> [f64; 2]
where
    R: Copy,
    Pendulum: Variational<R> + System<Dims = Dims<1, 0>>,
{
    let system = Pendulum { g: 9.8 };
    let integrator = Integrator::new(&system, rule);
    let mut squares = [0.0; 2];
    let starts = [0.7, 1.0, 1.3, 1.6, 1.9];
    for start in starts {
        let start = State::new([start], [0.0]);
        let energy = system.hamiltonian(&start).unwrap();
        let path = integrator.trajectory(start, h, NoNoise);
        for (k, state) in path.take(STEPS).enumerate() {
            let state = state.unwrap();
            let part = [STEPS / 100, STEPS].iter().position(|&n| n == k + 1);
            if let Some(part) = part {
                let error = system.hamiltonian(&state).unwrap() - energy;
                let walk = 0.5 * f64::EPSILON * system.g * ((k + 1) as f64).sqrt();
                squares[part] += (error / walk).powi(2) / starts.len() as f64;
            }
        }
    }
    squares.map(f64::sqrt)
}

#[test]
fn energies_walk_like_the_root_of_the_time() {
    // steps whose own error of the energy is below rounding
    for [early, late] in [
        walks(Gauss::<8>, 0.05),
        walks(Gauss::<4>, 0.01),
        walks(Gauss::<3>, 0.003),
    ] {
        println!("{early} after a hundredth of the steps, {late} at the end");
        assert!(early < 2.0, "{early}");
        assert!(late < 2.5, "{late}");
    }
}
