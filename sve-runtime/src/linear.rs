//! Linear systems of a size known at compile time, and the solution of dense ones.
//!
//! Input: matrix and right-hand side; output: the solution, or `None` where the matrix is singular to rounding.
//! One and two unknowns are written out (Cramer's rule is forward stable for two: Higham, Accuracy and Stability of
//! Numerical Algorithms, section 1.10.1); from three on Gaussian elimination with scaled partial pivoting,
//! so that equations in different units choose the same pivots.

/// Relative size under which what is left of two terms counts as zero: the rounding error of forming it.
/// A pivot is what is left of K.
pub(crate) const SINGULAR: f64 = 4.0 * f64::EPSILON;

/// A matrix of `K` rows that a step solves with.
pub trait Matrix<const K: usize> {
    /// The solution of `a x = b` with a number of the sign of the determinant; nothing where the matrix is singular to
    /// rounding.
    fn solve_oriented(&self, b: &[f64; K]) -> Option<([f64; K], f64)>;
    /// Whether all entries are.
    fn is_finite(&self) -> bool;
    /// The entry of the first row and column.
    fn first(&self) -> f64;
}

/// Solves `a x = b`.
#[inline(always)]
pub fn solve<const K: usize>(a: &impl Matrix<K>, b: &[f64; K]) -> Option<[f64; K]> {
    a.solve_oriented(b).map(|(x, _)| x)
}

/// Solves `a x = b`; with the solution a number of the sign of the determinant.
#[inline(always)]
pub fn solve_oriented<const K: usize>(a: &impl Matrix<K>, b: &[f64; K]) -> Option<([f64; K], f64)> {
    a.solve_oriented(b)
}

impl<const K: usize> Matrix<K> for [[f64; K]; K] {
    #[inline(always)]
    fn solve_oriented(&self, b: &[f64; K]) -> Option<([f64; K], f64)> {
        dense(self, b)
    }

    fn is_finite(&self) -> bool {
        self.as_flattened().iter().all(|x| x.is_finite())
    }

    #[inline(always)]
    fn first(&self) -> f64 {
        self[0][0]
    }
}

#[inline(always)]
fn dense<const K: usize>(a: &[[f64; K]; K], b: &[f64; K]) -> Option<([f64; K], f64)> {
    let mut x = [0.0; K];
    let mut orientation = 1.0;
    match K {
        0 => {}
        1 => {
            if a[0][0] == 0.0 {
                return None;
            }
            x[0] = b[0] / a[0][0];
            orientation = a[0][0];
        }
        2 => {
            let (ad, bc) = (a[0][0] * a[1][1], a[0][1] * a[1][0]);
            let det = ad - bc;
            if det.abs() <= SINGULAR * (ad.abs() + bc.abs()) {
                return None;
            }
            let inverse = 1.0 / det;
            x[0] = (b[0] * a[1][1] - b[1] * a[0][1]) * inverse;
            x[1] = (b[1] * a[0][0] - b[0] * a[1][0]) * inverse;
            orientation = det;
        }
        _ => return eliminate(a, b),
    }
    Some((x, orientation))
}

fn eliminate<const K: usize>(matrix: &[[f64; K]; K], rhs: &[f64; K]) -> Option<([f64; K], f64)> {
    let (mut a, mut b) = (*matrix, *rhs);
    let mut negative = false;
    let mut scale = [0.0; K];
    for i in 0..K {
        scale[i] = largest(&a[i]);
    }
    for k in 0..K {
        let mut pivot = k;
        for i in k + 1..K {
            // |a[i][k]| / scale[i] > |a[pivot][k]| / scale[pivot], without dividing
            if a[i][k].abs() * scale[pivot] > a[pivot][k].abs() * scale[i] {
                pivot = i;
            }
        }
        // A pivot that is small beside its row is one that has cancelled, or an unknown in a large unit: the second look tells.
        let size = a[pivot][k].abs();
        if size <= K as f64 * SINGULAR * scale[pivot] && cancelled(matrix, k) {
            return None;
        }
        a.swap(k, pivot);
        b.swap(k, pivot);
        scale.swap(k, pivot);
        negative ^= (a[k][k] < 0.0) ^ (pivot != k);
        for i in k + 1..K {
            let factor = a[i][k] / a[k][k];
            for j in k + 1..K {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    let mut x = [0.0; K];
    for k in (0..K).rev() {
        let mut sum = b[k];
        for j in k + 1..K {
            sum -= a[k][j] * x[j];
        }
        x[k] = sum / a[k][k];
    }
    Some((x, if negative { -1.0 } else { 1.0 }))
}

/// Largest magnitude in a row.
fn largest(row: &[f64]) -> f64 {
    row.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// Whether the pivot of column `k` is the rounding of the terms it is what is left of: the elimination once more, with the
/// magnitudes of the terms of each entry. Unlike a row or a column these all have the unit of the entry.
#[cold]
fn cancelled<const K: usize>(matrix: &[[f64; K]; K], k: usize) -> bool {
    let mut a = *matrix;
    let mut terms = matrix.map(|row| row.map(f64::abs));
    let mut scale = matrix.map(|row| largest(&row));
    for column in 0..=k {
        let mut pivot = column;
        for i in column + 1..K {
            if a[i][column].abs() * scale[pivot] > a[pivot][column].abs() * scale[i] {
                pivot = i;
            }
        }
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
    a[k][k].abs() <= K as f64 * SINGULAR * terms[k][k]
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{solve, solve_oriented};

    /// `SplitMix64`, uniform in [−1, 1).
    pub(crate) struct Random(pub(crate) u64);

    impl Random {
        pub(crate) fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn matrix<const K: usize>(&mut self) -> [[f64; K]; K] {
            core::array::from_fn(|_| core::array::from_fn(|_| self.next()))
        }

        /// A power of two from 2⁻⁶⁰ to 2⁶⁰.
        pub(crate) fn unit(&mut self) -> f64 {
            2.0_f64.powi((61.0 * self.next()) as i32)
        }
    }

    fn product<const K: usize>(a: &[[f64; K]; K], x: &[f64; K]) -> [f64; K] {
        core::array::from_fn(|i| (0..K).map(|j| a[i][j] * x[j]).sum())
    }

    /// `|Ax − b| ≤ growth ε |A||x|`, row by row: what a backward stable solution satisfies. Cramer's rule is only forward
    /// stable, and its residual is larger by the condition number, hence the bound over all samples on the median there.
    fn backward_error<const K: usize>(a: &[[f64; K]; K], x: &[f64; K], b: &[f64; K]) -> f64 {
        let ax = product(a, x);
        (0..K)
            .map(|i| {
                let size: f64 = (0..K).map(|j| (a[i][j] * x[j]).abs()).sum();
                (ax[i] - b[i]).abs() / (size + b[i].abs())
            })
            .fold(0.0, f64::max)
    }

    fn random_systems<const K: usize>() {
        let mut random = Random(K as u64);
        for _ in 0..2000 {
            let a = random.matrix::<K>();
            let b = core::array::from_fn(|_| random.next());
            let x = solve(&a, &b).expect("a random matrix has an inverse");
            let bound = if K == 2 {
                let det = a[0][0] * a[1][1] - a[0][1] * a[1][0];
                8.0 / det.abs()
            } else {
                8.0 * K as f64
            };
            let error = backward_error(&a, &x, &b);
            assert!(error <= bound * f64::EPSILON, "{a:?} {b:?}: {error:e}");
        }
    }

    #[test]
    fn random_systems_are_solved_to_rounding() {
        random_systems::<1>();
        random_systems::<2>();
        random_systems::<3>();
        random_systems::<4>();
        random_systems::<5>();
        random_systems::<6>();
    }

    fn permuted<const K: usize>() {
        // a cyclic permutation has no pivot on its diagonal
        let mut a = [[0.0; K]; K];
        let mut b = [0.0; K];
        for i in 0..K {
            a[i][(i + 1) % K] = 2.0;
            b[i] = 2.0 * ((i + 1) % K) as f64;
        }
        let x = solve(&a, &b).unwrap();
        for i in 0..K {
            assert_eq!(x[i], i as f64);
        }
    }

    /// The determinant by permutations, which is exact enough to have a sign.
    fn determinant<const K: usize>(a: &[[f64; K]; K], row: usize, used: usize) -> f64 {
        let (mut sum, mut sign) = (0.0, 1.0);
        if row == K {
            return 1.0;
        }
        for j in (0..K).filter(|j| used >> j & 1 == 0) {
            sum += sign * a[row][j] * determinant(a, row + 1, used | 1 << j);
            sign = -sign;
        }
        sum
    }

    fn orientations<const K: usize>() {
        let mut random = Random(300 + K as u64);
        for _ in 0..500 {
            let a = random.matrix::<K>();
            let expected = determinant(&a, 0, 0);
            let (_, orientation) = solve_oriented(&a, &[1.0; K]).unwrap();
            assert_eq!(orientation < 0.0, expected < 0.0, "{a:?}");
        }
    }

    #[test]
    fn the_orientation_has_the_sign_of_the_determinant() {
        orientations::<1>();
        orientations::<2>();
        orientations::<3>();
        orientations::<4>();
        orientations::<5>();
    }

    #[test]
    fn permutations_are_exact() {
        permuted::<1>();
        permuted::<2>();
        permuted::<3>();
        permuted::<4>();
        permuted::<5>();
        permuted::<6>();
        assert_eq!(solve(&[[0.0; 0]; 0], &[]), Some([]));
    }

    fn singular<const K: usize>() {
        let mut random = Random(100 + K as u64);
        let b: [f64; K] = core::array::from_fn(|_| random.next());
        assert_eq!(solve(&[[0.0; K]; K], &b), None);
        let mut missed = 0;
        for sample in 0..1000 {
            let regular = random.matrix::<K>();
            let at = sample % K;
            let (mut row, mut column, mut combination) = (regular, regular, regular);
            row[at] = [0.0; K];
            combination[at] = [0.0; K];
            for i in 0..K {
                column[i][at] = 0.0;
                if i != at {
                    let factor = random.next();
                    for j in 0..K {
                        combination[at][j] += factor * regular[i][j];
                    }
                }
            }
            let (rows, columns) = (units::<K>(&mut random), units::<K>(&mut random));
            for a in [row, column] {
                assert_eq!(solve(&a, &b), None, "{a:?}");
                assert_eq!(solve(&scaled(&a, &rows, &columns), &b), None, "{a:?}");
            }
            // A combination is one to rounding only, and what is left of it grows by the condition number of the others: a
            // bound that caught all would refuse regular matrices.
            for a in [combination, scaled(&combination, &rows, &[1.0; K])] {
                missed += u32::from(solve(&a, &b).is_some());
            }
        }
        assert!(
            missed < 100,
            "{missed} of 2000 singular matrices were not noticed"
        );
    }

    fn units<const K: usize>(random: &mut Random) -> [f64; K] {
        core::array::from_fn(|_| random.unit())
    }

    fn scaled<const K: usize>(
        a: &[[f64; K]; K],
        rows: &[f64; K],
        columns: &[f64; K],
    ) -> [[f64; K]; K] {
        core::array::from_fn(|i| core::array::from_fn(|j| a[i][j] * rows[i] * columns[j]))
    }

    #[test]
    fn singular_matrices_are_refused() {
        singular::<1>();
        singular::<2>();
        singular::<3>();
        singular::<4>();
        singular::<5>();
        singular::<6>();
    }

    fn in_other_units<const K: usize>() {
        let mut random = Random(200 + K as u64);
        for _ in 0..2000 {
            // a dominant diagonal, so that the pivots are good in any units of the unknowns
            let mut a = random.matrix::<K>();
            for i in 0..K {
                for j in 0..K {
                    // zeros too: a row without the unknown in the largest unit looks larger than the others
                    if random.next() > 0.0 {
                        a[i][j] = 0.0;
                    }
                }
                a[i][i] += 2.0 * K as f64;
            }
            let b: [f64; K] = core::array::from_fn(|_| random.next());
            let x = solve(&a, &b).unwrap();
            let norm = x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let (rows, columns) = (units::<K>(&mut random), units::<K>(&mut random));
            let rhs: [f64; K] = core::array::from_fn(|i| b[i] * rows[i]);

            // the units of the equations: the same pivots, so the same bits
            assert_eq!(solve(&scaled(&a, &rows, &[1.0; K]), &rhs), Some(x));

            // the units of the unknowns too: other pivots, no longer the best in each column, so the same numbers but for a few digits
            let y = solve(&scaled(&a, &rows, &columns), &rhs).expect("regular in any units");
            for i in 0..K {
                let y = y[i] * columns[i];
                assert!((y - x[i]).abs() <= 1e-10 * norm, "{y} {}", x[i]);
                if K <= 2 {
                    assert_eq!(y, x[i]);
                }
            }
        }
    }

    #[test]
    fn units_do_not_matter() {
        in_other_units::<1>();
        in_other_units::<2>();
        in_other_units::<3>();
        in_other_units::<4>();
        in_other_units::<5>();
        in_other_units::<6>();
    }

    #[test]
    fn pivots_are_scaled() {
        // without scaled pivoting the huge first row wins, and the second unknown loses all its digits
        let big = 2.0_f64.powi(60);
        let a = [[2.0, big, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let x = solve(&a, &[big, 2.0, 3.0]).unwrap();
        assert_eq!(x, [1.0, 1.0, 3.0]);
    }
}
