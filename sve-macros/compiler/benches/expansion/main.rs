//! The cost of a system before its first step: time of expansion, size of the code, time of the
//! compiler, operations.
//!
//! `cargo bench -p sve-compiler --bench expansion` prints a table for each scene in `scenes.rs`, of
//! 1 to 48 degrees of freedom; `-- chain 96 240` prints one scene in these sizes. Between two
//! rows, `^` is the exponent of growth: it is 2 for a quantity that grows like the square of the
//! degrees of freedom.

mod build;
mod scenes;

use std::time::Instant;

use proc_macro2::{TokenStream, TokenTree};

use build::{Built, Crate};
use scenes::Scene;
use sve_compiler::{CALL, Operations, Settings, expand};

const SIZES: [usize; 7] = [1, 2, 3, 6, 12, 24, 48];

fn main() {
    // cargo passes `--bench`
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| a != "--bench")
        .collect();
    let times_only = arguments.iter().any(|a| a == "--times");
    let sizes: Vec<usize> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    let sizes = if sizes.is_empty() {
        SIZES.to_vec()
    } else {
        sizes
    };
    let named = |scene: &Scene| arguments.iter().any(|a| a == scene.name());
    let mut scenes: Vec<Scene> = Scene::ALL.into_iter().filter(named).collect();
    if scenes.is_empty() {
        scenes = Scene::ALL.to_vec();
    }
    let done = if times_only {
        times(&scenes, &sizes)
    } else {
        tables(&scenes, &sizes)
    };
    if let Err(error) = done {
        eprintln!("{error}");
        std::process::exit(1);
    }
}

/// Prints the seconds of each expansion.
fn times(scenes: &[Scene], sizes: &[usize]) -> Result<(), String> {
    for &scene in scenes {
        for &n in sizes {
            let (seconds, _) = expansion(scene, n)?;
            println!("{seconds}");
        }
    }
    Ok(())
}

/// A row of the table.
struct Row {
    n: usize,
    expansion: f64,
    unoptimised: f64,
    tokens: usize,
    lines: usize,
    operations: Operations,
    built: Built,
}

fn tables(scenes: &[Scene], sizes: &[usize]) -> Result<(), String> {
    let scene_crate = Crate::new()?;
    println!(
        "Times in ms; `cargo check` and `cargo build --release` of a crate with the scene alone, in all; macro: expansion, optimised and not;"
    );
    println!(
        "operations of L, of the residual and of the Jacobian: arithmetic 1, calls {CALL}; R/L: residual for L."
    );
    for &scene in scenes {
        let mut arguments = vec![scene.name().to_owned()];
        arguments.extend(sizes.iter().map(ToString::to_string));
        let unoptimised = build::unoptimised(&arguments)?;
        println!("\n{} by the rule {}", scene.name(), Scene::RULE);
        println!(
            "{:>4} {:>8}    ^ {:>8}    ^ {:>8}    ^ {:>8}    ^ {:>8}    ^ {:>8}    ^ {:>8} {:>8} {:>8}  R/L {:>10}    ^",
            "dof",
            "macro",
            "macro-O0",
            "tokens",
            "lines",
            "check",
            "release",
            "L",
            "R",
            "J",
            "ns/step"
        );
        let mut previous: Option<Row> = None;
        for (&n, unoptimised) in sizes.iter().zip(unoptimised.lines()) {
            let row = row(scene, n, unoptimised, &scene_crate)?;
            row.print(previous.as_ref());
            previous = Some(row);
        }
    }
    Ok(())
}

fn row(scene: Scene, n: usize, unoptimised: &str, scene_crate: &Crate) -> Result<Row, String> {
    let (expansion, tokens) = expansion(scene, n)?;
    let (attribute, block) = input(scene, n)?;
    let program = scene.program(n);
    Ok(Row {
        n,
        expansion,
        unoptimised: unoptimised
            .trim()
            .parse()
            .map_err(|_| format!("not a time: {unoptimised}"))?,
        lines: build::lines(tokens.clone()),
        tokens: count(tokens),
        operations: Operations::count(&attribute, &block).map_err(|error| error.to_string())?,
        built: scene_crate.build(&program)?,
    })
}

impl Row {
    fn print(&self, previous: Option<&Self>) {
        let growth = |of: &dyn Fn(&Self) -> f64| {
            previous.map_or_else(String::new, |p| {
                let exponent = (of(self) / of(p)).ln() / (self.n as f64 / p.n as f64).ln();
                format!("{exponent:.1}")
            })
        };
        let milliseconds = |of: &dyn Fn(&Self) -> f64| {
            print!(" {:>8.1} {:>4}", 1e3 * of(self), growth(of));
        };
        let number = |of: &dyn Fn(&Self) -> usize| {
            print!(" {:>8} {:>4}", of(self), growth(&|row| of(row) as f64));
        };
        print!("{:>4}", self.n);
        milliseconds(&|row| row.expansion);
        milliseconds(&|row| row.unoptimised);
        number(&|row| row.tokens);
        number(&|row| row.lines);
        milliseconds(&|row| row.built.check);
        milliseconds(&|row| row.built.release);
        let Operations {
            lagrangian,
            residual,
            jacobian,
        } = self.operations;
        let ratio = residual as f64 / lagrangian as f64;
        print!(" {lagrangian:>8} {residual:>8} {jacobian:>8} {ratio:>4.1}");
        println!(
            " {:>10.0} {:>4}",
            self.built.step,
            growth(&|row| row.built.step)
        );
    }
}

/// Returns the attribute and the block of a scene.
fn input(scene: Scene, n: usize) -> Result<(TokenStream, TokenStream), String> {
    let parse = |text: &str| text.parse().map_err(|error| format!("{error}"));
    Ok((parse(Scene::RULE)?, parse(&scene.block(n))?))
}

/// Returns the median time of an expansion, and the expansion.
fn expansion(scene: Scene, n: usize) -> Result<(f64, TokenStream), String> {
    let (attribute, block) = input(scene, n)?;
    let mut times = Vec::new();
    // as without the feature `ensemble`
    let settings = Settings {
        lanes: false,
        ..Settings::default()
    };
    let whole = Instant::now();
    let tokens = loop {
        let start = Instant::now();
        let tokens = expand(&attribute, &block, settings);
        times.push(start.elapsed().as_secs_f64());
        if times.len() >= 9 || whole.elapsed().as_secs_f64() > 2.0 {
            break tokens;
        }
    };
    times.sort_unstable_by(f64::total_cmp);
    Ok((times[times.len() / 2], tokens))
}

/// Returns the number of tokens, including tokens within groups.
fn count(tokens: TokenStream) -> usize {
    let mut open = vec![tokens];
    let mut sum = 0;
    while let Some(stream) = open.pop() {
        for tree in stream {
            sum += 1;
            if let TokenTree::Group(group) = tree {
                open.push(group.stream());
            }
        }
    }
    sum
}
