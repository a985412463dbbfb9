//! The Kubo oscillator by the midpoint rule: the exact mean-square error, and the invariant.

use sve_models::models::Kubo;
use sve_runtime::prelude::*;

/// The step as a multiplier of `q + ip`, which it is where the step is linear and commutes with
/// rotations.
fn multiplier(kubo: &Integrator<Kubo, Midpoint>, h: f64, dw: f64) -> [f64; 2] {
    let image = |q: f64, p: f64| {
        let mut state = State::new([q], [p]);
        kubo.step(&mut state, h, &[dw]).unwrap();
        [state.q[0], state.p[0]]
    };
    let (one, i) = (image(1.0, 0.0), image(0.0, 1.0));
    // the image of i is i times the image of 1
    assert!((i[0] + one[1]).abs() <= 4.0 * f64::EPSILON);
    assert!((i[1] - one[0]).abs() <= 4.0 * f64::EPSILON);
    one
}

/// `E f(z)` for a standard normal z by the trapezoidal rule, which converges exponentially for a
/// function that is analytic in a strip: here its poles are at x = ±2i, far outside, and what is
/// cut off at ±9 is below 1e-18.
fn expectation(f: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
    let (mut sum, mut weights) = ([0.0; 2], 0.0);
    for k in -900..=900 {
        let z = 0.01 * f64::from(k);
        let weight = (-0.5 * z * z).exp();
        let value = f(z);
        weights += weight;
        sum[0] += weight * value[0];
        sum[1] += weight * value[1];
    }
    sum.map(|s| s / weights)
}

/// RMS error at T = 1 for a = 1, σ = ½ from (1, ½): the table of the mathematics page, given to six
/// or seven digits.
#[test]
fn mean_square_error() {
    let table: [(i32, f64); 5] = [
        (8, 1.292_700e-2),
        (16, 5.860_673e-3),
        (32, 2.768_785e-3),
        (64, 1.342_502e-3),
        (128, 6.605_79e-4),
    ];
    let (a, sigma) = (1.0, 0.5);
    let kubo = Integrator::new(Kubo { a, sigma }, Midpoint);
    for (steps, expected) in table {
        let h = 1.0 / f64::from(steps);
        // numerical over exact rotation: e^{i(x − 2 atan(x/2))}, whose real part after N steps is
        // what counts
        let [re, im] = expectation(|z| {
            let dw = h.sqrt() * z;
            let [c, s] = multiplier(&kubo, h, dw);
            let x = a * h + sigma * dw;
            [c * x.cos() - s * x.sin(), c * x.sin() + s * x.cos()]
        });
        let power = re.hypot(im).powi(steps) * (f64::from(steps) * im.atan2(re)).cos();
        let error = (2.0 * 1.25 * (1.0 - power)).sqrt();
        println!("N = {steps}: {error:e}");
        // 1 − power cancels ten digits of sixteen at most: 1e-5 is far above rounding and the
        // table's last digit
        assert!(
            (error / expected - 1.0).abs() < 1e-5,
            "N = {steps}: {error:e}"
        );
    }
}

/// Each step multiplies q² + p² by 1 + δ with |δ| a few ε from its roundings, which are as good as
/// independent since the noise moves the angle: after n steps the deviation is a random walk of
/// 2ε√n, taken five times for safety.
#[test]
fn radius_is_conserved() {
    let kubo = Integrator::new(Kubo { a: 1.0, sigma: 1.0 }, Midpoint);
    let start = State::new([1.0], [0.0]);
    let mut worst: f64 = 0.0;
    for (n, state) in (1..=20_000).zip(kubo.trajectory(start, 0.1, Wiener::new(42))) {
        let state = state.unwrap();
        let radius = state.q[0] * state.q[0] + state.p[0] * state.p[0];
        let bound = 10.0 * f64::EPSILON * f64::from(n).sqrt();
        worst = worst.max((radius - 1.0).abs() / bound);
        assert!((radius - 1.0).abs() <= bound, "step {n}: {radius}");
    }
    println!("largest deviation {worst} of the bound");
}
