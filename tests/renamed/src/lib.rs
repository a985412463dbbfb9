//! The runtime under another name: `#[variational(…, crate = …)]`.

use sve::prelude::*;

/// A pendulum whose pivot is shaken.
#[derive(Clone, Debug)]
pub struct Pendulum {
    /// Gravity over length.
    pub g: f64,
}

#[variational(midpoint, endpoint, crate = sve)]
impl Pendulum {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }

    /// γ.
    #[gamma]
    pub fn shake(&self, q: f64) -> f64 {
        q.sin()
    }
}

/// The same with an absolute path.
#[derive(Clone, Debug)]
pub struct Rotor {
    /// Moment of inertia.
    pub inertia: f64,
}

#[variational(crate = ::sve, initial_point)]
impl Rotor {
    /// L.
    pub fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * self.inertia * v * v
    }
}

#[test]
fn steps() -> Result<(), StepError> {
    let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    let mut state = State::new([1.0], [0.0]);
    pendulum.step(&mut state, 0.01, &[0.02])?;
    assert!(state.p[0] < 0.0);

    let rotor = Integrator::new(Rotor { inertia: 2.0 }, InitialPoint);
    let mut state = State::new([0.0], [1.0]);
    rotor.step(&mut state, 0.5, &[])?;
    assert_eq!(state.q, [0.25]);
    Ok(())
}
