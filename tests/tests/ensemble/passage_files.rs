//! Files of first passages are read with the values that were written: CSV, npy, Parquet.

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use sve_runtime::ensemble::Passages;
use sve_runtime::prelude::*;

use crate::files::same;
use crate::runs::{free, scratch};

/// Passages of 300 free particles that pass, fail, are stopped elsewhere, or go on: velocities from
/// −1 to 1; the slow ones to the right fail.
fn passages() -> Summary {
    let method = free();
    Ensemble::new(&method)
        .paths(300)
        .steps(0.1, 40)
        .every(10)
        .start(Starts::each(|path, _| {
            State::new([0.0], [path as f64 / 150.0 - 1.0])
        }))
        .observe("age", |_, s| if s.p[0].abs() < 0.2 { s.t } else { 0.0 })
        .bound("age", ..=1.5)
        .stop_at("left", |_, s| s.q[0] + 1.0)
        .first_passage("right", |_, s| s.q[0] - 0.5)
        .run()
        .unwrap()
}

/// The columns of the passages as the functions of [`Passages`] have them.
fn columns(passages: &Passages) -> [Vec<f64>; 6] {
    let counts = |counts: Vec<u64>| counts.into_iter().map(|n| n as f64).collect();
    let known = |values: Vec<Option<f64>>| values.into_iter().flatten().collect();
    [
        passages.times().to_vec(),
        counts(passages.passed()),
        counts(passages.censored()),
        counts(passages.at_risk()),
        known(passages.survival()),
        known(passages.survival_error()),
    ]
}

const COLUMNS: [&str; 6] = [
    "t",
    "passed",
    "censored",
    "at_risk",
    "survival",
    "survival_standard_error",
];

#[test]
fn passages_are_written_in_every_format() {
    let summary = passages();
    let [left, right] = ["left", "right"].map(|name| summary.passage(name).unwrap());
    assert!(right.passed()[4] > 50 && right.censored()[4] > 50 && right.at_risk()[4] > 3);
    for passages in [left, right] {
        let expected = columns(passages);
        assert_eq!(expected.each_ref().map(Vec::len), [5; 6]);
        let mut bytes = Vec::new();
        passages.write_csv(&mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next().unwrap(), COLUMNS.join(","));
        for row in 0..5 {
            let line = lines.next().unwrap().split(',');
            let fields: Vec<f64> = line.map(|field| field.parse().unwrap()).collect();
            assert_eq!(fields, expected.each_ref().map(|column| column[row]));
        }
        assert_eq!(lines.next(), None);

        let mut bytes = Vec::new();
        passages.write_npy(&mut bytes).unwrap();
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        assert!(
            header.contains("('at_risk', '<u8'), ('survival', '<f8'), "),
            "{header}"
        );
        let words = bytes[10 + length..].chunks_exact(8);
        for (at, word) in words.enumerate() {
            let (row, column) = (at / 6, at % 6);
            let word = u64::from_le_bytes(word.try_into().unwrap());
            let is_count = (1..4).contains(&column);
            let value = if is_count {
                word as f64
            } else {
                f64::from_bits(word)
            };
            assert!(
                same(value, expected[column][row]),
                "{} {row}",
                COLUMNS[column]
            );
        }

        let path = scratch("passages.parquet");
        passages.to_parquet(&path).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        for (row, record) in reader.get_row_iter(None).unwrap().enumerate() {
            for (column, (name, field)) in record.unwrap().get_column_iter().enumerate() {
                assert_eq!(name, COLUMNS[column]);
                let value = match field {
                    Field::Double(x) => *x,
                    Field::ULong(n) => *n as f64,
                    other => panic!("{other:?}"),
                };
                assert!(same(value, expected[column][row]), "{name} {row}");
            }
        }
        std::fs::remove_file(path).unwrap();
    }
}
