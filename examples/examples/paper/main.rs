//! Figures 1 to 4 of a text called "Stochastic Variational Integrators", and numbers that follow
//! from its schemes. The text is not the paper of Bou-Rabee and Owhadi of that title, but a later
//! one that cites it; see [`TEXT`].
//!
//! Writes SVG, PNG and CSV of each figure and one `index.html` without outside resources; prints
//! the table of measured and expected numbers; exits with status 1 if a number is off.
//! `cargo run --release --example paper -- --help` lists options.

mod figure1;
mod figure2;
mod figure3;
mod figure4;
mod oscillator;
mod run;
mod settings;
mod systems;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use sve_examples::check::{self, Check};
use sve_examples::figure::Figure;
use sve_examples::page::{self, Section};
use sve_examples::render;

use settings::{H, Options};

/// The result of a figure: its drawing, the text under it, and its numbers.
pub(crate) struct Report {
    title: &'static str,
    figure: Figure,
    caption: String,
    checks: Vec<Check>,
}

fn main() -> ExitCode {
    match paper(&Options::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs, writes and prints everything. Returns whether all compared numbers agree.
fn paper(options: &Options) -> Result<bool, Box<dyn Error>> {
    let start = Instant::now();
    fs::create_dir_all(&options.out)
        .map_err(|e| format!("cannot make {}: {e}", options.out.display()))?;

    // The ticks are 7 starts, 5 schemes on one path, the paths, 1 for figure 4, and then 4
    // drawings.
    let progress = ProgressBar::new(7 + 5 + u64::from(options.paths) + 1 + 4);
    progress.set_style(ProgressStyle::with_template(
        "{msg:<24} {bar:40} {pos}/{len}",
    )?);
    let tick = || progress.inc(1);
    let mut reports = Vec::new();
    progress.set_message("pendulum");
    reports.push(figure1::report(options, &tick)?);
    progress.set_message("oscillator, one path");
    reports.push(figure2::report(options, &tick)?);
    progress.set_message("oscillator, all paths");
    reports.push(figure3::report(options, &tick)?);
    progress.set_message("Kubo oscillator");
    reports.push(figure4::report(options, &tick)?);
    progress.set_message("drawing");
    let mut drawings = Vec::new();
    for report in &reports {
        drawings.push(write_figure(&options.out, &report.figure)?);
        tick();
    }
    progress.finish_and_clear();

    let index = options.out.join("index.html");
    write(&index, html(options, &reports, &drawings).as_bytes())?;
    let mut text = String::new();
    for report in &reports {
        writeln!(text, "{}", check::table(report.title, &report.checks))?;
    }
    print!("{text}");
    let failed = reports
        .iter()
        .flat_map(|report| &report.checks)
        .filter(|check| check.failed())
        .count();
    println!(
        "wrote {} and figure1 … figure4 as .svg, .png and .csv beside it, in {:.1} s",
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

/// Writes the files of a figure and returns its panels for the page.
fn write_figure(folder: &Path, figure: &Figure) -> Result<String, Box<dyn Error>> {
    let file = |extension| folder.join(figure.name).with_extension(extension);
    write(&file("svg"), render::svg(figure)?.as_bytes())?;
    write(&file("png"), &render::png(figure)?)?;
    write(&file("csv"), figure.csv().as_bytes())?;
    Ok(render::panels(figure)?)
}

fn html(options: &Options, reports: &[Report], drawings: &[String]) -> String {
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
    let failed = reports
        .iter()
        .flat_map(|r| &r.checks)
        .filter(|c| c.failed())
        .count();
    let verdict = match failed {
        0 => "Every compared number agrees.".to_owned(),
        n => {
            format!("<strong>{n} of the compared numbers are off; their rows are marked.</strong>")
        }
    };
    let head = format!(
        "<p>Every integrator here was derived at compile time from a Lagrangian; the methods they are compared with come \
         from the same derivatives. Step size {H}, horizon {}, {} paths, seed {}. {verdict}</p>",
        options.horizon, options.paths, options.seed
    );
    page::html(
        "Four figures on stochastic variational integrators",
        &head,
        &sections,
        TEXT,
    )
}

/// A note on the text, and on the labels that differ from it.
const TEXT: &str = "<section>
<h2>Which text this is, and where it is read differently</h2>
<p>Not “Stochastic variational integrators” by N. Bou-Rabee and H. Owhadi (IMA Journal of Numerical Analysis 29, 2009), but a later text of the
same title, without a date in print, which cites theirs as its reference [2], says that numerical demonstrations were not presented there, and gives some in
four figures: a pendulum, the stochastic linear oscillator on one path and on 100, and the Kubo oscillator. It prints no numbers for them:
expected values here follow from its schemes, and were computed independently by <code>examples/peers/paper.py</code>.</p>
<ol>
<li>The printed “symplectic Euler–Maruyama”, q₁ = q₀ + h p₁, p₁ = p₀ − h q₁ + σΔW, is backward Euler: its determinant is
1/(1 + h²), and its mean energy settles at 5. The discrete action of the endpoint rule gives q₁ = q₀ + h p₀,
p₁ = p₀ − h q₁ + σΔW, which the text prints as the partitioned method of its reference [5] and attributes to the initial point;
the initial-point rule gives p₁ = p₀ − h q₀ + σΔW, q₁ = q₀ + h p₁. Here the two are called by their rules.</li>
<li>With γ = −σq the text's own equations give dp = … − σdW; for dp = … + σdW it is γ = +σq, which is used here.</li>
<li>The integral in the oscillator's solution runs to t, ∫₀ᵗ sin(t − s) dW(s); printed is an upper limit of 1. (σ = 1 was set before.)</li>
<li>For the comparison on the Kubo oscillator the text refers to figure 2; it is in figure 4.</li>
</ol>
</section>";
