//! The energy of a chain of any length over long runs: it oscillates, and does not drift.

use sve_models::is_thorough;
use sve_runtime::Blocking;
use sve_runtime::prelude::*;

/// A ring of masses 1, with springs of the force d + β d³ and in wells.
struct Ring {
    beta: f64,
}

#[variational(stormer_verlet)]
impl Ring {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = 0.0;
        for i in 0..n {
            let d = q[(i + 1) % n] - q[i];
            l += 0.5 * v[i] * v[i] - 0.5 * q[i] * q[i];
            l -= 0.5 * d * d + 0.25 * self.beta * d.powi(4);
        }
        l
    }
}

const SITES: usize = 100;
const H: f64 = 0.07;

/// Samples.
const SAMPLES: usize = 10_000;

/// Steps from one sample to the next: 10⁶ steps in all, or 10⁷.
fn apart() -> u64 {
    if is_thorough() { 1000 } else { 100 }
}

/// Returns numbers between −½ and ½ without order.
fn spread(seed: u64) -> Vec<f64> {
    let number = |i: u64| {
        let bits = (i + 1000 * seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (bits ^ (bits >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11
    };
    (0..SITES as u64)
        .map(|i| number(i) as f64 / (1u64 << 53) as f64 - 0.5)
        .collect()
}

/// The error of the energy is h² times a function of the state. In a chaotic chain its means over
/// parts of the run are those of equilibrium, and differ by their standard errors alone.
#[test]
fn the_energy_of_a_chain_of_100_does_not_drift() {
    let ring = Integrator::new(Ring { beta: 0.7 }, StormerVerlet);
    let start = State::new(spread(1), spread(2));
    let first = ring.system().hamiltonian(&start).unwrap();
    let mut path = ring.trajectory(start, H, NoNoise);
    path.advance(10_000).unwrap();
    let (mut worst, mut halves) = (0.0f64, [Blocking::new(), Blocking::new()]);
    let apart = apart();
    for sample in 0..SAMPLES {
        let energy = ring.system().hamiltonian(path.advance(apart).unwrap());
        let error = energy.unwrap() / first - 1.0;
        worst = worst.max(error.abs());
        halves[2 * sample / SAMPLES].push(error);
    }
    let error = |half: &Blocking| half.standard_error().expect("a path that is long enough");
    let spread = error(&halves[0]).hypot(error(&halves[1]));
    let drift = halves[1].mean() - halves[0].mean();
    println!("{apart} steps apart: drift {drift:e} ± {spread:e}, largest error {worst:e}");
    assert!(worst < H * H, "{worst:e}");
    // means over halves are sharper than the oscillation by far
    assert!(spread < 3e-3 * H * H, "{spread:e}");
    assert!(drift.abs() < 4.0 * spread, "{drift:e} {spread:e}");
}
