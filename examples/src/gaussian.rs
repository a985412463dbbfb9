//! Exact moments of linear schemes with Gaussian increments.
//!
//! A linear scheme `y₁ = A y₀ + η`, `η ~ N(0, Q)`, keeps a Gaussian Gaussian: `μ₁ = A μ₀`,
//! `Σ₁ = A Σ₀ Aᵀ + Q`. A quadratic form has mean `tr(DΣ) + μᵀDμ` and variance
//! `2 tr(DΣDΣ) + 4 μᵀDΣDμ` (D symmetric). So mean energies and their standard errors are known
//! without sampling. For `Q = σ²h b bᵀ` the second moments `M = Σ + μμᵀ` obey
//! `M₁ = A M₀ Aᵀ + σ²h b bᵀ`. A and b are read off the steps of a method, so that the moments belong
//! to the code that runs.

use std::array::from_fn;

use sve_runtime::system::{Dims, System};
use sve_runtime::{Method, State, StepError};

/// A matrix, rows first.
pub type Matrix<const K: usize> = [[f64; K]; K];

/// A normal distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian<const K: usize> {
    /// The mean of the distribution.
    pub mean: [f64; K],
    /// The covariance of the distribution.
    pub covariance: Matrix<K>,
}

/// A and b of a step `y₁ = A y₀ + b ΔW`.
pub type Linear<const K: usize> = (Matrix<K>, [f64; K]);

/// Returns A and b of the steps of length `h` of a linear system, from three of them.
///
/// # Errors
/// That of a step.
pub fn linear<I>(method: &I, h: f64) -> Result<Linear<2>, StepError>
where
    I: Method<System: System<Dims = Dims<1, 1>>>,
{
    let image = |q: f64, p: f64, dw: f64| {
        let mut state = State::new([q], [p]);
        method.step(&mut state, h, &[dw])?;
        Ok([state.q[0], state.p[0]])
    };
    let (x, y) = (image(1.0, 0.0, 0.0)?, image(0.0, 1.0, 0.0)?);
    Ok((from_fn(|i| [x[i], y[i]]), image(0.0, 0.0, 1.0)?))
}

/// `½ yᵀ y`, the energy of an oscillator, as the matrix of a quadratic form.
pub const ENERGY: Matrix<2> = [[0.5, 0.0], [0.0, 0.5]];

/// A linear scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme<const K: usize> {
    /// The matrix that multiplies the state.
    pub a: Matrix<K>,
    /// The covariance of the added noise.
    pub noise: Matrix<K>,
}

impl<const K: usize> Gaussian<K> {
    /// Returns the distribution of a point.
    pub fn certain(mean: [f64; K]) -> Self {
        Self {
            mean,
            covariance: [[0.0; K]; K],
        }
    }

    /// Returns mean and variance of `yᵀ D y`, D symmetric.
    pub fn quadratic(&self, d: &Matrix<K>) -> (f64, f64) {
        let ds = product(d, &self.covariance);
        let dm = apply(d, &self.mean);
        let mean = trace(&ds) + dot(&self.mean, &dm);
        let variance = 2.0 * trace(&product(&ds, &ds)) + 4.0 * dot(&self.mean, &apply(&ds, &dm));
        (mean, variance)
    }
}

impl<const K: usize> Scheme<K> {
    /// Returns the scheme of steps of length `h` with one Wiener process.
    pub fn driven((a, b): Linear<K>, h: f64) -> Self {
        let noise = from_fn(|i| from_fn(|j| h * b[i] * b[j]));
        Self { a, noise }
    }

    /// Returns the distribution one step later.
    #[must_use]
    pub fn step(&self, y: &Gaussian<K>) -> Gaussian<K> {
        let mut covariance = product(&product(&self.a, &y.covariance), &transpose(&self.a));
        for i in 0..K {
            for j in 0..K {
                covariance[i][j] += self.noise[i][j];
            }
        }
        Gaussian {
            mean: apply(&self.a, &y.mean),
            covariance,
        }
    }

    /// Returns the distribution after so many steps.
    pub fn after(&self, start: [f64; K], steps: usize) -> Gaussian<K> {
        (0..steps).fold(Gaussian::certain(start), |y, _| self.step(&y))
    }

    /// Returns the distributions after 0, 1, 2 … steps.
    pub fn distributions(&self, start: [f64; K]) -> impl Iterator<Item = Gaussian<K>> {
        std::iter::successors(Some(Gaussian::certain(start)), |y| Some(self.step(y)))
    }
}

/// Returns the largest allowed error of the mean of `n` independent squares, in standard errors,
/// with a false alarm in ten thousand.
///
/// Chernoff's bound for the mean of n χ²₁ variables, which have the longest tail among energies of
/// a plane Gaussian: `P(mean > 1 + y) ≤ exp(−n (y − ln(1 + y))/2)`, and y is `√(2/n)` a standard
/// error. The result tends to the normal 4.4 as n grows.
pub fn standard_errors(n: f64) -> f64 {
    let wanted = 2e4_f64.ln();
    let (mut low, mut high) = (0.0, 4.0 * wanted / n + 4.0);
    // Halving 60 times reaches the rounding level.
    for _ in 0..60 {
        let y: f64 = f64::midpoint(low, high);
        if n * (y - y.ln_1p()) / 2.0 < wanted {
            low = y;
        } else {
            high = y;
        }
    }
    high * (n / 2.0).sqrt()
}

/// Returns `E f(X)` for `X ~ N(mean, deviation²)`.
///
/// Uses the trapezoidal rule on ±12 deviations: for f analytic near the real axis its error falls
/// exponentially with the spacing (Trefethen and Weideman, The exponentially convergent trapezoidal
/// rule, 2014).
pub fn expectation(mean: f64, deviation: f64, f: impl Fn(f64) -> f64) -> f64 {
    let spacing = 0.01;
    let weight = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
    (-1200..=1200)
        .map(|k| spacing * f64::from(k))
        .map(|z| spacing * weight(z) * f(mean + deviation * z))
        .sum()
}

impl Gaussian<2> {
    /// Returns `(x − μ)ᵀ Σ⁻¹ (x − μ)`, which is χ²₂ distributed: above s with probability
    /// exp(−s/2).
    pub fn surprise(&self, x: [f64; 2]) -> f64 {
        let d = [x[0] - self.mean[0], x[1] - self.mean[1]];
        let c = &self.covariance;
        let determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
        (c[1][1] * d[0] * d[0] - 2.0 * c[0][1] * d[0] * d[1] + c[0][0] * d[1] * d[1]) / determinant
    }
}

/// Returns `A B`.
pub fn product<const K: usize>(a: &Matrix<K>, b: &Matrix<K>) -> Matrix<K> {
    let mut c = [[0.0; K]; K];
    for i in 0..K {
        for j in 0..K {
            for k in 0..K {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

/// Returns `Aᵀ`.
pub fn transpose<const K: usize>(a: &Matrix<K>) -> Matrix<K> {
    from_fn(|i| from_fn(|j| a[j][i]))
}

fn apply<const K: usize>(a: &Matrix<K>, x: &[f64; K]) -> [f64; K] {
    from_fn(|i| dot(&a[i], x))
}

fn dot<const K: usize>(x: &[f64; K], y: &[f64; K]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

fn trace<const K: usize>(a: &Matrix<K>) -> f64 {
    (0..K).map(|i| a[i][i]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_a_square() {
        let x = Gaussian {
            mean: [2.0],
            covariance: [[9.0]],
        };
        // X² of N(2, 9) has mean 13 and variance 2·81 + 4·4·9.
        assert_eq!(x.quadratic(&[[1.0]]), (13.0, 306.0));
    }

    #[test]
    fn tails_become_normal() {
        assert!((standard_errors(1e9) - 4.45).abs() < 0.01);
        assert!(standard_errors(1.0) > 15.0);
    }

    #[test]
    fn expectation_of_a_polynomial() {
        let fourth = expectation(1.0, 2.0, |x| x.powi(4));
        // The fourth moment is μ⁴ + 6μ²σ² + 3σ⁴.
        assert!((fourth - 73.0).abs() < 1e-10);
    }
}
