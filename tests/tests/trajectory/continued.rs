//! A trajectory that is stored and continued has the bits of one that was not interrupted.

use sve_runtime::Variational;
use sve_runtime::baseline::EulerMaruyama;
use sve_runtime::prelude::*;
use sve_tests::oracle::{Model, Rule, Visitor, every_step, name, oscillator};
use sve_tests::random::Random;

/// Stored as text after each of some steps, and continued.
struct Continued(Random);

impl Visitor for Continued {
    fn visit<S, R, const N: usize, const M: usize>(&mut self, integrator: &Integrator<S, R>)
    where
        S: Model<N, M> + Variational<R>,
        R: Rule,
    {
        let start = S::point(&mut self.0);
        let noise = || Wiener::new(3).path(4);
        let whole: Vec<_> = integrator
            .trajectory(start, 0.01, noise())
            .take(20)
            .map(Result::unwrap)
            .collect();
        for stop in [0, 1, 7, 19] {
            let mut path = integrator.trajectory(start, 0.01, noise());
            (0..stop).for_each(|_| drop(path.next()));
            let text = serde_json::to_string(&path.snapshot()).unwrap();
            let snapshot: Snapshot<State<[f64; N]>> = serde_json::from_str(&text).unwrap();
            assert_eq!(snapshot, path.snapshot());
            let mut rest = integrator.resume(snapshot, noise()).unwrap();
            assert_eq!(rest.step(), stop as u64);
            for state in &whole[stop..] {
                assert_eq!(
                    &rest.next().unwrap().unwrap(),
                    state,
                    "{}",
                    name(integrator)
                );
            }
            // the same by hand: the noise from there on; only the time is counted from elsewhere
            let middle = *path.state();
            let mut rest = integrator.trajectory(middle, 0.01, noise().from_step(stop as u64));
            if let Some(next) = whole.get(stop) {
                assert_eq!(rest.next().unwrap().unwrap().p, next.p);
            }
        }
    }
}

#[test]
fn is_stored_and_continued_with_the_same_bits() {
    every_step(&mut Continued(Random::new(21)));
}

/// With compensated sums and refined steps, which are more than a state.
#[test]
fn what_is_carried_is_stored_too() {
    let oscillator = Integrator::new(oscillator(), Endpoint);
    let start = State::at(0.3, [1.0], [0.2]);
    let noise = Wiener::new(8);
    let mut whole = oscillator
        .trajectory(start, 1e-3, noise.clone())
        .compensated();
    let mut plain = oscillator.trajectory(start, 1e-3, noise.clone());
    (0..1000).for_each(|_| drop((whole.next(), plain.next())));
    let text = serde_json::to_string(&whole.snapshot()).unwrap();
    let snapshot: Snapshot<State<[f64; 1]>> = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (snapshot.step(), snapshot.h(), snapshot.state()),
        (1000, 1e-3, whole.state())
    );
    let mut rest = oscillator.resume(snapshot.clone(), noise.clone()).unwrap();
    // said again, it is the same
    let mut again = oscillator
        .resume(snapshot.clone(), noise.clone())
        .unwrap()
        .compensated();
    let mut without = oscillator.trajectory(*whole.state(), 1e-3, noise.clone().from_step(1000));
    let mut differs = false;
    for _ in 0..1000 {
        let state = whole.next().unwrap().unwrap();
        assert_eq!(rest.next().unwrap().unwrap(), state);
        assert_eq!(again.next().unwrap().unwrap(), state);
        differs |= without.next().unwrap().unwrap().q != state.q;
    }
    assert!(differs, "the low parts matter");
    assert_eq!(rest.snapshot(), whole.snapshot());
    let error = EulerMaruyama::new(sve_tests::oracle::oscillator())
        .resume(snapshot, noise.clone())
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

/// A pendulum with noise of fourth degree in the momentum, whose step has no solution for a large increment.
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
