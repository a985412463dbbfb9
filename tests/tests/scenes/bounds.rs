//! Bounds of the equations of midpoint steps, and what layouts tell of them.

use sve_runtime::prelude::*;

use crate::common::spread;
use crate::midpoint::pendula;

pub(crate) struct Springs {
    pub(crate) k: f64,
    pub(crate) own: f64,
}

#[variational(midpoint)]
impl Springs {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i] * v[i] - 0.5 * self.own * q[i] * q[i];
        }
        for i in 1..q.len() {
            l -= 0.5 * self.k * (q[i] - q[i - 1]).powi(2);
        }
        l
    }
}

/// The equations of a linear scene have the eigenvalues 1 + h²/4 (own + k λ) with λ from 0 to 4:
/// the step ends where the lowest one is 0, and bounds of an inner row are those eigenvalues.
#[test]
fn bounds_of_linear_scenes_are_their_spectrum() {
    let step = |own: f64, k: f64, h: f64| {
        let mut state = State::new(spread(50, 3), spread(50, 4));
        Integrator::new(Springs { k, own }, Midpoint).step(&mut state, h, &[])
    };
    step(-1.0, 0.3, 1.98).expect("a step");
    let Err(StepError::Stiff { bounds, what, .. }) = step(-1.0, 0.3, 2.0) else {
        panic!("the lowest eigenvalue is 0");
    };
    assert!(what.starts_with("q["), "{what}");
    assert!(
        (bounds[0] + 1.0).abs() < 1e-15 && (bounds[1] - 0.2).abs() < 1e-15,
        "{bounds:?}"
    );
    let Err(error @ StepError::Stiff { bounds, .. }) = step(0.0, 10.0, 4.0) else {
        panic!("many sweeps");
    };
    assert!(
        (bounds[0].abs() < 1e-13) && (bounds[1] - 160.0).abs() < 1e-12,
        "{bounds:?}"
    );
    let text = error.to_string();
    let advised = text.split("take |h| below about ").nth(1).expect("advice");
    let advised: f64 = advised
        .split(',')
        .next()
        .expect("a number")
        .parse()
        .expect("a number");
    step(0.0, 10.0, advised).expect("the advised step");
}

/// The bounds are those of inner rows, (own + k λ) h²/4 with λ from 0 to 4. The state stays as it
/// is.
#[test]
fn layouts_tell_the_bounds_and_the_sweeps() {
    let springs = Integrator::new(Springs { k: 1.0, own: 0.5 }, Midpoint);
    let start = State::new(spread(50, 3), spread(50, 4));
    let of_step = |h: f64| {
        let layout = springs.layout(&start, h).expect("a layout");
        let solution = layout.midpoint.expect("a midpoint step");
        let text = format!("{} sweeps a step", solution.sweeps);
        assert!(layout.to_string().contains(&text), "{layout}");
        // Chebyshev's iteration has the error 2 τᵏ, which ends far below rounding errors
        let [a, b] = solution.bounds.map(|bound| (1.0 + bound).sqrt());
        let sweeps = (32.0 / f64::EPSILON).ln() / ((b + a) / (b - a)).ln();
        let ratio = f64::from(solution.sweeps) / sweeps;
        assert!(0.7 < ratio && ratio < 1.2, "{ratio} {sweeps}");
        solution
    };
    let [short, long] = [0.4, 2.0].map(of_step);
    for (found, expected) in short.bounds.iter().zip([0.02, 0.18]) {
        assert!((found - expected).abs() < 1e-15, "{found}");
    }
    assert!(short.sweeps < long.sweeps);
    let stiff = Integrator::new(Springs { k: 0.3, own: -1.0 }, Midpoint);
    let error = stiff.layout(&start, 2.0).expect_err("an eigenvalue is 0");
    assert!(matches!(error, StepError::Stiff { .. }), "{error}");
    let explicit = Integrator::new(pendula(50, 0.7, 0.5), Endpoint);
    let layout = explicit.layout(&start, 0.4).expect("a layout");
    assert_eq!(layout.midpoint, None);
}
