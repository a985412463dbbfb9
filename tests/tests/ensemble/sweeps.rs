//! Sweeps: rows have the bits of single runs, differences the errors of common noise.

use std::time::Duration;

use sve_models::assert_matches;
use sve_models::checks::assert_close;
use sve_models::models::{Kubo, Oscillator};
use sve_runtime::ensemble::Sweep;
use sve_runtime::prelude::*;

use crate::runs::{KuboMethod, scratch};

const PATHS: u64 = 64 * 6 + 10;

type Method = Integrator<Oscillator, Midpoint>;

fn oscillators() -> [Method; 3] {
    [1.0, 1.5, 0.25].map(|sigma| Integrator::new(Oscillator { sigma }, Midpoint))
}

fn ensemble(method: &Method) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(PATHS)
        .seed(3)
        .steps(0.05, 40)
        .every(10)
        .observe("q", |_, s| s.q[0])
        .observe("σ", |system, _| system.sigma)
}

/// The motion is m + σx with the same x in all rows, so the variance of a difference of rows is (σ₁
/// − σ₀)²/σ₀² of that of a row, and that of independent runs would be (σ₁² + σ₀²)/σ₀² of it.
#[test]
fn differences_have_the_variance_of_common_noise() {
    let table = oscillators();
    let start = State::new([1.0], [0.0]);
    let sweep = ensemble(&table[0]).start(start).sweep(&table).unwrap();
    let sigma = table.each_ref().map(|method| method.system().sigma);
    for to in 0..3 {
        for from in 0..3 {
            let Some(difference) = sweep.difference(from, to) else {
                assert!(from >= to);
                continue;
            };
            assert!(from < to);
            assert_eq!(difference["σ"].mean()[4], sigma[to] - sigma[from]);
            assert_eq!(difference.counts(), [PATHS; 5]);
            for record in 1..5 {
                let mean = sweep[to]["q"].mean()[record] - sweep[from]["q"].mean()[record];
                assert!((difference["q"].mean()[record] - mean).abs() < 1e-14);
                let factor = (sigma[to] - sigma[from]).powi(2);
                let ratio = difference["q"].variance()[record] / sweep[0]["q"].variance()[record];
                assert!((ratio / factor - 1.0).abs() < 1e-11, "{from} {to} {ratio}");
            }
        }
    }
    assert!(sweep.difference(0, 3).is_none());
}

/// Starts of a linear system: the difference does not depend on the noise.
#[test]
fn rows_have_the_bits_of_single_runs() {
    let table = oscillators();
    let start = State::new([1.0], [0.0]);
    let sweep = ensemble(&table[0])
        .start(start)
        .threads(3)
        .sweep(&table)
        .unwrap();
    for (row, method) in sweep.rows().iter().zip(&table) {
        assert_eq!(*row, ensemble(method).start(start).run().unwrap());
    }
    let starts = [start, State::new([0.5], [0.5])];
    let sweep = ensemble(&table[0]).sweep(&starts).unwrap();
    for (row, start) in sweep.rows().iter().zip(starts) {
        assert_eq!(*row, ensemble(&table[0]).start(start).run().unwrap());
    }
    let difference = &sweep.difference(0, 1).unwrap()["q"];
    let errors = difference.standard_error();
    assert!(errors.iter().all(|error| *error < 1e-16));
    let mut exact = State::new([-0.5], [0.5]);
    for _ in 0..40 {
        table[0].step(&mut exact, 0.05, &[0.0]).unwrap();
    }
    assert!((difference.mean()[4] - exact.q[0]).abs() < 1e-14);
}

fn kubos() -> [KuboMethod; 2] {
    [0.5, 0.6].map(|sigma| Integrator::new(Kubo { a: 1.0, sigma }, Midpoint))
}

fn failing(table: &[KuboMethod]) -> Ensemble<'_, KuboMethod> {
    Ensemble::new(&table[0])
        .paths(PATHS)
        .seed(3)
        .steps(0.05, 40)
        .every(20)
        .start(Starts::each(|_, rng| {
            State::new([rng.normal()], [rng.uniform()])
        }))
        .observe("q", |_, s| if s.q[0] > 1.0 { f64::NAN } else { s.q[0] })
        .histogram("q", -1.0..1.0, 4)
        .covariance("q", "q")
}

/// A difference has the paths that have failed in neither row, and shards of a sweep merge into the
/// bits of the whole.
#[test]
fn failures_and_shards() {
    let table = kubos();
    let whole = failing(&table).sweep(&table).unwrap();
    let counts = whole.difference(0, 1).unwrap().counts();
    for record in 1..3 {
        let rows = [0, 1].map(|row| whole[row].counts()[record]);
        assert!(
            counts[record] < rows[0].min(rows[1]) && counts[record] > 100,
            "{counts:?}"
        );
    }
    assert_eq!(whole[1], failing(&table[1..]).run().unwrap());
    let mut merged = failing(&table).shard(1, 3).sweep(&table).unwrap();
    for index in [2, 0] {
        merged
            .merge(failing(&table).shard(index, 3).sweep(&table).unwrap())
            .unwrap();
    }
    assert_eq!(merged, whole);
    let twice = merged.merge(failing(&table).shard(0, 3).sweep(&table).unwrap());
    assert_matches!(twice, Err(EnsembleError::Overlap { .. }));
    let shorter = failing(&table).shard(0, 3).sweep(&table[..1]).unwrap();
    let shorter = merged.merge(shorter);
    assert_matches!(
        shorter,
        Err(EnsembleError::OtherTable { rows: 2, others: 1 })
    );
    assert_eq!(merged, whole);
    let text = serde_json::to_string(&whole).unwrap();
    assert_eq!(serde_json::from_str::<Sweep>(&text).unwrap(), whole);
}

/// Paths that stop, at other times in each row, with memories, passages and failures.
fn stopping(method: &Method) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(1500)
        .seed(5)
        .steps(0.05, 120)
        .every(30)
        .start(Starts::each(|_, rng| {
            State::new([0.3 * rng.normal()], [0.0])
        }))
        .observe("q", |_, s| s.q[0])
        .observe("time", |_, s| s.t)
        .maximum("highest", |_, s| s.q[0])
        .integral("area", |_, s| s.q[0])
        .bound("q", -4.0..)
        .stop_at("right", |_, s| s.q[0] - 1.0)
        .stop_at("far right", |_, s| s.q[0] - 1.02)
        .first_passage("left", |_, s| s.q[0] + 1.0)
        .histogram("q", -2.0..2.0, 8)
        .quantiles("time", 64)
        .covariance("q", "time")
        .keep_final_states(true)
}

/// The lanes of stopped paths are filled with others in a run alone, and not in a sweep; no bit of
/// a row feels this.
#[test]
fn rows_with_stopped_paths_have_the_bits_of_single_runs() {
    let table = oscillators();
    let of_rows = |threads| stopping(&table[0]).threads(threads).sweep(&table).unwrap();
    let sweep = of_rows(2);
    assert_eq!(sweep, of_rows(1));
    for (row, method) in sweep.rows().iter().zip(&table) {
        let alone = stopping(method).threads(1).run().unwrap();
        assert_eq!(*row, alone);
        for (passages, alone) in row.passages().iter().zip(alone.passages()) {
            assert_eq!(passages, alone);
        }
        assert_eq!(row.passages().len(), 3);
        let finals = |summary: &Summary| -> Vec<(u64, u64, u64)> {
            let states = summary.final_states();
            let bits = states.map(|(path, s)| (path, s.t.to_bits(), s.q[0].to_bits()));
            bits.collect()
        };
        assert_eq!(finals(row), finals(&alone));
    }
    let passed = |row: usize, name: &str| sweep[row].passage(name).unwrap().passed()[4];
    assert!(passed(0, "right") > 300 && passed(0, "right") < 1400);
    assert!(passed(1, "right") > passed(0, "right") && passed(2, "right") < passed(0, "right"));
    assert!(sweep[1].failed() > 10 && sweep[1].passage("left").unwrap().censored()[4] > 10);
    // a difference is that of stopped processes along common paths, of those that failed in neither
    // row
    let difference = sweep.difference(0, 1).unwrap();
    let lasting = |row: usize| -> std::collections::BTreeMap<u64, f64> {
        let states = sweep[row].final_states();
        states.map(|(path, state)| (path, state.t)).collect()
    };
    let [first, second] = [lasting(0), lasting(1)];
    let common = first
        .iter()
        .filter_map(|(path, t)| Some(second.get(path)? - t));
    let common: Vec<f64> = common.collect();
    assert_eq!(difference.counts()[4], common.len() as u64);
    let mean = common.iter().sum::<f64>() / common.len() as f64;
    assert_close(&[difference["time"].mean()[4]], &[mean], 1e-12, "time");

    let starts = [State::new([0.2], [0.0]), State::new([-0.5], [0.5])];
    let sweep = stopping(&table[0]).sweep(&starts).unwrap();
    for (row, start) in sweep.rows().iter().zip(starts) {
        assert_eq!(*row, stopping(&table[0]).start(start).run().unwrap());
    }
    let mut merged = stopping(&table[0]).shard(0, 2).sweep(&starts).unwrap();
    let other = stopping(&table[0]).shard(1, 2).sweep(&starts).unwrap();
    merged.merge(other).unwrap();
    assert_eq!(merged, sweep);
}

#[test]
fn antithetic_pairs_of_rows() {
    let table = oscillators();
    let start = State::new([1.0], [0.0]);
    let sweep = ensemble(&table[0])
        .start(start)
        .antithetic(true)
        .sweep(&table)
        .unwrap();
    assert!(sweep.difference(0, 1).unwrap()["q"].standard_error()[4] < 1e-16);
    let alone = ensemble(&table[1]).start(start).antithetic(true).run();
    assert_eq!(sweep[1], alone.unwrap());
}

#[test]
fn bad_tables_are_errors() {
    let table = kubos();
    assert_matches!(
        failing(&table).sweep(&table[..0]),
        Err(EnsembleError::EmptyTable)
    );
    let file = scratch("sweep.sve");
    let error = failing(&table)
        .checkpoint(&file, Duration::ZERO)
        .sweep(&table);
    assert!(matches!(error, Err(EnsembleError::SweepInOneFile)) && !file.exists());
    let starts = [0.0, 5.0].map(|t| State::at(t, [1.0], [0.0]));
    let error = failing(&table).sweep(&starts).unwrap_err();
    let is_of_row = |error: &EnsembleError| {
        matches!(
            error,
            EnsembleError::SweepTimes {
                row: 1,
                t: 5.0,
                first: 0.0
            }
        )
    };
    assert!(is_of_row(&error), "{error}");
    let error = failing(&table).stop_on_failure(true).sweep(&table);
    assert!(matches!(error, Err(EnsembleError::Failed(_))));
    let error = ensemble(&oscillators()[0])
        .sweep(&oscillators())
        .unwrap_err();
    assert!(error.to_string().contains("start"), "{error}");
}
