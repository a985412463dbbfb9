//! Schemes solved by an interpreter of their programs, and the residuals of the discrete equations
//! at the solution.

use super::system::{Point, System, gradient};
use super::{Case, Known};
use crate::algebra::tests::number::{Bounded, Dual, Number};
use crate::algebra::{Expr, Symbol};
use crate::catalogue::Rule;
use crate::program::tests::run;
use crate::program::{Scheduler, Tiers};
use crate::structure::{Linear, Matrix, Returns, Scheme, Solution};

/// Returns the solution of a small linear system.
fn linear(mut matrix: Vec<Vec<f64>>, mut rhs: Vec<f64>) -> Option<Vec<f64>> {
    let n = rhs.len();
    for k in 0..n {
        let size = |i: &usize| matrix[*i][k].abs();
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        matrix.swap(k, pivot);
        rhs.swap(k, pivot);
        for i in 0..n {
            let factor = matrix[i][k] / matrix[k][k];
            if i != k {
                for j in 0..n {
                    matrix[i][j] -= factor * matrix[k][j];
                }
                rhs[i] -= factor * rhs[k];
            }
        }
    }
    let solution: Vec<f64> = (0..n).map(|i| rhs[i] / matrix[i][i]).collect();
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

/// Returns `q₁ − q₀` and `p₁ − p₀`, block by block as in the emitted step; `None` if an iteration
/// does not converge.
pub(super) fn solution(
    case: &Case,
    scheme: &Scheme<Expr>,
    exprs: &[Expr],
    tiers: Tiers,
    given: &dyn Fn(Symbol) -> f64,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let mut scheduler = Scheduler::new(&case.arena, &case.symbols, tiers, exprs);
    let results = scheduler.values(exprs);
    let program = scheduler.finish(&results);
    let mut known = Known::new();
    let evaluate = |known: &Known, wanted: &[Expr]| -> Vec<f64> {
        let at = |s: Symbol| known.get(&s).copied().unwrap_or_else(|| given(s));
        let values = run(&program, &at);
        let of = |e: &Expr| exprs.iter().position(|x| x == e).expect("scheduled");
        wanted.iter().map(|e| values[&results[of(e)]]).collect()
    };
    let solve = |known: &Known, matrix: &Matrix<Expr>, rhs: &[Expr]| {
        let size = matrix.size();
        let mut full = vec![vec![0.0; size]; size];
        for (i, full_row) in full.iter_mut().enumerate() {
            let (columns, entries): (Vec<usize>, Vec<Expr>) = matrix.row(i).unzip();
            for (column, value) in columns.into_iter().zip(evaluate(known, &entries)) {
                full_row[column] = value;
            }
        }
        linear(full, evaluate(known, rhs))
    };
    for block in &scheme.blocks {
        match &block.solution {
            Solution::Formula(_) => {}
            Solution::System { linear, solved } => {
                let Linear { matrix, rhs } = linear;
                let x = solve(&known, matrix, rhs)?;
                known.extend(solved.iter().copied().zip(x));
            }
            Solution::Iteration(iteration) => {
                let guess = &iteration.guess;
                // if the limit of the guess is undefined, the iteration starts from arbitrary
                // values
                let anywhere = || iteration.iterates.iter().map(|&s| given(s)).collect();
                let explicit = solve(&known, &guess.matrix, &guess.rhs);
                let mut x: Vec<f64> = explicit.unwrap_or_else(anywhere);
                for refinement in &iteration.refinements {
                    known.extend(refinement.first.iter().copied().zip(x.clone()));
                    if let Some(more) = solve(&known, &guess.matrix, &refinement.rhs) {
                        x = x.iter().zip(more).map(|(x, more)| x + more).collect();
                    }
                }
                let mut last = f64::INFINITY;
                for _ in 0..30 {
                    known.extend(iteration.iterates.iter().copied().zip(x.clone()));
                    let by = solve(&known, &iteration.jacobian, &iteration.residual)?;
                    last = by.iter().fold(0.0, |m, x| m.max(x.abs()));
                    x = x.iter().zip(by).map(|(x, by)| x - by).collect();
                }
                if last > 1e-13 {
                    return None;
                }
                known.extend(iteration.solved.iter().copied().zip(x));
            }
        }
    }
    let (mut dq, mut dp) = (evaluate(&known, &scheme.dq), evaluate(&known, &scheme.dp));
    if scheme.returns == Returns::State {
        for i in 0..dq.len() {
            dq[i] -= case.point.q0[i];
            dp[i] -= case.point.p0[i];
        }
    }
    let finite = dq.iter().chain(&dp).all(|x| x.is_finite());
    finite.then_some((dq, dp))
}

/// Returns the largest residual of the discrete equations of a rule with one node, at given
/// increments. The velocity belongs to the momentum: Newton's method solves `∂S/∂v = 0` with
/// derivatives that are differences of exact ones.
pub(super) fn residual(system: &System, rule: Rule, point: &mut Point, dp: &[f64]) -> Option<f64> {
    let n = system.n;
    let one = Bounded::of(1.0);
    for i in 0..n {
        point.internal[i] = point.d[i] / point.h;
    }
    // starts near the velocity of the step, since several velocities may have the same momentum
    let constraint = |point: &Point, i: usize| {
        gradient(system, rule, point, |x| x.internal[n + i].slope = one).value
    };
    let missing: Vec<f64> = (0..n).map(|i| constraint(point, i)).collect();
    for i in 0..n {
        point.internal[i] += missing[i] / point.h;
    }
    let by_velocity = |point: &Point| -> Vec<f64> {
        (0..n)
            .map(|i| gradient(system, rule, point, |x| x.internal[i].slope = one).value / point.h)
            .collect()
    };
    for _ in 0..60 {
        let here = by_velocity(point);
        let columns: Vec<Vec<f64>> = (0..n)
            .map(|j| {
                let mut moved = point.clone();
                moved.internal[j] += 1e-6;
                let there = by_velocity(&moved);
                (0..n).map(|i| (there[i] - here[i]) / 1e-6).collect()
            })
            .collect();
        let matrix = (0..n)
            .map(|i| (0..n).map(|j| columns[j][i]).collect())
            .collect();
        let by = linear(matrix, here)?;
        for i in 0..n {
            point.internal[i] -= by[i];
        }
    }
    let slope = |along: &dyn Fn(&mut super::system::Variables<Dual<Bounded>>)| {
        gradient(system, rule, point, along).value()
    };
    let mut worst: f64 = by_velocity(point).iter().fold(0.0, |m, r| m.max(r.abs()));
    if worst.is_nan() || worst > 1e-11 {
        return None;
    }
    for i in 0..n {
        let end = slope(&|x| x.d[i].slope = one);
        let kick = slope(&|x| x.q0[i].slope = one);
        let constraint = slope(&|x| x.internal[n + i].slope = one);
        let balance = end - kick - point.p0[i];
        let momentum = dp[i] - kick;
        worst = [constraint, balance, momentum]
            .iter()
            .fold(worst, |m, r| m.max(r.abs()));
    }
    Some(worst)
}
