//! Equations with several solutions: the step takes the solution that is connected with the
//! solution without noise, or returns an error.

use sve_models::models::{Actions, Pendulum};
use sve_models::random::Random;
use sve_runtime::__private::{LANES, StateLanes};
use sve_runtime::prelude::*;

use super::systems::Fourth;

/// The end of a solution branch that is followed from zero noise.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Branch {
    /// The solution at the full increments.
    Solution(f64),
    /// The branch ends at this fraction of the increments.
    Ends(f64),
}

/// Follows the root of `value(x, s) = 0` from `start` at s = 0 to s = 1 in small steps, which are
/// halved if the root moves fast. `slope` is the derivative by x, which is positive along the
/// branch.
fn follow(start: f64, value: impl Fn(f64, f64) -> f64, slope: impl Fn(f64, f64) -> f64) -> Branch {
    const LARGEST: f64 = 1.0 / 1024.0;
    let (mut x, mut s, mut stride) = (start, 0.0, LARGEST);
    while s < 1.0 {
        let mut y = x;
        for _ in 0..8 {
            y -= value(y, s + stride) / slope(y, s + stride);
        }
        // on a regular branch the root moves little in a step
        let is_near = (y - x).abs() <= 0.01 * (0.1 + x.abs());
        if is_near && slope(y, s + stride) > 0.0 {
            (x, s) = (y, s + stride);
            // powers of two, so that s ends at 1
            stride = if (s / (2.0 * stride)).fract() == 0.0 {
                (2.0 * stride).min(LARGEST)
            } else {
                stride
            };
        } else {
            stride *= 0.5;
            if stride < 1e-9 {
                return Branch::Ends(s);
            }
        }
    }
    Branch::Solution(x)
}

/// The momentum of the middle: `a x + b (x³ − βx²) = c`.
fn fourth(system: &Fourth, state: &State<[f64; 1]>, h: f64, dw: f64) -> Branch {
    let (a, b) = (1.0 + 0.25 * h * h, 0.25 * h * system.s * dw);
    let c = state.p[0] - 0.5 * h * state.q[0];
    let beta = system.beta;
    follow(
        c / a,
        |x, s| a * x + s * b * (x.powi(3) - beta * x * x) - c,
        |x, s| a + s * b * (3.0 * x * x - 2.0 * beta * x),
    )
}

/// Compares a step with the branch; counts solutions and ends.
fn compare(
    result: Result<f64, StepError>,
    expected: Branch,
    counts: &mut [u32; 2],
    what: &dyn Fn() -> String,
) {
    match (result, expected) {
        (Ok(found), Branch::Solution(x)) => {
            let error = (found - x).abs();
            assert!(error <= 1e-6 * (1.0 + x.abs()), "{found} {x} {}", what());
            counts[0] += 1;
        }
        (Err(StepError::BranchLost { reached, .. }), Branch::Ends(at)) => {
            assert!((reached - at).abs() < 0.01, "{reached} {at} {}", what());
            counts[1] += 1;
        }
        // the reference has its own step size: within it of the fold either may be right
        (Err(StepError::BranchLost { reached, .. }), Branch::Solution(_)) => {
            assert!(reached > 0.999, "{reached} {}", what());
        }
        (Ok(_), Branch::Ends(at)) => assert!(at > 0.999, "another branch: {at} {}", what()),
        (Err(error), _) => panic!("{error} {}", what()),
    }
}

fn cases(beta: f64, seed: u64) -> impl Iterator<Item = (Fourth, State<[f64; 1]>, f64, f64)> {
    let mut random = Random::new(seed);
    (0..1500).map(move |_| {
        let [q, p, h, dw] = random.array(-1.0, 1.0);
        let h = 0.5 * (h + 1.0) + 0.01;
        let state = State::new([2.0 * q], [3.0 * p]);
        // far more than a Wiener increment would be
        (Fourth { s: 1.0, beta }, state, h, 20.0 * dw)
    })
}

#[test]
fn noise_of_degree_four_in_p() {
    for (beta, seed) in [(0.0, 1), (1.0, 2), (4.0, 3)] {
        let mut counts = [0; 2];
        for (system, start, h, dw) in cases(beta, seed) {
            let expected = fourth(&system, &start, h, dw);
            let midpoint = Integrator::new(system, Midpoint);
            let mut state = start;
            let result = midpoint.step(&mut state, h, &[dw]);
            if result.is_err() {
                assert_eq!(state, start);
            }
            let middle = result.map(|()| 0.5 * (start.p[0] + state.p[0]));
            let what = || format!("beta = {beta}, {start:?}, h = {h}, dw = {dw}");
            compare(middle, expected, &mut counts, &what);
        }
        // both are met often
        assert!(counts.iter().all(|&n| n > 150), "{counts:?}");
    }
}

/// Lanes take the same branch, or leave the state to the single step.
#[test]
fn lanes_take_the_same_branch() {
    let mut done = 0;
    for beta in [0.0, 4.0] {
        let system = Fourth { s: 1.0, beta };
        let midpoint = Integrator::new(system.clone(), Midpoint);
        let all: Vec<_> = cases(beta, 4).collect();
        for chunk in all.chunks_exact(LANES) {
            let h = chunk[0].2;
            let prepared = OneStepMethod::prepare(&midpoint, h).unwrap();
            let mut states = StateLanes::splat(&chunk[0].1);
            let mut dw = [[0.0; LANES]; 1];
            for (lane, (_, state, _, w)) in chunk.iter().enumerate() {
                states.set(lane, state);
                dw[0][lane] = *w;
            }
            let before = states;
            let left = midpoint.step_lanes(&prepared, &before, &mut states, h, &dw);
            for (lane, (_, start, _, w)) in chunk.iter().enumerate() {
                if left >> lane & 1 == 1 {
                    assert_eq!(states.get(lane).q, start.q);
                    continue;
                }
                let middle = 0.5 * (start.p[0] + states.get(lane).p[0]);
                match fourth(&system, start, h, *w) {
                    Branch::Solution(x) => {
                        assert!((middle - x).abs() <= 1e-6 * (1.0 + x.abs()), "{middle} {x}");
                    }
                    Branch::Ends(at) => assert!(at > 0.999, "another branch: {at}"),
                }
                done += 1;
            }
        }
    }
    // the judge leaves most of these, with increments far beyond those of noise, to the single step
    assert!(done > 250, "{done}");
}

/// Two unknowns: H₁ = (σ₁I, σ₂I²) with I = (q² + p²)/2. The midpoint rule turns by an angle that
/// depends on the middle's I, which solves `I (1 + x²/4) = I₀` with `x = ah + σ₁ΔW₁ + 2σ₂IΔW₂`, a
/// cubic equation.
#[test]
fn several_unknowns() {
    let mut random = Random::new(5);
    let mut counts = [0; 2];
    for _ in 0..1000 {
        let [q, p, w1, w2] = random.array(-1.0, 1.0);
        let (h, dw) = (0.1, [40.0 * w1, 10.0 * w2]);
        let system = Actions {
            a: 1.0,
            sigma: [0.5, 0.5],
        };
        let [s1, s2] = system.sigma;
        let start = State::new([2.0 * q], [2.0 * p]);
        let action = 0.5 * (start.q[0].powi(2) + start.p[0].powi(2));
        let turn = |i: f64, s: f64| h + s * (s1 * dw[0] + 2.0 * s2 * i * dw[1]);
        let expected = follow(
            action / (1.0 + 0.25 * h * h),
            |i, s| i * (1.0 + 0.25 * turn(i, s).powi(2)) - action,
            |i, s| {
                let x = turn(i, s);
                1.0 + 0.25 * x * x + 0.5 * i * x * s * 2.0 * s2 * dw[1]
            },
        );
        let midpoint = Integrator::new(system, Midpoint);
        let mut state = start;
        let result = midpoint.step(&mut state, h, &dw);
        let middle = result.map(|()| {
            let (q, p) = (state.q[0] + start.q[0], state.p[0] + start.p[0]);
            0.125 * (q * q + p * p)
        });
        let what = || format!("{start:?}, dw = {dw:?}");
        compare(middle, expected, &mut counts, &what);
    }
    assert!(counts[0] > 150 && counts[1] > 5, "{counts:?}");
}

/// Steps of a pendulum so long that their equation has several solutions: what is taken is
/// connected with the explicit guess by a regular Jacobian. (With the limit h → 0 it need not be:
/// an h of several periods has passed the folds of shorter ones.)
#[test]
fn long_steps_take_the_branch_of_their_guess() {
    let midpoint = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
    let mut random = Random::new(6);
    let mut counts = [0; 2];
    for _ in 0..2000 {
        let [q, p, h] = random.array(-1.0, 1.0);
        let start = State::new([3.0 * q], [3.0 * p]);
        let h = 3.5 + 3.0 * h;
        // the equation v + (h/2) sin(q₀ + hv/2) = p₀ and its limit at v = p₀
        let slope = |v: f64| 1.0 + 0.25 * h * h * (start.q[0] + 0.5 * h * v).cos();
        let by_short_steps = follow(
            0.0,
            |y, s| 2.0 * y - s * h * (start.p[0] - 0.5 * s * h * (start.q[0] + y).sin()),
            |y, s| 2.0 + 0.5 * (s * h).powi(2) * (start.q[0] + y).cos(),
        );
        let mut state = start;
        match midpoint.step(&mut state, h, &[]) {
            Ok(()) => {
                let v = (state.q[0] - start.q[0]) / h;
                let part = |k: u32| start.p[0] + f64::from(k) / 500.0 * (v - start.p[0]);
                let regular = (0..=500).all(|k| slope(part(k)) > 0.0);
                let followed = match by_short_steps {
                    Branch::Solution(y) => (0.5 * h * v - y).abs() < 1e-6,
                    Branch::Ends(_) => false,
                };
                assert!(regular || followed, "{start:?} {h}: {v} {by_short_steps:?}");
                counts[0] += 1;
            }
            Err(error) => {
                let lost = matches!(by_short_steps, Branch::Ends(_));
                assert!(lost, "{error} {by_short_steps:?}");
                counts[1] += 1;
            }
        }
    }
    assert!(counts[0] > 1000 && counts[1] > 0, "{counts:?}");
}
