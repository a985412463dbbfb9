//! Inputs that are held over a step: closed forms, the system with parameters instead, gradients,
//! and bad inputs.

use sve_models::differences::derivative;
use sve_runtime::prelude::*;

use crate::noise_forces::poles::Driven as DrivenBead;

/// A particle that is pushed.
struct Pushed;

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2), gauss(4))]
impl Pushed {
    fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
        0.5 * v * v + u * q
    }
}

/// `∂p_N/∂u_k` = h and `∂q_N/∂u_k` = h² (N − k − w), with w = 0 for the initial point, 1 for the
/// endpoint, ½ for symmetric rules and their compositions.
#[test]
fn a_pushed_particle_has_the_derivatives_of_its_closed_form() {
    let (h, n) = (0.1, 7);
    macro_rules! check {
        ($($rule:expr => $w:expr),*) => {$(
            let pushed = Integrator::new(Pushed, $rule);
            let path = || {
                let start = State::at(0.3, [0.4], [-0.2]);
                pushed.trajectory(start, h, NoNoise).inputs(|k, _| 0.3 * k as f64)
            };
            let place = path().gradient(n, |k, state| (k == n).then(|| state.q[0])).unwrap();
            let momentum = path().gradient(n, |k, state| (k == n).then(|| state.p[0])).unwrap();
            assert_eq!(place.inputs().len(), n as usize);
            for (k, (q, p)) in place.inputs().zip(momentum.inputs()).enumerate() {
                let expected = h * h * (n as f64 - k as f64 - $w);
                assert!((q[0] - expected).abs() < 1e-15 && (p[0] - h).abs() < 1e-15, "{k} {q:?}");
            }
            assert!((place.start().p[0] - 0.7).abs() < 1e-15);
            let end = path().nth(n as usize - 1).unwrap().unwrap();
            assert!((place.loss() - end.q[0]).abs() < 1e-15);
        )*};
    }
    check!(
        InitialPoint => 0.0, Endpoint => 1.0, Midpoint => 0.5, StormerVerlet => 0.5,
        Gauss::<2> => 0.5, Gauss::<4> => 0.5, Composed::new(Midpoint, KahanLi8) => 0.5
    );
}

/// An oscillator whose mass and stiffness are inputs.
struct Tuned;

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2))]
impl Tuned {
    fn lagrangian(&self, q: f64, v: f64, u: [f64; 2]) -> f64 {
        0.5 * u[0] * v * v - 0.5 * u[1] * q * q
    }
}

/// Half the trace of the midpoint step is (1 − x)/(1 + x), x = w h²/(4m). The momentum is
/// continuous where the mass jumps, and the energy jumps by the work of the inputs.
#[test]
fn held_mass_and_stiffness() {
    let tuned = Integrator::new(Tuned, Midpoint);
    for (h, m, w) in [(0.1, 1.3, 0.8), (0.7, 0.4, 2.5)] {
        let held = tuned.holding(&[m, w]);
        let tangent = held.tangent(&State::new([0.3], [0.4]), h, &[]).unwrap();
        let x = w * h * h / (4.0 * m);
        let half_trace = 0.5 * (tangent[0][0] + tangent[1][1]);
        assert!((half_trace - (1.0 - x) / (1.0 + x)).abs() < 1e-15);
    }
    let state = State::new([0.7], [0.9]);
    let [before, after] = [[1.3, 0.8], [0.6, 2.0]];
    let energy = |u| tuned.holding(&u).system().hamiltonian(&state).unwrap();
    let work =
        0.5 * 0.81 * (1.0 / after[0] - 1.0 / before[0]) + 0.5 * 0.49 * (after[1] - before[1]);
    assert!((energy(after) - energy(before) - work).abs() < 1e-15);
    let held = tuned.holding(&after);
    let velocity = held.system().velocity(&state).unwrap();
    assert!((velocity[0] - 1.5).abs() < 1e-15);
    let same = State::from_velocity(held.system(), state.q, velocity).unwrap();
    assert!(same.q == state.q && (same.p[0] - 0.9).abs() < 1e-15);
}

/// A jump of mass and stiffness between steps leaves the order. A step back with the same inputs by
/// the adjoint rule returns, and the tangent map along the sequence keeps areas.
#[test]
fn inputs_that_jump_between_steps_keep_order_return_and_areas() {
    /// Rounding errors of some hundred substeps of size ε.
    const ROUNDING: f64 = 4e-15;
    let (h, start) = (0.1, State::new([0.7], [0.9]));
    let pieces = [[1.3, 0.8], [0.6, 2.0], [0.9, 1.1]];
    let exact = pieces
        .iter()
        .fold([0.7_f64, 0.9], |[q, p], [m, w]: &[f64; 2]| {
            let (sin, cos) = (w / m).sqrt().sin_cos();
            let impedance = (w * m).sqrt();
            [q * cos + p / impedance * sin, p * cos - impedance * q * sin]
        });
    macro_rules! check {
        ($($rule:expr, $adjoint:expr, $steps:expr => $order:expr;)*) => {$(
            let tuned = Integrator::new(Tuned, $rule);
            let error = |steps: u64| {
                let path = tuned.trajectory(start, 1.0 / steps as f64, NoNoise);
                let mut path = path.inputs(|k, _| pieces[(k / steps) as usize]);
                let end = path.advance(3 * steps).unwrap();
                (end.q[0] - exact[0]).hypot(end.p[0] - exact[1])
            };
            let order = (error($steps) / error(2 * $steps)).log2();
            assert!((order - $order).abs() < 0.02 * $order, "{order} for {}", $order);
            let (mut state, mut area) = (start, 1.0);
            for u in &pieces {
                let map = tuned.holding(u).tangent(&state, h, &[]).unwrap();
                area *= map[0][0] * map[1][1] - map[0][1] * map[1][0];
                tuned.step_with(&mut state, h, &[], u).unwrap();
            }
            assert!((area - 1.0_f64).abs() < ROUNDING, "{area}");
            let back = Integrator::new(Tuned, $adjoint);
            for u in pieces.iter().rev() {
                back.step_with(&mut state, -h, &[], u).unwrap();
            }
            let (q, p) = (state.q[0] - start.q[0], state.p[0] - start.p[0]);
            assert!(q.hypot(p) < ROUNDING, "{state:?}");
        )*};
    }
    let composed = Composed::new(Midpoint, KahanLi8);
    check!(
        Endpoint, InitialPoint, 400 => 1.0;
        Midpoint, Midpoint, 40 => 2.0;
        StormerVerlet, StormerVerlet, 40 => 2.0;
        Gauss::<2>, Gauss::<2>, 10 => 4.0;
        composed, composed, 2 => 8.0;
    );
}

/// A rotor whose noise has the sum of a parameter and an input as its strength. The Lagrangian
/// takes the input and does not read it.
struct Jittered {
    s: f64,
}

#[variational(endpoint, midpoint, stormer_verlet)]
impl Jittered {
    fn lagrangian(&self, q: f64, v: f64, _u: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
    #[h1]
    fn jitter(&self, q: f64, p: f64, u: f64) -> f64 {
        0.5 * (self.s + u) * p * p * (1.0 + 0.3 * q.sin())
    }
}

/// An input in H₁ is the parameter beside it, in steps and in gradients.
#[test]
fn inputs_of_noises_in_the_momentum() {
    let end_and_slopes = |rule: usize, s: f64, u: f64| {
        let start = State::new([0.4], [0.8]);
        let jittered = Jittered { s };
        macro_rules! of {
            ($rule:expr) => {{
                let jittered = Integrator::new(jittered, $rule);
                let path = jittered
                    .trajectory(start, 0.1, Wiener::new(2))
                    .inputs(|_, _| u);
                let loss = path.gradient(9, |k, state| (k == 9).then(|| state.q[0] + state.p[0]));
                let loss = loss.unwrap();
                let by_inputs: f64 = loss.inputs().map(|u| u[0]).sum();
                [loss.loss(), loss.get("s").unwrap(), by_inputs]
            }};
        }
        match rule {
            0 => of!(Endpoint),
            1 => of!(Midpoint),
            _ => of!(StormerVerlet),
        }
    };
    for rule in 0..3 {
        let [loss, by_s, by_u] = end_and_slopes(rule, 0.0, 0.6);
        let expected = end_and_slopes(rule, 0.6, 0.0);
        for (x, y) in [loss, by_s, by_u].iter().zip(expected) {
            assert!((x - y).abs() < 1e-14, "{rule}: {x} {y}");
        }
        assert!(
            (by_s - by_u).abs() < 1e-14 && by_s.abs() > 0.01,
            "{rule}: {by_s} {by_u}"
        );
    }
}

/// Without stiffness `∂q_N/∂m_k` = −h `p₀/m_k²`, by every rule.
#[test]
fn a_held_mass_has_the_derivative_of_its_closed_form() {
    let (h, n, p) = (0.1, 5, 0.9);
    let mass = |k: u64| 1.0 + 0.3 * k as f64;
    macro_rules! check {
        ($($rule:expr),*) => {$(
            let tuned = Integrator::new(Tuned, $rule);
            let path = tuned.trajectory(State::new([0.4], [p]), h, NoNoise);
            let path = path.inputs(|k, _| [mass(k), 0.0]);
            let place = path.gradient(n, |k, state| (k == n).then(|| state.q[0])).unwrap();
            for (k, by_input) in place.inputs().enumerate() {
                let expected = -h * p / mass(k as u64).powi(2);
                assert!((by_input[0] - expected).abs() < 1e-15, "{by_input:?}");
            }
        )*};
    }
    check!(InitialPoint, Endpoint, Midpoint, StormerVerlet, Gauss::<2>);
}

/// A cell of lenses ±1/f at the starts of drifts of length l: ½ tr = 1 − l²/(2f²).
#[test]
fn lenses_at_the_starts_of_steps() {
    let ring = Integrator::new(Tuned, InitialPoint);
    let (length, focal) = (1.1, 1.4);
    let images = [State::new([1.0], [0.0]), State::new([0.0], [1.0])].map(|mut state| {
        for sign in [1.0, -1.0] {
            // the lens has the strength 1/f over the whole step
            let input = [1.0, sign / (focal * length)];
            ring.step_with(&mut state, length, &[], &input).unwrap();
        }
        state
    });
    let half_trace = 0.5 * (images[0].q[0] + images[1].p[0]);
    let expected = 1.0 - length * length / (2.0 * focal * focal);
    assert!(
        (half_trace - expected).abs() < 1e-15,
        "{half_trace} {expected}"
    );
}

/// A push whose strength is an input.
pub(crate) struct Kicked;

#[variational(midpoint)]
impl Kicked {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v
    }
    #[gamma]
    fn push(&self, q: f64, u: f64) -> f64 {
        u * q
    }
}

/// A feedback that multiplies increments is non-anticipating: `p_N` = p₀ Π (1 + σ `ΔW_k`), as of
/// Itô.
#[test]
fn a_feedback_is_known_before_the_increments() {
    let (sigma, h, n) = (0.7, 0.1, 20);
    let kicked = Integrator::new(Kicked, Midpoint);
    let path = kicked.trajectory(State::new([0.0], [1.0]), h, Wiener::new(4));
    let end = path
        .inputs(|_, state| sigma * state.p[0])
        .nth(n - 1)
        .unwrap()
        .unwrap();
    let factors = (0..n as u64).map(|k| 1.0 + sigma * Wiener::new(4).increment(k, 0, h));
    let expected: f64 = factors.product();
    assert!(
        (end.p[0] - expected).abs() < 1e-13,
        "{} {expected}",
        end.p[0]
    );
}

/// A body with a torque as its input.
struct Body;

#[variational(midpoint, stormer_verlet)]
impl Body {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[force]
    fn torque(&self, _r: Rotation3<f64>, _w: Vector3<f64>, u: Vector3<f64>) -> Vector3<f64> {
        u
    }
}

/// Gradients by inputs of turning bodies and of beads on a sphere are those of differences.
#[test]
fn gradients_by_inputs_of_rotations_and_with_constraints() {
    macro_rules! check {
        ($system:expr, [$($rule:expr),*], $start:expr, $input:expr, |$state:ident| $loss:expr) => {$(
            let integrator = Integrator::new($system, $rule);
            let path = |changed: u64, i: usize, d: f64| {
                let path = integrator.trajectory($start, 0.1, Wiener::new(5));
                path.inputs(move |k, _| $input(k, i, if k == changed { d } else { 0.0 }))
            };
            let found = path(0, 0, 0.0).gradient(6, |k, $state| (k > 2).then(|| $loss));
            for (k, by_input) in found.unwrap().inputs().enumerate() {
                for (i, found) in by_input.iter().enumerate() {
                    let expected = derivative(|d| {
                        let states = path(k as u64, i, d).take(6).skip(2).map(Result::unwrap);
                        states.map(|$state| $loss).sum()
                    });
                    assert!((found - expected).abs() < 1e-11, "{k} {i}: {found} {expected}");
                    assert!(expected.abs() > 1e-5, "{k} {i}: {expected}");
                }
            }
        )*};
    }
    let turning = State::new(UnitQuaternion::identity(), Vector3::new(0.7, 1.1, -0.4));
    let torque = |k: u64, i: usize, d: f64| {
        let mut u = Vector3::new(0.3, -0.2, (k as f64).sin());
        u[i] += d;
        u
    };
    let arm = Vector3::new(0.5, -0.3, 0.8);
    check! {
        Body, [Midpoint, StormerVerlet], turning, torque,
        |s| (s.q * arm)[2] + s.p[0] * (s.q * arm)[0]
    }
    let bead = State::new([1.0, 0.0, 0.0], [0.0, 0.4, 0.3]);
    let strength = |k: u64, _: usize, d: f64| 0.5 * (k as f64).cos() + d;
    check! {
        DrivenBead, [Midpoint, StormerVerlet], bead, strength,
        |s| s.q[1] + s.p[0] * s.p[2]
    }
}

/// About a principal axis Π₁ = Π₀ + h u.
#[test]
fn inputs_of_bodies() {
    let axis = Vector3::new(0.0, 0.0, 1.0);
    let mut state = State::new(UnitQuaternion::identity(), 0.4 * axis);
    for k in 0..5 {
        let body = Integrator::new(Body, Midpoint);
        body.step_with(&mut state, 0.1, &[], &(f64::from(k) * axis))
            .unwrap();
    }
    assert!((state.p - 1.4 * axis).norm() < 1e-14);
    let reference = Integrator::new(&Body, StormerVerlet);
    reference.step_with(&mut state, 0.1, &[], &axis).unwrap();
    assert!((state.p - 1.5 * axis).norm() < 1e-14);
}

#[test]
fn an_input_that_is_not_finite_is_named() {
    let tuned = Integrator::new(Tuned, Midpoint);
    let start = State::new([0.3], [0.4]);
    for bad in [f64::NAN, f64::INFINITY] {
        let mut state = start;
        let error = tuned
            .step_with(&mut state, 0.1, &[], &[1.0, bad])
            .unwrap_err();
        let text = error.to_string();
        assert!(text.contains(&format!("u[1] is {bad}")), "{text}");
        assert_eq!(state, start);
        let path = tuned.trajectory(start, 0.1, NoNoise);
        let mut path = path.inputs(|k, _| [1.0, if k == 3 { bad } else { 0.5 }]);
        assert_eq!(path.by_ref().take(3).flatten().count(), 3);
        let error = path.next().unwrap().unwrap_err().to_string();
        assert!(
            error.contains("u[1]") && error.contains("t = 0.3"),
            "{error}"
        );
        assert!(path.next().is_none());
    }
}

#[test]
fn the_plan_names_inputs() {
    let plan = Integrator::new(Tuned, StormerVerlet).plan();
    assert_eq!(plan.system, "Tuned");
    assert!(plan.to_string().contains("u[0]·v²/2 − u[1]·q²/2"), "{plan}");
}
