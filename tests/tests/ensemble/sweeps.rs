//! Sweeps: rows have the bits of single runs, differences the errors of common noise.

use std::time::Duration;

use sve_models::models::{Kubo, Oscillator};
use sve_runtime::ensemble::Sweep;
use sve_runtime::prelude::*;

const PATHS: u64 = 64 * 6 + 10;

fn oscillators() -> [Integrator<Oscillator, Midpoint>; 3] {
    [1.0, 1.5, 0.25].map(|sigma| Integrator::new(Oscillator { sigma }, Midpoint))
}

fn ensemble(
    method: &Integrator<Oscillator, Midpoint>,
) -> Ensemble<'_, Integrator<Oscillator, Midpoint>> {
    Ensemble::new(method)
        .paths(PATHS)
        .seed(3)
        .steps(0.05, 40)
        .record_every(10)
        .observe("q", |_, s| s.q[0])
        .observe("σ", |system, _| system.sigma)
}

/// The motion is m + σx with the same x in all rows, so the variance of a difference of rows is (σ₁ − σ₀)²/σ₀² of that of a row, and that of independent runs would be (σ₁² + σ₀²)/σ₀² of it.
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
    let sweep = ensemble(&table[0]).sweep_starts(&starts).unwrap();
    for (row, start) in sweep.rows().iter().zip(starts) {
        assert_eq!(*row, ensemble(&table[0]).start(start).run().unwrap());
    }
    let difference = &sweep.difference(0, 1).unwrap()["q"];
    assert!(
        difference
            .standard_error()
            .iter()
            .all(|error| *error < 1e-16)
    );
    let mut exact = State::new([-0.5], [0.5]);
    for _ in 0..40 {
        table[0].step(&mut exact, 0.05, &[0.0]).unwrap();
    }
    assert!((difference.mean()[4] - exact.q[0]).abs() < 1e-14);
}

fn kubos() -> [Integrator<Kubo, Midpoint>; 2] {
    [0.5, 0.6].map(|sigma| Integrator::new(Kubo { a: 1.0, sigma }, Midpoint))
}

fn failing(table: &[Integrator<Kubo, Midpoint>]) -> Ensemble<'_, Integrator<Kubo, Midpoint>> {
    Ensemble::new(&table[0])
        .paths(PATHS)
        .seed(3)
        .steps(0.05, 40)
        .record_every(20)
        .start_with(|_, rng| State::new([rng.normal()], [rng.uniform()]))
        .observe("q", |_, s| if s.q[0] > 1.0 { f64::NAN } else { s.q[0] })
        .histogram("q", -1.0..1.0, 4)
        .covariance("q", "q")
}

/// A difference has the paths that have failed in neither row, and shards of a sweep merge into the bits of the whole.
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
    assert!(matches!(twice, Err(EnsembleError::Overlap { .. })));
    let shorter = failing(&table).shard(0, 3).sweep(&table[..1]).unwrap();
    assert!(matches!(
        merged.merge(shorter),
        Err(EnsembleError::OtherTable { rows: 2, others: 1 })
    ));
    assert_eq!(merged, whole);
    let text = serde_json::to_string(&whole).unwrap();
    assert_eq!(serde_json::from_str::<Sweep>(&text).unwrap(), whole);
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
    assert_eq!(
        sweep[1],
        ensemble(&table[1])
            .start(start)
            .antithetic(true)
            .run()
            .unwrap()
    );
}

#[test]
fn bad_tables_are_errors() {
    let table = kubos();
    let error = failing(&table).sweep(&[]).unwrap_err();
    assert!(matches!(error, EnsembleError::EmptyTable), "{error}");
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep.sve");
    let error = failing(&table)
        .checkpoint(&file, Duration::ZERO)
        .sweep(&table);
    assert!(matches!(error, Err(EnsembleError::SweepInOneFile)) && !file.exists());
    let starts = [0.0, 5.0].map(|t| State::at(t, [1.0], [0.0]));
    let error = failing(&table).sweep_starts(&starts).unwrap_err();
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
