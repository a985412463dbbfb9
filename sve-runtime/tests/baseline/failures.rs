//! Steps that cannot be made: an error with numbers, and the state as it was.

use sve_runtime::baseline::{
    BackwardEulerMaruyama, EulerMaruyama, Heun, RungeKutta4, TaylorSeries2,
};
use sve_runtime::system::{Dims, System};
use sve_runtime::{Method, Newton, State, StepError};

use crate::models::{Kubo, Pendulum, Polar, Relativistic};

#[track_caller]
fn failure<I, const N: usize, const M: usize>(
    method: &I,
    state: State<[f64; N]>,
    h: f64,
    dw: [f64; M],
) -> StepError
where
    I: Method,
    I::System: System<Dims = Dims<N, M>>,
{
    let mut moved = state;
    let error = method.step(&mut moved, h, &dw).unwrap_err();
    // bits, because NaN ≠ NaN
    let bits = |s: &State<[f64; N]>| (s.t.to_bits(), s.q.map(f64::to_bits), s.p.map(f64::to_bits));
    assert_eq!(bits(&moved), bits(&state), "a failed step moved the state");
    error
}

#[track_caller]
fn named(error: StepError, name: &str) {
    match error {
        StepError::NonFiniteInput { what, .. } => assert_eq!(what, name),
        other => panic!("{other}"),
    }
}

/// Arguments that every method has to refuse.
fn refusals<I, const N: usize, const M: usize>(method: &I, good: State<[f64; N]>)
where
    I: Method,
    I::System: System<Dims = Dims<N, M>>,
{
    for h in [0.0, -0.0, f64::NAN, f64::INFINITY] {
        let error = failure(method, good, h, [0.0; M]);
        assert!(matches!(error, StepError::StepSize { .. }), "{error}");
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut state = good;
        state.q[N - 1] = bad;
        named(
            failure(method, state, 0.1, [0.0; M]),
            &format!("q[{}]", N - 1),
        );
        let mut state = good;
        state.p[0] = bad;
        named(failure(method, state, 0.1, [0.0; M]), "p[0]");
        let mut state = good;
        state.t = bad;
        named(failure(method, state, 0.1, [0.0; M]), "t");
        if M > 0 {
            let mut dw = [0.0; M];
            dw[M - 1] = bad;
            named(failure(method, good, 0.1, dw), &format!("dw[{}]", M - 1));
        }
    }
}

#[test]
fn every_method_refuses_bad_input() {
    let kubo = Kubo { a: 1.0, sigma: 1.0 };
    let start = State::new([1.0], [0.5]);
    refusals::<_, 1, 1>(&EulerMaruyama::new(kubo), start);
    refusals::<_, 1, 1>(&EulerMaruyama::new(kubo).uncorrected(), start);
    refusals::<_, 1, 1>(&BackwardEulerMaruyama::new(kubo), start);
    refusals::<_, 1, 1>(&Heun::new(kubo), start);
    let polar = Polar {
        m: 1.0,
        k: 1.0,
        sigma: [0.1, 0.2],
    };
    let start = State::new([1.0, 0.3], [0.1, 1.0]);
    refusals::<_, 2, 2>(&EulerMaruyama::new(polar), start);
    refusals::<_, 2, 2>(&BackwardEulerMaruyama::new(polar), start);
    refusals::<_, 2, 2>(&Heun::new(polar), start);
    let relativistic = Relativistic { k: 1.0 };
    refusals::<_, 2, 0>(&BackwardEulerMaruyama::new(relativistic), start);
    refusals::<_, 2, 0>(&RungeKutta4::new(relativistic), start);
    refusals::<_, 2, 0>(&TaylorSeries2::new(relativistic), start);
    let pendulum = Pendulum { g: 9.8 };
    refusals::<_, 1, 0>(&RungeKutta4::new(pendulum), State::new([1.0], [0.0]));
    refusals::<_, 1, 0>(&TaylorSeries2::new(pendulum), State::new([1.0], [0.0]));
}

#[test]
fn an_overflow_is_an_error_of_the_step() {
    let kubo = Kubo { a: 1.0, sigma: 1.0 };
    let far = State::at(3.0, [1e308], [1e308]);
    let overflows = [
        failure(&EulerMaruyama::new(kubo), far, 10.0, [1.0]),
        failure(&BackwardEulerMaruyama::new(kubo), far, 10.0, [30.0]),
        failure(&Heun::new(kubo), far, 10.0, [1.0]),
    ];
    for error in overflows {
        match error {
            StepError::NonFiniteResult { t, h, q, p } => {
                assert_eq!((t, h), (3.0, 10.0));
                assert_eq!((q, p), (vec![1e308], vec![1e308]));
            }
            other => panic!("{other}"),
        }
    }
    let fast = State::new([0.0], [1e308]);
    let pendulum = Pendulum { g: 9.8 };
    for error in [
        failure(&RungeKutta4::new(pendulum), fast, 1e10, []),
        failure(&TaylorSeries2::new(pendulum), fast, 1e10, []),
    ] {
        assert!(
            matches!(error, StepError::NonFiniteResult { h: 1e10, .. }),
            "{error}"
        );
    }
}

#[test]
fn a_singular_mass_matrix_is_named() {
    let polar = Polar {
        m: 1.0,
        k: 0.0,
        sigma: [0.0; 2],
    };
    let origin = State::at(1.0, [0.0, 0.0], [1.0, 1.0]);
    for error in [
        failure(&EulerMaruyama::new(polar), origin, 0.1, [0.0; 2]),
        failure(&Heun::new(polar), origin, 0.1, [0.0; 2]),
        failure(&BackwardEulerMaruyama::new(polar), origin, 0.1, [0.0; 2]),
    ] {
        // the fields of H₁ = p_r p_θ / r are not defined there either, and come first where they
        // are used first
        assert!(
            matches!(
                error,
                StepError::SingularMass { h: 0.1, .. } | StepError::NonFiniteResult { .. }
            ),
            "{error}"
        );
    }
}

#[test]
fn the_iteration_limit_is_reported() {
    let method = BackwardEulerMaruyama::new(Pendulum { g: 9.8 }).with_newton(Newton {
        max_iterations: 1,
        ..Newton::default()
    });
    match failure(&method, State::at(0.5, [1.0], [0.3]), 0.2, []) {
        StepError::NotConverged {
            t,
            h,
            iterations,
            residual,
            tolerance,
        } => {
            assert_eq!((t, h, iterations), (0.5, 0.2, 1));
            assert!(residual > tolerance && residual < 0.1);
        }
        other => panic!("{other}"),
    }
}
