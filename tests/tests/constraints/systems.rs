//! The systems under test, with a start each.

use sve_models::models::{
    Breathing, Curved, Ellipsoid, OnSphere, Saddle, Thermal, Torus, TurnedSphere, TwoRods,
};
use sve_runtime::prelude::*;
use sve_runtime::{ConstraintImpulses, Dims, System, Variational};

/// A chain of five rods of equal masses whose end is shaken.
#[derive(Clone, Debug)]
pub(crate) struct FiveRods {
    pub g: f64,
    pub s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl FiveRods {
    fn lagrangian(&self, q: [Vector2<f64>; 5], v: [Vector2<f64>; 5]) -> f64 {
        let mut energy = 0.0;
        for i in 0..5 {
            energy += 0.5 * v[i].norm_squared() - self.g * q[i].y;
        }
        energy
    }

    #[gamma]
    fn shake(&self, q: [Vector2<f64>; 5]) -> f64 {
        self.s * q[4].x
    }

    #[constraint]
    fn rods(&self, q: [Vector2<f64>; 5]) -> [f64; 5] {
        let mut rods = [0.5 * (q[0].norm_squared() - 1.0); 5];
        for i in 1..5 {
            rods[i] = 0.5 * ((q[i] - q[i - 1]).norm_squared() - 1.0);
        }
        rods
    }
}

/// What a test over all systems and rules does with each.
pub(crate) trait Check {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: sve_runtime::VectorCoordinates<N>;
}

fn all_rules<S, Q, const N: usize, const M: usize>(
    check: &mut impl Check,
    name: &str,
    system: &S,
    start: State<Q>,
) where
    S: System<Dims = Dims<N, M, Q>>
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Midpoint>
        + Variational<StormerVerlet>
        + ConstraintImpulses<InitialPoint>
        + ConstraintImpulses<Endpoint>
        + ConstraintImpulses<Midpoint>
        + ConstraintImpulses<StormerVerlet>,
    Q: sve_runtime::VectorCoordinates<N>,
{
    let midpoint = Integrator::new(system, Midpoint);
    let start = midpoint.consistent(start).unwrap();
    let initial_point = Integrator::new(system, InitialPoint);
    check.run(&format!("{name} initial_point"), &initial_point, start);
    check.run(
        &format!("{name} endpoint"),
        &Integrator::new(system, Endpoint),
        start,
    );
    check.run(&format!("{name} midpoint"), &midpoint, start);
    let verlet = Integrator::new(system, StormerVerlet);
    check.run(&format!("{name} stormer_verlet"), &verlet, start);
}

pub(crate) fn two_rods() -> TwoRods {
    TwoRods {
        m: [1.0, 0.5],
        l: [1.0, 0.7],
        g: 9.8,
        s: 0.3,
    }
}

/// All systems without a force.
pub(crate) fn conservative(check: &mut impl Check) {
    let q = [0.6, 0.0, -0.8];
    let p = [0.3, 0.9, 0.2];
    let [at, along] = [q, p].map(Vector3::from);
    all_rules(
        check,
        "sphere",
        &OnSphere { g: 1.3, s: 0.7 },
        State::new(q, p),
    );
    all_rules(
        check,
        "turned sphere",
        &TurnedSphere { s: 0.7 },
        State::new(q, p),
    );
    all_rules(
        check,
        "two rods",
        &two_rods(),
        State::new([0.9, -0.4, 0.6, -1.0], [0.2, 0.5, 0.4, 0.1]),
    );
    let torus = Torus {
        g: 1.0,
        a: 2.0,
        b: 0.7,
        s: 0.5,
    };
    all_rules(
        check,
        "torus",
        &torus,
        State::new(Vector3::new(2.5, 0.3, 0.4), along),
    );
    let ellipsoid = Ellipsoid {
        axes: [1.0, 2.0, 0.5],
        g: 1.0,
        s: 0.4,
    };
    all_rules(check, "ellipsoid", &ellipsoid, State::new(at, along));
    all_rules(
        check,
        "curved",
        &Curved { g: 1.0, s: 0.3 },
        State::new(at, along),
    );
    all_rules(
        check,
        "saddle",
        &Saddle { c: 0.3, s: 0.4 },
        State::new([0.5, -0.3, 0.0], p),
    );
    let breathing = Breathing {
        g: 1.0,
        d: 0.2,
        s: 0.4,
    };
    all_rules(check, "breathing", &breathing, State::at(0.4, at, along));
    let chain = FiveRods { g: 1.0, s: 0.3 };
    let place = |i: usize| Vector2::new(0.8 * (i + 1) as f64, -0.6 * ((i + 1) % 2) as f64);
    let q: [Vector2<f64>; 5] = core::array::from_fn(place);
    let p = [0.3, -0.2, 0.5, 0.1, -0.4].map(|x| Vector2::new(x, 0.5 - x));
    all_rules(check, "five rods", &chain, State::new(q, p));
}

/// All systems.
pub(crate) fn all(check: &mut impl Check) {
    conservative(check);
    let thermal = Thermal {
        g: 1.0,
        nu: 0.5,
        temperature: 1.0,
    };
    let start = State::new(Vector3::new(0.6, 0.0, -0.8), Vector3::new(0.3, 0.9, 0.2));
    all_rules(check, "thermal", &thermal, start);
}
