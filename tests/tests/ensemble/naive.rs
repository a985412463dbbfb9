//! An ensemble against a loop over trajectories.

use sve_models::checks::assert_relative;
use sve_models::models::{DoublePendulum, Pendulum};
use sve_models::orders::numbers;
use sve_runtime::baseline::Heun;
use sve_runtime::noise::ThreePoint;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::runs::kubo;

/// Two full blocks and a part of a third, whose last tile is partial as well.
const PATHS: u64 = 2 * 64 + 16 + 5;
const STEPS: u64 = 50;
const EVERY: u64 = 20;
const H: f64 = 0.01;

/// Lane steps may differ from scalar ones by rounding, which the motion does not amplify within 50
/// short steps.
const ROUNDING: f64 = 1e-12;

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
        .every(EVERY)
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
        let (found, expected) = ([end.q, end.p].concat(), numbers(&state));
        assert_relative(&found, &expected, ROUNDING, path);
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
        (statistics.mean(), mean),
        (&statistics.variance(), variance),
        (&statistics.standard_error(), (variance / n).sqrt()),
        (&statistics.standard_deviation(), variance.sqrt()),
        (statistics.min(), of(f64::min)),
        (statistics.max(), of(f64::max)),
    ] {
        assert_relative(&shown[record..=record], &[computed], ROUNDING, record);
    }
}

fn wiener(path: u64) -> Box<dyn Noise> {
    Box::new(Wiener::new(7).path(path))
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
fn noises_of_one_process() {
    let method = kubo();
    check(&method, State::at(0.3, [1.0], [0.2]), wiener, |e| e.seed(7));
    let check = |noise: &dyn Fn(u64) -> Box<dyn Noise>,
                 setting: &dyn for<'a> Fn(Ensemble<'a, _>) -> Ensemble<'a, _>| {
        check(&method, State::new([0.5], [0.1]), noise, setting);
    };
    check(&|_| Box::new(NoNoise), &|e| e.noise(NoNoise));
    // 149 paths of 50 steps have some twenty increments beyond 3 standard deviations
    check(
        &|path| Box::new(Truncated::new(wiener(path)).deviations(3.0).unwrap()),
        &|e| e.noise(Truncated::new(Wiener::new(7)).deviations(3.0).unwrap()),
    );
    check(&|path| Box::new(ThreePoint::new(7).path(path)), &|e| {
        e.noise(ThreePoint::new(7))
    });
    // a source with a path begins there
    check(&|path| wiener(path + 1000), &|e| {
        e.noise(Wiener::new(7).path(1000))
    });
}

/// The seed of random starts is that of the ensemble, without one that of the noise.
#[test]
fn seeds_of_noise_and_starts() {
    let method = kubo();
    let run = |settings: &dyn Fn(Ensemble<'_, _>) -> Summary| {
        let ensemble = Ensemble::new(&method)
            .paths(70)
            .steps(0.1, 5)
            .start(Starts::each(|_, rng| State::new([rng.normal()], [0.1])))
            .keep_final_states(true);
        settings(ensemble)
    };
    let both = run(&|e| e.seed(7).run().unwrap());
    assert_eq!(run(&|e| e.noise(Wiener::new(7)).run().unwrap()), both);
    let again = run(&|e| e.seed(7).noise(Wiener::new(7)).run().unwrap());
    assert_eq!(again, both);
    let ends = |summary: &Summary| -> Vec<f64> {
        summary.final_states().map(|(_, end)| end.q[0]).collect()
    };
    let other_starts = run(&|e| e.seed(8).noise(Wiener::new(7)).run().unwrap());
    let other_noise = run(&|e| e.seed(7).noise(Wiener::new(8)).run().unwrap());
    assert_ne!(ends(&other_starts), ends(&both));
    assert_ne!(ends(&other_noise), ends(&both));
    assert!(both.clone().merge(other_noise).is_err());
}
