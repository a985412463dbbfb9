//! Tables are read with the bits with which they were written.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use sve_models::models::Kubo;
use sve_runtime::prelude::*;
use sve_runtime::{SaveError, StateTable};

type Method = Integrator<Kubo, Midpoint>;
/// Names and values of columns; counts are exact as numbers.
type Columns = Vec<(String, Vec<f64>)>;

fn kubo() -> Method {
    Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint)
}

fn start() -> State<[f64; 1]> {
    State::new([1.0], [1e-300])
}

/// Returns a path of which no other test knows.
fn scratch(name: &str) -> PathBuf {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let process = std::process::id();
    std::env::temp_dir().join(format!("sve-tables-{process}-{number}-{name}"))
}

/// Reads CSV without quotes.
fn csv(bytes: &[u8]) -> Columns {
    let text = std::str::from_utf8(bytes).unwrap();
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',');
    let mut columns: Columns = names.map(|name| (name.to_owned(), Vec::new())).collect();
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), columns.len());
        for ((_, column), field) in columns.iter_mut().zip(fields) {
            column.push(if field.is_empty() {
                f64::NAN
            } else {
                field.parse().unwrap()
            });
        }
    }
    columns
}

/// Reads an array of `NumPy` by its format, version 1.0.
fn npy(bytes: &[u8]) -> Columns {
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((10 + length) % 64, 0);
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    let fields = header.strip_prefix("{'descr': [").unwrap();
    let (fields, rest) = fields
        .split_once("], 'fortran_order': False, 'shape': (")
        .unwrap();
    let rows: usize = rest.split_once(",), }").unwrap().0.parse().unwrap();
    let fields = fields.trim_end_matches("), ").split("), ");
    let fields: Vec<(&str, &str)> = fields
        .map(|field| field.trim_start_matches("('").split_once("', '").unwrap())
        .collect();
    let mut columns: Columns = fields
        .iter()
        .map(|field| (field.0.to_owned(), Vec::new()))
        .collect();
    let mut words = bytes[10 + length..].chunks_exact(8);
    for _ in 0..rows {
        for ((_, kind), (_, column)) in fields.iter().zip(&mut columns) {
            let word = u64::from_le_bytes(words.next().unwrap().try_into().unwrap());
            column.push(match *kind {
                "<f8'" => f64::from_bits(word),
                "<u8'" => word as f64,
                other => panic!("{other}"),
            });
        }
    }
    assert!(words.next().is_none() && words.remainder().is_empty());
    columns
}

fn parquet(bytes: Vec<u8>) -> Columns {
    let path = scratch("read.parquet");
    std::fs::write(&path, bytes).unwrap();
    let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
    let mut columns: Columns = Vec::new();
    for record in reader.get_row_iter(None).unwrap() {
        for (at, (name, field)) in record.unwrap().get_column_iter().enumerate() {
            if columns.len() == at {
                columns.push((name.clone(), Vec::new()));
            }
            columns[at].1.push(match field {
                Field::Double(x) => *x,
                Field::ULong(n) => *n as f64,
                other => panic!("{other:?}"),
            });
        }
    }
    std::fs::remove_file(path).unwrap();
    columns
}

/// Checks all formats of a table, given by their writers.
macro_rules! check_formats {
    ($table:expr, $expected:expr) => {{
        let (mut text, mut array, mut file) = (Vec::new(), Vec::new(), Vec::new());
        $table.write_csv(&mut text).unwrap();
        $table.write_npy(&mut array).unwrap();
        $table.write_parquet(&mut file).unwrap();
        for read in [csv(&text), npy(&array), parquet(file)] {
            check(&read, $expected);
        }
    }};
}

fn check(read: &Columns, expected: &Columns) {
    let bits = |columns: &Columns| {
        let bits = |(name, column): &(String, Vec<f64>)| {
            (
                name.clone(),
                column.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            )
        };
        columns.iter().map(bits).collect::<Vec<_>>()
    };
    assert_eq!(bits(read), bits(expected));
}

fn columns(names: &[&str], rows: impl IntoIterator<Item = Vec<f64>>) -> Columns {
    let mut columns: Columns = names
        .iter()
        .map(|&name| (name.to_owned(), Vec::new()))
        .collect();
    for row in rows {
        assert_eq!(row.len(), columns.len());
        for ((_, column), value) in columns.iter_mut().zip(row) {
            column.push(value);
        }
    }
    columns
}

#[test]
fn trajectories() {
    let method = kubo();
    let path = || {
        method
            .trajectory(start(), 0.1, Wiener::new(1))
            .every(3)
            .until(2.0)
    };
    let states: Vec<_> = path().map(Result::unwrap).collect();
    let rows = states.iter().map(|s| vec![s.t, s.q[0], s.p[0]]);
    let expected = columns(&["t", "q[0]", "p[0]"], rows);
    assert_eq!(expected[0].1, [0.0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.8, 2.0]);
    check_formats!(path().table().unwrap(), &expected);
    // straight into files
    let file = scratch("path");
    path().to_csv(&file).unwrap();
    check(&csv(&std::fs::read(&file).unwrap()), &expected);
    path().to_npy(&file).unwrap();
    check(&npy(&std::fs::read(&file).unwrap()), &expected);
    path().to_parquet(&file).unwrap();
    check(&parquet(std::fs::read(&file).unwrap()), &expected);
    std::fs::remove_file(file).unwrap();
}

#[test]
fn trajectories_that_have_no_table_are_errors() {
    let method = kubo();
    let path = || method.trajectory(start(), 0.1, Wiener::new(1));
    assert!(matches!(path().every(3).table(), Err(SaveError::NoEnd)));
    let file = scratch("none");
    let error = path().at([-1.0]).to_csv(&file).unwrap_err();
    assert!(
        matches!(error, SaveError::Step(StepError::TimeOrder { .. })),
        "{error}"
    );
    assert!(!file.exists());
    let error = path().until(1.0).to_csv(file.join("x.csv")).unwrap_err();
    assert!(matches!(error, SaveError::File(_)), "{error}");
    assert!(error.to_string().contains("x.csv"), "{error}");
    assert_eq!(format!("{error:?}"), error.to_string());
    // adding a column that fails
    let table = StateTable::of(method.system(), path().take(3)).unwrap();
    let failing = |_: &Kubo, _: &State<[f64; 1]>| Err::<f64, _>(StepError::StepSize { h: 0.0 });
    assert!(table.with(method.system(), "x", failing).is_err());
}

fn ensemble(method: &Method) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(150)
        .seed(3)
        .steps(0.05, 40)
        .every(15)
        .start(Starts::each(|_, rng| {
            State::new([rng.normal()], [rng.uniform()])
        }))
        .observe("q", |_, s| if s.q[0] > 2.5 { f64::NAN } else { s.q[0] })
        .keep_final_states(true)
}

#[test]
fn paths_of_ensembles() {
    let method = kubo();
    let ensemble = ensemble(&method);
    let summary = ensemble.run().unwrap();
    assert!(summary.failed() > 0, "a path that fails is one of them");
    let mut rows = Vec::new();
    for path in 0..150 {
        let states = ensemble.replay(path).unwrap().collect::<Vec<_>>();
        for (step, state) in (1..).zip(states) {
            if let (Ok(s), true) = (state, [15, 30, 40].contains(&step)) {
                rows.push(vec![path as f64, s.t, s.q[0], s.p[0]]);
            }
        }
    }
    let table = ensemble.path_table(0..150).unwrap();
    let expected = columns(&["path", "t", "q[0]", "p[0]"], rows);
    // the start, which a replay leaves out
    let at_start = |row: &usize| table.get("t").unwrap()[*row] == 0.0;
    let starts = (0..table.rows()).filter(at_start).count();
    assert_eq!(starts + expected[0].1.len(), table.rows());
    assert_eq!(starts as u64, summary.counts()[0]);
    let mut text = Vec::new();
    table.write_csv(&mut text).unwrap();
    let mut read = csv(&text);
    check_formats!(table, &read);
    let later: Vec<bool> = read[1].1.iter().map(|t| *t > 0.0).collect();
    for (_, column) in &mut read {
        let mut later = later.iter();
        column.retain(|_| *later.next().unwrap());
    }
    check(&read, &expected);
    // a path that stops ends there
    let stopping = self::ensemble(&method).stop_at("axis", |_, s| s.q[0]);
    let ends = stopping.run().unwrap();
    let (path, end) = ends
        .final_states()
        .find(|(_, s)| s.t % 0.1 != 0.0 && s.t < 1.0)
        .unwrap();
    let table = stopping.path_table([path]).unwrap();
    assert_eq!(table.get("t").unwrap().last(), Some(&end.t));
    assert!(matches!(
        ensemble.path_table([150]),
        Err(EnsembleError::Path {
            path: 150,
            paths: 150
        })
    ));
}

#[test]
fn final_states_of_ensembles() {
    let method = kubo();
    let summary = ensemble(&method).run().unwrap();
    let rows = summary
        .final_states()
        .map(|(path, s)| vec![path as f64, s.t, s.q[0], s.p[0]]);
    let expected = columns(&["path", "t", "q[0]", "p[0]"], rows);
    assert_eq!(expected[0].1.len() as u64, 150 - summary.failed());
    let table = summary.final_state_table(method.system());
    check_formats!(table, &expected);
    assert_eq!(table.paths().unwrap().len(), table.rows());
}

#[test]
fn histograms_of_ensembles() {
    let method = kubo();
    let summary = ensemble(&method)
        .histogram("q", -1.0..0.5, 3)
        .histogram("q", -1.0..0.5, Bins::at_end(3))
        .run()
        .unwrap();
    let [always, last] = summary.histograms() else {
        panic!("two histograms")
    };
    assert_eq!(
        (always.times(), last.times()),
        (summary.times(), &summary.times()[3..])
    );
    for histogram in [always, last] {
        let mut rows = Vec::new();
        for (row, &t) in histogram.times().iter().enumerate() {
            let e = histogram.edges();
            let counts = histogram.counts_at(row);
            let below = histogram.below_at(row);
            rows.push(vec![t, f64::NEG_INFINITY, e[0], below as f64]);
            for bin in 0..3 {
                rows.push(vec![t, e[bin], e[bin + 1], counts[bin] as f64]);
            }
            let above = histogram.above_at(row);
            rows.push(vec![t, e[3], f64::INFINITY, above as f64]);
            let sum = below + above + counts.iter().sum::<u64>();
            let record = summary.times().iter().position(|time| *time == t).unwrap();
            assert_eq!(sum, summary.counts()[record]);
        }
        let expected = columns(&["t", "low", "high", "paths"], rows);
        check_formats!(histogram, &expected);
    }
}
