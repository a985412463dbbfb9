//! The solution of a step of a Gauss rule by continuation, apart from the runtime: first the step
//! size grows without noise, then the increments.
//!
//! Unknowns are positions and momenta of the stages, the equations those of Hamilton. Derivatives
//! are differences, strides are short, and each point has to be near the tangent at the one before.

/// Motion of positions and momenta `(q, p)`: without noise, then of each process.
pub(super) type Fields<'a> = &'a dyn Fn(&[f64]) -> Vec<Vec<f64>>;

/// Where the path of a solution leads.
#[derive(Clone, Debug)]
pub(super) enum Branch {
    /// To this state.
    State(Vec<f64>),
    /// To an end, after this part of the step size and of the increments.
    Ends([f64; 2]),
}

/// The coefficients of a Gauss rule.
pub(super) struct Coefficients {
    pub(super) a: Vec<Vec<f64>>,
    pub(super) b: Vec<f64>,
}

impl Coefficients {
    /// The nodes are found by bisection, weights and coefficients by quadrature with Lagrange
    /// polynomials.
    pub(super) fn new(stages: usize) -> Self {
        let legendre = |y: f64| {
            let (mut last, mut p) = (0.0, 1.0);
            for k in 0..stages {
                let k = k as f64;
                (last, p) = (p, ((2.0 * k + 1.0) * y * p - k * last) / (k + 1.0));
            }
            p
        };
        let mut c = Vec::new();
        let grid = |i: usize| -1.0 + i as f64 / 500.0 + 1e-7;
        for i in 0..1000 {
            let (mut low, mut high) = (grid(i), grid(i + 1));
            if legendre(low) * legendre(high) > 0.0 {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if legendre(low) * legendre(middle) <= 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            c.push(0.5 + 0.25 * (low + high));
        }
        assert_eq!(c.len(), stages);
        let lagrange = |j: usize, x: f64| -> f64 {
            let others = (0..stages).filter(|&k| k != j);
            others.map(|k| (x - c[k]) / (c[j] - c[k])).product()
        };
        // Boole's rule on many parts: exact to rounding for these degrees
        let integral = |j: usize, end: f64| -> f64 {
            let part = end / 64.0;
            let weights = [7.0, 32.0, 12.0, 32.0, 7.0];
            let of_part = |i: usize| -> f64 {
                let at = |k: usize| lagrange(j, part * (i as f64 + k as f64 / 4.0));
                let terms = weights.iter().enumerate().map(|(k, w)| w * at(k));
                terms.sum::<f64>() * part / 90.0
            };
            (0..64).map(of_part).sum()
        };
        Self {
            a: (0..stages)
                .map(|i| (0..stages).map(|j| integral(j, c[i])).collect())
                .collect(),
            b: (0..stages).map(|j| integral(j, 1.0)).collect(),
        }
    }
}

/// A step whose path is followed.
pub(super) struct Step<'a> {
    pub(super) rule: &'a Coefficients,
    pub(super) fields: Fields<'a>,
    /// `(q, p)` at the start.
    pub(super) start: &'a [f64],
    pub(super) h: f64,
    pub(super) dw: &'a [f64],
}

impl Step<'_> {
    /// Follows the solution.
    pub(super) fn follow(&self) -> Branch {
        let mut z = self.start.repeat(self.rule.b.len());
        for leg in 0..2 {
            if leg == 1 && self.dw.iter().all(|&w| w == 0.0) {
                break;
            }
            let part = |s: f64| if leg == 0 { [s, 0.0] } else { [1.0, s] };
            match self.follow_leg(&z, part) {
                Ok(end) => z = end,
                Err(s) => return Branch::Ends(part(s)),
            }
        }
        let slopes = self.slopes(&z, [1.0, 1.0]);
        let n = self.start.len();
        let end = (0..n).map(|k| {
            let stages = slopes.iter().zip(&self.rule.b);
            self.start[k] + stages.map(|(slope, b)| b * slope[k]).sum::<f64>()
        });
        Branch::State(end.collect())
    }

    fn follow_leg(&self, start: &[f64], part: impl Fn(f64) -> [f64; 2]) -> Result<Vec<f64>, f64> {
        let (mut here, mut s) = (start.to_vec(), 0.0);
        let mut stride: f64 = 1.0 / 64.0;
        while s < 1.0 {
            let next = f64::min(1.0, s + stride);
            let found = self
                .tangent(&here, [part(s), part(1.0)])
                .and_then(|tangent| {
                    let ahead = here.iter().zip(&tangent).map(|(x, by)| x + (next - s) * by);
                    let ahead: Vec<f64> = ahead.collect();
                    let z = self.newton(&ahead, part(next))?;
                    let is_near = distance(&z, &ahead) <= 0.1 * distance(&z, &here) + 1e-9;
                    is_near.then_some(z)
                });
            if let Some(z) = found {
                (here, s) = (z, next);
                stride = (2.0 * stride).min(1.0 / 16.0);
            } else {
                stride *= 0.5;
                if stride < 1e-11 {
                    return Err(s);
                }
            }
        }
        Ok(here)
    }

    /// The derivative of the solution along a leg, of which `here` and the end are given as parts
    /// of the step.
    fn tangent(&self, z: &[f64], [here, end]: [[f64; 2]; 2]) -> Option<Vec<f64>> {
        // the leg of the step size ends without increments
        let direction = if end[1] > 0.0 { [0.0, 1.0] } else { [1.0, 0.0] };
        let (n, slopes) = (self.start.len(), self.slopes(z, direction));
        let mut rows = self.jacobian(z, here);
        for (i, a) in self.rule.a.iter().enumerate() {
            for m in 0..n {
                let terms = a.iter().zip(&slopes).map(|(a, slope)| a * slope[m]);
                rows[i * n + m].push(terms.sum());
            }
        }
        solve(rows)
    }

    /// `h X + Σ ΔW_a X_a` at each stage.
    fn slopes(&self, z: &[f64], part: [f64; 2]) -> Vec<Vec<f64>> {
        let stages = z.chunks(self.start.len());
        stages.map(|z| self.slope(z, part)).collect()
    }

    fn slope(&self, z: &[f64], [step, noise]: [f64; 2]) -> Vec<f64> {
        let fields = (self.fields)(z);
        let factors = core::iter::once(step * self.h).chain(self.dw.iter().map(|w| noise * w));
        let mut sum = vec![0.0; z.len()];
        for (field, factor) in fields.iter().zip(factors) {
            for (sum, x) in sum.iter_mut().zip(field) {
                *sum += factor * x;
            }
        }
        sum
    }

    /// The derivatives of the equations `z_i − z₀ − Σ a_ij slope_j = 0`.
    fn jacobian(&self, z: &[f64], part: [f64; 2]) -> Vec<Vec<f64>> {
        const STEP: f64 = 1e-6;
        let n = self.start.len();
        let mut rows: Vec<Vec<f64>> = vec![vec![0.0; z.len()]; z.len()];
        for column in 0..z.len() {
            let (j, k) = (column / n, column % n);
            let mut at = z[j * n..(j + 1) * n].to_vec();
            at[k] += STEP;
            let right = self.slope(&at, part);
            at[k] -= 2.0 * STEP;
            let left = self.slope(&at, part);
            for (i, a) in self.rule.a.iter().enumerate() {
                for m in 0..n {
                    rows[i * n + m][column] = -a[j] * (right[m] - left[m]) / (2.0 * STEP);
                }
            }
            rows[column][column] += 1.0;
        }
        rows
    }

    /// Newton's method, which has to contract.
    fn newton(&self, guess: &[f64], part: [f64; 2]) -> Option<Vec<f64>> {
        let n = self.start.len();
        let mut z = guess.to_vec();
        let mut last = f64::INFINITY;
        for _ in 0..12 {
            let slopes = self.slopes(&z, part);
            let mut rows = self.jacobian(&z, part);
            for (i, a) in self.rule.a.iter().enumerate() {
                for m in 0..n {
                    let terms = a.iter().zip(&slopes).map(|(a, slope)| a * slope[m]);
                    let residual = z[i * n + m] - self.start[m] - terms.sum::<f64>();
                    rows[i * n + m].push(residual);
                }
            }
            let update = solve(rows)?;
            let size = update.iter().fold(0.0, |x: f64, y| x.max(y.abs()));
            for (z, by) in z.iter_mut().zip(&update) {
                *z -= by;
            }
            let scale = z.iter().fold(1.0, |x: f64, y| x.max(y.abs()));
            if size <= 1e-11 * scale {
                return Some(z);
            }
            if size > 0.25 * last || !size.is_finite() {
                return None;
            }
            last = size;
        }
        None
    }
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    let each = x.iter().zip(y).map(|(x, y)| (x - y).abs());
    each.fold(0.0, f64::max)
}

/// Gaussian elimination; the right-hand side is the last column.
fn solve(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| rows[i][k].abs().total_cmp(&rows[j][k].abs()))?;
        rows.swap(k, pivot);
        if rows[k][k] == 0.0 || !rows[k][k].is_finite() {
            return None;
        }
        let (upper, lower) = rows.split_at_mut(k + 1);
        for row in lower {
            let factor = row[k] / upper[k][k];
            if factor != 0.0 {
                for (x, y) in row[k..].iter_mut().zip(&upper[k][k..]) {
                    *x -= factor * y;
                }
            }
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * x[j]).sum();
        x[k] = (rows[k][n] - known) / rows[k][k];
    }
    Some(x)
}
