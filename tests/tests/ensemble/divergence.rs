//! Warnings about motions without physical meaning: diverging observables, paths out of bounds,
//! means dominated by one path.

use sve_models::checks::assert_says;
use sve_models::models::{Bath, Pendulum};
use sve_runtime::ensemble::{Cause, Warning};
use sve_runtime::prelude::*;

use crate::runs::oscillator;

/// An oscillator under noise. Beyond ωh = 2 its explicit step is unstable: the energy grows by 25
/// orders and stays finite.
type Stiff = Integrator<Bath, Endpoint>;

fn stiff(omega: f64) -> Stiff {
    let (nu, sigma) = (0.0, 1.0);
    Integrator::new(Bath { omega, nu, sigma }, Endpoint)
}

fn ensemble(method: &Stiff, every: u64) -> Ensemble<'_, Stiff> {
    Ensemble::new(method)
        .paths(200)
        .steps(0.1, 200)
        .every(every)
        .start(State::new([1.0], [0.0]))
        .observe("energy", Mechanics::hamiltonian)
        .observe("one", |_, _| 1.0)
}

#[test]
fn is_reported_for_energies_that_grow_and_for_no_others() {
    // recorded often, and at the ends alone
    for every in [10, 200] {
        let unstable = stiff(20.05);
        let summary = ensemble(&unstable, every).run().unwrap();
        assert_eq!(summary.failed(), 0);
        let end = *summary["energy"].max().last().unwrap();
        assert!((1e20..1e30).contains(&end), "{end:e}");
        match &summary.warnings()[..] {
            [
                Warning::Diverges {
                    name, to, after, ..
                },
            ] => {
                assert_eq!((name.as_str(), *to, *after), ("energy", 20.0, end));
            }
            other => panic!("{other:?}"),
        }
        assert_says(summary, &["`energy` diverges"]);
        let stable = stiff(19.0);
        let summary = ensemble(&stable, every).run().unwrap();
        assert_eq!(summary.warnings(), []);
    }
}

/// Motions that grow like a power of time, rotate, or rest.
#[test]
fn is_not_reported_for_motions_that_do_not() {
    let oscillator = oscillator(Midpoint);
    let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    for every in [1, 50, 1000] {
        let summary = Ensemble::new(&oscillator)
            .paths(200)
            .steps(0.05, 1000)
            .every(every)
            .start(State::new([0.0], [0.0]))
            .observe("energy", Mechanics::hamiltonian)
            .observe("t⁴", |_, s| s.t.powi(4))
            .observe("sine", |_, s| (s.t * std::f64::consts::TAU).sin())
            .run()
            .unwrap();
        assert_eq!(summary.warnings(), [], "{every}");
        let summary = Ensemble::new(&pendulum)
            .paths(2)
            .steps(0.05, 1000)
            .every(every)
            .start(State::new([0.0], [0.0]))
            .observe("q", |_, s| s.q[0])
            .run()
            .unwrap();
        assert_eq!(summary.warnings(), [], "{every}");
    }
}

#[test]
fn bounds_make_paths_fail_that_leave_them() {
    let (method, every) = (stiff(20.05), 10);
    let free = ensemble(&method, every).run().unwrap();
    let bounded = ensemble(&method, every).bound("energy", ..=1e6);
    let summary = bounded.run().unwrap();
    assert_eq!(summary.failed(), 200);
    for failure in summary.failures() {
        let Cause::OutOfBound {
            name,
            value,
            low,
            high,
        } = &failure.cause
        else {
            panic!("{failure}");
        };
        assert_eq!(
            (name.as_str(), *low, *high),
            ("energy", f64::NEG_INFINITY, 1e6)
        );
        assert!(*value > 1e6 && failure.step % 10 == 0);
        let last = bounded.replay(failure.path).unwrap().last().unwrap();
        assert_eq!(last, Err(failure.clone()));
    }
    let largest = summary["energy"].max().iter().copied().fold(0.0, f64::max);
    assert!(largest <= 1e6 && free["energy"].max()[20] > 1e6);
    assert!(summary.to_string().contains("no path is left"), "{summary}");
    assert!(!summary.to_string().contains("NaN"), "{summary}");
    // both bounds are inside
    let inside = ensemble(&method, every)
        .bound("one", 1.0..1.0)
        .run()
        .unwrap();
    assert_eq!(inside.failed(), 0);
    let outside = ensemble(&method, every).bound("one", 2.0..).run().unwrap();
    assert_eq!((outside.failed(), outside.counts()[0]), (200, 0));
}

#[test]
fn a_mean_that_hangs_on_one_path_is_reported() {
    let oscillator = oscillator(Midpoint);
    let ensemble = |paths| {
        Ensemble::new(&oscillator)
            .paths(paths)
            .steps(0.05, 2)
            .start(Starts::each(|path, _| {
                State::new([if path == 77 { 1.0 } else { 0.0 }], [0.0])
            }))
            .observe("event", |_, s| if s.q[0] > 0.5 { 1.0 } else { 0.0 })
            .run()
            .unwrap()
    };
    match &ensemble(500).warnings()[..] {
        [
            Warning::OnePath {
                name,
                paths: 500,
                value,
                share,
                ..
            },
        ] => {
            assert_eq!((name.as_str(), *value), ("event", 1.0));
            assert!(*share > 0.99);
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(ensemble(80).warnings(), []);
}
