//! Measured orders of convergence: one table of method, system and expected order.

use sve_runtime::baseline::{
    BackwardEulerMaruyama, EulerMaruyama, Heun, RungeKutta4, TaylorSeries2,
};
use sve_runtime::system::{Dims, System};
use sve_runtime::{Method, State};

use crate::models::{Damped, Kubo, Pendulum, Relativistic};
use crate::random::Random;

/// Slope of the least-squares line.
fn slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
}

fn deterministic_end<I>(method: &I, start: State<[f64; 1]>, steps: u32) -> [f64; 2]
where
    I: Method,
    I::System: System<Dims = Dims<1, 0>>,
{
    let mut state = start;
    for _ in 0..steps {
        method
            .step(&mut state, 1.0 / f64::from(steps), &[])
            .unwrap();
    }
    [state.q[0], state.p[0]]
}

fn deterministic_order<I>(method: &I, start: State<[f64; 1]>, exact: [f64; 2]) -> f64
where
    I: Method,
    I::System: System<Dims = Dims<1, 0>>,
{
    let (x, y): (Vec<_>, Vec<_>) = [32, 64, 128, 256]
        .into_iter()
        .map(|steps| {
            let z = deterministic_end(method, start, steps);
            let error = (z[0] - exact[0]).hypot(z[1] - exact[1]);
            (-f64::from(steps).ln(), error.ln())
        })
        .unzip();
    slope(&x, &y)
}

/// The reference: Runge–Kutta with a step 16 times smaller than the smallest, its error below
/// `1e-12`.
fn deterministic_table<S>(name: &str, system: S, start: State<[f64; 1]>)
where
    S: System<Dims = Dims<1, 0>> + Copy,
{
    let exact = deterministic_end(&RungeKutta4::new(system), start, 4096);
    let table = [
        (
            "RungeKutta4",
            deterministic_order(&RungeKutta4::new(system), start, exact),
            4.0,
        ),
        (
            "TaylorSeries2",
            deterministic_order(&TaylorSeries2::new(system), start, exact),
            2.0,
        ),
        (
            "Heun",
            deterministic_order(&Heun::new(system), start, exact),
            2.0,
        ),
        (
            "EulerMaruyama",
            deterministic_order(&EulerMaruyama::new(system), start, exact),
            1.0,
        ),
        (
            "BackwardEulerMaruyama",
            deterministic_order(&BackwardEulerMaruyama::new(system), start, exact),
            1.0,
        ),
    ];
    for (method, order, expected) in table {
        println!("{name:<14} {method:<22} order {order:.3}");
        // the next term of the error expansion is still felt at h = 1/32
        assert!(
            (order - expected).abs() < 0.1,
            "{name}, {method}: order {order}"
        );
    }
}

#[test]
fn deterministic_orders() {
    deterministic_table("pendulum", Pendulum { g: 9.8 }, State::new([1.0], [0.5]));
    let damped = Damped {
        c: 0.4,
        k: 5.0,
        b: 2.0,
    };
    deterministic_table("time-dependent", damped, State::at(0.3, [1.0], [0.5]));
    deterministic_table(
        "relativistic",
        Relativistic { k: 2.0 },
        State::new([0.5], [0.4]),
    );
}

#[test]
fn reference_is_the_exact_solution() {
    // c and k alone have q = e^{−ct/2}(cos ωt + (c/2ω) sin ωt), which no jet entered
    let damped = Damped {
        c: 0.4,
        k: 5.0,
        b: 0.0,
    };
    let z = deterministic_end(&RungeKutta4::new(damped), State::new([1.0], [0.0]), 4096);
    let w = (5.0_f64 - 0.04).sqrt();
    let q = (-0.2_f64).exp() * (w.cos() + 0.2 / w * w.sin());
    assert!((z[0] - q).abs() < 1e-12);
}

const FINEST: usize = 1024;
const STEPS: [usize; 5] = [64, 128, 256, 512, 1024];
const BATCHES: usize = 20;
const PATHS: usize = 100;

/// Mean and standard error over batches of the slope of the RMS error at T = 1 against the exact
/// rotation.
fn strong_order<I>(method: &I) -> (f64, f64)
where
    I: Method<System = Kubo>,
{
    let Kubo { a, sigma } = *method.system();
    let (q, p) = (1.0, 0.5);
    let x: Vec<f64> = STEPS.iter().map(|&n| -(n as f64).ln()).collect();
    let mut random = Random::new(2024);
    let slopes: Vec<f64> = (0..BATCHES)
        .map(|_| {
            let mut squares = [0.0; STEPS.len()];
            for _ in 0..PATHS {
                let scale = (1.0 / FINEST as f64).sqrt();
                let path: Vec<f64> = (0..FINEST).map(|_| scale * random.normal()).collect();
                let angle = a + sigma * path.iter().sum::<f64>();
                let (sin, cos) = angle.sin_cos();
                for (square, &steps) in squares.iter_mut().zip(&STEPS) {
                    let mut state = State::new([q], [p]);
                    for part in path.chunks(FINEST / steps) {
                        let dw = [part.iter().sum()];
                        method.step(&mut state, 1.0 / steps as f64, &dw).unwrap();
                    }
                    *square += (state.q[0] - (q * cos + p * sin)).powi(2)
                        + (state.p[0] - (p * cos - q * sin)).powi(2);
                }
            }
            let y: Vec<f64> = squares
                .iter()
                .map(|s| 0.5 * (s / PATHS as f64).ln())
                .collect();
            slope(&x, &y)
        })
        .collect();
    let n = BATCHES as f64;
    let mean = slopes.iter().sum::<f64>() / n;
    let variance = slopes.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[test]
fn strong_orders_on_kubo() {
    let kubo = Kubo { a: 1.0, sigma: 0.5 };
    let table = [
        ("Heun", strong_order(&Heun::new(kubo)), 1.0),
        (
            "EulerMaruyama",
            strong_order(&EulerMaruyama::new(kubo)),
            0.5,
        ),
        (
            "BackwardEulerMaruyama",
            strong_order(&BackwardEulerMaruyama::new(kubo)),
            0.5,
        ),
        (
            "EulerMaruyama, uncorrected",
            strong_order(&EulerMaruyama::new(kubo).uncorrected()),
            0.0,
        ),
        (
            "BackwardEulerMaruyama, uncorrected",
            strong_order(&BackwardEulerMaruyama::new(kubo).uncorrected()),
            0.0,
        ),
    ];
    for (method, (order, error), _) in table {
        println!("{method:<36} strong order {order:.3} ± {error:.3}");
    }
    for (method, (order, error), expected) in table {
        // four standard errors, and 0.06 for the next term of the error expansion over this range
        // of h
        assert!(
            (order - expected).abs() < 4.0 * error + 0.06 && error < 0.05,
            "{method}: strong order {order} ± {error}"
        );
    }
}
