//! The page of a study: errors against time to solution and against the step size, and the table.
//!
//! Input: a [`Report`]. Output: HTML. Invariant: an error below two of its standard errors is drawn as an upper limit, and no line goes through it.

use std::path::Path;

use super::bounds::around;
use super::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row as Panels};
use super::{PlotError, page, render};
use crate::study::{Estimate, Report, Row};

/// An error with its standard error; 0 where it has none.
type Error<'a> = &'a dyn Fn(&Row) -> Option<Estimate>;
/// A kind of error with its name.
type Kind = (String, Box<dyn Fn(&Row) -> Option<Estimate>>);
/// What errors are drawn against.
type Abscissa = (&'static str, fn(&Row) -> Option<f64>);

const TIME: Abscissa = ("time to solution of one path (s)", |row| {
    row.timing.map(|timing| timing.time_to_solution)
});
const STEP: Abscissa = ("step size h", |row| Some(row.h));

impl Report {
    /// Writes a page with pictures of the errors against time to solution and step size, and the table.
    ///
    /// Bars have two standard errors on either side. An error below two standard errors is an upper limit.
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
    ///     .start(State::new([1.0], [0.0])).horizon(1.0).steps([16, 32, 64])
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
    /// [`PlotError`] when the page cannot be written.
    pub fn write_html(&self, path: impl AsRef<Path>) -> Result<(), PlotError> {
        let title = format!("{} to t = {}", self.problem(), self.horizon());
        let mut body = format!("<figure>\n{}\n", render::svg(&figure(self))?);
        body += "<figcaption>Bars: two standard errors on either side. Arrows: upper limits of errors below two standard errors.</figcaption>\n</figure>\n";
        body.push_str("<pre>");
        body.push_str(&page::escape(&self.to_string()));
        body.push_str("</pre>\n");
        page::write(path.as_ref(), &page::document(&title, &body))
    }
}

/// A row of panels for each kind of error: against time, where times were measured, and step size.
fn figure(report: &Report) -> Figure {
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
    let row = |(name, error): &Kind| {
        let against = |x| panel(report, x, (name, error));
        let mut panels = vec![against(STEP).legend(Corner::Outside)];
        if timed {
            panels.insert(0, against(TIME));
        }
        Panels {
            height: 380,
            panels,
        }
    };
    Figure {
        name: "study",
        width: if timed { 1240 } else { 780 },
        rows: kinds.iter().map(row).collect(),
    }
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
