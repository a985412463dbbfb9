//! The midpoint rule beside the same iteration by hand: Chebyshev's, for the displacements. For a
//! chain with fixed ends, bounds come from the largest distance of neighbours; for the φ⁴ field on a
//! periodic lattice, from the largest magnitude of the field.

use std::hint::black_box;
use std::ops::Range;

use sve_runtime::__private::AnySystem;
use sve_runtime::__private::scene::{Scene, Scenes};
use sve_runtime::Rule;
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

struct Phi4 {
    side: usize,
}

#[variational(midpoint)]
impl Phi4 {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..self.side {
            for j in 0..self.side {
                let c = i * self.side + j;
                let right = i * self.side + (j + 1) % self.side;
                let below = (i + 1) % self.side * self.side + j;
                l += 0.5 * v[c] * v[c] - 0.25 * (q[c] * q[c] - 1.0).powi(2);
                l -= 0.5 * ((q[right] - q[c]).powi(2) + (q[below] - q[c]).powi(2));
            }
        }
        l
    }
}

/// A system whose forces read `S` nodes, the own one among them.
trait Model<const S: usize>: Copy {
    /// The number of zeros at each end of the nodes.
    const WALLS: usize;
    /// Returns the number of sites of a tile.
    fn tile(self) -> usize;
    /// Visits ranges of sites, with the first of the nodes of each kind that they read.
    fn visit(self, sites: Range<usize>, visit: impl FnMut(Range<usize>, [usize; S]));
    fn force(self, nodes: [f64; S]) -> f64;
    /// Returns bounds of the derivatives of −force, near nodes that move by up to `by`.
    fn bounds(self, nodes: &[f64], by: f64) -> [f64; 2];
}

#[derive(Clone, Copy)]
struct OfChain;

impl Model<3> for OfChain {
    const WALLS: usize = 1;

    fn tile(self) -> usize {
        1024
    }

    #[inline(always)]
    fn visit(self, sites: Range<usize>, mut visit: impl FnMut(Range<usize>, [usize; 3])) {
        let first = sites.start;
        visit(sites, [first, first + 1, first + 2]);
    }

    #[inline(always)]
    fn force(self, [a, b, c]: [f64; 3]) -> f64 {
        let (left, right) = (b - a, c - b);
        right + BETA * right * right * right - (left + BETA * left * left * left)
    }

    #[inline(always)]
    fn bounds(self, nodes: &[f64], by: f64) -> [f64; 2] {
        let stretches = nodes.windows(2).map(|x| (x[1] - x[0]).abs());
        let stretch = stretches.fold(0.0, f64::max) + by;
        [0.0, 4.0 * (1.0 + 3.0 * BETA * stretch * stretch)]
    }
}

/// A periodic square lattice with this side.
#[derive(Clone, Copy)]
struct OfLattice(usize);

impl Model<5> for OfLattice {
    const WALLS: usize = 0;

    fn tile(self) -> usize {
        self.0 * 1024usize.div_ceil(self.0)
    }

    #[inline(always)]
    fn visit(self, sites: Range<usize>, mut visit: impl FnMut(Range<usize>, [usize; 5])) {
        let Self(side) = self;
        for row in sites.step_by(side) {
            let (last, n) = (side - 1, side * side);
            let [up, down] = [(row + n - side) % n, (row + side) % n];
            visit(row..row + 1, [row, up, down, row + last, row + 1]);
            let inner = row + 1..row + last;
            visit(inner, [row + 1, up + 1, down + 1, row, row + 2]);
            let end = row + last;
            visit(end..end + 1, [end, up + last, down + last, end - 1, row]);
        }
    }

    #[inline(always)]
    fn force(self, [x, up, down, left, right]: [f64; 5]) -> f64 {
        x - x * x * x + (up - x) + (down - x) + (left - x) + (right - x)
    }

    #[inline(always)]
    fn bounds(self, nodes: &[f64], by: f64) -> [f64; 2] {
        let field = largest(nodes) + by;
        [-1.0, 3.0 * field * field + 7.0]
    }
}

/// The arrays of the iteration by hand.
struct Hand {
    q: Vec<f64>,
    p: Vec<f64>,
    d: Vec<f64>,
    update: Vec<f64>,
    nodes: [Vec<f64>; 2],
}

impl Hand {
    fn new<const S: usize, M: Model<S>>(_: M, q: &[f64], p: &[f64]) -> Self {
        let zeros = |count: usize| vec![0.0; count];
        Self {
            q: q.to_vec(),
            p: p.to_vec(),
            d: zeros(q.len()),
            update: zeros(q.len()),
            nodes: [0, 1].map(|_| zeros(q.len() + 2 * M::WALLS)),
        }
    }
}

struct Step<'a, M, const S: usize>(&'a mut Hand, M, f64);

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

/// Cuts slices to a length. Loops over indices, since functions of arrays are not always inlined.
#[inline(always)]
fn cut<const S: usize>(mut nodes: [&[f64]; S], n: usize) -> [&[f64]; S] {
    for k in 0..S {
        nodes[k] = &nodes[k][..n];
    }
    nodes
}

#[inline(always)]
fn at<const S: usize>(nodes: &[&[f64]; S], i: usize) -> [f64; S] {
    let mut row = [0.0; S];
    for k in 0..S {
        row[k] = nodes[k][i];
    }
    row
}

/// Updates the displacements. The slices are arguments, so that they are known not to overlap.
#[inline(always)]
fn relax<const S: usize>(
    nodes: [&[f64]; S],
    [q, p]: [&[f64]; 2],
    d: &mut [f64],
    update: &mut [f64],
    fresh: &mut [f64],
    [h, alpha, beta]: [f64; 3],
    force: impl Fn([f64; S]) -> f64,
) {
    let n = d.len();
    let nodes = cut(nodes, n);
    let (q, p, update, fresh) = (&q[..n], &p[..n], &mut update[..n], &mut fresh[..n]);
    for i in 0..n {
        let impulse = p[i] + 0.5 * h * force(at(&nodes, i));
        let change = beta * update[i] - alpha * (d[i] - h * impulse);
        d[i] += change;
        (update[i], fresh[i]) = (change, q[i] + 0.5 * d[i]);
    }
}

#[inline(always)]
fn kick<const S: usize>(
    nodes: [&[f64]; S],
    p: &mut [f64],
    h: f64,
    force: impl Fn([f64; S]) -> f64,
) {
    let n = p.len();
    let nodes = cut(nodes, n);
    for i in 0..n {
        p[i] += h * force(at(&nodes, i));
    }
}

impl<const S: usize, M: Model<S>> Kernel for Step<'_, M, S> {
    #[inline(always)]
    fn run(self) {
        let Self(hand, model, h) = self;
        let Hand {
            q,
            p,
            d,
            update,
            nodes: [old, new],
        } = hand;
        let (mut old, mut new, n) = (old, new, q.len());
        for i in 0..n {
            d[i] = h * p[i];
            old[M::WALLS + i] = q[i] + 0.5 * d[i];
            update[i] = 0.0;
        }
        let (guess, farthest) = (largest(d), largest(q));
        // over boxes around the displacements
        let bounds = model.bounds(old, 1.5 * guess);
        let [lower, upper] = bounds.map(|bound| 1.0 + 0.25 * h * h * bound);
        let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
        let ratio = (upper.sqrt() - lower.sqrt()) / (upper.sqrt() + lower.sqrt());
        let (mut alpha, mut rho, mut beta) = (1.0 / middle, half / middle, 0.0);
        loop {
            let (mut change, mut size) = (0.0f64, 0.0f64);
            for first in (0..n).step_by(model.tile()) {
                let tile = first..n.min(first + model.tile());
                model.visit(
                    tile.clone(),
                    #[inline(always)]
                    |at, reads| {
                        let read = reads.map(|first| &old[first..first + at.len()]);
                        let fresh = &mut new[M::WALLS + at.start..M::WALLS + at.end];
                        let (d, update) = (&mut d[at.clone()], &mut update[at.clone()]);
                        let of_site = [&q[at.clone()], &p[at]];
                        relax(
                            read,
                            of_site,
                            d,
                            update,
                            fresh,
                            [h, alpha, beta],
                            #[inline(always)]
                            |x| model.force(x),
                        );
                    },
                );
                change = change.max(largest(&update[tile.clone()]));
                size = size.max(largest(&d[tile]));
            }
            std::mem::swap(&mut old, &mut new);
            let error = change * ratio / (1.0 - ratio);
            let of_impulse = (size + guess) / (2.0 * (upper - 1.0));
            if error <= f64::EPSILON / 16.0 * farthest.max(size).min(of_impulse)
                || change <= f64::EPSILON * (size + guess)
            {
                break;
            }
            alpha = 2.0 / (2.0 * middle - half * rho);
            let next = 0.5 * half * alpha;
            (beta, rho) = (next * rho, next);
        }
        model.visit(
            0..n,
            #[inline(always)]
            |at, reads| {
                let read = reads.map(|first| &old[first..first + at.len()]);
                kick(
                    read,
                    &mut p[at],
                    h,
                    #[inline(always)]
                    |x| model.force(x),
                );
            },
        );
        for (q, d) in q.iter_mut().zip(d) {
            *q += *d;
        }
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
        let title = format!("midpoint, chain of {n}, h = {h}");
        let start = State::new(q.clone(), p.clone());
        measure(&title, is_asked, OfChain, Fput { beta: BETA }, start, h);
    }
}

/// Measures square lattices.
pub(crate) fn lattice(side: usize, is_asked: &dyn Fn(&str) -> bool) {
    let field = |at: f64| (0..side * side).map(move |i| 1.2 * (at * i as f64).sin());
    let start = State::new(field(0.37).collect(), field(0.83).collect());
    let title = format!("midpoint, lattice of {side} × {side}, h = 0.1");
    measure(&title, is_asked, OfLattice(side), Phi4 { side }, start, 0.1);
}

fn measure<S, const N: usize>(
    title: &str,
    is_asked: &dyn Fn(&str) -> bool,
    model: impl Model<N>,
    system: S,
    start: State<Vec<f64>>,
    h: f64,
) where
    Midpoint: Rule<S, Increments = [f64]>,
    S: AnySystem<Configuration = Vec<f64>, Kind = Scenes, Target = S, Stepped = S>,
    S: Scene<Row = [f64; 1]>,
{
    let mut hand = Hand::new(model, &start.q, &start.p);
    let integrator = Integrator::new(system, Midpoint);
    let mut path = integrator.trajectory(start, h, NoNoise);
    let end = path.advance(1).expect("a step");
    dispatch(Step(&mut hand, model, h));
    // both make the same step
    for (x, y) in (end.q.iter().zip(&hand.q)).chain(end.p.iter().zip(&hand.p)) {
        assert!((x - y).abs() < 1e-14, "{x} {y}");
    }
    let units = hand.q.len() as f64;
    compare(
        title,
        is_asked,
        vec![
            (
                "Chebyshev by hand",
                units,
                Box::new(|| dispatch(Step(black_box(&mut hand), model, h))),
            ),
            (
                "trajectory, midpoint",
                units,
                Box::new(|| assert!(path.advance(1).is_ok())),
            ),
        ],
    );
}
