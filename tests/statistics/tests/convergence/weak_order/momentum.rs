//! Weak orders with noise that moves the position.

use sve_runtime::prelude::*;

use super::moments::{distance, exact, matrix, moments};
use super::systems::{Damped, Squeezed};
use super::{for_each_rule, line, linear};

/// The term with noise in momentum needs two stages.
#[test]
fn commuting_noises_in_momentum() {
    let start = State::new([1.0], [0.3]);
    let drift = matrix([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]]);
    for (system, text) in [
        (
            Squeezed {
                sigma: [0.5, 0.0],
                a: 1.0,
                b: 0.4,
                beat: 0.0,
            },
            "H₁ = ½(aq² + bp²)",
        ),
        (
            Squeezed {
                sigma: [0.5, 0.3],
                a: 1.0,
                b: -0.5,
                beat: 0.7,
            },
            "two H₁, one of time",
        ),
    ] {
        let (a, b) = (system.a, system.b);
        let exact = exact(start, &drift, |t| {
            let strengths = system.strengths(t).into_iter();
            strengths
                .map(|s| matrix([[0.0, s * b, 0.0], [-s * a, 0.0, 0.0], [0.0; 3]]))
                .collect()
        });
        for_each_rule!(
            linear,
            system.clone(),
            (
                Midpoint,
                Gauss::<2>,
                Weak2(Gauss::<2>),
                Weak2(Gauss::<3>),
                Weak2(Gauss::<4>)
            ),
            (text, start, &exact)
        );
    }
}

/// Noise in momentum beside a force has weak order 1 with the term `h K/12` in H too, which is why
/// the attribute refuses the option.
#[test]
fn noise_in_momentum_with_friction() {
    let start = State::new([1.0], [0.3]);
    let (a, b, nu) = (0.5, 0.2, 0.6);
    let drift = matrix([[0.0, 1.0, 0.0], [-1.0, -nu, 0.0], [0.0; 3]]);
    let noise = matrix([[0.0, b, 0.0], [-a, 0.0, 0.0], [0.0; 3]]);
    let exact = exact(start, &drift, |_| vec![noise.clone()]);
    // K = (a − b)(aq² − bp²)
    let with_term = |h: f64| Damped {
        w: 1.0 - h / 6.0 * (a - b) * b,
        k: 1.0 + h / 6.0 * (a - b) * a,
        a,
        b,
        nu,
    };
    for (term, rule) in [(0.0, "gauss(2)"), (1.0, "gauss(2) with the term")] {
        let error = |level: u32| {
            let system = with_term(term * 0.5_f64.powi(level as i32));
            let found = moments(&Integrator::new(system, Gauss::<2>), start, level);
            distance(&found, &exact)
        };
        let errors: Vec<f64> = (4..=7).map(error).collect();
        line("Damped", rule, "H₁ = ½(aq² + bp²), friction", 1, &errors);
    }
}
