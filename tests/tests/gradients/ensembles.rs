//! Gradients in ensembles: bits, failures and messages.

use sve_models::models::Pendulum;
use sve_models::oracle::pendulum;
use sve_runtime::ensemble::By;
use sve_runtime::prelude::*;

use crate::adjoint::Swing;

const H: f64 = 0.05;

fn swing() -> Integrator<Swing, Endpoint> {
    Integrator::new(Swing { g: 2.0, s: 0.3 }, Endpoint)
}

fn ensemble(swing: &Integrator<Swing, Endpoint>) -> Ensemble<'_, Integrator<Swing, Endpoint>> {
    Ensemble::new(swing)
        .paths(300)
        .seed(4)
        .steps(H, 20)
        .every(5)
        .start(Starts::each(|_, rng| {
            State::new([0.8], [0.3 * rng.normal()])
        }))
        .observe("q", |_, state| state.q[0])
}

fn with_gradient(swing: &Integrator<Swing, Endpoint>) -> Ensemble<'_, Integrator<Swing, Endpoint>> {
    ensemble(swing).gradient("cos", ["g".into(), By::p(0)], |s| s.q[0].cos())
}

#[test]
fn gradients_change_no_other_bit() {
    let swing = swing();
    let (without, with) = (ensemble(&swing).run(), with_gradient(&swing).run());
    assert_eq!(without.unwrap()["q"], with.unwrap()["q"]);
}

#[test]
fn threads_and_shards_change_no_bit() {
    let swing = swing();
    let whole = with_gradient(&swing).run().unwrap();
    assert_eq!(with_gradient(&swing).threads(3).run().unwrap(), whole);
    let shard = |index| with_gradient(&swing).shard(index, 3).run().unwrap();
    let mut merged = shard(2);
    merged.merge(shard(0)).unwrap();
    merged.merge(shard(1)).unwrap();
    assert_eq!(merged, whole);
    // other quantities are another run
    let by_s = ensemble(&swing).gradient("cos", ["s".into(), By::p(0)], |s| s.q[0].cos());
    assert!(merged.merge(by_s.run().unwrap()).is_err());
}

#[test]
fn a_replayed_path_is_that_of_the_ensemble() {
    let swing = swing();
    let with = with_gradient(&swing).keep_final_states(true);
    let summary = with.run().unwrap();
    let (path, end) = summary.final_states().nth(77).unwrap();
    assert_eq!(with.replay(path).unwrap().last().unwrap().unwrap(), end);
}

#[test]
fn a_derivative_that_is_not_finite_is_a_failure() {
    let swing = swing();
    let summary = Ensemble::new(&swing)
        .paths(100)
        .steps(H, 4)
        .every(1)
        .start(State::new([0.8], [0.0]))
        // at the start the root is 0 and its derivative by q infinite
        .gradient("root", [By::q(0)], |s| (s.q[0] - 0.8).powi(2).sqrt())
        .run()
        .unwrap();
    assert_eq!(summary.failed(), 100);
    let failure = summary.failures()[0].to_string();
    assert!(failure.contains("∂root/∂q[0] at the start"), "{failure}");
    // a constant has no derivative by q, also where its own derivative is infinite
    let summary = Ensemble::new(&swing)
        .paths(10)
        .steps(H, 4)
        .start(State::new([0.8], [0.0]))
        .gradient("x", [By::q(0)], |s| {
            let zero = s.parameter("g") - s.parameter("g");
            s.q[0] + zero.sqrt()
        })
        .run()
        .unwrap();
    assert_eq!(summary.failed(), 0);
    assert_eq!(summary.derivative("x", By::q(0)).unwrap().mean()[0], 1.0);
}

#[test]
fn messages_name_what_there_is() {
    let swing = swing();
    let message = |by: By| {
        let wrong = ensemble(&swing).gradient("x", [by], |s| s.q[0]);
        wrong.run().unwrap_err().to_string()
    };
    assert_eq!(
        message("k".into()),
        "there is no gradient by k: L, the noises and the force have no such parameter; they have [\"g\", \"s\"]"
    );
    assert_eq!(
        message(By::p(1)),
        "there is no gradient by p[1] at the start: the system has 1 coordinates, whose numbers begin at 0"
    );
    let bead = Integrator::new(Bead { g: 1.0 }, StormerVerlet);
    let on_ring = Ensemble::new(&bead)
        .paths(10)
        .steps(H, 4)
        .start(State::new([1.0, 0.0], [0.0, 0.5]))
        .gradient("x", [By::q(0)], |s| s.q[0]);
    let message = on_ring.run().unwrap_err().to_string();
    assert!(message.contains("under constraints"), "{message}");
    let stopped = with_gradient(&swing).stop_at("down", |_, state| state.q[0]);
    let message = stopped.run().unwrap_err().to_string();
    assert!(message.contains("run without `stop_at`"), "{message}");
    let twice = with_gradient(&swing).gradient("cos", ["g"], |s| s.q[0].cos());
    assert!(matches!(twice.run(), Err(EnsembleError::TwiceNamed { .. })));
}

#[test]
fn an_unknown_parameter_in_a_function_is_an_error() {
    let known = "L, the noises and the force have no such parameter; they have [\"";
    let pendulum: Integrator<Pendulum, Midpoint> = Integrator::new(pendulum(), Midpoint);
    let path = pendulum.trajectory(State::new([1.0], [0.0]), H, NoNoise);
    let loss = path.gradient(1, |k, s| (k == 1).then(|| s.parameter("k") * s.q[0]));
    let message = loss.unwrap_err().to_string();
    let expected = format!("`parameter(\"k\")`: {known}");
    assert!(message.starts_with(&expected), "{message}");
    let swing = swing();
    // before the first step, also where the number has no influence
    let wrong = ensemble(&swing).gradient("x", ["g"], |s| {
        let _ = s.parameter("k");
        s.q[0]
    });
    let message = wrong.run().unwrap_err().to_string();
    let expected = format!("the function of the gradient `x`: {expected}");
    assert!(message.starts_with(&expected), "{message}");
    // the function may ask for a parameter only later
    let later = ensemble(&swing).gradient("x", ["g"], |s| {
        if s.t < 0.3 {
            s.q[0]
        } else {
            s.parameter("k") * s.q[0]
        }
    });
    let summary = later.run().unwrap();
    assert_eq!(summary.failed(), 300);
    let failure = summary.failures()[0].to_string();
    assert!(failure.contains(known), "{failure}");
}

/// A bead on a ring that stands upright.
struct Bead {
    g: f64,
}

#[variational(stormer_verlet)]
impl Bead {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - self.g * q[1]
    }
    #[constraint]
    fn ring(&self, q: [f64; 2]) -> f64 {
        0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0)
    }
}

/// For a large ΔW a step has no solution.
struct Rotor;

#[variational(midpoint)]
impl Rotor {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
    #[h1]
    fn jitter(&self, _q: f64, p: f64) -> f64 {
        0.1 * p.powi(4)
    }
}

/// A step that is made in parts has no tangent map.
#[test]
fn a_path_with_a_refined_step_fails() {
    let rotor = Integrator::new(Rotor, Midpoint);
    let ensemble = || {
        Ensemble::new(&rotor)
            .paths(100)
            .seed(1)
            .steps(0.5, 12)
            .start(State::new([0.0], [2.0]))
    };
    let failed = |summary: Summary| {
        let failures = summary.failures().iter().map(|failure| failure.path);
        failures.collect::<Vec<_>>()
    };
    let plain = failed(ensemble().run().unwrap());
    assert!(plain.len() > 10 && plain.len() < 100, "{}", plain.len());
    let refined = ensemble().refine(16);
    assert_eq!(refined.run().unwrap().failed(), 0);
    let with = refined.gradient("cos", [By::p(0)], |s| s.q[0].cos());
    assert_eq!(failed(with.run().unwrap()), plain);
}
