//! Noise that dominates, and noise that vanishes.

use sve_models::models::{DoublePendulum, Kubo, Oscillator, PlanarDoublePendulum};
use sve_runtime::{Dims, System, Variational, prelude::*};

use super::systems::{Fourth, Rotor};
use sve_models::models::Kepler;

/// Kubo's circle, with a kick of the angle of σ√h in each step: the midpoint rule stays on it to
/// rounding, for kicks of many turns too. The rounding of each of n steps is a few ε times the size
/// of its matrix, which a large turn x cancels within, up to ε x²/(1 + x²/4), so 4ε; they add up
/// like a random walk, bounded here by n/10 units.
#[test]
fn kubo_stays_on_its_circle() {
    let (h, steps) = (0.1_f64, 20_000);
    for strength in [0.1, 0.3, 1.0, 3.0, 10.0] {
        let sigma = strength / h.sqrt();
        let kubo = Integrator::new(Kubo { a: 1.0, sigma }, Midpoint);
        let start = State::new([1.0], [0.0]);
        for state in kubo.trajectory(start, h, Wiener::new(5)).take(steps) {
            let state = state.unwrap();
            let radius = state.q[0].hypot(state.p[0]);
            assert!(
                (radius - 1.0).abs() < 0.1 * steps as f64 * f64::EPSILON,
                "σ√h = {strength}: {radius}"
            );
        }
    }
}

/// The other two rules solve for one half of the step explicitly; their circle is deformed, and for
/// kicks near a turn there is none. What they give is finite or an error.
#[test]
fn kubo_by_the_other_rules_is_finite_or_an_error() {
    fn run<R>(rule: R, sigma: f64, h: f64)
    where
        Kubo: Variational<R>,
    {
        let kubo = Integrator::new(Kubo { a: 1.0, sigma }, rule);
        let path = kubo.trajectory(State::new([1.0], [0.0]), h, Wiener::new(5));
        for state in path.take(5000).map_while(Result::ok) {
            assert!(state.q[0].is_finite() && state.p[0].is_finite());
        }
    }
    for strength in [0.1, 1.0, 10.0] {
        run(Endpoint, strength / 0.1_f64.sqrt(), 0.1);
        run(InitialPoint, strength / 0.1_f64.sqrt(), 0.1);
    }
}

/// With increments that are bounded, equations with noise of degree four in p have solutions for
/// small h; with unbounded ones a long run meets the end of its branch, and says so.
#[test]
fn degree_four_needs_truncation() {
    let rotor = Integrator::new(Rotor { s: 0.3 }, Midpoint);
    let start = State::new([0.0], [2.0]);
    let h = 0.3;
    let bounded = Truncated::new(Wiener::new(1));
    let failed =
        |states: Vec<Result<State<[f64; 1]>, StepError>>| states.into_iter().find_map(Result::err);
    let error = failed(
        rotor
            .trajectory(start, h, Wiener::new(1))
            .take(200_000)
            .collect(),
    );
    let Some(StepError::BranchLost {
        t,
        h: step,
        dw,
        reached,
        step: followed,
    }) = &error
    else {
        panic!("{error:?}");
    };
    assert!(*t > 0.0 && *step == h && dw.len() == 1 && (0.0..1.0).contains(reached));
    assert_eq!(*followed, 1.0);
    let message = error.as_ref().unwrap().to_string();
    for part in ["refine", "smaller h", "3e-1"] {
        assert!(message.contains(part), "{message}");
    }
    let error = failed(
        rotor
            .trajectory(start, 0.02, bounded)
            .take(20_000)
            .collect(),
    );
    assert_eq!(error, None);
}

/// The bits of a trajectory.
fn bits<S, R, W: Noise, const N: usize, const M: usize>(
    system: S,
    rule: R,
    start: State<[f64; N]>,
    noise: W,
) -> Vec<u64>
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let integrator = Integrator::new(system, rule);
    let path = integrator.trajectory(start, 0.05, noise).take(500);
    path.flat_map(|state| {
        let state = state.unwrap();
        [state.q.map(f64::to_bits), state.p.map(f64::to_bits)].concat()
    })
    .collect()
}

fn no_noise_is_the_limit<R: Copy>(rule: R)
where
    Oscillator: Variational<R>,
    Kepler: Variational<R>,
    Fourth: Variational<R>,
    Kubo: Variational<R>,
    DoublePendulum: Variational<R>,
{
    // σ = 0 with noise, no noise with σ, and a σ whose kicks are below the last digit
    let start = State::new([1.0], [0.3]);
    let oscillator = |sigma, noise: &mut dyn Noise| bits(Oscillator { sigma }, rule, start, noise);
    let still = oscillator(0.7, &mut NoNoise);
    for sigma in [0.0, 1e-20, 1e-300] {
        assert_eq!(oscillator(sigma, &mut Wiener::new(2)), still);
    }
    let start = State::new([1.0, 0.1], [0.1, 1.0]);
    let kepler = |sigma, noise: &mut dyn Noise| bits(Kepler { k: 1.0, sigma }, rule, start, noise);
    let still = kepler(0.7, &mut NoNoise);
    for sigma in [0.0, 1e-22, 1e-300] {
        assert_eq!(kepler(sigma, &mut Wiener::new(2)), still);
    }
    let start = State::new([1.0], [0.3]);
    let fourth = |s, noise: &mut dyn Noise| bits(Fourth { s, beta: 1.0 }, rule, start, noise);
    let still = fourth(0.7, &mut NoNoise);
    for s in [0.0, 1e-22, 1e-300] {
        assert_eq!(fourth(s, &mut Wiener::new(2)), still);
    }
    let kubo = |sigma, noise: &mut dyn Noise| bits(Kubo { a: 1.0, sigma }, rule, start, noise);
    let still = kubo(0.7, &mut NoNoise);
    for sigma in [0.0, 1e-22, 1e-300] {
        assert_eq!(kubo(sigma, &mut Wiener::new(2)), still);
    }
    let start = State::new([1.0, 0.5], [0.1, 0.2]);
    let double = |s, noise: &mut dyn Noise| {
        let (m, l, g) = ([1.0, 0.7], [1.0, 1.2], 9.8);
        bits(DoublePendulum { m, l, g, s }, rule, start, noise)
    };
    let still = double(0.7, &mut NoNoise);
    for s in [0.0, 1e-22, 1e-300] {
        assert_eq!(double(s, &mut Wiener::new(2)), still);
    }
}

#[test]
fn vanishing_noise_leaves_the_bits_of_the_deterministic_step() {
    no_noise_is_the_limit(InitialPoint);
    no_noise_is_the_limit(Endpoint);
    no_noise_is_the_limit(Midpoint);
}

/// A system with σ = 0 against a system without noise.
#[test]
fn a_system_without_noise_has_the_same_bits() {
    fn check<R: Copy>(rule: R)
    where
        DoublePendulum: Variational<R>,
        PlanarDoublePendulum: Variational<R>,
    {
        let (m, l, g) = ([1.0, 0.7], [1.0, 1.2], 9.8);
        let start = State::new([1.0, 0.5], [0.1, 0.2]);
        let noisy = bits(
            DoublePendulum { m, l, g, s: 0.0 },
            rule,
            start,
            Wiener::new(2),
        );
        let still = bits(PlanarDoublePendulum { m, l, g }, rule, start, NoNoise);
        assert_eq!(noisy, still);
    }
    check(InitialPoint);
    check(Endpoint);
    check(Midpoint);
}
