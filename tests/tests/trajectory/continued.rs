//! A trajectory that is stored and continued has the bits of one that was not interrupted.

use sve_models::case::Case;
use sve_models::functions::Point;
use sve_models::oracle::{cases, oscillator};
use sve_models::random::Random;
use sve_runtime::baseline::EulerMaruyama;
use sve_runtime::prelude::*;

/// Stores the path as text after each of some steps, and continues it.
fn continued_has_the_same_bits(case: &dyn Case, random: &mut Random) {
    let start = case.model().point(random);
    let (h, noise) = (0.01, || Wiener::new(3).path(4));
    let whole: Vec<Point> = case
        .trajectory(&start, h, Box::new(noise()))
        .take(20)
        .map(Result::unwrap)
        .collect();
    for stop in [0, 1, 7, 19] {
        let stored = case.stored(&start, h, noise(), stop);
        let (step, mut rest) = case.continued(&stored, noise());
        assert_eq!(step, stop as u64);
        for state in &whole[stop..] {
            assert_eq!(&rest.next().unwrap().unwrap(), state, "{}", case.name());
        }
        // the same by hand: the noise from there on; only the time is counted from elsewhere
        let middle = stop.checked_sub(1).map_or(&start, |last| &whole[last]);
        let later = noise().from_step(stop as u64);
        let mut rest = case.trajectory(middle, h, Box::new(later));
        if let Some(next) = whole.get(stop) {
            assert_eq!(rest.next().unwrap().unwrap().p, next.p);
        }
    }
}

#[test]
fn a_stored_trajectory_is_continued_with_the_same_bits() {
    let mut random = Random::new(21);
    for case in cases() {
        continued_has_the_same_bits(&*case, &mut random);
    }
}

/// With compensated sums and refined steps, which are more than a state.
#[test]
fn what_is_carried_is_stored_too() {
    let oscillator = Integrator::new(oscillator(), Endpoint);
    let start = State::at(0.3, [1.0], [0.2]);
    let noise = Wiener::new(8);
    let mut whole = oscillator.trajectory(start, 1e-3, noise).compensated();
    let mut plain = oscillator.trajectory(start, 1e-3, noise);
    (0..1000).for_each(|_| drop((whole.next(), plain.next())));
    let text = serde_json::to_string(&whole.snapshot()).unwrap();
    let snapshot: Snapshot<State<[f64; 1]>> = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (snapshot.step(), snapshot.h(), snapshot.state()),
        (1000, 1e-3, whole.state())
    );
    let mut rest = oscillator.resume(snapshot.clone(), noise).unwrap();
    // said again, it is the same
    let mut again = oscillator
        .resume(snapshot.clone(), noise)
        .unwrap()
        .compensated();
    let mut without = oscillator.trajectory(*whole.state(), 1e-3, noise.from_step(1000));
    let mut differs = false;
    for _ in 0..1000 {
        let state = whole.next().unwrap().unwrap();
        assert_eq!(rest.next().unwrap().unwrap(), state);
        assert_eq!(again.next().unwrap().unwrap(), state);
        differs |= without.next().unwrap().unwrap().q != state.q;
    }
    assert!(differs, "the low parts matter");
    assert_eq!(rest.snapshot(), whole.snapshot());
    let error = EulerMaruyama::new(sve_models::oracle::oscillator())
        .resume(snapshot, noise)
        .err();
    assert_eq!(error, Some(StepError::Uncompensated { t: 1.3 }));

    let rotor = Integrator::new(Rotor, Midpoint);
    let start = State::new([0.0], [2.0]);
    let mut whole = rotor.trajectory(start, 0.5, Wiener::new(1)).refine(16);
    (0..500).for_each(|_| drop(whole.next()));
    assert!(whole.refinements().steps > 0);
    let mut rest = rotor
        .resume(whole.snapshot(), Wiener::new(1))
        .unwrap()
        .refine(16);
    for _ in 0..500 {
        assert_eq!(rest.next(), whole.next());
    }
    assert_eq!(rest.refinements(), whole.refinements());
    assert_eq!(rest.snapshot(), whole.snapshot());
}

/// A pendulum with noise of fourth degree in the momentum, whose step has no solution for a large
/// increment.
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

/// The data that a block reads: numbers, arrays, vectors, matrices and structs of these. Two
/// further fields belong to the user's functions alone.
#[derive(Clone)]
struct Rich {
    k: f64,
    a: [f64; 2],
    g: Vector2<f64>,
    m: Matrix2<f64>,
    bodies: [Body; 2],
    count: usize,
    is_shown: bool,
}

#[derive(Clone, Copy)]
struct Body {
    mass: f64,
}

#[variational(stormer_verlet, midpoint)]
impl Rich {
    fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        let [first, second] = self.bodies;
        let m: Matrix2<f64> = self.m;
        let kinetic = 0.5 * (first.mass * v.x * v.x + second.mass * v.y * v.y);
        kinetic + self.k * q.x.cos() - self.a[1] * q.y.sin() + self.g.dot(&q)
            - 0.1 * q.dot(&(m * q)).cos()
    }

    #[gamma]
    fn push(&self, q: Vector2<f64>) -> f64 {
        self.a[0] * q.x.sin()
    }
}

const RICH: Rich = Rich {
    k: 3.0,
    a: [0.3, 0.7],
    g: Vector2::new(0.1, -0.2),
    m: Matrix2::new(1.0, 0.2, 0.3, 0.8),
    bodies: [Body { mass: 1.0 }, Body { mass: 2.0 }],
    count: 1,
    is_shown: true,
};

/// Another Lagrangian that carries as many numbers.
struct Similar {
    k: f64,
}

#[variational(stormer_verlet)]
impl Similar {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.k * q.cos()
    }
}

struct Other {
    k: f64,
}

#[variational(stormer_verlet)]
impl Other {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.k * q.cosh()
    }
}

/// The force at the end of a step belongs to the parameters of that step.
#[test]
fn a_snapshot_is_not_resumed_with_other_parameters_where_something_is_carried() {
    let start = State::new(Vector2::new(0.8, -0.3), Vector2::new(0.3, 0.2));
    let noise = Wiener::new(2);
    let mut verlet = Integrator::new(RICH, StormerVerlet);
    let mut path = verlet.trajectory(start, 0.05, noise);
    // nothing is carried before the first step
    let before = path.snapshot();
    path.nth(9).unwrap().unwrap();
    let after = path.snapshot();
    let next = path.next().unwrap().unwrap();
    let text = serde_json::to_string(&after).unwrap();
    let changes: [fn(&mut Rich); 6] = [
        |s| s.k = 1.0,
        |s| s.a[0] += 1e-15,
        |s| s.a[1] = -0.7,
        |s| s.g.y = 0.0,
        |s| s.m[(1, 0)] = 0.2,
        |s| s.bodies[1].mass = 3.0,
    ];
    for change in changes {
        change(verlet.system_mut());
        let stored = serde_json::from_str(&text).unwrap();
        for snapshot in [after.clone(), stored] {
            let error = verlet.resume(snapshot, noise).map(|_| ()).unwrap_err();
            let message = error.to_string();
            assert!(
                matches!(error, StepError::OtherSteps { t: 0.5, .. }),
                "{message}"
            );
            assert!(
                message.contains("values of the system's parameters"),
                "{message}"
            );
        }
        // what the message says
        let from = noise.from_step(after.step());
        let mut on = verlet.trajectory(*after.state(), after.h(), from);
        let mut state = *after.state();
        verlet
            .step(&mut state, 0.05, &[noise.increment(10, 0, 0.05)])
            .unwrap();
        let found = on.next().unwrap().unwrap();
        assert_eq!((found.q, found.p), (state.q, state.p));
        assert!(verlet.resume(before.clone(), noise).is_ok());
        *verlet.system_mut() = RICH;
    }
    // no function of the block reads these fields
    verlet.system_mut().count = 7;
    verlet.system_mut().is_shown = false;
    assert_eq!(
        (verlet.system().count, verlet.system().is_shown),
        (7, false)
    );
    let mut resumed = verlet.resume(after.clone(), noise).unwrap();
    assert_eq!(resumed.next().unwrap().unwrap(), next);
    let error = verlet.clone().with_newton(Newton {
        max_iterations: 3,
        ..Newton::default()
    });
    let error = error.resume(after, noise).map(|_| ()).unwrap_err();
    assert!(
        error.to_string().contains("options of Newton's method"),
        "{error}"
    );
    // a stored form that does not say of which parameters it is
    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    value.as_object_mut().unwrap().remove("steps");
    let unknown = serde_json::from_value(value).unwrap();
    assert!(verlet.resume(unknown, noise).is_err());
}

#[test]
fn a_snapshot_of_another_formula_is_not_resumed() {
    let similar = Integrator::new(Similar { k: 1.0 }, StormerVerlet);
    let mut path = similar.trajectory(State::new([0.5], [0.1]), 0.1, NoNoise);
    path.nth(2).unwrap().unwrap();
    let other = Integrator::new(Other { k: 1.0 }, StormerVerlet);
    let error = other
        .resume(path.snapshot(), NoNoise)
        .map(|_| ())
        .unwrap_err();
    assert!(
        error.to_string().contains("other formulas of the system"),
        "{error}"
    );
}

/// A rule that carries nothing reads the present parameters alone.
#[test]
fn a_rule_that_carries_nothing_goes_on_with_other_parameters() {
    let start = State::new(Vector2::new(0.8, -0.3), Vector2::new(0.3, 0.2));
    let noise = Wiener::new(2);
    let mut midpoint = Integrator::new(RICH, Midpoint);
    let mut path = midpoint.trajectory(start, 0.05, noise);
    path.nth(9).unwrap().unwrap();
    let after = path.snapshot();
    midpoint.system_mut().k = 1.0;
    let resumed = midpoint.resume(after.clone(), noise).unwrap();
    let anew = midpoint.trajectory(*after.state(), 0.05, noise.from_step(10));
    for (a, b) in resumed.zip(anew).take(20) {
        let (a, b) = (a.unwrap(), b.unwrap());
        assert_eq!((a.q, a.p), (b.q, b.p));
    }
}
