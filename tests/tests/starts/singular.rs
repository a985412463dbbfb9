//! Starts at which no isolated velocity has the momentum: no rule makes a step from them, in single
//! steps, along trajectories, with derivatives and in ensembles, and all rules say the same. Near
//! them steps are made.

use sve_models::random::Random;
use sve_runtime::__private::Increments;
use sve_runtime::ensemble::Cause;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{MomentumVelocities, Variational};

use crate::refused::refused;
use crate::systems::{Coupled, Fold, Gram, Mass, Polar, Quartic, Ray, Vanishing};

/// Checks that all rules give the same error. Returns it.
fn same(errors: &[StepError]) -> StepError {
    for error in errors {
        assert_eq!(error, &errors[0]);
    }
    errors[0].clone()
}

/// The row, the relative pivot and the velocities of an error that names a singular mass matrix.
fn singular(error: &StepError) -> (usize, f64, MomentumVelocities) {
    match error {
        StepError::SingularMass { found, .. } => {
            let (pivot, terms) = (found.pivot, found.terms);
            let relative = if pivot == 0.0 { 0.0 } else { pivot / terms };
            (found.row, relative, found.velocities)
        }
        other => panic!("{other}"),
    }
}

#[test]
fn a_mass_of_zero() {
    for (p, expected) in [
        (0.5, MomentumVelocities::None { distance: 0.5 }),
        (0.0, MomentumVelocities::Many),
    ] {
        // the mass belongs to the system, so no path of an ensemble has a start
        let method = Integrator::new(Mass { m: 0.0 }, Midpoint);
        let start = State::at(2.0, [1.0], [p]);
        let summary = Ensemble::new(&method)
            .paths(40)
            .steps(0.01, 2)
            .start(Starts::each(|_, _| start))
            .run()
            .unwrap();
        assert_eq!(summary.failed(), 40);
        let mut errors = Vec::new();
        macro_rules! rules {
            ($($rule:expr),*) => {$({
                let method = Integrator::new(Mass { m: 0.0 }, $rule);
                let mut state = start;
                errors.push(method.step(&mut state, 0.01, &Increments::NONE).unwrap_err());
                assert_eq!(state, start);
                let path = method.trajectory(start, 0.01, Wiener::new(1)).take(1);
                errors.extend(path.map(Result::unwrap_err));
            })*};
        }
        rules!(
            InitialPoint,
            Endpoint,
            Midpoint,
            StormerVerlet,
            Gauss::<2>,
            Gauss::<4>,
            Weak2(Midpoint),
            StageNoise(Gauss::<2>),
            Split::new(BlanesMoan4),
            Composed::new(StormerVerlet, KahanLi8)
        );
        let of_composition = errors.split_off(errors.len() - 4);
        for error in of_composition {
            assert_eq!(singular(&error), (0, 0.0, expected));
        }
        let error = same(&errors);
        assert_eq!(singular(&error), (0, 0.0, expected));
        let text = error.to_string();
        for part in [
            "t = 2",
            "q = [1.0]",
            "h = 1e-2",
            "p[0]",
            "mass matrix",
            &format!("p = [{p:?}]"),
        ] {
            assert!(text.contains(part), "{text}");
        }
        for failure in summary.failures() {
            assert_eq!(failure.cause, Cause::Step(error.clone()));
        }
        let compensated = Integrator::new(Mass { m: 0.0 }, StormerVerlet);
        let mut path = compensated
            .trajectory(start, 0.01, Wiener::new(1))
            .compensated();
        assert_eq!(path.next(), Some(Err(error.clone())));
    }
}

#[test]
fn velocities_with_one_momentum() {
    let at = |p| State::new([1.0, 0.3], p);
    for p in [[0.2, 0.1], [0.2, 0.2]] {
        let mut errors = Vec::new();
        macro_rules! rules {
            ($($rule:expr),*) => {$({
                let method = Integrator::new(Coupled { a: 1.0 }, $rule);
                let mut state = at(p);
                errors.push(method.step(&mut state, 0.01, &[]).unwrap_err());
                let near = Integrator::new(Coupled { a: 1.0 - 1e-12 }, $rule);
                near.step(&mut at([0.2, 0.2]), 1e-9, &[]).unwrap();
            })*};
        }
        rules!(
            InitialPoint,
            Endpoint,
            Midpoint,
            StormerVerlet,
            Gauss::<2>,
            Gauss::<4>
        );
        let (_, pivot, velocities) = singular(&same(&errors));
        assert_eq!(pivot, 0.0);
        if p[0] == p[1] {
            assert_eq!(velocities, MomentumVelocities::Many);
        } else {
            assert!(
                matches!(velocities, MomentumVelocities::None { distance } if (distance - 0.1).abs() < 1e-15),
                "{velocities:?}"
            );
        }
    }
}

#[test]
fn a_mass_that_vanishes_at_a_place() {
    let good = State::new([1.0], [0.3]);
    for (p, expected) in [
        (1.0, MomentumVelocities::None { distance: 1.0 }),
        (0.0, MomentumVelocities::Many),
    ] {
        let bad = State::new([0.0], [p]);
        let errors = [
            refused(Vanishing, InitialPoint, bad, good),
            refused(Vanishing, Endpoint, bad, good),
            refused(Vanishing, Midpoint, bad, good),
            refused(Vanishing, StormerVerlet, bad, good),
            refused(Vanishing, Gauss::<2>, bad, good),
            refused(Vanishing, Gauss::<4>, bad, good),
            refused(Vanishing, Taylor2, bad, good),
            refused(&Vanishing, Midpoint, bad, good),
        ];
        assert_eq!(singular(&same(&errors)), (0, 0.0, expected));
        assert_eq!(
            singular(&Vanishing.velocity(&bad).unwrap_err()),
            (0, 0.0, expected)
        );
    }
}

#[test]
fn the_pole_of_polar_coordinates() {
    let good = State::new([1.0, 0.3], [0.5, 0.2]);
    for (p, expected) in [
        (0.2, MomentumVelocities::None { distance: 0.2 }),
        (0.0, MomentumVelocities::Many),
    ] {
        let bad = State::new([0.0, 0.3], [0.5, p]);
        let errors = [
            refused(Polar, InitialPoint, bad, good),
            refused(Polar, Endpoint, bad, good),
            refused(Polar, Midpoint, bad, good),
            refused(Polar, StormerVerlet, bad, good),
            refused(Polar, Gauss::<2>, bad, good),
            refused(Polar, Gauss::<4>, bad, good),
            refused(Polar, Weak2(StormerVerlet), bad, good),
            refused(Polar, StageNoise(Gauss::<4>), bad, good),
        ];
        assert_eq!(singular(&same(&errors)), (1, 0.0, expected));
    }
    // next to the pole nothing is refused by the test of the start: the explicit parts of steps are
    // made
    let near = State::new([1e-3, 0.3], [0.5, 1e-9]);
    Integrator::new(Polar, Endpoint)
        .step(&mut { near }, 1e-4, &[0.0])
        .unwrap();
}

fn random_rows<const N: usize>(random: &mut Random) -> [[f64; N]; N] {
    core::array::from_fn(|_| random.array(-1.0, 1.0))
}

#[test]
fn random_mass_matrices_that_lose_a_rank_at_a_place() {
    let mut random = Random::new(5);
    for _ in 0..4 {
        let (b, c) = (random_rows(&mut random), random.array::<1>(-1.0, 1.0)[0]);
        let fold = || Fold { b, c };
        let [mut q, p]: [[f64; 5]; 2] = core::array::from_fn(|_| random.array(-1.0, 1.0));
        q[0] = c;
        let bad = State::new(q, p);
        q[0] = c + 2.0;
        let good = State::new(q, p.map(|p| 0.1 * p));
        let errors = [
            refused(fold(), Endpoint, bad, good),
            refused(fold(), Midpoint, bad, good),
            refused(fold(), StormerVerlet, bad, good),
            refused(fold(), Gauss::<2>, bad, good),
            refused(fold(), Gauss::<4>, bad, good),
        ];
        let (_, _, velocities) = singular(&same(&errors));
        assert!(
            matches!(velocities, MomentumVelocities::None { .. }),
            "{velocities:?}"
        );
    }
}

fn steps<R>(gram: &Gram, rule: R, start: State<[f64; 3]>) -> Result<State<[f64; 3]>, StepError>
where
    Gram: Variational<R> + System<Dims = Dims<3, 0>>,
{
    let (method, mut state) = (Integrator::new(gram.clone(), rule), start);
    let h = 1e-3;
    method.step(&mut state, h, &[])?;
    let mut path = method.trajectory(start, h, NoNoise);
    assert_eq!(path.next().unwrap()?.t, h);
    Ok(state)
}

#[test]
fn random_mass_matrices_of_parameters() {
    let mut random = Random::new(9);
    for _ in 0..200 {
        let mut b: [[f64; 3]; 3] = random_rows(&mut random);
        let start = State::new(random.array(-1.0, 1.0), random.array(-1.0, 1.0));
        let [x, y] = random.array(-2.0, 2.0);
        b[2] = core::array::from_fn(|i| x * b[0][i] + y * b[1][i]);
        let singular_gram = Gram { b };
        macro_rules! rules {
            ($($rule:expr),*) => {$({
                let error = steps(&singular_gram, $rule, start).unwrap_err();
                let (_, pivot, velocities) = singular(&error);
                // the rounding errors of three rows of sums
                assert!(pivot < 192.0 * f64::EPSILON, "{error}");
                assert!(matches!(velocities, MomentumVelocities::None { .. }), "{error}");
                // masses in units of 2^±60
                for unit in [30.0_f64.exp2(), (-30.0_f64).exp2()] {
                    let b = b.map(|row| row.map(|x| unit * x));
                    let error = steps(&Gram { b }, $rule, start).unwrap_err();
                    assert!(matches!(error, StepError::SingularMass { .. }), "{error}");
                }
            })*};
        }
        rules!(Endpoint, Midpoint, StormerVerlet, Gauss::<2>, Gauss::<4>);
    }
}

/// A mass of 10⁻¹², and masses in units of 2^±60, are legal: positions have the bits of the closed
/// form in these units.
#[test]
fn small_masses_step() {
    for m in [
        1e-12,
        60.0_f64.exp2(),
        (-60.0_f64).exp2(),
        f64::MIN_POSITIVE,
    ] {
        let (h, q, p) = (0.01, 1.0, 0.3 * m);
        let mut state = State::new([q], [p]);
        Integrator::new(Mass { m }, Endpoint)
            .step(&mut state, h, &[0.0])
            .unwrap();
        let end = q + h * (p / m);
        assert!((state.q[0] - end).abs() <= 2.0 * f64::EPSILON, "{m:e}");
        assert_eq!(state.p[0], p - h * state.q[0]);
        for error in [
            Integrator::new(Mass { m }, Midpoint).step(&mut { state }, 1e-9, &[0.0]),
            Integrator::new(Mass { m }, StormerVerlet).step(&mut { state }, 1e-9, &[0.0]),
            Integrator::new(Mass { m }, Gauss::<2>).step(&mut { state }, 1e-9, &[0.0]),
        ] {
            let is_refused = matches!(error, Err(StepError::SingularMass { .. }));
            assert!(!is_refused, "{m:e}");
        }
    }
}

#[test]
fn a_momentum_that_no_velocity_has() {
    let good = State::new([0.3], [1.2]);
    let bad = State::new([0.3], [2.0]);
    let errors = [
        refused(Ray, InitialPoint, bad, good),
        refused(Ray, Endpoint, bad, good),
        refused(Ray, Midpoint, bad, good),
        refused(Ray, StormerVerlet, bad, good),
        refused(Ray, Gauss::<2>, bad, good),
        refused(Ray, Gauss::<4>, bad, good),
        refused(Ray, StageNoise(Gauss::<2>), bad, good),
        refused(Ray, Composed::new(Midpoint, KahanLi8), bad, good),
    ];
    let StepError::NoVelocity { q, p, distance, .. } = same(&errors) else {
        panic!("{}", errors[0]);
    };
    assert_eq!((q.as_slice(), p.as_slice()), (&[0.3][..], &[2.0][..]));
    // ∂L/∂v is below n = 1.473
    assert!((distance - (2.0 - 1.473)).abs() < 1e-9, "{distance}");
    assert_eq!(
        Ray.velocity(&bad).map_err(|e| e.to_string()),
        Err(errors[0].to_string())
    );
    // up to the bound there are velocities
    for p in [1.4, 1.47, 1.4729] {
        let mut state = State::new([0.3], [p]);
        Integrator::new(Ray, StormerVerlet)
            .step(&mut state, 1e-6, &[0.0])
            .unwrap_or_else(|error| panic!("{p}: {error}"));
    }
    for p in [1.4731, 1.5, 1e3] {
        let error = Integrator::new(Ray, Midpoint).step(&mut State::new([0.3], [p]), 1e-6, &[0.0]);
        assert!(
            matches!(error, Err(StepError::NoVelocity { .. })),
            "{p}: {error:?}"
        );
    }
}

/// A velocity of zero has the momentum, and the mass matrix is singular there: the solutions of a
/// step are no differentiable function of its start.
#[test]
fn a_mass_that_vanishes_at_rest() {
    let good = State::new([0.3], [8.0]);
    let bad = State::new([0.3], [0.0]);
    let errors = [
        refused(Quartic, InitialPoint, bad, good),
        refused(Quartic, Endpoint, bad, good),
        refused(Quartic, Midpoint, bad, good),
        refused(Quartic, StormerVerlet, bad, good),
        refused(Quartic, Gauss::<2>, bad, good),
        refused(Quartic, Gauss::<4>, bad, good),
    ];
    let error = same(&errors);
    let of_composition = refused(Quartic, Composed::new(Midpoint, KahanLi8), bad, good);
    assert_eq!(singular(&of_composition), singular(&error));
    assert_eq!(singular(&error), (0, 0.0, MomentumVelocities::Rest));
    assert!(
        error.to_string().contains("rest has the momentum"),
        "{error}"
    );
    for p in [1e-3, -1e-6, 1e-9] {
        Integrator::new(Quartic, Endpoint)
            .step(&mut State::new([0.3], [p]), 0.01, &[])
            .unwrap();
    }
}

/// A rigid body without mass, or without inertia about an axis.
#[test]
fn bodies_without_mass_or_inertia() {
    let start = State::new(
        (Vector3::x(), UnitQuaternion::identity()),
        (Vector3::y(), Vector3::new(0.5, 0.5, 0.5)),
    );
    for (m, i, expected) in [
        (0.0, Vector3::new(1.0, 2.0, 3.0), 1),
        (2.0, Vector3::new(1.0, 0.0, 3.0), 4),
    ] {
        let method = Integrator::new(super::Body { m, i }, Midpoint);
        let mut state = start;
        let error = method.step(&mut state, 0.01, &[]).unwrap_err();
        let (row, _, velocities) = singular(&error);
        assert_eq!(row, expected);
        assert!(
            matches!(velocities, MomentumVelocities::None { .. }),
            "{error}"
        );
        assert_eq!(state, start);
    }
    let i = Vector3::new(1.0, 2.0, 3.0);
    let method = Integrator::new(super::Body { m: 2.0, i }, Midpoint);
    assert_eq!(method.step(&mut { start }, 0.01, &[]), Ok(()));
}
