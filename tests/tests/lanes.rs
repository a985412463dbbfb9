//! Steps in lanes against steps of single states, for every rule of every model. The bits are equal
//! if the step calls no function of the library and does not iterate.

use std::collections::BTreeSet;

use sve_models::case::Case;
use sve_models::functions::Point;
use sve_models::oracle::cases;
use sve_models::random::Random;
use sve_runtime::__private::{LANES, Mask};
use sve_runtime::plan::BlockKind;

/// A state and increments for each lane.
struct Block {
    states: Vec<Point>,
    dw: Vec<Vec<f64>>,
}

impl Block {
    fn random(case: &dyn Case, random: &mut Random) -> Self {
        let (model, noises) = (case.model(), case.dimensions().1);
        let lane = |_| (model.point(random), random.vector(noises, -0.3, 0.3));
        let (states, dw) = (0..LANES).map(lane).unzip();
        Self { states, dw }
    }
}

const H: f64 = 0.1;

/// Steps all lanes. Returns the states and the set of lanes that were not solved.
fn step(case: &dyn Case, block: &Block) -> (Vec<Point>, Mask) {
    case.step_lanes(&block.states, H, &block.dw).unwrap()
}

/// Allowed difference in units of rounding. Functions of lanes differ from functions of the library
/// in the last place, Newton's method ends within a few units, and the Jacobians of the models
/// amplify both at most ten times.
const UNITS: f64 = 40.0;

/// Steps that are not made in lanes: they are too large, banded, or have more unknowns than the
/// bounds judge, L is not quadratic in the velocity, or, for `Actions`, the bounds accept no step.
const ONE_BY_ONE: [&str; 18] = [
    "Actions by stormer_verlet",
    "Chain by midpoint",
    "Charges by endpoint",
    "Charges by midpoint",
    "Magnetic by taylor2",
    "PlanarDoublePendulum by taylor2",
    "Rails by initial_point",
    "Rails by endpoint",
    "Rails by midpoint",
    "Rails by stormer_verlet",
    "Relativistic by initial_point",
    "Relativistic by endpoint",
    "Relativistic by midpoint",
    "Relativistic by stormer_verlet",
    "Relativistic by taylor2",
    "SphericalPendulum by taylor2",
    "Stirred by taylor2",
    "Stretched by taylor2",
];

fn lanes_are_single_states(case: &dyn Case, random: &mut Random) {
    let (what, plan) = (case.name(), case.plan());
    let in_lanes = !ONE_BY_ONE.contains(&what.as_str());
    let is_exact =
        plan.step.transcendental == 0 && plan.blocks.iter().all(|b| b.kind != BlockKind::Newton);
    let mut solved = 0;
    for _ in 0..20 {
        let block = Block::random(case, random);
        let (states, left) = step(case, &block);
        assert!(in_lanes || left == Mask::MAX, "{what}");
        solved += left.count_zeros();
        for lane in 0..LANES {
            let (before, got, dw) = (&block.states[lane], &states[lane], &block.dw[lane]);
            if left >> lane & 1 == 1 {
                assert_eq!(got, before, "{what}");
                continue;
            }
            let expected = case.stepped(before, H, dw);
            assert_eq!(got.t, before.t, "{what}");
            // a unit in the last place of the largest number, at least of 1
            let bound = if is_exact {
                0.0
            } else {
                UNITS * f64::EPSILON * expected.size()
            };
            for (a, b) in got.entries().zip(expected.entries()) {
                assert!(
                    (a - b).abs() <= bound,
                    "{what}: {got:?} in a lane, {expected:?} alone, from {before:?}, {dw:?}"
                );
            }
        }
    }
    // the bounds do not accept some fast motions, which the single step solves
    assert!(
        !in_lanes || solved > 20 * LANES as u32 / 4,
        "{what}: {solved}"
    );
}

#[test]
fn lanes_agree_with_single_states() {
    let mut random = Random::new(11);
    for case in cases() {
        lanes_are_single_states(&*case, &mut random);
    }
}

/// Models whose energies are computed one after the other: the mass matrix couples too many
/// coordinates, or L is not quadratic in the velocities.
const ENERGIES_ONE_BY_ONE: [&str; 2] = ["Rails", "Relativistic"];

#[test]
fn energies_in_lanes_are_those_of_single_states() {
    let mut random = Random::new(15);
    let (mut in_lanes, mut alone) = (BTreeSet::new(), BTreeSet::new());
    for case in cases() {
        let (name, model) = (case.name(), case.model());
        let name = name.split(' ').next().unwrap_or_default().to_owned();
        for _ in 0..5 {
            let states: Vec<Point> = (0..LANES).map(|_| model.point(&mut random)).collect();
            let energies = case.energies(&states);
            if energies.iter().all(|[lane, _]| lane.is_nan()) {
                alone.insert(name.clone());
                continue;
            }
            in_lanes.insert(name.clone());
            for ([lane, expected], state) in energies.into_iter().zip(&states) {
                // a state outside of the domain of L has no energy
                if expected.is_nan() {
                    assert!(!lane.is_finite(), "{name}: {lane} at {state:?}");
                    continue;
                }
                let bound = 1e-12 * (1.0 + expected.abs());
                assert!(
                    (lane - expected).abs() <= bound,
                    "{name}: {lane} {expected} at {state:?}"
                );
            }
        }
    }
    let expected = ENERGIES_ONE_BY_ONE.map(str::to_owned);
    assert_eq!(alone, BTreeSet::from(expected));
    assert!(
        in_lanes.len() > 20 && in_lanes.is_disjoint(&alone),
        "{in_lanes:?}"
    );
}

fn lanes_are_the_same_beside_others(case: &dyn Case, random: &mut Random) {
    let what = case.name();
    let block = Block::random(case, random);
    let (together, left) = step(case, &block);
    if left == Mask::MAX {
        return;
    }
    for lane in 0..LANES {
        let state = &block.states[lane];
        let mut alone = Block {
            states: vec![state.clone(); LANES],
            dw: vec![block.dw[lane].clone(); LANES],
        };
        // one neighbour that cannot be stepped, one that is far away
        let (bad, far) = ((lane + 1) % LANES, (lane + 2) % LANES);
        alone.states[bad].q[0] = f64::NAN;
        alone.states[far].p[0] *= 1e6;
        let (states, left) = step(case, &alone);
        assert_eq!(left >> bad & 1, 1, "{what}: NaN");
        assert!(states[bad].q[0].is_nan(), "{what}");
        assert_eq!(states[bad].p[0], state.p[0], "{what}: state of a lane left");
        let last = (lane + 5) % LANES;
        for other in [lane, last] {
            assert_eq!(left >> other & 1, 0, "{what}");
            assert_eq!(states[other], together[lane], "{what}");
        }
    }
}

#[test]
fn a_lane_does_not_feel_its_neighbours() {
    let mut random = Random::new(12);
    for case in cases() {
        lanes_are_the_same_beside_others(&*case, &mut random);
    }
}
