//! Files of summaries are read with the values that were written: CSV, npy, Parquet, serde. Runs
//! continue from a checkpoint.

use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use sve_models::checks::assert_says;
use sve_runtime::prelude::*;

use crate::runs::{KuboMethod, kubo, scratch};

fn ensemble(method: &KuboMethod) -> Ensemble<'_, KuboMethod> {
    Ensemble::new(method)
        .paths(700)
        .seed(3)
        .steps(0.05, 40)
        .every(15)
        .start(Starts::each(|_, rng| {
            State::new([rng.normal()], [rng.uniform()])
        }))
        .observe("q", |_, s| if s.q[0] > 2.5 { f64::NAN } else { s.q[0] })
        .observe("a, \"b\" é", |_, s| {
            if s.t < 0.1 { 1e-300 * s.p[0] } else { -s.p[0] }
        })
        .histogram("q", -2.0..2.0, 5)
        .keep_final_states(true)
}

/// The columns of the table, as the summary has them; a variance of one path is NaN.
fn table(summary: &Summary) -> Vec<(String, Vec<f64>)> {
    let counts = summary.counts().iter().map(|&n| n as f64).collect();
    let mut table = vec![
        ("t".to_owned(), summary.times().to_vec()),
        ("paths".to_owned(), counts),
    ];
    for s in summary.statistics() {
        let mut add = |what: &str, values: &[f64]| {
            table.push((format!("{}_{what}", s.name()), values.to_vec()));
        };
        add("mean", s.mean());
        add("variance", &s.variance());
        add("standard_error", &s.standard_error());
        add("min", s.min());
        add("max", s.max());
    }
    table
}

pub(crate) fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

/// A summary with several paths, and one of a single path, which has no variance.
fn summaries() -> [Summary; 2] {
    let method = kubo();
    let one = ensemble(&method).paths(1).run().unwrap();
    assert!(one["q"].variance()[0].is_nan());
    [ensemble(&method).run().unwrap(), one]
}

#[test]
fn csv() {
    for summary in summaries() {
        let mut bytes = Vec::new();
        summary.write_csv(&mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let mut lines = text.lines();
        let table = table(&summary);
        let header =
            "t,paths,q_mean,q_variance,q_standard_error,q_min,q_max,\"a, \"\"b\"\" é_mean\",";
        assert!(lines.next().unwrap().starts_with(header), "{text}");
        for row in 0..summary.times().len() {
            let fields: Vec<_> = lines.next().unwrap().split(',').collect();
            assert_eq!(fields.len(), table.len());
            for (field, (name, values)) in fields.iter().zip(&table) {
                let value = if field.is_empty() {
                    f64::NAN
                } else {
                    field.parse().unwrap()
                };
                assert!(same(value, values[row]), "{name}: {field}");
            }
        }
        assert_eq!(lines.next(), None);
    }
}

#[test]
fn npy() {
    for summary in summaries() {
        let mut bytes = Vec::new();
        summary.write_npy(&mut bytes).unwrap();
        // a name beyond ASCII makes it version 3
        assert_eq!(&bytes[..8], b"\x93NUMPY\x03\x00");
        let length = u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
        assert_eq!((12 + length) % 64, 0);
        let header = std::str::from_utf8(&bytes[12..12 + length]).unwrap();
        let start = "{'descr': [('t', '<f8'), ('paths', '<u8'), ('q_mean', '<f8'), ";
        assert!(header.starts_with(start), "{header}");
        let end = "('a, \"b\" é_max', '<f8'), ], 'fortran_order': False, 'shape': (4,), }";
        assert_says(header, &[end]);
        assert!(header.ends_with('\n'));
        let table = table(&summary);
        let mut words = bytes[12 + length..].chunks_exact(8);
        for row in 0..4 {
            for (name, values) in &table {
                let word = u64::from_le_bytes(words.next().unwrap().try_into().unwrap());
                if name == "paths" {
                    assert_eq!(word, summary.counts()[row]);
                } else {
                    assert!(same(f64::from_bits(word), values[row]), "{name}");
                }
            }
        }
        assert!(words.next().is_none() && words.remainder().is_empty());
    }
    let method = kubo();
    let plain = ensemble_of_one_name(&method);
    let mut bytes = Vec::new();
    plain.write_npy(&mut bytes).unwrap();
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((10 + length) % 64, 0);
    assert_eq!(bytes.len(), 10 + length + 2 * 7 * 8);
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    assert!(header.contains(r"('it\'s_mean', '<f8'), "), "{header}");
    assert!(header.ends_with('\n'));
}

fn ensemble_of_one_name(method: &KuboMethod) -> Summary {
    let ensemble = Ensemble::new(method).paths(20).steps(0.1, 3);
    let ensemble = ensemble.start(State::new([1.0], [0.0]));
    ensemble.observe("it's", |_, s| s.q[0]).run().unwrap()
}

#[test]
fn parquet_files() {
    for summary in summaries() {
        let path = scratch("table.parquet");
        summary.to_parquet(&path).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let table = table(&summary);
        let mut rows = 0;
        for (row, record) in reader.get_row_iter(None).unwrap().enumerate() {
            let record = record.unwrap();
            let columns: Vec<_> = record.get_column_iter().collect();
            assert_eq!(columns.len(), table.len());
            for ((name, field), (expected, values)) in columns.into_iter().zip(&table) {
                assert_eq!(name, expected);
                match field {
                    Field::Double(x) => assert!(same(*x, values[row]), "{name}: {x}"),
                    Field::ULong(n) => {
                        assert_eq!((*n, name.as_str()), (summary.counts()[row], "paths"));
                    }
                    other => panic!("{other:?}"),
                }
            }
            rows += 1;
        }
        assert_eq!(rows, 4);
        std::fs::remove_file(path).unwrap();
    }
}

#[test]
fn serde_of_summaries() {
    for summary in summaries() {
        let text = serde_json::to_string(&summary).unwrap();
        let back: Summary = serde_json::from_str(&text).unwrap();
        // serde_json's feature `float_roundtrip` is on
        assert_eq!(back, summary);
        assert_eq!(back.failures(), summary.failures());
        // parts that do not fit together are an error, not a panic
        for (old, new) in [
            ("\"counts\":[", "\"counts\":[1,"),
            ("\"coordinates\":1", "\"coordinates\":2"),
            ("\"bins\":5", "\"bins\":18446744073709551615"),
            ("\"bins\":5", "\"bins\":0"),
            ("\"results\":[{", "\"results\":[],\"others\":[{"),
            ("\"first\":0", "\"first\":18446744073709551615"),
            ("\"level\":", "\"level\":99"),
            ("\"blocks\":", "\"blocks\":9"),
            ("\"final_paths\":[", "\"final_paths\":[7777777,"),
        ] {
            let bent = text.replacen(old, new, 1);
            assert_ne!(bent, text, "{old}");
            assert!(serde_json::from_str::<Summary>(&bent).is_err(), "{new}");
        }
    }
}

#[test]
fn serde_of_states_and_errors() {
    let state = State::at(0.1, [1.0, f64::INFINITY], [-0.0, 1e-320]);
    let text = serde_json::to_string(&state).unwrap();
    assert_eq!(text, r#"{"t":0.1,"q":[1.0,"inf"],"p":[-0.0,1e-320]}"#);
    let back: State<[f64; 2]> = serde_json::from_str(&text).unwrap();
    assert_eq!(back, state);
    assert!(serde_json::from_str::<State<[f64; 3]>>(&text).is_err());
    assert!(serde_json::from_str::<State<[f64; 1]>>(&text).is_err());

    let h = f64::NAN;
    let text = serde_json::to_string(&StepError::StepSize { h }).unwrap();
    assert_eq!(text, r#"{"StepSize":{"h":"NaN"}}"#);
    let back: StepError = serde_json::from_str(&text).unwrap();
    assert!(matches!(back, StepError::StepSize { h } if h.is_nan()));
}

#[test]
fn a_stopped_run_continues_with_the_same_bits() {
    let method = kubo();
    let whole = ensemble(&method).run().unwrap();
    let path = scratch("continued.sve");
    for (shard, of) in [(0, 1), (1, 3)] {
        let whole = if of == 1 {
            whole.clone()
        } else {
            ensemble(&method).shard(shard, of).run().unwrap()
        };
        let mut runs = 0;
        loop {
            let budget = Mutex::new(2);
            let stop = || {
                let mut left = budget.lock().unwrap();
                *left -= 1;
                *left < 0
            };
            let part = ensemble(&method)
                .shard(shard, of)
                .checkpoint(&path, Duration::ZERO)
                .resume(true)
                .stop_when(stop)
                .run()
                .unwrap();
            runs += 1;
            if part.paths() == whole.paths() {
                assert_eq!(part, whole);
                break;
            }
            assert!(runs < 20);
        }
        assert!(runs > 1);
        std::fs::remove_file(&path).unwrap();
    }
}

#[test]
fn a_run_that_was_killed_continues() {
    let method = kubo();
    let path = scratch("killed.sve");
    let ensemble = |panics: bool| {
        ensemble(&method)
            .observe("end", move |_, s| {
                assert!(!(panics && s.t == 2.0 && s.p[0] > 2.2), "as if killed");
                s.q[0]
            })
            .checkpoint(&path, Duration::ZERO)
            .resume(true)
    };
    let killed = std::panic::AssertUnwindSafe(|| ensemble(true).threads(1).run());
    assert!(std::panic::catch_unwind(killed).is_err());
    let continued = ensemble(false).run().unwrap();
    let _ = std::fs::remove_file(&path);
    assert_eq!(continued, ensemble(false).run().unwrap());
    std::fs::remove_file(&path).unwrap();
}

type FileWriter = fn(&Summary, &Path) -> std::io::Result<()>;

/// The writers of a summary, with the names of their formats.
fn writers() -> [(&'static str, FileWriter); 3] {
    [
        ("x.csv", |summary, path| summary.to_csv(path)),
        ("x.npy", |summary, path| summary.to_npy(path)),
        ("x.parquet", |summary, path| summary.to_parquet(path)),
    ]
}

#[test]
fn files_that_cannot_be_written_are_errors_with_their_path() {
    let summary = ensemble_of_one_name(&kubo());
    let folder = scratch("unwritable");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("file"), b"").unwrap();
    for (name, write) in writers() {
        let mut paths = vec![folder.join("file").join(name), folder.join("no").join(name)];
        if cfg!(target_os = "linux") {
            // a full disk; a folder that not even an administrator may write to
            paths.extend([PathBuf::from("/dev/full"), Path::new("/proc").join(name)]);
        }
        for path in paths {
            let error = write(&summary, &path).unwrap_err();
            assert_says(error, &[path.to_str().unwrap()]);
        }
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "{name}");
    }
    let records = [sve_runtime::study::Record::default()];
    let path = folder.join("file/x.csv");
    let error = sve_runtime::study::to_csv(&path, &records).unwrap_err();
    assert_says(error, &[path.to_str().unwrap()]);
    sve_runtime::study::to_csv(folder.join("x.csv"), &records).unwrap();
    let read = std::fs::File::open(folder.join("x.csv")).unwrap();
    let read = sve_runtime::study::read_csv(std::io::BufReader::new(read));
    assert_eq!(read.unwrap(), records);
    std::fs::remove_dir_all(folder).unwrap();
}

/// A writer that fails after this number of bytes.
struct Room(usize);

impl std::io::Write for Room {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let taken = bytes.len().min(self.0);
        self.0 -= taken;
        if taken == 0 && !bytes.is_empty() {
            return Err(std::io::ErrorKind::StorageFull.into());
        }
        Ok(taken)
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

type Writer<W> = fn(&Summary, W) -> std::io::Result<()>;

/// A file that could not be written completely is an error.
#[test]
fn writers_that_end_early_are_errors() {
    let summary = ensemble_of_one_name(&kubo());
    let writers: [Writer<BufWriter<Room>>; 3] = [
        |s, to| s.write_csv(to),
        |s, to| s.write_npy(to),
        |s, to| s.write_parquet(to),
    ];
    let mut whole = [Vec::new(), Vec::new(), Vec::new()];
    summary.write_csv(&mut whole[0]).unwrap();
    summary.write_npy(&mut whole[1]).unwrap();
    summary.write_parquet(&mut whole[2]).unwrap();
    for (write, whole) in writers.into_iter().zip(whole) {
        for room in [0, 1, whole.len() / 2, whole.len() - 1] {
            let error = write(&summary, BufWriter::new(Room(room))).unwrap_err();
            assert_eq!(error.kind(), std::io::ErrorKind::StorageFull, "{room}");
        }
        write(&summary, BufWriter::new(Room(whole.len()))).unwrap();
    }
    let records = vec![sve_runtime::study::Record::default(); 3];
    let file = BufWriter::new(Room(200));
    assert!(sve_runtime::study::write_csv(file, &records).is_err());
    // a pipe that nobody reads
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let error = summary.write_csv(BufWriter::new(writer)).unwrap_err();
    assert_eq!(error.kind(), std::io::ErrorKind::BrokenPipe);
}
