//! Runs of the code written by hand: every function does a whole task. The functions of systems
//! return the mean of the observable at the end.

use std::hint::black_box;

use crate::hand::{self, Fill, Kubos, Oscillators, Pendulums, RECORD, Stream, Sums, W};
use crate::wide::{Kernel, Plain, dispatch};
use crate::words::{Words, Xoshiro};
use crate::{PATHS, STEPS};

/// Number of rows of four that stay in the first cache.
const ROWS: usize = 16;
/// Number of lanes of kernels that go through memory.
const WIDE: usize = 16;

/// Runs a kernel with contraction, or without it.
fn run<K: Kernel>(fused: bool, kernel: K) {
    if fused {
        dispatch(kernel);
    } else {
        dispatch(Plain(kernel));
    }
}

pub(crate) fn xoshiro_words() -> f64 {
    words(Xoshiro::new(1))
}

pub(crate) fn words(mut words: impl Words<WIDE>) -> f64 {
    let mut rows = vec![[[0_u64; WIDE]; 4]; ROWS];
    for _ in 0..PATHS * STEPS / (ROWS * 4 * WIDE) {
        dispatch(Fill(&mut words, black_box(&mut rows)));
    }
    rows[0][0][0] as f64
}

pub(crate) fn normals(fused: bool, mut words: impl Words<WIDE>) -> f64 {
    let mut rows = vec![[[0.0; WIDE]; 4]; ROWS];
    for _ in 0..PATHS * STEPS / (ROWS * 4 * WIDE) {
        run(fused, Fill(&mut words, black_box(&mut rows)));
    }
    rows[0][0][0]
}

pub(crate) fn xoshiro_normals(fused: bool) -> f64 {
    let (mut words, mut rows) = (Xoshiro::new(1), vec![[[0.0; W]; 2]; 4 * ROWS]);
    for _ in 0..PATHS * STEPS / (4 * ROWS * 2 * W) {
        run(fused, Stream(&mut words, black_box(&mut rows)));
    }
    rows[0][0][0]
}

/// Runs a task of all paths on the threads of the surrounding pool, each with its own seed. Returns
/// the mean.
fn on_all_threads(part: impl Fn(u64, usize) -> f64 + Sync) -> f64 {
    let threads = rayon::current_num_threads();
    let parts = rayon::broadcast(|context| part(context.index() as u64, PATHS / W / threads));
    parts.into_iter().sum::<f64>() / PATHS as f64
}

pub(crate) fn oscillators(fused: bool) -> f64 {
    on_all_threads(|seed, tiles| {
        let mut sums: Sums = vec![[0.0; 2]; STEPS / RECORD];
        let (h, sigma) = black_box((0.1, 1.0));
        run(
            fused,
            Oscillators {
                words: &mut Xoshiro::new(seed),
                tiles,
                h,
                sigma,
                sums: &mut sums,
            },
        );
        sums[STEPS / RECORD - 1][0]
    })
}

pub(crate) fn kubos(fused: bool) -> f64 {
    on_all_threads(|seed, tiles| {
        let mut sums: Sums = vec![[0.0; 2]; STEPS / RECORD];
        let (h, a, sigma) = black_box((0.1, 1.0, 1.0));
        run(
            fused,
            Kubos {
                words: &mut Xoshiro::new(seed),
                tiles,
                h,
                a,
                sigma,
                sums: &mut sums,
            },
        );
        sums[STEPS / RECORD - 1][0]
    })
}

pub(crate) fn pendulums(fused: bool) -> f64 {
    let (mut q, mut p) = hand::pendulum_starts(PATHS);
    let (h, g) = black_box((0.1, 9.8));
    run(
        fused,
        Pendulums {
            q: &mut q,
            p: &mut p,
            steps: STEPS,
            h,
            g,
        },
    );
    p.as_flattened().iter().sum::<f64>() / PATHS as f64
}
