//! The cost of a step for each coordinate, from 10² to 10⁶ coordinates.
//!
//! Four systems by the rule of Störmer and Verlet: a chain, the φ⁴ field on a square lattice, bonds
//! of polymers, and atoms with lists of neighbours. Each is stepped by a trajectory, by single
//! steps, by the loops that one writes first, and by the best loops of the benchmark `scenes`. All
//! four must lead to the same positions. They are measured in turn, by the time of the processor
//! for this thread; the numbers are medians, and the ratios are those of the same turn. Lists are
//! made once, and making them is not part of a step. A page with the picture is written to
//! `target/cost_per_coordinate`.
//!
//! `cost_per_coordinate serve SYSTEM COORDINATES STEP` makes steps on demand for other programs.
#![allow(unsafe_code)]

mod figure;
#[path = "../../../sve-runtime/benches/scenes/hand.rs"]
#[allow(dead_code)]
mod hand;
#[path = "../../../sve-runtime/benches/scenes/measure.rs"]
#[allow(dead_code)]
mod measure;
mod plain;
mod scenes;
mod serve;
mod ways;

use std::error::Error;
use std::process::ExitCode;

use indicatif::ProgressBar;
use sve_examples::check::Check;
use sve_examples::machine;
use sve_examples::report::report;

use measure::{Case, Medians, medians};
use ways::{KINDS, Kind, WAYS};

const SIZES: [usize; 5] = [100, 1000, 10_000, 100_000, 1_000_000];

/// Turns in which the ways are measured.
const TURNS: usize = 7;

/// Names of the ways to make steps, in the order of the medians.
const NAMES: [&str; WAYS] = ["trajectory", "single steps", "plain loops", "best loops"];

/// The medians of one system and size.
struct Measured {
    kind: usize,
    coordinates: usize,
    ways: [Medians; WAYS],
}

/// Returns the number of steps of a call: a block of a trajectory, or more of a small system.
fn steps(kind: &Kind, coordinates: usize) -> u64 {
    let is_costly = kind.name == "atoms with lists";
    match (is_costly, coordinates) {
        (true, 10_000..) => 16,
        (true, _) => 64,
        _ => 64 + (1 << 16) / coordinates as u64,
    }
}

fn measured(kind: usize, size: usize) -> Result<Measured, Box<dyn Error>> {
    let scene = (KINDS[kind].scene)(size)?;
    let coordinates = scene.coordinates();
    let count = steps(&KINDS[kind], coordinates);
    let units = (coordinates as u64 * count) as f64;
    let mut cases: Vec<Case<'_>> = Vec::new();
    for (name, mut way) in NAMES.into_iter().zip(scene.ways(KINDS[kind].short)) {
        cases.push((name, units, Box::new(move || way.advance(count))));
    }
    let ways = medians(&mut cases, TURNS);
    Ok(Measured {
        kind,
        coordinates,
        ways: ways.try_into().map_err(|_| "a median for each way")?,
    })
}

/// Returns the largest difference of the positions after 20 steps, of each way from the trajectory.
fn differences(kind: &Kind) -> Result<[f64; WAYS], Box<dyn Error>> {
    let scene = (kind.scene)(3000)?;
    let ends = scene.ways(kind.h).map(|mut way| {
        way.advance(20);
        way.q()
    });
    let [path, ..] = &ends;
    let largest = |end: &Vec<f64>| {
        let pairs = end.iter().zip(path);
        pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
    };
    Ok(ends.each_ref().map(largest))
}

fn print(all: &[Measured]) {
    let [a, b, c, d] = NAMES;
    println!("nanoseconds a coordinate and step, and in brackets the trajectory over it");
    println!("{:<20}{:>9}  {a:>12}{b:>20}{c:>20}{d:>20}", "", "n");
    for Measured {
        kind,
        coordinates,
        ways,
    } in all
    {
        print!("{:<20}{coordinates:>9}", KINDS[*kind].name);
        print!("  {:>12.3}", ways[0].time);
        for way in &ways[1..] {
            print!("{:>12.3} ({:>5.2})", way.time, 1.0 / way.ratio);
        }
        println!();
    }
    println!();
}

fn checks(all: &[Measured]) -> Result<Vec<Check>, Box<dyn Error>> {
    let mut checks = Vec::new();
    for kind in &KINDS {
        let [_, single, plain, best] = differences(kind)?;
        let check = |way: &str, difference: f64| {
            Check::new(format!("{}: |Δq|, {way}", kind.name), difference)
        };
        checks.push(check(NAMES[1], single).near(0.0, 0.0, "the same bits"));
        let rounding = "rounding, after 20 steps of 3000 coordinates";
        checks.push(check(NAMES[2], plain).near(0.0, 1e-13, rounding));
        checks.push(check(NAMES[3], best).near(0.0, 1e-13, rounding));
    }
    for (kind, Kind { name, .. }) in KINDS.iter().enumerate() {
        let ratios = |way: usize| {
            let own = all.iter().filter(move |m| m.kind == kind);
            own.map(move |m| 1.0 / m.ways[way].ratio)
        };
        for (way, of) in [(2, "plain loops"), (3, "best loops")] {
            let most = ratios(way).fold(0.0, f64::max);
            checks.push(
                Check::new(format!("{name}: trajectory / {of}"), most)
                    .reported("the largest of the sizes, on this machine"),
            );
        }
    }
    Ok(checks)
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let Some(("serve", rest)) = words
        .split_first()
        .map(|(first, rest)| (first.as_str(), rest))
    {
        serve::serve(rest)?;
        return Ok(ExitCode::SUCCESS);
    }
    let bar = ProgressBar::new((KINDS.len() * SIZES.len()) as u64);
    let mut all = Vec::new();
    for kind in 0..KINDS.len() {
        for size in SIZES {
            all.push(measured(kind, size)?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    print(&all);
    let caption = format!(
        "Times of a coordinate and step on one thread of {}, medians of {TURNS} turns, by the rule of Störmer and Verlet. Above: by trajectories and by single steps, each of which computes all forces twice. Below: the times of trajectories in parts of those of loops by hand; below 1 the trajectory is faster.",
        machine::processor()
    );
    report(
        "The cost of a coordinate",
        &figure::figure(&all),
        &caption,
        &checks(&all)?,
    )
}
