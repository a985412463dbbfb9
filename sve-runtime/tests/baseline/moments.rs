//! The mean energy of the linear oscillator, exactly: no sampling error.
//!
//! A scheme `z₁ = A z₀ + b ΔW` carries second moments by `M₁ = A M₀ Aᵀ + h b bᵀ`; A and b are read
//! off the step itself.

use sve_runtime::baseline::{BackwardEulerMaruyama, EulerMaruyama, Heun};
use sve_runtime::{Method, State};

use crate::models::Oscillator;

const H: f64 = 0.1;

type Matrix = [[f64; 2]; 2];

fn image<I>(method: &I, z: [f64; 2], dw: f64) -> [f64; 2]
where
    I: Method<System = Oscillator>,
{
    let mut state = State::new([z[0]], [z[1]]);
    method.step(&mut state, H, &[dw]).unwrap();
    [state.q[0], state.p[0]]
}

/// `E[H]` after 100, 1000 and 20000 steps from (1, 0).
fn mean_energies<I>(method: &I) -> [f64; 3]
where
    I: Method<System = Oscillator>,
{
    let columns = [
        image(method, [1.0, 0.0], 0.0),
        image(method, [0.0, 1.0], 0.0),
    ];
    let a: Matrix = [
        [columns[0][0], columns[1][0]],
        [columns[0][1], columns[1][1]],
    ];
    let b = image(method, [0.0, 0.0], 1.0);
    // the step is linear, so that A and b tell all of it
    let z = image(method, [0.3, -0.7], 0.4);
    for i in 0..2 {
        assert!((z[i] - (a[i][0] * 0.3 - a[i][1] * 0.7 + b[i] * 0.4)).abs() < 1e-15);
    }
    let mut m: Matrix = [[1.0, 0.0], [0.0, 0.0]];
    let mut energies = [0.0; 3];
    for step in 1..=20_000 {
        let mut next = [[0.0; 2]; 2];
        for i in 0..2 {
            for j in 0..2 {
                next[i][j] = H * b[i] * b[j];
                for k in 0..2 {
                    for l in 0..2 {
                        next[i][j] += a[i][k] * m[k][l] * a[j][l];
                    }
                }
            }
        }
        m = next;
        if let Some(at) = [100, 1000, 20_000].iter().position(|&s| s == step) {
            energies[at] = 0.5 * (m[0][0] + m[1][1]);
        }
    }
    energies
}

#[track_caller]
fn assert_relative(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value / expected - 1.0).abs() <= tolerance,
        "{value} is not {expected}"
    );
}

#[test]
fn forward_euler_maruyama_gains_energy_exponentially() {
    let [short, middle, long] = mean_energies(&EulerMaruyama::new(Oscillator { sigma: 1.0 }));
    assert_relative(short, 9.876_476_061_818_382, 1e-12);
    assert_relative(middle, 115_270.356_007_975_24, 1e-12);
    assert_relative(long, 1.471_76e87, 0.5e-5 / 1.471_76);
}

#[test]
fn backward_euler_maruyama_settles_where_the_exact_energy_grows() {
    let [short, middle, long] =
        mean_energies(&BackwardEulerMaruyama::new(Oscillator { sigma: 1.0 }));
    assert_relative(short, 3.336_299_544_518_964, 1e-12);
    assert_relative(middle, 4.999_785_296_694_256, 1e-12);
    assert_relative(long, 5.0, 1e-12);
}

#[test]
fn additive_noise_needs_no_correction() {
    let oscillator = Oscillator { sigma: 0.7 };
    let mut corrected = State::new([0.3], [0.4]);
    let mut plain = corrected;
    EulerMaruyama::new(oscillator)
        .step(&mut corrected, H, &[0.2])
        .unwrap();
    EulerMaruyama::new(oscillator)
        .uncorrected()
        .step(&mut plain, H, &[0.2])
        .unwrap();
    assert_eq!(corrected, plain);
    BackwardEulerMaruyama::new(oscillator)
        .step(&mut corrected, H, &[0.2])
        .unwrap();
    BackwardEulerMaruyama::new(oscillator)
        .uncorrected()
        .step(&mut plain, H, &[0.2])
        .unwrap();
    assert_eq!(corrected, plain);
}

#[test]
fn heun_gains_energy_at_the_fourth_power_of_the_step() {
    // |λ|² = (1 − h²/2)² + h² = 1 + h⁴/4 for the deterministic part; with noise the forcing adds
    // its share each step.
    let [_, _, long] = mean_energies(&Heun::new(Oscillator { sigma: 0.0 }));
    assert_relative(long, 0.5 * (1.0 + H.powi(4) / 4.0).powi(20_000), 1e-10);
}
