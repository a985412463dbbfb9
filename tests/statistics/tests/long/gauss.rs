//! Energies of long trajectories by the Gauss rules: their errors are those of rounding, and grow
//! like the square root of the time (Brouwer's law).
//!
//! Errors are measured in random walks of rounding, ε|H|√n/2 after n steps of a system whose energy
//! has the magnitude |H|. A drift of a hundredth of a unit of rounding in a step is 20 of them
//! after a million steps, and 60 after ten million.

use sve_models::is_thorough;
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

struct Pendulum {
    g: f64,
}

#[variational(gauss(3), gauss(4), gauss(8))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// Steps, and starts.
fn length() -> (usize, usize) {
    if is_thorough() {
        (10_000_000, 12)
    } else {
        (1_000_000, 6)
    }
}

/// Errors of the energy over some trajectories, in random walks of rounding.
#[derive(Debug)]
pub(crate) struct Errors {
    /// Root mean square at the end.
    end: f64,
    /// Mean of the drifts, and its standard error. The drift of a trajectory is the slope of the
    /// least-squares line times the number of steps.
    drift: [f64; 2],
}

/// Follows trajectories of so many steps of size `h`, for a system whose energy is of the magnitude
/// `size`.
pub(crate) fn errors<S, R, Q, const N: usize>(
    method: &Integrator<S, R>,
    starts: &[State<Q>],
    (h, steps): (f64, usize),
    (energy, size): (impl Fn(&State<Q>) -> f64, f64),
) -> Errors
where
    S: Variational<R> + System<Dims = Dims<N, 0, Q>>,
    Q: VectorCoordinates<N>,
{
    const SAMPLES: usize = 1000;
    let walk = 0.5 * f64::EPSILON * size * (steps as f64).sqrt();
    let (mut squares, mut drifts) = (0.0, Vec::new());
    for start in starts {
        let before = energy(start);
        let mut path = method.trajectory(*start, h, NoNoise);
        let (mut error, mut slope, mut norm) = (0.0, 0.0, 0.0);
        for sample in 1..=SAMPLES {
            let state = path.nth(steps / SAMPLES - 1).unwrap().unwrap();
            error = (energy(&state) - before) / walk;
            let time = sample as f64 / SAMPLES as f64 - 0.5;
            slope += time * error;
            norm += time * time;
        }
        squares += error * error;
        drifts.push(slope / norm);
    }
    let count = starts.len() as f64;
    let mean = drifts.iter().sum::<f64>() / count;
    let variance = drifts.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    Errors {
        end: (squares / count).sqrt(),
        drift: [mean, (variance / count).sqrt()],
    }
}

/// Checks that the errors are those of a walk, and that there is no drift beyond it.
#[track_caller]
pub(crate) fn walks(name: &str, errors: &Errors) {
    println!("{name}: {errors:?}");
    assert!(errors.end < 2.0, "{name}: {errors:?}");
    let [drift, error] = errors.drift;
    assert!(drift.abs() < 3.0 * error.max(0.3), "{name}: {errors:?}");
}

/// Checks a rule on a pendulum, for several amplitudes.
fn pendulum_walks<R>(rule: R, h: f64)
where
    R: Copy,
    Pendulum: Variational<R>,
{
    let (steps, count) = length();
    let start = |k| State::new([0.7 + 1.2 * (k as f64 + 0.5) / count as f64], [0.0]);
    let starts: Vec<_> = (0..count).map(start).collect();
    let system = Pendulum { g: 9.8 };
    let method = Integrator::new(&system, rule);
    let energy = |state: &State<_>| system.hamiltonian(state).unwrap();
    let name = format!("{}, h = {h}", method.plan().rule);
    walks(
        &name,
        &errors(&method, &starts, (h, steps), (energy, system.g)),
    );
}

// steps whose own error of the energy is below rounding; some near simple fractions

#[test]
fn energies_of_a_pendulum_walk_with_eight_stages() {
    pendulum_walks(Gauss::<8>, 0.05);
    pendulum_walks(Gauss::<8>, 0.1);
    pendulum_walks(Gauss::<8>, 0.2);
}

#[test]
fn energies_of_a_pendulum_walk_with_fewer_stages() {
    pendulum_walks(Gauss::<4>, 0.01);
    pendulum_walks(Gauss::<3>, 0.003);
}
