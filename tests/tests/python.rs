//! The Python programs of the guide read what the library writes, with the same bits.
//!
//! A program that needs Python or `NumPy` where this machine lacks them is skipped, and the reason
//! is printed.

#![allow(clippy::redundant_closure_for_method_calls)] // closures are written as users write them

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use sve_runtime::prelude::*;

const PAGE: &str = include_str!("../../sve-runtime/docs/guide/python.md");

/// The oscillator of the page.
struct Oscillator {
    sigma: f64,
}

#[variational(stormer_verlet)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * (v * v - q * q)
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

#[test]
fn python_programs_of_the_guide_read_the_files() {
    let folder = Folder::new();
    let (end, means) = write_files(&folder.0);
    let programs: Vec<&str> = python_blocks(PAGE).collect();
    assert_eq!(programs.len(), 2, "programs of the page");
    for program in programs {
        let needs_numpy = program.contains("import numpy");
        let required = if needs_numpy { "import numpy" } else { "" };
        if !run(required, &folder.0).is_some_and(|output| output.status.success()) {
            let lacking = if needs_numpy { "NumPy" } else { "python3" };
            report_skipped(lacking);
            continue;
        }
        // Python prints numbers, as Rust does, with the digits that give back their bits
        let checks = if needs_numpy {
            format!(
                "assert path['q'][-1] == {:?}\nassert list(energy['energy_mean']) == {means:?}\n",
                end.q[0]
            )
        } else {
            format!(
                "assert path[-1] == {{'t': {:?}, 'q': {:?}, 'p': {:?}}}\n",
                end.t, end.q[0], end.p[0]
            )
        };
        let output = run(&format!("{program}\n{checks}"), &folder.0).unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{program}{checks}: {error}");
    }
}

/// Does what the Rust program of the page does. Returns the last state of the path, and the means
/// of the energy.
fn write_files(folder: &Path) -> (State<[f64; 1]>, Vec<f64>) {
    let oscillator = Integrator::new(Oscillator { sigma: 0.5 }, StormerVerlet);
    let start = State::new([1.0], [0.0]);
    let path = || {
        oscillator
            .trajectory(start, 0.1, Wiener::new(42))
            .every(1)
            .until(10.0)
    };
    path().to_csv(folder.join("path.csv")).unwrap();
    let summary = Ensemble::new(&oscillator)
        .paths(1000)
        .seed(42)
        .steps(0.1, 100)
        .every(10)
        .start(start)
        .observe("energy", |system, state| system.hamiltonian(state))
        .run()
        .unwrap();
    summary.to_csv(folder.join("energy.csv")).unwrap();
    summary.to_npy(folder.join("energy.npy")).unwrap();
    (
        path().last().unwrap().unwrap(),
        summary["energy"].mean().to_vec(),
    )
}

/// Returns the programs of a page that are marked as Python.
fn python_blocks(page: &str) -> impl Iterator<Item = &str> {
    let blocks = page.split("```python\n").skip(1);
    blocks.map(|rest| rest.split("```").next().unwrap())
}

/// Runs a program in Python, whose folder of temporary files is `folder`; `None` if there is no
/// Python.
fn run(program: &str, folder: &Path) -> Option<Output> {
    let mut python = Command::new("python3");
    python.args(["-c", program]).env("TMPDIR", folder);
    python.output().ok()
}

/// Prints that a program was skipped. The output of a test that passes is captured, so the line is
/// written past it.
fn report_skipped(lacking: &str) {
    let line = format!("SKIPPED: a Python program of the guide; this machine lacks {lacking}\n");
    std::io::stderr().write_all(line.as_bytes()).unwrap();
}

/// A folder that is removed when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        let path = std::env::temp_dir().join(format!("sve-python-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
