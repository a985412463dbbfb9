//! Systems with a mistake: their uses give no errors of their own.

use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        v[0] * v[0] - self.g * q[0].abs()
    }

    #[gamma]
    fn push(&self, q: [f64; 1]) -> f64 {
        self.g * q[0]
    }
}

struct Bead;

#[variational(midpoint)]
impl Bead {
    fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        0.5 * v.norm_squared() - q.abs().x
    }

    #[symmetry]
    fn shift(&self, _q: Vector2<f64>) -> Vector2<f64> {
        Vector2::y()
    }
}

struct Beads;

#[variational(midpoint)]
impl Beads {
    fn lagrangian(&self, q: [SVector<f64, 3>; 2], v: [SVector<f64, 3>; 2]) -> f64 {
        0.5 * (v[0].norm_squared() + v[1].norm_squared()) - q[0].max()
    }
}

fn main() -> Result<(), StepError> {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
    let mut state = State::new([1.0], [0.0]);
    let _ = pendulum.step(&mut state, 0.1, &[0.5]);
    let _ = pendulum.plan().to_string();
    for state in pendulum.trajectory(state, 0.1, Wiener::new(1)).take(10) {
        let _ = state;
    }

    let bead = Integrator::new(Bead, Midpoint);
    let mut state = State::new(Vector2::x(), Vector2::y());
    bead.step(&mut state, 0.1, &[])?;
    println!("{} {}", bead.system().hamiltonian(&state)?, bead.system().shift_momentum(&state));

    let beads = Integrator::new(Beads, Midpoint);
    let mut state = State::new([Vector3::x(); 2], [Vector3::y(); 2]);
    beads.step(&mut state, 0.1, &[])?;
    let velocity: [Vector3<f64>; 2] = beads.system().velocity(&state)?;
    println!("{velocity:?}");

    without_prelude::integrator();
    Ok(())
}

#[no_implicit_prelude]
#[deny(warnings, unused)]
mod without_prelude {
    pub(super) struct Pendulum {
        pub(super) g: f64,
    }

    #[::sve_runtime::variational(midpoint)]
    impl Pendulum {
        #[must_use]
        fn lagrangian(&self, mut q: [f64; 1], v: [f64; 1]) -> f64 {
            q[0] *= self.g;
            let unused = 1.0;
            v[0] * v[0] - self.potential(q[0]).abs()
        }

        fn potential(&self, x: f64) -> f64 {
            self.g * x
        }
    }

    pub(super) fn integrator() {
        let _ = ::sve_runtime::Integrator::new(Pendulum { g: 1.0 }, ::sve_runtime::Midpoint);
    }
}
