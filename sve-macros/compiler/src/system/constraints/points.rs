//! Random points at which constraints hold, with velocities along them.

use crate::algebra::{Arena, Expr, Symbol, random_coordinate};
use crate::model::Model;
use crate::system::mechanics::Mechanics;

/// Number of points that are sought.
const POINTS: usize = 6;

/// Largest number of random starts.
const ATTEMPTS: u64 = 60;

/// Largest number of Gauss–Newton steps from a start.
const ITERATIONS: usize = 60;

/// Largest φ, relative to its terms, at a point.
const ON_CONSTRAINTS: f64 = 1e-13;

/// Pivot, relative to its diagonal entry, below which gradients count as dependent.
const DEPENDENT: f64 = 1e-9;

/// A point on the constraints.
pub(super) struct Point {
    attempt: u64,
    /// The values of time, positions, velocities and momenta that differ from the values of the
    /// attempt.
    moved: Vec<(Symbol, f64)>,
    /// For each constraint its pivot, relative to the diagonal entry, in the elimination of
    /// `∂φ/∂q M⁻¹ ∂φ/∂qᵀ` in the order of the source.
    pivots: Vec<f64>,
    /// For each constraint the size of its gradient, relative to the size at the random start,
    /// where the constraint does not hold.
    gradients: Vec<f64>,
}

impl Point {
    /// Returns the value of a symbol.
    pub(super) fn value(&self, symbol: Symbol) -> f64 {
        let moved = self.moved.iter().find(|m| m.0 == symbol);
        moved.map_or_else(|| random_coordinate(self.attempt, symbol), |m| m.1)
    }

    pub(super) fn pivot(&self, k: usize) -> f64 {
        self.pivots[k]
    }

    pub(super) fn gradient_size(&self, k: usize) -> f64 {
        self.gradients[k]
    }
}

/// Finds points on the constraints of a model.
pub(super) fn points(model: &Model, mechanics: &Mechanics, arena: &Arena) -> Vec<Point> {
    let attempts = if arena.is_exhausted() { 0 } else { ATTEMPTS };
    let seek = Seek {
        model,
        mechanics,
        arena,
    };
    (0..attempts)
        .filter_map(|attempt| seek.point(attempt))
        .take(POINTS)
        .collect()
}

struct Seek<'a> {
    model: &'a Model,
    mechanics: &'a Mechanics,
    arena: &'a Arena,
}

impl Seek<'_> {
    fn point(&self, attempt: u64) -> Option<Point> {
        let (model, mechanics) = (self.model, self.mechanics);
        let count = mechanics.constraints.len();
        let start = model.q.iter().map(|&s| (s, random_coordinate(attempt, s)));
        let mut point = Point {
            attempt,
            moved: start.collect(),
            pivots: Vec::new(),
            gradients: Vec::new(),
        };
        let of = |of: fn(&crate::system::mechanics::ConstraintJet) -> Expr| -> Vec<Expr> {
            mechanics.constraints.iter().map(of).collect()
        };
        let (values, magnitudes, rates) = (of(|c| c.value), of(|c| c.magnitude), of(|c| c.dt));
        let slopes: Vec<Expr> = mechanics
            .constraints
            .iter()
            .flat_map(|c| c.dq.clone())
            .collect();
        let n = model.dof();
        let at_start = self.values(&slopes, &point);
        for _ in 0..ITERATIONS {
            let (phi, scale) = (
                self.values(&values, &point),
                self.values(&magnitudes, &point),
            );
            let is_on = |k: usize| phi[k].abs() <= ON_CONSTRAINTS * scale[k];
            if !phi.iter().all(|x| x.is_finite()) {
                return None;
            }
            if (0..count).all(is_on) {
                break;
            }
            let rows = self.values(&slopes, &point);
            let rows: Vec<&[f64]> = rows.chunks(n).collect();
            let gram = gram(&rows, &rows);
            let step = solve(gram, phi)?;
            for i in 0..n {
                let along: f64 = (0..count).map(|k| step[k] * rows[k][i]).sum();
                point.moved[i].1 -= along;
            }
        }
        let (phi, scale) = (
            self.values(&values, &point),
            self.values(&magnitudes, &point),
        );
        let is_on = |k: usize| phi[k].abs() <= ON_CONSTRAINTS.sqrt() * scale[k];
        if !(0..count).all(is_on) {
            return None;
        }
        let rows = self.values(&slopes, &point);
        let rows: Vec<&[f64]> = rows.chunks(n).collect();
        let size = |row: &[f64]| row.iter().map(|x| x * x).sum::<f64>().sqrt();
        point.gradients = (0..count)
            .map(|k| size(rows[k]) / size(&at_start[k * n..(k + 1) * n]))
            .collect();
        let rates = self.values(&rates, &point);
        self.move_along(&mut point, &rows, &rates)?;
        Some(point)
    }

    /// Computes for a point a velocity along the constraints, its momentum, and the pivots of its
    /// gradients.
    fn move_along(&self, point: &mut Point, rows: &[&[f64]], rates: &[f64]) -> Option<()> {
        let (model, mechanics) = (self.model, self.mechanics);
        let n = model.dof();
        let mass = self.values(&mechanics.lagrangian.dvv.concat(), point);
        let mass: Vec<Vec<f64>> = mass.chunks(n).map(<[f64]>::to_vec).collect();
        let directions: Option<Vec<Vec<f64>>> = rows
            .iter()
            .map(|row| general_solve(mass.clone(), row.to_vec()))
            .collect();
        let directions = directions?;
        let views: Vec<&[f64]> = directions.iter().map(Vec::as_slice).collect();
        let matrix = gram(rows, &views);
        point.pivots = pivots(matrix.clone());
        let mut v: Vec<f64> = model.v.iter().map(|&s| point.value(s)).collect();
        for _ in 0..2 {
            let psi = rows
                .iter()
                .zip(rates)
                .map(|(row, rate)| rate + row.iter().zip(&v).map(|(a, b)| a * b).sum::<f64>());
            let nu = solve(matrix.clone(), psi.collect())?;
            for (direction, nu) in directions.iter().zip(nu) {
                for i in 0..n {
                    v[i] -= nu * direction[i];
                }
            }
        }
        point.moved.extend(model.v.iter().copied().zip(v));
        let p = self.values(&mechanics.lagrangian.dv, point);
        point.moved.extend(model.p.iter().copied().zip(p));
        Some(())
    }

    fn values(&self, exprs: &[Expr], point: &Point) -> Vec<f64> {
        self.arena.values(exprs, |s| point.value(s))
    }
}

/// Returns `⟨a_k, b_l⟩`.
fn gram(a: &[&[f64]], b: &[&[f64]]) -> Vec<Vec<f64>> {
    let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum();
    a.iter()
        .map(|x| b.iter().map(|y| product(x, y)).collect())
        .collect()
}

/// Returns the pivots of an elimination without exchanges, relative to the diagonal entries. A row
/// whose pivot is too small is skipped.
fn pivots(matrix: Vec<Vec<f64>>) -> Vec<f64> {
    eliminated(matrix, None).0
}

/// Solves a positive definite system. Unknowns whose pivots are too small become zero. Returns
/// `None` if a number is not finite.
fn solve(matrix: Vec<Vec<f64>>, b: Vec<f64>) -> Option<Vec<f64>> {
    let solution = eliminated(matrix, Some(b)).1;
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

fn eliminated(mut matrix: Vec<Vec<f64>>, b: Option<Vec<f64>>) -> (Vec<f64>, Vec<f64>) {
    let n = matrix.len();
    let mut b = b.unwrap_or_else(|| vec![0.0; n]);
    let diagonal: Vec<f64> = (0..n).map(|k| matrix[k][k]).collect();
    let mut ratios = vec![0.0; n];
    let mut is_used = vec![false; n];
    for k in 0..n {
        let ratio = matrix[k][k] / diagonal[k];
        ratios[k] = if ratio.is_finite() { ratio } else { 0.0 };
        is_used[k] = ratios[k].abs() > DEPENDENT;
        if !is_used[k] {
            continue;
        }
        for i in k + 1..n {
            let factor = matrix[i][k] / matrix[k][k];
            for j in k..n {
                matrix[i][j] -= factor * matrix[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev().filter(|&k| is_used[k]) {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * x[j]).sum();
        x[k] = (b[k] - known) / matrix[k][k];
    }
    (ratios, x)
}

/// Solves a system with exchanges of rows; `None` if it is singular.
fn general_solve(mut matrix: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for k in 0..n {
        let size = |i: &usize| matrix[*i][k].abs();
        let pivot = (k..n).max_by(|i, j| size(i).total_cmp(&size(j)))?;
        if size(&pivot) == 0.0 || size(&pivot).is_nan() {
            return None;
        }
        matrix.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = matrix[i][k] / matrix[k][k];
            for j in k..n {
                matrix[i][j] -= factor * matrix[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / matrix[k][k];
    }
    Some(b)
}
