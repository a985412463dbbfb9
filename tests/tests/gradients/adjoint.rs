//! The gradient of a loss by the discrete adjoint: against products of the tangent maps of the
//! steps, and against differences.

use std::cell::RefCell;

use sve_models::case::{Case, LossGradient};
use sve_models::differences::derivative;
use sve_models::functions::Point;
use sve_models::models::Kubo;
use sve_models::oracle::{cases, kubo};
use sve_models::random::Random;
use sve_runtime::noise::{Noise, NoiseError, Replayable};
use sve_runtime::prelude::*;
use sve_runtime::{Dual, Rule, Tangent};

const H: f64 = 0.05;
const STEPS: u64 = 6;

/// Some hundred operations on numbers of the size of the largest one on the way.
const ROUNDING: f64 = 1e-13;

/// A loss of the end and of the state in the middle.
fn loss(number: u64, q: &[Dual], p: &[Dual]) -> Option<Dual> {
    let weight = match number {
        3 => 0.5,
        STEPS => 1.0,
        _ => return None,
    };
    let terms = q.iter().zip(p).zip(1..);
    Some(
        weight
            * terms
                .map(|((&q, &p), i)| f64::from(i) * q + q * p)
                .sum::<Dual>(),
    )
}

/// The derivatives of the loss by (q, p).
fn loss_by_state(number: u64, state: &Point) -> Vec<f64> {
    let weight = if number == STEPS { 1.0 } else { 0.5 };
    let by_q = state.p.iter().zip(1..).map(|(p, i)| f64::from(i) + p);
    by_q.chain(state.q.iter().copied())
        .map(|x| weight * x)
        .collect()
}

/// The gradient from the tangent maps and sensitivities of the steps, forwards. Returns the largest
/// term beside it.
fn forwards(case: &dyn Case, start: &Point, seed: u64) -> Result<(LossGradient, f64), StepError> {
    let (n, m) = case.dimensions();
    let size = 2 * n;
    let mut state = start.clone();
    let mut by_start: Vec<Vec<f64>> = (0..size)
        .map(|i| (0..size).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    let (mut by_parameters, mut largest): (Vec<Vec<f64>>, f64) = (Vec::new(), 1.0);
    let mut sum = LossGradient {
        loss: 0.0,
        start: vec![0.0; size],
        parameters: Vec::new(),
    };
    let mut noise = Wiener::new(seed);
    for number in 1..=STEPS {
        let mut dw = vec![0.0; m];
        noise.increments(number - 1, H, &mut dw).unwrap();
        let own = case.differentiated(&mut state, H, &dw)?;
        let image = |x: &Vec<f64>| -> Vec<f64> {
            let rows = own.tangent.iter();
            rows.map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum())
                .collect()
        };
        by_start = by_start.iter().map(image).collect();
        by_parameters.resize(own.sensitivity.len(), vec![0.0; size]);
        by_parameters = by_parameters.iter().map(image).collect();
        for (total, (_, own)) in by_parameters.iter_mut().zip(&own.sensitivity) {
            total.iter_mut().zip(own).for_each(|(x, y)| *x += y);
        }
        let entries = own.tangent.iter().chain(&by_start).chain(&by_parameters);
        largest = entries.flatten().fold(largest, |m, x| m.max(x.abs()));
        sum.parameters.resize(by_parameters.len(), 0.0);
        if number == 3 || number == STEPS {
            let slopes = loss_by_state(number, &state);
            let along = |x: &Vec<f64>| x.iter().zip(&slopes).map(|(a, b)| a * b).sum::<f64>();
            let terms = state.q.iter().zip(&state.p).zip(1..);
            let value: f64 = terms.map(|((q, p), i)| f64::from(i) * q + q * p).sum();
            sum.loss += if number == STEPS { value } else { 0.5 * value };
            let all = sum.start.iter_mut().zip(&by_start);
            all.chain(sum.parameters.iter_mut().zip(&by_parameters))
                .for_each(|(total, vector)| *total += along(vector));
        }
    }
    let size = state.size();
    Ok((sum, largest * size * size))
}

/// All rules of all models: the adjoint is the transpose of the forward derivatives.
#[test]
fn adjoints_are_transposed_tangent_maps() {
    let mut random = Random::new(5);
    let mut compared = 0;
    for case in cases() {
        let start = case.model().point(&mut random);
        let Ok((expected, largest)) = forwards(&*case, &start, 3) else {
            continue;
        };
        let found = case.gradient(&start, H, [STEPS, 2], 3, &loss).unwrap();
        let both = [(&found, &expected)].into_iter();
        let numbers = both.flat_map(|(a, b)| {
            let start = a.start.iter().zip(&b.start);
            let all = start.chain(a.parameters.iter().zip(&b.parameters));
            all.chain(std::iter::once((&a.loss, &b.loss)))
        });
        for (found, expected) in numbers {
            assert!(
                (found - expected).abs() <= ROUNDING * largest,
                "{}: {found:e} for {expected:e}, terms up to {largest:e}",
                case.name()
            );
        }
        assert_eq!(found.parameters.len(), expected.parameters.len());
        compared += 1;
    }
    // a random start of one or two models may lead out of their domain
    assert!(compared + 3 >= cases().len(), "{compared}");
}

/// A pendulum whose steps carry numbers: a force, or the stages from which the next step begins.
struct Carried {
    g: f64,
}

#[variational(midpoint, stormer_verlet, gauss(3))]
impl Carried {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// The states of a gradient are those of the trajectory, with all numbers that it carries, and
/// states between checkpoints are computed again with the same bits.
#[test]
fn the_number_of_checkpoints_changes_no_bit() {
    fn check<R: Copy + Rule<Carried>>(rule: R, before: usize) {
        let steps = 100;
        let pendulum = Integrator::new(Carried { g: 1.3 }, rule);
        let path = || {
            let mut path = pendulum.trajectory(State::new([1.0], [0.5]), H, NoNoise);
            for state in path.by_ref().take(before) {
                state.unwrap();
            }
            path
        };
        let gradient = |checkpoints: Option<usize>| {
            let adjoint = path().adjoint(steps);
            let adjoint = match checkpoints {
                Some(states) => adjoint.checkpoints(states),
                None => adjoint,
            };
            let gradient = adjoint.gradient(|number, s| {
                (number % 7 == 1 || number == steps).then(|| s.q[0] * s.p[0] * s.parameter("g"))
            });
            gradient.unwrap()
        };
        let expected = gradient(None);
        // from the last state to the first, as the adjoint adds them
        let states: Vec<_> = path().take(steps as usize).map(Result::unwrap).collect();
        let read = (1..=steps).rev().filter(|k| k % 7 == 1 || *k == steps);
        let loss = read.fold(0.0, |sum, k| {
            let state = &states[k as usize - 1];
            state.q[0] * state.p[0] * 1.3 + sum
        });
        assert_eq!(expected.loss(), loss);
        for checkpoints in [0, 1, 2, 5, 14, 99, 1000] {
            assert_eq!(gradient(Some(checkpoints)), expected, "{checkpoints}");
        }
    }
    for before in [0, 5] {
        check(Midpoint, before);
        check(StormerVerlet, before);
        check(Gauss::<3>, before);
    }
}

/// Differences of a trajectory: a loss of many states that reads a parameter, from a later state of
/// a trajectory.
#[test]
fn gradients_are_differences_of_the_loss() {
    let steps = 40;
    let loss = |a: f64, sigma: f64, moved: f64| {
        let kubo = Integrator::new(Kubo { a, sigma }, Midpoint);
        let mut path = kubo.trajectory(State::new([1.0], [0.3]), H, Wiener::new(8));
        path.nth(9).unwrap().unwrap();
        let first = *path.state();
        let from = State::at(first.t, [first.q[0] + moved], first.p);
        let rest = kubo.trajectory(from, H, Wiener::new(8).from_step(10));
        let mut sum = a * from.q[0].powi(2);
        for (state, number) in rest.take(steps as usize).zip(1..) {
            let state = state.unwrap();
            if number % 4 == 0 {
                sum += a * state.q[0].powi(2) + state.p[0].exp();
            }
        }
        sum
    };
    let (a, sigma) = (1.3, 0.6);
    let kubo = Integrator::new(Kubo { a, sigma }, Midpoint);
    let mut path = kubo.trajectory(State::new([1.0], [0.3]), H, Wiener::new(8));
    path.nth(9).unwrap().unwrap();
    let gradient = path
        .gradient(steps, |number, s| {
            let square = s.parameter("a") * s.q[0].powi(2);
            match number {
                0 => Some(square),
                _ => (number % 4 == 0).then(|| square + s.p[0].exp()),
            }
        })
        .unwrap();
    assert!((gradient.loss() - loss(a, sigma, 0.0)).abs() < 1e-13 * gradient.loss());
    let near = |found: f64, expected: f64, what: &str| {
        assert!(
            (found - expected).abs() < 1e-9 * (1.0 + expected.abs()),
            "{what}: {found} {expected}"
        );
    };
    let by_q = derivative(|d| loss(a, sigma, d));
    near(gradient.start().q[0], by_q, "q");
    // the parameters change the ten steps before the first state too, so these are left out
    let first = *{
        let mut path = kubo.trajectory(State::new([1.0], [0.3]), H, Wiener::new(8));
        path.nth(9).unwrap().unwrap();
        path
    }
    .state();
    let from_there = |a: f64, sigma: f64| {
        let kubo = Integrator::new(Kubo { a, sigma }, Midpoint);
        let path = kubo.trajectory(first, H, Wiener::new(8).from_step(10));
        let mut sum = a * first.q[0].powi(2);
        for (state, number) in path.take(steps as usize).zip(1..) {
            let state = state.unwrap();
            if number % 4 == 0 {
                sum += a * state.q[0].powi(2) + state.p[0].exp();
            }
        }
        sum
    };
    let by_a = derivative(|d| from_there(a + d, sigma));
    let by_sigma = derivative(|d| from_there(a, sigma + d));
    near(gradient.get("a").unwrap(), by_a, "a");
    near(gradient.get("sigma").unwrap(), by_sigma, "sigma");
    assert_eq!(gradient.get("b"), None);
}

/// Compositions, Gauss rules and rules with stage noise: the adjoint against the chain of tangent
/// maps.
#[test]
fn compositions_and_gauss_rules() {
    /// Checks an integrator of a system with one coordinate, one noise and the stages of a rule.
    macro_rules! check {
        ($system:expr, $rule:expr, $stages:expr) => {{
            let integrator = Integrator::new($system, $rule);
            let start = State::new([0.8], [0.4]);
            let path = integrator.trajectory(start, H, Wiener::new(4));
            let gradient = path.gradient(20, |k, s| (k == 20).then(|| s.q[0])).unwrap();
            let (mut state, mut tangent) = (start, Tangent::identity());
            let mut total = None;
            let mut noise = Wiener::new(4);
            for step in 0..20 {
                let mut dw = [0.0; $stages];
                match $stages {
                    1 => noise.increments(step, H, &mut dw).unwrap(),
                    stages => noise.stage_increments(step, H, stages, &mut dw).unwrap(),
                }
                let (own, sensitivity) = integrator
                    .step_with_derivatives(&mut state, H, &dw)
                    .unwrap();
                tangent = &own * &tangent;
                total = Some(match total.take() {
                    None => sensitivity,
                    Some(mut total) => {
                        sve_runtime::Sensitivity::advance(&mut total, &own, &sensitivity);
                        total
                    }
                });
            }
            let found = [gradient.start().q[0], gradient.start().p[0]];
            for (found, expected) in found.iter().zip(&tangent[0]) {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
            for (name, expected) in total.unwrap().iter() {
                let (found, expected) = (gradient.get(name).unwrap(), expected.q[0]);
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{name}: {found} {expected}"
                );
            }
        }};
    }
    check!(kubo(), Composed::new(Midpoint, KahanLi8), 1);
    check!(Swing { g: 2.0, s: 0.3 }, Split::new(BlanesMoan4), 1);
    check!(Swing { g: 2.0, s: 0.3 }, Gauss::<2>, 1);
    check!(Swing { g: 2.0, s: 0.3 }, Gauss::<4>, 1);
    check!(Swing { g: 2.0, s: 0.3 }, StageNoise(Gauss::<3>), 3);
}

/// A pendulum whose pivot is shaken.
pub(crate) struct Swing {
    pub(crate) g: f64,
    pub(crate) s: f64,
}

#[variational(initial_point, endpoint, gauss(2), gauss(4), gauss(3, stage_noise))]
impl Swing {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.s * q.sin()
    }
}

/// A step function of time: the pieces add up to the derivative by a constant, and each is that by
/// its value.
#[test]
fn pieces_are_derivatives_by_a_step_function() {
    let run = |values: [f64; 3]| {
        let mut state = State::new([0.8], [0.0]);
        for (piece, g) in values.into_iter().enumerate() {
            let swing = Integrator::new(Swing { g, s: 0.3 }, Endpoint);
            // pieces of 8, 8 and 4 steps
            let (first, steps) = (8 * piece as u64, if piece == 2 { 4 } else { 8 });
            let path = swing.trajectory(state, H, Wiener::new(2).from_step(first));
            state = path.take(steps).last().unwrap().unwrap();
        }
        state.q[0]
    };
    let swing = Integrator::new(Swing { g: 2.0, s: 0.3 }, Endpoint);
    let path = swing.trajectory(State::new([0.8], [0.0]), H, Wiener::new(2));
    let adjoint = path.adjoint(20).pieces_of(8);
    let gradient = adjoint.gradient(|k, s| (k == 20).then(|| s.q[0])).unwrap();
    let pieces: Vec<f64> = gradient.pieces("g").unwrap().collect();
    assert_eq!(pieces.len(), 3);
    for (piece, found) in pieces.iter().enumerate() {
        let expected = derivative(|d| {
            let mut values = [2.0; 3];
            values[piece] += d;
            run(values)
        });
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
    assert_eq!(gradient.get("g").unwrap(), pieces.iter().sum::<f64>());
}

#[test]
fn failures_are_errors() {
    let swing = Integrator::new(Swing { g: 2.0, s: 0.3 }, Endpoint);
    let start = State::new([0.8], [0.0]);
    let root = swing
        .trajectory(start, H, Wiener::new(2))
        .gradient(20, |_, s| Some((s.q[0] - 0.8).sqrt()));
    assert!(
        matches!(root, Err(StepError::NonFiniteLoss { .. })),
        "{root:?}"
    );
    let recorded = Recorded::new(H, [[0.1], [0.2]]).unwrap();
    let short = swing
        .trajectory(start, H, &recorded)
        .gradient(3, |k, s| (k == 3).then(|| s.q[0]));
    assert!(matches!(short, Err(StepError::Noise { .. })), "{short:?}");
    let stands = swing
        .trajectory(start, 0.0, NoNoise)
        .gradient(3, |_, s| Some(s.q[0]));
    assert!(
        matches!(stands, Err(StepError::StepSize { .. })),
        "{stands:?}"
    );
    // without steps the loss is that of the start
    let none = swing.trajectory(start, H, NoNoise);
    let none = none.gradient(0, |_, s| Some(s.q[0].powi(2))).unwrap();
    assert_eq!(none.loss(), 0.8 * 0.8);
    assert_eq!((none.start().q, none.start().p), ([1.6], [0.0]));
    assert_eq!(none.get("g"), Some(0.0));
}

/// A path that counts how often the increments of each step are drawn.
struct Counted<'a>(Wiener, &'a RefCell<Vec<u64>>);

impl Noise for Counted<'_> {
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.1.borrow_mut()[step as usize] += 1;
        self.0.increments(step, h, dw)
    }
}

impl Replayable for Counted<'_> {}

/// `c` states are enough for (c + r)!/(c! r!) steps that are made `r` + 1 times. By default each is
/// made twice, as long as its states fit into their memory.
#[test]
fn steps_are_made_as_often_as_documented() {
    let swing = Integrator::new(Swing { g: 2.0, s: 0.3 }, Endpoint);
    let most = |steps: u64, checkpoints: Option<usize>| {
        let counts = RefCell::new(vec![0; steps as usize]);
        let path = Counted(Wiener::new(2), &counts);
        let path = swing.trajectory(State::new([0.8], [0.0]), H, path);
        let adjoint = path.adjoint(steps);
        let adjoint = match checkpoints {
            Some(states) => adjoint.checkpoints(states),
            None => adjoint,
        };
        let gradient = adjoint.gradient(|k, s| (k == steps).then(|| s.q[0]));
        assert!(gradient.unwrap().loss().is_finite());
        // the derivatives of a step draw its increments once more
        counts.take().into_iter().max().unwrap() - 1
    };
    for (states, repetitions, steps) in [(1, 3, 4), (2, 2, 6), (3, 3, 20), (3, 4, 35), (5, 2, 21)] {
        let made = most(steps, Some(states));
        assert!(
            made <= repetitions + 1,
            "{steps} steps, {states} states: {made}"
        );
        let made = most(steps + 1, Some(states));
        assert!(made > repetitions, "{steps} steps, {states} states: {made}");
    }
    for steps in [1, 10, 100, 1000] {
        assert_eq!(most(steps, None), 1, "{steps}");
    }
    // without further states all steps begin at the first one
    assert_eq!(most(30, Some(0)), 29);
}
