//! Legendre series of the impulses and displacements of a step: their coefficients, their decay,
//! their values at the stages of another step, and their integral.
//!
//! Input: the values `F_j = h b_j f_j` at the stages of a step. With `y_j = 2 c_j − 1` the
//! polynomial through `f_j` is
//!
//! ```text
//! f(x) = (1/h) Σ_k (2k + 1) C_k P_k(2x − 1),  C_k = Σ_j P_k(y_j) F_j,  k from 0 to S − 1
//! ```
//!
//! and its integral from the start of the step
//! `½ ((X + 1) C_0 + Σ_{k≥1} C_k (P_{k+1}(X) − P_{k−1}(X)))`, `X = 2x − 1`.

use super::nodes::root;
use super::stages::{Matrix, Rows, larger, product};
use super::tableau::{MOST_STAGES, Tableau, legendre_at};
use crate::lanes::dispatch::Kernel;
use crate::lanes::elementary::log2;

/// Returns the matrix `P_k(y_j)`, column by column.
const fn at_nodes<const S: usize>() -> Matrix<S> {
    let mut values = [[0.0; S]; S];
    let mut j = 0;
    while j < S {
        let exact = legendre_at(root(S, j));
        let mut k = 0;
        while k < S {
            values[j][k] = exact[k].high;
            k += 1;
        }
        j += 1;
    }
    values
}

/// Returns the Legendre polynomials of degree 0 to [`MOST_STAGES`] at several points.
#[inline(always)]
fn polynomials<const L: usize>(points: &[f64; L]) -> [[f64; L]; MOST_STAGES + 1] {
    let mut values = [[1.0; L]; MOST_STAGES + 1];
    values[1] = *points;
    for k in 1..MOST_STAGES {
        let (degree, next) = (k as f64, (k + 1) as f64);
        let [of_last, of_before] = [(2.0 * degree + 1.0) / next, degree / next];
        for i in 0..L {
            values[k + 1][i] = of_last * points[i] * values[k][i] - of_before * values[k - 1][i];
        }
    }
    values
}

/// Computes the coefficients of the series of `R` quantities.
pub(super) struct Coefficients<'a, const S: usize, const N: usize, const R: usize> {
    pub(super) stages: &'a [Rows<S, N>; R],
}

/// The coefficients of a step, a row of degrees for each coordinate, and their decay.
pub(super) struct Series<const S: usize, const N: usize, const R: usize> {
    pub(super) rows: [Rows<S, N>; R],
    /// The sizes of each quantity.
    sizes: [Sizes; R],
}

/// The sizes of a quantity: the largest values among the coordinates.
#[derive(Clone, Copy)]
struct Sizes {
    /// `max |C_{S−1}|` and `max |C_{S−2}|`.
    last: [f64; 2],
    /// `max |F_j| / b_j`.
    value: f64,
}

impl<const S: usize, const N: usize, const R: usize> Kernel for Coefficients<'_, S, N, R> {
    type Output = Series<S, N, R>;

    #[inline(always)]
    fn run(self) -> Series<S, N, R> {
        let (matrix, tableau) = const { (&at_nodes::<S>(), &Tableau::<S>::VALUES) };
        let mut rows = [[[0.0; S]; N]; R];
        let mut sizes = [Sizes {
            last: [0.0; 2],
            value: 0.0,
        }; R];
        for r in 0..R {
            let mut values = [0.0; S];
            let mut coefficients = [0.0; S];
            for n in 0..N {
                rows[r][n] = product(matrix, &self.stages[r][n]);
                for i in 0..S {
                    let value = (tableau.inverse_b[i] * self.stages[r][n][i]).abs();
                    values[i] = larger(values[i], value);
                    coefficients[i] = larger(coefficients[i], rows[r][n][i].abs());
                }
            }
            sizes[r].last = [coefficients[S - 1], coefficients[S - 2]];
            sizes[r].value = values.into_iter().fold(0.0, larger);
        }
        Series { rows, sizes }
    }
}

impl<const S: usize, const N: usize, const R: usize> Series<S, N, R> {
    /// Returns the logarithm to base 2 of the ratio of successive terms, the largest of all
    /// quantities; −∞ if no term of high degree is left. Two degrees are looked at, since the
    /// coefficient of a single degree vanishes by chance.
    pub(super) fn decay(&self) -> f64 {
        let of = |sizes: &Sizes| {
            let per_degree = |coefficient: f64, degree: usize| {
                let degree = degree as f64;
                let part = (2.0 * degree + 1.0) * coefficient / sizes.value;
                let logarithm = log2(part) / degree;
                // without a normal number
                if logarithm.is_nan() {
                    f64::NEG_INFINITY
                } else {
                    logarithm
                }
            };
            per_degree(sizes.last[0], S - 1).max(per_degree(sizes.last[1], S - 2))
        };
        let decays = self.sizes.iter().map(of);
        decays.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Computes the values of `R` series at the stages of the step that follows, which is `ratio` times
/// as long.
pub(super) struct Ahead<'a, const S: usize, const N: usize, const R: usize> {
    pub(super) rows: &'a [Rows<S, N>; R],
    pub(super) ratio: f64,
}

impl<const S: usize, const N: usize, const R: usize> Kernel for Ahead<'_, S, N, R> {
    type Output = [Rows<S, N>; R];

    #[inline(always)]
    fn run(self) -> [Rows<S, N>; R] {
        let Tableau { c, b, .. } = const { &Tableau::<S>::VALUES };
        let mut points = [0.0; S];
        for i in 0..S {
            points[i] = 1.0 + 2.0 * self.ratio * c[i];
        }
        let polynomials = polynomials(&points);
        let mut matrix = [[0.0; S]; S];
        for k in 0..S {
            let factor = (2 * k + 1) as f64;
            for i in 0..S {
                matrix[k][i] = self.ratio * b[i] * factor * polynomials[k][i];
            }
        }
        let mut values = [[[0.0; S]; N]; R];
        for r in 0..R {
            for n in 0..N {
                values[r][n] = product(&matrix, &self.rows[r][n]);
            }
        }
        values
    }
}

/// Returns the integral of a series from the start of its step to a fraction of the step.
pub(crate) fn integral<const S: usize>(coefficients: &[f64; S], fraction: f64) -> f64 {
    let point = 2.0 * fraction - 1.0;
    let values = polynomials(&[point]);
    let mut sum = (point + 1.0) * coefficients[0];
    for k in 1..S {
        sum += coefficients[k] * (values[k + 1][0] - values[k - 1][0]);
    }
    0.5 * sum
}

#[cfg(test)]
mod tests {
    use super::{Ahead, Coefficients, Kernel as _, Tableau, integral};

    /// Returns `h b_i f(x_i)` for `f = Σ a_k x^k` at the stages of a step from `start`, of size
    /// `h`.
    fn stages<const S: usize>(start: f64, h: f64, f: impl Fn(f64) -> f64) -> [f64; S] {
        let Tableau { c, b, .. } = Tableau::<S>::VALUES;
        core::array::from_fn(|i| h * b[i] * f(start + h * c[i]))
    }

    fn check<const S: usize>() {
        for degree in 0..S {
            let f = |x: f64| x.powi(degree as i32) - 0.5;
            let integral_of_f =
                |x: f64| x.powi(degree as i32 + 1) / (degree as f64 + 1.0) - 0.5 * x;
            let series = Coefficients::<S, 1, 1> {
                stages: &[[stages::<S>(0.0, 1.0, f)]],
            };
            let rows = series.run().rows;
            for ratio in [0.3, 1.0, 1.9] {
                let ahead = Ahead { rows: &rows, ratio }.run();
                let expected = stages::<S>(1.0, ratio, f);
                for i in 0..S {
                    let error = (ahead[0][0][i] - expected[i]).abs();
                    assert!(error < 1e-10, "{S} {degree} {ratio} {i}: {error:e}");
                }
            }
            for fraction in [0.0, 0.1, 0.5, 0.77, 1.0] {
                let error = integral(&rows[0][0], fraction) - integral_of_f(fraction);
                assert!(error.abs() < 1e-14, "{S} {degree} {fraction}: {error:e}");
            }
        }
    }

    #[test]
    fn series_of_polynomials_are_exact_beyond_the_step_and_their_integrals_within() {
        check::<4>();
        check::<5>();
        check::<6>();
        check::<7>();
        check::<8>();
    }

    #[test]
    fn the_decay_is_that_of_a_pole() {
        // the coefficients of 1/(z − x) fall by z + √(z² − 1) per degree, in units of half a step
        for z in [1.5, 3.0, 10.0_f64] {
            let f = |x: f64| 1.0 / (0.5 * (z + 1.0) - x);
            let series = Coefficients::<8, 1, 1> {
                stages: &[[stages::<8>(0.0, 1.0, f)]],
            };
            let (found, expected) = (series.run().decay(), -(z + (z * z - 1.0).sqrt()).log2());
            assert!((found - expected).abs() < 0.5, "{z}: {found} {expected}");
        }
        let nothing = Coefficients::<8, 1, 1> {
            stages: &[[[0.0; 8]]],
        };
        assert_eq!(nothing.run().decay(), f64::NEG_INFINITY);
    }
}
