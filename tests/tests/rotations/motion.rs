//! Invariants of motions with rotations: momenta, Casimirs, energies; steps back; compositions;
//! energy and drift.

use sve_models::orders::numbers;
use sve_runtime::__private::Coordinates;
use sve_runtime::Variational;
use sve_runtime::nalgebra::Quaternion;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::starts::{attitude, body, pair, three};
use crate::systems::{
    DRIVEN, Driven, FreeBody, HeavyTop, I, NOISY_BODY, SYMMETRIC_TOP, SymmetricTop, TETHERED,
    THREE, TOP, Three,
};

/// Makes a step and the step back. Returns the largest difference from the start.
fn there_and_back<S, R, Q, const N: usize, const M: usize>(
    system: S,
    rule: R,
    start: State<Q>,
    dw: [f64; M],
) -> f64
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    R: Copy,
    Q: Coordinates<N>,
{
    let integrator = Integrator::new(system, rule);
    let mut state = start;
    integrator.step(&mut state, 0.2, &dw).unwrap();
    integrator.step(&mut state, -0.2, &dw.map(|w| -w)).unwrap();
    let (a, b) = (numbers(&start), numbers(&state));
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

#[test]
fn a_step_and_the_step_back_return_to_the_start() {
    let errors = [
        there_and_back(FreeBody { i: I }, Midpoint, body(), []),
        there_and_back(NOISY_BODY, Midpoint, body(), [0.3, -0.4]),
        there_and_back(TOP, Midpoint, body(), [0.5]),
        there_and_back(TETHERED, Midpoint, pair(), [0.4, -0.3]),
        there_and_back(THREE, Midpoint, three(), [0.4]),
        there_and_back(TOP, StormerVerlet, body(), [0.5]),
        there_and_back(SYMMETRIC_TOP, StormerVerlet, body(), [0.3, -0.2]),
        there_and_back(TETHERED, StormerVerlet, pair(), [0.4, -0.3]),
        there_and_back(THREE, StormerVerlet, three(), [0.4]),
    ];
    println!("{errors:?}");
    assert!(errors.iter().all(|&e| e < 1e-14), "{errors:?}");
}

/// Body momentum and spatial momentum of a body that noise drives through its momentum alone, over
/// 10⁶ steps.
#[test]
fn a_free_body_keeps_its_casimir_and_its_spatial_momentum() {
    let system = NOISY_BODY;
    let integrator = Integrator::new(system, Midpoint);
    let start = body();
    let (casimir, spatial) = (start.p.norm_squared(), start.q * start.p);
    let energy = system.hamiltonian(&start).unwrap();
    let mut errors = [0.0f64; 3];
    let mut change: f64 = 0.0;
    let path = integrator.trajectory(start, 0.05, Wiener::new(7));
    for state in path.take(1_000_000) {
        let state = state.unwrap();
        errors[0] = errors[0].max((state.p.norm_squared() / casimir - 1.0).abs());
        errors[1] = errors[1].max((state.q * state.p - spatial).norm() / spatial.norm());
        errors[2] = errors[2].max((state.q.norm() - 1.0).abs());
        change = change.max((system.hamiltonian(&state).unwrap() - energy).abs());
    }
    println!(
        "Casimir {:e}, spatial momentum {:e}, length {:e}, energy {change}",
        errors[0], errors[1], errors[2]
    );
    assert!(errors.iter().all(|&e| e < 1e-12), "{errors:?}");
    assert!(change > 0.1, "the noise works");
}

#[test]
fn momenta_of_symmetries_are_kept() {
    assert_momenta_of_symmetries_are_kept(Midpoint);
    assert_momenta_of_symmetries_are_kept(StormerVerlet);
}

fn assert_momenta_of_symmetries_are_kept<R: Copy>(rule: R)
where
    SymmetricTop: Variational<R>,
    Three: Variational<R>,
{
    let system = SYMMETRIC_TOP;
    let integrator = Integrator::new(system, rule);
    let start = body();
    let spatial = (start.q * start.p).z;
    assert!((system.vertical_momentum(&start) - spatial).abs() < 1e-15);
    assert!((system.figure_axis_momentum(&start) - start.p.z).abs() < 1e-15);
    let mut worst: f64 = 0.0;
    let mut state = start;
    for step in 0..3000 {
        let dw = [0, 1].map(|process| Wiener::new(3).increment(step, process, 0.05));
        integrator.step(&mut state, 0.05, &dw).unwrap();
        worst = worst.max((system.vertical_momentum(&state) - spatial).abs());
        worst = worst.max((state.p.z - start.p.z).abs());
    }
    println!("{worst:e}");
    assert!(worst < 1e-13, "{worst:e}");

    let system = Three { s: 0.0, ..THREE };
    let start = three();
    let before = system.together_momentum(&start);
    let mut state = start;
    let integrator = Integrator::new(system, rule);
    for _ in 0..1000 {
        integrator.step(&mut state, 0.05, &[0.0]).unwrap();
    }
    assert!((system.together_momentum(&state) - before).abs() < 1e-13);
}

/// The energy of a heavy top without noise oscillates and does not drift; the vertical momentum
/// stays.
#[test]
fn the_energy_of_a_heavy_top_does_not_drift() {
    let system = HeavyTop { s: 0.0, ..TOP };
    let integrator = Integrator::new(system, Midpoint);
    let mut state = body();
    let (energy, vertical) = (system.hamiltonian(&state).unwrap(), (state.q * state.p).z);
    let (mut early, mut late, mut drift): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for step in 0..20_000 {
        integrator.step(&mut state, 0.1, &[0.0]).unwrap();
        let error = (system.hamiltonian(&state).unwrap() - energy).abs();
        if step < 2000 {
            early = early.max(error);
        } else {
            late = late.max(error);
        }
        drift = drift.max(((state.q * state.p).z - vertical).abs());
    }
    println!("{early:e} {late:e} {drift:e}");
    assert!(late < 1.2 * early && early < 0.1);
    assert!(drift < 1e-12, "{drift:e}");
}

/// Energy, velocity and drift against the user's functions and the equations of motion.
#[test]
fn mechanics_of_a_body() {
    let system = TOP;
    let state = body();
    let w = system.velocity(&state).unwrap();
    assert!((w - state.p.component_div(&I)).norm() < 1e-15);
    let matrix = state.q.to_rotation_matrix();
    let energy = state.p.dot(&w) - system.lagrangian(matrix, w);
    assert!((system.hamiltonian(&state).unwrap() - energy).abs() < 1e-14);
    // gravity turns the axis: the torque is − weight e₃ × Rᵀe₃
    let torque = -system.weight * Vector3::z().cross(&(matrix.inverse() * Vector3::z()));
    let drift = system.drift(&state).unwrap();
    assert!((drift.q - w).norm() < 1e-15);
    assert!((drift.p - (state.p.cross(&w) + torque)).norm() < 1e-14);
    // the derivative of the drift along the motion, by the motion itself
    let integrator = Integrator::new(HeavyTop { s: 0.0, ..system }, Midpoint);
    let acceleration = system.acceleration(&state).unwrap();
    let field = |h: f64| {
        let mut state = state;
        for _ in 0..4 {
            integrator.step(&mut state, h / 4.0, &[0.0]).unwrap();
        }
        system.drift(&state).unwrap()
    };
    let h = 1e-3;
    let (ahead, behind) = (field(h), field(-h));
    let slope = [
        (ahead.q - behind.q) / (2.0 * h),
        (ahead.p - behind.p) / (2.0 * h),
    ];
    assert!((slope[0] - acceleration.q).norm() < 1e-5 && (slope[1] - acceleration.p).norm() < 1e-5);
}

/// The equations of motion with noise that depends on both, by small steps.
#[test]
fn noise_of_a_body_is_that_of_a_small_step() {
    let system = SYMMETRIC_TOP;
    let integrator = Integrator::new(system, Midpoint);
    let start = body();
    let dw = [2e-4, -3e-4];
    let noise = system.noise(&start, &dw);
    // the drift of so small a step is far below the noise
    let mut state = start;
    integrator.step(&mut state, 1e-14, &dw).unwrap();
    let turned = crate::charts::cayley_vector(&(start.q.inverse() * state.q));
    assert!((turned - noise.q).norm() < 1e-7, "{turned} {}", noise.q);
    assert!((state.p - start.p - noise.p).norm() < 1e-7);
}

/// A composition of order 8 of the symmetric midpoint rule.
#[test]
fn a_composition_has_order_eight() {
    let system = HeavyTop { s: 0.0, ..TOP };
    let integrator = Integrator::new(system, Composed::new(Midpoint, KahanLi8));
    let end = |steps: u32| {
        let mut state = body();
        for _ in 0..steps {
            integrator
                .step(&mut state, 1.0 / f64::from(steps), &[0.0])
                .unwrap();
        }
        state
    };
    let exact = end(64);
    let error = |steps: u32| {
        (end(steps).q.coords - exact.q.coords).norm() + (end(steps).p - exact.p).norm()
    };
    let errors = [error(2), error(4), error(8)];
    println!("{errors:?}");
    let order = (errors[1] / errors[2]).log2();
    assert!(order > 7.0, "{order}");
}

#[test]
fn friction_takes_energy_and_a_torque_gives_it() {
    let damped = Driven {
        torque: 0.0,
        ..DRIVEN
    };
    let integrator = Integrator::new(damped, Midpoint);
    let mut state = body();
    for _ in 0..4000 {
        integrator.step(&mut state, 0.05, &[]).unwrap();
    }
    // at rest with its axis downwards
    assert!((damped.hamiltonian(&state).unwrap() + 2.0).abs() < 1e-9);
    // a small step approximates the drift with the torque
    let (start, h) = (body(), 1e-6);
    let mut state = start;
    let driven = Integrator::new(DRIVEN, Midpoint);
    driven.step(&mut state, h, &[]).unwrap();
    let rate = (state.p - start.p) / h;
    assert!((rate - DRIVEN.drift(&start).unwrap().p).norm() < 1e-5);
}

#[test]
fn a_step_that_turns_too_far_is_an_error() {
    let integrator = Integrator::new(FreeBody { i: I }, Midpoint);
    let start = State::new(attitude(0.1, 0.2, 0.3), Vector3::new(30.0, 0.1, -0.2));
    let mut state = start;
    let error = integrator.step(&mut state, 0.75, &[]).unwrap_err();
    assert!(matches!(error, StepError::LargeRotation { .. }), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("h = 7.5e-1") && text.contains("smaller h"),
        "{text}"
    );
    assert_eq!(state, start);
    integrator.step(&mut state, 0.1, &[]).unwrap();
    assert!((state.q.norm() - 1.0).abs() < 1e-15);
}

#[test]
fn a_quaternion_that_is_not_finite_is_an_error() {
    let integrator = Integrator::new(FreeBody { i: I }, Midpoint);
    let broken = UnitQuaternion::new_unchecked(Quaternion::new(1.0, f64::NAN, 0.0, 0.0));
    let mut state = State::new(broken, Vector3::new(0.1, 0.2, 0.3));
    let error = integrator.step(&mut state, 0.1, &[]).unwrap_err();
    assert!(error.to_string().contains("q[1] is NaN"), "{error}");
}

/// An isotropic body under a torque that turns with it.
struct Sphere;

#[variational(midpoint, stormer_verlet)]
impl Sphere {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.65 * w.norm_squared()
    }
    #[force(noise)]
    fn torque(&self, _r: Rotation3<f64>, _w: Vector3<f64>) -> Vector3<f64> {
        Vector3::new(0.3, -0.2, 0.5)
    }
}

/// `Π_N` = Π₀ + f `W_N`, path by path: the momentum of an isotropic body is parallel to its
/// velocity, so that nothing turns it.
#[test]
fn a_torque_of_the_body_adds_its_increments_to_the_momentum() {
    let torque = Vector3::new(0.3, -0.2, 0.5);
    let State { q, .. } = body();
    for p in [Vector3::zeros(), 0.7 * torque, Vector3::new(0.7, 1.1, -0.4)] {
        let mut total = 0.0;
        let (mut midpoint, mut verlet) = (State::new(q, p), State::new(q, p));
        for step in 0..200 {
            let dw = [Wiener::new(3).increment(step, 0, 0.02)];
            total += dw[0];
            Integrator::new(Sphere, Midpoint)
                .step(&mut midpoint, 0.02, &dw)
                .unwrap();
            Integrator::new(Sphere, StormerVerlet)
                .step(&mut verlet, 0.02, &dw)
                .unwrap();
        }
        let expected = p + torque * total;
        // each of the 200 steps rounds a momentum below 3 twice, by half a unit
        let bound = 200.0 * 3.0 * f64::EPSILON;
        for state in [midpoint, verlet] {
            let error = (state.p - expected).norm();
            assert!(error < bound, "{error:e}: {state:?} {expected}");
        }
    }
}

#[test]
fn plans_name_the_attitudes_of_their_nodes() {
    let plan = Integrator::new(TOP, StormerVerlet).plan().to_string();
    assert!(
        plan.contains("R₀[2, 1]") && plan.contains("R₁[2, 1]"),
        "{plan}"
    );
    assert!(!plan.contains("R̄["), "{plan}");
    let plan = Integrator::new(TOP, Midpoint).plan().to_string();
    assert!(plan.contains("R̄[2, 1]") && !plan.contains("R₁["), "{plan}");
}
