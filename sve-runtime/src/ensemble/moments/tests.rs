//! The moments of a block do not depend on how its paths are divided.

use super::{Column, LANES, Lane, Mask};

/// Adds values in tiles with the given masks. Returns the column and the count.
fn column(values: &[f64], masks: &[Mask]) -> (Column, u64) {
    let mut column = Column::new(1);
    let (mut count, mut values) = (0, values.iter());
    for &mask in masks.iter().cycle() {
        // the values of the other lanes must not matter
        let mut tile: Lane = [f64::NAN; LANES];
        let mut counted = 0;
        for lane in (0..LANES).filter(|lane| mask >> lane & 1 == 1) {
            if let Some(&value) = values.next() {
                tile[lane] = value;
                counted |= 1 << lane;
            }
        }
        column.add(0, count, &tile, counted);
        count += u64::from(counted.count_ones());
        if values.len() == 0 {
            break;
        }
    }
    (column, count)
}

#[test]
fn agree_with_two_passes_far_from_zero() {
    // a mean 10⁸ times the deviations: sums of squares alone would have no digit left
    let values: Vec<f64> = (0..500)
        .map(|i| 1e8 + f64::from(i * 37 % 101) / 64.0)
        .collect();
    let mean = values.iter().map(|x| x - 1e8).sum::<f64>() / 500.0;
    let squares = values.iter().map(|x| (x - 1e8 - mean).powi(2)).sum::<f64>();
    for masks in [&[0xffff][..], &[0x8001, 0, 0x00f0], &[1, 0xffff]] {
        let (column, count) = column(&values, masks);
        assert_eq!(count, 500);
        assert!((column.mean[0] - 1e8 - mean).abs() < 1e-7, "{masks:?}");
        assert!(
            (column.squares[0] / squares - 1.0).abs() < 1e-9,
            "{masks:?}"
        );
        assert_eq!((column.min[0], column.max[0]), (1e8, 1e8 + 100.0 / 64.0));
    }
}

#[test]
fn of_columns_that_are_merged() {
    let values: Vec<f64> = (0..300)
        .map(|i| f64::from(i * 37 % 101).sqrt() - 4.0)
        .collect();
    let (whole, _) = column(&values, &[0xffff]);
    for cut in [0, 1, 17, 150, 300] {
        let (mut left, a) = column(&values[..cut], &[0xffff]);
        let (right, b) = column(&values[cut..], &[0xffff]);
        left.merge(&[a], &right, &[b]);
        assert!((left.mean[0] - whole.mean[0]).abs() < 1e-14, "{cut}");
        assert!((left.squares[0] / whole.squares[0] - 1.0).abs() < 1e-14);
        assert_eq!((left.min[0], left.max[0]), (whole.min[0], whole.max[0]));
    }
}

#[test]
fn that_overflow_are_infinite_and_not_nan() {
    let values: Vec<f64> = (0..64)
        .map(|i| if i % 32 < 16 { 1.7e308 } else { -1.7e308 })
        .collect();
    let (column, _) = column(&values, &[0xffff]);
    assert!(column.mean[0].abs() < 1e296, "{}", column.mean[0]);
    assert_eq!(column.squares[0], f64::INFINITY);
    assert_eq!((column.min[0], column.max[0]), (-1.7e308, 1.7e308));
}
