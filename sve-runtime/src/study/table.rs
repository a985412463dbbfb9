//! The table of a report, for a terminal.

use core::fmt;

use super::estimate::Estimate;
use super::order::{NotAsymptotic, Order};
use super::report::{Report, Row};

const HEAD: [&str; 12] = [
    "method",
    "h",
    "error",
    "± se",
    "weak error",
    "± se",
    "invariant",
    "drift",
    "ns/step",
    "time",
    "iterations",
    "failures",
];

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let paths = match self.paths {
            1 => "1 path".to_owned(),
            n => format!("{n} paths"),
        };
        write!(f, "{} to t = {}, {paths}", self.problem, self.horizon)?;
        if let Some(first) = self.observables.first() {
            write!(f, ", weak error of {first}")?;
        }
        writeln!(f)?;
        let rows: Vec<[String; 12]> = self.rows.iter().map(cells).collect();
        let width = |column: usize| {
            let cells = rows.iter().map(|row| row[column].chars().count());
            cells.max().unwrap_or(0).max(HEAD[column].chars().count())
        };
        let widths: [usize; 12] = core::array::from_fn(width);
        line(f, &HEAD, &widths)?;
        for row in &rows {
            line(f, &row.each_ref().map(String::as_str), &widths)?;
        }
        (self.conclusions().iter()).try_for_each(|line| writeln!(f, "  {line}"))
    }
}

impl Report {
    /// Returns a line for each order, strong and weak, and for each method without one.
    pub(crate) fn conclusions(&self) -> Vec<String> {
        let [strong, weak] = [&self.orders, &self.weak_orders];
        let [no_strong, no_weak] = [&self.not_asymptotic, &self.weak_not_asymptotic];
        let strong = strong.iter().map(|order| format!("order of {order}"));
        let no_strong = no_strong.iter().map(|method| format!("order of {method}"));
        let weak = weak.iter().map(|order| format!("weak order of {order}"));
        let no_weak = no_weak
            .iter()
            .map(|method| format!("weak order of {method}"));
        strong.chain(no_strong).chain(weak).chain(no_weak).collect()
    }
}

/// Returns the method, with the observable of a weak order.
fn subject(method: &str, observable: Option<&String>) -> String {
    match observable {
        None => method.to_owned(),
        Some(name) => format!("{method}, mean of {name}"),
    }
}

/// The method, its order with the error rounded up, and whether that is more than the method's own.
impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Estimate {
            value,
            standard_error,
        } = self.order;
        // No error is printed as 0.
        let error = 1e-3 * (1e3 * standard_error).ceil().max(1.0);
        write!(
            f,
            "{}: {value:.3} ± {error:.3} from {} step sizes",
            subject(&self.method, self.observable.as_ref()),
            self.points
        )?;
        conjugate(f, self.of_method.filter(|_| self.exceeds_method()))
    }
}

/// The reason why errors may decrease faster than the order of their method.
fn conjugate(f: &mut fmt::Formatter<'_>, order: Option<f64>) -> fmt::Result {
    match order {
        Some(order) => write!(
            f,
            "; the method has order {order}, and its errors of that order cancel at this time, as where a rule is conjugate to \
             one of higher order (initial point and endpoint are, to Störmer–Verlet, for L = T(v) − V(q))"
        ),
        None => Ok(()),
    }
}

/// The method and its local slopes.
impl fmt::Display for NotAsymptotic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let subject = subject(&self.method, self.observable.as_ref());
        write!(f, "{subject}: not asymptotic")?;
        match &self.slopes[..] {
            [] if self.observable.is_some() => f.write_str(
                ", fewer than two step sizes with errors of one sign below a quarter of the observable and above rounding and scatter of the paths",
            ),
            [] => f.write_str(
                ", no two step sizes with errors between a quarter of the solution and rounding",
            ),
            slopes => {
                let slopes: Vec<String> =
                    slopes.iter().map(|s| format!("{:.2}", s.value)).collect();
                write!(f, ", local slopes {}", slopes.join(", "))?;
                conjugate(f, self.of_method.filter(|_| self.exceeds_method()))
            }
        }
    }
}

fn line(f: &mut fmt::Formatter<'_>, cells: &[&str; 12], widths: &[usize; 12]) -> fmt::Result {
    // numbers to the right, names to the left
    write!(f, "  {:<1$}", cells[0], widths[0])?;
    for (cell, width) in cells.iter().zip(widths).skip(1) {
        write!(f, "  {cell:>width$}")?;
    }
    writeln!(f)
}

fn cells(row: &Row) -> [String; 12] {
    let number = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), |x| format!("{x:.2e}"));
    let weak = row.weak_errors.first();
    [
        row.method.clone(),
        number(Some(row.h)),
        number(row.error.map(|e| e.value)),
        number(row.error.map(|e| e.standard_error)),
        number(weak.map(|e| e.value)),
        number(weak.map(|e| e.standard_error)),
        number(row.invariant.map(|i| i.largest)),
        number(row.invariant.map(|i| i.drift.value)),
        row.timing.map_or_else(
            || "–".to_owned(),
            |t| format!("{:.1} ± {:.1}", t.ns_per_step, t.ns_spread),
        ),
        row.timing.map_or_else(
            || "–".to_owned(),
            |t| format!("{:.2e} s", t.time_to_solution),
        ),
        row.newton_iterations
            .map_or_else(|| "–".to_owned(), |n| format!("{n:.2}")),
        row.failures.to_string(),
    ]
}
