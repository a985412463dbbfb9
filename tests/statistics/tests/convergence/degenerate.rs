//! Strong orders of degenerate systems, as rows of the table of `strong_order.rs`. The expected order is within four standard errors of the fit, and the
//! standard error at most 0.03; two standard errors would leave one row in twenty off by chance. Wrong steps fail the same test.

use sve_models::degenerate::wrong::{self, Plain};
use sve_models::degenerate::{
    InternalLotkaVolterra, Kubo, Spin, StormyLotkaVolterra, TumblingSpin, VortexPair,
};
use sve_models::oracle::Rule;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, StrongOrder, System, Variational, VectorCoordinates};

use super::strong_order::{record, slope, total};

/// Batches of paths, from whose scatter the standard error comes.
const BATCHES: u64 = 24;

/// Step sizes that are measured, each half of the one before.
const LEVELS: usize = 5;

/// Exponent of the largest step size 2⁻ᵏ against a reference with steps of 2⁻¹⁴, and against an exact path.
const COARSEST: u32 = 6;
const REFERENCE: u32 = 14;
const COARSEST_EXACT: u32 = 8;

/// The paths of a row.
#[derive(Clone, Copy)]
struct Paths {
    /// Paths of a batch.
    count: u64,
    processes: usize,
    /// Exponents of the coarsest step, and of the steps that are recorded.
    coarsest: u32,
    recorded: u32,
}

/// The slope of the logarithms of the errors of configurations, with its standard error.
fn measure<const N: usize>(
    paths: Paths,
    exact: impl Fn(&Recorded) -> [f64; N],
    end: impl Fn(&Recorded) -> [f64; N],
) -> [f64; 2] {
    let x: [f64; LEVELS] = core::array::from_fn(|k| -(k as f64));
    let mut total = [0.0; LEVELS];
    let mut slopes = Vec::new();
    for batch in 0..BATCHES {
        let mut squares = [0.0; LEVELS];
        for member in 0..paths.count {
            let path = batch * paths.count + member;
            let fine = record(path, paths.processes, paths.recorded);
            let target = exact(&fine);
            for (square, level) in squares.iter_mut().zip(paths.coarsest..) {
                let coarse = fine.coarsen(fine.len() >> level).unwrap();
                let found = end(&coarse);
                *square += (0..N).map(|i| (found[i] - target[i]).powi(2)).sum::<f64>();
            }
        }
        for (sum, square) in total.iter_mut().zip(&squares) {
            *sum += square;
        }
        slopes.push(slope(&x, &squares.map(|s: f64| 0.5 * s.log2())));
    }
    let count = BATCHES as f64;
    let mean = slopes.iter().sum::<f64>() / count;
    let variance = slopes.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let order = slope(&x, &total.map(|s: f64| 0.5 * s.log2()));
    [order, (variance / count).sqrt()]
}

/// The configuration at the end of a recorded path.
fn end<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<Q>,
    path: &Recorded,
) -> [f64; N]
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let end = integrator.trajectory(start, path.h(), path).last();
    end.expect("a step at least").unwrap().q.coordinates()
}

/// Rows of the table.
#[derive(Default)]
struct Table {
    off: Vec<String>,
}

impl Table {
    /// Prints a row.
    fn row(&mut self, names: [&str; 3], expected: f64, [order, error]: [f64; 2]) {
        let [system, rule, noise] = names;
        let row = format!("| {system} | {rule} | {noise} | {expected} | {order:.3} ± {error:.3} |");
        println!("{row}");
        if error > 0.03 || (order - expected).abs() > 4.0 * error {
            self.off.push(row);
        }
    }

    /// Checks all rows.
    fn check(self) {
        assert!(self.off.is_empty(), "{:#?}", self.off);
    }
}

/// A row of a rule, against an exact end or the midpoint rule with small steps.
fn stochastic<S, R, Q, const N: usize, const M: usize>(
    table: &mut Table,
    (system, rule): (S, R),
    noise: &str,
    start: State<Q>,
    count: u64,
    exact: Option<&dyn Fn([f64; M]) -> [f64; N]>,
) where
    S: Variational<R> + Variational<Midpoint> + System<Dims = Dims<N, M, Q>> + Copy,
    R: Rule,
    Q: VectorCoordinates<N>,
{
    let integrator = Integrator::new(system, rule);
    let reference = Integrator::new(system, Midpoint);
    let plan = integrator.plan();
    let expected = match plan.strong_order {
        StrongOrder::One => 1.0,
        StrongOrder::Half { .. } => 0.5,
        other => panic!("{other:?}"),
    };
    let mut paths = Paths {
        count,
        processes: M,
        coarsest: COARSEST,
        recorded: REFERENCE,
    };
    let measured = match exact {
        Some(exact) => {
            paths.coarsest = COARSEST_EXACT;
            paths.recorded = COARSEST_EXACT + LEVELS as u32 - 1;
            let end = |path: &Recorded| end(&integrator, start, path);
            measure(paths, |fine| exact(total(fine)), end)
        }
        None => measure(
            paths,
            |fine| end(&reference, start, fine),
            |path| end(&integrator, start, path),
        ),
    };
    table.row([plan.system, R::NAME, noise], expected, measured);
}

#[test]
fn a_rotation_against_its_exact_path() {
    let mut table = Table::default();
    let start = State::from_configuration(&Kubo, [1.0, 0.5]).unwrap();
    let exact = |[w]: [f64; 1]| {
        let (s, c) = (1.0 + 0.5 * w).sin_cos();
        [c - 0.5 * s, s + 0.5 * c]
    };
    let noise = "γ = −H/2, exact path";
    stochastic(
        &mut table,
        (Kubo, InitialPoint),
        noise,
        start,
        2,
        Some(&exact),
    );
    stochastic(&mut table, (Kubo, Midpoint), noise, start, 8, Some(&exact));
    stochastic(&mut table, (Kubo, Endpoint), noise, start, 2, Some(&exact));
    table.check();
}

/// The spin of a stereographic point, turned about (0.6, 0, 0.8) by an angle, and its stereographic point.
fn turned([u, v]: [f64; 2], angle: f64) -> [f64; 2] {
    let square = u * u + v * v;
    let spin = [2.0 * u, 2.0 * v, 1.0 - square].map(|x| x / (1.0 + square));
    let axis = [0.6, 0.0, 0.8];
    let along: f64 = (0..3).map(|i| axis[i] * spin[i]).sum();
    let (s, c) = angle.sin_cos();
    let cross = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        axis[j] * spin[k] - axis[k] * spin[j]
    };
    let end: [f64; 3] =
        core::array::from_fn(|i| c * spin[i] + s * cross(i) + (1.0 - c) * along * axis[i]);
    [end[0] / (1.0 + end[2]), end[1] / (1.0 + end[2])]
}

const SPIN: [f64; 2] = [0.3125, 0.40625];

fn spin_exact([w]: [f64; 1]) -> [f64; 2] {
    turned(SPIN, -(1.0 + 0.5 * w))
}

#[test]
fn a_spin_against_its_exact_path() {
    let mut table = Table::default();
    let start = State::from_configuration(&Spin, SPIN).unwrap();
    let noise = "γ = −H/2, exact path";
    stochastic(
        &mut table,
        (Spin, Midpoint),
        noise,
        start,
        8,
        Some(&spin_exact),
    );
    table.check();
}

#[test]
fn two_vortices_against_their_exact_path() {
    let mut table = Table::default();
    let pair = VortexPair {
        strength: [1.0, 2.0],
        sigma: 0.3,
    };
    let start = State::from_configuration(&pair, [[1.0, 0.0], [-0.5, 0.0]]).unwrap();
    let exact = |[w]: [f64; 1]| {
        let (s, c) = (3.0 / 2.25 * (1.0 + 0.3 * w)).sin_cos();
        [c, s, -0.5 * c, -0.5 * s]
    };
    let noise = "γ = −σH, exact path";
    stochastic(&mut table, (pair, Midpoint), noise, start, 2, Some(&exact));
    table.check();
}

#[test]
fn lotka_volterra_with_one_noise() {
    let mut table = Table::default();
    let system = InternalLotkaVolterra;
    let start = State::from_configuration(&system, [1.5, 0.8]).unwrap();
    let noise = "one γ";
    stochastic(&mut table, (system, InitialPoint), noise, start, 1, None);
    stochastic(&mut table, (system, Midpoint), noise, start, 10, None);
    stochastic(&mut table, (system, Endpoint), noise, start, 1, None);
    table.check();
}

#[test]
fn noises_of_positions_that_do_not_commute() {
    let mut table = Table::default();
    let system = StormyLotkaVolterra;
    let start = State::from_configuration(&system, [1.5, 0.8]).unwrap();
    let noise = "γ = 0.2 (ln x, y)";
    stochastic(&mut table, (system, InitialPoint), noise, start, 8, None);
    stochastic(&mut table, (system, Midpoint), noise, start, 8, None);
    stochastic(&mut table, (system, Endpoint), noise, start, 8, None);
    let spin = TumblingSpin;
    let start = State::from_configuration(&spin, SPIN).unwrap();
    stochastic(
        &mut table,
        (spin, Midpoint),
        "γ = 0.2 (S_x, S_y)",
        start,
        8,
        None,
    );
    table.check();
}

/// A spring between a mass and a joint without mass, which a stiffening spring ties to the origin.
#[derive(Clone, Copy, Debug)]
struct Joint;

#[variational(initial_point, midpoint, endpoint)]
impl Joint {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * v[0] * v[0] - (x - y).powi(2) - 0.5 * y * y - 0.25 * y.powi(4)
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> f64 {
        0.8 * (2.0 * q[0]).sin()
    }
}

#[test]
fn a_joint_without_mass() {
    let mut table = Table::default();
    let start = State::from_configuration(&Joint, [0.8, 0.4]).unwrap();
    let noise = "γ = 0.8 sin 2x";
    stochastic(&mut table, (Joint, InitialPoint), noise, start, 8, None);
    stochastic(&mut table, (Joint, Midpoint), noise, start, 8, None);
    stochastic(&mut table, (Joint, Endpoint), noise, start, 8, None);
    table.check();
}

/// The plain discrete equations lose their order, and projecting after each step converges to another equation.
#[test]
fn wrong_steps_have_no_order() {
    for what in [Plain::Free, Plain::Projected] {
        let end = |path: &Recorded| {
            let start = State::from_configuration(&Spin, SPIN).unwrap();
            let (mut q, mut p) = (start.q, start.p);
            for step in 0..path.len() {
                let dw = [path.get(step).unwrap()[0]];
                (q, p) = wrong::step(&Spin, what, (q, p), path.h(), &dw);
            }
            q
        };
        let exact = |fine: &Recorded| spin_exact(total(fine));
        let paths = Paths {
            count: 4,
            processes: 1,
            coarsest: COARSEST,
            recorded: COARSEST + LEVELS as u32 - 1,
        };
        let [order, error] = measure(paths, exact, end);
        println!("| Spin | midpoint, {what:?} | γ = −H/2 | none | {order:.3} ± {error:.3} |");
        assert!(order < 0.8, "{what:?}: {order} ± {error}");
    }
}
