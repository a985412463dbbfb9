//! Studies with noise: errors against exact expectations, orders, and orders that are not claimed.

use sve_models::exact::OscillatorStep;
use sve_models::models::{Kubo, Oscillator};
use sve_runtime::baseline::{EulerMaruyama, Heun};
use sve_runtime::prelude::*;
use sve_runtime::study::{Estimate, Order, Report, Study};

use crate::without_noise::pendulum;

/// Accepted deviation in standard errors. The seeds are fixed, so the results of the tests do not
/// vary.
const SIGMAS: f64 = 4.0;

const SIGMA: f64 = 0.7;
pub(super) const HORIZON: f64 = 2.0;
const STEPS: [usize; 4] = [32, 64, 128, 256];
const PATHS: u64 = 400;

fn near(measured: Estimate, expected: f64, what: &str) {
    let Estimate {
        value,
        standard_error,
    } = measured;
    println!("{what}: {value:e} ± {standard_error:e}, expected {expected:e}");
    assert!(
        (value - expected).abs() <= SIGMAS * standard_error,
        "{what}"
    );
}

/// The oscillator's four schemes against its exact paths.
pub(super) fn oscillator() -> Report {
    let system = Oscillator { sigma: SIGMA };
    let start = State::new([1.0], [0.0]);
    // E H = H₀ + σ²t/2
    let energy = 0.5 + 0.5 * SIGMA * SIGMA * HORIZON;
    Study::new("oscillator")
        .start(start)
        .horizon(HORIZON)
        .step_counts(STEPS)
        .paths(PATHS)
        .method(
            "initial point",
            &Integrator::new(system.clone(), InitialPoint),
        )
        .method("endpoint", &Integrator::new(system.clone(), Endpoint))
        .method("midpoint", &Integrator::new(system.clone(), Midpoint))
        .method("Euler–Maruyama", &EulerMaruyama::new(system.clone()))
        .exact_paths(|path, steps| {
            let noise = Wiener::new(11).path(path);
            OscillatorStep::new(HORIZON / steps as f64).path(SIGMA, start, &noise, steps)
        })
        .observe("energy, paired", Mechanics::hamiltonian)
        .observe_mean("energy", Mechanics::hamiltonian, energy)
        .repeats(0)
        .run()
        .unwrap()
}

type Matrix = [[f64; 4]; 4];

/// A and b of the schemes `z₁ = A z₀ + b σ ΔW`.
fn scheme(method: &str, h: f64) -> ([[f64; 2]; 2], [f64; 2]) {
    match method {
        "initial point" => ([[1.0 - h * h, h], [-h, 1.0]], [h, 1.0]),
        "endpoint" => ([[1.0, h], [-h, 1.0 - h * h]], [0.0, 1.0]),
        "midpoint" => {
            let d = 1.0 + h * h / 4.0;
            let c = (1.0 - h * h / 4.0) / d;
            ([[c, h / d], [-h / d, c]], [h / 2.0 / d, 1.0 / d])
        }
        "Euler–Maruyama" => ([[1.0, h], [-h, 1.0]], [0.0, 1.0]),
        other => panic!("{other}"),
    }
}

/// Second moments of (scheme, exact solution) on the same path: `M₁ = A M₀ Aᵀ + Q`.
fn joint_moments(method: &str, steps: usize) -> Matrix {
    let h = HORIZON / steps as f64;
    let ([[a, b], [c, d]], kick) = scheme(method, h);
    let exact = OscillatorStep::new(h);
    let (sin, cos) = (exact.sin, exact.cos);
    let map = [
        [a, b, 0.0, 0.0],
        [c, d, 0.0, 0.0],
        [0.0, 0.0, cos, sin],
        [0.0, 0.0, -sin, cos],
    ];
    let mut noise = [[0.0; 4]; 4];
    for i in 0..2 {
        for j in 0..2 {
            noise[i][j] = SIGMA * SIGMA * h * kick[i] * kick[j];
            noise[2 + i][2 + j] = SIGMA * SIGMA * exact.integrals[i][j];
            noise[i][2 + j] = SIGMA * SIGMA * kick[i] * exact.with_dw[j];
            noise[2 + j][i] = noise[i][2 + j];
        }
    }
    let start = [1.0, 0.0, 1.0, 0.0];
    let mut moments: Matrix = start.map(|x| start.map(|y| x * y));
    for _ in 0..steps {
        let mut next = noise;
        for i in 0..4 {
            for j in 0..4 {
                for k in 0..4 {
                    for l in 0..4 {
                        next[i][j] += map[i][k] * moments[k][l] * map[j][l];
                    }
                }
            }
        }
        moments = next;
    }
    moments
}

#[test]
fn strong_and_weak_errors_of_linear_schemes_have_their_exact_expectations() {
    let report = oscillator();
    println!("{report}");
    assert_eq!(report.rows().len(), 4 * STEPS.len());
    for row in report.rows() {
        assert_eq!(row.failures, 0);
        assert_eq!(row.h, HORIZON / row.steps as f64);
        let m = joint_moments(&row.method, row.steps);
        let strong = (0..2).map(|i| m[i][i] - 2.0 * m[i][2 + i] + m[2 + i][2 + i]);
        let name = format!("{} with {}", row.method, row.steps);
        near(row.error.unwrap(), strong.sum::<f64>().sqrt(), &name);
        let weak = 0.5 * (m[0][0] + m[1][1]) - 0.5 - 0.5 * SIGMA * SIGMA * HORIZON;
        let [paired, unpaired] = row.weak_errors[..] else {
            panic!("two observables");
        };
        near(paired, weak, &format!("{name}, paired"));
        near(unpaired, weak, &format!("{name}, unpaired"));
        // that is what common random numbers are for
        assert!(paired.standard_error < 0.2 * unpaired.standard_error);
    }
}

#[test]
fn orders_are_measured_within_their_errors() {
    let report = oscillator();
    assert_eq!(report.orders().len(), 4);
    for order in report.orders() {
        let measured = order.order;
        println!("{order:?}");
        assert!((3..=STEPS.len()).contains(&order.points));
        assert_eq!(order.of_method, order_of(&order.method));
        assert!(measured.standard_error > 1e-4 && measured.standard_error < 0.25);
        // the error contains the next power of h
        assert!((measured.value - 1.0).abs() < measured.standard_error);
    }
}

/// Weak errors of the same run: the slope of their exact expectations at the finest steps is within
/// two errors, from paired paths, whose errors are small enough for an order of every method.
#[test]
fn weak_orders_are_those_of_the_exact_expectations() {
    let report = oscillator();
    let weak = |method: &str, steps: usize| {
        let m = joint_moments(method, steps);
        0.5 * (m[0][0] + m[1][1]) - 0.5 - 0.5 * SIGMA * SIGMA * HORIZON
    };
    let mut seen = 0;
    for order in report.weak_orders() {
        let Estimate {
            value,
            standard_error,
        } = order.order;
        let slope = (weak(&order.method, 2048) / weak(&order.method, 4096)).log2();
        println!("{order}; exact {slope}");
        assert!((value - slope).abs() <= 2.0 * standard_error, "{order}");
        assert!(order.of_method.is_none() && !order.exceeds_method());
        let observable = order.observable.as_deref();
        seen += usize::from(observable == Some("energy, paired"));
    }
    let others = report.weak_not_asymptotic();
    assert_eq!(report.weak_orders().len() + others.len(), 8);
    assert!(seen >= 1, "{report}");
    let text = report.to_string();
    assert!(
        text.contains("weak order of midpoint, mean of energy, paired"),
        "{text}"
    );
    assert!(
        report
            .orders()
            .iter()
            .all(|order| order.observable.is_none())
    );
}

/// Means of Kubo's oscillator have weak order 1, of which the paths are certain enough.
#[test]
fn weak_orders_of_means_are_measured_within_their_errors() {
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let midpoint = Integrator::new(system.clone(), Midpoint);
    let heun = Heun::new(system);
    let study = kubo().step_counts([16, 32, 64, 128]).paths(4000).seed(3);
    let study = study.method("midpoint", &midpoint).method("Heun", &heun);
    let report = study.observe("q", |_, state| state.q[0]).run().unwrap();
    println!("{report}");
    for method in ["midpoint", "Heun"] {
        let order = report
            .weak_orders()
            .iter()
            .find(|order| order.method == method);
        let order = order.unwrap_or_else(|| panic!("{report}"));
        assert!(
            (order.order.value - 1.0).abs() <= 2.0 * order.order.standard_error,
            "{order}"
        );
    }
}

/// The order that a derived rule states with noise; other methods state none.
fn order_of(method: &str) -> Option<f64> {
    (method != "Euler–Maruyama").then_some(1.0)
}

/// The error of an order is realistic: for nearly all of several independent seeds, 1 is within
/// twice the error, and the errors are not much larger than necessary.
#[test]
fn the_error_of_an_order_is_that_of_its_seeds() {
    const SEEDS: usize = 60;
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let midpoint = Integrator::new(system, Midpoint);
    let study = |seed| {
        let study = kubo().seed(seed).paths(400).method("midpoint", &midpoint);
        study.step_counts([16, 32, 64, 128]).run().unwrap()
    };
    let orders: Vec<Estimate> = (0..SEEDS as u64)
        .filter_map(|seed| Some(study(seed).orders().first()?.order))
        .collect();
    let n = orders.len() as f64;
    let scatter = orders.iter().map(|o| (o.value - 1.0).powi(2)).sum::<f64>() / n;
    let claimed = orders.iter().map(|o| o.standard_error.powi(2)).sum::<f64>() / n;
    let within = |o: &&Estimate| (o.value - 1.0).abs() <= 2.0 * o.standard_error;
    let within = orders.iter().filter(within).count();
    println!(
        "{n} orders, {within} within two errors; scatter {:e}, claimed {:e}",
        scatter.sqrt(),
        claimed.sqrt()
    );
    assert!(orders.len() > SEEDS / 2);
    // outside of two standard errors would be 5 %: 12 of 60 are four deviations more
    assert!(orders.len() - within < 12);
    assert!(claimed < 25.0 * scatter);
}

/// Orders that were once printed as such: of too few step sizes, of errors of two powers, of a rule
/// that is conjugate to one of higher order.
#[test]
fn an_order_is_not_claimed_where_there_is_none() {
    use sve_runtime::study::NotAsymptotic;

    let report = pendulum(4);
    let text = report.to_string();
    println!("{text}");
    assert!(!text.contains("NaN") && !text.contains("± 0.000"), "{text}");
    // most errors of Euler's method are as large as the motion
    let [NotAsymptotic { method, slopes, .. }] = report.not_asymptotic() else {
        panic!("{:?}", report.not_asymptotic());
    };
    assert!(method == "Euler" && slopes.len() < 3);
    assert!(text.contains("order of Euler: not asymptotic"));
    assert!(!report.orders().iter().any(Order::exceeds_method));
    // after whole periods of a linear oscillator the change of coordinates by which the endpoint
    // rule differs from a rule of order 2 is where it began
    let system = Oscillator { sigma: 0.0 };
    let endpoint = Integrator::new(system.clone(), Endpoint);
    let study = |horizon: f64| {
        let (sin, cos) = horizon.sin_cos();
        let study = Study::new("oscillator").start(State::new([1.0], [0.0]));
        let study = study
            .horizon(horizon)
            .step_counts([128, 256, 512, 1024, 2048]);
        let study = study.method("endpoint", &endpoint).repeats(0).paths(2);
        study
            .exact(move |_| State::at(horizon, [cos], [-sin]))
            .run()
            .unwrap()
    };
    let whole = study(2.0 * std::f64::consts::TAU);
    println!("{whole}");
    let order = &whole.orders()[0];
    assert!((order.order.value - 2.0).abs() < order.order.standard_error.max(1e-3));
    assert!(order.of_method == Some(1.0) && order.exceeds_method());
    assert!(whole.to_string().contains("conjugate"));
    let generic = study(2.1 * std::f64::consts::TAU);
    println!("{generic}");
    let order = &generic.orders()[0];
    assert!((order.order.value - 1.0).abs() < order.order.standard_error.max(1e-3));
    assert!(!order.exceeds_method());
}

/// Kubo's oscillator against the rotation by `t + σ W(t)`.
pub(super) fn kubo<'a>() -> Study<'a, Kubo> {
    Study::new("Kubo")
        .start(State::new([1.0], [0.0]))
        .horizon(1.0)
        .step_counts([16, 64])
        .exact(|path| {
            let whole = path.coarsen(path.len()).unwrap();
            let (sin, cos) = (1.0 + 0.5 * whole.get(0).unwrap()[0]).sin_cos();
            State::at(1.0, [cos], [-sin])
        })
        .repeats(0)
}

/// The fine reference has an error of its own: with order 1, a part of as many times fewer steps,
/// of either sign.
#[test]
fn a_fine_step_stands_for_the_exact_solution() {
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let midpoint = Integrator::new(system.clone(), Midpoint);
    let heun = Heun::new(system);
    let exact = kubo().paths(200).method("Heun", &heun);
    // the paths are those of the finest steps: as many with the factor as without
    let exact = exact.step_counts([16, 64, 1024]).run().unwrap();
    let fine = kubo().paths(200).method("Heun", &heun);
    let fine = fine.fine(&midpoint, 16).run().unwrap();
    for steps in [16, 64] {
        let error = |report: &Report| report.row("Heun", steps).unwrap().error.unwrap().value;
        let (exact, fine) = (error(&exact), error(&fine));
        println!("{exact:e} {fine:e}");
        assert!(exact != fine && (exact / fine - 1.0).abs() < steps as f64 / 1024.0);
    }
}
