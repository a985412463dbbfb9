//! Scenes against the best loops by hand: `cargo bench -p sve-runtime --bench scenes`, or with a
//! title, or its beginning and `...`, after `--`.
//!
//! Each round runs all cases of a group one after the other, and the table has medians: of the time
//! of a site (or pair) and step, and of its ratio to the first case within a round. Times are those
//! of the processor for this thread, where the system tells them.
#![allow(unsafe_code)]

mod hand;
mod lists;
mod measure;
mod midpoint;
mod noise;
#[path = "../../tests/scene/scenes.rs"]
#[allow(dead_code)]
mod scenes;
#[cfg(target_arch = "x86_64")]
mod wide;

use std::hint::black_box;

use hand::dispatch;
use lists::{angles, bonds, grid, molecules};
use measure::{Case, compare};
use scenes::{Chain, Lattice};
use sve_runtime::__private::StepShear as Shear;
use sve_runtime::__private::scene::{Phase, Prepared, Row, Scene};
use sve_runtime::prelude::*;

const H: f64 = 0.02;

fn main() {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with('-'))
        .collect();
    let is_asked = |title: &str| {
        words.is_empty()
            || words.iter().any(|word| match word.strip_suffix("...") {
                Some(start) => title.starts_with(start),
                None => title == word,
            })
    };
    for n in [100, 1000, 10_000, 1_000_000] {
        chain(n, &is_asked);
    }
    for sides in [
        [1, 10, 10],
        [1, 100, 100],
        [1, 1000, 1000],
        [10, 10, 10],
        [22, 22, 22],
        [100, 100, 100],
    ] {
        lattice(sides, &is_asked);
    }
    for side in [4, 15, 69] {
        molecules(side, &is_asked);
        bonds(side, &is_asked);
        angles(side, &is_asked);
    }
    for n in [34, 334, 3334] {
        all_pairs(n, &is_asked);
    }
    for n in [100, 10_000, 1_000_000] {
        midpoint::chain(n, &is_asked);
        noise::chain(n, &is_asked);
    }
    for side in [10, 100, 1000] {
        midpoint::lattice(side, &is_asked);
    }
}

/// Returns the shears of the endpoint rule, or of the rule of Störmer and Verlet.
fn shears(is_verlet: bool) -> Vec<Shear> {
    let kick = |part: f64, at: f64| Shear::Kick {
        h: part * H,
        part,
        at: at * H,
    };
    if is_verlet {
        vec![
            kick(0.5, 0.0),
            Shear::Drift {
                h: H,
                friction: [0.0; 2],
                parts: [0.0; 2],
                at: [0.0; 2],
            },
            kick(0.5, 1.0),
        ]
    } else {
        vec![
            Shear::Drift {
                h: H,
                friction: [0.0; 2],
                parts: [0.0; 2],
                at: [0.0; 2],
            },
            kick(1.0, 1.0),
        ]
    }
}

/// A trajectory of a scene.
struct Path<'a, S: Scene> {
    scene: &'a S,
    prepared: Prepared,
    shears: Vec<Shear>,
    q: Vec<S::Row>,
    p: Vec<S::Row>,
}

impl<'a, S: Scene> Path<'a, S> {
    fn new(scene: &'a S, q: &[S::Row], is_verlet: bool) -> Self {
        Self {
            scene,
            prepared: Prepared::new(scene, q.len(), 0.0).expect("indices in range"),
            shears: shears(is_verlet),
            q: q.to_vec(),
            p: vec![S::Row::ZERO; q.len()],
        }
    }

    fn advance(&mut self, steps: u64) {
        let mut state = Phase {
            q: black_box(&mut self.q),
            p: &mut self.p,
        };
        let (mut made, mut t) = (0, 0.0);
        while made < steps {
            let mut draw = |step: u64, _: &mut [f64]| Some(step as f64);
            let (scene, shears) = (self.scene, &self.shears);
            let count = steps - made;
            made += (self.prepared)
                .block(scene, shears, &mut state, &mut t, &mut [], count, &mut draw)
                .max(1);
        }
    }

    fn step(&mut self) {
        let mut state = Phase {
            q: black_box(&mut self.q),
            p: &mut self.p,
        };
        let (scene, shears) = (self.scene, &self.shears);
        let made = self
            .prepared
            .step(scene, shears, &mut state, [0.0, H], &[], false);
        assert_eq!(made, Ok(()));
    }
}

/// Returns the number of steps of a call, with as many as a block has.
fn steps(n: usize) -> u64 {
    64 + (1 << 16) / (n as u64 + 1)
}

fn rows(q: &[f64]) -> &[[f64; 1]] {
    q.as_chunks().0
}

fn chain(n: usize, is_asked: &dyn Fn(&str) -> bool) {
    let scene = Chain {
        beta: 0.7,
        mass: 1.0,
    };
    let start: Vec<f64> = (0..n).map(|i| 0.3 * (0.01 * i as f64).sin()).collect();
    let (count, units) = (steps(n), steps(n) as f64 * n as f64);
    let state = || (start.clone(), vec![0.0; n]);
    let (mut a, mut b) = (state(), state());
    let mut endpoint = Path::new(&scene, rows(&start), false);
    let mut verlet = Path::new(&scene, rows(&start), true);
    let mut single = Path::new(&scene, rows(&start), false);
    let mut single_verlet = Path::new(&scene, rows(&start), true);
    let beta = 0.7;
    compare(
        &format!("chain of {n}"),
        is_asked,
        vec![
            (
                "by hand, in place",
                units,
                Box::new(|| {
                    for _ in 0..count {
                        let (q, p) = (black_box(&mut *a.0), &mut *a.1);
                        dispatch(hand::Chain { q, p, h: H, beta });
                    }
                }),
            ),
            (
                "by hand, two plain loops",
                units,
                Box::new(|| {
                    for _ in 0..count {
                        hand::plain_chain(black_box(&mut b.0), &mut b.1, H, beta);
                    }
                }),
            ),
            (
                "trajectory, endpoint",
                units,
                Box::new(|| endpoint.advance(count)),
            ),
            (
                "trajectory, Störmer–Verlet",
                units,
                Box::new(|| verlet.advance(count)),
            ),
            (
                "single steps, endpoint",
                units,
                Box::new(|| (0..count).for_each(|_| single.step())),
            ),
            (
                "single steps, Störmer–Verlet",
                units,
                Box::new(|| (0..count).for_each(|_| single_verlet.step())),
            ),
        ],
    );
}

fn lattice(sides: [usize; 3], is_asked: &dyn Fn(&str) -> bool) {
    let n = sides.iter().product();
    let start: Vec<f64> = (0..n).map(|i| (0.37 * i as f64).sin()).collect();
    let (count, units) = (steps(n), steps(n) as f64 * n as f64);
    let mut a = (start.clone(), vec![0.0; n]);
    let title = format!("lattice of {sides:?}");
    let by_hand: Case<'_> = (
        "by hand, rows in place",
        units,
        Box::new(move || {
            for _ in 0..count {
                let (q, p) = (black_box(&mut *a.0), &mut *a.1);
                dispatch(hand::Lattice { sides, q, p, h: H });
            }
        }),
    );
    if sides[0] == 1 {
        let scene = Lattice {
            sides: [sides[1], sides[2]],
            around: 0,
        };
        let mut path = Path::new(&scene, rows(&start), false);
        let mut single = Path::new(&scene, rows(&start), false);
        compare(
            &title,
            is_asked,
            vec![
                by_hand,
                (
                    "trajectory, endpoint",
                    units,
                    Box::new(|| path.advance(count)),
                ),
                (
                    "single steps, endpoint",
                    units,
                    Box::new(|| (0..count).for_each(|_| single.step())),
                ),
            ],
        );
    } else {
        let scene = Lattice { sides, around: 0 };
        let mut path = Path::new(&scene, rows(&start), false);
        compare(
            &title,
            is_asked,
            vec![
                by_hand,
                (
                    "trajectory, endpoint",
                    units,
                    Box::new(|| path.advance(count)),
                ),
            ],
        );
    }
}

/// Stars of equal masses.
struct Stars {
    softening: f64,
}

#[variational(stormer_verlet)]
impl Stars {
    fn lagrangian(&self, q: &[[f64; 3]], v: &[[f64; 3]]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * (v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]);
            for j in 0..i {
                let mut r2 = self.softening;
                for k in 0..3 {
                    let d = q[j][k] - q[i][k];
                    r2 += d * d;
                }
                l += 1.0 / r2.sqrt();
            }
        }
        l
    }
}

fn all_pairs(n: usize, is_asked: &dyn Fn(&str) -> bool) {
    let x = &grid(15)[..n];
    let (h, softening) = (H, 0.01);
    let pairs = 0.5 * n as f64 * (n - 1) as f64;
    let integrator = Integrator::new(Stars { softening }, StormerVerlet);
    let start = State::new(x.to_vec(), vec![[0.0; 3]; n]);
    let mut path = integrator.trajectory(start, h, NoNoise);
    let steps = if n > 1000 { 16 } else { 64 };
    let state = || {
        let arrays: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; n]);
        ([x.to_vec(), vec![[0.0; 3]; n], vec![[0.0; 3]; n]], arrays)
    };
    let ([mut q, mut p, mut f], mut arrays) = state();
    let mut cases: Vec<Case<'_>> = vec![
        (
            "by hand, blocks of 16",
            pairs,
            Box::new(move || {
                hand::verlet([black_box(&mut q), &mut p, &mut f], h, |x, f| {
                    dispatch(hand::AllPairs {
                        x,
                        f,
                        arrays: &mut arrays,
                        softening,
                    });
                });
            }),
        ),
        (
            "trajectory, Störmer–Verlet",
            pairs * steps as f64,
            Box::new(|| assert!(path.advance(steps).is_ok())),
        ),
    ];
    #[cfg(target_arch = "x86_64")]
    if wide::is_here() {
        let ([mut q, mut p, mut f], mut arrays) = state();
        let step = move || {
            hand::verlet([black_box(&mut q), &mut p, &mut f], h, |x, f| {
                wide::all_pairs(x, f, &mut arrays, softening);
            });
        };
        // the first case is what the others are compared with
        cases.insert(0, ("by hand, AVX-512", pairs, Box::new(step)));
    }
    compare(&format!("all pairs of {n} bodies"), is_asked, cases);
}
