//! The page of an ensemble: means with their standard errors, histograms, numbers at the end.
//!
//! Input: a [`Summary`]. Output: HTML. Invariant: what is drawn has its standard error beside it.

use core::fmt::Write as _;
use core::ops::Range;
use std::path::Path;

use super::bounds::around;
use super::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use super::{PlotError, page, palette};
use crate::ensemble::{Histogram, Passages, Statistics, Summary};

/// Half the width of bands and bars, in standard errors.
const ERRORS: f64 = 2.0;
/// Part of the height of a panel that a legend needs.
const LEGEND: f64 = 0.15;
/// Points of a line with symbols of their own.
const SYMBOLS: usize = 12;

impl Summary {
    /// Writes a page that says what was run (system with its parameters, method, steps, paths,
    /// noise and seed), with pictures of the means, histograms and first passages, and tables of
    /// the statistics at the end and of the rates of first passages.
    ///
    /// Bands and bars have two standard errors on either side; of a histogram's bin with n of N
    /// paths that is √(n (1 − n/N)).
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator { sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let method = Integrator::new(Oscillator { sigma: 1.0 }, Midpoint);
    /// let summary = Ensemble::new(&method)
    ///     .paths(200).steps(0.1, 100).every(10)
    ///     .start(State::new([1.0], [0.0]))
    ///     .observe("energy", |system, state| system.hamiltonian(state))
    ///     .observe("q", |_, state| state.q[0])
    ///     .histogram("q", -40.0..40.0, 40)
    ///     .first_passage("far out", |_, state| state.q[0] - 5.0)
    ///     .run()?;
    /// # let folder = std::env::temp_dir().join(format!("sve-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder)?;
    /// # let path = folder.join("oscillator.html");
    /// # let written = path.clone();
    /// # /*
    /// let path = "oscillator.html";
    /// # */
    /// summary.write_html(path)?;
    /// # let page = std::fs::read_to_string(&written)?;
    /// # assert!(page.contains("<svg") && page.contains("of 200 paths passed") && page.contains("survival ± 2 standard errors"));
    /// # assert!(page.contains("<code>Oscillator</code>") && page.contains("<code>sigma</code> = 1") && page.contains("100 steps of h = 0.1"));
    /// # std::fs::remove_dir_all(&folder)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`PlotError`] when the page cannot be written.
    pub fn write_html(&self, path: impl AsRef<Path>) -> Result<(), PlotError> {
        let mut title = format!("Ensemble of {}", page::count(self.paths(), "path"));
        if let Some(&t) = self.times().last() {
            title.push_str(" to t = ");
            title.push_str(&page::number(t, 6));
        }
        let mut body = page::facts(&facts(self));
        for warning in self.warnings() {
            body.push_str("<p class=\"warning\">");
            body.push_str(&page::escape(&warning.to_string()));
            body.push_str("</p>\n");
        }
        let figures = figures(self);
        if !figures.is_empty() {
            body += &page::panels(
                &figures,
                "Bands and bars: two standard errors on either side.",
            )?;
        }
        body += &table(self);
        body += &table_of_passages(self);
        if let Some(first) = self.failures().first() {
            body.push_str("<p>First failure: ");
            body.push_str(&page::escape(&first.to_string()));
            body.push_str("</p>\n");
        }
        page::write(path.as_ref(), &page::document(&title, &body))
    }
}

/// Returns the facts about a run.
fn facts(summary: &Summary) -> Vec<(&'static str, String)> {
    let run = summary.description();
    let mut facts = page::facts_of_system(&run.system);
    facts.push(("method", run.method.clone()));
    let h = page::exact(run.h);
    facts.push((
        "steps",
        format!("{} of h = {h}", page::count(run.steps, "step")),
    ));
    let mut paths = vec![page::count(summary.paths(), "path")];
    if !summary.is_complete() {
        paths.push(format!("of {}", summary.paths_of_ensemble()));
    }
    if summary.failed() > 0 {
        paths.push(format!("of which {} failed", summary.failed()));
    }
    if summary.refined_steps() > 0 {
        let refined = page::count(summary.refined_steps(), "step");
        paths.push(format!("{refined} made in smaller ones"));
    }
    facts.push(("paths", paths.join(", ")));
    let noise = if run.noise.is_empty() {
        "none"
    } else {
        &run.noise
    };
    facts.push(("noise", noise.to_owned()));
    let seed = if run.seed == run.start_seed {
        run.seed.to_string()
    } else {
        format!(
            "{} of the noise, {} of the starts",
            run.seed, run.start_seed
        )
    };
    facts.push(("seed", seed));
    facts
}

/// A figure for each observable, then for each histogram, then for each first passage.
fn figures(summary: &Summary) -> Vec<Figure> {
    let times = summary.times();
    let means = summary.statistics().iter().map(|s| mean(times, s));
    let histograms = summary.histograms().iter();
    let histograms = histograms.map(|of| histogram(of, summary.is_antithetic()));
    let passages = summary.passages().iter().map(survival);
    let panels = means.chain(histograms).chain(passages);
    let figure = |panel| Figure {
        name: "ensemble",
        width: 540,
        rows: vec![Row {
            height: 320,
            panels: vec![panel],
        }],
    };
    panels.map(figure).collect()
}

fn mean(times: &[f64], statistics: &Statistics) -> Panel {
    let errors = statistics.standard_error();
    let points: Vec<(f64, f64)> = times
        .iter()
        .copied()
        .zip(statistics.mean().iter().copied())
        .collect();
    let ends = points.iter().zip(&errors);
    let ends: Vec<(f64, f64)> = ends
        .map(|(&(_, mean), error)| (mean - ERRORS * error, mean + ERRORS * error))
        .collect();
    let all = points.iter().map(|p| p.1);
    let all = all.chain(ends.iter().flat_map(|&(low, high)| [low, high]));
    let name = statistics.name();
    let (x, mut y) = (around(times.iter().copied()), around(all));
    let corner = free_corner(&points, &ends, &x, &y).unwrap_or_else(|| {
        y.end += LEGEND * (y.end - y.start);
        Corner::TopLeft
    });
    let panel = Panel::new(
        format!("Mean of {name}"),
        Axis::new("time t", x),
        Axis::new(name, y),
    );
    let pen = if points.len() > SYMBOLS {
        Pen::line(palette::BLUE, 1.5)
    } else {
        Pen::series(0)
    };
    let layer = Layer::new("mean ± 2 standard errors", points, pen);
    let layer = if times.len() > SYMBOLS {
        layer.band(ends)
    } else {
        layer.bars(ends)
    };
    panel.with(layer).legend(corner)
}

/// Returns a corner with room for a legend of half of the width, in which no point and no end of a
/// bar is.
fn free_corner(
    points: &[(f64, f64)],
    ends: &[(f64, f64)],
    x: &Range<f64>,
    y: &Range<f64>,
) -> Option<Corner> {
    let middle = f64::midpoint(x.start, x.end);
    let high = y.end - LEGEND * (y.end - y.start);
    let low = y.start + LEGEND * (y.end - y.start);
    let is_free = |is_left: bool, is_top: bool| {
        points.iter().zip(ends).all(|(&(x, value), &(from, to))| {
            let is_beside = (x > middle) == is_left && x != middle;
            let is_there = |y: f64| if is_top { y > high } else { y < low };
            is_beside || ![value, from, to].into_iter().any(is_there)
        })
    };
    [
        (Corner::TopRight, false, true),
        (Corner::TopLeft, true, true),
        (Corner::BottomRight, false, false),
        (Corner::BottomLeft, true, false),
    ]
    .into_iter()
    .find_map(|(corner, is_left, is_top)| is_free(is_left, is_top).then_some(corner))
}

/// A histogram. Its bars are the errors of a multinomial count, which antithetic pairs do not have.
fn histogram(histogram: &Histogram, are_pairs: bool) -> Panel {
    let (edges, counts) = (histogram.edges(), histogram.counts());
    let last = histogram.rows() - 1;
    let inside: u64 = counts.iter().sum();
    let outside = histogram.below_at(last) + histogram.above_at(last);
    let paths = (inside + outside) as f64;
    let (mut outline, mut points, mut ends) = (Vec::new(), Vec::new(), Vec::new());
    for (edge, &count) in edges.windows(2).zip(counts) {
        let density = |n: f64| n / (paths * (edge[1] - edge[0]));
        let n = count as f64;
        let error = ERRORS * (n * (1.0 - n / paths)).sqrt();
        outline.extend([(edge[0], density(n)), (edge[1], density(n))]);
        points.push((f64::midpoint(edge[0], edge[1]), density(n)));
        ends.push((density((n - error).max(0.0)), density(n + error)));
    }
    let top = ends.iter().fold(0.0, |top: f64, end| top.max(end.1));
    let errors = Layer::new("", points, Pen::dots(palette::BLUE, 0.0));
    let errors = if are_pairs { errors } else { errors.bars(ends) };
    let name = histogram.name();
    let (first, end) = (edges[0], edges[edges.len() - 1]);
    let title = match outside {
        0 => format!("Distribution of {name} at the end"),
        n => format!("Distribution of {name} at the end; {n} paths outside"),
    };
    let top = if top > 0.0 { 1.08 * top } else { 1.0 };
    Panel::new(
        title,
        Axis::new(name, first..end),
        Axis::new("density", 0.0..top),
    )
    .with(Layer::new("", outline, Pen::line(palette::BLUE, 1.2)).filled(0.0))
    .with(errors)
}

/// The curve of survival with its band, as far as it is known.
fn survival(passages: &Passages) -> Panel {
    let times = passages.times();
    let survival = times.iter().zip(passages.survival());
    let points: Vec<(f64, f64)> = survival.filter_map(|(&t, s)| Some((t, s?))).collect();
    let ends = points.iter().zip(passages.survival_error());
    let ends = ends.map(|(&(_, s), error)| {
        // without a survivor there is no error
        let error = ERRORS * error.unwrap_or(0.0);
        ((s - error).max(0.0), (s + error).min(1.0))
    });
    let ends: Vec<(f64, f64)> = ends.collect();
    let last = |counts: Vec<u64>| counts.last().copied().unwrap_or(0);
    let (passed, censored) = (last(passages.passed()), last(passages.censored()));
    let name = passages.name();
    let mut title = format!("{name}: {passed} of {} paths passed", passages.paths());
    // writing into a String cannot fail
    if censored > 0 {
        let _ = write!(title, ", {censored} censored");
    }
    if let Some(t) = passages.unknown_from() {
        let _ = write!(title, ", unknown from t = {} on", page::number(t, 6));
    }
    let layer = Layer::new(
        "survival ± 2 standard errors",
        points,
        Pen::line(palette::BLUE, 1.5),
    );
    Panel::new(
        title,
        Axis::new("time t", around(times.iter().copied())),
        Axis::new("not yet passed", 0.0..1.05),
    )
    .with(layer.band(ends))
    .legend(Corner::BottomLeft)
}

/// The statistics at the end; nothing without observables.
fn table(summary: &Summary) -> String {
    let paths = summary.counts().last().copied().unwrap_or(0);
    let last = |values: &[f64]| values.last().copied().filter(|_| paths > 0);
    let row = |s: &Statistics| {
        let mut cells = vec![s.name().to_owned(), paths.to_string()];
        cells.extend(page::known_with_error(
            last(s.mean()),
            last(&s.standard_error()),
        ));
        cells.push(page::known(last(&s.standard_deviation()), 4));
        let deviation = last(&s.standard_deviation()).unwrap_or(f64::NAN);
        for value in [last(s.min()), last(s.max())] {
            let text = value.map(|value| page::number_beside(value, deviation));
            cells.push(text.unwrap_or_else(|| page::NONE.to_owned()));
        }
        ("", cells)
    };
    let rows: Vec<_> = summary.statistics().iter().map(row).collect();
    if rows.is_empty() {
        return String::new();
    }
    let head = [
        "at the end",
        "paths",
        "mean",
        "± standard error",
        "standard deviation",
        "least",
        "greatest",
    ];
    page::table(&head, &rows)
}

/// The first passages with their rates; nothing without such functions.
fn table_of_passages(summary: &Summary) -> String {
    let last = |counts: Vec<u64>| counts.last().copied().unwrap_or(0).to_string();
    let row = |passages: &Passages| {
        let mut cells = vec![
            passages.name().to_owned(),
            last(passages.passed()),
            last(passages.censored()),
            last(passages.at_risk()),
        ];
        let (survival, error) = (passages.survival(), passages.survival_error());
        cells.extend(page::known_with_error(
            survival.last().copied().flatten(),
            error.last().copied().flatten(),
        ));
        let rate = passages.rate(0);
        cells.extend(page::known_with_error(
            Some(rate.value),
            Some(rate.standard_error),
        ));
        cells.push(page::known(Some(rate.exposure), 6));
        ("", cells)
    };
    let rows: Vec<_> = summary.passages().iter().map(row).collect();
    if rows.is_empty() {
        return String::new();
    }
    let head = [
        "first passage",
        "passed",
        "censored",
        "at risk at the end",
        "survival at the end",
        "± standard error",
        "rate",
        "± standard error",
        "time at risk",
    ];
    page::table(&head, &rows)
}

#[cfg(test)]
mod tests {
    use super::{Corner, free_corner};

    #[test]
    fn a_legend_stands_where_no_curve_and_no_bar_is() {
        let corner = |points: &[(f64, f64)], bar: f64| {
            let ends: Vec<_> = points.iter().map(|p| (p.1 - bar, p.1 + bar)).collect();
            free_corner(points, &ends, &(0.0..1.0), &(0.0..1.0))
        };
        let curve = |y: fn(f64) -> f64| -> Vec<(f64, f64)> {
            (0..=20)
                .map(|k| f64::from(k) / 20.0)
                .map(|x| (x, y(x)))
                .collect()
        };
        let (falling, rising) = (curve(|x| 1.0 - x), curve(|x| x));
        assert_eq!(corner(&falling, 0.0), Some(Corner::TopRight));
        assert_eq!(corner(&rising, 0.0), Some(Corner::TopLeft));
        let high = curve(|x| if x < 0.9 { 0.95 } else { 0.5 });
        assert_eq!(corner(&high, 0.0), Some(Corner::BottomRight));
        assert_eq!(corner(&falling, 0.4), None);
    }
}
