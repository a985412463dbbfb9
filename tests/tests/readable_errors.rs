//! A program whose `main` returns an error prints the message.

use std::process::Command;

use sve_runtime::ensemble::EnsembleError;
use sve_runtime::prelude::*;

/// A pendulum that spins too fast for its step.
struct Pendulum;

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
}

/// Set in the process that fails.
const FAILS: &str = "SVE_TEST_FAILS";

fn failing_step() -> Result<(), StepError> {
    let pendulum = Integrator::new(Pendulum, Midpoint);
    pendulum.step(&mut State::new([f64::NAN], [0.0]), 0.1, &[])
}

fn failing_ensemble() -> Result<(), EnsembleError> {
    let pendulum = Integrator::new(Pendulum, Midpoint);
    Ensemble::new(&pendulum).steps(0.1, 10).run().map(drop)
}

/// Ends with the error of a step where the variable is set: what a `main` does.
#[test]
fn a_process_that_ends_with_an_error() -> Result<(), StepError> {
    match std::env::var_os(FAILS) {
        Some(_) => failing_step(),
        None => Ok(()),
    }
}

#[test]
fn an_error_of_main_is_printed_as_its_message() {
    let output = Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "a_process_that_ends_with_an_error",
            "--nocapture",
        ])
        .env(FAILS, "1")
        .output()
        .unwrap();
    assert!(!output.status.success());
    let printed = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    let message = failing_step().unwrap_err().to_string();
    assert!(
        printed.concat().contains(&format!("Error: {message}")),
        "{printed:?}"
    );
}

#[test]
fn errors_are_printed_as_their_messages() {
    let error = failing_ensemble().unwrap_err();
    assert_eq!(format!("{error:?}"), error.to_string());
    let boxed: Box<dyn std::error::Error> = failing_step().unwrap_err().into();
    assert_eq!(format!("{boxed:?}"), boxed.to_string());
    let error = std::fs::exists("/").map(|_| std::path::Path::new("/no/such/folder/x.csv"));
    let pendulum = Integrator::new(Pendulum, Midpoint);
    let start = State::new([0.1], [0.0]);
    let summary = Ensemble::new(&pendulum)
        .paths(1)
        .steps(0.1, 1)
        .start(start)
        .run()
        .unwrap();
    let error = summary.to_csv(error.unwrap()).unwrap_err();
    assert!(
        format!("{error:?}").contains("/no/such/folder/x.csv: No such"),
        "{error:?}"
    );
}
