//! Checks of the code written by hand: it is compared with the library's functions and with plain
//! scalar steps.
//!
//! Every function panics if the results differ, since a limit by a wrong computation has no
//! meaning.

use std::array::from_fn;
use std::f64::consts::FRAC_PI_2;

use crate::hand::{self, Fill, Kubos, LONG, Oscillators, Pendulums, RECORD, Stream, W};
use crate::wide::dispatch;
use crate::words::{self, Words, Xoshiro};
use crate::{PATHS, STEPS, derived, limits, scalar};

/// Makes all checks.
pub(crate) fn all() {
    words::check();
    normals();
    moments("xoshiro256++", Xoshiro::<W>::new(3));
    stream();
    moments("Philox4x32-10", words::Philox { seed: 3, block: 0 });
    moments("Threefry4x64-13", words::Threefry { seed: 3, block: 0 });
    oscillators();
    kubos();
    pendulums();
    tasks();
}

/// Returns the pair of Box and Muller, computed with the functions of the standard library.
fn pair(radius: u64, angle: u64) -> [f64; 2] {
    let u = (radius as f64 + 0.5) / 18_446_744_073_709_551_616.0;
    let r = (-2.0 * u.ln()).sqrt();
    let fraction = ((angle << 2) >> 12) as f64 / 4_503_599_627_370_496.0 - 0.5;
    let (s, c) = (fraction * FRAC_PI_2).sin_cos();
    let [x, y] = [if angle >> 63 == 1 { -r * c } else { r * c }, r * s];
    if (angle >> 62) & 1 == 1 {
        [y, x]
    } else {
        [x, y]
    }
}

fn normals() {
    let mut words = Xoshiro::<1>::new(1);
    let ends = [[0, 0], [1, 1 << 61], [1 << 63, 1 << 62], [1 << 63, 3 << 62]];
    let random = (0..100_000).map(|_| [words.next(0), words.next(0)]);
    for [radius, angle] in ends.into_iter().chain(random) {
        let expected = pair(radius, angle);
        let r = expected[0].hypot(expected[1]);
        let z = hand::pair::<false>(radius, angle);
        for i in 0..2 {
            // Near u = 1 a rounding error of u, ε/2, becomes an error of r of ε/(2r).
            let allowed = 1e-14 * r + f64::EPSILON / r;
            assert!(
                (z[i] - expected[i]).abs() <= allowed,
                "{radius:#x} {angle:#x}: {z:?} for {expected:?}"
            );
        }
    }
}

/// Checks mean, variance and fourth moment of 10⁶ normals, within five standard errors.
fn moments<G: Words<W>>(name: &str, mut words: G) {
    let mut rows = vec![[[0.0; W]; 4]; 1_000_000 / (4 * W)];
    dispatch(Fill(&mut words, &mut rows));
    let count = (rows.len() * 4 * W) as f64;
    let mean = |power: i32| {
        let sum: f64 = rows.iter().flatten().flatten().map(|z| z.powi(power)).sum();
        sum / count
    };
    // Var zᵏ = E z²ᵏ − (E zᵏ)²
    for (power, expected, variance) in [(1, 0.0, 1.0_f64), (2, 1.0, 2.0), (4, 3.0, 96.0)] {
        let score = (mean(power) - expected) / (variance / count).sqrt();
        assert!(
            score.abs() < 5.0,
            "{name}: moment {power} is off by {score} standard errors"
        );
    }
}

/// Checks that the fused rows equal the results of [`hand::pair`].
fn stream() {
    let mut rows = [[[0.0; W]; 2]; 8];
    dispatch(Stream(&mut Xoshiro::new(7), &mut rows));
    let mut words = Xoshiro::<W>::new(7);
    for row in rows {
        for lane in 0..W {
            let (a, b) = (words.next(lane), words.next(lane));
            let expected = pair(a, b);
            for i in 0..2 {
                assert!(
                    (row[i][lane] - expected[i]).abs() < 1e-12,
                    "lane {lane}: {row:?}"
                );
            }
        }
    }
}

/// Steps every lane of one tile by a scalar step, with the same words. Returns the sums after
/// [`RECORD`] steps.
fn by_scalars(
    step: impl Fn(&mut [f64; 2], f64),
    observable: impl Fn(&[f64; 2]) -> f64,
) -> [f64; 2] {
    let mut words = Xoshiro::<W>::new(5);
    let mut states = [[1.0, 0.0]; W];
    for _ in 0..RECORD / 2 {
        for (lane, state) in states.iter_mut().enumerate() {
            let (a, b) = (words.next(lane), words.next(lane));
            for z in pair(a, b) {
                step(state, 0.1_f64.sqrt() * z);
            }
        }
    }
    let values = states.map(|state| observable(&state));
    [values.iter().sum(), values.iter().map(|x| x * x).sum()]
}

fn agree(name: &str, sums: [f64; 2], expected: [f64; 2]) {
    for i in 0..2 {
        // a hundred steps of a few roundings each; the maps do not amplify them
        let allowed = 1e-12 * (1.0 + expected[i].abs());
        assert!(
            (sums[i] - expected[i]).abs() <= allowed,
            "{name}: {sums:?} for {expected:?}"
        );
    }
}

fn oscillators() {
    let mut sums = vec![[0.0; 2]];
    let mut words = Xoshiro::new(5);
    dispatch(Oscillators {
        words: &mut words,
        tiles: 1,
        h: 0.1,
        sigma: 1.0,
        sums: &mut sums,
    });
    let expected = by_scalars(
        |z, dw| scalar::oscillator_endpoint(z, 0.1, 1.0, dw),
        |[q, p]| 0.5 * (q * q + p * p),
    );
    agree("oscillators", sums[0], expected);
}

fn kubos() {
    let mut sums = vec![[0.0; 2]];
    let mut words = Xoshiro::new(5);
    dispatch(Kubos {
        words: &mut words,
        tiles: 1,
        h: 0.1,
        a: 1.0,
        sigma: 1.0,
        sums: &mut sums,
    });
    let expected = by_scalars(
        |z, dw| scalar::kubo_cayley(z, 0.1, 1.0, 1.0, dw),
        |[q, _]| *q,
    );
    agree("Kubo oscillators", sums[0], expected);
}

fn pendulums() {
    let (h, g) = (0.1, 9.8);
    let (mut q, mut p) = hand::pendulum_starts(LONG);
    let starts: [[f64; 2]; LONG] = from_fn(|lane| [q[0][lane], p[0][lane]]);
    dispatch(Pendulums {
        q: &mut q,
        p: &mut p,
        steps: 100,
        h,
        g,
    });
    for (lane, mut z) in starts.into_iter().enumerate() {
        for _ in 0..100 {
            scalar::pendulum_naive(&mut z, h, g);
        }
        // Both iterations end within 1e-13; neighbouring orbits separate linearly, fastest near the
        // separatrix.
        let difference = (z[0] - q[0][lane]).abs().max((z[1] - p[0][lane]).abs());
        assert!(difference < 1e-9, "pendulum {lane}: off by {difference}");
    }
}

/// Checks that all sides of a task compute the same: their means agree.
fn tasks() {
    let near = |what: &str, mean: f64, expected: f64, allowed: f64| {
        assert!(
            (mean - expected).abs() <= allowed,
            "{what}: {mean} for {expected}"
        );
    };
    assert_eq!(STEPS, 1000, "the expectations below are those of t = 100");
    // The expected value follows from the recursion of the moments; an energy is distributed nearly
    // exponentially.
    let (energy, error) = (50.599_043_290_997_86, 50.6 / (PATHS as f64).sqrt());
    near(
        "oscillators",
        limits::oscillators(true),
        energy,
        5.0 * error,
    );
    near(
        "derived oscillators",
        derived::oscillators(),
        energy,
        5.0 * error,
    );
    // The phase is practically uniform.
    let error = (0.5 / PATHS as f64).sqrt();
    near("Kubo oscillators", limits::kubos(true), 0.0, 5.0 * error);
    near(
        "derived Kubo oscillators",
        derived::kubos(),
        0.0,
        5.0 * error,
    );
    // Without noise the means are equal up to rounding errors. These grow linearly, and for the
    // double pendulum hardly at all in t = 2.
    near(
        "pendulums",
        limits::pendulums(true),
        derived::pendulums(),
        1e-8,
    );
    let singly = derived::double_pendulums_singly();
    near(
        "double pendulums",
        derived::double_pendulums(),
        singly,
        1e-10,
    );
    // a sum of STEPS increments of variance 0.1
    let error = (0.1 * (STEPS * PATHS) as f64).sqrt() / PATHS as f64;
    near("walks", derived::walks(), 0.0, 5.0 * error);
}
