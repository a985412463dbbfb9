//! The rate at which Langevin dynamics in a double well forgets its well, to many digits.
//!
//! Input: V = a(q² − 1)², friction ν, temperature kT. Output: λ, the smallest eigenvalue above 0 of
//! the Fokker–Planck operator. The difference of the wells' populations finally decays as exp(−λt).
//!
//! With ψ = f/√(equilibrium) expanded in Hermite functions of v, `ψ = Σ cₙ(q) ψₙ(v)`, and
//! `A = √kT ∂/∂q + V'/(2√kT)`,
//!
//! ```text
//! dcₙ/dt = −νn cₙ + √(n+1) A† cₙ₊₁ − √n A cₙ₋₁
//! ```
//!
//! so that `λ c₀ = A† S₁ A c₀` with `Sₙ = (νn − λ + (n+1) A† Sₙ₊₁ A)⁻¹`, a continued fraction of
//! matrices in a basis of oscillator functions of q, where V' has a finite band. The slowest state
//! is odd in q; S is even.
//!
//! Source: Risken, *The Fokker–Planck Equation*, second edition, chapter 10.

/// Number of functions of q.
const BASIS: usize = 80;
/// Number of functions of v.
const LEVELS: usize = 40;

type Rows = Vec<Vec<f64>>;

/// Returns λ of V = a(q² − 1)².
pub(crate) fn rate(a: f64, nu: f64, kt: f64) -> f64 {
    let lower = lowering(a, kt);
    let mut lambda = 0.0;
    // λ is small compared with ν, so that the fraction hardly depends on it: three rounds reach
    // rounding.
    for _ in 0..4 {
        let shift = lambda;
        let mut inner = zeros();
        for n in (1..=LEVELS).rev() {
            let scale = (n + 1) as f64;
            let mut m = between(&lower, &inner);
            for (i, row) in m.iter_mut().enumerate() {
                for x in row.iter_mut() {
                    *x *= scale;
                }
                row[i] += nu * n as f64 - shift;
            }
            inner = inverse(m);
        }
        lambda = smallest_odd(&between(&lower, &inner));
    }
    lambda
}

fn zeros() -> Rows {
    vec![vec![0.0; BASIS]; BASIS]
}

/// Returns A in a basis of oscillator functions whose width fits a decay like exp(−V/2kT).
fn lowering(a: f64, kt: f64) -> Rows {
    let width = 0.4;
    let (mut q, mut d) = (zeros(), zeros());
    for k in 1..BASIS {
        let root = (k as f64 / 2.0).sqrt();
        (q[k - 1][k], q[k][k - 1]) = (root * width, root * width);
        (d[k - 1][k], d[k][k - 1]) = (root / width, -root / width);
    }
    let cube = product(&product(&q, &q), &q);
    let mut lower = zeros();
    for i in 0..BASIS {
        for j in 0..BASIS {
            let force = 4.0 * a * (cube[i][j] - q[i][j]);
            lower[i][j] = kt.sqrt() * d[i][j] + force / (2.0 * kt.sqrt());
        }
    }
    lower
}

fn product(x: &Rows, y: &Rows) -> Rows {
    let mut z = zeros();
    for i in 0..BASIS {
        for k in 0..BASIS {
            if x[i][k] != 0.0 {
                for j in 0..BASIS {
                    z[i][j] += x[i][k] * y[k][j];
                }
            }
        }
    }
    z
}

/// Returns `Aᵀ S A`.
fn between(a: &Rows, s: &Rows) -> Rows {
    let mut transposed = zeros();
    for i in 0..BASIS {
        for j in 0..BASIS {
            transposed[j][i] = a[i][j];
        }
    }
    product(&transposed, &product(s, a))
}

/// Returns the inverse of a positive definite matrix, by Gauss and Jordan.
fn inverse(mut m: Rows) -> Rows {
    let mut inverse = zeros();
    for (i, row) in inverse.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for k in 0..BASIS {
        let scale = 1.0 / m[k][k];
        for x in m[k].iter_mut().chain(&mut inverse[k]) {
            *x *= scale;
        }
        let (pivot, beside) = (m[k].clone(), inverse[k].clone());
        for i in (0..BASIS).filter(|&i| i != k) {
            let factor = m[i][k];
            if factor != 0.0 {
                for j in 0..BASIS {
                    m[i][j] -= factor * pivot[j];
                    inverse[i][j] -= factor * beside[j];
                }
            }
        }
    }
    inverse
}

/// Returns the smallest eigenvalue among odd functions, by inverse iteration.
fn smallest_odd(m: &Rows) -> f64 {
    // Even rows are replaced by rows of the unit matrix, so that the even functions, one of which
    // has eigenvalue 0, are left out.
    let mut odd = zeros();
    for i in 0..BASIS {
        for j in 0..BASIS {
            let both = i % 2 == 1 && j % 2 == 1;
            odd[i][j] = if both {
                m[i][j]
            } else {
                f64::from(u8::from(i == j))
            };
        }
    }
    let inverse = inverse(odd);
    let mut x: Vec<f64> = (0..BASIS).map(|i| (i % 2) as f64).collect();
    let mut largest = 1.0;
    for _ in 0..60 {
        let y: Vec<f64> = inverse
            .iter()
            .map(|row| row.iter().zip(&x).map(|(m, x)| m * x).sum())
            .collect();
        largest = y.iter().map(|y| y * y).sum::<f64>().sqrt();
        x = y.iter().map(|y| y / largest).collect();
    }
    1.0 / largest
}
