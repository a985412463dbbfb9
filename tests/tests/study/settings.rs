//! Failures in studies, invalid settings, and files of results.

use sve_models::models::Kubo;
use sve_runtime::baseline::Heun;
use sve_runtime::prelude::*;
use sve_runtime::study::{Study, StudyError, read_csv, write_csv};
use sve_runtime::system::{IncrementsOf, StateOf};

use crate::report::{HORIZON, kubo, oscillator};

/// The midpoint rule, which fails if an increment is larger than a bound.
struct Timid(Integrator<Kubo, Midpoint>, f64);

impl OneStepMethod for Timid {
    type System = Kubo;
    type Increments = [f64; 1];
    type Prepared = f64;

    fn system(&self) -> &Kubo {
        self.0.system()
    }

    fn prepare(&self, h: f64) -> Result<f64, StepError> {
        Ok(h)
    }

    fn step_prepared(
        &self,
        h: &f64,
        state: &mut StateOf<Kubo>,
        _: f64,
        dw: &IncrementsOf<Kubo>,
    ) -> Result<(), StepError> {
        if dw[0].abs() > self.1 {
            return Err(StepError::StepSize { h: dw[0] });
        }
        self.0.step(state, *h, dw)
    }
}

#[test]
fn failures_are_counted_and_the_rest_is_measured() {
    let midpoint = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let bound = 0.45;
    let (timid, hopeless) = (Timid(midpoint.clone(), bound), Timid(midpoint.clone(), 0.0));
    let report = kubo()
        .paths(100)
        .seed(3)
        .method("midpoint", &midpoint)
        .method("timid", &timid)
        .method("hopeless", &hopeless)
        .repeats(1)
        .run()
        .unwrap();
    for steps in [16, 64] {
        let fails = |path: &u64| {
            let fine = Recorded::record(Wiener::new(3).path(*path), 1.0 / 64.0, 1, 64).unwrap();
            let coarse = fine.coarsen(64 / steps).unwrap();
            (0..steps).any(|step| coarse.get(step).unwrap()[0].abs() > bound)
        };
        let expected = (0..100).filter(fails).count() as u64;
        println!("{expected} failures");
        let row = report.row("timid", steps).unwrap();
        assert_eq!(row.failures, expected);
        assert!(steps == 64 || (expected > 10 && expected < 90));
        let all = report.row("midpoint", steps).unwrap();
        assert!(row.error.is_some() && (row.error == all.error) == (expected == 0));
        assert!(all.timing.unwrap().ns_per_step > 0.0);
        let row = report.row("hopeless", steps).unwrap();
        assert_eq!((row.failures, row.error, row.timing), (100, None, None));
    }
    // two step sizes have one slope, which is no order; with failures at one of them there is not
    // even that
    assert!(report.orders().is_empty());
    let slopes = report.not_asymptotic().iter();
    let slopes: Vec<(&str, usize)> = slopes.map(|m| (&*m.method, m.slopes.len())).collect();
    assert_eq!(slopes, [("midpoint", 1), ("timid", 0), ("hopeless", 0)]);
}

#[test]
fn a_study_is_a_function_of_its_settings() {
    let midpoint = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let study = |seed| {
        let study = kubo().paths(50).seed(seed).method("midpoint", &midpoint);
        study.run().unwrap()
    };
    assert_eq!(study(1), study(1));
    assert_ne!(study(1), study(2));
    assert_eq!(oscillator(), oscillator());
}

#[test]
fn records_are_read_back() {
    let records = oscillator().records();
    let mut file = Vec::new();
    write_csv(&mut file, &records).unwrap();
    assert_eq!(read_csv(&file[..]).unwrap(), records);
    assert_eq!(records[5].method, "endpoint");
    assert_eq!(records[5].h, Some(HORIZON / 64.0));
    assert!(records[5].energy_error.is_none() && records[5].source.starts_with("sve "));
}

#[test]
fn settings_that_make_no_sense_are_named() {
    let midpoint = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let good = || kubo().method("midpoint", &midpoint);
    let message = |study: Study<'_, Kubo>| study.run().unwrap_err().to_string();
    assert!(good().run().is_ok());
    assert!(message(kubo()).contains(".method("));
    assert!(message(Study::new("")).contains(".horizon("));
    assert!(message(good().step_counts([])).contains(".step_counts("));
    assert!(message(good().step_counts([12, 64])).starts_with("12 steps do not divide the 64"));
    assert!(message(good().step_counts([0])).starts_with("`steps` was given 0"));
    assert!(message(good().step_counts([8, 8])).contains("two of `8`"));
    assert!(message(good().paths(0)).starts_with("`paths` was given 0"));
    assert!(message(good().method("midpoint", &midpoint)).contains("two of `midpoint`"));
    assert!(message(good().fine(&midpoint, 0)).starts_with("`fine` was given 0"));
    let many = message(good().fine(&midpoint, 1 << 61));
    assert!(
        many.contains("2305843009213693952 times 64 steps"),
        "{many}"
    );
    // the same method made anew is the same; another one, other options, or smaller steps are not
    let again = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let own = message(good().fine(&again, 1));
    assert!(
        own.contains("is the method `midpoint` with the same 64 steps"),
        "{own}"
    );
    assert!(good().fine(&again, 2).run().is_ok());
    assert!(
        good()
            .fine(&Heun::new(Kubo { a: 1.0, sigma: 0.5 }), 1)
            .run()
            .is_ok()
    );
    let newton = Newton {
        max_iterations: 9,
        ..Newton::default()
    };
    assert!(good().fine(&again.with_newton(newton), 1).run().is_ok());
    for horizon in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = good().horizon(horizon).run().unwrap_err();
        assert!(matches!(error, StudyError::Horizon { .. }));
    }
    let short = |_: u64, _: usize| {
        (
            Recorded::new(0.1, [[0.0]]).unwrap(),
            State::new([0.0], [0.0]),
        )
    };
    assert!(message(good().exact_paths(short)).contains("wanted are 64 steps"));
    let hopeless = Timid(midpoint.clone(), 0.0);
    assert!(message(good().fine(&hopeless, 2)).starts_with("the reference of path 0 failed"));
    let undefined = |_: &Recorded| State::new([f64::NAN], [0.0]);
    assert!(message(good().exact(undefined)).starts_with("the reference of path 0 is not finite"));
}
