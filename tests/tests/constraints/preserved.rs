//! Quantities that long paths keep: the constraints, momenta of symmetries, the energy without
//! drift; and the exact path of a rotation.

use sve_runtime::__private::{ConstraintImpulses, VectorCoordinates};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::systems::{Check, all};

/// A spherical pendulum with its symmetry.
struct Turning {
    g: f64,
    s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Turning {
    fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    #[gamma]
    fn lift(&self, q: Vector3<f64>) -> f64 {
        self.s * q.z.sin()
    }

    #[symmetry]
    fn turn(&self, q: Vector3<f64>) -> Vector3<f64> {
        Vector3::new(-q.y, q.x, 0.0)
    }

    #[constraint]
    fn sphere(&self, q: Vector3<f64>) -> f64 {
        0.5 * (q.norm_squared() - 1.0)
    }
}

/// The largest φ, relative to its terms, and the largest rate of φ.
fn violations<S, Q, const N: usize, const M: usize>(system: &S, state: &State<Q>) -> [f64; 2]
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let velocity = system.velocity(state).unwrap();
    let v = Q::components(&velocity);
    let [mut phi, mut psi] = [0.0f64; 2];
    system.constraint_jets(state.t, &state.q.coordinates(), &mut |jet| {
        phi = phi.max(jet.value.abs() / jet.magnitude);
        let rate: f64 = jet.dq.iter().zip(&v).map(|(a, b)| a * b).sum();
        psi = psi.max((rate + jet.dt).abs());
    });
    [phi, psi]
}

struct OnConstraints;

impl Check for OnConstraints {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let [mut phi, mut psi] = [0.0f64; 2];
        for state in integrator
            .trajectory(start, 0.01, Wiener::new(3))
            .take(1000)
        {
            let state = state.unwrap_or_else(|e| panic!("{name}: {e}"));
            let found = violations(integrator.system(), &state);
            phi = phi.max(found[0]);
            psi = psi.max(found[1]);
        }
        println!("{name}: {phi:e} {psi:e}");
        // the equation of the torus has differences of coordinates, which amplify rounding errors
        assert!(phi < 5e-15 && psi < 5e-15, "{name}: {phi:e} {psi:e}");
    }
}

#[test]
fn paths_stay_on_the_constraints_to_rounding() {
    all(&mut OnConstraints);
}

fn moment_and_energy<R>(rule: R, bound: f64)
where
    Turning: Variational<R>,
{
    // a momentum is kept to rounding with noise too
    let integrator = Integrator::new(Turning { g: 1.0, s: 0.3 }, rule);
    let system = integrator.system();
    let start = State::new(Vector3::new(0.6, 0.0, -0.8), Vector3::new(0.2, 0.9, 0.15));
    let moment = system.turn_momentum(&start);
    let path = integrator.trajectory(start, 0.1, Wiener::new(1)).take(2000);
    let worst = path.map(|state| (system.turn_momentum(&state.unwrap()) - moment).abs());
    let worst = worst.fold(0.0, f64::max);
    println!("L_z {worst:e}");
    assert!(worst < 2e-14, "{worst:e}");
    assert_eq!(integrator.plan().conserved, ["turn_momentum"]);
    // the energy does not drift: the second half of a long path is no worse than the first
    let energy = system.hamiltonian(&start).unwrap();
    let (mut halves, mut state) = ([0.0f64; 2], start);
    for half in &mut halves {
        for _ in 0..5000 {
            integrator.step(&mut state, 0.1, &[0.0]).unwrap();
            *half = half.max((system.hamiltonian(&state).unwrap() - energy).abs());
        }
    }
    println!("energy {halves:?}");
    assert!(
        halves[0] < bound && halves[1] < 1.02 * halves[0],
        "{halves:?}"
    );
}

#[test]
fn momenta_are_kept_and_energy_does_not_drift() {
    moment_and_energy(InitialPoint, 6e-2);
    moment_and_energy(Endpoint, 6e-2);
    moment_and_energy(Midpoint, 2e-3);
    moment_and_energy(StormerVerlet, 2e-3);
}
