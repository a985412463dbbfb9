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
