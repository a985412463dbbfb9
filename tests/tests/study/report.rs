//! Work–precision studies: errors against exact expectations, orders, invariants, failures, iterations, and that all of it is a function of
//! the settings.

use sve_runtime::baseline::{EulerMaruyama, Heun, RungeKutta4};
use sve_runtime::prelude::*;
use sve_runtime::study::{Estimate, Order, Report, Study, StudyError, read_csv, write_csv};
use sve_runtime::{IncrementsOf, Solver, StateOf, Variational};
use sve_models::exact::OscillatorStep;
use sve_models::models::{Kubo, Oscillator, Pendulum};

/// Standard errors that are accepted; with fixed seeds the tests never change their minds.
const SIGMAS: f64 = 4.0;

const SIGMA: f64 = 0.7;
const HORIZON: f64 = 2.0;
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
fn oscillator() -> Report {
    let system = Oscillator { sigma: SIGMA };
    let start = State::new([1.0], [0.0]);
    // E H = H₀ + σ²t/2
    let energy = 0.5 + 0.5 * SIGMA * SIGMA * HORIZON;
    Study::new("oscillator")
        .start(start)
        .horizon(HORIZON)
        .steps(STEPS)
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

/// What a derived rule says of itself with noise; other methods say nothing.
fn order_of(method: &str) -> Option<f64> {
    (method != "Euler–Maruyama").then_some(1.0)
}

/// An order's error says what it claims: of independent seeds nearly all have 1 within twice the error, and the errors are not
/// much larger than they have to be.
#[test]
fn the_error_of_an_order_is_that_of_its_seeds() {
    const SEEDS: usize = 60;
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let midpoint = Integrator::new(system, Midpoint);
    let study = |seed| {
        let study = kubo().seed(seed).paths(400).method("midpoint", &midpoint);
        study.steps([16, 32, 64, 128]).run().unwrap()
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

/// Orders that were once printed as such: of too few step sizes, of errors of two powers, of a rule that is conjugate to one of higher order.
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
    // after whole periods of a linear oscillator the change of coordinates by which the endpoint rule differs from a rule of order 2
    // is where it began
    let system = Oscillator { sigma: 0.0 };
    let endpoint = Integrator::new(system.clone(), Endpoint);
    let study = |horizon: f64| {
        let (sin, cos) = horizon.sin_cos();
        let study = Study::new("oscillator").start(State::new([1.0], [0.0]));
        let study = study.horizon(horizon).steps([128, 256, 512, 1024, 2048]);
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
    if let Some(order) = generic.orders().first() {
        assert!((order.order.value - 1.0).abs() < order.order.standard_error.max(1e-3));
        assert!(!order.exceeds_method());
    }
}

/// Kubo's oscillator against the rotation by `t + σ W(t)`.
fn kubo<'a>() -> Study<'a, Kubo> {
    Study::new("Kubo")
        .start(State::new([1.0], [0.0]))
        .horizon(1.0)
        .steps([16, 64])
        .exact(|path| {
            let whole = path.coarsen(path.len()).unwrap();
            let (sin, cos) = (1.0 + 0.5 * whole.get(0).unwrap()[0]).sin_cos();
            State::at(1.0, [cos], [-sin])
        })
        .repeats(0)
}

/// The fine reference has an error of its own: with order 1, a part of as many times fewer steps, of either sign.
#[test]
fn a_fine_step_stands_for_the_exact_solution() {
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let midpoint = Integrator::new(system.clone(), Midpoint);
    let heun = Heun::new(system);
    let exact = kubo().paths(200).method("Heun", &heun);
    // the paths are those of the finest steps: as many with the factor as without
    let exact = exact.steps([16, 64, 1024]).run().unwrap();
    let fine = kubo().paths(200).method("Heun", &heun);
    let fine = fine.fine(&midpoint, 16).run().unwrap();
    for steps in [16, 64] {
        let error = |report: &Report| report.row("Heun", steps).unwrap().error.unwrap().value;
        let (exact, fine) = (error(&exact), error(&fine));
        println!("{exact:e} {fine:e}");
        assert!(exact != fine && (exact / fine - 1.0).abs() < steps as f64 / 1024.0);
    }
}

fn pendulum(seconds: u32) -> Report {
    let system = Pendulum { g: 9.8 };
    let reference = RungeKutta4::new(system.clone());
    Study::new("pendulum")
        .start(State::new([1.0], [0.0]))
        .horizon(seconds.into())
        .steps([40, 80, 160, 320].map(|n| n * seconds as usize))
        .method(
            "initial point",
            &Integrator::new(system.clone(), InitialPoint),
        )
        .method("endpoint", &Integrator::new(system.clone(), Endpoint))
        .method("midpoint", &Integrator::new(system.clone(), Midpoint))
        .method("Taylor", &Integrator::new(system.clone(), Taylor2))
        .method("Euler", &EulerMaruyama::new(system.clone()))
        .method("Runge–Kutta", &RungeKutta4::new(system))
        .fine(&reference, 8)
        .observe("q", |_, state| state.q[0])
        .invariant(Mechanics::hamiltonian)
        .repeats(0)
        .run()
        .unwrap()
}

#[test]
fn energy_errors_are_bounded_for_symplectic_rules_and_grow_for_eulers() {
    let (short, long) = (pendulum(4), pendulum(16));
    for (short, long) in short.rows().iter().zip(long.rows()) {
        let (first, second) = (short.invariant.unwrap(), long.invariant.unwrap());
        println!("{} {} {first:?} {second:?}", short.method, short.h);
        assert_eq!((&short.method, short.h), (&long.method, long.h));
        let growth = second.largest / first.largest;
        // slope times horizon, beside the largest difference
        let secular = second.drift.value * 16.0 / second.largest;
        match &*short.method {
            "Euler" => assert!(growth > 2.0 && secular > 0.7),
            // it loses energy steadily, beside an oscillation
            "Runge–Kutta" => assert!(growth > 2.0 && secular < -0.7),
            // a whole period is in the shorter time; what is left of a period at the ends tilts the line
            _ => assert!((growth - 1.0).abs() < 0.01 && secular.abs() < 0.2),
        }
        assert_eq!(second.drift.standard_error, 0.0);
    }
}

#[test]
fn orders_without_noise() {
    let report = pendulum(4);
    assert_eq!(report.paths(), 1);
    let orders = report.orders();
    assert_eq!(orders.len(), 5);
    for order in orders {
        println!("{order}");
        let (expected, own) = match &*order.method {
            "initial point" | "endpoint" => (1.0, Some(1.0)),
            "midpoint" | "Taylor" => (2.0, Some(2.0)),
            _ => (4.0, None),
        };
        assert_eq!(order.of_method, own);
        let Estimate {
            value,
            standard_error,
        } = order.order;
        assert!((value - expected).abs() <= standard_error && standard_error < 0.1);
    }
    // a difference of a deterministic number is certain, and of the first order here
    let row = report.row("endpoint", 160).unwrap();
    assert_eq!(row.weak_errors[0].standard_error, 0.0);
    assert!(row.weak_errors[0].value.abs() <= row.error.unwrap().value);
}

/// The limit that was found is the lowest that serves.
#[test]
fn iterations_are_those_of_the_steps() {
    let system = Pendulum { g: 9.8 };
    let midpoint = Integrator::new(system.clone(), Midpoint);
    let mut state = State::new([1.0], [0.0]);
    let prepared = midpoint.prepare(0.1).unwrap();
    let mut refused = 0;
    for _ in 0..40 {
        let found = midpoint.newton_iterations(&prepared, &state, 0.1, &[]);
        let found = found.unwrap();
        assert!((1..=4).contains(&found), "{found}");
        let limited = |max_iterations| {
            let newton = Newton {
                max_iterations,
                ..Newton::default()
            };
            let mut end = state;
            let limited = midpoint.with_limit(newton);
            limited.step(&mut end, 0.1, &[]).map(|()| end)
        };
        let mut end = state;
        midpoint.step(&mut end, 0.1, &[]).unwrap();
        assert_eq!(limited(found), Ok(end));
        let fewer = Newton {
            max_iterations: found - 1,
            ..Newton::default()
        };
        // the step itself would be followed from a smaller one
        let solver = Solver::new(&fewer);
        let increment =
            Variational::<Midpoint>::increment(&system, &prepared, &state, 0.1, &[], &solver);
        refused += u32::from(increment.is_err());
        state = end;
    }
    // from the second guess, a step may arrive with fewer
    assert!(refused > 20);
    let report = pendulum(4);
    let row = report.row("midpoint", 160).unwrap();
    let mean = row.newton_iterations.unwrap();
    assert!((1.0..=3.0).contains(&mean));
    assert_eq!(
        report.row("endpoint", 160).unwrap().newton_iterations,
        Some(0.0)
    );
    assert_eq!(report.row("Euler", 160).unwrap().newton_iterations, None);
}

trait WithLimit {
    fn with_limit(&self, newton: Newton) -> Self;
}

impl WithLimit for Integrator<Pendulum, Midpoint> {
    fn with_limit(&self, newton: Newton) -> Self {
        self.clone().with_newton(newton)
    }
}

/// The midpoint rule, where no increment is larger than a bound.
struct Timid(Integrator<Kubo, Midpoint>, f64);

impl Method for Timid {
    type System = Kubo;
    type Prepared = f64;

    fn system(&self) -> &Kubo {
        self.0.system()
    }

    fn prepare(&self, h: f64) -> Result<f64, StepError> {
        Ok(h)
    }

    fn step_prepared(
        &self,
        h: &f64,
        state: &mut StateOf<Kubo>,
        _: f64,
        dw: &IncrementsOf<Kubo>,
    ) -> Result<(), StepError> {
        if dw[0].abs() > self.1 {
            return Err(StepError::StepSize { h: dw[0] });
        }
        self.0.step(state, *h, dw)
    }
}

#[test]
fn failures_are_counted_and_the_rest_is_measured() {
    let midpoint = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let bound = 0.45;
    let (timid, hopeless) = (Timid(midpoint.clone(), bound), Timid(midpoint.clone(), 0.0));
    let report = kubo()
        .paths(100)
        .seed(3)
        .method("midpoint", &midpoint)
        .method("timid", &timid)
        .method("hopeless", &hopeless)
        .repeats(1)
        .run()
        .unwrap();
    for steps in [16, 64] {
        let fails = |path: &u64| {
            let fine = Recorded::record(Wiener::new(3).path(*path), 1.0 / 64.0, 1, 64).unwrap();
            let coarse = fine.coarsen(64 / steps).unwrap();
            (0..steps).any(|step| coarse.get(step).unwrap()[0].abs() > bound)
        };
        let expected = (0..100).filter(fails).count() as u64;
        println!("{expected} failures");
        let row = report.row("timid", steps).unwrap();
        assert_eq!(row.failures, expected);
        assert!(steps == 64 || (expected > 10 && expected < 90));
        let all = report.row("midpoint", steps).unwrap();
        assert!(row.error.is_some() && (row.error == all.error) == (expected == 0));
        assert!(all.timing.unwrap().ns_per_step > 0.0);
        let row = report.row("hopeless", steps).unwrap();
        assert_eq!((row.failures, row.error, row.timing), (100, None, None));
    }
    // two step sizes have one slope, which is no order; with failures at one of them there is not even that
    assert!(report.orders().is_empty());
    let slopes = report.not_asymptotic().iter();
    let slopes: Vec<(&str, usize)> = slopes.map(|m| (&*m.method, m.slopes.len())).collect();
    assert_eq!(slopes, [("midpoint", 1), ("timid", 0), ("hopeless", 0)]);
}

#[test]
fn a_study_is_a_function_of_its_settings() {
    let midpoint = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let study = |seed| {
        let study = kubo().paths(50).seed(seed).method("midpoint", &midpoint);
        study.run().unwrap()
    };
    assert_eq!(study(1), study(1));
    assert_ne!(study(1), study(2));
    assert_eq!(oscillator(), oscillator());
}

#[test]
fn records_are_read_back() {
    let records = oscillator().records();
    let mut file = Vec::new();
    write_csv(&mut file, &records).unwrap();
    assert_eq!(read_csv(&file[..]).unwrap(), records);
    assert_eq!(records[5].method, "endpoint");
    assert_eq!(records[5].h, Some(HORIZON / 64.0));
    assert!(records[5].energy_error.is_none() && records[5].source.starts_with("sve "));
}

#[test]
fn settings_that_make_no_sense_are_named() {
    let midpoint = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let good = || kubo().method("midpoint", &midpoint);
    let message = |study: Study<'_, Kubo>| study.run().unwrap_err().to_string();
    assert!(good().run().is_ok());
    assert!(message(kubo()).contains(".method("));
    assert!(message(Study::new("")).contains(".horizon("));
    assert!(message(good().steps([])).contains(".steps("));
    assert!(message(good().steps([12, 64])).starts_with("12 steps do not divide the 64"));
    assert!(message(good().steps([0])).starts_with("`steps` was given 0"));
    assert!(message(good().steps([8, 8])).contains("two of `8`"));
    assert!(message(good().paths(0)).starts_with("`paths` was given 0"));
    assert!(message(good().method("midpoint", &midpoint)).contains("two of `midpoint`"));
    assert!(message(good().fine(&midpoint, 0)).starts_with("`fine` was given 0"));
    let many = message(good().fine(&midpoint, 1 << 61));
    assert!(
        many.contains("2305843009213693952 times 64 steps"),
        "{many}"
    );
    // the same method made anew is the same; another one, other options, or smaller steps are not
    let again = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let own = message(good().fine(&again, 1));
    assert!(
        own.contains("is the method `midpoint` with the same 64 steps"),
        "{own}"
    );
    assert!(good().fine(&again, 2).run().is_ok());
    assert!(
        good()
            .fine(&Heun::new(Kubo { a: 1.0, sigma: 0.5 }), 1)
            .run()
            .is_ok()
    );
    let newton = Newton {
        max_iterations: 9,
        ..Newton::default()
    };
    assert!(good().fine(&again.with_newton(newton), 1).run().is_ok());
    for horizon in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = good().horizon(horizon).run().unwrap_err();
        assert!(matches!(error, StudyError::Horizon { .. }));
    }
    let short = |_: u64, _: usize| {
        (
            Recorded::new(0.1, [[0.0]]).unwrap(),
            State::new([0.0], [0.0]),
        )
    };
    assert!(message(good().exact_paths(short)).contains("wanted are 64 steps"));
    let hopeless = Timid(midpoint.clone(), 0.0);
    assert!(message(good().fine(&hopeless, 2)).starts_with("the reference of path 0 failed"));
    let undefined = |_: &Recorded| State::new([f64::NAN], [0.0]);
    assert!(message(good().exact(undefined)).starts_with("the reference of path 0 is not finite"));
}
