//! The page of a study: errors against time to solution and against the step size, and the table.
//!
//! Input: a [`Report`]. Output: HTML. Invariant: an error below two of its standard errors is drawn
//! as an upper limit, and no line goes through it.

use std::path::Path;

use super::bounds::around;
use super::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row as Panels};
use super::legend::Legend;
use super::{PlotError, page, palette};
use crate::study::{Estimate, Order, Report, Row};

/// The error of a row with its standard error; 0 if it has none.
type Error = dyn Fn(&Row) -> Option<Estimate>;

/// A kind of error.
struct Kind<'a> {
    name: String,
    error: Box<Error>,
    /// The measured orders of the methods.
    orders: Vec<&'a Order>,
}

/// The quantity on the horizontal axis of a figure of errors: its name in the title, and on the
/// axis.
type Abscissa = ([&'static str; 2], fn(&Row) -> Option<f64>);

/// Height of a figure without its legend, and about the width of its axes, in CSS pixels.
const HEIGHT: u32 = 360;
const AXES: f64 = 440.0;

/// Lengths of dash and gap of the guides of different orders, in CSS pixels, and the distance of a
/// guide from the errors of a method, in decades.
const DASHES: [(f64, f64); 4] = [(6.0, 3.0), (2.0, 3.0), (12.0, 3.0), (4.0, 6.0)];
const BELOW: f64 = 0.4;

const TIME: Abscissa = (["time", "time to solution of one path (s)"], |row| {
    row.timing.map(|timing| timing.time_to_solution)
});
const STEP: Abscissa = (["step size", "step size h"], |row| Some(row.h));

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
            "Bars: two standard errors on either side. Arrows: upper limits of errors below two standard errors. Grey lines: the measured orders, rounded to halves.",
        )?;
        body += &table(self);
        for line in self.conclusions() {
            let (first, rest) = line.split_at(1);
            body.push_str("<p>");
            body.push_str(&first.to_uppercase());
            body.push_str(&page::escape(&with_minus(rest)));
            body.push_str("</p>\n");
        }
        page::write(path.as_ref(), &page::document(&title, &body))
    }
}

/// Returns a text with typographic minus signs before its numbers.
fn with_minus(text: &str) -> String {
    ('0'..='9').fold(text.to_owned(), |text, digit| {
        text.replace(&format!(" -{digit}"), &format!(" −{digit}"))
    })
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
    let error = "± standard error".to_owned();
    let mut pair = |name: &str| head.extend([name.to_owned(), error.clone()]);
    pair("error");
    for name in report.observables() {
        pair(&format!("weak error of {name}"));
    }
    head.push("largest error of the invariant".to_owned());
    head.extend(["drift".to_owned(), error]);
    head.extend(
        [
            "ns a step",
            "± half the interquartile range",
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
    let mut kinds = vec![Kind {
        name: "Error at the end (root of the mean square)".to_owned(),
        error: Box::new(strong),
        orders: report.orders().iter().collect(),
    }];
    for (k, name) in report.observables().iter().enumerate() {
        let weak = move |row: &Row| row.weak_errors.get(k).copied();
        let orders = report.weak_orders().iter();
        kinds.push(Kind {
            name: format!("Weak error of {name}"),
            error: Box::new(weak),
            orders: orders
                .filter(|order| order.observable.as_ref() == Some(name))
                .collect(),
        });
    }
    if report.rows().iter().any(|row| row.invariant.is_some()) {
        let invariant = |row: &Row| {
            Some(Estimate {
                value: row.invariant?.largest,
                standard_error: 0.0,
            })
        };
        kinds.push(Kind {
            name: "Largest error of the invariant".to_owned(),
            error: Box::new(invariant),
            orders: Vec::new(),
        });
    }
    let timed = report.rows().iter().any(|row| row.timing.is_some());
    let against = |x: Abscissa, kind: &Kind<'_>, orders: &[&Order]| {
        let panel = panel(report, x, kind, orders).legend(Corner::Below);
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
    let of = |kind: &Kind<'_>| {
        let time = timed.then(|| against(TIME, kind, &[]));
        time.into_iter()
            .chain([against(STEP, kind, &kind.orders)])
            .collect::<Vec<_>>()
    };
    kinds.iter().flat_map(of).collect()
}

/// Draws the errors of all methods, with a guide for each of these orders.
fn panel(
    report: &Report,
    ([against, x_name], x): Abscissa,
    kind: &Kind<'_>,
    orders: &[&Order],
) -> Panel {
    let mut methods: Vec<&str> = Vec::new();
    for row in report.rows() {
        if !methods.contains(&&*row.method) {
            methods.push(&row.method);
        }
    }
    let mut layers: Vec<Layer> = methods
        .iter()
        .enumerate()
        .flat_map(|(number, method)| {
            let rows = report.rows().iter().filter(|row| row.method == *method);
            let points = rows.filter_map(|row| {
                let error = (kind.error)(row)?;
                Some((x(row)?, error.value, error.standard_error))
            });
            Layer::errors(*method, Pen::series(number), points)
        })
        .collect();
    layers.extend(guides(orders, &layers));
    let points = || layers.iter().flat_map(|layer| &layer.points);
    let (xs, ys) = (around(points().map(|p| p.0)), around(points().map(|p| p.1)));
    let empty = Panel::new(
        format!("{} against {against}", kind.name),
        Axis::powers(x_name, xs),
        Axis::powers("error", ys),
    );
    layers.into_iter().fold(empty, Panel::with)
}

/// Returns a line for each measured order, rounded to halves, below the errors of the first method
/// that has it.
fn guides(orders: &[&Order], layers: &[Layer]) -> Vec<Layer> {
    let mut known: Vec<f64> = Vec::new();
    let mut guides = Vec::new();
    for order in orders {
        let slope = (2.0 * order.order.value).round() / 2.0;
        let errors = layers.iter().find(|layer| layer.label == order.method);
        let points = errors
            .into_iter()
            .flat_map(|layer| layer.points.iter().copied());
        let mut points: Vec<_> = points.filter(|point| point.1.is_finite()).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [(x, y), .., (end, _)] = points[..] else {
            continue;
        };
        if known.contains(&slope) {
            continue;
        }
        let Some(&dash) = DASHES.get(known.len()) else {
            break;
        };
        known.push(slope);
        let line = vec![(x, y - BELOW), (end, y - BELOW + slope * (end - x))];
        let pen = Pen::dashed(palette::GREY, 1.2, dash);
        guides.push(Layer::new(format!("order {slope}"), line, pen));
    }
    guides
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
