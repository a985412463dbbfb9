//! Measured weak orders: one table of system, rule, noise and expected order.
//!
//! Nothing is sampled. The expectation over an increment is a Gauss–Hermite quadrature. The second
//! moments of a linear system after a step are `E[A M Aᵀ]` for the matrix A of the step, which
//! depends on ΔW; the exact ones obey linear equations. For other systems the quadrature follows
//! all nodes of all steps. The order is the slope of the logarithms.

mod forces;
mod moments;
mod momentum;
mod quadrature;
mod stages;
mod systems;

use sve_models::models::Oscillator;
use sve_models::orders::{Order, Tolerance, distance2};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use moments::{Matrix, distance, exact, matrix, moments, plus};
use quadrature::{expectations, gauss_hermite, tensor};
use systems::{Bent, Coupled, CubicFriction, Heavy, Parametric, Quadratic, products};

/// At the larger steps the next term of the error still counts.
const TOLERANCE: Tolerance = Tolerance {
    bias: 0.12,
    error: 0.0,
};

/// Prints a row of the table and checks it.
fn line(system: &str, rule: &str, noise: &str, expected: u32, errors: &[f64]) {
    Order::of(errors).check([system, rule, noise], f64::from(expected), TOLERANCE);
}

/// The distance of two rows of numbers.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    distance2(a, b).sqrt()
}

/// One line for a rule: steps of 2⁻⁴ … 2⁻⁷.
fn linear<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    noise: &str,
    start: State<[f64; N]>,
    exact: &Matrix,
) -> Vec<f64>
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let error = |level| distance(&moments(integrator, start, level), exact);
    let errors: Vec<f64> = (4..=7).map(error).collect();
    let plan = integrator.plan();
    line(plan.system, plan.rule, noise, plan.weak_order, &errors);
    errors
}

macro_rules! for_each_rule {
    ($check:ident, $system:expr, every, $arguments:tt) => {
        for_each_rule!($check, $system, (InitialPoint, Endpoint), $arguments);
        for_each_rule!($check, $system, (Midpoint, Weak2(Midpoint)), $arguments);
        for_each_rule!($check, $system, (StormerVerlet, Weak2(StormerVerlet)), $arguments);
        for_each_rule!($check, $system, (Gauss::<2>, Weak2(Gauss::<2>)), $arguments);
    };
    ($check:ident, $system:expr, ($($rule:expr),*), $arguments:tt) => {$(
        for_each_rule!(one $check, $system, $rule, $arguments);
    )*};
    (one $check:ident, $system:expr, $rule:expr, ($($argument:expr),*)) => {
        $check(&Integrator::new($system, $rule), $($argument),*);
    };
}
use for_each_rule;

/// Oscillators with noisy stiffness, with their names and their exact moments from a start.
fn stiffness(start: State<[f64; 1]>) -> impl Iterator<Item = (Parametric, &'static str, Matrix)> {
    let rows = [
        (0.0, 0.0, "γ = ½σq²"),
        (0.7, 0.0, "γ = ½σ(t)q²"),
        (0.0, 0.4, "γ = ½σq², friction"),
    ];
    rows.into_iter().map(move |(beat, friction, noise)| {
        let system = Parametric {
            sigma: 0.5,
            beat,
            friction,
        };
        let drift = matrix([[0.0, 1.0, 0.0], [-1.0, -friction, 0.0], [0.0; 3]]);
        let exact = exact(start, &drift, |t| {
            let sigma = 2.0 * system.stiffness(t, 1.0);
            vec![matrix([[0.0; 3], [sigma, 0.0, 0.0], [0.0; 3]])]
        });
        (system, noise, exact)
    })
}

#[test]
fn noisy_stiffness() {
    let start = State::new([1.0], [0.0]);
    for (system, noise, exact) in stiffness(start) {
        let plain = Integrator::new(system.clone(), Midpoint);
        let plain = linear(&plain, noise, start, &exact);
        let corrected = Integrator::new(system.clone(), Weak2(Midpoint));
        let corrected = linear(&corrected, noise, start, &exact);
        // steps of 2⁻⁵
        assert!(plain[1] > 8.0 * corrected[1], "{plain:?} {corrected:?}");
        for_each_rule!(linear, system.clone(), every, (noise, start, &exact));
        let fourth = Integrator::new(system, Weak2(Gauss::<4>));
        linear(&fourth, noise, start, &exact);
    }
}

#[test]
fn two_noises_with_coupled_masses() {
    let start = State::new([1.0, -0.5], [0.2, 0.3]);
    // M⁻¹ of M = (1, ½; ½, 2)
    let (a, b, c) = (2.0 / 1.75, -0.5 / 1.75, 1.0 / 1.75);
    let drift = matrix([
        [0.0, 0.0, a, b, 0.0],
        [0.0, 0.0, b, c, 0.0],
        [-1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, -2.0, 0.0, 0.0, 0.0],
        [0.0; 5],
    ]);
    for (sigma, noise) in [
        ([0.6, 0.4], "two γ"),
        ([0.8, 0.1], "a strong γ and a weak one"),
    ] {
        let system = Coupled { sigma };
        let [s0, s1] = system.sigma;
        let zero = [0.0; 5];
        let (first, second, third) = (
            [s0, 0.0, 0.0, 0.0, 0.0],
            [0.0, s1, 0.0, 0.0, 0.0],
            [s1, -s1, 0.0, 0.0, 0.0],
        );
        let noises = vec![
            matrix([zero, zero, first, zero, zero]),
            matrix([zero, zero, second, third, zero]),
        ];
        let exact = exact(start, &drift, |_| noises.clone());
        for_each_rule!(linear, system.clone(), every, (noise, start, &exact));
    }
}

/// Additive noise needs no term: K is a constant.
#[test]
fn additive_noise() {
    let start = State::new([1.0], [0.0]);
    let drift = matrix([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]]);
    let push = matrix([[0.0; 3], [0.0, 0.0, 0.7], [0.0; 3]]);
    let exact = exact(start, &drift, |_| vec![push.clone()]);
    for_each_rule!(
        linear,
        Oscillator { sigma: 0.7 },
        (InitialPoint, Endpoint, Midpoint, StormerVerlet),
        ("γ = σq", start, &exact)
    );
}

/// H₁ and noises that do not commute have weak order 1; so they have with the term `⅛ h ΣK` in H,
/// which is why the attribute refuses the option.
#[test]
fn quadratic_noise_in_momentum() {
    let start = State::new([1.0], [0.3]);
    let drift = matrix([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]]);
    for (noise @ [a, b, c], text) in [
        ([0.5, 0.2, 0.0], "H₁ = ½(aq² + bp²)"),
        ([0.5, 0.0, 0.4], "H₁ = ½aq² and cqp, not commuting"),
    ] {
        let noises = vec![
            matrix([[0.0, b, 0.0], [-a, 0.0, 0.0], [0.0; 3]]),
            matrix([[c, 0.0, 0.0], [0.0, -c, 0.0], [0.0; 3]]),
        ];
        let exact = exact(start, &drift, |_| noises.clone());
        let plain = Quadratic {
            w: 1.0,
            k: 1.0,
            noise,
        };
        for_each_rule!(
            linear,
            plain.clone(),
            (InitialPoint, Endpoint, Midpoint, StormerVerlet),
            (text, start, &exact)
        );
        // ΣK = (a − b)(aq² − bp²) + 2c²(q² + p²)
        let with_term = |h: f64| Quadratic {
            w: 1.0 + 0.25 * h * (2.0 * c * c - (a - b) * b),
            k: 1.0 + 0.25 * h * (2.0 * c * c + (a - b) * a),
            noise,
        };
        let error = |level: u32| {
            let system = with_term(0.5_f64.powi(level as i32));
            distance(
                &moments(&Integrator::new(system, Midpoint), start, level),
                &exact,
            )
        };
        let errors: Vec<f64> = (4..=7).map(error).collect();
        line("Quadratic", "midpoint with the term", text, 1, &errors);
    }
}

/// One line for a rule: 2, 4 and 8 steps to T = ½.
fn nonlinear<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    noise: &str,
    start: State<[f64; N]>,
    exact: &[f64],
    observe: &dyn Fn(&State<[f64; N]>) -> Vec<f64>,
) where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let nodes = tensor(&gauss_hermite(4));
    let error = |steps: u32| {
        let found = expectations(
            integrator,
            start,
            (steps, 0.5 / f64::from(steps)),
            &nodes,
            observe,
        );
        apart(&found, exact)
    };
    let errors = [2, 4, 8].map(error);
    let plan = integrator.plan();
    line(plan.system, plan.rule, noise, plan.weak_order, &errors);
}

/// Exact moments at T = ½ of x with its velocity: those at T = 1 for half of the rates.
fn halved(start: &[f64], drift: &Matrix, noise: &Matrix) -> Vec<f64> {
    let scaled = |m: &Matrix, factor: f64| plus(m, factor - 1.0, m);
    let n = start.len() / 2;
    let padded = |m: &Matrix| {
        let mut rows: Matrix = m.iter().map(|row| [row, &[0.0][..]].concat()).collect();
        rows.push(vec![0.0; 2 * n + 1]);
        rows
    };
    let (drift, noise) = (
        padded(&scaled(drift, 0.5)),
        padded(&scaled(noise, 0.5_f64.sqrt())),
    );
    let all = match n {
        1 => exact(State::new([start[0]], [start[1]]), &drift, |_| {
            vec![noise.clone()]
        }),
        _ => {
            let state = State::new([start[0], start[1]], [start[2], start[3]]);
            exact(state, &drift, |_| vec![noise.clone()])
        }
    };
    all[..2 * n]
        .iter()
        .flat_map(|row| row[..2 * n].to_vec())
        .collect()
}

#[test]
fn masses_that_depend_on_the_configuration() {
    let heavy = Heavy { sigma: 0.8 };
    let start = State::new([1.2], [0.4]);
    let square = heavy.moments(&start);
    // the signs of both are positive
    let at = [square[0].sqrt(), square[3].sqrt()];
    assert_eq!(products(&at).len(), square.len());
    let drift = matrix([[0.0, 1.0], [-1.0, 0.0]]);
    let noise = matrix([[0.0, 0.0], [heavy.sigma, 0.0]]);
    let exact = halved(&at, &drift, &noise);
    let observe = |state: &State<[f64; 1]>| heavy.moments(state);
    let text = "mass 1 + q²/4";
    for_each_rule!(
        nonlinear,
        heavy.clone(),
        every,
        (text, start, &exact, &observe)
    );

    let bent = Bent { sigma: 0.8 };
    let start = State::new([0.7, 0.5], [0.6, 0.5]);
    let square = bent.moments(&start);
    let at: Vec<f64> = (0..4).map(|i| square[5 * i].sqrt()).collect();
    let zero = [0.0; 4];
    let drift = matrix([
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [-1.0, 0.0, 0.0, 0.0],
        [0.0, -2.0, 0.0, 0.0],
    ]);
    let s = bent.sigma;
    let noise = matrix([zero, zero, [s, 0.5 * s, 0.0, 0.0], [0.5 * s, 0.0, 0.0, 0.0]]);
    let exact = halved(&at, &drift, &noise);
    let observe = |state: &State<[f64; 2]>| bent.moments(state);
    let text = "full mass matrix of q";
    for_each_rule!(
        nonlinear,
        bent.clone(),
        every,
        (text, start, &exact, &observe)
    );
}

/// A force that is not affine in v has weak order 1 with the term too. The exact expectations are
/// not known: the table has differences between steps and steps of half the size.
#[test]
fn cubic_friction() {
    let nodes = tensor(&gauss_hermite(4));
    let found = |steps: u32| {
        let h = 0.125 / f64::from(steps);
        let system = CubicFriction {
            sigma: 0.8,
            nu: 1.0,
            h,
        };
        let integrator = Integrator::new(system, Midpoint);
        let observe = |state: &State<[f64; 1]>| products(&[state.q[0], state.p[0]]);
        expectations(
            &integrator,
            State::new([1.0], [0.4]),
            (steps, h),
            &nodes,
            &observe,
        )
    };
    let values = [1, 2, 4, 8].map(found);
    let pairs = values.windows(2);
    let errors: Vec<f64> = pairs.map(|pair| apart(&pair[0], &pair[1])).collect();
    line(
        "CubicFriction",
        "midpoint with the term",
        "γ = ½σq²",
        1,
        &errors,
    );
}
