//! Ensembles of a hundred thousand paths against exact results: growth of the mean energy,
//! distribution of a phase, rate of escape.
//!
//! Input: seed, number of paths, folder. Output: SVG figures, `index.html` with the figures and
//! their numbers, the same numbers with their z-scores on the terminal; status 1 if a number is
//! off. `cargo run --release --example ensemble -- --help` lists options.

mod escape;
mod kubo;
mod oscillator;
mod spectrum;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use sve_examples::check::{self, Check};
use sve_examples::figure::Figure;
use sve_examples::page::{self, Section};
use sve_examples::render;
use sve_runtime::plot::page::number;

/// Runs ensembles of which the expectation is known and compares. Ends with status 1 where a number
/// is off.
#[derive(Clone, Debug, Parser)]
#[command(name = "ensemble")]
pub(crate) struct Options {
    /// Seed of the Wiener paths
    #[arg(long, default_value_t = 42)]
    pub(crate) seed: u64,
    /// Paths of each ensemble
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u64).range(1000..=10_000_000))]
    pub(crate) paths: u64,
    /// Folder for figures and page
    #[arg(long, default_value = "target/ensemble")]
    pub(crate) out: PathBuf,
}

/// The results of one experiment: its drawing, the text under it, and its numbers.
pub(crate) struct Report {
    title: &'static str,
    figure: Figure,
    caption: String,
    checks: Vec<Check>,
}

/// Runs the ensembles of one experiment and returns the report.
type Experiment = fn(&Options) -> Result<Report, Box<dyn Error>>;

/// Compares a mean with its expectation.
pub(crate) fn mean(
    what: impl AsRef<str>,
    measured: f64,
    expected: f64,
    standard_error: f64,
    paths: u64,
    reason: &str,
) -> Check {
    let z = (measured - expected) / standard_error;
    let factor = sve_examples::gaussian::standard_errors(paths as f64);
    let what = format!("{} (z = {})", what.as_ref(), number(z, 2));
    Check::new(what, measured).near(
        expected,
        factor * standard_error,
        format!("{reason}; {factor:.1} standard errors allowed (false alarm 10⁻⁴)"),
    )
}

/// Compares a number with a reference from which it differs by a known bias, at most `known`, and
/// by scatter. The reason gives both parts of the difference. There is no z-score, which the bias
/// would make large.
pub(crate) fn known_difference(
    what: impl AsRef<str>,
    measured: f64,
    expected: f64,
    standard_error: f64,
    (known, why): (f64, &str),
) -> Check {
    let scatter = STANDARD_ERRORS * standard_error;
    let [off, bias, rest] =
        [measured - expected, known.abs(), scatter].map(|x| number(100.0 * x / expected.abs(), 2));
    Check::new(what.as_ref(), measured).near(
        expected,
        scatter + known,
        format!(
            "differs by {off} %; allowed are {bias} % for {why}, and {rest} % for scatter, {STANDARD_ERRORS} standard errors"
        ),
    )
}

/// Largest allowed difference of a single number, in standard errors: a false alarm in 150,000.
const STANDARD_ERRORS: f64 = 4.5;

fn main() -> ExitCode {
    match ensemble(&Options::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs, writes and prints everything. Returns whether all compared numbers agree.
fn ensemble(options: &Options) -> Result<bool, Box<dyn Error>> {
    let start = Instant::now();
    fs::create_dir_all(&options.out)
        .map_err(|e| format!("cannot make {}: {e}", options.out.display()))?;
    let parts: [Experiment; 3] = [oscillator::report, kubo::report, escape::report];
    let mut reports = Vec::new();
    for part in parts {
        let begin = Instant::now();
        let report = part(options)?;
        println!(
            "{}",
            check::table(
                &format!("{} [{:.1} s]", report.title, begin.elapsed().as_secs_f64()),
                &report.checks
            )
        );
        reports.push(report);
    }
    let drawings = reports
        .iter()
        .map(|report| draw(&options.out, &report.figure))
        .collect::<Result<Vec<_>, _>>()?;
    let failed = reports
        .iter()
        .flat_map(|report| &report.checks)
        .filter(|check| check.failed())
        .count();
    let index = options.out.join("index.html");
    write(
        &index,
        html(options, &reports, &drawings, failed).as_bytes(),
    )?;
    println!(
        "wrote {} and its figures in {:.1} s",
        index.display(),
        start.elapsed().as_secs_f64()
    );
    if failed > 0 {
        eprintln!("{failed} of the numbers above are off");
    }
    Ok(failed == 0)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|e| format!("cannot write {}: {e}", path.display()))
}

/// Writes a figure and returns its panels for the page.
fn draw(folder: &Path, figure: &Figure) -> Result<String, Box<dyn Error>> {
    write(
        &folder.join(figure.name).with_extension("svg"),
        render::svg(figure)?.as_bytes(),
    )?;
    Ok(render::panels(figure)?)
}

fn html(options: &Options, reports: &[Report], drawings: &[String], failed: usize) -> String {
    let sections: Vec<Section<'_>> = reports
        .iter()
        .zip(drawings)
        .map(|(report, svg)| Section {
            title: report.title,
            svg,
            caption: &report.caption,
            checks: &report.checks,
        })
        .collect();
    let verdict = match failed {
        0 => "Every compared number agrees.".to_owned(),
        n => {
            format!("<strong>{n} of the compared numbers are off; their rows are marked.</strong>")
        }
    };
    let head = format!(
        "<p>{} paths each, seed {}. z is the difference to the expectation in standard errors. {verdict}</p>",
        options.paths, options.seed
    );
    page::html(
        "Ensembles against what is known exactly",
        &head,
        &sections,
        "",
    )
}
