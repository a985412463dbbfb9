//! The exponents of Hénon and Heiles against an integration that shares no code with them: the
//! equations of motion and of a small change, written out and solved by the classical Runge–Kutta
//! method.
//!
//! Source of the equations: M. Hénon, C. Heiles, *The applicability of the third integral of
//! motion*, Astron. J. 69 (1964) 73–79.

use sve_models::models::HenonHeiles;
use sve_runtime::prelude::*;

/// Lengths of the parts of a path, whose rates are taken as independent. In a part before them the
/// change turns to the direction that grows.
const PART: u32 = 500;
const PARTS: u32 = 20;

/// Steps per unit of time, of the reference and of the integrator.
const FINE: u32 = 50;
const COARSE: u32 = 20;

/// The rates of change of the state and of a small change.
fn rates(z: &[f64; 8]) -> [f64; 8] {
    let [x, y, px, py, dx, dy, dpx, dpy] = *z;
    [
        px,
        py,
        -x - 2.0 * x * y,
        -y - x * x + y * y,
        dpx,
        dpy,
        -(1.0 + 2.0 * y) * dx - 2.0 * x * dy,
        -2.0 * x * dx - (1.0 - 2.0 * y) * dy,
    ]
}

fn runge_kutta(z: &[f64; 8], h: f64) -> [f64; 8] {
    let at = |k: &[f64; 8], part: f64| core::array::from_fn(|i| z[i] + part * h * k[i]);
    let a = rates(z);
    let b = rates(&at(&a, 0.5));
    let c = rates(&at(&b, 0.5));
    let d = rates(&at(&c, 1.0));
    core::array::from_fn(|i| z[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]))
}

/// A start in the chaotic sea with an energy, on x = 0 and y = −0.25, which moves along x.
fn start(energy: f64) -> [f64; 4] {
    let y: f64 = -0.25;
    let potential = 0.5 * y * y - y.powi(3) / 3.0;
    [0.0, y, (2.0 * (energy - potential)).sqrt(), 0.0]
}

/// The largest exponent with its standard error, from the parts of a path.
fn reference(energy: f64) -> (f64, f64) {
    let h = 1.0 / f64::from(FINE);
    let [x, y, px, py] = start(energy);
    let mut z = [x, y, px, py, 0.6, 0.0, 0.0, 0.8];
    let mut grow = || {
        let mut sum = 0.0;
        for _ in 0..PART * FINE {
            z = runge_kutta(&z, h);
            let size = z[4..].iter().map(|x| x * x).sum::<f64>().sqrt();
            sum += size.ln();
            z[4..].iter_mut().for_each(|x| *x /= size);
        }
        sum / f64::from(PART)
    };
    grow();
    let rates: Vec<f64> = (0..PARTS).map(|_| grow()).collect();
    let n = f64::from(PARTS);
    let mean = rates.iter().sum::<f64>() / n;
    let squares: f64 = rates.iter().map(|rate| (rate - mean).powi(2)).sum();
    (mean, (squares / (n * (n - 1.0))).sqrt())
}

/// At both energies one chaotic region has nearly all of the energy surface outside of the islands,
/// so paths of different methods have the same exponent. Nearby islands hold paths for long times,
/// which the errors of the averages contain.
#[test]
fn agrees_with_an_independent_integration() {
    let h = 1.0 / f64::from(COARSE);
    let integrator = Integrator::new(HenonHeiles, StormerVerlet);
    let mut exponents = Vec::new();
    for energy in [0.125, 0.16] {
        let (expected, of_expected) = reference(energy);
        let [x, y, px, py] = start(energy);
        let mut path = integrator.lyapunov(State::new([x, y], [px, py]), h, NoNoise, 4);
        path.advance(u64::from(PART * COARSE)).unwrap();
        path.restart();
        path.advance(u64::from(PARTS * PART * COARSE)).unwrap();
        let found = path.exponents();
        let error = path.standard_errors()[0].unwrap();
        println!(
            "E = {energy}: {} ± {error}, {expected} ± {of_expected}",
            found[0]
        );
        let distance = (found[0] - expected).abs();
        assert!(distance < 4.5 * error.hypot(of_expected), "{distance}");
        assert!(error < 0.1 * expected && of_expected < 0.1 * expected);
        // the energy and the direction of the motion do not grow exponentially
        assert!(found[1].abs() < 2e-3 && found[2].abs() < 2e-3, "{found:?}");
        // the pairs are exact in each step
        let pairs = [found[0] + found[3], found[1] + found[2]];
        assert!(pairs.iter().all(|sum| sum.abs() < 1e-10), "{pairs:?}");
        exponents.push(found[0]);
    }
    assert!(exponents[1] > 1.5 * exponents[0], "{exponents:?}");
}
