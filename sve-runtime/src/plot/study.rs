//! The page of a study: errors against time to solution and against the step size, and the table.
//!
//! Input: a [`Report`]. Output: HTML. Invariant: an error below two of its standard errors is drawn
//! as an upper limit, and no line goes through it.

use std::path::Path;

use super::bounds::around;
use super::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row as Panels};
use super::legend::Legend;
use super::{PlotError, page};
use crate::study::{Estimate, Report, Row};

/// An error with its standard error; 0 if it has none.
type Error<'a> = &'a dyn Fn(&Row) -> Option<Estimate>;
/// A kind of error with its name.
type Kind = (String, Box<dyn Fn(&Row) -> Option<Estimate>>);
/// The quantity on the horizontal axis of a figure of errors.
type Abscissa = (&'static str, fn(&Row) -> Option<f64>);

/// Height of a figure without its legend, and about the width of its axes, in CSS pixels.
const HEIGHT: u32 = 360;
const AXES: f64 = 440.0;

const TIME: Abscissa = ("time to solution of one path (s)", |row| {
    row.timing.map(|timing| timing.time_to_solution)
});
const STEP: Abscissa = ("step size h", |row| Some(row.h));

impl Report {
    /// Writes a page with a description of the study (system with its parameters, methods,
    /// reference, paths and seed), pictures of the errors against time to solution and step size,
    /// and the table.
    ///
    /// Bars have two standard errors on either side. An error below two standard errors is an upper
    /// limit.
    ///
    /// ```
    /// use sve_runtime::baseline::Heun;
    /// use sve_runtime::prelude::*;
    /// use sve_runtime::study::Study;
    ///
    /// #[derive(Clone, Copy)]
    /// struct Oscillator;
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    /// }
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let (midpoint, heun) = (Integrator::new(Oscillator, Midpoint), Heun::new(Oscillator));
    /// let report = Study::new("oscillator")
    ///     .start(State::new([1.0], [0.0])).horizon(1.0).step_counts([16, 32, 64])
    ///     .method("midpoint", &midpoint).method("Heun", &heun)
    ///     .exact(|_| State::new([1_f64.cos()], [-1_f64.sin()]))
    ///     .repeats(1)
    ///     .run()?;
    /// # let folder = std::env::temp_dir().join(format!("sve-study-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder)?;
    /// # let path = folder.join("oscillator.html");
    /// # let written = path.clone();
    /// # /*
    /// let path = "oscillator.html";
    /// # */
    /// report.write_html(path)?;
    /// # assert!(std::fs::read_to_string(&written)?.contains("<svg"));
    /// # std::fs::remove_dir_all(&folder)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`PlotError`] if the page cannot be written.
    pub fn write_html(&self, path: impl AsRef<Path>) -> Result<(), PlotError> {
        let title = format!(
            "{} to t = {}",
            self.problem(),
            page::number(self.horizon(), 6)
        );
        let mut body = page::facts(&facts(self));
        body += &page::panels(
            &figures(self),
            "Bars: two standard errors on either side. Arrows: upper limits of errors below two standard errors.",
        )?;
        body += &table(self);
        for line in self.conclusions() {
            let (first, rest) = line.split_at(1);
            body.push_str("<p>");
            body.push_str(&first.to_uppercase());
            body.push_str(&page::escape(rest));
            body.push_str("</p>\n");
        }
        page::write(path.as_ref(), &page::document(&title, &body))
    }
}

/// Returns the description of the study.
fn facts(report: &Report) -> Vec<(&'static str, String)> {
    let mut facts = page::facts_of_system(&report.system);
    let method = |(name, what): &(String, String)| {
        if name == what {
            name.clone()
        } else {
            format!("{name} ({what})")
        }
    };
    let methods: Vec<_> = report.methods.iter().map(method).collect();
    facts.push(("methods", methods.join(", ")));
    facts.push(("compared with", report.reference.clone()));
    facts.push(("paths", page::count(report.paths(), "path")));
    if let Some(seed) = report.seed {
        facts.push(("seed", seed.to_string()));
    }
    facts
}

/// Returns a row for each method and number of steps. Columns without a number are left out.
fn table(report: &Report) -> String {
    let mut head = vec!["method".to_owned(), "steps".to_owned(), "h".to_owned()];
    let mut pair = |name: &str| head.extend([name.to_owned(), "±".to_owned()]);
    pair("error");
    for name in report.observables() {
        pair(&format!("weak error of {name}"));
    }
    head.push("largest error of the invariant".to_owned());
    head.extend(["drift".to_owned(), "±".to_owned()]);
    head.extend(
        [
            "ns a step",
            "±",
            "time to solution (s)",
            "iterations",
            "failures",
        ]
        .map(String::from),
    );
    let estimate = |estimate: Option<Estimate>| {
        let value = estimate.map(|estimate| estimate.value);
        page::known_with_error(value, estimate.map(|estimate| estimate.standard_error))
    };
    let cells = |row: &Row| {
        let mut cells = vec![
            row.method.clone(),
            row.steps.to_string(),
            page::number(row.h, 4),
        ];
        cells.extend(estimate(row.error));
        for number in 0..report.observables().len() {
            cells.extend(estimate(row.weak_errors.get(number).copied()));
        }
        cells.push(page::known(row.invariant.map(|i| i.largest), 3));
        cells.extend(estimate(row.invariant.map(|i| i.drift)));
        cells.push(page::known(row.timing.map(|t| t.ns_per_step), 4));
        cells.push(page::known(row.timing.map(|t| t.ns_spread), 2));
        cells.push(page::known(row.timing.map(|t| t.time_to_solution), 3));
        cells.push(page::known(row.newton_iterations, 3));
        cells.push(row.failures.to_string());
        cells
    };
    let rows: Vec<Vec<String>> = report.rows().iter().map(cells).collect();
    let is_there = |column: &usize| rows.iter().any(|row| row[*column] != page::NONE);
    let columns: Vec<usize> = (0..head.len()).filter(is_there).collect();
    let chosen = |cells: &[String]| {
        columns
            .iter()
            .map(|&column| cells[column].clone())
            .collect()
    };
    let head: Vec<String> = chosen(&head);
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    let rows: Vec<(&str, Vec<String>)> = rows.iter().map(|row| ("", chosen(row))).collect();
    page::table(&head, &rows)
}

/// Returns figures of each kind of error: against time, if times were measured, and against step
/// size.
fn figures(report: &Report) -> Vec<Figure> {
    let strong = |row: &Row| row.error;
    let mut kinds: Vec<Kind> = vec![(
        "error at the end (root of the mean square)".to_owned(),
        Box::new(strong),
    )];
    for (k, name) in report.observables().iter().enumerate() {
        let weak = move |row: &Row| row.weak_errors.get(k).copied();
        kinds.push((format!("weak error of {name}"), Box::new(weak)));
    }
    if report.rows().iter().any(|row| row.invariant.is_some()) {
        let invariant = |row: &Row| {
            Some(Estimate {
                value: row.invariant?.largest,
                standard_error: 0.0,
            })
        };
        kinds.push((
            "largest error of the invariant".to_owned(),
            Box::new(invariant),
        ));
    }
    let timed = report.rows().iter().any(|row| row.timing.is_some());
    let against = |x: Abscissa, (name, error): &Kind| {
        let panel = panel(report, x, (name, error)).legend(Corner::Below);
        // The axes keep their height for every length of the legend.
        let room = Legend::new(&panel.layers, Corner::Below, AXES).rows_below();
        Figure {
            name: "study",
            width: 540,
            rows: vec![Panels {
                height: HEIGHT + room,
                panels: vec![panel],
            }],
        }
    };
    let of = |kind: &Kind| {
        let time = timed.then(|| against(TIME, kind));
        time.into_iter()
            .chain([against(STEP, kind)])
            .collect::<Vec<_>>()
    };
    kinds.iter().flat_map(of).collect()
}

fn panel(report: &Report, (x_name, x): Abscissa, (y_name, error): (&str, Error<'_>)) -> Panel {
    let mut methods: Vec<&str> = Vec::new();
    for row in report.rows() {
        if !methods.contains(&&*row.method) {
            methods.push(&row.method);
        }
    }
    let layers: Vec<Layer> = methods
        .iter()
        .enumerate()
        .flat_map(|(number, method)| {
            let rows = report.rows().iter().filter(|row| row.method == *method);
            let points = rows.filter_map(|row| {
                let error = error(row)?;
                Some((x(row)?, error.value, error.standard_error))
            });
            Layer::errors(*method, Pen::series(number), points)
        })
        .collect();
    let points = || layers.iter().flat_map(|layer| &layer.points);
    let (xs, ys) = (around(points().map(|p| p.0)), around(points().map(|p| p.1)));
    let empty = Panel::new(
        report.problem(),
        Axis::powers(x_name, xs),
        Axis::powers(y_name, ys),
    );
    layers.into_iter().fold(empty, Panel::with)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_series_are_told_apart() {
        let axis = || Axis::new("", 0.0..1.0);
        let empty = Panel::new("", axis(), axis()).legend(Corner::Outside);
        let panel = (0..21).fold(empty, |panel, k| {
            panel.with(Layer::new(k.to_string(), Vec::new(), Pen::series(k)))
        });
        let figure = Figure {
            name: "many",
            width: 100,
            rows: vec![Panels {
                height: 100,
                panels: vec![panel],
            }],
        };
        assert!(figure.check_series().is_ok());
    }
}
