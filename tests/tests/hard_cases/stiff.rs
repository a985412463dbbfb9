//! Oscillators whose period is far below the step.

use sve_models::models::Quartic;
use sve_models::stepper::{Stepper, one_node};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::systems::Stiff;

/// Returns the largest energy in units of the initial energy, for steps of 1; `None` if a step
/// fails or the energy passes a million.
fn largest_energy<S: System<Dims = Dims<1, 0>>>(
    system: &S,
    rule: &dyn Stepper<[f64; 1], [f64; 0]>,
    steps: usize,
) -> Option<f64> {
    let mut state = State::new([1.0], [0.0]);
    let energy = |state: &State<[f64; 1]>| system.hamiltonian(state).unwrap();
    let (first, mut largest) = (energy(&state), 1.0_f64);
    for _ in 0..steps {
        rule.step(&mut state, 1.0, &[]).ok()?;
        largest = largest.max(energy(&state) / first);
        if largest > 1e6 {
            return None;
        }
    }
    Some(largest)
}

/// The largest energies by initial point, midpoint and endpoint. The step is 1, so that ω is ωh.
fn linear(omega: f64, steps: usize) -> [Option<f64>; 3] {
    let system = Stiff { omega };
    let rules = one_node(&system);
    [0, 1, 2].map(|rule| largest_energy(&system, &*rules[rule], steps))
}

/// ω² = 3k is the largest curvature of the potential on the way.
fn quartic(omega: f64, steps: usize) -> [Option<f64>; 3] {
    let system = Quartic {
        m: 1.0,
        k: omega.powi(2) / 3.0,
    };
    let rules = one_node(&system);
    [0, 1, 2].map(|rule| largest_energy(&system, &*rules[rule], steps))
}

const OMEGA_H: [f64; 9] = [0.1, 0.3, 1.0, 1.9, 2.1, 5.0, 10.0, 100.0, 1000.0];

/// Returns the first ωh above 1, in steps of a thousandth, at which the energy passes a million or
/// a step fails.
fn stops_at(run: impl Fn(f64) -> Option<f64>) -> f64 {
    let mut scan = (1000..).map(|k| f64::from(k) / 1000.0);
    scan.find(|&omega| run(omega).is_none()).unwrap()
}

/// The midpoint rule conserves quadratic energies, whatever the step: what is left is the random
/// walk of rounding errors, which a step amplifies by up to ωh (the momentum is ωh times what the
/// position is).
#[test]
fn linear_midpoint_conserves_energy() {
    for omega in OMEGA_H {
        let largest = linear(omega, 5000)[1].unwrap();
        let walk = 16.0 * f64::EPSILON * (1.0 + omega) * 5000.0_f64.sqrt();
        assert!(largest <= 1.0 + walk, "ωh = {omega}: {largest}");
    }
}

/// The other two are stable for ωh < 2, where their modified energy p² + ω²q² ± hω²qp is definite:
/// it bounds the energy by (1 + ωh/2)/(1 − ωh/2) of the first. Above, they are hyperbolic maps.
#[test]
fn linear_endpoint_and_initial_point_stop_at_two() {
    for omega in OMEGA_H {
        let [initial_point, _, endpoint] = linear(omega, 5000);
        for largest in [initial_point, endpoint] {
            let bound = (1.0 + 0.5 * omega) / (1.0 - 0.5 * omega);
            match largest {
                Some(largest) => assert!(omega < 2.0 && largest <= 1.000_001 * bound),
                None => assert!(omega > 2.0, "ωh = {omega}"),
            }
        }
    }
    for rule in [0, 2] {
        let stop = stops_at(|omega| linear(omega, 5000)[rule]);
        assert!((stop - 2.0).abs() < 0.002, "{stop}");
    }
}

/// The midpoint rule does not conserve the energy of a quartic oscillator, and no theorem bounds it
/// for large steps; it stays within a factor of nine of the first for all ωh. The others blow up in
/// an island of instability at ωh = 1.3354 to 1.3444, found with the maps written by hand.
#[test]
fn quartic_midpoint_stays_bounded() {
    for omega in OMEGA_H {
        let largest = quartic(omega, 20_000)[1].unwrap();
        assert!(largest < 20.0, "ωh = {omega}: {largest}");
    }
    for rule in [0, 2] {
        let stop = stops_at(|omega| quartic(omega, 5000)[rule]);
        assert!((1.335..1.345).contains(&stop), "{stop}");
    }
}
