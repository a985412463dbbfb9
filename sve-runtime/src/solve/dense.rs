//! Linear systems with a dense matrix of a size known at compile time.
//!
//! Input: matrix and right-hand side. Output: the solution and the sign of the determinant, or
//! `None` if the matrix is singular to rounding. One and two unknowns are solved by Cramer's rule,
//! which is forward stable for two (Higham, *Accuracy and Stability of Numerical Algorithms*,
//! section 1.10.1). Three and more are solved by Gaussian elimination with scaled partial pivoting:
//! equations in different units choose the same pivots. Their factors can be kept for further
//! right-hand sides.

/// Relative size below which a difference of two terms is indistinguishable from rounding error. A
/// pivot is a difference of K terms, so its threshold is K times this one.
pub(crate) const SINGULAR: f64 = 4.0 * f64::EPSILON;

/// The same size for a matrix whose entries are sums with rounding errors of their own, such as a
/// mass matrix.
pub(crate) const WITHOUT_DIGITS: f64 = 16.0 * SINGULAR;

/// The sign of a determinant, as a number of that sign.
///
/// Two regular matrices between which a path of regular matrices exists have determinants of the
/// same sign.
#[derive(Clone, Copy, Debug)]
pub struct DeterminantSign(f64);

impl DeterminantSign {
    /// The sign of an unknown determinant. It is opposite to no sign.
    pub const UNKNOWN: Self = Self(f64::NAN);

    /// The sign of a number.
    #[inline(always)]
    pub(crate) const fn of(number: f64) -> Self {
        Self(number)
    }

    #[inline(always)]
    pub(super) fn from_is_negative(is_negative: bool) -> Self {
        Self(if is_negative { -1.0 } else { 1.0 })
    }

    /// Returns whether one sign is plus and the other minus.
    #[inline(always)]
    pub(crate) fn is_opposite_to(self, other: Self) -> bool {
        (self.0 < 0.0 && other.0 > 0.0) || (self.0 > 0.0 && other.0 < 0.0)
    }

    #[inline(always)]
    pub(crate) fn is_unknown(self) -> bool {
        self.0.is_nan()
    }

    #[cfg(test)]
    pub(crate) fn is_negative(self) -> bool {
        self.0 < 0.0
    }
}

/// A square matrix of `K` rows that linear systems of a step have.
pub trait Matrix<const K: usize>: Copy {
    /// Solves `a x = b`. Returns the solution and the sign of the determinant, or `None` if the
    /// matrix is singular to rounding.
    #[inline(always)]
    fn solve_with_sign(&self, b: &[f64; K]) -> Option<([f64; K], DeterminantSign)> {
        self.solve_above(SINGULAR, b)
    }
    /// Solves `a x = b` as [`solve_with_sign`](Self::solve_with_sign) does, with another relative
    /// size of the pivots that count as rounding error.
    fn solve_above(&self, rounding: f64, b: &[f64; K]) -> Option<([f64; K], DeterminantSign)>;
    /// Returns whether all entries are finite.
    fn is_finite(&self) -> bool;
    /// Returns the entry of the first row and column.
    fn first(&self) -> f64;
}

/// Returns whether all numbers are finite, without branches.
#[inline(always)]
pub(super) fn all_finite(numbers: &[f64]) -> bool {
    let mut sum = 0.0;
    for x in numbers {
        sum += 0.0 * x;
    }
    sum == 0.0
}

/// Solves `a x = b`.
#[inline(always)]
pub fn solve<const K: usize>(a: &impl Matrix<K>, b: &[f64; K]) -> Option<[f64; K]> {
    a.solve_with_sign(b).map(|(x, _)| x)
}

/// Solves `a x = b`. Returns the solution and the sign of the determinant.
#[inline(always)]
pub fn solve_with_sign<const K: usize>(
    a: &impl Matrix<K>,
    b: &[f64; K],
) -> Option<([f64; K], DeterminantSign)> {
    a.solve_with_sign(b)
}

/// Returns whether every pivot exceeds the rounding errors of a matrix whose entries are sums.
#[inline(always)]
pub fn is_regular<const K: usize>(a: &impl Matrix<K>) -> bool {
    a.solve_above(WITHOUT_DIGITS, &[0.0; K]).is_some()
}

impl<const K: usize> Matrix<K> for [[f64; K]; K] {
    #[inline(always)]
    fn solve_above(&self, rounding: f64, b: &[f64; K]) -> Option<([f64; K], DeterminantSign)> {
        solve_dense(self, rounding, b)
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        all_finite(self.as_flattened())
    }

    #[inline(always)]
    fn first(&self) -> f64 {
        self[0][0]
    }
}

#[inline(always)]
fn solve_dense<const K: usize>(
    a: &[[f64; K]; K],
    rounding: f64,
    b: &[f64; K],
) -> Option<([f64; K], DeterminantSign)> {
    let mut x = [0.0; K];
    let mut sign = DeterminantSign::of(1.0);
    match K {
        0 => {}
        1 => {
            if a[0][0] == 0.0 {
                return None;
            }
            x[0] = b[0] / a[0][0];
            sign = DeterminantSign::of(a[0][0]);
        }
        2 => {
            let (ad, bc) = (a[0][0] * a[1][1], a[0][1] * a[1][0]);
            let det = ad - bc;
            if det.abs() <= rounding * (ad.abs() + bc.abs()) {
                return None;
            }
            let inverse = 1.0 / det;
            x[0] = (b[0] * a[1][1] - b[1] * a[0][1]) * inverse;
            x[1] = (b[1] * a[0][0] - b[0] * a[1][0]) * inverse;
            sign = DeterminantSign::of(det);
        }
        _ => return eliminate(a, rounding, b),
    }
    Some((x, sign))
}

/// Solves a system of three and more unknowns by its factors.
fn eliminate<const K: usize>(
    matrix: &[[f64; K]; K],
    rounding: f64,
    rhs: &[f64; K],
) -> Option<([f64; K], DeterminantSign)> {
    let mut lu = *matrix;
    let (rows, sign) = factor(matrix, rounding, &mut lu)?;
    Some((substitute(&lu, &rows, rhs), sign))
}

/// The LU factors of a matrix, for several right-hand sides.
#[derive(Clone, Copy, Debug)]
pub struct Factors<const K: usize> {
    /// The upper factor, and below the diagonal the lower one without its unit diagonal.
    lu: [[f64; K]; K],
    /// The row of the matrix that became each row of the factors.
    rows: [usize; K],
    sign: DeterminantSign,
}

impl<const K: usize> Factors<K> {
    /// Solves `a x = b`, bit for bit as [`solve`] does for three and more unknowns.
    #[inline(always)]
    pub fn solve(&self, b: &[f64; K]) -> [f64; K] {
        substitute(&self.lu, &self.rows, b)
    }

    /// Returns the sign of the determinant.
    #[inline(always)]
    pub fn sign(&self) -> DeterminantSign {
        self.sign
    }
}

/// Factors a matrix. Returns `None` if it is singular to rounding.
pub fn factored<const K: usize>(matrix: &[[f64; K]; K]) -> Option<Factors<K>> {
    let mut lu = *matrix;
    let (rows, sign) = factor(matrix, SINGULAR, &mut lu)?;
    Some(Factors { lu, rows, sign })
}

/// Solves with the factors of a matrix. `rows` gives the exchanges of rows.
#[inline(always)]
fn substitute<const K: usize>(lu: &[[f64; K]; K], rows: &[usize; K], b: &[f64; K]) -> [f64; K] {
    let mut x = rows.map(|row| b[row]);
    for k in 0..K {
        for i in k + 1..K {
            x[i] -= lu[i][k] * x[k];
        }
    }
    for k in (0..K).rev() {
        let mut sum = x[k];
        for j in k + 1..K {
            sum -= lu[k][j] * x[j];
        }
        x[k] = sum / lu[k][k];
    }
    x
}

/// Gaussian elimination with scaled partial pivoting: turns `a`, a copy of the matrix, into its
/// factors. Returns the row of the matrix that became each row, and the sign of the determinant. In
/// place, since code that is not optimised would put several copies of a large matrix on the stack.
#[inline(always)]
fn factor<const K: usize>(
    matrix: &[[f64; K]; K],
    rounding: f64,
    a: &mut [[f64; K]; K],
) -> Option<([usize; K], DeterminantSign)> {
    let mut rows = core::array::from_fn(|i| i);
    let mut is_negative = false;
    let mut scale = [0.0; K];
    for i in 0..K {
        scale[i] = largest_magnitude(&a[i]);
    }
    for k in 0..K {
        let pivot = pivot_row(a, &scale, k);
        // A pivot that is small beside its row may be a rounding error, or its unknown may have a
        // large unit. The slower test distinguishes the two.
        let size = a[pivot][k].abs();
        if size <= K as f64 * rounding * scale[pivot] && is_rounding_error(matrix, rounding, k) {
            return None;
        }
        a.swap(k, pivot);
        rows.swap(k, pivot);
        scale.swap(k, pivot);
        is_negative ^= (a[k][k] < 0.0) ^ (pivot != k);
        for i in k + 1..K {
            let factor = a[i][k] / a[k][k];
            for j in k + 1..K {
                a[i][j] -= factor * a[k][j];
            }
            a[i][k] = factor;
        }
    }
    Some((rows, DeterminantSign::from_is_negative(is_negative)))
}

/// Returns the row from `k` on with the largest entry of column `k` relative to the row's scale.
#[inline(always)]
fn pivot_row<const K: usize>(a: &[[f64; K]; K], scale: &[f64; K], k: usize) -> usize {
    let mut pivot = k;
    for i in k + 1..K {
        // |a[i][k]| / scale[i] > |a[pivot][k]| / scale[pivot], without dividing
        if a[i][k].abs() * scale[pivot] > a[pivot][k].abs() * scale[i] {
            pivot = i;
        }
    }
    pivot
}

/// Returns whether the pivot of column `k` is only rounding error.
///
/// Repeats the elimination and accumulates, for each entry, the sum of the magnitudes of the terms
/// subtracted to form it. A pivot far below that sum has no correct digits. Unlike the largest
/// entry of a row or column, the sum has the unit of the pivot.
#[cold]
fn is_rounding_error<const K: usize>(matrix: &[[f64; K]; K], rounding: f64, k: usize) -> bool {
    let mut a = *matrix;
    // in place: `map` would pass copies of the largest matrices through the stack
    let mut terms = *matrix;
    for entry in terms.as_flattened_mut() {
        *entry = entry.abs();
    }
    let mut scale: [f64; K] = core::array::from_fn(|i| largest_magnitude(&matrix[i]));
    for column in 0..=k {
        let pivot = pivot_row(&a, &scale, column);
        a.swap(column, pivot);
        terms.swap(column, pivot);
        scale.swap(column, pivot);
        if column == k {
            break;
        }
        for i in column + 1..K {
            let factor = a[i][column] / a[column][column];
            for j in column + 1..K {
                a[i][j] -= factor * a[column][j];
                terms[i][j] += factor.abs() * terms[column][j];
            }
        }
    }
    a[k][k].abs() <= K as f64 * rounding * terms[k][k]
}

/// Returns the largest magnitude of a row's entries.
#[inline]
pub(super) fn largest_magnitude(row: &[f64]) -> f64 {
    row.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

#[cfg(test)]
pub(crate) mod tests;
