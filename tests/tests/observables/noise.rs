//! Sections of paths with noise: replay, the path within a step, its law.

use sve_runtime::prelude::*;

use super::systems::{Drifting, Langevin, Pendulum};

/// The same seed gives the same bits: in another order, from a step on, and after other events.
#[test]
fn sections_can_be_replayed() {
    let motion = Integrator::new(Pendulum { sigma: 0.5 }, StormerVerlet);
    let start = State::new([0.3], [0.0]);
    let (h, noise) = (0.2, Wiener::new(11).path(3));
    let section = |noise| {
        let path = motion.trajectory(start, h, noise);
        let section = path.crossings(|_, s| s.q[0]).angle();
        section.stop_at(|_, s| s.t - 150.0).map(Result::unwrap)
    };
    let all: Vec<_> = section(noise).collect();
    assert!(all.iter().eq(section(noise).collect::<Vec<_>>().iter()));
    assert_ne!(all, section(Wiener::new(11).path(4)).collect::<Vec<_>>());
    // another function beside it does not move the path
    let beside = motion
        .trajectory(start, h, noise)
        .crossings(|_, s| s.q[0])
        .angle()
        .samples(3)
        .stop_at(|_, s| s.t - all[20].t - 0.01);
    let seen: Vec<_> = beside.map(Result::unwrap).collect();
    for state in &all[..20] {
        let near = seen.iter().map(|other| (other.t - state.t).abs());
        // the noise moves the angle too, which has several zeros within a small part of a step
        assert!(near.fold(f64::INFINITY, f64::min) < 0.1 * h);
    }
    // entered at a step, with the increments from there on
    let mut path = motion.trajectory(start, h, noise);
    let middle = path.nth(99).unwrap().unwrap();
    let later = all.iter().filter(|s| s.t > middle.t);
    let entered = motion
        .trajectory(State { t: 0.0, ..middle }, h, noise.from_step(100))
        .crossings(|_, s| s.q[0])
        .angle();
    let mut count = 0;
    for (a, b) in later.zip(entered) {
        let b = b.unwrap();
        assert!((a.p[0] - b.p[0]).abs() < 1e-12 && (a.t - b.t - 20.0).abs() < 1e-12);
        count += 1;
    }
    assert!(count > 3);
}

/// The path of q = W at the times of the refined path.
fn refined_path(noise: &Wiener, h: f64, depth: u32, steps: usize) -> Vec<f64> {
    let fine_h = h / f64::from(1_u32 << depth);
    let fine = noise.refine(depth).unwrap();
    let fine = Recorded::record(fine, fine_h, 1, steps << depth).unwrap();
    let mut sums = vec![0.0];
    for k in 0..fine.len() {
        sums.push(sums[k] + fine.get(k).unwrap()[0]);
    }
    sums
}

/// Within steps the path is that of the refined noise, and a crossing of a level lies where the
/// refined path crosses it.
#[test]
fn the_path_within_a_step_is_the_refined_path() {
    let motion = Integrator::new(Drifting { sigma: 1.0 }, Midpoint);
    let (h, depth, steps) = (0.5, 10, 6);
    let start = State::new([0.0], [0.0]);
    let fine_h: f64 = h / 1024.0;
    let mut count = 0;
    for number in 0..50 {
        let noise = Wiener::new(8).path(number);
        let fine = refined_path(&noise, h, depth, steps);
        for k in [1_u16, 37, 512, 1500, 3071] {
            let path = motion.trajectory(start, h, noise);
            let at = path.stop_at(|_, s| s.t - f64::from(k) * fine_h).last();
            let at = at.unwrap().unwrap();
            assert!(
                (at.q[0] - fine[usize::from(k)]).abs() < 1e-14,
                "{at:?} {}",
                fine[usize::from(k)]
            );
            // the refined source knows the same path within its shorter steps
            let refined = noise.refine(3).unwrap();
            let path = motion.trajectory(start, h / 8.0, refined);
            let at = path.stop_at(|_, s| s.t - f64::from(k) * fine_h).last();
            let at = at.unwrap().unwrap();
            assert!(
                (at.q[0] - fine[usize::from(k)]).abs() < 1e-14,
                "{at:?} {}",
                fine[usize::from(k)]
            );
        }
        let path = motion.trajectory(start, h, noise);
        let section = path.crossings(|_, s| s.q[0] - 0.1);
        for state in section.stop_at(|_, s| s.t - 2.9) {
            #[allow(clippy::cast_sign_loss)] // times are positive
            let cell = (state.unwrap().t / fine_h) as usize;
            // within a fine step the path moves by a few √h
            let away = (fine[cell] - 0.1).abs();
            assert!(away < 6.0 * fine_h.sqrt(), "{away}");
            count += 1;
        }
    }
    assert!(count > 30, "{count}");
}

/// At a fixed fraction θ of a step the state is that of the bridge: mean `θΔW`, variance
/// `θ(1 − θ)h`.
#[test]
fn the_law_of_the_path_within_a_step() {
    let motion = Integrator::new(Drifting { sigma: 1.0 }, Midpoint);
    let h = 0.5;
    for fraction in [0.3, 0.5, 0.9] {
        let paths = 20_000;
        let (mut sum, mut squares, mut product) = (0.0, 0.0, 0.0);
        for path in 0..paths {
            let noise = Wiener::new(4).path(path);
            let whole = noise.increment(0, 0, h);
            let path = motion.trajectory(State::new([0.0], [0.0]), h, noise);
            let end = path.stop_at(|_, s| s.t - fraction * h).last();
            let bridge = end.unwrap().unwrap().q[0] - fraction * whole;
            sum += bridge;
            squares += bridge * bridge;
            product += bridge * whole;
        }
        let n = paths as f64;
        let variance = fraction * (1.0 - fraction) * h;
        assert!(sum.abs() / n < 4.0 * (variance / n).sqrt());
        assert!((squares / n / variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
        assert!(product.abs() / n < 4.0 * (variance * h / n).sqrt());
    }
}

/// A function that the noise itself moves is zero at the state that is found, although it has zeros
/// everywhere near.
#[test]
fn rough_functions_are_zero_where_they_are_found() {
    let motion = Integrator::new(
        Langevin {
            nu: 0.5,
            sigma: 1.0,
        },
        Midpoint,
    );
    let path = motion.trajectory(State::new([0.0], [0.5]), 0.1, Wiener::new(2));
    for state in path.crossings(|_, s| s.p[0]).take(500) {
        assert!(state.unwrap().p[0].abs() < 1e-10);
    }
    let path = motion.trajectory(State::new([0.0], [0.5]), 0.1, Wiener::new(2));
    for state in path.crossings(|_, s| s.q[0]).take(100) {
        assert!(state.unwrap().q[0].abs() < 1e-12);
    }
}

/// The time of a passage converges path by path with order 1: a step is solved anew on its part of
/// the path.
#[test]
fn passages_converge_with_the_rule() {
    let motion = Integrator::new(Pendulum { sigma: 0.3 }, Midpoint);
    let start = State::new([0.5], [0.0]);
    let paths = 301;
    let mut errors = [(); 4].map(|()| Vec::new());
    for path in 0..paths {
        let passage = |depth: u32| {
            let noise = Wiener::new(21).path(path).refine(depth).unwrap();
            let h = 0.4 / f64::from(1_u32 << depth);
            let path = motion.trajectory(start, h, noise);
            let end = path.stop_at(|_, s| s.q[0]).falling().take(4000).last();
            end.unwrap().unwrap().t
        };
        let exact = passage(8);
        for (depth, errors) in (0..).zip(&mut errors) {
            errors.push((passage(depth) - exact).abs());
        }
    }
    // medians: a path that turns near zero may pass it much later with another step
    let errors = errors.map(|mut errors| {
        errors.sort_by(f64::total_cmp);
        errors[errors.len() / 2]
    });
    let order = (errors[0] / errors[3]).log2() / 3.0;
    println!("passages: order {order:.2}, errors {errors:?}");
    assert!((order - 1.0).abs() < 0.15, "{order} {errors:?}");
}
