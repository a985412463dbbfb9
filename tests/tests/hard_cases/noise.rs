//! Noise that dominates, and noise that vanishes.

use sve_models::checks::assert_says;
use sve_models::models::{DoublePendulum, Kepler, Kubo, Oscillator, PlanarDoublePendulum, Rotor};
use sve_models::stepper::one_node;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Variational, prelude::*};

use super::systems::Fourth;

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
    for strength in [0.1, 1.0, 10.0] {
        let (h, a) = (0.1_f64, 1.0);
        let sigma = strength / h.sqrt();
        for rule in one_node(&Kubo { a, sigma }) {
            let mut state = State::new([1.0], [0.0]);
            for step in 0..5000 {
                let dw = [Wiener::new(5).increment(step, 0, h)];
                if rule.step(&mut state, h, &dw).is_err() {
                    break;
                }
                let is_finite = state.q[0].is_finite() && state.p[0].is_finite();
                assert!(is_finite, "{}, step {step}: {state:?}", rule.name());
            }
        }
    }
}

/// With increments that are bounded, equations with noise of degree four in p have solutions for
/// small h; with unbounded ones a long run meets the end of its branch, and says so.
#[test]
fn degree_four_needs_truncation() {
    let rotor = Integrator::new(Rotor { s: 0.25 * 0.3 }, Midpoint);
    let start = State::new([0.0], [2.0]);
    let h = 0.3;
    let bounded = Truncated::new(Wiener::new(1));
    let path = rotor.trajectory(start, h, Wiener::new(1));
    let error = path.take(200_000).find_map(Result::err);
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
    assert_says(error.as_ref().unwrap(), &["refine", "smaller h", "3e-1"]);
    let mut path = rotor.trajectory(start, 0.02, bounded).take(20_000);
    assert_eq!(path.find_map(Result::err), None);
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

/// The bits of a path with a strength of noise and a source.
type PathBits<'a> = dyn Fn(f64, &mut dyn Noise) -> Vec<u64> + 'a;

/// σ = 0 with noise, no noise with σ, and a σ whose kicks are below the last digit: the same bits.
fn no_noise_is_the_limit<R: Copy>(rule: R)
where
    Oscillator: Variational<R>,
    Kepler: Variational<R>,
    Fourth: Variational<R>,
    Kubo: Variational<R>,
    DoublePendulum: Variational<R>,
{
    let (line, double) = (State::new([1.0], [0.3]), State::new([1.0, 0.5], [0.1, 0.2]));
    let planet = State::new([1.0, 0.1], [0.1, 1.0]);
    let (m, l, g) = ([1.0, 0.7], [1.0, 1.2], 9.8);
    let paths: [(&str, f64, &PathBits<'_>); 5] = [
        ("Oscillator", 1e-20, &|sigma, noise| {
            bits(Oscillator { sigma }, rule, line, noise)
        }),
        ("Kepler", 1e-22, &|sigma, noise| {
            bits(Kepler { k: 1.0, sigma }, rule, planet, noise)
        }),
        ("Fourth", 1e-22, &|s, noise| {
            bits(Fourth { s, beta: 1.0 }, rule, line, noise)
        }),
        ("Kubo", 1e-22, &|sigma, noise| {
            bits(Kubo { a: 1.0, sigma }, rule, line, noise)
        }),
        ("DoublePendulum", 1e-22, &|s, noise| {
            bits(DoublePendulum { m, l, g, s }, rule, double, noise)
        }),
    ];
    for (name, tiny, path) in paths {
        let still = path(0.7, &mut NoNoise);
        for sigma in [0.0, tiny, 1e-300] {
            let quiet = path(sigma, &mut Wiener::new(2));
            assert_eq!(quiet, still, "{name}, σ = {sigma:e}");
        }
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
    let (m, l, g) = ([1.0, 0.7], [1.0, 1.2], 9.8);
    let (noisy, still) = (
        DoublePendulum { m, l, g, s: 0.0 },
        PlanarDoublePendulum { m, l, g },
    );
    for (noisy, still) in one_node(&noisy).iter().zip(one_node(&still)) {
        let start = State::new([1.0, 0.5], [0.1, 0.2]);
        let (mut with, mut without) = (start, start);
        for step in 0..500 {
            let dw = [0, 1].map(|process| Wiener::new(2).increment(step, process, 0.05));
            noisy.step(&mut with, 0.05, &dw).unwrap();
            still.step(&mut without, 0.05, &[]).unwrap();
            assert_eq!(with, without, "{}, step {step}", noisy.name());
        }
    }
}
