//! Constraints whose gradients vanish where they hold, which a step refuses, and constraints of any
//! size, which it takes.

use sve_models::stepper::{Stepper, Steppers, with_verlet};
use sve_runtime::Variational;
use sve_runtime::ensemble::Cause;
use sve_runtime::prelude::*;

/// A particle on the circle f = 0, written as s (f² + r f).
struct Circle {
    r: f64,
    s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Circle {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - q[1]
    }

    #[constraint]
    fn circle(&self, q: [f64; 2]) -> f64 {
        let f = q[0] * q[0] + q[1] * q[1] - 1.0;
        self.s * (f * f) + self.s * self.r * f
    }
}

/// The same with f³, and with noise that is curved in the momentum: the solution has no bounds.
struct Curved {
    r: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Curved {
    fn lagrangian(&self, _q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1])
    }

    #[h1(tangent)]
    fn noise(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        0.05 * (p[0] * p[0] + p[1] * p[1]) * (2.0 + q[0])
    }

    #[constraint]
    fn circle(&self, q: [f64; 2]) -> f64 {
        let f = q[0] * q[0] + q[1] * q[1] - 1.0;
        f.powi(3) + self.r * f
    }
}

/// A point beside the circle by a part of its radius, moving along it.
fn beside(k: u32) -> State<[f64; 2]> {
    let angle = 0.37 * f64::from(k);
    let side = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    let radius = 1.0 + side * 10.0_f64.powf(-1.0 - 0.15 * f64::from(k % 90));
    let (sin, cos) = angle.sin_cos();
    State::new([radius * cos, radius * sin], [-sin, cos])
}

fn distance(state: &State<[f64; 2]>) -> f64 {
    (state.q[0].hypot(state.q[1]) - 1.0).abs()
}

/// Returns how many starts are projected and how many steps are made, and the largest distance from
/// the circle of what came of them.
fn made<const M: usize>(rule: &dyn Stepper<[f64; 2], [f64; M]>, dw: &[f64; M]) -> (u32, u32, f64) {
    let (mut projected, mut stepped, mut worst) = (0, 0, 0.0_f64);
    for k in 0..180 {
        let start = beside(k);
        match rule.consistent(start) {
            Ok(state) => {
                projected += 1;
                worst = worst.max(distance(&state));
            }
            Err(error) => {
                let is_refused = matches!(
                    error,
                    StepError::ConstraintGradient { .. }
                        | StepError::ConstraintRank { .. }
                        | StepError::NoConsistentState { .. }
                );
                assert!(is_refused, "{error}");
            }
        }
        let mut end = start;
        match rule.step(&mut end, 0.01, dw) {
            Ok(()) => {
                stepped += 1;
                worst = worst.max(distance(&end));
            }
            Err(_) => assert_eq!(end, start),
        }
    }
    (projected, stepped, worst)
}

#[test]
fn a_squared_function_is_no_constraint() {
    for s in [1.0, 2.0_f64.powi(60), 2.0_f64.powi(-60)] {
        for rule in with_verlet(&Circle { r: 0.0, s }) {
            let (projected, stepped, _) = made(&*rule, &[]);
            assert_eq!((projected, stepped), (0, 0), "{}, s = {s}", rule.name());
        }
    }
    // both circles of f² + r f are, if they are as far apart as the digits of f
    for r in [1e-12, 1e-9] {
        for rule in with_verlet(&Circle { r, s: 1.0 }) {
            let (.., worst) = made(&*rule, &[]);
            assert!(
                worst <= 0.51 * r + 1e-15,
                "{}, r = {r}: {worst}",
                rule.name()
            );
        }
    }
}

#[test]
fn the_error_has_the_numbers() {
    let integrator = Integrator::new(Circle { r: 0.0, s: 1.0 }, StormerVerlet);
    let start = State::new([1.0 + 1e-8, 0.0], [0.0, 1.0]);
    let error = integrator.step(&mut { start }, 0.01, &[]).unwrap_err();
    let StepError::ConstraintGradient {
        constraint,
        value,
        change,
        gradient,
        ..
    } = &error
    else {
        panic!("{error}");
    };
    assert_eq!(&**constraint, "circle");
    assert!((value / 4e-16 - 1.0).abs() < 1e-4, "{error}");
    assert!((gradient[0] / 8e-8 - 1.0).abs() < 1e-4, "{error}");
    // half of the gradient at the distance f/4 on either side
    assert!((change - 0.5).abs() < 1e-3, "{error}");
}

#[test]
fn constraints_of_any_size_are_taken() {
    let circles = [0, 60, -60].map(|power| Circle {
        r: 1.0,
        s: 2.0_f64.powi(power),
    });
    let ends = circles.each_ref().map(|circle| {
        let end = |rule: Box<dyn Stepper<[f64; 2], [f64; 0]> + '_>| {
            let (projected, _, worst) = made(&*rule, &[]);
            assert!(projected == 180 && worst < 1e-14, "{projected} {worst}");
            rule.after(rule.consistent(beside(3)).unwrap(), 0.01, &[], 100)
        };
        with_verlet(circle).into_iter().map(end).collect::<Vec<_>>()
    });
    assert_eq!(ends[0], ends[1]);
    assert_eq!(ends[0], ends[2]);
}

#[test]
fn roots_of_third_degree_are_refused_without_bounds() {
    let (none, circle) = (Curved { r: 0.0 }, Curved { r: 1.0 });
    let (midpoint, verlet) = (Midpoint, StormerVerlet);
    let [of_none, of_circle]: [Steppers<'_, _, 1>; 2] = [&none, &circle].map(|system| {
        let midpoint = Box::new(Integrator::new(system, midpoint)) as Box<dyn Stepper<_, _>>;
        vec![midpoint, Box::new(Integrator::new(system, verlet))]
    });
    for rule in of_none {
        let (projected, stepped, _) = made(&*rule, &[0.05]);
        assert_eq!((projected, stepped), (0, 0), "{}", rule.name());
    }
    for rule in of_circle {
        let (projected, stepped, worst) = made(&*rule, &[0.05]);
        assert!(
            projected == 180 && stepped > 30 && worst < 1e-14,
            "{stepped} {worst}"
        );
    }
}

/// Paths in lanes, from the circle and from beside it.
#[test]
fn lanes_refuse_them_too() {
    fn check<R: Copy + Sync>(rule: R)
    where
        Circle: Variational<R, Prepared: Sync, Memory: Sync>,
    {
        let integrator = Integrator::new(Circle { r: 0.0, s: 1.0 }, rule);
        assert!(integrator.plan().in_lanes);
        let summary = Ensemble::new(&integrator)
            .paths(180)
            .seed(1)
            .steps(0.01, 2)
            .start(Starts::each(|path, _| beside(path as u32)))
            .observe("x", |_, state: &State<[f64; 2]>| state.q[0])
            .run()
            .unwrap();
        assert_eq!(summary.failures().len(), 180);
        for failure in summary.failures() {
            let is_refused = matches!(
                failure.cause,
                Cause::Step(
                    StepError::ConstraintGradient { .. }
                        | StepError::ConstraintRank { .. }
                        | StepError::InconsistentStart { .. }
                )
            );
            assert!(is_refused && failure.step == 0, "{failure}");
        }
    }
    check(Midpoint);
    check(StormerVerlet);
}
