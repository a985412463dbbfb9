//! The output of a program: a page with its figure and numbers, the figure alone, and the exit
//! status.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use crate::check::{self, Check};
use crate::figure::{Figure, Panel, Row};
use crate::page::{self, Section};
use crate::render;

/// Returns the figure of one row of panels, with its width and height in CSS pixels.
pub fn one_row(name: &'static str, [width, height]: [u32; 2], panels: Vec<Panel>) -> Figure {
    let rows = vec![Row { height, panels }];
    Figure { name, width, rows }
}

/// Writes `target/NAME/index.html`, `NAME.svg` and `NAME.png`, where NAME is the name of the
/// figure, and prints the numbers. Returns the exit status: failure if a number is off.
///
/// # Errors
/// If a file cannot be written.
pub fn report(
    title: &str,
    figure: &Figure,
    caption: &str,
    checks: &[Check],
) -> Result<ExitCode, Box<dyn Error>> {
    let folder = Path::new("target").join(figure.name);
    std::fs::create_dir_all(&folder)?;
    let section = Section {
        title,
        svg: &render::panels(figure)?,
        caption,
        checks,
    };
    let page = folder.join("index.html");
    std::fs::write(&page, page::html(title, "", &[section], ""))?;
    let svg = folder.join(format!("{}.svg", figure.name));
    std::fs::write(svg, render::svg(figure)?)?;
    std::fs::write(
        folder.join(format!("{}.png", figure.name)),
        render::png(figure)?,
    )?;
    println!("{}", check::table(title, checks));
    println!("page: {}", page.display());
    Ok(if checks.iter().any(Check::failed) {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}
