//! Stages in lanes: sums over stages and products with the matrices of a rule, as loops over arrays
//! that the compiler turns into vector instructions.

use super::tableau::Tableau;

/// A number at each stage, for each coordinate.
pub(super) type Rows<const S: usize, const N: usize> = [[f64; S]; N];

/// A matrix over the stages, column by column.
pub(super) type Matrix<const S: usize> = [[f64; S]; S];

/// Returns `Σ_j matrix[j] z_j`. The products are added as a tree, whose chain of operations is
/// shorter than the chain of a sum in order.
#[inline(always)]
pub(super) fn product<const S: usize>(matrix: &Matrix<S>, z: &[f64; S]) -> [f64; S] {
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

/// Returns the sum over the stages, adding the first to the last. The order is the same for the
/// step backwards.
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

/// Returns the reciprocal of the size of a coordinate: its magnitude at the start plus its largest
/// displacement at the stages.
#[inline(always)]
pub(super) fn inverse_size<const S: usize>(start: f64, moves: &[f64; S]) -> f64 {
    let mut sizes = [0.0; S];
    for i in 0..S {
        sizes[i] = moves[i].abs();
    }
    1.0 / (start.abs() + largest(sizes) + f64::MIN_POSITIVE)
}

/// Returns the largest change of a coordinate at a stage, relative to the sizes of the coordinates;
/// changes that are not numbers do not count, unless no change is a number: the tests of the step's
/// result find them. Overwrites `old`.
///
/// Rows are combined in memory: variables that a loop over coordinates carries for each stage would
/// not be put into vectors.
#[inline(always)]
pub(super) fn relative_change<const S: usize, const N: usize>(
    old: &mut Rows<S, N>,
    new: &Rows<S, N>,
    inverse_sizes: &[f64; N],
) -> f64 {
    for n in 0..N {
        for i in 0..S {
            old[n][i] = ((new[n][i] - old[n][i]) * inverse_sizes[n]).abs();
        }
    }
    let mut width = N;
    while width > 1 {
        let half = width.div_ceil(2);
        for n in 0..width / 2 {
            for i in 0..S {
                old[n][i] = larger(old[n][i], old[n + half][i]);
            }
        }
        width = half;
    }
    largest(old[0])
}

/// Returns the largest of numbers as [`larger`] does.
#[inline(always)]
fn largest<const S: usize>(mut numbers: [f64; S]) -> f64 {
    let mut width = S;
    while width > 1 {
        let half = width.div_ceil(2);
        for j in 0..width / 2 {
            numbers[j] = larger(numbers[j], numbers[j + half]);
        }
        width = half;
    }
    numbers[0]
}

/// Returns the larger of two numbers; the second one if one of them is NaN. A comparison of
/// floating-point numbers, and not of their bits, becomes one instruction for all lanes.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::{inverse_size, product, relative_change, sum};

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
    fn a_change_is_relative() {
        let inverse = inverse_size(-1.0, &[0.5, -3.0, 1.0]);
        assert_eq!(inverse, 0.25);
        let change = |new: [[f64; 3]; 2]| {
            let mut old = [[0.0, 1.0, 2.0], [0.0; 3]];
            relative_change(&mut old, &new, &[inverse, 1.0])
        };
        assert_eq!(change([[0.5, 1.0, 0.0], [0.0, 0.0, 0.1]]), 0.5);
        assert_eq!(change([[0.5, 1.0, 2.0], [0.0, -0.7, 0.1]]), 0.7);
        assert!(change([[f64::NAN; 3]; 2]).is_nan());
    }
}
