//! Energies of long runs by every rule where its steps are iterated: they walk at random, by the
//! rounding of the state, and do not drift.

use sve_runtime::__private::{LANES, StateLanes};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

struct CurvedMass;

#[variational(midpoint, endpoint, initial_point, taylor2, gauss(3), gauss(8))]
impl CurvedMass {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v * (1.0 + 0.5 * q.sin()) - 0.5 * q * q
    }
}

struct Quartic;

#[variational(midpoint, endpoint, initial_point, taylor2)]
impl Quartic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v * (1.0 + q * q) - 0.25 * q.powi(4)
    }
}

const STEPS: u32 = 300_000;

/// Largest change of the energy's mean in random walks of rounding, ε|H|√n/2: about 2 are met among
/// so few runs, and a drift of a tenth of a unit of rounding in 100 steps would be 5.
const BOUND: f64 = 4.0;

/// The change of the mean energy from the first third to the last. The weights sin⁶ take its
/// oscillation, of the period of the motion, out of the means.
fn check<S, R>(system: S, rule: R)
where
    S: Variational<R> + System<Dims = Dims<1, 0>>,
{
    let integrator = Integrator::new(system, rule);
    for h in [0.01, 0.02, 0.03, 0.1] {
        let prepared = OneStepMethod::prepare(&integrator, h).unwrap();
        let mut state = State::new([1.0], [0.3]);
        let start = integrator.system().hamiltonian(&state).unwrap();
        let means = [(); 3].map(|()| {
            let (mut sum, mut weights) = (0.0, 0.0);
            let third = STEPS / 3;
            for k in 0..third {
                OneStepMethod::step_prepared(&integrator, &prepared, &mut state, h, &[]).unwrap();
                let place = std::f64::consts::PI * f64::from(k) / f64::from(third);
                let weight = place.sin().powi(6);
                sum += weight * (integrator.system().hamiltonian(&state).unwrap() - start);
                weights += weight;
            }
            sum / weights
        });
        let walk = 0.5 * f64::EPSILON * start.abs() * f64::from(STEPS).sqrt();
        let moved = (means[2] - means[0]) / walk;
        assert!(
            moved.abs() < BOUND,
            "{}, h = {h}: {moved}",
            integrator.plan()
        );
    }
}

#[test]
fn energies_walk_at_random_by_every_rule() {
    check(CurvedMass, Midpoint);
    check(CurvedMass, Endpoint);
    check(CurvedMass, InitialPoint);
    check(CurvedMass, Taylor2);
    check(Quartic, Midpoint);
    check(Quartic, Endpoint);
    check(Quartic, InitialPoint);
    check(Quartic, Taylor2);
    check(CurvedMass, Gauss::<3>);
    check(CurvedMass, Gauss::<8>);
}

/// The same in lanes, whose starts differ: the mean over the lanes of the change, which walks less
/// by the root of their number.
fn check_lanes<S, R>(system: S, rule: R)
where
    S: Variational<R> + System<Dims = Dims<1, 0>>,
{
    let integrator = Integrator::new(system, rule);
    let energy =
        |states: &StateLanes<1>, lane| integrator.system().hamiltonian(&states.get(lane)).unwrap();
    for h in [0.01, 0.02, 0.03, 0.1] {
        let prepared = OneStepMethod::prepare(&integrator, h).unwrap();
        let mut states = StateLanes::splat(&State::new([1.0], [0.3]));
        for lane in 0..LANES {
            states.set(lane, &State::new([0.6 + 0.02 * lane as f64], [0.3]));
        }
        let start: [f64; LANES] = core::array::from_fn(|lane| energy(&states, lane));
        let means = [(); 3].map(|()| {
            let (mut sums, mut weights) = ([0.0; LANES], 0.0);
            let third = STEPS / 9;
            for k in 0..third {
                let mut next = states;
                let left =
                    OneStepMethod::step_lanes(&integrator, &prepared, &states, &mut next, h, &[]);
                assert_eq!(left, 0, "h = {h}: the lane step leaves lanes");
                states = next;
                // energies cost more than steps; fewer of them would take harmonics of the motion
                // for a mean
                if k % 2 != 0 {
                    continue;
                }
                let place = std::f64::consts::PI * f64::from(k) / f64::from(third);
                let weight = place.sin().powi(6);
                for lane in 0..LANES {
                    sums[lane] += weight * (energy(&states, lane) - start[lane]);
                }
                weights += weight;
            }
            sums.map(|sum| sum / weights)
        });
        let mut moved = 0.0;
        for lane in 0..LANES {
            let walk = 0.5 * f64::EPSILON * start[lane].abs() * f64::from(STEPS / 3).sqrt();
            moved += (means[2][lane] - means[0][lane]) / walk / LANES as f64;
        }
        let bound = BOUND / (LANES as f64).sqrt();
        assert!(
            moved.abs() < bound,
            "{}, h = {h}: {moved}",
            integrator.plan()
        );
    }
}

#[test]
fn energies_walk_at_random_in_lanes() {
    check_lanes(CurvedMass, Midpoint);
    check_lanes(CurvedMass, Endpoint);
    check_lanes(CurvedMass, InitialPoint);
    check_lanes(Quartic, Midpoint);
    check_lanes(Quartic, Endpoint);
    check_lanes(Quartic, InitialPoint);
}
