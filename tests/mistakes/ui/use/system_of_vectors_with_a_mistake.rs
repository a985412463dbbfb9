//! Uses of a system of vectors with a mistake give no errors of their own.

use sve_runtime::prelude::*;

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
    let bead = Integrator::new(Bead, Midpoint);
    let mut state = State::new(Vector2::x(), Vector2::y());
    bead.step(&mut state, 0.1, &[])?;
    println!("{} {}", bead.system().hamiltonian(&state)?, bead.system().shift_momentum(&state));

    let beads = Integrator::new(Beads, Midpoint);
    let mut state = State::new([Vector3::x(); 2], [Vector3::y(); 2]);
    beads.step(&mut state, 0.1, &[])?;
    let velocity: [Vector3<f64>; 2] = beads.system().velocity(&state)?;
    println!("{velocity:?}");
    Ok(())
}
