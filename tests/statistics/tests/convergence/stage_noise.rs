//! Strong orders with stage noise: min(S, 3) where the noise is additive, otherwise 1, and 1.5 with
//! the option `weak2`. The reference is a finer step on the same path.

use sve_runtime::Rule;
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

macro_rules! systems {
    ($($(#[$doc:meta])* $name:ident, $q:ident, $v:ident, $lagrangian:expr, $gamma:expr;)*) => {$(
        $(#[$doc])*
        struct $name;

        #[variational(
            gauss(2, stage_noise),
            gauss(3, stage_noise),
            gauss(4, stage_noise),
            gauss(2, stage_noise, weak2),
            gauss(3, stage_noise, weak2)
        )]
        impl $name {
            fn lagrangian(&self, $q: f64, $v: f64) -> f64 {
                $lagrangian
            }
            #[gamma]
            fn push(&self, $q: f64) -> f64 {
                $gamma
            }
        }
    )*};
}

systems! {
    /// A pendulum that is pushed.
    Pendulum, q, v, 0.5 * v * v + 2.0 * q.cos(), 0.7 * q;
    /// A double well that is pushed.
    DoubleWell, q, v, 0.5 * v * v - 0.25 * (q * q - 1.0).powi(2), 0.7 * q;
    /// A pendulum with noise that depends on its place.
    Shaken, q, v, 0.5 * v * v + 2.0 * q.cos(), 0.7 * (2.0 * q).sin();
    /// The same with a mass that depends on its place.
    Heavy, q, v, 0.5 * (1.0 + 0.25 * q * q) * v * v + 2.0 * q.cos(), 0.7 * (2.0 * q).sin();
}

/// Paths that tell order 1 from 2 and from 3.
const FEW: u64 = 64;

/// Paths that tell order 1 from 1.5.
const MANY: u64 = 512;

/// Steps that are measured, in units of the fewest.
const STEPS: [usize; 4] = [1, 2, 4, 8];

/// Steps of the reference, in these units.
const FINE: usize = 64;

/// Slope of the RMS error at time 1 against the step, for numbers of paths and of fewest steps.
fn order<S, R, const K: usize>(method: &Integrator<S, R>, [paths, fewest]: [u64; 2]) -> f64
where
    S: System<Dims = Dims<1, 1>>,
    R: Rule<S::Itself>,
{
    let start = State::new([1.0], [0.2]);
    let end = |path: &Recorded| {
        let end = method.trajectory(start, path.h(), path).last();
        end.expect("a step").expect("a solution")
    };
    let finest = FINE * fewest as usize;
    let mut squares = [0.0; STEPS.len()];
    for number in 0..paths {
        let noise = Wiener::new(17).path(number);
        let fine = Recorded::record_stages(noise, 1.0 / finest as f64, 1, K, finest).unwrap();
        let exact = end(&fine);
        for (square, steps) in squares.iter_mut().zip(STEPS) {
            let found = end(&fine.coarsen(FINE / steps).unwrap());
            *square += (found.q[0] - exact.q[0]).powi(2) + (found.p[0] - exact.p[0]).powi(2);
        }
    }
    let first = squares[0] / squares[STEPS.len() - 1];
    0.5 * first.log2() / (STEPS.len() - 1) as f64
}

/// Checks the order that the plan states.
fn check<S, R, const K: usize>(system: S, rule: R, numbers: [u64; 2], bias: f64)
where
    S: System<Dims = Dims<1, 1>>,
    R: Rule<S::Itself>,
{
    let method = Integrator::new(system, rule);
    let plan = method.plan();
    let expected = match plan.strong_order {
        StrongOrder::One => 1.0,
        StrongOrder::OneAndAHalf => 1.5,
        StrongOrder::Two => 2.0,
        StrongOrder::TwoAndAHalf => 2.5,
        StrongOrder::Three => 3.0,
        other => panic!("{other:?}"),
    };
    let order = order::<S, R, K>(&method, numbers);
    println!(
        "{} by {}: {order:.3} for {expected}",
        plan.system, plan.rule
    );
    assert!(
        (order - expected).abs() < bias,
        "{} by {}: {order} for {expected}",
        plan.system,
        plan.rule
    );
}

#[test]
fn additive_noise_has_the_order_of_the_stages_up_to_three() {
    check::<_, _, 2>(Pendulum, StageNoise(Gauss::<2>), [FEW, 4], 0.15);
    check::<_, _, 3>(Pendulum, StageNoise(Gauss::<3>), [FEW, 4], 0.15);
    check::<_, _, 2>(DoubleWell, StageNoise(Gauss::<2>), [FEW, 4], 0.15);
    check::<_, _, 3>(DoubleWell, StageNoise(Gauss::<3>), [FEW, 4], 0.15);
    check::<_, _, 4>(DoubleWell, StageNoise(Gauss::<4>), [FEW, 4], 0.4);
}

#[test]
fn other_noise_has_order_one() {
    check::<_, _, 2>(Shaken, StageNoise(Gauss::<2>), [MANY, 32], 0.1);
    check::<_, _, 3>(Shaken, StageNoise(Gauss::<3>), [MANY, 32], 0.1);
    check::<_, _, 2>(Heavy, StageNoise(Gauss::<2>), [MANY, 32], 0.1);
}

#[test]
fn the_option_weak2_makes_it_one_and_a_half() {
    check::<_, _, 2>(Shaken, Weak2(StageNoise(Gauss::<2>)), [MANY, 32], 0.1);
    check::<_, _, 3>(Shaken, Weak2(StageNoise(Gauss::<3>)), [MANY, 32], 0.1);
    check::<_, _, 2>(Heavy, Weak2(StageNoise(Gauss::<2>)), [MANY, 32], 0.1);
    check::<_, _, 3>(Heavy, Weak2(StageNoise(Gauss::<3>)), [MANY, 32], 0.1);
}
