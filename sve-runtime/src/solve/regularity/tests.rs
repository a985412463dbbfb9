//! Regularity within bounds: determinants by elimination, matrices within bounds, signs along a
//! path.

use super::{contains_path, is_regular_within};
use crate::solve::banded::Banded;
use crate::solve::dense::{self, tests::Random};
use crate::solve::diagonal::Diagonal;

/// Returns the determinant of a small matrix, by elimination with partial pivoting.
fn determinant<const K: usize>(mut a: [[f64; K]; K]) -> f64 {
    let mut product = 1.0;
    for k in 0..K {
        let pivot = (k..K).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()));
        let pivot = pivot.unwrap_or(k);
        if pivot != k {
            a.swap(k, pivot);
            product = -product;
        }
        product *= a[k][k];
        for i in k + 1..K {
            let factor = a[i][k] / a[k][k];
            for j in k..K {
                a[i][j] -= factor * a[k][j];
            }
        }
    }
    product
}

/// Checks that no matrix within the radii of an accepted one has a determinant of the other sign.
/// Returns the numbers of refused and accepted matrices.
fn samples<const K: usize>(random: &mut Random) -> [u32; 2] {
    let mut counts = [0; 2];
    for _ in 0..400 {
        let middle: [[f64; K]; K] =
            core::array::from_fn(|_| core::array::from_fn(|_| random.next()));
        let size = 0.4 * random.next().abs();
        let radius = middle.map(|row| row.map(|x| size * (x.abs() + 0.1)));
        let accepted = is_regular_within(&middle, &radius);
        counts[usize::from(accepted)] += 1;
        if !accepted {
            continue;
        }
        let sign = determinant(middle).signum();
        for _ in 0..50 {
            let corner = core::array::from_fn(|i| {
                core::array::from_fn(|j| middle[i][j] + radius[i][j] * random.next().signum())
            });
            assert!(determinant::<K>(corner) * sign > 0.0, "{middle:?}");
        }
    }
    counts
}

#[test]
fn accepted_neighbourhoods_contain_no_singular_matrix() {
    let mut random = Random(11);
    let counts = [
        samples::<1>(&mut random),
        samples::<2>(&mut random),
        samples::<3>(&mut random),
        samples::<4>(&mut random),
    ];
    for [refused, accepted] in counts {
        assert!(refused > 10 && accepted > 50, "{counts:?}");
    }
}

/// Checks that solutions with matrices within the radii and right-hand sides within the defects of
/// an accepted box are in the box. Returns the numbers of refused and accepted boxes.
fn boxes<const K: usize>(random: &mut Random) -> [u32; 2] {
    let mut counts = [0; 2];
    for _ in 0..400 {
        let middle: [[f64; K]; K] = core::array::from_fn(|i| {
            core::array::from_fn(|j| random.next() + if i == j { 2.0 } else { 0.0 })
        });
        let size = 0.4 * random.next().abs();
        let radius = middle.map(|row| row.map(|x| size * (x.abs() + 0.1)));
        let defects: [f64; K] = core::array::from_fn(|_| random.next().abs());
        let reach = [2.0 * random.next().abs(); K];
        let accepted = contains_path(&middle, &radius, &defects, &reach);
        counts[usize::from(accepted)] += 1;
        if !accepted {
            continue;
        }
        for _ in 0..50 {
            let matrix: [[f64; K]; K] = core::array::from_fn(|i| {
                core::array::from_fn(|j| middle[i][j] + radius[i][j] * random.next().signum())
            });
            let rhs: [f64; K] = core::array::from_fn(|i| defects[i] * random.next().signum());
            let solution = dense::solve(&matrix, &rhs).expect("a regular matrix");
            for i in 0..K {
                assert!(solution[i].abs() <= reach[i], "{middle:?} {radius:?}");
            }
        }
    }
    counts
}

#[test]
fn accepted_boxes_contain_all_solutions() {
    let mut random = Random(17);
    let counts = [
        boxes::<1>(&mut random),
        boxes::<2>(&mut random),
        boxes::<3>(&mut random),
        boxes::<5>(&mut random),
    ];
    for [refused, accepted] in counts {
        assert!(refused > 40 && accepted > 10, "{counts:?}");
    }
}

#[test]
fn boxes_that_are_just_too_small_or_not_numbers_are_refused() {
    let middle = [[2.0, 0.0], [0.0, 4.0]];
    let none = [[0.0; 2]; 2];
    // The bound is 1/0.95 of the solution.
    assert!(contains_path(&middle, &none, &[1.0, 1.0], &[0.53, 0.27]));
    assert!(!contains_path(&middle, &none, &[1.0, 1.0], &[0.52, 0.27]));
    assert!(!contains_path(&middle, &none, &[1.0, 1.0], &[0.53, 0.26]));
    assert!(contains_path(&middle, &none, &[0.0; 2], &[0.0; 2]));
    assert!(!contains_path(&middle, &none, &[f64::NAN, 0.0], &[1.0; 2]));
    assert!(!contains_path(&middle, &none, &[1.0; 2], &[f64::NAN; 2]));
    assert!(!contains_path(&[[1.0]], &[[0.96]], &[0.0], &[1.0]));
    assert!(!contains_path(&[[f64::NAN]], &[[0.0]], &[0.0], &[1.0]));
    assert!(!contains_path(
        &[[0.0; 3]; 3],
        &[[0.0; 3]; 3],
        &[0.0; 3],
        &[1.0; 3]
    ));
}

#[test]
fn boxes_of_bands_are_those_of_the_same_matrix_written_in_full() {
    let mut random = Random(23);
    let mut counts = [0; 2];
    for _ in 0..1000 {
        let cosines: [f64; 5] = core::array::from_fn(|_| random.next());
        let rows: [[f64; 3]; 6] = core::array::from_fn(|i| match i {
            0 => [2.0, cosines[0], 0.0],
            5 => [cosines[4], 2.0, 0.0],
            _ => [cosines[i - 1], 2.0, cosines[i]],
        });
        let size = 0.3 * random.next().abs();
        let radii = rows.map(|row| row.map(|x| size * x.abs()));
        let full = |rows: &[[f64; 3]; 6]| -> [[f64; 6]; 6] {
            let mut full = [[0.0; 6]; 6];
            for i in 0..6_usize {
                for j in 0..3 {
                    let column = i.saturating_sub(1) + j;
                    if column < 6 {
                        full[i][column] = rows[i][j];
                    }
                }
            }
            full
        };
        let defects: [f64; 6] = core::array::from_fn(|_| random.next().abs());
        let reach = [3.0 * random.next().abs(); 6];
        let banded = contains_path(&Banded::<6, 1, 3>(rows), &radii, &defects, &reach);
        assert_eq!(
            banded,
            contains_path(&full(&rows), &full(&radii), &defects, &reach)
        );
        counts[usize::from(banded)] += 1;
    }
    assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
}

#[test]
fn the_test_is_sharp_for_diagonal_matrices_in_any_units() {
    let middle: [[f64; 3]; 3] = [[2e150, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 1e-150]];
    let scaled = |by: f64| middle.map(|row| row.map(|x| by * x.abs()));
    assert!(is_regular_within(&middle, &scaled(0.94)));
    assert!(!is_regular_within(&middle, &scaled(0.96)));
}

#[test]
fn diagonal_midpoints_are_accepted_as_the_same_matrix_written_in_full() {
    let mut random = Random(5);
    let mut counts = [0; 2];
    for _ in 0..2000 {
        let diagonal: [f64; 3] = core::array::from_fn(|_| random.next() * random.unit());
        let full: [[f64; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| if i == j { diagonal[i] } else { 0.0 })
        });
        let size = random.next().abs();
        let radius =
            diagonal.map(|x| core::array::from_fn(|_| size * x.abs() * random.next().abs()));
        let accepted = is_regular_within(&Diagonal(diagonal.map(|x| [x])), &radius);
        assert_eq!(accepted, is_regular_within(&full, &radius));
        counts[usize::from(accepted)] += 1;
    }
    assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
    assert!(!is_regular_within(&Diagonal([[0.0]; 3]), &[[0.0; 3]; 3]));
    assert!(!is_regular_within(
        &Diagonal([[1.0]; 3]),
        &[[f64::NAN; 3]; 3]
    ));
}

#[test]
fn singular_matrices_and_nan_are_refused() {
    assert!(!is_regular_within(&[[f64::NAN]], &[[0.0]]));
    assert!(!is_regular_within(&[[1.0]], &[[f64::NAN]]));
    assert!(!is_regular_within(
        &[[1.0, 0.0], [0.0, 0.0]],
        &[[0.0; 2]; 2]
    ));
    assert!(!is_regular_within(&[[0.0; 3]; 3], &[[0.0; 3]; 3]));
}
