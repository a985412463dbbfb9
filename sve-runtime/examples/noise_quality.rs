//! The quality of Wiener increments on as many draws as one has time for.
//!
//! `cargo run --release -p sve-runtime --example noise_quality [draws] [seed]`, by default 10⁹ draws of seed 1 on all cores, which takes
//! half a minute on two. It prints each statistic with its deviation in standard errors, and exits with status 1 if one is out
//! of its bound, which chance alone exceeds once in about 10⁴ runs.

#[path = "../tests/noise/statistics.rs"]
mod statistics;

use std::process::ExitCode;

use statistics::{Finding, Pairs, Sample};
use sve_runtime::noise::{Noise, NoiseError, Wiener};

/// Steps of a path, and processes: a path is 4096 draws.
const STEPS: u64 = 1024;
const PROCESSES: usize = 4;

/// What one thread gathers.
struct Gathered {
    all: Sample,
    lags: [Pairs; 5],
    processes: Pairs,
    paths: Pairs,
    seeds: Pairs,
}

impl Gathered {
    fn new() -> Self {
        Self {
            all: Sample::new(),
            lags: Default::default(),
            processes: Pairs::default(),
            paths: Pairs::default(),
            seeds: Pairs::default(),
        }
    }

    fn merge(&mut self, other: &Self) {
        self.all.merge(&other.all);
        for (lag, more) in self.lags.iter_mut().zip(&other.lags) {
            lag.merge(more);
        }
        self.processes.merge(&other.processes);
        self.paths.merge(&other.paths);
        self.seeds.merge(&other.seeds);
    }

    /// A path of a seed, beside the next path and the next seed.
    fn add(&mut self, seed: u64, path: u64) -> Result<(), NoiseError> {
        let source = |seed, path| Wiener::new(seed).path(path);
        let mut noise = source(seed, path);
        let (mut next_path, mut next_seed) = (source(seed, path + 1), source(seed + 1, path));
        let mut last = [[0.0; PROCESSES]; 5];
        for step in 0..STEPS {
            let mut z = [0.0; PROCESSES];
            noise.increments(step, 1.0, &mut z)?;
            for z in z {
                self.all.add(z);
            }
            for (lag, (pairs, last)) in (1..).zip(self.lags.iter_mut().zip(&last)) {
                if step >= lag {
                    pairs.add(last[0], z[0]);
                }
            }
            self.processes.add(z[0], z[1]);
            last.rotate_right(1);
            last[0] = z;
            let mut other = [0.0];
            next_path.increments(step, 1.0, &mut other)?;
            self.paths.add(z[0], other[0]);
            next_seed.increments(step, 1.0, &mut other)?;
            self.seeds.add(z[0], other[0]);
        }
        Ok(())
    }

    fn findings(&self) -> Vec<Finding> {
        let mut findings = self.all.findings();
        for (lag, pairs) in (1..).zip(&self.lags) {
            findings.extend(pairs.findings(&format!("steps at lag {lag}")));
        }
        findings.extend(self.processes.findings("processes 0, 1"));
        findings.extend(self.paths.findings("adjacent paths"));
        findings.extend(self.seeds.findings("adjacent seeds"));
        findings
    }
}

fn gather(seed: u64, paths: u64) -> Result<Gathered, NoiseError> {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let of_thread = |thread: u64| {
        let mut gathered = Gathered::new();
        for path in (thread..paths).step_by(threads as usize) {
            gathered.add(seed, path)?;
        }
        Ok(gathered)
    };
    std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads)
            .map(|thread| scope.spawn(move || of_thread(thread)))
            .collect();
        let mut total = Gathered::new();
        for thread in running {
            total.merge(&thread.join().expect("a thread of draws does not panic")?);
        }
        Ok(total)
    })
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|word| word.parse::<u64>());
    let (Ok(draws), Ok(seed)) = (
        arguments.next().unwrap_or(Ok(1_000_000_000)),
        arguments.next().unwrap_or(Ok(1)),
    ) else {
        eprintln!("usage: noise_quality [draws] [seed]");
        return ExitCode::FAILURE;
    };
    let paths = draws.div_ceil(STEPS * PROCESSES as u64);
    let findings = match gather(seed, paths) {
        Ok(gathered) => gathered.findings(),
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    println!("{} draws of seed {seed}", paths * STEPS * PROCESSES as u64);
    println!(
        "{:40} {:>16} {:>16} {:>10}",
        "", "value", "expected", "deviation"
    );
    for Finding {
        what,
        value,
        expected,
        deviation,
        ..
    } in &findings
    {
        println!("{what:40} {value:16.9} {expected:16.9} {deviation:10.2}");
    }
    let off = findings.iter().filter(|finding| !finding.holds()).count();
    println!("{off} of {} out of bounds", findings.len());
    if off == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
