//! Starts from velocities: p = ∂L/∂v, in the shape in which the Lagrangian is written.

mod refused;
mod singular;
mod systems;

use sve_models::models::Relativistic;
use sve_runtime::prelude::*;

/// A mass that depends on place and time.
struct Growing {
    m: f64,
}

#[variational(midpoint)]
impl Growing {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        0.5 * self.m * (1.0 + q * q + t) * v * v - q.ln()
    }
}

/// Bodies in a plane, with a magnetic field.
struct Bodies {
    m: [f64; 3],
    b: f64,
}

#[variational(midpoint)]
impl Bodies {
    fn lagrangian(&self, q: [[f64; 2]; 3], v: [[f64; 2]; 3]) -> f64 {
        let mut l = 0.0;
        for i in 0..3 {
            l += 0.5 * self.m[i] * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
            l += 0.5 * self.b * (q[i][0] * v[i][1] - q[i][1] * v[i][0]);
        }
        l
    }
}

/// A rigid body in space.
struct Body {
    m: f64,
    i: Vector3<f64>,
}

#[variational(midpoint)]
impl Body {
    fn lagrangian(
        &self,
        q: Vector3<f64>,
        _r: Rotation3<f64>,
        v: Vector3<f64>,
        w: Vector3<f64>,
    ) -> f64 {
        0.5 * self.m * v.norm_squared() + 0.5 * w.dot(&self.i.component_mul(&w)) - q.z
    }
}

/// A bead on a circle.
struct Bead {
    m: f64,
}

#[variational(midpoint)]
impl Bead {
    fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        0.5 * self.m * v.norm_squared() - q.y
    }

    #[constraint]
    fn circle(&self, q: Vector2<f64>) -> f64 {
        q.norm_squared() - 1.0
    }
}

/// A point vortex beside a mass, and a coordinate without a velocity.
struct Mixed;

#[variational(midpoint)]
impl Mixed {
    fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 {
        let h =
            0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]) + 0.5 * (q[3] - q[2]) * (q[3] - q[2]);
        q[1] * v[0] + v[2] * v[2] - h
    }
}

#[test]
fn the_momentum_is_that_of_the_velocity() -> Result<(), StepError> {
    let growing = Growing { m: 2.0 };
    assert_eq!(
        State::from_velocity(&growing, [2.0], [3.0])?,
        State::new([2.0], [30.0])
    );
    let later = State::from_velocity_at(&growing, 5.0, [2.0], [3.0])?;
    assert_eq!(later, State::at(5.0, [2.0], [60.0]));
    assert_eq!(growing.velocity(&later)?, [3.0]);
    // not quadratic in v, and borrowed
    let particle = &Relativistic {
        m: 2.0,
        c: 3.0,
        k: 1.0,
    };
    let state = State::from_velocity(particle, [0.5, 0.0], [1.8, 0.0])?;
    assert!((state.p[0] - 2.0 * 1.8 / 0.8).abs() < 1e-14);
    assert!((particle.velocity(&state)?[0] - 1.8).abs() < 1e-14);
    Ok(())
}

#[test]
fn bodies_keep_their_shape() -> Result<(), StepError> {
    let bodies = Integrator::new(
        Bodies {
            m: [1.0, 2.0, 4.0],
            b: 2.0,
        },
        Midpoint,
    );
    let q = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
    let v = [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]];
    let state = State::from_velocity(bodies.system(), q, v)?;
    assert_eq!(
        (state.q, state.p),
        (q, [[1.0, 3.0], [5.0, 8.0], [20.0, 24.0]])
    );
    assert_eq!(bodies.system().velocity(&state)?, v);
    Ok(())
}

#[test]
fn rotations_have_angular_velocities() -> Result<(), StepError> {
    let body = Body {
        m: 2.0,
        i: Vector3::new(1.0, 2.0, 3.0),
    };
    let at = (
        Vector3::x(),
        UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3),
    );
    let moving = (Vector3::y(), Vector3::new(0.5, 0.5, 0.5));
    let state = State::from_velocity(&body, at, moving)?;
    assert_eq!(state.q, at);
    assert_eq!(state.p, (2.0 * Vector3::y(), Vector3::new(0.5, 1.0, 1.5)));
    assert_eq!(body.velocity(&state)?, moving);
    Ok(())
}

#[test]
fn constrained_starts_are_projected_after_it() -> Result<(), StepError> {
    let bead = Integrator::new(Bead { m: 3.0 }, Midpoint);
    let start = State::from_velocity(bead.system(), Vector2::x(), Vector2::new(0.5, 1.0))?;
    assert_eq!(start.p, Vector2::new(1.5, 3.0));
    let start = bead.consistent(start)?;
    assert!((start.p - Vector2::new(0.0, 3.0)).norm() < 1e-14);
    Ok(())
}

#[test]
fn coordinates_without_mass_have_their_momenta() -> Result<(), StepError> {
    // the velocity of a coordinate without mass does not matter
    let state = State::from_velocity(&Mixed, [0.5, 2.0, 1.0, 1.0], [9.0, 9.0, 3.0, 9.0])?;
    assert_eq!(state.p, [2.0, 0.0, 6.0, 0.0]);
    let velocity = Mixed.velocity(&state)?;
    assert!((velocity[2] - 3.0).abs() < 1e-14);
    let error = State::from_velocity(&Mixed, [0.5, 2.0, 1.0, 1.5], [0.0; 4]).unwrap_err();
    assert!(matches!(error, StepError::Inconsistent { .. }), "{error}");
    Ok(())
}

#[test]
fn numbers_that_are_not_finite_are_errors() {
    let growing = Growing { m: 2.0 };
    let at = |t, q: f64, v: f64| State::from_velocity_at(&growing, t, [q], [v]).unwrap_err();
    for (error, name) in [
        (at(f64::NAN, 1.0, 1.0), "t"),
        (at(0.0, f64::INFINITY, 1.0), "q[0]"),
        (at(0.0, 1.0, f64::NAN), "v[0]"),
    ] {
        assert!(
            matches!(&error, StepError::NonFiniteInput { what, .. } if what == name),
            "{error}"
        );
    }
    // outside of the domain of L the derivative by v is finite
    let error = at(0.0, -1.0, 1.0);
    assert!(
        matches!(error, StepError::NonFiniteResult { .. }),
        "{error}"
    );
}

/// A table of torques over time, set between steps, is a Lagrangian with that torque in each step.
#[test]
fn parameters_change_between_steps() -> Result<(), StepError> {
    #[derive(Clone)]
    struct Driven {
        torque: f64,
    }

    #[variational(stormer_verlet)]
    impl Driven {
        fn lagrangian(&self, q: f64, v: f64) -> f64 {
            0.5 * v * v + q.cos() + self.torque * q
        }
    }

    let table = [0.5, -1.0, 2.0];
    let mut driven = Integrator::new(Driven { torque: 0.0 }, StormerVerlet);
    let (mut state, mut expected) = (State::new([0.3], [0.1]), State::new([0.3], [0.1]));
    for torque in table {
        driven.system_mut().torque = torque;
        driven.step(&mut state, 0.1, &[])?;
        Integrator::new(Driven { torque }, StormerVerlet).step(&mut expected, 0.1, &[])?;
    }
    assert_eq!(state, expected);
    Ok(())
}
