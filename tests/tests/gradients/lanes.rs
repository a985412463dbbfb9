//! Tangent vectors in lanes against the derivatives of single steps, for every rule of every model.

use sve_models::case::Case;
use sve_models::functions::{Point, Vector};
use sve_models::oracle::{cases, kubo};
use sve_models::random::Random;
use sve_runtime::__private::lane::{LaneDirections, TangentLanes};
use sve_runtime::__private::{Differentiable, LANES, StateLanes};
use sve_runtime::prelude::*;

use crate::adjoint::Swing;

const H: f64 = 0.1;

/// Allowed difference in units of rounding of the largest entry of the tangent map. The steps are
/// linearised at unknowns that agree to rounding, with functions that do, and in lanes the inverse
/// of the Jacobian stands for its factors.
const UNITS: f64 = 40.0;

/// Steps whose tangent vectors are carried one after the other though the steps are made in lanes:
/// their derivatives are too large.
const ALONE: [&str; 2] = ["Charges by initial_point", "Charges by stormer_verlet"];

/// Compares the lanes of a block. Returns the numbers of lanes that were solved, and of those whose
/// vectors were carried.
fn compare(case: &dyn Case, random: &mut Random) -> [u32; 2] {
    let (what, noises) = (case.name(), case.dimensions().1);
    let states: Vec<Point> = (0..LANES).map(|_| case.model().point(random)).collect();
    let dw: Vec<Vector> = (0..LANES)
        .map(|_| random.vector(noises, -0.3, 0.3))
        .collect();
    let found = case.tangents_in_lanes(&states, H, &dw).unwrap();
    let (plain, unsolved) = case.step_lanes(&states, H, &dw).unwrap();
    assert_eq!(found.unsolved, unsolved, "{what}");
    assert_eq!(found.unfinished & unsolved, unsolved, "{what}");
    assert!(found.states == plain, "{what}: other bits");
    for lane in (0..LANES).filter(|lane| found.unfinished >> lane & 1 == 0) {
        let expected = case
            .differentiated(&mut states[lane].clone(), H, &dw[lane])
            .unwrap();
        let size = expected.tangent.len();
        let column = |j: usize| expected.tangent.iter().map(|row| row[j]).collect();
        let by_state = (0..size).map(column);
        let by_parameters = expected
            .sensitivity
            .iter()
            .map(|(_, vector)| vector.clone());
        let all: Vec<Vector> = by_state.chain(by_parameters).collect();
        let largest = all.iter().flatten().fold(1.0, |m: f64, x| m.max(x.abs()));
        assert_eq!(all.len(), found.vectors[lane].len(), "{what}");
        for (number, (found, expected)) in found.vectors[lane].iter().zip(&all).enumerate() {
            for (found, expected) in found.iter().zip(expected) {
                let off = (found - expected).abs() / (largest * f64::EPSILON);
                assert!(
                    off <= UNITS,
                    "{what}, direction {number}: {found} in a lane, {expected} alone, {off} units, from {:?}",
                    states[lane]
                );
            }
        }
    }
    [unsolved, found.unfinished].map(u32::count_zeros)
}

#[test]
fn tangent_vectors_in_lanes_are_those_of_single_steps() {
    let mut random = Random::new(21);
    let mut alone = Vec::new();
    for case in cases() {
        let (mut solved, mut carried) = (0, 0);
        for _ in 0..5 {
            let [of_block, carried_of_block] = compare(&*case, &mut random);
            solved += of_block;
            carried += carried_of_block;
        }
        if carried < solved {
            assert_eq!(carried, 0, "{}", case.name());
            alone.push(case.name());
        }
    }
    assert_eq!(alone, ALONE);
}

/// Substeps pass their tangent vectors on.
#[test]
fn compositions_carry_tangent_vectors_in_lanes() {
    /// Checks an integrator of a system with one coordinate and one noise: by q and p at the start,
    /// and by each parameter.
    macro_rules! check {
        ($system:expr, $rule:expr) => {{
            let integrator = Integrator::new($system, $rule);
            let starts: [State<[f64; 1]>; LANES] = core::array::from_fn(|lane| {
                State::new([0.8 - 0.05 * lane as f64], [0.4 + 0.02 * lane as f64])
            });
            let dw: [f64; LANES] = core::array::from_fn(|lane| 0.1 - 0.01 * lane as f64);
            let mut states = StateLanes::splat(&starts[0]);
            (starts.iter().enumerate()).for_each(|(lane, start)| states.set(lane, start));
            let zero = TangentLanes {
                q: [[0.0; LANES]],
                p: [[0.0; LANES]],
            };
            let mut start = [zero; 4];
            (start[0].q, start[1].p) = ([[1.0; LANES]], [[1.0; LANES]]);
            let (mut next, mut end) = (states, start);
            let directions = LaneDirections {
                start: &start,
                next: &mut end,
                parameters: &[None, None, Some(0), Some(1)],
            };
            let prepared = OneStepMethod::prepare(&integrator, H).unwrap();
            let masks =
                integrator.push_forward_lanes(&prepared, &states, &mut next, H, &[dw], directions);
            assert_eq!(masks, [0, 0]);
            for (lane, mut state) in starts.into_iter().enumerate() {
                let (tangent, sensitivity) = integrator
                    .step_with_derivatives(&mut state, H, &[dw[lane]])
                    .unwrap();
                let by_state = [0, 1].map(|j| [tangent[0][j], tangent[1][j]]);
                let by_parameters = sensitivity.iter().map(|(_, by)| [by.q[0], by.p[0]]);
                let expected: Vec<_> = by_state.into_iter().chain(by_parameters).collect();
                assert_eq!(expected.len(), end.len());
                for (found, expected) in end.iter().zip(expected) {
                    let found = [found.q[0][lane], found.p[0][lane]];
                    for (found, expected) in found.into_iter().zip(expected) {
                        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
                    }
                }
            }
        }};
    }
    check!(kubo(), Composed::new(Midpoint, KahanLi8));
    check!(Swing { g: 2.0, s: 0.3 }, Split::new(BlanesMoan4));
}
