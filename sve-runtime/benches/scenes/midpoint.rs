//! The midpoint rule for a chain with fixed ends, beside the same iteration by hand: Chebyshev's,
//! for the displacements, with bounds from the largest and the smallest distance of neighbours.

use std::hint::black_box;

use sve_runtime::prelude::*;

use super::hand::{Kernel, dispatch};
use super::measure::compare;

const BETA: f64 = 0.7;

struct Fput {
    beta: f64,
}

#[variational(midpoint)]
impl Fput {
    fn spring(&self, d: f64) -> f64 {
        0.5 * d * d + 0.25 * self.beta * d.powi(4)
    }

    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = 0.0;
        for i in 0..n {
            l += 0.5 * v[i] * v[i];
        }
        for i in 1..n {
            l -= self.spring(q[i] - q[i - 1]);
        }
        l - self.spring(q[0]) - self.spring(q[n - 1])
    }
}

/// The arrays of the iteration by hand. Places and nodes have the walls at both ends.
struct Hand {
    q: Vec<f64>,
    p: Vec<f64>,
    d: Vec<f64>,
    update: Vec<f64>,
    nodes: [Vec<f64>; 2],
    sweeps: usize,
    steps: usize,
}

struct Step<'a>(&'a mut Hand, f64);

#[inline(always)]
fn force(a: f64, b: f64, c: f64) -> f64 {
    let (left, right) = (b - a, c - b);
    right + BETA * right * right * right - (left + BETA * left * left * left)
}

#[inline(always)]
fn largest(x: &[f64]) -> f64 {
    let mut parts = [0.0f64; 16];
    let (chunks, rest) = x.as_chunks::<16>();
    for chunk in chunks {
        for (part, x) in parts.iter_mut().zip(chunk) {
            *part = if x.abs() > *part { x.abs() } else { *part };
        }
    }
    let rest = rest.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    parts.into_iter().fold(rest, f64::max)
}

/// Updates the displacements. The slices are arguments, so that they are known not to overlap.
#[inline(always)]
fn relax(
    [nodes, q, p]: [&[f64]; 3],
    d: &mut [f64],
    update: &mut [f64],
    fresh: &mut [f64],
    h: f64,
    [alpha, beta]: [f64; 2],
) {
    let n = d.len();
    let (a, b, c) = (&nodes[..n], &nodes[1..=n], &nodes[2..n + 2]);
    let (q, p) = (&q[..n], &p[..n]);
    let (update, fresh) = (&mut update[..n], &mut fresh[..n]);
    for i in 0..n {
        let residual = d[i] - h * (p[i] + 0.5 * h * force(a[i], b[i], c[i]));
        let change = beta * update[i] - alpha * residual;
        d[i] += change;
        (update[i], fresh[i]) = (change, q[i] + 0.5 * d[i]);
    }
}

impl Kernel for Step<'_> {
    #[inline(always)]
    fn run(self) {
        const TILE: usize = 1024;
        let Self(hand, h) = self;
        let n = hand.d.len();
        let q = &mut hand.q[1..=n];
        for i in 0..n {
            hand.d[i] = h * hand.p[i];
            hand.nodes[0][1 + i] = q[i] + 0.5 * hand.d[i];
            hand.update[i] = 0.0;
        }
        let (guess, farthest) = (largest(&hand.d), largest(q));
        // distances over boxes around the displacements
        let stretch = |x: &[f64]| (x[1] - x[0]).abs();
        let stretches = hand.nodes[0].windows(2).map(stretch);
        let stretch = stretches.fold(0.0, f64::max) + 1.5 * guess;
        let upper = 0.25 * h * h * 4.0 * (1.0 + 3.0 * BETA * stretch * stretch);
        let (middle, half) = (1.0 + 0.5 * upper, 0.5 * upper);
        let ratio = ((1.0 + upper).sqrt() - 1.0) / ((1.0 + upper).sqrt() + 1.0);
        let (mut alpha, mut rho, mut beta) = (1.0 / middle, half / middle, 0.0);
        let [old, new] = &mut hand.nodes;
        let (mut old, mut new) = (old, new);
        loop {
            let (mut change, mut size) = (0.0f64, 0.0f64);
            for first in (0..n).step_by(TILE) {
                let end = n.min(first + TILE);
                let here = first..end;
                let d = &mut hand.d[here.clone()];
                let update = &mut hand.update[here.clone()];
                let read = [&old[first..end + 2], &q[here.clone()], &hand.p[here]];
                relax(read, d, update, &mut new[first + 1..=end], h, [alpha, beta]);
                change = change.max(largest(update));
                size = size.max(largest(d));
            }
            std::mem::swap(&mut old, &mut new);
            hand.sweeps += 1;
            let error = change * ratio / (1.0 - ratio);
            let of_impulse = (size + guess) / (2.0 * upper);
            if error <= f64::EPSILON / 16.0 * farthest.max(size).min(of_impulse)
                || change <= f64::EPSILON * (size + guess)
            {
                break;
            }
            alpha = 2.0 / (2.0 * middle - half * rho);
            let next = 0.5 * half * alpha;
            (beta, rho) = (next * rho, next);
        }
        for i in 0..n {
            hand.p[i] += h * force(old[i], old[1 + i], old[2 + i]);
            q[i] += hand.d[i];
        }
        hand.steps += 1;
    }
}

/// Measures chains of `n` masses, with steps from a small to a large part of the shortest period.
pub(crate) fn chain(n: usize, is_asked: &dyn Fn(&str) -> bool) {
    let amplitude = |i: usize| {
        let x = i as f64;
        [
            0.4 * ((0.37 * x).sin() + 0.3 * (1.9 * x).cos()),
            0.2 * (0.81 * x).cos(),
        ]
    };
    let [q, p] = [0, 1].map(|at| (0..n).map(|i| amplitude(i)[at]).collect::<Vec<f64>>());
    for h in [0.02, 0.1, 0.5] {
        let walls = |inner: &[f64]| [&[0.0][..], inner, &[0.0]].concat();
        let mut hand = Hand {
            q: walls(&q),
            p: p.clone(),
            d: vec![0.0; n],
            update: vec![0.0; n],
            nodes: [walls(&q), walls(&q)],
            sweeps: 0,
            steps: 0,
        };
        let integrator = Integrator::new(Fput { beta: BETA }, Midpoint);
        let mut path = integrator.trajectory(State::new(q.clone(), p.clone()), h, NoNoise);
        check(&mut hand, &integrator, h);
        let units = n as f64;
        compare(
            &format!("midpoint, chain of {n}, h = {h}"),
            is_asked,
            vec![
                (
                    "Chebyshev by hand",
                    units,
                    Box::new(|| dispatch(Step(black_box(&mut hand), h))),
                ),
                (
                    "trajectory, midpoint",
                    units,
                    Box::new(|| assert!(path.advance(1).is_ok())),
                ),
            ],
        );
    }
}

/// Checks that both make the same step.
fn check(hand: &mut Hand, integrator: &Integrator<Fput, Midpoint>, h: f64) {
    let n = hand.d.len();
    let mut state = State::new(hand.q[1..=n].to_vec(), hand.p.clone());
    integrator.step(&mut state, h, &[]).expect("a step");
    dispatch(Step(hand, h));
    for (x, y) in (state.q.iter().zip(&hand.q[1..])).chain(state.p.iter().zip(&hand.p)) {
        assert!((x - y).abs() < 1e-14, "{x} {y}");
    }
}
