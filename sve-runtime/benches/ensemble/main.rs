//! Ensembles against what is written by hand for one system: `cargo bench -p sve-runtime --features ensemble --bench ensemble`.
//!
//! Prints a table: nanoseconds a normal or a trajectory-step, medians of runs that alternate between all sides of a task so that a
//! noisy machine hits them alike; the ratio to the limit, the first side of the task; and the ratio that is wanted.

mod check;
mod hand;
#[path = "../steps/hand.rs"]
#[allow(dead_code)] // has more steps than are compared here
mod scalar;
mod systems;
mod wide;
mod words;

use std::hint::black_box;
use std::thread;
use std::time::Instant;

use sve_runtime::prelude::*;

use hand::{Fill, Kubos, LONG, Oscillators, Pendulums, RECORD, Stream, Sums, W};
use systems::DoublePendulum;
use wide::dispatch;
use words::{Philox, Threefry, Words, Xoshiro};

/// Paths of a task.
const PATHS: usize = 1024;
/// Steps of a path.
const STEPS: usize = 2000;
/// Double pendulums, whose steps take a hundred times as long.
const DOUBLE: usize = 64;
/// Alternating runs of a task.
const ROUNDS: usize = 101;

/// One way of doing a task.
struct Side<'a> {
    name: &'static str,
    run: Box<dyn Fn() -> f64 + 'a>,
    /// Largest ratio to the limit that is wanted.
    wanted: Option<f64>,
}

/// What all sides do.
struct Task<'a> {
    name: &'static str,
    /// Normals or trajectory-steps of a run.
    count: usize,
    sides: Vec<Side<'a>>,
}

fn side<'a>(name: &'static str, run: impl Fn() -> f64 + 'a) -> Side<'a> {
    let run = Box::new(run);
    Side {
        name,
        run,
        wanted: None,
    }
}

/// Rows of four that stay in the first cache.
const ROWS: usize = 16;
/// Lanes of what goes through memory.
const WIDE: usize = 16;

fn random_words<G: Words<WIDE>>(words: G) -> f64 {
    let (mut words, mut rows) = (words, vec![[[0_u64; WIDE]; 4]; ROWS]);
    for _ in 0..PATHS * STEPS / (ROWS * 4 * WIDE) {
        dispatch(Fill(&mut words, black_box(&mut rows)));
    }
    rows[0][0][0] as f64
}

fn normals(words: impl Words<WIDE>) -> f64 {
    let (mut words, mut rows) = (words, vec![[[0.0; WIDE]; 4]; ROWS]);
    for _ in 0..PATHS * STEPS / (ROWS * 4 * WIDE) {
        dispatch(Fill(&mut words, black_box(&mut rows)));
    }
    rows[0][0][0]
}

fn stream() -> f64 {
    let (mut words, mut rows) = (Xoshiro::new(1), vec![[[0.0; W]; 2]; 4 * ROWS]);
    for _ in 0..PATHS * STEPS / (4 * ROWS * 2 * W) {
        dispatch(Stream(&mut words, black_box(&mut rows)));
    }
    rows[0][0][0]
}

fn noise() -> [Task<'static>; 2] {
    let (philox, threefry) = (Philox { seed: 1, block: 0 }, Threefry { seed: 1, block: 0 });
    [
        Task {
            name: "words",
            count: PATHS * STEPS,
            sides: vec![
                side("xoshiro256++", || random_words(Xoshiro::new(1))),
                side("Threefry4x64-13", move || random_words(threefry)),
                side("Philox4x32-10", move || random_words(philox)),
            ],
        },
        Task {
            name: "normals",
            count: PATHS * STEPS,
            sides: vec![
                side("xoshiro256++", stream),
                side("Threefry4x64-13", move || normals(threefry)),
                side("Philox4x32-10", move || normals(philox)),
            ],
        },
    ]
}

/// Runs a task of all paths on `threads` threads, which differ in their seeds.
fn on_threads(threads: usize, run: impl Fn(u64, usize) -> f64 + Sync) -> f64 {
    if threads == 1 {
        return run(0, PATHS / W);
    }
    thread::scope(|scope| {
        let run = &run;
        let handles: Vec<_> = (0..threads)
            .map(|k| scope.spawn(move || run(k as u64, PATHS / W / threads)))
            .collect();
        handles.into_iter().map(|h| h.join().expect("a run")).sum()
    })
}

fn oscillators(threads: usize) -> f64 {
    on_threads(threads, |seed, tiles| {
        let mut sums: Sums = vec![[0.0; 2]; STEPS / RECORD];
        let (h, sigma) = black_box((0.1, 1.0));
        dispatch(Oscillators {
            words: &mut Xoshiro::new(seed),
            tiles,
            h,
            sigma,
            sums: &mut sums,
        });
        sums[0][0]
    })
}

fn kubos(threads: usize) -> f64 {
    on_threads(threads, |seed, tiles| {
        let mut sums: Sums = vec![[0.0; 2]; STEPS / RECORD];
        let (h, a, sigma) = black_box((0.1, 1.0, 1.0));
        dispatch(Kubos {
            words: &mut Xoshiro::new(seed),
            tiles,
            h,
            a,
            sigma,
            sums: &mut sums,
        });
        sums[0][0]
    })
}

fn pendulums() -> f64 {
    let (mut q, mut p) = hand::pendulum_starts(PATHS);
    let (h, g) = black_box((0.1, 9.8));
    dispatch(Pendulums {
        q: &mut q,
        p: &mut p,
        steps: STEPS,
        h,
        g,
    });
    q[0][0] + p[0][LONG - 1]
}

/// Double pendulums one after the other, by the derived step of one state.
fn double_pendulums(count: usize) -> f64 {
    let (m, l, g) = ([1.0, 0.5], [1.0, 0.7], 9.8);
    let integrator = Integrator::new(DoublePendulum { m, l, g }, Midpoint);
    let mut sum = 0.0;
    for k in 0..count {
        let start = double_pendulum(k as u64);
        let states = integrator.trajectory(black_box(start), black_box(0.01), NoNoise);
        let last = states.take(STEPS).last().expect("a step").expect("a step");
        sum += last.q[0];
    }
    sum
}

/// Starts that differ from path to path.
fn double_pendulum(path: u64) -> State<2> {
    let at = path as f64 / PATHS as f64;
    State::new([1.0 + at, 0.5 - at], [0.3, -0.2])
}

fn table(tasks: &[Task<'_>]) {
    println!(
        "{:<24}{:<22}{:>8}{:>8}{:>8}{:>8}",
        "task", "by", "ns", "best", "ratio", "wanted"
    );
    for Task { name, count, sides } in tasks {
        let mut times = vec![Vec::with_capacity(ROUNDS); sides.len()];
        for _ in 0..ROUNDS {
            for (side, times) in sides.iter().zip(&mut times) {
                let start = Instant::now();
                black_box((side.run)());
                times.push(start.elapsed().as_secs_f64() * 1e9 / *count as f64);
            }
        }
        for times in &mut times {
            times.sort_by(f64::total_cmp);
        }
        let limit = times[0][ROUNDS / 2];
        for (side, times) in sides.iter().zip(&times) {
            let (ns, best) = (times[ROUNDS / 2], times[0]);
            let wanted = side.wanted.map_or(String::new(), |r| format!("{r:.2}"));
            let ratio = ns / limit;
            println!(
                "{name:<24}{:<22}{ns:>8.3}{best:>8.3}{ratio:>8.2}{wanted:>8}",
                side.name
            );
        }
    }
}

fn main() {
    check::all();
    println!("with {}, medians of {ROUNDS} runs", wide::name());
    let mut tasks = Vec::from(noise());
    tasks.push(Task {
        name: "A oscillator endpoint",
        count: PATHS * STEPS,
        sides: vec![
            side("by hand", || oscillators(1)),
            side("by hand, 2 threads", || oscillators(2)),
        ],
    });
    tasks.push(Task {
        name: "B Kubo midpoint",
        count: PATHS * STEPS,
        sides: vec![
            side("by hand", || kubos(1)),
            side("by hand, 2 threads", || kubos(2)),
        ],
    });
    tasks.push(Task {
        name: "pendulum",
        count: PATHS * STEPS,
        sides: vec![side("by hand", pendulums)],
    });
    tasks.push(Task {
        name: "double pendulum",
        count: DOUBLE * STEPS,
        sides: vec![side("scalar step", || double_pendulums(DOUBLE))],
    });
    table(&tasks);
}
