//! Steps of linear systems against their closed forms, at random states, step sizes and increments.
//!
//! The closed forms are evaluated with twice the digits, so that only the step rounds. Bound: 2 ulp
//! of the largest of |q₀|, |p₀|, σ|ΔW|, |q₁| and |p₁|. A step rounds a few products and sums of at
//! most that size, half an ulp each. For Kubo the angle `x = ah + σΔW` is rounded as well, up to 1½
//! of its ulp: 2 ulp of the largest of |q₀| … |p₁| and 1 more of x times that.

use sve_models::double_double::Double;
use sve_models::models::{Kubo, Oscillator};
use sve_models::random::Random;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

const SAMPLES: usize = 20_000;

/// Unit in the last place of `x`.
fn ulp(x: f64) -> f64 {
    x.abs().next_up() - x.abs()
}

/// A sample in numbers with twice the digits.
struct Exact {
    q: Double,
    p: Double,
    h: Double,
    /// ΔW.
    dw: Double,
}

fn d(x: f64) -> Double {
    Double::from(x)
}

struct Sample {
    start: State<[f64; 1]>,
    h: f64,
    dw: f64,
}

/// Sizes vary over six decades for the state, four for the step.
fn sample(random: &mut Random) -> Sample {
    let mut size = |decades: f64| {
        let sign = if random.uniform(0.0, 1.0) < 0.5 {
            -1.0
        } else {
            1.0
        };
        sign * 10f64.powf(random.uniform(-decades, 0.0))
    };
    let (q, p) = (1e3 * size(6.0), 1e3 * size(6.0));
    let h = size(4.0).abs();
    let dw = size(4.0);
    Sample {
        start: State::new([q], [p]),
        h,
        dw,
    }
}

/// Compares steps of `integrator` with `expected(sample)`, within `bound(sample, largest of the
/// start and the end)`.
fn check<S, R>(
    integrator: &Integrator<S, R>,
    bound: impl Fn(&Sample, f64) -> f64,
    expected: impl Fn(Exact) -> [Double; 2],
) where
    S: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let mut random = Random::new(3);
    let mut worst: f64 = 0.0;
    for _ in 0..SAMPLES {
        let sample = sample(&mut random);
        let Sample { start, h, dw } = &sample;
        let mut state = *start;
        integrator.step(&mut state, *h, &[*dw]).unwrap();
        let [q, p] = expected(Exact {
            q: d(start.q[0]),
            p: d(start.p[0]),
            h: d(*h),
            dw: d(*dw),
        })
        .map(Double::nearest);
        let size = [start.q[0], start.p[0], q, p]
            .iter()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let bound = bound(&sample, size);
        for (got, expected) in [(state.q[0], q), (state.p[0], p)] {
            let error = (got - expected).abs();
            worst = worst.max(error / bound);
            assert!(
                error <= bound,
                "{start:?} h = {h:e} dw = {dw:e}: {got:e} {expected:e}, bound {bound:e}"
            );
        }
        assert_eq!(state.t, *h);
    }
    println!("{}: {worst} of the bound", integrator.plan().rule);
}

const SIGMA: f64 = 0.7;

fn two_ulp(sample: &Sample, size: f64) -> f64 {
    2.0 * ulp(size.max(SIGMA * sample.dw.abs()))
}

#[test]
fn oscillator_by_initial_point() {
    let oscillator = Integrator::new(Oscillator { sigma: SIGMA }, InitialPoint);
    check(&oscillator, two_ulp, |Exact { q, p, h, dw }| {
        let p1 = p - h * q + d(SIGMA) * dw;
        [q + h * p1, p1]
    });
}

#[test]
fn oscillator_by_endpoint() {
    let oscillator = Integrator::new(Oscillator { sigma: SIGMA }, Endpoint);
    check(&oscillator, two_ulp, |Exact { q, p, h, dw }| {
        let q1 = q + h * p;
        [q1, p - h * q1 + d(SIGMA) * dw]
    });
}

/// The solution of the two equations of the midpoint rule: with `D = 1 + h²/4`,
/// `D (q₁ − q₀) = h (p₀ − h q₀/2 + σΔW/2)` and `D (p₁ − p₀) = σΔW − h (q₀ + h p₀/2)`.
#[test]
fn oscillator_by_midpoint() {
    let oscillator = Integrator::new(Oscillator { sigma: SIGMA }, Midpoint);
    check(&oscillator, two_ulp, |Exact { q, p, h, dw }| {
        let (half, kick) = (d(0.5) * h, d(SIGMA) * dw);
        let determinant = d(1.0) + half * half;
        [
            q + h * (p - half * q + d(0.5) * kick) / determinant,
            p + (kick - h * (q + half * p)) / determinant,
        ]
    });
}

/// With `x = ah + σΔW` and `D = 1 + x²/4`: `D (q₁ − q₀) = x (p₀ − x q₀/2)`,
/// `D (p₁ − p₀) = −x (q₀ + x p₀/2)`.
#[test]
fn kubo_by_midpoint() {
    let a = 1.3;
    let kubo = Integrator::new(Kubo { a, sigma: SIGMA }, Midpoint);
    let bound = |s: &Sample, size: f64| {
        let x = a * s.h + SIGMA * s.dw.abs();
        2.0 * ulp(size) + ulp(x * size)
    };
    check(&kubo, bound, |Exact { q, p, h, dw }| {
        let x = d(a) * h + d(SIGMA) * dw;
        let half = d(0.5) * x;
        let determinant = d(1.0) + half * half;
        [
            q + x * (p - half * q) / determinant,
            p - x * (q + half * p) / determinant,
        ]
    });
}
