//! Work–precision: the time that an error costs, for ten problems and all methods.
//!
//! Writes `index.html`, without outside resources, and for each problem a figure as SVG and PNG and
//! its numbers as CSV. CSV files of the same columns from other programs, in the folder `peers`,
//! are drawn into the same figures. `cargo run --release --example work_precision -- --help` lists
//! options.
//!
//! `work_precision serve` solves paths on demand for other programs, and `work_precision turns`
//! draws what they measured in turns with it.
#![allow(unsafe_code)]

mod compensated;
mod deterministic;
mod look;
#[path = "../../../sve-runtime/benches/scenes/measure.rs"]
#[allow(dead_code)]
mod measure;
mod noisy;
mod picture;
mod planets;
mod plots;
mod problem;
mod report;
mod serve;
mod systems;
mod timed;
mod turns;
mod uncorrected;
mod verdict;

use std::error::Error;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Parser, Subcommand};
use sve_examples::figure::Figure;
use sve_examples::{machine, page, render};
use sve_runtime::study::{Record, StudyError, read_csv, write_csv};

use problem::Problem;
use report::Section;

/// Measures strong, weak and energy errors against time to solution, for all methods on ten
/// problems.
#[derive(Clone, Debug, Parser)]
#[command(name = "work_precision")]
struct Options {
    /// Only the problem of this name
    #[arg(long)]
    only: Option<String>,
    /// Folder for the page, figures and data
    #[arg(long, default_value = "target/work-precision")]
    out: PathBuf,
    #[command(subcommand)]
    mode: Option<Mode>,
}

#[derive(Clone, Debug, Subcommand)]
enum Mode {
    /// Solve the path of each line of the standard input: see `serve.rs`
    Serve,
    /// Draw the pictures of the comparison in turns, from files that `examples/peers/run.py` wrote
    Turns {
        /// Folder of the files
        #[arg(default_value = "docs/numbers/peers/turns")]
        folder: PathBuf,
    },
}

/// The name of a problem in file names, and the function that runs it.
type Entry = (&'static str, fn() -> Result<Problem, StudyError>);

const PROBLEMS: [Entry; 10] = [
    ("linear_oscillator", noisy::oscillator),
    ("kubo", noisy::kubo),
    ("synchrotron", noisy::synchrotron),
    ("henon_heiles", noisy::henon_heiles),
    ("langevin", noisy::langevin),
    ("pendulum", deterministic::pendulum),
    ("double_pendulum", deterministic::double_pendulum),
    ("kepler", deterministic::kepler),
    ("quiet_henon_heiles", deterministic::quiet_henon_heiles),
    ("outer_solar_system", deterministic::outer_solar_system),
];

/// Largest error that is of interest: all motions have the size 1.
const LARGEST: f64 = 0.1;

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    fs::create_dir_all(&options.out)?;
    match &options.mode {
        Some(Mode::Serve) => return serve::serve(),
        Some(Mode::Turns { folder }) => return turns::write(&peers(folder)?, &options.out),
        None => {}
    }
    let begin = Instant::now();
    // The files stored with the repository, unless there are newer files.
    let own = options.out.join("peers");
    let stored = PathBuf::from("docs/numbers/peers");
    let peers = peers(if own.is_dir() { &own } else { &stored })?;
    let mut sections = String::new();
    for (name, run) in PROBLEMS {
        if options.only.as_deref().is_some_and(|only| only != name) {
            continue;
        }
        let problem = run()?;
        println!("{}", problem.report);
        sections.push_str(&section(&options.out, name, &problem, &peers)?);
    }
    if sections.is_empty() {
        return Err(format!("no such problem; there are {:?}", PROBLEMS.map(|p| p.0)).into());
    }
    let index = options.out.join("index.html");
    let head = report::head(&machine::description(), peers.len());
    let title = "Work and precision: which method for which error";
    fs::write(
        &index,
        page::document(title, &format!("{head}\n{sections}")),
    )?;
    println!(
        "wrote {} in {:.1} s",
        index.display(),
        begin.elapsed().as_secs_f64()
    );
    Ok(())
}

/// Writes the files of a problem, and returns its part of the page.
fn section(
    out: &Path,
    name: &'static str,
    problem: &Problem,
    peers: &[Record],
) -> Result<String, Box<dyn Error>> {
    let mut records = problem.report.records();
    write_csv(
        File::create(out.join(name).with_extension("csv"))?,
        &records,
    )?;
    let (peers, others): (Vec<Record>, Vec<Record>) = peers
        .iter()
        .filter(|record| record.problem == name)
        .cloned()
        .partition(|record| same_horizon(record, problem.report.horizon()));
    if let Some(other) = others.first() {
        eprintln!(
            "{} lines of {name} in the folder of peers, such as {} of {}, are left out: they end at another time than {}",
            others.len(),
            other.method,
            other.source,
            problem.report.horizon()
        );
    }
    let all = plots::series(&records, &peers);
    let fastest = |error: plots::Quantity, is_peer: bool| {
        let curves: Vec<_> = all
            .iter()
            .filter(|series| series.is_peer == is_peer && converges(problem, series))
            .map(|series| series.curve(error))
            .collect();
        verdict::winners(&curves, LARGEST)
    };
    let winners = fastest(plots::strong, false);
    let weak = problem.report.observables().first().map(String::as_str);
    let mut conclusions = report::conclusion("an error at the end", &winners);
    if let Some(observed) = weak {
        let what = format!("a weak error of {observed} (two standard errors where they are more)");
        conclusions += &report::conclusion(&what, &fastest(plots::weak_bound, false));
    }
    if let Some(invariant) = problem.invariant {
        let what = format!("a largest error of {invariant}");
        conclusions += &report::conclusion(&what, &fastest(plots::largest, false));
    }
    let what = "an error at the end, by other programs";
    conclusions += &report::conclusion(what, &fastest(plots::strong, true));
    println!("{}", report::plain(name, &conclusions));
    let shown = plots::Shown {
        problem: problem.title,
        norm: problem.norm,
        weak,
        invariant: problem.invariant,
    };
    let picture = plots::picture(name, &all, &winners, &shown);
    let picture = write(&picture, &out.join(format!("{name}-errors")))?;
    let figure = write(
        &plots::figure(name, &all, &winners, &shown),
        &out.join(name),
    )?;
    records.extend(peers);
    Ok(report::body(&Section {
        problem,
        conclusions: &conclusions,
        picture: &picture,
        figure: &figure,
        records: &records,
    }))
}

/// Writes a picture as SVG and PNG, and returns its panels for the page.
fn write(figure: &Figure, file: &Path) -> Result<String, Box<dyn Error>> {
    fs::write(file.with_extension("svg"), render::svg(figure)?)?;
    fs::write(file.with_extension("png"), render::png(figure)?)?;
    Ok(render::panels(figure)?)
}

/// Returns whether a method's error decreases with the step size. For other programs this is
/// assumed.
fn converges(problem: &Problem, series: &plots::Series) -> bool {
    const LEAST: f64 = 0.25;
    // Errors at the rounding level of the problem do not decrease further.
    const FAR: f64 = 1e-4;
    let errors = || series.records.iter().filter_map(|record| record.error);
    let (largest, smallest) = (
        errors().fold(0.0, f64::max),
        errors().fold(f64::INFINITY, f64::min),
    );
    if smallest < FAR * largest {
        return true;
    }
    let report = &problem.report;
    let mut orders = report.orders().iter();
    if let Some(order) = orders.find(|order| order.method == series.name) {
        return order.order.value > LEAST;
    }
    let mut others = report.not_asymptotic().iter();
    let slopes = others.find(|method| method.method == series.name);
    let last = slopes.and_then(|method| method.slopes.last());
    series.is_peer || last.is_some_and(|slope| slope.value > LEAST)
}

/// Returns whether a record ends at this time, as far as its step size and times show.
fn same_horizon(record: &Record, horizon: f64) -> bool {
    let (Some(h), Some(time), Some(ns)) = (record.h, record.time_to_solution_s, record.ns_per_step)
    else {
        return true;
    };
    let own = h * (time / (1e-9 * ns)).round();
    (own - horizon).abs() <= 1e-3 * horizon
}

/// Reads the records that other programs wrote.
fn peers(folder: &Path) -> Result<Vec<Record>, Box<dyn Error>> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(Vec::new());
    };
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    // The file system determines the order of files in a folder.
    files.sort();
    let mut records = Vec::new();
    for file in files
        .iter()
        .filter(|file| file.extension().is_some_and(|e| e == "csv"))
    {
        let read = read_csv(BufReader::new(File::open(file)?));
        records.extend(read.map_err(|e| format!("{}: {e}", file.display()))?);
    }
    Ok(records)
}
