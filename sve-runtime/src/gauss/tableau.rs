//! The coefficients of the Gauss rules, computed by the compiler from the nodes.
//!
//! Input: the nodes to 106 bits. Output: the coefficients. The coefficients of the first-order
//! form, `μ_ij = a_ij / b_j`, are rounded such that the condition of symplecticity holds exactly in
//! `f64`, `μ_ij + μ_ji = 1`. The coefficients of the second-order form,
//! `η_ij = Σ_k a_ik a_kj / b_j`, are rounded for each step size, in `scaled.rs`.
//!
//! With the shifted Legendre polynomials, `b_j μ_ij` is the integral of the Lagrange polynomial of
//! node j from 0 to node i, in a form that does not cancel: `μ_ij = (1 + y_i)/2 + ½ Σ_k P_k(y_j)
//! (P_{k+1}(y_i) − P_{k−1}(y_i))`, k from 1 to S − 1, with `y = 2c − 1`.
//!
//! Sources: Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006), sections II.1.3 and
//! VIII.6 (rounding); Antoñana, Makazaga, Murua, *Reducing and monitoring round-off error
//! propagation for symplectic implicit Runge–Kutta schemes* (2017).

use super::double_double::Double;
use super::nodes::root;

/// Largest number of stages.
pub(crate) const MOST_STAGES: usize = 8;

/// Binary digits after the point of the ratios μ: their sums with 1 are then exact.
const BITS_OF_RATIOS: u32 = 52;

/// Binary digits after the point of the nodes.
const BITS_OF_NODES: u32 = 53;

/// The coefficients of the Gauss rule with `S` stages. Matrices are stored column by column,
/// `matrix[j][i]` for the effect of stage j on stage i, so that a product with a vector adds
/// columns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tableau<const S: usize> {
    /// Nodes, in units of the step.
    pub(super) c: [f64; S],
    /// Weights.
    pub(super) b: [f64; S],
    /// `a_ij / b_j`.
    pub(super) ratio: [[f64; S]; S],
    /// The same row by row: `ratio_of[i][j]` for the effect of stage j on stage i.
    pub(super) ratio_of: [[f64; S]; S],
    /// `Σ_k a_ik a_kj / b_j`.
    pub(super) second_order: [[f64; S]; S],
    /// `Σ_k μ_ik x_kj`, where x extrapolates the impulses of a step to those of the next one.
    pub(super) ratio_ahead: [[f64; S]; S],
    /// `Σ_k η_ik x_kj`.
    pub(super) second_order_ahead: [[f64; S]; S],
    /// `1 / b_i`.
    pub(super) inverse_b: [f64; S],
    /// `1 / w_i`, with the positive eigenvector w of `|a_ij|`, whose largest entry is 1.
    pub(super) inverse_units: [f64; S],
    /// The norm of `|a_ij|` in these units, its spectral radius.
    pub(super) norm: f64,
    /// The largest `Σ_j |a_ij| / w_i`.
    pub(super) reach: f64,
    /// The largest `c_i / w_i`.
    pub(super) latest: f64,
}

impl<const S: usize> Tableau<S> {
    /// The coefficients of the rule.
    pub(super) const VALUES: Self = Self::new();

    const fn new() -> Self {
        assert!(
            S >= 1 && S <= MOST_STAGES,
            "the Gauss rules have 1 to 8 stages"
        );
        let exact = Exact::<S>::new();
        let mut all = Self {
            c: [0.0; S],
            b: [0.0; S],
            ratio: [[0.0; S]; S],
            ratio_of: [[0.0; S]; S],
            second_order: [[0.0; S]; S],
            ratio_ahead: [[0.0; S]; S],
            second_order_ahead: [[0.0; S]; S],
            inverse_b: [0.0; S],
            inverse_units: [0.0; S],
            norm: 0.0,
            reach: 0.0,
            latest: 0.0,
        };
        let mut i = 0;
        while i < S {
            all.c[i] = exact.c[i].to_multiple_of_two_to_minus(BITS_OF_NODES);
            all.b[i] = exact.b[i].high;
            i += 1;
        }
        let mut i = 0;
        while i < S {
            let mut j = i;
            while j < S {
                let ratio = exact.ratio[i][j].to_multiple_of_two_to_minus(BITS_OF_RATIOS);
                (all.ratio[j][i], all.ratio_of[i][j]) = (ratio, ratio);
                (all.ratio[i][j], all.ratio_of[j][i]) = (1.0 - ratio, 1.0 - ratio);
                j += 1;
            }
            (all.ratio[i][i], all.ratio_of[i][i]) = (0.5, 0.5);
            let mut j = 0;
            while j < S {
                let (mut sum, mut second, mut k) = (Double::ZERO, Double::ZERO, 0);
                while k < S {
                    let ahead = exact.ahead[k][j];
                    sum = sum.plus(exact.ratio[i][k].times(ahead));
                    second = second.plus(exact.second_order(i, k).times(ahead));
                    k += 1;
                }
                all.second_order[j][i] = exact.second_order(i, j).high;
                all.ratio_ahead[j][i] = sum.high;
                all.second_order_ahead[j][i] = second.high;
                j += 1;
            }
            i += 1;
        }
        all.with_norm()
    }

    /// Computes the norm of `|a_ij|` by the power method.
    const fn with_norm(mut self) -> Self {
        let mut units = [1.0; S];
        let mut sweep = 0;
        while sweep < SWEEPS {
            let image = self.magnitudes(&units);
            let (mut largest, mut i) = (0.0, 0);
            while i < S {
                largest = larger(largest, image[i]);
                i += 1;
            }
            let mut i = 0;
            while i < S {
                units[i] = image[i] / largest;
                i += 1;
            }
            sweep += 1;
        }
        let (image, sums) = (self.magnitudes(&units), self.magnitudes(&[1.0; S]));
        let mut i = 0;
        while i < S {
            self.inverse_b[i] = 1.0 / self.b[i];
            self.inverse_units[i] = 1.0 / units[i];
            self.norm = larger(self.norm, image[i] / units[i]);
            self.reach = larger(self.reach, sums[i] / units[i]);
            self.latest = larger(self.latest, self.c[i] / units[i]);
            i += 1;
        }
        self
    }

    /// Returns `Σ_j |a_ij| x_j`.
    const fn magnitudes(&self, x: &[f64; S]) -> [f64; S] {
        let (mut sums, mut i) = ([0.0; S], 0);
        while i < S {
            let mut j = 0;
            while j < S {
                sums[i] += self.ratio[j][i].abs() * self.b[j] * x[j];
                j += 1;
            }
            i += 1;
        }
        sums
    }
}

/// Sweeps of the power method. The second eigenvalue is at most half of the first one.
const SWEEPS: u32 = 100;

const fn larger(x: f64, y: f64) -> f64 {
    if x > y { x } else { y }
}

/// The coefficients to 106 bits; `ratio[i][j]` is `a_ij / b_j`.
pub(super) struct Exact<const S: usize> {
    pub(super) c: [Double; S],
    pub(super) b: [Double; S],
    pub(super) ratio: [[Double; S]; S],
    /// `b_i ℓ_j(1 + c_i) / b_j`, which extrapolates the impulses of a step by their polynomial to
    /// the impulses of the next step.
    ahead: [[Double; S]; S],
}

impl<const S: usize> Exact<S> {
    pub(super) const fn new() -> Self {
        let half = Double::of(0.5);
        // P_k at each node, k from 0 to S
        let mut legendre = [[Double::ZERO; MOST_STAGES + 1]; S];
        let (mut c, mut b) = ([Double::ZERO; S], [Double::ZERO; S]);
        let mut i = 0;
        while i < S {
            let y = root(S, i);
            c[i] = Double::ONE.plus(y).times(half);
            legendre[i] = legendre_at(y);
            let (mut sum, mut k) = (Double::ZERO, 0);
            while k < S {
                let p = legendre[i][k];
                sum = sum.plus(p.times(p).times(Double::of((2 * k + 1) as f64)));
                k += 1;
            }
            b[i] = Double::ONE.over(sum);
            i += 1;
        }
        let (mut ratio, mut ahead) = ([[Double::ZERO; S]; S], [[Double::ZERO; S]; S]);
        let mut i = 0;
        while i < S {
            let next_step = legendre_at(root(S, i).plus(Double::of(2.0)));
            let mut j = 0;
            while j < S {
                let (mut sum, mut k) = (c[i].times(Double::of(2.0)), 1);
                while k < S {
                    let next = legendre[i][k + 1].minus(legendre[i][k - 1]);
                    sum = sum.plus(legendre[j][k].times(next));
                    k += 1;
                }
                ratio[i][j] = sum.times(half);
                let (mut sum, mut k) = (Double::ZERO, 0);
                while k < S {
                    let term = legendre[j][k].times(next_step[k]);
                    sum = sum.plus(term.times(Double::of((2 * k + 1) as f64)));
                    k += 1;
                }
                ahead[i][j] = sum.times(b[i]);
                j += 1;
            }
            i += 1;
        }
        Self { c, b, ratio, ahead }
    }

    /// Returns `Σ_k a_ik a_kj / b_j`.
    const fn second_order(&self, i: usize, j: usize) -> Double {
        let (mut sum, mut k) = (Double::ZERO, 0);
        while k < S {
            let first = self.ratio[i][k].times(self.b[k]);
            sum = sum.plus(first.times(self.ratio[k][j]));
            k += 1;
        }
        sum
    }
}

/// Returns the Legendre polynomials of degree 0 to [`MOST_STAGES`], by their recurrence.
pub(super) const fn legendre_at(y: Double) -> [Double; MOST_STAGES + 1] {
    let mut p = [Double::ONE; MOST_STAGES + 1];
    p[1] = y;
    let mut k = 1;
    while k < MOST_STAGES {
        let first = y.times(p[k]).times(Double::of((2 * k + 1) as f64));
        let second = p[k - 1].times(Double::of(k as f64));
        p[k + 1] = first.minus(second).over(Double::of((k + 1) as f64));
        k += 1;
    }
    p
}

#[cfg(test)]
mod tests {
    use super::{Double, Exact, Tableau};

    /// Checks the simplifying conditions B(2S), C(S) and D(S), which give order 2S (Hairer,
    /// Nørsett, Wanner, *Solving Ordinary Differential Equations I*, theorem II.7.4), in 106 bits.
    fn check_order<const S: usize>() {
        let exact = Exact::<S>::new();
        let power = |x: Double, k: usize| (0..k).fold(Double::ONE, |p, _| p.times(x));
        let number = |k: usize| Double::of(k as f64);
        let small = |x: Double, what: &str| {
            assert!(x.high.abs() < 1e-29, "{what} with {S} stages: {:e}", x.high);
        };
        for k in 1..=2 * S {
            let sum = (0..S).fold(Double::ZERO, |sum, i| {
                sum.plus(exact.b[i].times(power(exact.c[i], k - 1)))
            });
            small(sum.minus(Double::ONE.over(number(k))), "B");
        }
        let a = |i: usize, j: usize| exact.ratio[i][j].times(exact.b[j]);
        for k in 1..=S {
            for i in 0..S {
                let sum = (0..S).fold(Double::ZERO, |sum, j| {
                    sum.plus(a(i, j).times(power(exact.c[j], k - 1)))
                });
                small(sum.minus(power(exact.c[i], k).over(number(k))), "C");
                let sum = (0..S).fold(Double::ZERO, |sum, j| {
                    let term = exact.b[j].times(a(j, i));
                    sum.plus(term.times(power(exact.c[j], k - 1)))
                });
                let right = Double::ONE.minus(power(exact.c[i], k));
                let right = exact.b[i].times(right).over(number(k));
                small(sum.minus(right), "D");
            }
        }
    }

    /// Checks that impulses `b_i f(c_i)` of polynomials are extrapolated exactly.
    fn check_extrapolation<const S: usize>() {
        let all = Tableau::<S>::VALUES;
        let impulse = |c: f64, i: usize, k: usize| all.b[i] * c.powi(k as i32);
        for k in 0..S {
            let first: [f64; S] = core::array::from_fn(|i| impulse(all.c[i], i, k));
            let next: [f64; S] = core::array::from_fn(|i| impulse(1.0 + all.c[i], i, k));
            let pairs = [
                (&all.ratio, &all.ratio_ahead),
                (&all.second_order, &all.second_order_ahead),
            ];
            for (matrix, ahead) in pairs {
                for i in 0..S {
                    let sum = |m: &[[f64; S]; S], z: &[f64; S]| -> f64 {
                        (0..S).map(|j| m[j][i] * z[j]).sum()
                    };
                    let (found, expected) = (sum(ahead, &first), sum(matrix, &next));
                    let error = (found - expected).abs();
                    assert!(error < 1e-9, "{S} stages, degree {k}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn impulses_of_the_next_step_are_extrapolated() {
        check_extrapolation::<2>();
        check_extrapolation::<4>();
        check_extrapolation::<8>();
    }

    fn check_symplecticity<const S: usize>() {
        let exact = Exact::<S>::new();
        let Tableau {
            c,
            b,
            ratio,
            second_order,
            ..
        } = Tableau::<S>::VALUES;
        for i in 0..S {
            assert!((c[i] - exact.c[i].high).abs() <= 2.0_f64.powi(-53));
            assert!((b[i] - exact.b[i].high).abs() <= 2.0_f64.powi(-54));
            for j in 0..S {
                // The equality is exact: sums of multiples of 2⁻⁵² below 4 are not rounded.
                assert_eq!(ratio[j][i] + ratio[i][j], 1.0, "{S} stages, {i} {j}");
                let difference = second_order[j][i] - second_order[i][j];
                assert!((difference - (c[i] - c[j])).abs() < 1e-15);
                let at = |bits: i32| 2.0_f64.powi(-bits);
                assert!((ratio[j][i] - exact.ratio[i][j].high).abs() <= at(52));
                let eta = exact.second_order(i, j).high;
                assert_eq!(second_order[j][i], eta);
                assert_eq!(c[i] / at(53), (c[i] / at(53)).round());
                assert_eq!(ratio[j][i] / at(52), (ratio[j][i] / at(52)).round());
            }
        }
    }

    #[test]
    fn the_rules_have_order_twice_their_stages() {
        check_order::<1>();
        check_order::<2>();
        check_order::<3>();
        check_order::<4>();
        check_order::<5>();
        check_order::<6>();
        check_order::<7>();
        check_order::<8>();
    }

    #[test]
    fn coefficients_are_exactly_symplectic() {
        check_symplecticity::<1>();
        check_symplecticity::<2>();
        check_symplecticity::<3>();
        check_symplecticity::<4>();
        check_symplecticity::<5>();
        check_symplecticity::<6>();
        check_symplecticity::<7>();
        check_symplecticity::<8>();
    }

    #[test]
    fn one_stage_is_the_midpoint() {
        let Tableau { c, b, ratio, .. } = Tableau::<1>::VALUES;
        assert_eq!((c, b, ratio), ([0.5], [1.0], [[0.5]]));
    }
}
