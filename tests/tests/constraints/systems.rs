//! The systems under test, with a start each.

use sve_models::models::{
    Breathing, Curved, Ellipsoid, OnSphere, Saddle, Thermal, Torus, TurnedSphere, TwoRods,
};
use sve_models::random::Random;
use sve_runtime::__private::{ConstraintImpulses, Dimensions, LANES, Lane, Mask, StateLanesOf};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{OneStepMethod, Variational};

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

/// The body of a test over all systems and rules.
pub(crate) trait Check {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: sve_runtime::__private::VectorCoordinates<N>;
}

/// Random consistent states around a start, one for each lane.
pub(crate) fn random_states<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    around: State<Q>,
    [of_q, of_p]: [f64; 2],
    random: &mut Random,
) -> Vec<State<Q>>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: sve_runtime::__private::VectorCoordinates<N>,
{
    let mut states = Vec::new();
    while states.len() < LANES {
        let (q, p) = (around.q.coordinates(), Q::components(&around.p));
        let moved: [f64; N] = core::array::from_fn(|i| q[i] + random.uniform(-of_q, of_q));
        let pushed: [f64; N] = core::array::from_fn(|i| p[i] + random.uniform(-of_p, of_p));
        let (q, p) = (Q::from_coordinates(&moved), Q::from_components(&pushed));
        states.extend(integrator.consistent(State::at(around.t, q, p)));
    }
    states
}

/// Steps of all lanes. Returns the states, and the mask of the lanes that are left to the single
/// step.
pub(crate) fn stepped_in_lanes<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    states: &[State<Q>],
    h: f64,
    dw: &[Lane; M],
) -> (Vec<State<Q>>, Mask)
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: sve_runtime::__private::VectorCoordinates<N>,
{
    let mut lanes = <Dims<N, M, Q> as Dimensions>::splat(&states[0]);
    for (lane, state) in states.iter().enumerate() {
        <Dims<N, M, Q> as Dimensions>::set(&mut lanes, lane, state);
    }
    let mut next: StateLanesOf<S> = lanes;
    let prepared = OneStepMethod::prepare(integrator, h).unwrap();
    let left = OneStepMethod::step_lanes(integrator, &prepared, &lanes, &mut next, h, dw);
    let states = (0..LANES).map(|lane| <Dims<N, M, Q> as Dimensions>::get(&next, lane));
    (states.collect(), left)
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
    Q: sve_runtime::__private::VectorCoordinates<N>,
{
    let midpoint = Integrator::new(system, Midpoint);
    let start = midpoint.consistent(start).unwrap();
    let initial_point = Integrator::new(system, InitialPoint);
    check.run(&format!("{name} initial_point"), &initial_point, start);
    let endpoint = Integrator::new(system, Endpoint);
    check.run(&format!("{name} endpoint"), &endpoint, start);
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

/// A state of the two rods that moves, with this momentum of the upper end.
pub(crate) fn two_rods_at(speed: f64) -> State<[f64; 4]> {
    let near = State::new([0.9, -0.4, 0.6, -1.0], [0.2, speed, 0.4, 0.1]);
    Integrator::new(two_rods(), Midpoint)
        .consistent(near)
        .unwrap()
}

pub(crate) fn thermal(nu: f64, temperature: f64) -> Thermal {
    let g = 1.0;
    Thermal { g, nu, temperature }
}

/// All systems without a force.
pub(crate) fn conservative(check: &mut impl Check) {
    let q = [0.6, 0.0, -0.8];
    let p = [0.3, 0.9, 0.2];
    let [at, along] = [q, p].map(Vector3::from);
    let start = State::new(q, p);
    all_rules(check, "sphere", &OnSphere { g: 1.3, s: 0.7 }, start);
    all_rules(check, "turned sphere", &TurnedSphere { s: 0.7 }, start);
    all_rules(check, "two rods", &two_rods(), two_rods_at(0.5));
    let torus = Torus {
        g: 1.0,
        a: 2.0,
        b: 0.7,
        s: 0.5,
    };
    let on_torus = State::new(Vector3::new(2.5, 0.3, 0.4), along);
    all_rules(check, "torus", &torus, on_torus);
    let ellipsoid = Ellipsoid {
        axes: [1.0, 2.0, 0.5],
        g: 1.0,
        s: 0.4,
    };
    all_rules(check, "ellipsoid", &ellipsoid, State::new(at, along));
    let curved = Curved { g: 1.0, s: 0.3 };
    all_rules(check, "curved", &curved, State::new(at, along));
    let saddle = Saddle { c: 0.3, s: 0.4 };
    all_rules(check, "saddle", &saddle, State::new([0.5, -0.3, 0.0], p));
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
    let start = State::new(Vector3::new(0.6, 0.0, -0.8), Vector3::new(0.3, 0.9, 0.2));
    all_rules(check, "thermal", &thermal(0.5, 1.0), start);
}
