//! An ensemble against a loop over trajectories.

use sve_runtime::baseline::Heun;
use sve_runtime::noise::ThreePoint;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System};
use sve_tests::models::{DoublePendulum, Kubo, Pendulum};

/// Two full blocks and a part of a third, whose last tile is partial as well.
const PATHS: u64 = 2 * 64 + 16 + 5;
const STEPS: u64 = 50;
const EVERY: u64 = 20;
const H: f64 = 0.01;

/// Lane steps may differ from scalar ones by rounding, which the motion does not amplify within 50 short steps.
const ROUNDING: f64 = 1e-12;

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING * (1.0 + b.abs())
}

fn check<I, S, const N: usize, const M: usize>(
    method: &I,
    start: State<[f64; N]>,
    noise: impl Fn(u64) -> Box<dyn Noise>,
    settings: impl for<'a> Fn(Ensemble<'a, I>) -> Ensemble<'a, I>,
) where
    I: Method<System = S> + Sync,
    S: System<Dims = Dims<N, M>>,
{
    let observable = |state: &State<[f64; N]>| state.q[0].mul_add(2.0, state.p[N - 1]) + state.t;
    let ensemble = settings(Ensemble::new(method))
        .paths(PATHS)
        .steps(H, STEPS)
        .record_every(EVERY)
        .start(start)
        .keep_final_states(true)
        .observe("mixture", |_, state| observable(state));
    let summary = ensemble.run().unwrap();
    assert!(summary.is_complete());
    assert_eq!((summary.paths(), summary.failed()), (PATHS, 0));

    let mut values = vec![Vec::new(); 4];
    for (k, (path, end)) in summary.final_states().enumerate() {
        assert_eq!(path, k as u64);
        let mut state = start;
        values[0].push(observable(&state));
        let trajectory = method.trajectory(start, H, noise(path));
        for (step, next) in (1..=STEPS).zip(trajectory) {
            state = next.unwrap();
            if step % EVERY == 0 || step == STEPS {
                values[step.div_ceil(EVERY) as usize].push(observable(&state));
            }
        }
        assert_eq!(end.t, state.t);
        for i in 0..N {
            assert!(close(end.q[i], state.q[i]), "{end:?} {state:?}");
            assert!(close(end.p[i], state.p[i]), "{end:?} {state:?}");
        }
    }
    let times: Vec<f64> = [0, 20, 40, 50]
        .map(|k| f64::from(k).mul_add(H, start.t))
        .to_vec();
    assert_eq!(summary.times(), times);
    for (record, values) in values.iter().enumerate() {
        two_pass(&summary, record, values);
    }
}

fn two_pass(summary: &Summary, record: usize, values: &[f64]) {
    let statistics = &summary["mixture"];
    let n = values.len() as f64;
    assert_eq!(statistics.counts()[record], PATHS);
    assert_eq!(values.len() as u64, PATHS);
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let of = |join: fn(f64, f64) -> f64| values.iter().copied().reduce(join).unwrap();
    for (shown, computed) in [
        (statistics.mean()[record], mean),
        (statistics.variance()[record], variance),
        (statistics.standard_error()[record], (variance / n).sqrt()),
        (statistics.standard_deviation()[record], variance.sqrt()),
        (statistics.min()[record], of(f64::min)),
        (statistics.max()[record], of(f64::max)),
    ] {
        assert!(close(shown, computed), "{record}: {shown} for {computed}");
    }
}

fn wiener(path: u64) -> Box<dyn Noise> {
    Box::new(Wiener::new(7).path(path))
}

#[test]
fn one_noise() {
    let method = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let start = State::at(0.3, [1.0], [0.2]);
    check(&method, start, wiener, |e| e.seed(7));
}

fn double_pendulum() -> DoublePendulum {
    DoublePendulum {
        m: [1.0, 0.7],
        l: [1.0, 0.8],
        g: 9.8,
        s: 0.4,
    }
}

#[test]
fn two_noises_and_newton() {
    let method = Integrator::new(double_pendulum(), Midpoint);
    let start = State::new([0.5, -0.3], [0.1, 0.2]);
    check(&method, start, wiener, |e| e.seed(7));
}

#[test]
fn a_baseline() {
    let method = Heun::new(double_pendulum());
    let start = State::new([0.5, -0.3], [0.1, 0.2]);
    check(&method, start, wiener, |e| e.seed(7));
}

#[test]
fn no_processes() {
    let method = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    let start = State::new([0.5], [0.1]);
    check(&method, start, |_| Box::new(NoNoise), |e| e);
}

#[test]
fn noise_switched_off() {
    let method = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let start = State::new([0.5], [0.1]);
    check(&method, start, |_| Box::new(NoNoise), |e| e.no_noise());
}

#[test]
fn truncated_increments() {
    let method = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let start = State::new([0.5], [0.1]);
    // 149 paths of 50 steps have some twenty of them beyond 3 standard deviations
    let truncated = |path| -> Box<dyn Noise> {
        Box::new(Truncated::new(wiener(path)).deviations(3.0).unwrap())
    };
    check(&method, start, truncated, |e| e.seed(7).truncated(3.0));
}

#[test]
fn three_point_increments() {
    let method = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let start = State::new([0.5], [0.1]);
    let three_point = |path| -> Box<dyn Noise> { Box::new(ThreePoint::new(7).path(path)) };
    check(&method, start, three_point, |e| e.seed(7).three_point());
}
