//! Studies of one path without noise: orders, invariants and iterations.

use sve_models::models::Pendulum;
use sve_runtime::__private::{BlockSolver, StepEquations};
use sve_runtime::baseline::{EulerMaruyama, RungeKutta4};
use sve_runtime::prelude::*;
use sve_runtime::study::{Estimate, Report, Study};

pub(super) fn pendulum(seconds: u32) -> Report {
    let system = Pendulum { g: 9.8 };
    let reference = RungeKutta4::new(system.clone());
    Study::new("pendulum")
        .start(State::new([1.0], [0.0]))
        .horizon(seconds.into())
        .step_counts([40, 80, 160, 320].map(|n| n * seconds as usize))
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
            // a whole period is in the shorter time; what is left of a period at the ends tilts the
            // line
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
    let coefficients = StepEquations::<Midpoint>::prepare(&system, 0.1);
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
        let solver = BlockSolver::new(&fewer);
        let increment = StepEquations::<Midpoint>::increment(
            &system,
            &coefficients,
            &mut (),
            &state,
            0.1,
            &[],
            &solver,
        );
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
