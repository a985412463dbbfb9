//! Noises that are forces: closed forms of steps, what is conserved, the Itô correction, and
//! ensembles. Poles of many unknowns are in `noise_forces/poles.rs`. `derivatives.rs` compares the
//! steps with the equations of the discrete action, with the corrections of rules with one node at
//! an end.

pub(crate) mod poles;

use sve_models::differences::derivatives;
use sve_models::models::Rubbed;
use sve_models::oracle::{rubbed, sail};
use sve_runtime::Variational;
use sve_runtime::baseline::EulerMaruyama;
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// A free particle whose friction is noisy: `dp = σp ∘ dW`.
struct Rubbing {
    sigma: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(3),
    gauss(4)
)]
impl Rubbing {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v
    }
    #[force(noise)]
    fn rub(&self, _q: f64, v: f64) -> f64 {
        self.sigma * v
    }
}

/// Returns p₁/p₀ of a step with ``y = σΔW``.
fn ratio<R: Copy>(rule: R, y: f64) -> Result<f64, StepError>
where
    Rubbing: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let integrator = Integrator::new(Rubbing { sigma: 0.8 }, rule);
    let mut state = State::new([0.3], [1.0]);
    integrator.step(&mut state, 0.1, &[y / 0.8])?;
    Ok(state.p[0])
}

/// The ratios are those of the linear test equation: of the rules with one node at an end with the
/// correction, of Gauss rules the diagonal Padé approximants of eʸ.
#[test]
fn friction_noise_has_its_closed_form() {
    for y in [-3.0, -0.4, 0.0, 0.3, 1.2] {
        let expected = [
            1.0 / (1.0 - y + 0.5 * y * y),
            1.0 + y + 0.5 * y * y,
            (1.0 + 0.5 * y) / (1.0 - 0.5 * y),
            (1.0 + 0.5 * y) / (1.0 - 0.5 * y),
            (1.0 + y / 2.0 + y * y / 12.0) / (1.0 - y / 2.0 + y * y / 12.0),
        ];
        let found = [
            ratio(InitialPoint, y),
            ratio(Endpoint, y),
            ratio(Midpoint, y),
            ratio(StormerVerlet, y),
            ratio(Gauss::<2>, y),
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            let found = found.unwrap();
            assert!(
                (found - expected).abs() < 1e-14 * (1.0 + expected.abs()),
                "y = {y}: {found}, not {expected}"
            );
        }
    }
}

/// The midpoint rule and the rule of Störmer and Verlet have a pole at y = 2, the rule with three
/// stages at 4.644. Steps beyond are errors, although their equations are linear.
#[test]
fn a_step_that_meets_a_pole_is_an_error() {
    let poles = [
        (ratio(Midpoint, 1.9), ratio(Midpoint, 2.5), 0.8),
        (ratio(StormerVerlet, 1.9), ratio(StormerVerlet, 2.5), 0.8),
        (ratio(Gauss::<3>, 4.6), ratio(Gauss::<3>, 6.0), 0.774),
    ];
    for (before, beyond, at) in poles {
        assert!(before.unwrap().is_finite());
        let Err(error @ StepError::NoisePole { reached, .. }) = &beyond else {
            panic!("{beyond:?}");
        };
        assert!((reached - at).abs() < 1e-3, "{reached}");
        let message = error.to_string();
        for word in ["`gauss(2)`", "`endpoint`", "`Truncated`", "pole"] {
            assert!(message.contains(word), "{word}: {message}");
        }
    }
    for y in [-20.0, 2.0, 8.0, 50.0] {
        for found in [
            ratio(InitialPoint, y),
            ratio(Endpoint, y),
            ratio(Gauss::<2>, y),
            ratio(Gauss::<4>, y),
        ] {
            assert!(found.unwrap() > 0.0, "y = {y}");
        }
    }
}

#[test]
fn plans_tell_of_poles_and_of_structure() {
    macro_rules! text {
        ($rule:expr) => {
            Integrator::new(Rubbing { sigma: 0.8 }, $rule)
                .plan()
                .to_string()
        };
    }
    for (text, has_pole) in [
        (text!(InitialPoint), false),
        (text!(Endpoint), false),
        (text!(Midpoint), true),
        (text!(StormerVerlet), true),
        (text!(Gauss::<2>), false),
        (text!(Gauss::<3>), true),
    ] {
        assert_eq!(text.contains("do not exist"), has_pole, "{text}");
        assert!(text.contains("keeps no symplectic form"), "{text}");
        assert!(text.contains("(Stratonovich)"), "{text}");
    }
    let order = Integrator::new(sail(), Midpoint).plan().strong_order;
    let pair = ("jitter", "push");
    assert_eq!(order, StrongOrder::Half { pair });
    let order = Integrator::new(rubbed(), Midpoint).plan().strong_order;
    assert_eq!(order, StrongOrder::One);
}

/// A noise force that depends on time, without another force.
struct Gusts;

#[variational(midpoint, gauss(2))]
impl Gusts {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }
    #[force(noise)]
    fn gust(&self, t: f64, q: f64, _v: f64) -> f64 {
        t.cos() * q
    }
}

#[test]
fn plans_name_the_time_of_a_noise_force() {
    let texts = [
        (
            Integrator::new(Gusts, Midpoint).plan().to_string(),
            "f(t̄, q̄, v)",
        ),
        (
            Integrator::new(Gusts, Gauss::<2>).plan().to_string(),
            "f(tᵢ, Qᵢ, Vᵢ)",
        ),
    ];
    for (text, force) in texts {
        assert!(
            text.contains("L(q̄, v)") || text.contains("L(Qᵢ, Vᵢ)"),
            "{text}"
        );
        assert!(!text.contains("f(q") && !text.contains("f(Q"), "{text}");
        assert!(text.contains(force), "{text}");
        assert!(text.contains("t̄ = ") || text.contains("tᵢ = "), "{text}");
    }
}

/// Masses whose elimination finds no pivot on the diagonal, with two noise forces of positions.
struct Swapped;

#[variational(midpoint)]
impl Swapped {
    fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 {
        v[0] * v[1] + v[1] * v[2] + v[2] * v[3] - q[0] * q[1]
    }
    #[force(noise)]
    fn first(&self, q: [f64; 4], _v: [f64; 4]) -> [f64; 4] {
        [q[1], 0.0, q[0] * q[2], 0.0]
    }
    #[force(noise)]
    fn second(&self, q: [f64; 4], _v: [f64; 4]) -> [f64; 4] {
        [0.0, q[3], q[1], 1.0]
    }
}

#[test]
fn noise_forces_of_positions_commute_whatever_the_masses() {
    let order = Integrator::new(Swapped, Midpoint).plan().strong_order;
    assert_eq!(order, StrongOrder::One);
}

/// A push in one direction as a γ, and as a force.
struct Pushed {
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2), gauss(4))]
impl Pushed {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
    #[force]
    fn drag(&self, _q: f64, v: f64) -> f64 {
        -0.5 * v
    }
}

struct Forced {
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2), gauss(4))]
impl Forced {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
    #[force(noise)]
    fn push(&self, _q: f64, _v: f64) -> f64 {
        self.sigma
    }
    #[force]
    fn drag(&self, _q: f64, v: f64) -> f64 {
        -0.5 * v
    }
}

fn agree<R: Copy>(rule: R)
where
    Pushed: Variational<R> + System<Dims = Dims<1, 1>>,
    Forced: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let start = State::new([0.4], [0.7]);
    let pushed = Integrator::new(Pushed { sigma: 0.6 }, rule);
    let forced = Integrator::new(Forced { sigma: 0.6 }, rule);
    let end = |state: Option<Result<State<[f64; 1]>, StepError>>| state.unwrap().unwrap();
    let expected = end(pushed.trajectory(start, 0.1, Wiener::new(2)).nth(99));
    let found = end(forced.trajectory(start, 0.1, Wiener::new(2)).nth(99));
    // the same terms in another order
    let error = (found.q[0] - expected.q[0]).abs() + (found.p[0] - expected.p[0]).abs();
    assert!(error < 1e-13, "{found:?} {expected:?}");
    let plans = [pushed.plan(), forced.plan()];
    assert_eq!(plans[0].strong_order, plans[1].strong_order);
    assert_eq!(plans[0].weak_order, plans[1].weak_order);
}

/// The moments of an Ornstein–Uhlenbeck process with a γ are thus those with a force.
#[test]
fn a_constant_force_is_that_of_a_linear_potential() {
    agree(InitialPoint);
    agree(Endpoint);
    agree(Midpoint);
    agree(StormerVerlet);
    agree(Gauss::<2>);
    agree(Gauss::<4>);
}

/// Two coordinates with a noisy spring to the origin, written as a force: its torque is zero.
struct Sprung;

#[variational(midpoint, stormer_verlet, endpoint, gauss(2))]
impl Sprung {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.25 * (q[0] * q[0] + q[1] * q[1]).powi(2)
    }
    #[force(noise)]
    fn pull(&self, q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        let speed = v[0] * v[0] + v[1] * v[1];
        q.map(|q| 0.4 * q / (1.0 + speed))
    }
    #[symmetry]
    fn turn(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0]]
    }
}

#[test]
fn a_force_without_work_along_a_symmetry_keeps_its_momentum() {
    let start = State::new([0.8, 0.1], [0.2, 0.9]);
    let momentum = Sprung.turn_momentum(&start);
    macro_rules! check {
        ($($rule:expr),*) => {$(
            let integrator = Integrator::new(Sprung, $rule);
            assert_eq!(integrator.plan().conserved, ["turn_momentum"]);
            for state in integrator.trajectory(start, 0.05, Wiener::new(3)).take(500) {
                let found = Sprung.turn_momentum(&state.unwrap());
                assert!((found - momentum).abs() < 1e-13, "{found} for {momentum}");
            }
        )*};
    }
    check!(Midpoint, StormerVerlet, Endpoint, Gauss::<2>);
}

/// Checks `½ Σ (Dg_a) g_a` against differences of the fields.
fn check_correction<S, const N: usize, const M: usize>(system: &S, state: &State<[f64; N]>)
where
    S: System<Dims = Dims<N, M>>,
{
    let field = |state: &State<[f64; N]>, a: usize| {
        let mut dw = [0.0; M];
        dw[a] = 1.0;
        let noise = system.noise(state, &dw);
        [noise.q, noise.p].concat()
    };
    let mut expected = vec![0.0; 2 * N];
    for a in 0..M {
        let along = field(state, a);
        let change = derivatives(|d| {
            let mut moved = *state;
            for i in 0..N {
                moved.q[i] += d * along[i];
                moved.p[i] += d * along[N + i];
            }
            field(&moved, a)
        });
        for (sum, change) in expected.iter_mut().zip(change) {
            *sum += 0.5 * change;
        }
    }
    let found = system.ito_correction(state);
    for (found, expected) in [found.q, found.p].concat().iter().zip(expected) {
        assert!((found - expected).abs() < 1e-10, "{found}, not {expected}");
    }
}

#[test]
fn the_ito_correction_has_the_part_of_forces() {
    check_correction(&rubbed(), &State::at(0.3, [0.4], [-0.7]));
    check_correction(&sail(), &State::at(0.3, [0.4, -0.6], [0.7, 0.2]));
    let Rubbed { m: _, s } = rubbed();
    let found = rubbed().ito_correction(&State::new([0.4], [0.9])).p[0];
    let expected = 0.5 * (s[0] * s[0] + s[1] * s[1]) * 0.9;
    assert!((found - expected).abs() < 1e-15);
}

/// Checks a step of Euler and Maruyama's method, `z + h (drift + correction) + noise`.
fn check_euler<S, const N: usize, const M: usize>(system: &S, start: State<[f64; N]>, dw: [f64; M])
where
    S: System<Dims = Dims<N, M>>,
{
    let h = 0.01;
    let mut state = start;
    let method = EulerMaruyama::new(system);
    method.step(&mut state, h, &dw).unwrap();
    let (drift, noise) = (system.drift(&start).unwrap(), system.noise(&start, &dw));
    let correction = system.ito_correction(&start);
    for i in 0..N {
        let q = start.q[i] + h * (drift.q[i] + correction.q[i]) + noise.q[i];
        let p = start.p[i] + h * (drift.p[i] + correction.p[i]) + noise.p[i];
        let error = (state.q[i] - q).abs() + (state.p[i] - p).abs();
        assert!(error < 1e-15, "{state:?}: {error:e}");
    }
}

/// With straight-line code of the increment for `rubbed`, and by the derivatives of L for `sail`,
/// whose correction solves with the mass matrix.
#[test]
fn baselines_take_noise_forces() {
    check_euler(&rubbed(), State::at(0.3, [0.4], [-0.7]), [0.05, -0.02]);
    let start = State::at(0.3, [0.4, -0.6], [0.7, 0.2]);
    check_euler(&sail(), start, [0.05, -0.02, 0.07]);
}

/// Of a step of the endpoint rule on a free particle, `E[r] = 1 + ½σ²h` and
/// `E[r²] = 1 + 2σ²h + ¾(σ²h)²` for `r = 1 + y + ½y²`.
#[test]
fn an_ensemble_has_the_exact_means() {
    let (sigma, h, steps) = (0.8_f64, 0.05, 20_u8);
    let integrator = Integrator::new(Rubbing { sigma }, Endpoint);
    let summary = Ensemble::new(&integrator)
        .paths(20_000)
        .seed(5)
        .steps(h, steps.into())
        .start(State::new([0.3], [1.0]))
        .observe("p", |_, state| Ok(state.p[0]))
        .observe("p²", |_, state| Ok(state.p[0] * state.p[0]))
        .run()
        .unwrap();
    let variance = sigma * sigma * h;
    let first = 1.0 + 0.5 * variance;
    let second = 1.0 + 2.0 * variance + 0.75 * variance * variance;
    for (name, factor) in [("p", first), ("p²", second)] {
        let mean = *summary[name].mean().last().unwrap();
        let error = *summary[name].standard_error().last().unwrap();
        let expected = factor.powi(steps.into());
        let is_within = (mean - expected).abs() < 4.0 * error;
        assert!(
            is_within && error < 0.05 * expected,
            "{name}: {mean} ± {error}, not {expected}"
        );
    }
}
