//! The gain of using a system's structure: every scene's derived step against the step without
//! structure.
//!
//! The step without structure is one Newton iteration in all unknowns of the rule, displacement,
//! velocity and momentum, with the full symbolic Jacobian. It computes all values in each
//! iteration, as generic code would. Solver and stopping rule are the same. Prints the table, and
//! writes a page with the table and a picture to `target/structure/`.

mod scenes;

use std::error::Error;
use std::fmt::{Display, Write};
use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use scenes::{Facts, Scene, Visitor, every_scene};
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Shape};
use sve_examples::report::one_row;
use sve_examples::{palette, render};
use sve_runtime::__private::Unstructured;
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::Variational;
use sve_runtime::plot::page::{self, number};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, StateOf, System};

/// Number of steps of a run, all from the scene's start.
const STEPS: usize = 512;

/// Number of timed runs of each step; the result is the median. The runs alternate, so that a busy
/// machine affects both steps.
const RUNS: usize = 31;

/// Shortest duration of a run.
const RUN: Duration = Duration::from_micros(500);

/// The facts, iterations and times of one of the two steps.
struct Side {
    facts: Facts,
    iterations: f64,
    nanoseconds: f64,
}

/// A scene with its two steps.
struct Row {
    scene: String,
    derived: Side,
    unstructured: Side,
}

#[derive(Default)]
struct Rows(Vec<Result<Row, StepError>>);

impl Visitor for Rows {
    fn visit<S, R, Q, const N: usize, const M: usize>(&mut self, scene: &Scene<S, R>)
    where
        S: System<Dims = Dims<N, M, Q>> + Variational<R> + Variational<Unstructured<R>> + Copy,
        Q: VectorCoordinates<N>,
        R: Copy,
    {
        self.0.push(row(scene));
    }
}

fn row<S, R, Q, const N: usize, const M: usize>(scene: &Scene<S, R>) -> Result<Row, StepError>
where
    S: System<Dims = Dims<N, M, Q>> + Variational<R> + Variational<Unstructured<R>> + Copy,
    Q: VectorCoordinates<N>,
    R: Copy,
{
    let wiener = Wiener::new(1);
    let increments: Vec<[f64; M]> = (0..STEPS as u64)
        .map(|k| core::array::from_fn(|i| wiener.increment(k, i, scene.h)))
        .collect();
    let derived = Runner::new(&scene.derived, scene.start, scene.h, &increments)?;
    let unstructured = Runner::new(&scene.unstructured, scene.start, scene.h, &increments)?;
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..RUNS {
        times[0].push(derived.time()?);
        times[1].push(unstructured.time()?);
    }
    let [of_derived, of_unstructured] = times.map(median);
    Ok(Row {
        scene: format!("{}, `{}`", scene.name, scene.derived.plan().rule),
        derived: Side {
            facts: Facts::of::<S, R>(),
            iterations: iterations(&scene.derived, scene.start, scene.h, &increments)?,
            nanoseconds: of_derived,
        },
        unstructured: Side {
            facts: Facts::of::<S, Unstructured<R>>(),
            iterations: iterations(&scene.unstructured, scene.start, scene.h, &increments)?,
            nanoseconds: of_unstructured,
        },
    })
}

/// Steps to be timed.
struct Runner<'a, S: System, R, const M: usize> {
    integrator: &'a Integrator<S, R>,
    start: StateOf<S>,
    h: f64,
    increments: &'a [[f64; M]],
    /// Number of passes along the path in a run.
    passes: u32,
}

impl<'a, S, R, Q, const N: usize, const M: usize> Runner<'a, S, R, M>
where
    S: System<Dims = Dims<N, M, Q>> + Variational<R>,
    Q: VectorCoordinates<N>,
{
    fn new(
        integrator: &'a Integrator<S, R>,
        start: State<Q>,
        h: f64,
        increments: &'a [[f64; M]],
    ) -> Result<Self, StepError> {
        let mut runner = Self {
            integrator,
            start,
            h,
            increments,
            passes: 1,
        };
        while runner.run()? < RUN {
            runner.passes *= 2;
        }
        Ok(runner)
    }

    fn run(&self) -> Result<Duration, StepError> {
        let clock = Instant::now();
        for _ in 0..self.passes {
            let (mut state, h) = (black_box(self.start), black_box(self.h));
            let prepared = OneStepMethod::prepare(self.integrator, h)?;
            for dw in self.increments {
                OneStepMethod::step_prepared(self.integrator, &prepared, &mut state, h, dw)?;
            }
            black_box(state);
        }
        Ok(clock.elapsed())
    }

    /// Returns nanoseconds a step.
    fn time(&self) -> Result<f64, StepError> {
        let steps = f64::from(self.passes) * self.increments.len() as f64;
        Ok(self.run()?.as_secs_f64() * 1e9 / steps)
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Returns the mean number of iterations of the steps: the smallest limit with which each step
/// succeeds.
fn iterations<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    mut state: State<Q>,
    h: f64,
    increments: &[[f64; M]],
) -> Result<f64, StepError>
where
    S: System<Dims = Dims<N, M, Q>> + Variational<R> + Clone,
    Q: VectorCoordinates<N>,
    R: Clone,
{
    let mut sum = 0;
    for dw in increments {
        let arrives = |limit: u32| {
            let newton = Newton {
                max_iterations: limit,
                ..*integrator.newton()
            };
            let limited = integrator.clone().with_newton(newton);
            limited.step(&mut { state }, h, dw).is_ok()
        };
        let most = integrator.newton().max_iterations;
        sum += (0..most).find(|&limit| arrives(limit)).unwrap_or(most);
        integrator.step(&mut state, h, dw)?;
    }
    Ok(f64::from(sum) / increments.len() as f64)
}

/// Names of the columns of the table.
const HEAD: [&str; 10] = [
    "scene, rule",
    "blocks",
    "operations",
    "calls",
    "additions",
    "n",
    "state",
    "beside it",
    "ns a step",
    "ratio",
];

/// Returns the table of the differences between the step without structure and the derived step, in
/// columns of equal width.
fn markdown(rows: &[[String; 10]]) -> Result<String, std::fmt::Error> {
    let long = |text: &str| text.chars().count();
    let width = |column: usize| {
        let cells = rows.iter().map(|row| long(&row[column]));
        cells.fold(long(HEAD[column]), usize::max)
    };
    let widths: [usize; 10] = std::array::from_fn(width);
    let line = |cells: [&str; 10]| {
        let padded = cells.iter().zip(widths);
        let padded: Vec<_> = padded
            .map(|(cell, width)| format!("{cell:width$}"))
            .collect();
        format!("| {} |", padded.join(" | "))
    };
    let mut text = String::new();
    writeln!(text, "{}", line(HEAD))?;
    writeln!(text, "{}", line(["---"; 10]))?;
    for row in rows {
        writeln!(text, "{}", line(row.each_ref().map(String::as_str)))?;
    }
    Ok(text)
}

fn cells(row: &Row) -> [String; 10] {
    let Row {
        scene,
        derived,
        unstructured,
    } = row;
    let (a, b) = (&unstructured.facts, &derived.facts);
    let change = |a: &dyn Display, b: &dyn Display| {
        let (a, b) = (a.to_string(), b.to_string());
        if a == b { a } else { format!("{a} → {b}") }
    };
    let tenths = |x: f64| format!("{x:.1}");
    [
        scene.clone(),
        change(&a.blocks, &b.blocks),
        change(&a.operations, &b.operations),
        change(&a.calls, &b.calls),
        change(&a.additions, &b.additions),
        change(
            &tenths(unstructured.iterations),
            &tenths(derived.iterations),
        ),
        b.state.to_string(),
        change(&a.beside, &b.beside),
        change(
            &tenths(unstructured.nanoseconds),
            &tenths(derived.nanoseconds),
        ),
        tenths(unstructured.nanoseconds / derived.nanoseconds),
    ]
}

/// Draws a line for each scene, from the time without structure to the time with it.
fn figure(rows: &[Row]) -> Figure {
    let place = |at: usize| (rows.len() - at) as f64;
    let points = |side: fn(&Row) -> &Side| -> Vec<(f64, f64)> {
        let times = rows.iter().enumerate();
        times
            .map(|(at, row)| (side(row).nanoseconds.log10(), place(at)))
            .collect()
    };
    let (derived, unstructured) = (points(|row| &row.derived), points(|row| &row.unstructured));
    let last = unstructured
        .iter()
        .fold(2.0, |last: f64, point| last.max(point.0));
    // The names of the scenes stand left of all times.
    let first = -0.9;
    let mut times = Axis::powers("time of a step (ns)", first..last + 0.6);
    times.labels = 8;
    let mut scenes = Axis::new("", 0.0..rows.len() as f64 + 1.0);
    scenes.labels = 0;
    let mut panel = Panel::new(
        "Time of a step, with the structure of the scene and without, and the ratio of the times",
        times,
        scenes,
    );
    for (at, row) in rows.iter().enumerate() {
        let (low, high) = (derived[at], unstructured[at]);
        let ratio = row.unstructured.nanoseconds / row.derived.nanoseconds;
        panel = panel
            .with(Layer::new("", vec![low, high], Pen::line(palette::GREY, 1.0)).unlisted())
            .note(
                (first + 0.05, high.1),
                row.scene.replace('`', ""),
                palette::BLACK,
            )
            .note((high.0 + 0.06, high.1), number(ratio, 2), palette::BLACK);
    }
    let mut open = Pen::dots(palette::VERMILION, 3.5);
    if let Some(symbols) = &mut open.symbol {
        symbols.shape = Shape::Circle;
    }
    let panel = panel
        .with(Layer::new(
            "with structure",
            derived,
            Pen::dots(palette::BLUE, 3.5),
        ))
        .with(Layer::new("without", unstructured, open))
        .legend(Corner::TopRight);
    one_row("structure", [860, 80 + 22 * rows.len() as u32], vec![panel])
}

/// The explanation of the columns.
const LEGEND: &str = "Without structure → with it; one value where both are the same.
operations, calls of functions, angle additions (sines and cosines from those of an angle near by): of a step and of n iterations
n: iterations that moved the unknowns, on average; one more evaluation may tell that the last one arrived
state, beside it: bytes of the state, and of what is kept for a step size with the largest system of equations
ratio: of the times";

fn main() -> Result<(), Box<dyn Error>> {
    let mut rows = Rows::default();
    every_scene(&mut rows);
    let rows: Vec<Row> = rows.0.into_iter().collect::<Result<_, _>>()?;
    let cells: Vec<_> = rows.iter().map(cells).collect();
    let table = markdown(&cells)?;
    println!("{table}\n{LEGEND}");
    let folder = Path::new("target/structure");
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("structure.md"), &table)?;
    let figure = figure(&rows);
    std::fs::write(folder.join("structure.svg"), render::svg(&figure)?)?;
    std::fs::write(folder.join("structure.png"), render::png(&figure)?)?;
    let cells: Vec<_> = cells.into_iter().map(|row| ("", row.to_vec())).collect();
    let table = page::table(&HEAD, &cells);
    let legend = page::escape(LEGEND).replace('\n', "<br>\n");
    let body = format!(
        "<figure>\n{}\n</figure>\n{table}<p>{legend}</p>\n",
        render::panels(&figure)?
    );
    let page = folder.join("index.html");
    std::fs::write(&page, page::document("The gain of structure", &body))?;
    println!("page: {}", page.display());
    Ok(())
}
