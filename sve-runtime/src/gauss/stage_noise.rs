//! Increments at the stages of a Gauss rule.
//!
//! The increment of a process at stage i is `ω_i = ∫ ℓ_i dW`, where ℓ is the Lagrange basis of the
//! nodes. The ω are independent with variance `b_i h`, since the basis is orthogonal, and add up to
//! ΔW. Let `ξ_k` be the coefficients of the path in Legendre polynomials. They are independent with
//! variance h, and the first one is ΔW. Then
//!
//! ```text
//! ω_i = b_i Σ_{k<S} √(2k+1) P_k(2c_i − 1) ξ_k
//! ```
//!
//! so one path serves every number of stages, and the midpoint rule.

use super::tableau::Tableau;

/// Calls a function with the number of stages as a constant; `None` for a number that no rule has.
macro_rules! with_stages {
    ($stages:expr, $function:ident($($argument:expr),*)) => {
        match $stages {
            1 => Some($function::<1>($($argument),*)),
            2 => Some($function::<2>($($argument),*)),
            3 => Some($function::<3>($($argument),*)),
            4 => Some($function::<4>($($argument),*)),
            5 => Some($function::<5>($($argument),*)),
            6 => Some($function::<6>($($argument),*)),
            7 => Some($function::<7>($($argument),*)),
            8 => Some($function::<8>($($argument),*)),
            _ => None,
        }
    };
}

/// Returns the weights b of the rule with so many stages; `None` for a number that no rule has.
pub(crate) fn weights(stages: usize) -> Option<&'static [f64]> {
    fn of<const S: usize>() -> &'static [f64] {
        const { &Tableau::<S>::VALUES.b }
    }
    with_stages!(stages, of())
}

/// Returns the nodes c of the rule with so many stages; `None` for a number that no rule has.
fn nodes(stages: usize) -> Option<&'static [f64]> {
    fn of<const S: usize>() -> &'static [f64] {
        const { &Tableau::<S>::VALUES.c }
    }
    with_stages!(stages, of())
}

/// Writes the increments at the stages to `parts`, one for each stage, from the coefficients of the
/// path in Legendre polynomials. Returns whether there is a rule with so many stages.
#[inline]
pub(crate) fn from_coefficients(coefficients: impl Fn(usize) -> f64, parts: &mut [f64]) -> bool {
    fn of<const S: usize>(coefficients: impl Fn(usize) -> f64, parts: &mut [f64]) {
        let Tableau { b, c, .. } = const { &Tableau::<S>::VALUES };
        let coefficients: [f64; S] = core::array::from_fn(coefficients);
        for (i, part) in parts.iter_mut().enumerate() {
            let y = 2.0 * c[i] - 1.0;
            let (mut before, mut polynomial, mut sum) = (0.0, 1.0, coefficients[0]);
            for (k, coefficient) in coefficients.iter().enumerate().skip(1) {
                let degree = k as f64;
                let next =
                    ((2.0 * degree - 1.0) * y * polynomial - (degree - 1.0) * before) / degree;
                (before, polynomial) = (polynomial, next);
                sum += (2.0 * degree + 1.0).sqrt() * polynomial * coefficient;
            }
            *part = b[i] * sum;
        }
    }
    with_stages!(parts.len(), of(coefficients, parts)).is_some()
}

/// Adds the increments at the stages of step `number` among `count` steps to the increments of one
/// step over all of them, which has as many stages or fewer. The basis of the long step is a
/// polynomial on each short step, and the basis of the short step represents its degree, so the sum
/// is exact.
pub(crate) fn add_to_longer_step(parts: &[f64], [number, count]: [usize; 2], longer: &mut [f64]) {
    let (Some(nodes), Some(c)) = (nodes(parts.len()), nodes(longer.len())) else {
        return;
    };
    for (part, node) in parts.iter().zip(nodes) {
        let at = (number as f64 + node) / count as f64;
        for (i, longer) in longer.iter_mut().enumerate() {
            let others = (0..c.len()).filter(|&j| j != i);
            let basis: f64 = others.map(|j| (at - c[j]) / (c[i] - c[j])).product();
            *longer += basis * part;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{add_to_longer_step, from_coefficients, nodes, weights};

    /// Returns the increments at the stages for each coefficient alone.
    fn matrix(stages: usize) -> Vec<Vec<f64>> {
        let column = |k: usize| {
            let mut parts = vec![0.0; stages];
            assert!(from_coefficients(
                |at| f64::from(u8::from(at == k)),
                &mut parts
            ));
            parts
        };
        (0..stages).map(column).collect()
    }

    #[test]
    fn increments_at_the_stages_are_independent_with_the_weights_as_variances() {
        for stages in 1..=8 {
            let (columns, b) = (matrix(stages), weights(stages).unwrap());
            for i in 0..stages {
                for j in 0..stages {
                    let covariance: f64 = columns.iter().map(|column| column[i] * column[j]).sum();
                    let expected = if i == j { b[i] } else { 0.0 };
                    assert!((covariance - expected).abs() < 1e-15, "{stages} {i} {j}");
                }
            }
            for (k, column) in columns.iter().enumerate() {
                let sum: f64 = column.iter().sum();
                let expected = f64::from(u8::from(k == 0));
                assert!((sum - expected).abs() < 1e-15, "{stages} {k}");
            }
        }
        assert!(!from_coefficients(|_| 0.0, &mut [0.0; 9]));
        assert_eq!(weights(0), None);
    }

    /// Takes the integral of `x^degree` in place of a path: `ω_i = ∫ ℓ_i f′ dt` is exact where `f′`
    /// has a degree up to S.
    #[test]
    fn longer_steps_have_the_integrals_of_the_path() {
        for stages in 2..=8 {
            let integrals = |start: f64, h: f64, degree: i32| -> Vec<f64> {
                let (b, c) = (weights(stages).unwrap(), nodes(stages).unwrap());
                let slope = |x: f64| x.powi(degree);
                (0..stages)
                    .map(|i| h * b[i] * slope(start + c[i] * h))
                    .collect()
            };
            for degree in 0..stages as i32 {
                let mut longer = vec![0.0; stages];
                for number in 0..3 {
                    let parts = integrals(0.5 * number as f64, 0.5, degree);
                    add_to_longer_step(&parts, [number, 3], &mut longer);
                }
                for (x, expected) in longer.iter().zip(integrals(0.0, 1.5, degree)) {
                    assert!(
                        (x - expected).abs() < 1e-13,
                        "{stages} {degree}: {x} {expected}"
                    );
                }
            }
        }
    }

    /// A path has the same coefficients with fewer stages.
    #[test]
    fn fewer_stages_have_the_first_coefficients() {
        for stages in 2..=8 {
            for fewer in 1..stages {
                for (k, parts) in matrix(stages).iter().enumerate() {
                    let mut found = vec![0.0; fewer];
                    add_to_longer_step(parts, [0, 1], &mut found);
                    let zero = vec![0.0; fewer];
                    let expected = matrix(fewer).get(k).cloned().unwrap_or(zero);
                    for (x, expected) in found.iter().zip(expected) {
                        assert!((x - expected).abs() < 1e-14, "{stages} {fewer} {k}");
                    }
                }
            }
        }
    }
}
