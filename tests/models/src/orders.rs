//! Orders of convergence: one table of system, rule, noise, expected order and tolerance.
//!
//! The order is the slope of the logarithm of the error against the logarithm of the step size. On
//! paths with noise, the error is the root mean square over paths of the distance of the ends, and
//! the scatter of the slope between batches of paths gives its standard error.

use sve_runtime::__private::{Coordinates, FixedSize};
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Configuration, Rule};

/// Largest accepted deviation of a slope, in standard errors. Two standard errors would reject one
/// row in twenty by chance.
const SIGMAS: f64 = 4.0;

/// Returns the slope of the least-squares line.
pub fn slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
}

/// A measured order.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    /// The slope.
    pub value: f64,
    /// The standard error of the slope; zero without sampling.
    pub error: f64,
}

/// The largest accepted error of a measured order.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Bias, beside four standard errors: at the larger steps the next term of the error still
    /// counts.
    pub bias: f64,
    /// Largest standard error.
    pub error: f64,
}

impl Order {
    /// Returns the order from the errors of steps, each half as long as the step before.
    pub fn of(errors: &[f64]) -> Self {
        let x: Vec<f64> = (0..errors.len()).map(|k| -(k as f64)).collect();
        let y: Vec<f64> = errors.iter().map(|error| error.log2()).collect();
        Self {
            value: slope(&x, &y),
            error: 0.0,
        }
    }

    /// Returns the order from the sums of squared errors in each batch of paths.
    pub fn of_batches(batches: &[Vec<f64>]) -> Self {
        let order = |squares: &[f64]| {
            let errors: Vec<f64> = squares.iter().map(|square| square.sqrt()).collect();
            Self::of(&errors).value
        };
        let total = |level: usize| batches.iter().map(|batch| batch[level]).sum();
        let total: Vec<f64> = (0..batches[0].len()).map(total).collect();
        let slopes: Vec<f64> = batches.iter().map(|batch| order(batch)).collect();
        let count = slopes.len() as f64;
        let mean = slopes.iter().sum::<f64>() / count;
        let squares: f64 = slopes.iter().map(|slope| (slope - mean).powi(2)).sum();
        Self {
            value: order(&total),
            error: (squares / (count - 1.0) / count).sqrt(),
        }
    }

    /// Prints a row of the table, named by system, rule and noise, and checks it.
    ///
    /// # Panics
    /// If the order differs from the expected order.
    pub fn check(self, [system, rule, noise]: [&str; 3], expected: f64, tolerance: Tolerance) {
        let Self { value, error } = self;
        let row = format!("| {system} | {rule} | {noise} | {expected} | {value:.3} ± {error:.3} |");
        println!("{row}");
        let is_as_expected = (value - expected).abs() <= tolerance.bias + SIGMAS * error;
        assert!(is_as_expected && error <= tolerance.error, "{row}");
    }
}

/// A path with noise.
pub struct Path {
    /// The increments of the finest steps.
    pub fine: Recorded,
    /// Coordinates and momenta at the exact end. If it is `None`, each step size is compared with
    /// half of it.
    pub end: Option<Vec<f64>>,
}

/// A function that returns the end of a path by a method.
pub type End<'a> = Box<dyn Fn(&Recorded) -> Vec<f64> + 'a>;

/// A method in a table of orders.
pub struct Row<'a> {
    /// The name of the system.
    pub system: String,
    /// The name of the rule.
    pub rule: String,
    /// The expected order.
    pub order: f64,
    /// The function for the end of a path.
    pub end: End<'a>,
}

impl<'a> Row<'a> {
    /// Returns the row of a rule with the strong order that its plan states.
    ///
    /// # Panics
    /// If the plan states no number.
    pub fn new<S, R, Q, const N: usize, const M: usize>(system: S, rule: R, start: State<Q>) -> Self
    where
        S: System<Dims = Dims<N, M, Q>> + 'a,
        R: Rule<S::Itself> + 'a,
        Q: Coordinates<N>,
    {
        let integrator = Integrator::new(system, rule);
        let plan = integrator.plan();
        Self {
            system: plan.system.to_owned(),
            rule: match plan.substeps {
                Some(substeps) => format!("{}, {}", plan.rule, substeps.composition),
                None => plan.rule.to_owned(),
            },
            order: match plan.strong_order {
                StrongOrder::Half { .. } => 0.5,
                StrongOrder::One => 1.0,
                StrongOrder::OneAndAHalf => 1.5,
                StrongOrder::Two => 2.0,
                StrongOrder::Three => 3.0,
                StrongOrder::Deterministic => f64::from(plan.deterministic_order),
                other => panic!("{other:?}"),
            },
            end: Box::new(move |path| end(&integrator, start, path)),
        }
    }

    /// Returns the row with another order than the plan states.
    #[must_use]
    pub fn of_order(self, order: f64) -> Self {
        Self { order, ..self }
    }

    /// Returns a row for each of the rules with one node and for Störmer–Verlet.
    pub fn rules<S, Q, const N: usize, const M: usize>(system: S, start: State<Q>) -> Vec<Self>
    where
        S: System<Dims = Dims<N, M, Q>> + Copy + 'a,
        InitialPoint: Rule<S::Itself>,
        Midpoint: Rule<S::Itself>,
        StormerVerlet: Rule<S::Itself>,
        Endpoint: Rule<S::Itself>,
        Q: Coordinates<N>,
    {
        vec![
            Self::new(system, InitialPoint, start),
            Self::new(system, Midpoint, start),
            Self::new(system, StormerVerlet, start),
            Self::new(system, Endpoint, start),
        ]
    }
}

/// Returns coordinates and momenta at the end of a recorded path.
///
/// # Panics
/// If a step fails.
pub fn end<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<Q>,
    path: &Recorded,
) -> Vec<f64>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    let end = integrator.trajectory(start, path.h(), path).last();
    numbers(&end.expect("a step").expect("a solution"))
}

/// Returns coordinates, then momenta. Quaternions are continuous along a path, so that the
/// quaternions of two steps on the same path have the same sign.
pub fn numbers<Q: FixedSize>(state: &State<Q>) -> Vec<f64> {
    let mut numbers = vec![0.0; Q::STORED_VALUES + Q::DEGREES_OF_FREEDOM];
    let (q, p) = numbers.split_at_mut(Q::STORED_VALUES);
    state.q.store(q);
    state.p.store(p);
    numbers
}

/// Returns the squared distance of two ends.
///
/// # Panics
/// If they have different lengths.
pub fn distance2(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
}

/// Returns the sum of all increments of each process.
///
/// # Panics
/// If the path has another number of processes.
pub fn total<const M: usize>(path: &Recorded) -> [f64; M] {
    let whole = path.coarsen(path.len()).expect("one step");
    let increments = whole.get(0).expect("a step");
    increments.try_into().expect("so many processes")
}

/// The paths to time 1 on which orders are measured, and the numbers of steps: 2ᵏ and, level by
/// level, twice as many.
#[derive(Clone, Copy, Debug)]
pub struct Paths {
    /// Seed of the noise.
    pub seed: u64,
    /// Batches of paths.
    pub batches: u64,
    /// Paths of a batch.
    pub count: u64,
    /// Exponent of the fewest steps.
    pub coarsest: u32,
    /// Numbers of steps that are measured.
    pub levels: u32,
    /// Exponent of the steps that are recorded.
    pub finest: u32,
    /// The largest accepted error of an order.
    pub tolerance: Tolerance,
}

impl Paths {
    /// Returns a path with the increments of so many processes.
    ///
    /// # Panics
    /// If an increment is not finite.
    pub fn record(&self, path: u64, processes: usize) -> Recorded {
        let h = 0.5_f64.powi(self.finest as i32);
        let noise = Wiener::new(self.seed).path(path);
        Recorded::record(noise, h, processes, 1 << self.finest).expect("finite increments")
    }

    /// Returns paths with an end that `end` computes from the increments of so many processes.
    pub fn against(
        self,
        processes: usize,
        end: impl Fn(&Recorded) -> Vec<f64>,
    ) -> impl Fn(u64) -> Path {
        move |path| {
            let fine = self.record(path, processes);
            let end = Some(end(&fine));
            Path { fine, end }
        }
    }

    /// Measures the orders of methods on the same paths.
    ///
    /// # Panics
    /// If a step fails.
    pub fn measure(&self, rows: &[Row<'_>], path: &dyn Fn(u64) -> Path) -> Vec<Order> {
        let mut tables = vec![Vec::new(); rows.len()];
        for batch in 0..self.batches {
            let mut squares = vec![vec![0.0; self.levels as usize]; rows.len()];
            for member in 0..self.count {
                let path = path(batch * self.count + member);
                for (squares, row) in squares.iter_mut().zip(rows) {
                    self.add(squares, row, &path);
                }
            }
            for (table, squares) in tables.iter_mut().zip(squares) {
                table.push(squares);
            }
        }
        tables
            .iter()
            .map(|table| Order::of_batches(table))
            .collect()
    }

    /// Adds the squared errors of a method on a path.
    fn add(&self, squares: &mut [f64], row: &Row<'_>, path: &Path) {
        let end = |level: u32| {
            let parts = path.fine.len() >> (self.coarsest + level);
            (row.end)(&path.fine.coarsen(parts).expect("whole steps"))
        };
        let last = self.levels + u32::from(path.end.is_none());
        let ends: Vec<_> = (0..last).map(end).collect();
        for (level, square) in squares.iter_mut().enumerate() {
            let exact = path.end.as_ref().unwrap_or_else(|| &ends[level + 1]);
            *square += distance2(&ends[level], exact);
        }
    }

    /// Prints and checks a row of the table for each method.
    ///
    /// # Panics
    /// If an order differs from the expected order.
    pub fn check(&self, noise: &str, rows: &[Row<'_>], path: impl Fn(u64) -> Path) {
        for (row, order) in rows.iter().zip(self.measure(rows, &path)) {
            order.check([&row.system, &row.rule, noise], row.order, self.tolerance);
        }
    }
}
