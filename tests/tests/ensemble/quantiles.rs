//! Intervals of quantiles: their ranks, and how often they contain the quantile of the distribution.

use sve_runtime::prelude::*;

/// A particle that stays where it starts.
struct Particle;

#[variational(midpoint)]
impl Particle {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v
    }
}

fn particle() -> Integrator<Particle, Midpoint> {
    Integrator::new(Particle, Midpoint)
}

/// Values 1 to n: the value of a rank is the rank. The ends are beyond the ranks np ∓ z√(np(1 − p)) by less than 2.
#[test]
fn ends_have_the_ranks_of_so_many_deviations() {
    let (method, paths) = (particle(), 1000_u16);
    let summary = Ensemble::new(&method)
        .paths(u64::from(paths))
        .steps(0.1, 1)
        .start_with(|path, _| State::new([((path * 77) % 1000 + 1) as f64], [0.0]))
        .observe("q", |_, state| state.q[0])
        .quantiles("q", 1000)
        .run()
        .unwrap();
    let quantiles = summary.quantiles("q").unwrap();
    assert_eq!(quantiles.rank_error(), [0.0, 0.0]);
    let n = f64::from(paths);
    for p in [0.05, 0.3, 0.5, 0.9] {
        assert_eq!(quantiles.quantile(p)[1], (n * p).ceil());
        for deviations in [0.0, 1.0, 3.0] {
            let half = deviations * (n * p * (1.0 - p)).sqrt();
            let [low, high] = quantiles.interval(p, deviations)[1];
            let (below, above) = (n * p - half - low, high - n * p - half);
            assert!((0.0..2.0).contains(&below), "{p} {deviations}: {low}");
            assert!((0.0..2.0).contains(&above), "{p} {deviations}: {high}");
        }
    }
    // 2 of 1000 values are not enough to tell 1/500 from 0
    assert_eq!(quantiles.interval(0.002, 2.0)[1][0], f64::NEG_INFINITY);
    assert_eq!(quantiles.interval(0.998, 2.0)[1][1], f64::INFINITY);
}

/// With two deviations 95 % of the intervals contain the quantile, and a few more, since the ends are whole ranks.
#[test]
fn intervals_contain_the_quantile_as_often_as_they_say() {
    let method = particle();
    let (runs, p) = (1000_u32, 0.3);
    let found = |seed: u32| {
        let summary = Ensemble::new(&method)
            .paths(192)
            .seed(u64::from(seed))
            .steps(0.1, 1)
            .start_with(|_, rng| State::new([rng.uniform()], [0.0]))
            .observe("q", |_, state| state.q[0])
            .quantiles("q", 192)
            .threads(1)
            .run()
            .unwrap();
        let [low, high] = summary.quantiles("q").unwrap().interval(p, 2.0)[1];
        low <= p && p <= high
    };
    let part =
        f64::from((0..runs).map(|seed| u32::from(found(seed))).sum::<u32>()) / f64::from(runs);
    // four standard errors of 0.0066 below 95.4 %; the widest interval that two more ranks on each side allow contains 98.5 %
    assert!((0.928..0.998).contains(&part), "{part}");
}

#[test]
#[should_panic(expected = "0 or more")]
fn an_interval_of_no_width_is_a_mistake() {
    let method = particle();
    let ensemble = Ensemble::new(&method).paths(4).steps(0.1, 1);
    let ensemble = ensemble.start(State::new([1.0], [0.0]));
    let summary = ensemble
        .observe("q", |_, s| s.q[0])
        .quantiles("q", 4)
        .run()
        .unwrap();
    let _ = summary.quantiles("q").unwrap().interval(0.5, f64::NAN);
}
