//! Stages in lanes: sums over stages and products with the matrices of a rule, as loops over arrays that the compiler turns into vector instructions.

use super::tableau::Tableau;

/// A number at each stage, for each coordinate.
pub(super) type Rows<const S: usize, const N: usize> = [[f64; S]; N];

/// Returns `Σ_j matrix[j] z_j`. The products are added as a tree, whose chain of operations is shorter than that of a sum in order.
#[inline(always)]
pub(super) fn product<const S: usize>(matrix: &[[f64; S]; S], z: &[f64; S]) -> [f64; S] {
    let mut terms = [[0.0; S]; S];
    for j in 0..S {
        for i in 0..S {
            terms[j][i] = matrix[j][i] * z[j];
        }
    }
    let mut width = S;
    while width > 1 {
        let half = width.div_ceil(2);
        for j in 0..width / 2 {
            for i in 0..S {
                terms[j][i] += terms[j + half][i];
            }
        }
        width = half;
    }
    terms[0]
}

/// Returns `Σ_j μ_ij z_j` at all stages.
#[inline(always)]
pub(super) fn at_stages<const S: usize, const N: usize>(
    tableau: &Tableau<S>,
    z: &Rows<S, N>,
) -> Rows<S, N> {
    let mut sums = [[0.0; S]; N];
    for n in 0..N {
        sums[n] = product(&tableau.ratio, &z[n]);
    }
    sums
}

/// Returns the sum over the stages, the first with the last: the order is that of the step backwards.
#[inline(always)]
pub(super) fn sum<const S: usize>(z: &[f64; S]) -> f64 {
    let mut sum = 0.0;
    for j in 0..S / 2 {
        sum += z[j] + z[S - 1 - j];
    }
    if S % 2 == 1 {
        sum += z[S / 2];
    }
    sum
}

/// Returns the reciprocal of the size of a coordinate: its magnitude at the start and the farthest that it moves at the stages.
#[inline(always)]
pub(super) fn inverse_size<const S: usize>(start: f64, moves: &[f64; S]) -> f64 {
    let mut sizes = [0.0; S];
    for i in 0..S {
        sizes[i] = moves[i].abs();
    }
    1.0 / (start.abs() + largest(sizes) + f64::MIN_POSITIVE)
}

/// The change of a sweep, relative to the sizes of the coordinates: the largest one at each stage.
#[derive(Clone, Copy)]
pub(super) struct Change<const S: usize> {
    largest: [f64; S],
    /// The sum, which is NaN if a change is; comparisons would drop it.
    sum: [f64; S],
}

impl<const S: usize> Change<S> {
    pub(super) const NONE: Self = Self {
        largest: [0.0; S],
        sum: [0.0; S],
    };

    /// Includes the change of a coordinate.
    #[inline(always)]
    pub(super) fn include(&mut self, old: &[f64; S], new: &[f64; S], inverse_size: f64) {
        for i in 0..S {
            let change = (new[i] - old[i]).abs() * inverse_size;
            let largest = self.largest[i];
            self.largest[i] = if change > largest { change } else { largest };
            self.sum[i] += change;
        }
    }

    /// Returns the largest change of all coordinates and stages; NaN if one of them is.
    #[inline(always)]
    pub(super) fn largest(&self) -> f64 {
        let mut sum = 0.0;
        for i in 0..S {
            sum += self.sum[i];
        }
        largest(self.largest) + 0.0 * sum
    }
}

/// Returns the largest of numbers that are not negative.
#[inline(always)]
fn largest<const S: usize>(mut numbers: [f64; S]) -> f64 {
    let mut width = S;
    while width > 1 {
        let half = width.div_ceil(2);
        for j in 0..width / 2 {
            let (a, b) = (numbers[j], numbers[j + half]);
            numbers[j] = if a > b { a } else { b };
        }
        width = half;
    }
    numbers[0]
}

#[cfg(test)]
mod tests {
    use super::{Change, inverse_size, product, sum};

    #[test]
    fn products_and_sums_are_those_of_all_stages() {
        fn check<const S: usize>() {
            let matrix: [[f64; S]; S] =
                core::array::from_fn(|j| core::array::from_fn(|i| (i + 10 * j) as f64));
            let z: [f64; S] = core::array::from_fn(|j| (j + 1) as f64);
            for (i, x) in product(&matrix, &z).into_iter().enumerate() {
                let expected: f64 = (0..S).map(|j| ((i + 10 * j) * (j + 1)) as f64).sum();
                assert_eq!(x, expected);
            }
            assert_eq!(sum(&z), (S * (S + 1) / 2) as f64);
        }
        check::<2>();
        check::<3>();
        check::<5>();
        check::<8>();
    }

    #[test]
    fn a_change_is_relative_and_nan_is_not_lost() {
        let inverse = inverse_size(-1.0, &[0.5, -3.0, 1.0]);
        assert_eq!(inverse, 0.25);
        let mut change = Change::NONE;
        change.include(&[0.0, 1.0, 2.0], &[0.5, 1.0, 0.0], inverse);
        change.include(&[0.0; 3], &[0.0, 0.0, 0.1], 1.0);
        assert_eq!(change.largest(), 0.5);
        change.include(&[0.0; 3], &[f64::NAN, 0.0, 0.0], 1.0);
        change.include(&[0.0; 3], &[1.0; 3], 1.0);
        assert!(change.largest().is_nan());
    }
}
