//! The forces of constraints against the tension of a pendulum, and their part that noise makes.

use sve_models::checks::assert_close;
use sve_models::stepper::Stepper;
use sve_runtime::prelude::*;

use super::systems::{two_rods, two_rods_at};

#[test]
fn the_tension_converges_to_that_of_the_motion() {
    // at the lowest point of a swing: m g + m v²/l of both masses in a line
    let mut quiet = two_rods();
    quiet.s = 0.0;
    let integrator = Integrator::new(&quiet, Midpoint);
    let still = State::new([0.0, -1.0, 0.0, -1.7], [0.0; 4]);
    let forces = integrator
        .constraint_forces(&still, 0.01, &[0.0, 0.0])
        .unwrap();
    let [upper, lower] = ["rods[0]", "rods[1]"].map(|name| forces.get(name).unwrap());
    // the upper rod bears both weights, the lower rod one of them
    let found = [upper.mean[1], lower.mean[3], lower.mean[1]];
    let expected = [1.5 * 9.8, 0.5 * 9.8, -0.5 * 9.8];
    assert_close(&found, &expected, 1e-12, "tensions");
    for i in 0..4 {
        let sum = (forces.at_start[i] + forces.at_end[i]) / 0.01;
        assert!((forces.mean[i] - sum).abs() < 1e-12);
        assert!((forces.mean[i] - upper.mean[i] - lower.mean[i]).abs() < 1e-12);
    }
}

/// The mean force is what the momentum gains beside gravity and noise.
#[test]
fn the_impulses_are_the_change_of_momentum() {
    let system = two_rods();
    let integrator = Integrator::new(&system, StormerVerlet);
    let start = two_rods_at(0.5);
    let (h, dw) = (0.02, [0.1, -0.2]);
    let forces = integrator.constraint_forces(&start, h, &dw).unwrap();
    let end = integrator.after(start, h, &dw, 1);
    let others = [0.0, -h * 9.8 + 0.3 * dw[1], 0.3 * dw[0], -h * 0.5 * 9.8];
    let gained: [f64; 4] = core::array::from_fn(|i| end.p[i] - start.p[i] - others[i]);
    assert_close(&gained, &forces.mean.map(|f| h * f), 1e-14, "impulses");
}

/// The mean force has a part of the size of h^(−1/2) with noise.
#[test]
fn noise_makes_forces_that_grow_with_smaller_steps() {
    let system = two_rods();
    let integrator = Integrator::new(&system, Midpoint);
    let start = State::new([0.0, -1.0, 0.0, -1.7], [0.0; 4]);
    let spread = |h: f64| {
        let dw = [0.0, h.sqrt()];
        let forces = integrator.constraint_forces(&start, h, &dw).unwrap();
        (forces.get("rods[0]").unwrap().mean[1] - 1.5 * 9.8).abs()
    };
    let ratio = spread(1e-4) / spread(1e-2);
    assert!((ratio - 10.0).abs() < 0.1, "{ratio}");
}
