//! Measured weak orders: one table of system, rule, noise and expected order.
//!
//! Nothing is sampled. The expectation over an increment is a Gauss–Hermite quadrature. The second moments of a linear system after a step are
//! `E[A M Aᵀ]` for the matrix A of the step, which depends on ΔW; the exact ones obey linear equations. For other systems the quadrature
//! follows all nodes of all steps. The order is the slope of the logarithms.

use sve_models::models::Oscillator;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

use crate::weak_systems::{Bent, Coupled, CubicFriction, Heavy, Parametric, Quadratic, products};

/// What a slope may be off: at the larger steps the next term of the error still counts.
const BIAS: f64 = 0.12;

/// Nodes and weights of the quadrature over a normal variable: zeros of the Hermite polynomial of degree n by Newton's method, from starts between
/// those of the zeros of the polynomial of degree n − 1.
fn gauss_hermite(n: usize) -> Vec<(f64, f64)> {
    // orthonormal polynomials: √(k+1) H_{k+1} = x H_k − √k H_{k−1}
    let evaluate = |degree: usize, x: f64| {
        let (mut before, mut value) = (0.0, 1.0);
        for k in 0..degree {
            let next = (x * value - (k as f64).sqrt() * before) / (k as f64 + 1.0).sqrt();
            (before, value) = (value, next);
        }
        [value, before]
    };
    let mut zeros: Vec<f64> = Vec::new();
    for degree in 1..=n {
        let end = 2.0 * (degree as f64).sqrt();
        let borders: Vec<f64> = [&[-end], zeros.as_slice(), &[end]].concat();
        let zero = |pair: &[f64]| {
            let (mut low, mut high) = (pair[0], pair[1]);
            let sign = evaluate(degree, low)[0].signum();
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if evaluate(degree, middle)[0] * sign > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            0.5 * (low + high)
        };
        zeros = borders.windows(2).map(zero).collect();
    }
    let weight = |&x: &f64| {
        let before = evaluate(n, x)[1];
        (x, 1.0 / (n as f64 * before * before))
    };
    zeros.iter().map(weight).collect()
}

#[test]
fn the_quadrature_has_the_moments_of_a_normal_variable() {
    for n in [5, 24] {
        let nodes = gauss_hermite(n);
        let mut expected = 1.0;
        for power in 0..n {
            let moment: f64 = nodes
                .iter()
                .map(|(x, w)| w * x.powi(2 * power as i32))
                .sum();
            assert!(
                (moment / expected - 1.0).abs() < 1e-11,
                "{n} {power}: {moment}"
            );
            expected *= 2.0 * power as f64 + 1.0;
        }
    }
}

/// All nodes of M independent variables with their weights.
fn tensor<const M: usize>(nodes: &[(f64, f64)]) -> Vec<([f64; M], f64)> {
    let mut all = vec![([0.0; M], 1.0)];
    for at in 0..M {
        let extended = all.iter().flat_map(|&(x, w)| {
            nodes.iter().map(move |&(node, weight)| {
                let mut x = x;
                x[at] = node;
                (x, w * weight)
            })
        });
        all = extended.collect();
    }
    all
}

type Matrix = Vec<Vec<f64>>;

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |row: &Vec<f64>, j: usize| row.iter().zip(b).map(|(x, y)| x * y[j]).sum();
    a.iter()
        .map(|row| (0..b[0].len()).map(|j| entry(row, j)).collect())
        .collect()
}

fn transposed(a: &Matrix) -> Matrix {
    (0..a[0].len())
        .map(|j| a.iter().map(|row| row[j]).collect())
        .collect()
}

fn plus(a: &Matrix, factor: f64, b: &Matrix) -> Matrix {
    let row =
        |(x, y): (&Vec<f64>, &Vec<f64>)| x.iter().zip(y).map(|(x, y)| x + factor * y).collect();
    a.iter().zip(b).map(row).collect()
}

/// The matrix of a step on (q, p, 1), for systems whose step is affine.
fn step_matrix<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    [t, h]: [f64; 2],
    dw: &[f64; M],
) -> Matrix
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let image = |unit: usize| {
        let mut state = State::at(t, [0.0; N], [0.0; N]);
        if unit < N {
            state.q[unit] = 1.0;
        } else if unit < 2 * N {
            state.p[unit - N] = 1.0;
        }
        integrator.step(&mut state, h, dw).unwrap();
        [state.q, state.p].concat()
    };
    let origin = image(2 * N);
    let mut columns: Matrix = (0..2 * N)
        .map(|unit| {
            image(unit)
                .iter()
                .zip(&origin)
                .map(|(x, y)| x - y)
                .chain([0.0])
                .collect()
        })
        .collect();
    columns.push(origin.into_iter().chain([1.0]).collect());
    transposed(&columns)
}

/// Second moments of (q, p, 1) at T = 1 after 2ᵏ steps.
fn moments<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<[f64; N]>,
    level: u32,
) -> Matrix
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let steps = 1_u32 << level;
    let h = 1.0 / f64::from(steps);
    let nodes = tensor::<M>(&gauss_hermite(24));
    let mut second = second_moments(start);
    for step in 0..steps {
        let mut next = vec![vec![0.0; 2 * N + 1]; 2 * N + 1];
        for (x, weight) in &nodes {
            let a = step_matrix(
                integrator,
                [f64::from(step) * h, h],
                &x.map(|x| x * h.sqrt()),
            );
            next = plus(&next, *weight, &times(&times(&a, &second), &transposed(&a)));
        }
        second = next;
    }
    second
}

fn second_moments<const N: usize>(start: State<[f64; N]>) -> Matrix {
    let z = [&start.q[..], &start.p, &[1.0]].concat();
    z.iter()
        .map(|x| z.iter().map(|y| x * y).collect())
        .collect()
}

/// The exact second moments at T = 1 of dz = B₀(t) z dt + Σ B_a(t) z ∘ dW_a: Runge–Kutta of order 4 with 2¹² steps.
fn exact<const N: usize>(
    start: State<[f64; N]>,
    drift: &Matrix,
    noises: impl Fn(f64) -> Vec<Matrix>,
) -> Matrix {
    let rate = |t: f64, m: &Matrix| {
        let half = times(drift, m);
        let mut rate = plus(&half, 1.0, &transposed(&half));
        for b in noises(t) {
            let twice = times(&b, &times(&b, m));
            rate = plus(&plus(&rate, 0.5, &twice), 0.5, &transposed(&twice));
            rate = plus(&rate, 1.0, &times(&times(&b, m), &transposed(&b)));
        }
        rate
    };
    let mut m = second_moments(start);
    let steps = 1 << 12;
    let h = 1.0 / f64::from(steps);
    for step in 0..steps {
        let t = f64::from(step) * h;
        let a = rate(t, &m);
        let b = rate(t + 0.5 * h, &plus(&m, 0.5 * h, &a));
        let c = rate(t + 0.5 * h, &plus(&m, 0.5 * h, &b));
        let d = rate(t + h, &plus(&m, h, &c));
        for (factor, k) in [(1.0, &a), (2.0, &b), (2.0, &c), (1.0, &d)] {
            m = plus(&m, factor * h / 6.0, k);
        }
    }
    m
}

/// Slope of the least-squares line through the logarithms of the errors for steps halved again and again.
fn slope(errors: &[f64]) -> f64 {
    let mean = (errors.len() - 1) as f64 / 2.0;
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (k, error) in errors.iter().enumerate() {
        let x = k as f64 - mean;
        covariance -= x * error.log2();
        variance += x * x;
    }
    covariance / variance
}

/// Prints a line of the table and checks it.
fn line(system: &str, rule: &str, noise: &str, expected: u32, errors: &[f64]) {
    let order = slope(errors);
    let last = errors.last().unwrap();
    println!("| {system} | {rule} | {noise} | {expected} | {order:.3} | {last:.1e} |");
    assert!(
        (order - f64::from(expected)).abs() < BIAS,
        "{system} by {rule}: weak order {order}, expected {expected}: {errors:?}"
    );
}

fn distance(a: &Matrix, b: &Matrix) -> f64 {
    let difference = plus(a, -1.0, b).concat();
    difference.iter().map(|x| x * x).sum::<f64>().sqrt()
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
    ($check:ident, $system:expr, ($($rule:expr),*), $arguments:tt) => {$(
        for_each_rule!(one $check, $system, $rule, $arguments);
    )*};
    (one $check:ident, $system:expr, $rule:expr, ($($argument:expr),*)) => {
        $check(&Integrator::new($system, $rule), $($argument),*);
    };
}

/// `rows` as a matrix.
fn matrix<const K: usize>(rows: [[f64; K]; K]) -> Matrix {
    rows.iter().map(|row| row.to_vec()).collect()
}

#[test]
fn noisy_stiffness() {
    let start = State::new([1.0], [0.0]);
    for (system, noise) in [
        (
            Parametric {
                sigma: 0.5,
                beat: 0.0,
                friction: 0.0,
            },
            "γ = ½σq²",
        ),
        (
            Parametric {
                sigma: 0.5,
                beat: 0.7,
                friction: 0.0,
            },
            "γ = ½σ(t)q²",
        ),
        (
            Parametric {
                sigma: 0.5,
                beat: 0.0,
                friction: 0.4,
            },
            "γ = ½σq², friction",
        ),
    ] {
        let drift = matrix([[0.0, 1.0, 0.0], [-1.0, -system.friction, 0.0], [0.0; 3]]);
        let exact = exact(start, &drift, |t| {
            let sigma = 2.0 * system.stiffness(t, 1.0);
            vec![matrix([[0.0; 3], [sigma, 0.0, 0.0], [0.0; 3]])]
        });
        let rules = (InitialPoint, Endpoint, Midpoint, StormerVerlet);
        for_each_rule!(
            linear,
            system.clone(),
            (rules.0, rules.1),
            (noise, start, &exact)
        );
        let plain = linear(
            &Integrator::new(system.clone(), rules.2),
            noise,
            start,
            &exact,
        );
        let corrected = linear(
            &Integrator::new(system.clone(), Weak2(rules.2)),
            noise,
            start,
            &exact,
        );
        // steps of 2⁻⁵
        assert!(plain[1] > 8.0 * corrected[1], "{plain:?} {corrected:?}");
        for_each_rule!(
            linear,
            system.clone(),
            (rules.3, Weak2(rules.3)),
            (noise, start, &exact)
        );
    }
}

#[test]
fn two_noises_with_coupled_masses() {
    let system = Coupled { sigma: [0.6, 0.4] };
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
    let [s0, s1] = system.sigma;
    let noises = vec![
        matrix([
            [0.0; 5],
            [0.0; 5],
            [s0, 0.0, 0.0, 0.0, 0.0],
            [0.0; 5],
            [0.0; 5],
        ]),
        matrix([
            [0.0; 5],
            [0.0; 5],
            [0.0, s1, 0.0, 0.0, 0.0],
            [s1, -s1, 0.0, 0.0, 0.0],
            [0.0; 5],
        ]),
    ];
    let exact = exact(start, &drift, |_| noises.clone());
    for_each_rule!(
        linear,
        system.clone(),
        (
            InitialPoint,
            Endpoint,
            Midpoint,
            Weak2(Midpoint),
            StormerVerlet,
            Weak2(StormerVerlet)
        ),
        ("two γ", start, &exact)
    );
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

/// H₁ and noises that do not commute have weak order 1; so they have with ½κhΣK in H, κ = ¼, which is why the attribute refuses the option.
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
        let error = |level| {
            let system = with_term(0.5_f64.powi(level));
            distance(
                &moments(&Integrator::new(system, Midpoint), start, level as u32),
                &exact,
            )
        };
        let errors: Vec<f64> = (4..=7).map(error).collect();
        line("Quadratic", "midpoint with the term", text, 1, &errors);
    }
}

/// Expectations at T = ½ after some steps, by following all nodes of all steps.
fn expectations<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    state: State<[f64; N]>,
    (left, h): (u32, f64),
    nodes: &[([f64; M], f64)],
    observe: &dyn Fn(&State<[f64; N]>) -> Vec<f64>,
) -> Vec<f64>
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    if left == 0 {
        return observe(&state);
    }
    let mut sums: Vec<f64> = Vec::new();
    for (x, weight) in nodes {
        let mut next = state;
        integrator
            .step(&mut next, h, &x.map(|x| x * h.sqrt()))
            .unwrap();
        let values = expectations(integrator, next, (left - 1, h), nodes, observe);
        sums.resize(values.len(), 0.0);
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += weight * value;
        }
    }
    sums
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
    let nodes = tensor(&gauss_hermite(5));
    let error = |steps: u32| {
        let found = expectations(
            integrator,
            start,
            (steps, 0.5 / f64::from(steps)),
            &nodes,
            observe,
        );
        let squares = found.iter().zip(exact).map(|(x, y)| (x - y).powi(2));
        squares.sum::<f64>().sqrt()
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
    for_each_rule!(
        nonlinear,
        heavy.clone(),
        (
            InitialPoint,
            Endpoint,
            Midpoint,
            Weak2(Midpoint),
            StormerVerlet,
            Weak2(StormerVerlet)
        ),
        ("mass 1 + q²/4", start, &exact, &observe)
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
    for_each_rule!(
        nonlinear,
        bent.clone(),
        (
            InitialPoint,
            Endpoint,
            Midpoint,
            Weak2(Midpoint),
            StormerVerlet,
            Weak2(StormerVerlet)
        ),
        ("full mass matrix of q", start, &exact, &observe)
    );
}

/// A force that is not affine in v has weak order 1 with the term too. The exact expectations are not known: the table has differences between steps and steps of half the size.
#[test]
fn cubic_friction() {
    let nodes = tensor(&gauss_hermite(5));
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
    let difference = |pair: &[Vec<f64>]| {
        let squares = pair[0].iter().zip(&pair[1]).map(|(x, y)| (x - y).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let errors: Vec<f64> = values.windows(2).map(difference).collect();
    line(
        "CubicFriction",
        "midpoint with the term",
        "γ = ½σq²",
        1,
        &errors,
    );
}
