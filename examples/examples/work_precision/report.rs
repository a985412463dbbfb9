//! The page: for each problem a verdict in words, the figure, orders, and all numbers.

use std::fmt::Write as _;

use sve_runtime::plot::page::{self, escape};
use sve_runtime::study::Record;

use crate::problem::Problem;
use crate::verdict::{Winner, duration, rounded};

/// The text and the figures of a problem on the page.
pub(crate) struct Section<'a> {
    pub(crate) problem: &'a Problem,
    /// The fastest methods by ranges of errors, in words.
    pub(crate) conclusions: &'a str,
    /// The picture of the errors at the end by few methods, as markup.
    pub(crate) picture: &'a str,
    /// The figure of all errors and methods, as markup.
    pub(crate) figure: &'a str,
    pub(crate) records: &'a [Record],
}

const STYLE: &str = "<style>
details table { font-size: 12px }
details td { white-space: nowrap }
details { margin: 0 0 2rem }
@media print { details { display: none } }
</style>";

/// Returns the conclusion for a kind of error in words, with times.
pub(crate) fn conclusion(what: &str, winners: &[Winner]) -> String {
    let parts: Vec<String> = winners
        .iter()
        .map(|winner| {
            let [(short, high), (long, low)] = winner.ends();
            let name = escape(&winner.name);
            if winner.trace.len() == 1 {
                let (at, time) = (rounded(high), duration(short));
                return format!("at {at} <strong>{name}</strong> ({time})");
            }
            format!(
                "from {} to {} <strong>{name}</strong> ({} to {})",
                rounded(high),
                rounded(low),
                duration(short),
                duration(long)
            )
        })
        .collect();
    if parts.is_empty() {
        String::new()
    } else {
        format!("<p>For {}: {}.</p>", escape(what), parts.join(", "))
    }
}

/// Returns conclusions for a terminal, one line each, starting with the problem.
pub(crate) fn plain(problem: &str, conclusions: &str) -> String {
    let text = conclusions.replace("<strong>", "").replace("</strong>", "");
    let mut lines = String::new();
    for line in text.split("<p>").filter(|line| !line.is_empty()) {
        // Writing into a String cannot fail.
        let _ = writeln!(lines, "{problem} | {}", line.replace("</p>", ""));
    }
    lines
}

/// Returns the orders, or local slopes if the errors have no order.
fn orders(problem: &Problem) -> String {
    let report = &problem.report;
    let orders = report.orders().iter().map(ToString::to_string);
    let others = report.not_asymptotic().iter().map(ToString::to_string);
    let items: Vec<String> = orders
        .chain(others)
        .map(|line| format!("<li>{}</li>", escape(&line)))
        .collect();
    format!(
        "<p>Measured strong orders. Errors of orders contain the scatter between paths and the bias of step sizes that are not small \
         enough.</p>\n<ul>{}</ul>\n",
        items.join("\n")
    )
}

const HEAD: [&str; 13] = [
    "method",
    "h",
    "error",
    "± se",
    "weak error",
    "± se",
    "invariant",
    "drift",
    "ns/step",
    "±",
    "time",
    "iterations",
    "failures",
];

fn table(records: &[Record]) -> String {
    let number = |x: Option<f64>| x.map_or_else(String::new, |x| page::number(x, 3));
    let row = |record: &Record| {
        let method = if record.source.starts_with("sve ") {
            record.method.clone()
        } else {
            format!("{} ({})", record.method, record.source)
        };
        let cells = vec![
            method,
            number(record.h),
            number(record.error),
            number(record.error_se),
            number(record.weak_error),
            number(record.weak_error_se),
            number(record.energy_error),
            number(record.energy_drift),
            number(record.ns_per_step),
            number(record.ns_spread),
            record.time_to_solution_s.map(duration).unwrap_or_default(),
            number(record.newton_iterations),
            record.failures.to_string(),
        ];
        ("", cells)
    };
    let rows: Vec<_> = records.iter().map(row).collect();
    format!(
        "<details><summary>All numbers</summary>\n{}</details>\n",
        page::table(&HEAD, &rows)
    )
}

/// Returns the body of a section.
pub(crate) fn body(section: &Section<'_>) -> String {
    let problem = section.problem;
    format!(
        "<section>\n<h2>{}</h2>\n<p>{}</p>\n{}\n<figure>\n{}\n</figure>\n<figure>\n{}\n</figure>\n{}</section>\n{}",
        escape(problem.title),
        escape(problem.setting),
        section.conclusions,
        section.picture,
        section.figure,
        orders(problem),
        table(section.records)
    )
}

/// Returns the text before the problems.
pub(crate) fn head(machine: &str, peers: usize) -> String {
    let peers = match peers {
        0 => String::from(
            "No results of other programs were found in <code>peers/</code> beside this page.",
        ),
        n => format!(
            "{n} lines of results of other programs were read from <code>peers/</code>; their lines are dotted, and their times as they \
             measured them. Batches of paths are to be compared with those of <code>Ensemble</code>, not with the single paths here. The grey band is that of our own methods."
        ),
    };
    format!(
        "{STYLE}<p>The first picture of each problem shows few methods, the figure below it all, half of them named under each of its upper panels. Down is more precise, left is faster; the grey band follows the fastest \
         method. Variational rules have solid lines, methods to compare with dashed ones.</p>\n\
         <p>Errors are root mean squares over paths of the distance of (q, p) from the reference at the end, on the same Brownian paths for all methods and step sizes. \
         Weak errors are differences of means on these paths; arrows are upper limits of those below two standard errors. Slopes of the invariant are those of least-squares lines through its values; of an error that only oscillates they are what is left at the ends, and change their sign with the step size. Times are medians of alternating repeats, \
         of the steps of one path on one thread, with the increments at hand. A method is called the fastest until another one is 10 % faster. \
         Methods whose errors fall more slowly than h^¼ are not counted among the fastest: they converge to something else, if at all. Where the \
         solution of a problem with noise is not known, a rule of this project with shorter steps, named with the problem, is its reference; errors without noise are those of \
         the coordinates, against ends that were computed with 30 digits.</p>\n\
         <p>Machine: {}. {peers}</p>",
        escape(machine)
    )
}
