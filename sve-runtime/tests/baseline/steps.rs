//! Single steps against the formulas, written out by hand.

use sve_runtime::baseline::{
    BackwardEulerMaruyama, EulerMaruyama, Heun, RungeKutta4, TaylorSeries2,
};
use sve_runtime::{Method, Newton, OneStepMethod, State};

use crate::models::{Damped, Kubo, Oscillator, Pendulum, Polar, Relativistic};

const H: f64 = 0.1;
const KUBO: Kubo = Kubo { a: 1.5, sigma: 0.8 };

fn after<I, const N: usize, const M: usize>(
    method: &I,
    mut state: State<[f64; N]>,
    h: f64,
    dw: [f64; M],
) -> State<[f64; N]>
where
    I: Method,
    I::System: sve_runtime::system::System<Dims = sve_runtime::system::Dims<N, M>>,
{
    method.step(&mut state, h, &dw).unwrap();
    state
}

#[track_caller]
fn assert_near<const N: usize>(state: &State<[f64; N]>, q: [f64; N], p: [f64; N], tolerance: f64) {
    for i in 0..N {
        assert!(
            (state.q[i] - q[i]).abs() <= tolerance,
            "{state:?}, q = {q:?}"
        );
        assert!(
            (state.p[i] - p[i]).abs() <= tolerance,
            "{state:?}, p = {p:?}"
        );
    }
}

#[test]
fn euler_maruyama_on_kubo() {
    let (q, p, h, dw) = (0.6, -0.3, 0.05, 0.11);
    let x = KUBO.a * h + KUBO.sigma * dw;
    let start = State::at(2.0, [q], [p]);
    let plain = after(&EulerMaruyama::new(KUBO).uncorrected(), start, h, [dw]);
    assert_near(&plain, [q + x * p], [p - x * q], 1e-15);
    assert_eq!(plain.t, 2.05);
    let c = -KUBO.sigma.powi(2) / 2.0 * h;
    let corrected = after(&EulerMaruyama::new(KUBO), start, h, [dw]);
    assert_near(&corrected, [q + x * p + c * q], [p - x * q + c * p], 1e-15);
}

#[test]
fn backward_euler_maruyama_on_kubo() {
    let (q, p, h, dw) = (0.6, -0.3, 0.05, 0.11);
    let y = KUBO.sigma * dw;
    for c in [0.0, -KUBO.sigma.powi(2) / 2.0 * h] {
        let method = BackwardEulerMaruyama::new(KUBO);
        let method = if c == 0.0 {
            method.uncorrected()
        } else {
            method
        };
        // q₁ − w p₁ = e, p₁ + w q₁ = f with w = a h
        let (e, f, w) = (q + y * p + c * q, p - y * q + c * p, KUBO.a * h);
        let det = 1.0 + w * w;
        let state = after(&method, State::new([q], [p]), h, [dw]);
        assert_near(&state, [(e + w * f) / det], [(f - w * e) / det], 1e-15);
    }
}

#[test]
fn heun_on_kubo() {
    let (q, p, h, dw) = (0.6, -0.3, 0.05, 0.11);
    let x = KUBO.a * h + KUBO.sigma * dw;
    let state = after(&Heun::new(KUBO), State::new([q], [p]), h, [dw]);
    let c = 1.0 - x * x / 2.0;
    assert_near(&state, [c * q + x * p], [c * p - x * q], 1e-15);
}

#[test]
fn backward_euler_solves_its_own_equation() {
    // z₁ − h f(t₁, z₁) − z₀ − n = 0, with f from the first-order form
    use sve_runtime::Mechanics;
    let (h, dw) = (0.1, [0.05, -0.2]);
    let polar = Polar {
        m: 1.3,
        k: 0.9,
        sigma: [0.4, 0.3],
    };
    let start = State::new([1.1, 0.4], [0.2, 0.8]);
    let end = after(&BackwardEulerMaruyama::new(polar), start, h, dw);
    let (f, n, c) = (
        polar.drift(&end).unwrap(),
        polar.noise(&start, &dw),
        polar.ito_correction(&start),
    );
    for i in 0..2 {
        let q = start.q[i] + h * (f.q[i] + c.q[i]) + n.q[i];
        let p = start.p[i] + h * (f.p[i] + c.p[i]) + n.p[i];
        assert!((end.q[i] - q).abs() < 1e-15 && (end.p[i] - p).abs() < 1e-15);
    }

    let damped = Damped {
        c: 0.4,
        k: 2.0,
        b: 0.7,
    };
    let start = State::at(0.5, [0.8], [0.1]);
    let end = after(&BackwardEulerMaruyama::new(damped), start, h, []);
    let f = damped.drift(&end).unwrap();
    assert!((end.q[0] - start.q[0] - h * f.q[0]).abs() < 1e-15);
    assert!((end.p[0] - start.p[0] - h * f.p[0]).abs() < 1e-15);

    let relativistic = Relativistic { k: 3.0 };
    let start = State::new([0.5, -0.3], [2.0, 0.7]);
    let end = after(&BackwardEulerMaruyama::new(relativistic), start, h, []);
    let f = relativistic.drift(&end).unwrap();
    for i in 0..2 {
        assert!((end.q[i] - start.q[i] - h * f.q[i]).abs() < 1e-15);
        assert!((end.p[i] - start.p[i] - h * f.p[i]).abs() < 1e-15);
    }
}

#[test]
fn deterministic_methods_on_a_linear_system() {
    // undamped: z₁ = Σ (h Ω)^k / k! z₀ up to the order of the method
    let damped = Damped {
        c: 0.0,
        k: 4.0,
        b: 0.0,
    };
    let (q, p, h) = (0.3, 0.9, 0.1);
    let (mut term, mut sum) = ([q, p], [q, p]);
    for k in 1..=4 {
        term = [
            h * term[1] / f64::from(k),
            -4.0 * h * term[0] / f64::from(k),
        ];
        sum = [sum[0] + term[0], sum[1] + term[1]];
        if k == 2 {
            let state = after(&TaylorSeries2::new(damped), State::new([q], [p]), h, []);
            assert_near(&state, [sum[0]], [sum[1]], 1e-15);
            let state = after(&Heun::new(damped), State::new([q], [p]), h, []);
            assert_near(&state, [sum[0]], [sum[1]], 1e-15);
        }
    }
    let state = after(&RungeKutta4::new(damped), State::new([q], [p]), h, []);
    assert_near(&state, [sum[0]], [sum[1]], 1e-15);
}

#[test]
fn taylor_series_gains_the_energy_that_the_paper_plots() {
    // pendulum, h = 0.1, from rest at q = 1: energy −5.295 → 45.3 at t = 200 → 471 at t = 2000
    use sve_runtime::Mechanics;
    let method = TaylorSeries2::new(Pendulum { g: 9.8 });
    let mut state = State::new([1.0], [0.0]);
    let mut energy = [0.0; 3];
    for step in 0..=20_000 {
        if let Some(at) = [0, 2_000, 20_000].iter().position(|&s| s == step) {
            energy[at] = method.system().hamiltonian(&state).unwrap();
        }
        method.step(&mut state, 0.1, &[]).unwrap();
    }
    assert!((energy[0] + 5.295).abs() < 5e-4, "{energy:?}");
    assert!((energy[1] - 45.3).abs() < 0.05, "{energy:?}");
    assert!((energy[2] - 471.0).abs() < 0.5, "{energy:?}");
}

#[test]
fn backward_euler_has_the_exact_jacobian() {
    // a wrong entry would still converge, but not quadratically
    let quick = Newton {
        max_iterations: 5,
        ..Newton::default()
    };
    let polar = Polar {
        m: 1.3,
        k: 0.9,
        sigma: [0.4, 0.3],
    };
    let start = State::new([1.1, 0.4], [0.2, 0.8]);
    after(
        &BackwardEulerMaruyama::new(polar).with_newton(quick),
        start,
        0.3,
        [0.05, -0.2],
    );
    let damped = Damped {
        c: 0.4,
        k: 2.0,
        b: 3.0,
    };
    // linear: one update, and one evaluation that confirms it
    let quick = Newton {
        max_iterations: 2,
        ..Newton::default()
    };
    let start = State::at(0.5, [0.8], [0.1]);
    after(
        &BackwardEulerMaruyama::new(damped).with_newton(quick),
        start,
        0.5,
        [],
    );
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
