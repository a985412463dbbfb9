//! The iteration that solves the equations of a step: Chebyshev's semi-iteration.
//!
//! Input: an interval that contains all eigenvalues of the Jacobian, and that is positive. Output:
//! the weights of the updates `Δ ← β Δ − α g`, with the residual g. If the Jacobian is not
//! symmetric, or rounding errors stop the iteration, its weights are those of Richardson's
//! iteration, which contracts in the norm of the largest component.
//!
//! Source: Saad, *Iterative Methods for Sparse Linear Systems* (2003), algorithm 12.1.

/// Part of a rounding error that the error of the iteration may have. Rounding errors have random
/// signs, and this error has none.
const PART: f64 = 1.0 / 16.0;

/// The weights of the updates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chebyshev {
    /// Middle and half width of the interval.
    middle: f64,
    half: f64,
    /// The weight that the next update depends on; `None` before the first one.
    rho: Option<f64>,
    is_plain: bool,
    is_first: bool,
    /// The largest ratio of successive errors, after several updates.
    contraction: f64,
}

impl Chebyshev {
    /// Returns the iteration for eigenvalues from `lower` to `upper`, which are positive.
    pub(super) fn new([lower, upper]: [f64; 2], is_symmetric: bool) -> Self {
        let [a, b] = [lower, upper].map(f64::sqrt);
        let mut iteration = Self {
            middle: 0.5 * (lower + upper),
            half: 0.5 * (upper - lower),
            rho: None,
            is_plain: false,
            is_first: true,
            contraction: (b - a) / (b + a),
        };
        if !is_symmetric {
            iteration.make_plain();
        }
        iteration
    }

    /// Returns a bound of the eigenvalues of the Jacobian without its unit matrix.
    fn slope(&self) -> f64 {
        let distance = |end: f64| (end - 1.0).abs();
        distance(self.middle - self.half).max(distance(self.middle + self.half))
    }

    /// Returns the number of updates that reduce an error to `part` of it.
    pub(super) fn updates(&self, part: f64) -> f64 {
        (part.ln() / self.contraction.ln()).max(1.0)
    }

    /// Returns a bound of the error of the nodes after the update `change`.
    pub(super) fn error(&self, change: f64) -> f64 {
        let ratio = if self.is_first {
            self.half / self.middle
        } else {
            self.contraction
        };
        change * ratio / (1.0 - ratio)
    }

    /// Returns whether the error of the nodes after the update `change` is below rounding errors:
    /// those of the nodes, none of which is farther than `farthest`, or those of displacements of
    /// `size`. A displacement is twice that of its node, and the impulse adds to it the slope times
    /// the displacement.
    pub(super) fn is_solved(&self, change: f64, size: f64, farthest: f64) -> bool {
        let of_impulse = size / (2.0 * self.slope());
        self.error(change) <= PART * f64::EPSILON * farthest.max(of_impulse)
            || change <= f64::EPSILON * farthest
    }

    /// Continues with the weights of Richardson's iteration. Returns whether the weights were
    /// others.
    pub(super) fn make_plain(&mut self) -> bool {
        self.contraction = self.half / self.middle;
        !core::mem::replace(&mut self.is_plain, true)
    }

    /// Returns the weight α of Richardson's iteration. Its updates reduce the largest error,
    /// whether the Jacobian is symmetric or not.
    pub(super) fn plain_weight(&self) -> f64 {
        1.0 / self.middle
    }

    /// Returns α and β of the next update.
    pub(super) fn weights(&mut self) -> [f64; 2] {
        self.is_first = self.rho.is_none();
        let Some(rho) = self.rho.filter(|_| !self.is_plain) else {
            self.rho = Some(self.half / self.middle);
            return [self.plain_weight(), 0.0];
        };
        let alpha = 2.0 / (2.0 * self.middle - self.half * rho);
        let next = 0.5 * self.half * alpha;
        self.rho = Some(next);
        [alpha, next * rho]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error after k updates is at most 2 τ^k of the first one for each eigenvalue in the
    /// interval, and at its ends it is that of the Chebyshev polynomial.
    #[test]
    fn errors_are_those_of_chebyshev_polynomials() {
        let [a, b] = [0.7, 3.1];
        for (eigenvalue, is_end) in [(a, true), (1.3, false), (2.2, false), (b, true)] {
            let mut iteration = Chebyshev::new([a, b], true);
            let (mut error, mut change) = (1.0, 0.0);
            for k in 1..12 {
                let [alpha, beta] = iteration.weights();
                change = beta * change - alpha * eigenvalue * error;
                error += change;
                let x = ((b + a) / (b - a)).acosh();
                let bound = 1.0 / (f64::from(k) * x).cosh();
                assert!(
                    f64::abs(error) <= bound * (1.0 + 1e-12),
                    "{k} {error} {bound}"
                );
                if is_end {
                    assert!((f64::abs(error) / bound - 1.0).abs() < 1e-10, "{k} {error}");
                }
            }
        }
    }

    #[test]
    fn plain_updates_contract_by_the_contraction() {
        let mut iteration = Chebyshev::new([0.5, 1.5], false);
        let mut error: f64 = 1.0;
        for _ in 0..5 {
            let [alpha, beta] = iteration.weights();
            assert_eq!([alpha, beta], [1.0, 0.0]);
            error -= alpha * 1.5 * error;
        }
        assert!((error.abs() - iteration.contraction.powi(5)).abs() < 1e-15);
    }
}
