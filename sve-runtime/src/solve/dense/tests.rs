//! Dense solves: random systems, singular matrices, units, the sign of the determinant.

use super::{factored, largest_magnitude, pivot_row, solve, solve_with_sign};

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

/// Returns the componentwise backward error of a solution, which for a backward stable method is a
/// small multiple of ε. Cramer's rule is only forward stable: its backward error grows with the
/// condition number.
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

/// Returns the determinant by expansion along rows. Its sign is right for random matrices.
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

fn determinant_signs<const K: usize>() {
    let mut random = Random(300 + K as u64);
    for _ in 0..500 {
        let a = random.matrix::<K>();
        let expected = determinant(&a, 0, 0);
        let (_, sign) = solve_with_sign(&a, &[1.0; K]).unwrap();
        assert_eq!(sign.is_negative(), expected < 0.0, "{a:?}");
    }
}

#[test]
fn the_sign_is_that_of_the_determinant() {
    determinant_signs::<1>();
    determinant_signs::<2>();
    determinant_signs::<3>();
    determinant_signs::<4>();
    determinant_signs::<5>();
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
        // The rounding error of the combined row grows with the condition number of the other rows.
        // A bound that detected every such matrix would refuse regular matrices.
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

fn scaled<const K: usize>(a: &[[f64; K]; K], rows: &[f64; K], columns: &[f64; K]) -> [[f64; K]; K] {
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
        // With a dominant diagonal, the pivots are good in any units of the unknowns.
        let mut a = random.matrix::<K>();
        for i in 0..K {
            for j in 0..K {
                // With zeros, a row without the unknown in the largest unit has a small scale and
                // is preferred as pivot row.
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

        // Other units of the equations give the same pivots, so the same bits.
        assert_eq!(solve(&scaled(&a, &rows, &[1.0; K]), &rhs), Some(x));

        // Other units of the unknowns give other pivots, which are not the best in each column: a
        // few digits are lost.
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
    // Without scaling, the huge first row would be the pivot row, and the second unknown would lose
    // all its digits.
    let big = 2.0_f64.powi(60);
    let a = [[2.0, big, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let x = solve(&a, &[big, 2.0, 3.0]).unwrap();
    assert_eq!(x, [1.0, 1.0, 3.0]);
}

/// Solves by elimination with scaled partial pivoting that carries the right-hand side along.
fn eliminated<const K: usize>(mut a: [[f64; K]; K], mut b: [f64; K]) -> [f64; K] {
    let mut scale = a.map(|row| largest_magnitude(&row));
    for k in 0..K {
        let pivot = pivot_row(&a, &scale, k);
        a.swap(k, pivot);
        b.swap(k, pivot);
        scale.swap(k, pivot);
        for i in k + 1..K {
            let factor = a[i][k] / a[k][k];
            for j in k + 1..K {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..K).rev() {
        for j in k + 1..K {
            b[k] -= a[k][j] * b[j];
        }
        b[k] /= a[k][k];
    }
    b
}

#[test]
fn factors_give_the_bits_of_elimination() {
    let mut random = Random(9);
    for _ in 0..200 {
        let a: [[f64; 5]; 5] = core::array::from_fn(|_| core::array::from_fn(|_| random.next()));
        let factors = factored(&a).expect("a regular matrix");
        for _ in 0..3 {
            let b: [f64; 5] = core::array::from_fn(|_| random.next());
            let (x, sign) = solve_with_sign(&a, &b).expect("a regular matrix");
            assert_eq!(factors.solve(&b), eliminated(a, b));
            assert_eq!(x, eliminated(a, b));
            assert_eq!(factors.sign().is_negative(), sign.is_negative());
        }
    }
}

#[test]
fn singular_matrices_have_no_factors() {
    let a = [[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [1.0, 1.0, 1.0]];
    assert!(factored(&a).is_none());
}
