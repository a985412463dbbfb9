//! Which solution a step of a Gauss rule takes: random steps against continuation that is apart
//! from the runtime.

mod continuation;

use sve_models::is_thorough;
use sve_models::random::Random;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use continuation::{Branch, Coefficients, Fields, Step};

/// Number of random steps, for all systems and rules together.
fn steps() -> usize {
    if is_thorough() { 1_000_000 } else { 10_000 }
}

/// `½v² + cos kq`, kicked.
#[derive(Clone, Copy, Debug)]
struct Waves {
    k: f64,
    gamma: f64,
}

#[variational(gauss(2), gauss(3), gauss(4), gauss(6))]
impl Waves {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + (self.k * q).cos()
    }
    #[gamma]
    fn kick(&self, q: f64) -> f64 {
        self.gamma * q.cos()
    }
}

#[derive(Clone, Copy, Debug)]
struct DoubleWell;

#[variational(gauss(2), gauss(3), gauss(4), gauss(6))]
impl DoubleWell {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.25 * (q * q - 1.0).powi(2)
    }
}

#[derive(Clone, Copy, Debug)]
struct DoublePendulum;

#[variational(gauss(2), gauss(3), gauss(4), gauss(6))]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + 2.0 * q[0].cos() + q[1].cos()
    }
}

/// A pendulum whose mass and length are noisy.
#[derive(Clone, Copy, Debug)]
struct Jittered;

#[variational(gauss(2), gauss(3), gauss(4), gauss(6))]
impl Jittered {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * p * p * (1.0 + 0.3 * q.sin()) + 0.4 * q * q
    }
}

/// Pendulums on a line, joined by springs: more coordinates than have bounds.
#[derive(Clone, Copy, Debug)]
struct Joined;

#[variational(gauss(2), gauss(3), gauss(4), gauss(6))]
impl Joined {
    fn lagrangian(&self, q: [f64; 5], v: [f64; 5]) -> f64 {
        let apart: f64 = (0..5).map(|i| 0.5 * v[i] * v[i] + q[i].cos()).sum();
        let springs: f64 = (0..4).map(|i| 0.25 * (q[i + 1] - q[i]).powi(2)).sum();
        apart - springs
    }
}

fn joined(z: &[f64]) -> Vec<Vec<f64>> {
    let force = |i: usize| {
        let left = if i > 0 { z[i - 1] - z[i] } else { 0.0 };
        let right = if i < 4 { z[i + 1] - z[i] } else { 0.0 };
        0.5 * (left + right) - z[i].sin()
    };
    vec![z[5..].iter().copied().chain((0..5).map(force)).collect()]
}

fn waves(k: f64, gamma: f64) -> impl Fn(&[f64]) -> Vec<Vec<f64>> {
    move |z| {
        let motion = vec![z[1], -k * (k * z[0]).sin()];
        vec![motion, vec![0.0, -gamma * z[0].sin()]]
    }
}

fn double_well(z: &[f64]) -> Vec<Vec<f64>> {
    vec![vec![z[1], -z[0] * (z[0] * z[0] - 1.0)]]
}

fn double_pendulum(z: &[f64]) -> Vec<Vec<f64>> {
    let (sin, cos) = (z[0] - z[1]).sin_cos();
    let determinant = 2.0 - cos * cos;
    let v = [
        (z[2] - cos * z[3]) / determinant,
        (2.0 * z[3] - cos * z[2]) / determinant,
    ];
    let coupling = v[0] * v[1] * sin;
    let forces = [-coupling - 2.0 * z[0].sin(), coupling - z[1].sin()];
    vec![vec![v[0], v[1], forces[0], forces[1]]]
}

fn jittered(z: &[f64]) -> Vec<Vec<f64>> {
    let (sin, cos) = z[0].sin_cos();
    let noise = vec![
        z[1] * (1.0 + 0.3 * sin),
        -0.15 * z[1] * z[1] * cos - 0.8 * z[0],
    ];
    vec![vec![z[1], -sin], noise]
}

/// The outcomes of some steps.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    /// Steps that took the connected solution.
    taken: usize,
    /// Steps that were refused where the path ends.
    ended: usize,
    /// Steps that were refused where the solution exists.
    refused: usize,
}

/// Steps from random states, within `size` of zero, with step sizes between `sizes`.
fn compare<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    (stages, fields): (usize, Fields<'_>),
    size: [f64; 2],
    sizes: [f64; 2],
    random: &mut Random,
    count: usize,
) -> Counts
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let rule = Coefficients::new(stages);
    let mut counts = Counts::default();
    for _ in 0..count {
        let (q, p) = (
            random.array::<N>(-size[0], size[0]),
            random.array::<N>(-size[1], size[1]),
        );
        let h = random.uniform(sizes[0].ln(), sizes[1].ln()).exp();
        let dw: [f64; M] =
            core::array::from_fn(|_| h.sqrt() * random.array::<3>(-1.0, 1.0).iter().sum::<f64>());
        let start = State::new(q, p);
        let mut state = start;
        let result = integrator.step(&mut state, h, &dw);
        let at = [&q[..], &p].concat();
        let step = Step {
            rule: &rule,
            fields,
            start: &at,
            h,
            dw: &dw,
        };
        let branch = step.follow();
        let what = || {
            format!(
                "{stages} stages, {start:?}, h = {h:?}, {dw:?}: {state:?} {result:?} {branch:?}"
            )
        };
        match (&result, &branch) {
            (Ok(()), Branch::State(end)) => {
                let found = [&state.q[..], &state.p].concat();
                let is_near = |(x, y): (&f64, &f64)| (x - y).abs() <= 1e-6 * (1.0 + y.abs());
                assert!(found.iter().zip(end).all(is_near), "{}", what());
                counts.taken += 1;
            }
            // both have strides of their own: within these of a fold either may be right
            (Ok(()), Branch::Ends([step, noise])) => {
                let is_last = if *noise > 0.0 { *noise } else { *step } > 0.999;
                let is_last = is_last && (*noise > 0.0 || M == 0);
                assert!(is_last, "{}", what());
            }
            (Err(_), Branch::Ends(_)) => counts.ended += 1,
            (Err(_), Branch::State(_)) => counts.refused += 1,
        }
        if result.is_err() {
            assert_eq!(state, start);
        }
    }
    counts
}

/// Compares all rules for a system; returns the counts.
macro_rules! all_rules {
    ($system:expr, $fields:expr, $size:expr, $sizes:expr) => {
        all_rules!($system, $fields, $size, $sizes, steps() / 24)
    };
    ($system:expr, $fields:expr, $size:expr, $sizes:expr, $count:expr) => {{
        let (mut random, count) = (Random::new(7), $count);
        let mut all = Counts::default();
        all_rules!(@ $system, $fields, $size, $sizes, random, count, all; 2, 3, 4, 6);
        all
    }};
    (@ $system:expr, $fields:expr, $size:expr, $sizes:expr, $random:ident, $count:ident, $all:ident; $($stages:literal),*) => {$(
        let integrator = Integrator::new($system, Gauss::<$stages>);
        let found = compare(&integrator, ($stages, &$fields), $size, $sizes, &mut $random, $count);
        $all.taken += found.taken;
        $all.ended += found.ended;
        $all.refused += found.refused;
    )*};
}

/// Checks that many solutions were compared, that paths ended, and that few solutions were refused.
fn check(counts: Counts) {
    let Counts {
        taken,
        ended,
        refused,
    } = counts;
    let all = taken + ended + refused;
    assert!(4 * taken > all && ended > 0, "{counts:?}");
    assert!(100 * refused <= all, "{counts:?}");
}

#[test]
fn random_steps_of_a_pendulum() {
    let pendulum = Waves { k: 1.0, gamma: 0.0 };
    check(all_rules!(
        pendulum,
        waves(1.0, 0.0),
        [3.2, 3.0],
        [0.3, 6.0]
    ));
}

#[test]
fn random_steps_between_short_waves() {
    let short = Waves { k: 3.0, gamma: 0.0 };
    check(all_rules!(short, waves(3.0, 0.0), [1.0, 2.0], [0.1, 3.0]));
}

#[test]
fn random_steps_in_a_double_well() {
    check(all_rules!(DoubleWell, double_well, [1.6, 1.5], [0.3, 4.0]));
}

#[test]
fn random_steps_of_a_double_pendulum() {
    check(all_rules!(
        DoublePendulum,
        double_pendulum,
        [3.0, 2.0],
        [0.1, 3.0]
    ));
}

#[test]
fn random_steps_of_joined_pendulums() {
    // continuation with differences of ten variables takes long
    check(all_rules!(
        Joined,
        joined,
        [3.2, 3.0],
        [0.5, 8.0],
        steps() / 400
    ));
}

#[test]
fn random_steps_with_noise() {
    let kicked = Waves {
        k: 1.0,
        gamma: 20.0,
    };
    check(all_rules!(
        kicked,
        waves(1.0, 20.0),
        [3.2, 1.0],
        [0.01, 1.0]
    ));
}

#[test]
fn random_steps_with_noise_of_momenta() {
    check(all_rules!(Jittered, jittered, [2.0, 2.0], [0.03, 3.0]));
}

/// Compares the second steps of trajectories, which start from the stages of the first ones.
fn compare_second_steps<S, R, const N: usize>(
    integrator: &Integrator<S, R>,
    (stages, fields): (usize, Fields<'_>),
    longest: f64,
) where
    S: Variational<R> + System<Dims = Dims<N, 0>>,
{
    let (rule, mut random, mut taken) = (Coefficients::new(stages), Random::new(3), 0);
    for _ in 0..steps() / 50 {
        let start = State::new(random.array(-1.6, 1.6), random.array(-1.5, 1.5));
        let h = random.uniform(0.2, longest);
        let path = integrator.trajectory(start, h, NoNoise).take(2);
        let Ok(path) = path.collect::<Result<Vec<_>, _>>() else {
            continue;
        };
        let [first, second] = [&path[0], &path[1]].map(|s| [&s.q[..], &s.p].concat());
        let step = Step {
            rule: &rule,
            fields,
            start: &first,
            h,
            dw: &[],
        };
        let what = || format!("{stages} stages, h = {h:?}, {first:?} {second:?}");
        let Branch::State(end) = step.follow() else {
            panic!("beyond the end: {}", what());
        };
        let is_near = |(x, y): (&f64, &f64)| (x - y).abs() <= 1e-6 * (1.0 + y.abs());
        assert!(second.iter().zip(&end).all(is_near), "{}", what());
        taken += 1;
    }
    assert!(taken > steps() / 100, "{taken}");
}

#[test]
fn second_steps_of_trajectories() {
    compare_second_steps(
        &Integrator::new(DoubleWell, Gauss::<4>),
        (4, &double_well),
        2.0,
    );
    compare_second_steps(
        &Integrator::new(DoublePendulum, Gauss::<6>),
        (6, &double_pendulum),
        1.5,
    );
}
