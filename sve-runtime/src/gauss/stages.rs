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
pub(super) fn at_stages<const S: usize, const N: usize>(z: &Rows<S, N>) -> Rows<S, N> {
    let ratio = const { &Tableau::<S>::VALUES.ratio };
    let mut sums = [[0.0; S]; N];
    for n in 0..N {
        sums[n] = product(ratio, &z[n]);
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

/// Returns the largest magnitude of a coordinate at the stages; what is not a number is passed over.
#[inline(always)]
pub(super) fn largest<const S: usize>(z: &[f64; S]) -> f64 {
    let mut largest = 0.0;
    for i in 0..S {
        let size = z[i].abs();
        largest = if size > largest { size } else { largest };
    }
    largest
}

/// Returns the largest change of a coordinate at the stages, relative to its size at the start and to how far it moves; NaN if a change is not a number.
#[inline(always)]
pub(super) fn relative_change<const S: usize>(start: f64, old: &[f64; S], new: &[f64; S]) -> f64 {
    let (mut change, mut undefined) = ([0.0; S], 0.0);
    for i in 0..S {
        change[i] = new[i] - old[i];
    }
    for i in 0..S {
        undefined += 0.0 * change[i];
    }
    let size = start.abs() + largest(new) + f64::MIN_POSITIVE;
    largest(&change) / size + undefined
}
