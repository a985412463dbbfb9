//! Ensembles against code written by hand for one system: `cargo bench -p sve-runtime --features
//! ensemble --bench ensemble`. `-- normals` selects the tasks whose names contain `normals`.
//!
//! Prints a table: nanoseconds a normal or a trajectory-step, medians of runs that alternate
//! between all sides of a task so that a noisy machine hits them alike, and the best run; the ratio
//! to the median of the first side; and the wanted ratio. The wanted ratios were set on a machine
//! where the limits were 0.475 ns (noise), 0.50 (A), 0.77 (B) and 1.5 (pendulum) by portable code.
//! A run takes about a millisecond: short compared with a time slice of the system, long compared
//! with waking a thread. Sides called plain do not contract products and sums. The library may not
//! contract them either, since its bits are the same on every machine.

mod check;
mod constrained;
mod derived;
mod feedback;
mod hand;
mod limits;
#[path = "../steps/hand.rs"]
#[allow(dead_code)] // the module has more steps than are compared here
mod scalar;
mod systems;
mod wide;
mod words;

use std::hint::black_box;
use std::time::Instant;

use rayon::{ThreadPool, ThreadPoolBuilder};

use words::{Philox, Threefry};

/// Number of paths of a task.
const PATHS: usize = 1024;
/// Number of steps of a path.
const STEPS: usize = 1000;
/// Number of double pendulums, whose steps take a hundred times as long.
const DOUBLE: usize = 64;
/// Number of steps of the double pendulums.
const DOUBLE_STEPS: usize = 200;
/// Number of alternating runs of a task.
const ROUNDS: usize = 201;

/// One way of doing a task.
struct Side<'a> {
    name: &'static str,
    run: Box<dyn Fn() -> f64 + Sync + 'a>,
    /// Number of threads of the side.
    threads: usize,
    /// Largest wanted ratio to the first side.
    wanted: Option<f64>,
}

/// A task that all sides do.
struct Task<'a> {
    name: &'static str,
    /// Number of normals or trajectory-steps of a run.
    count: usize,
    sides: Vec<Side<'a>>,
}

fn side<'a>(name: &'static str, run: impl Fn() -> f64 + Sync + 'a) -> Side<'a> {
    let run = Box::new(run);
    Side {
        name,
        run,
        threads: 1,
        wanted: None,
    }
}

impl Side<'_> {
    fn wanted(self, ratio: f64) -> Self {
        Self {
            wanted: Some(ratio),
            ..self
        }
    }

    fn on_two_threads(self) -> Self {
        Self { threads: 2, ..self }
    }
}

fn noise() -> [Task<'static>; 2] {
    let (philox, threefry) = (Philox { seed: 1, block: 0 }, Threefry { seed: 1, block: 0 });
    let count = PATHS * STEPS;
    let words = vec![
        side("xoshiro256++", limits::xoshiro_words),
        side("Threefry4x64-13", move || limits::words(threefry)),
        side("Philox4x32-10", move || limits::words(philox)),
    ];
    let normals = vec![
        side("xoshiro256++", || limits::xoshiro_normals(true)),
        side("xoshiro256++, plain", || limits::xoshiro_normals(false)),
        side("Threefry", move || limits::normals(true, threefry)),
        side("Threefry, plain", move || limits::normals(false, threefry)),
        side("Philox", move || limits::normals(true, philox)),
        side("sve, summed", derived::walks).wanted(1.47),
    ];
    [
        Task {
            name: "words",
            count,
            sides: words,
        },
        Task {
            name: "normals",
            count,
            sides: normals,
        },
    ]
}

fn oscillators() -> [Task<'static>; 4] {
    let task = |name, sides| Task {
        name,
        count: PATHS * STEPS,
        sides,
    };
    [
        task(
            "A oscillator endpoint",
            vec![
                side("by hand", || limits::oscillators(true)),
                side("by hand, plain", || limits::oscillators(false)),
                side("sve", derived::oscillators).wanted(1.80),
            ],
        ),
        task(
            "A, 2 threads against 1",
            vec![
                side("sve", derived::oscillators),
                side("sve, 2 threads", derived::oscillators)
                    .on_two_threads()
                    .wanted(1.0 / 1.9),
                side("by hand, 2 threads", || limits::oscillators(true)).on_two_threads(),
            ],
        ),
        task(
            "B Kubo midpoint",
            vec![
                side("by hand", || limits::kubos(true)),
                side("by hand, plain", || limits::kubos(false)),
                side("sve", derived::kubos).wanted(1.43),
            ],
        ),
        task(
            "B, 2 threads against 1",
            vec![
                side("sve", derived::kubos),
                side("sve, 2 threads", derived::kubos)
                    .on_two_threads()
                    .wanted(1.0 / 1.9),
                side("by hand, 2 threads", || limits::kubos(true)).on_two_threads(),
            ],
        ),
    ]
}

fn pendulums() -> [Task<'static>; 2] {
    [
        Task {
            name: "pendulum midpoint",
            count: PATHS * STEPS,
            sides: vec![
                side("by hand", || limits::pendulums(true)),
                side("by hand, plain", || limits::pendulums(false)),
                side("sve", derived::pendulums).wanted(2.0),
            ],
        },
        Task {
            name: "double pendulum",
            count: DOUBLE * DOUBLE_STEPS,
            sides: vec![
                side("sve, scalar steps", derived::double_pendulums_singly),
                side("sve", derived::double_pendulums).wanted(0.25),
            ],
        },
    ]
}

/// Returns a pool whose threads exist before a run begins.
fn pool(threads: usize) -> ThreadPool {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads")
}

fn table(tasks: &[Task<'_>]) {
    let pools = [pool(1), pool(2)];
    println!(
        "{:<24}{:<20}{:>9}{:>9}{:>8}{:>8}",
        "task", "by", "ns", "best", "ratio", "wanted"
    );
    for Task { name, count, sides } in tasks {
        let mut times = vec![Vec::with_capacity(ROUNDS); sides.len()];
        for _ in 0..ROUNDS {
            for (side, times) in sides.iter().zip(&mut times) {
                let elapsed = pools[side.threads - 1].install(|| {
                    let start = Instant::now();
                    black_box((side.run)());
                    start.elapsed()
                });
                times.push(elapsed.as_secs_f64() * 1e9 / *count as f64);
            }
        }
        for times in &mut times {
            times.sort_by(f64::total_cmp);
        }
        let limit = times[0][ROUNDS / 2];
        for (side, times) in sides.iter().zip(&times) {
            let (ns, best) = (times[ROUNDS / 2], times[0]);
            let wanted = side.wanted.map_or(String::new(), |r| format!("{r:.2}"));
            println!(
                "{name:<24}{:<20}{ns:>9.3}{best:>9.3}{:>8.2}{wanted:>8}",
                side.name,
                ns / limit
            );
        }
    }
}

fn main() {
    check::all();
    println!("with {}, medians of {ROUNDS} runs", wide::name());
    let mut tasks = Vec::from(noise());
    tasks.extend(oscillators());
    tasks.extend(pendulums());
    tasks.extend(constrained::tasks());
    tasks.extend(feedback::tasks());
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|arg| !arg.starts_with('-'))
        .collect();
    tasks.retain(|task| wanted.is_empty() || wanted.iter().any(|w| task.name.contains(w)));
    table(&tasks);
}
