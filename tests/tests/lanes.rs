//! Steps in lanes against steps of single states: every rule of every model. Bit for bit where no function of the library and no
//! iteration is involved.

use sve_runtime::prelude::*;
use sve_runtime::{BlockKind, LANES, Lane, Mask, StateLanes, Variational};
use sve_tests::oracle::{Model, Rule, Visitor, every_step, name};
use sve_tests::random::Random;

/// States of as many lanes with their increments.
struct Block<const N: usize, const M: usize> {
    states: StateLanes<N>,
    dw: [Lane; M],
}

impl<const N: usize, const M: usize> Block<N, M> {
    fn random<S: Model<N, M>>(random: &mut Random) -> Self {
        let mut block = Self {
            states: StateLanes::splat(&State::new([0.0; N], [0.0; N])),
            dw: [[0.0; LANES]; M],
        };
        for lane in 0..LANES {
            block.states.set(lane, &S::point(random));
            let dw: [f64; M] = random.array(-0.3, 0.3);
            for i in 0..M {
                block.dw[i][lane] = dw[i];
            }
        }
        block
    }

    fn increments(&self, lane: usize) -> [f64; M] {
        core::array::from_fn(|i| self.dw[i][lane])
    }
}

const H: f64 = 0.1;

/// A step of all lanes; the set of those left.
fn step<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    block: &Block<N, M>,
) -> (StateLanes<N>, Mask)
where
    S: Model<N, M> + Variational<R>,
{
    let mut next = block.states;
    let prepared = Method::prepare(integrator, H).unwrap();
    let left = Method::step_lanes(
        integrator,
        &prepared,
        &block.states,
        &mut next,
        H,
        &block.dw,
    );
    (next, left)
}

/// A unit in the last place of the numbers in a state, at least of 1.
fn unit<const N: usize>(state: &State<[f64; N]>) -> f64 {
    let numbers = state.q.iter().chain(&state.p);
    f64::EPSILON * numbers.fold(1.0, |m: f64, x| m.max(x.abs()))
}

/// Functions of lanes and those of the library differ in the last place, Newton's method ends within some, and the Jacobians
/// of the models pass this on, times ten at most.
const UNITS: f64 = 40.0;

/// Too large for lanes, banded, or of more unknowns than are judged; and where L is not quadratic in the velocity.
const ONE_BY_ONE: [&str; 15] = [
    "Chain by midpoint",
    "Charges by endpoint",
    "Charges by midpoint",
    "Magnetic by taylor2",
    "PlanarDoublePendulum by taylor2",
    "Rails by initial_point",
    "Rails by endpoint",
    "Rails by midpoint",
    "Relativistic by initial_point",
    "Relativistic by endpoint",
    "Relativistic by midpoint",
    "Relativistic by taylor2",
    "SphericalPendulum by taylor2",
    "Stirred by taylor2",
    "Stretched by taylor2",
];

struct Against(Random);

impl Visitor for Against {
    fn visit<S, R, const N: usize, const M: usize>(&mut self, integrator: &Integrator<S, R>)
    where
        S: Model<N, M> + Variational<R>,
        R: Rule,
    {
        let what = name(integrator);
        let plan = integrator.plan();
        let in_lanes = !ONE_BY_ONE.contains(&what.as_str());
        let is_exact = plan.step.transcendental == 0
            && plan.blocks.iter().all(|b| b.kind != BlockKind::Newton);
        let mut solved = 0;
        for _ in 0..20 {
            let block = Block::random::<S>(&mut self.0);
            let (states, left) = step(integrator, &block);
            assert!(in_lanes || left == Mask::MAX, "{what}");
            solved += left.count_zeros();
            for lane in 0..LANES {
                let before = block.states.get(lane);
                let got = states.get(lane);
                if left >> lane & 1 == 1 {
                    assert_eq!(got, before, "{what}");
                    continue;
                }
                let mut expected = before;
                let dw = block.increments(lane);
                integrator.step(&mut expected, H, &dw).unwrap();
                assert_eq!(got.t, before.t, "{what}");
                let bound = if is_exact {
                    0.0
                } else {
                    UNITS * unit(&expected)
                };
                for i in 0..N {
                    let error = (got.q[i] - expected.q[i]).abs();
                    let error = error.max((got.p[i] - expected.p[i]).abs());
                    assert!(
                        error <= bound,
                        "{what}: {got:?} in a lane, {expected:?} alone, from {before:?}, {dw:?}"
                    );
                }
            }
        }
        // the judge leaves some fast motions to the single step
        assert!(
            !in_lanes || solved > 20 * LANES as u32 / 4,
            "{what}: {solved}"
        );
    }
}

#[test]
fn lanes_agree_with_single_states() {
    every_step(&mut Against(Random::new(11)));
}

struct Neighbours(Random);

impl Visitor for Neighbours {
    fn visit<S, R, const N: usize, const M: usize>(&mut self, integrator: &Integrator<S, R>)
    where
        S: Model<N, M> + Variational<R>,
        R: Rule,
    {
        let what = name(integrator);
        let block = Block::random::<S>(&mut self.0);
        let (together, left) = step(integrator, &block);
        if left == Mask::MAX {
            return;
        }
        for lane in 0..LANES {
            let state = block.states.get(lane);
            let mut alone = Block::<N, M> {
                states: StateLanes::splat(&state),
                dw: [[0.0; LANES]; M],
            };
            for i in 0..M {
                alone.dw[i] = [block.dw[i][lane]; LANES];
            }
            // one neighbour that cannot be stepped, one that is far away
            let (bad, far) = ((lane + 1) % LANES, (lane + 2) % LANES);
            alone.states.q[0][bad] = f64::NAN;
            alone.states.p[0][far] *= 1e6;
            let (states, left) = step(integrator, &alone);
            assert_eq!(left >> bad & 1, 1, "{what}: NaN");
            assert!(states.q[0][bad].is_nan(), "{what}");
            assert_eq!(states.p[0][bad], state.p[0], "{what}: state of a lane left");
            let last = (lane + 5) % LANES;
            for other in [lane, last] {
                assert_eq!(left >> other & 1, 0, "{what}");
                assert_eq!(states.get(other), together.get(lane), "{what}");
            }
        }
    }
}

#[test]
fn a_lane_does_not_feel_its_neighbours() {
    every_step(&mut Neighbours(Random::new(12)));
}
