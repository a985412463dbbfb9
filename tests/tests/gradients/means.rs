//! Derivatives of means against differences of the means of the same paths, which they are exactly.

use sve_models::differences::derivative;
use sve_runtime::ensemble::By;
use sve_runtime::prelude::*;

use crate::adjoint::Swing;

const H: f64 = 0.05;
const STEPS: u64 = 30;

/// A double well with friction and noise that moves the position, at a rule with an iteration.
struct Well {
    a: f64,
    nu: f64,
    s: [f64; 2],
}

#[variational(midpoint)]
impl Well {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.a * (q * q - 1.0).powi(2)
    }
    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }
    #[gamma]
    fn bath(&self, q: f64) -> f64 {
        self.s[0] * q
    }
    #[h1]
    fn stir(&self, q: f64, p: f64) -> f64 {
        self.s[1] * q * p
    }
}

fn well(a: f64, nu: f64, s: [f64; 2]) -> Integrator<Well, Midpoint> {
    Integrator::new(Well { a, nu, s }, Midpoint)
}

/// The mean of an observable at the end.
fn mean(well: &Integrator<Well, Midpoint>, q: f64, p: f64) -> f64 {
    let a = well.system().a;
    let summary = paths(well, q, p)
        .observe("x", move |_, s| {
            a * (s.q[0] * s.p[0]).sin() + s.q[0].powi(2)
        })
        .run()
        .unwrap();
    assert_eq!(summary.failed(), 0);
    summary["x"].mean()[1]
}

fn paths(
    well: &Integrator<Well, Midpoint>,
    q: f64,
    p: f64,
) -> Ensemble<'_, Integrator<Well, Midpoint>> {
    // lanes that take the scalar step, and a tile that is not full
    Ensemble::new(well)
        .paths(70)
        .seed(9)
        .steps(H, STEPS)
        .start(Starts::each(move |path, rng| {
            let shift = if path == 3 { 2.0 } else { 0.1 };
            State::new([q + shift * rng.normal()], [p])
        }))
}

#[test]
fn derivatives_of_means_are_differences_of_the_same_paths() {
    let (a, nu, s) = (0.7, 0.4, [0.5, 0.2]);
    let (q, p) = (0.6, -0.2);
    let integrator = well(a, nu, s);
    let all = ["a".into(), "nu".into(), "s[0]".into(), "s[1]".into()];
    let all = all.into_iter().chain([By::q(0), By::p(0)]);
    let summary = paths(&integrator, q, p)
        .gradient("x", all, |s| {
            s.parameter("a") * (s.q[0] * s.p[0]).sin() + s.q[0].powi(2)
        })
        .run()
        .unwrap();
    assert!((summary["x"].mean()[1] - mean(&integrator, q, p)).abs() < 1e-14);
    let check = |by: By, difference: f64| {
        let found = summary.derivative("x", by.clone()).unwrap().mean()[1];
        assert!(
            (found - difference).abs() < 1e-8 * (1.0 + difference.abs()),
            "{by}: {found} {difference}"
        );
    };
    // the differences are taken in a hundredth of the parameters, where they have nine digits
    let by = |change: &dyn Fn(f64) -> f64| 100.0 * derivative(|d| change(0.01 * d));
    check("a".into(), by(&|d| mean(&well(a + d, nu, s), q, p)));
    check("nu".into(), by(&|d| mean(&well(a, nu + d, s), q, p)));
    let moved = |d: [f64; 2]| [s[0] + d[0], s[1] + d[1]];
    let by_s = by(&|d| mean(&well(a, nu, moved([d, 0.0])), q, p));
    check("s[0]".into(), by_s);
    let by_s = by(&|d| mean(&well(a, nu, moved([0.0, d])), q, p));
    check("s[1]".into(), by_s);
    check(By::q(0), by(&|d| mean(&integrator, q + d, p)));
    check(By::p(0), by(&|d| mean(&integrator, q, p + d)));
}

/// At the start a coordinate varies by itself alone, on each path alike.
#[test]
fn derivatives_at_the_start_are_those_of_the_function() {
    let integrator = well(0.7, 0.4, [0.5, 0.2]);
    let summary = paths(&integrator, 0.6, -0.2)
        .gradient("x", ["a".into(), By::q(0), By::p(0)], |s| {
            s.parameter("a") * s.p[0] + s.q[0]
        })
        .run()
        .unwrap();
    let at_start = |by: By| {
        let derivative = summary.derivative("x", by).unwrap();
        (derivative.mean()[0], derivative.standard_error()[0])
    };
    assert_eq!(at_start("a".into()), (-0.2, 0.0));
    assert_eq!(at_start(By::q(0)), (1.0, 0.0));
    assert_eq!(at_start(By::p(0)), (0.7, 0.0));
    assert!(summary.derivative("x", "nu").is_none());
}

/// One path of an ensemble is a trajectory, whose gradient the discrete adjoint has, piece by piece
/// of a step function.
#[test]
fn a_single_path_has_the_gradient_of_its_trajectory() {
    let swing = Integrator::new(Swing { g: 2.0, s: 0.3 }, Endpoint);
    let start = State::new([0.8], [0.1]);
    // the end is the end of a piece, to which the parameter in the observable belongs
    let pieces = [0..8, 8..16].map(|steps| By::during("g", steps));
    let by = pieces
        .iter()
        .cloned()
        .chain(["g".into(), "s".into(), By::q(0)]);
    let summary = Ensemble::new(&swing)
        .paths(1)
        .seed(5)
        .steps(H, 16)
        .start(start)
        .gradient("x", by, |s| s.parameter("g") * s.q[0].sin())
        .run()
        .unwrap();
    let path = swing.trajectory(start, H, Wiener::new(5).path(0));
    let gradient = path
        .adjoint(16)
        .pieces_of(8)
        .gradient(|k, s| (k == 16).then(|| s.parameter("g") * s.q[0].sin()))
        .unwrap();
    let check = |by: By, expected: f64| {
        let found = summary.derivative("x", by.clone()).unwrap().mean()[1];
        assert!((found - expected).abs() < 1e-13, "{by}: {found} {expected}");
    };
    for (piece, expected) in pieces.into_iter().zip(gradient.pieces("g").unwrap()) {
        check(piece, expected);
    }
    check("g".into(), gradient.get("g").unwrap());
    check("s".into(), gradient.get("s").unwrap());
    check(By::q(0), gradient.start().q[0]);
}
