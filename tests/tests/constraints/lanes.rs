//! Steps of constrained systems in lanes against steps of single states. The last digits may
//! differ: pivots have another order, and quotients share a division.

use sve_models::checks::assert_within;
use sve_models::models::{Thermal, TurnedSphere};
use sve_models::orders::numbers;
use sve_models::random::Random;
use sve_runtime::__private::{ConstraintImpulses, LANES, Lane, VectorCoordinates};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::systems::{Check, all, random_states, stepped_in_lanes, thermal};

/// States and increments of all lanes.
struct Block<Q: VectorCoordinates<N>, const N: usize, const M: usize> {
    states: Vec<State<Q>>,
    dw: [Lane; M],
}

impl<Q: VectorCoordinates<N>, const N: usize, const M: usize> Block<Q, N, M> {
    /// Consistent states around a start, and increments up to `noise`.
    fn random<S, R>(
        integrator: &Integrator<S, R>,
        around: State<Q>,
        noise: f64,
        random: &mut Random,
    ) -> Self
    where
        S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    {
        let states = random_states(integrator, around, [0.3, 1.0], random);
        let lane = |_| core::array::from_fn(|_| random.uniform(-noise, noise));
        let dw = core::array::from_fn(lane);
        Self { states, dw }
    }

    fn increments(&self, lane: usize) -> [f64; M] {
        self.dw.map(|row| row[lane])
    }
}

/// Allowed difference in units of rounding of the largest number, which is at least 1. Both
/// iterations end within a few units of the root, in the velocity; the solves that follow multiply
/// this by the condition of the constraints.
const UNITS: f64 = 16.0;

/// Steps of more than 3000 instructions: the correction of a noise that is curved in the momentum,
/// along the constraint.
const ONE_BY_ONE: [&str; 2] = ["curved initial_point", "curved endpoint"];

/// Compares lanes with single states at several step sizes.
struct Compared {
    random: Random,
    /// Largest difference, and lanes that were solved and not.
    worst: f64,
    solved: u32,
    left: u32,
}

impl Check for Compared {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let in_lanes = integrator.plan().in_lanes;
        assert_eq!(in_lanes, !ONE_BY_ONE.contains(&name), "{name}");
        let (mut solved, mut count) = (0, 0);
        // of the last steps, many have no root
        for (h, deviations) in [(1e-3, 1.0), (0.03, 1.0), (0.1_f64, 1.0), (0.4, 3.0)] {
            for _ in 0..6 {
                let noise = deviations * h.sqrt();
                let block = Block::random(integrator, start, noise, &mut self.random);
                let (states, left) = stepped_in_lanes(integrator, &block.states, h, &block.dw);
                if deviations == 1.0 {
                    solved += left.count_zeros();
                    count += LANES as u32;
                }
                for lane in 0..LANES {
                    let before = &block.states[lane];
                    if left >> lane & 1 == 1 {
                        assert_eq!(&states[lane], before, "{name}");
                        continue;
                    }
                    let mut single = *before;
                    let dw = block.increments(lane);
                    let result = integrator.step(&mut single, h, &dw);
                    assert!(result.is_ok(), "{name}: {result:?} from {before:?}");
                    let (got, expected) = (numbers(&states[lane]), numbers(&single));
                    let size = expected.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
                    for (a, b) in got.iter().zip(&expected) {
                        let units = (a - b).abs() / (f64::EPSILON * size);
                        self.worst = self.worst.max(units);
                        assert!(
                            units <= UNITS,
                            "{name}, h = {h}: {got:?} in a lane, {expected:?} alone"
                        );
                    }
                }
            }
        }
        self.solved += solved;
        self.left += count - solved;
        assert!(in_lanes || solved == 0, "{name}: {solved}");
        // the fast path of lanes accepts iterations that contract by 1/64; the long steps among
        // these take the scalar step
        assert!(
            !in_lanes || 4 * solved >= 3 * count,
            "{name}: {solved} of {count}"
        );
    }
}

#[test]
fn lanes_agree_with_single_states() {
    let mut compared = Compared {
        random: Random::new(21),
        worst: 0.0,
        solved: 0,
        left: 0,
    };
    all(&mut compared);
    let [solved, left] = [compared.solved, compared.left];
    let worst = compared.worst;
    println!("{solved} lanes solved, {left} left, at most {worst} units of rounding apart");
}

/// Steps each lane beside other neighbours: one that cannot be stepped, one that is far away.
struct Neighbours {
    random: Random,
}

impl Check for Neighbours {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let h = 0.03;
        let block = Block::random(integrator, start, 0.2, &mut self.random);
        let (together, left) = stepped_in_lanes(integrator, &block.states, h, &block.dw);
        for lane in (0..LANES).filter(|lane| left >> lane & 1 == 0).step_by(5) {
            let mut alone = Block {
                states: vec![block.states[lane]; LANES],
                dw: block.increments(lane).map(|dw| [dw; LANES]),
            };
            let (bad, far) = ((lane + 1) % LANES, (lane + 2) % LANES);
            let mut q = start.q.coordinates();
            q[0] = f64::NAN;
            alone.states[bad].q = Q::from_coordinates(&q);
            let p = Q::components(&block.states[lane].p).map(|p| 1e6 * p);
            alone.states[far].p = Q::from_components(&p);
            let (states, left) = stepped_in_lanes(integrator, &alone.states, h, &alone.dw);
            assert_eq!(left >> bad & 1, 1, "{name}: NaN");
            for other in [lane, (lane + 5) % LANES] {
                assert_eq!(left >> other & 1, 0, "{name}");
                assert_eq!(states[other], together[lane], "{name}");
            }
        }
    }
}

#[test]
fn a_lane_does_not_feel_its_neighbours() {
    all(&mut Neighbours {
        random: Random::new(22),
    });
}

/// A particle at rest that is turned at random: each step of the midpoint rule turns it by 2
/// arctan(s ΔW/2) about the axis, so the mean of the part across the axis is multiplied by
/// `E (1 − x²/4)/(1 + x²/4)`, x = s ΔW, in each step.
#[test]
fn the_mean_of_random_rotations_is_exact() {
    const STEPS: u64 = 40;
    let (s, h) = (1.0, 0.05_f64);
    let integrator = Integrator::new(TurnedSphere { s }, Midpoint);
    assert!(integrator.plan().in_lanes);
    let (axis, q) = (
        Vector3::new(1.0, -2.0, 2.0) / 3.0,
        Vector3::new(0.6, 0.0, -0.8),
    );
    let summary = Ensemble::new(&integrator)
        .paths(4000)
        .seed(3)
        .steps(h, STEPS)
        .start(State::new(q.into(), [0.0; 3]))
        .observe("x", |_, state: &State<[f64; 3]>| state.q[0])
        .observe("y", |_, state: &State<[f64; 3]>| state.q[1])
        .observe("along the axis", |_, state: &State<[f64; 3]>| {
            (state.q[0] - 2.0 * state.q[1] + 2.0 * state.q[2]) / 3.0
        })
        .run()
        .unwrap();
    let failures = summary.failures();
    assert!(failures.is_empty(), "{}", failures[0]);
    // the mean over a normal distribution, by the trapezoidal rule
    let (mut factor, mut weight) = (0.0, 0.0);
    for k in -4000..=4000 {
        let z = f64::from(k) * 2e-3;
        let (x, w) = (s * h.sqrt() * z, (-0.5 * z * z).exp());
        factor += w * (1.0 - 0.25 * x * x) / (1.0 + 0.25 * x * x);
        weight += w;
    }
    let factor = (factor / weight).powi(STEPS as i32);
    let along = axis * axis.dot(&q);
    let expected = along + (q - along) * factor;
    for (k, expected) in [expected.x, expected.y].into_iter().enumerate() {
        let statistics = &summary.statistics()[k];
        let (mean, variance) = (statistics.mean(), statistics.variance());
        let last = mean.len() - 1;
        let error = (variance[last] / 4000.0).sqrt();
        assert_within(mean[last], expected, error, 4.5, k);
        assert!(error > 1e-3);
    }
    let statistics = &summary.statistics()[2];
    let (min, max) = (statistics.min(), statistics.max());
    for x in min.iter().chain(max) {
        assert!((x - axis.dot(&q)).abs() < 1e-14, "{x}");
    }
}

/// A heat bath: E z = 1 − coth 1 and the temperature 1 at g = T = 1. The rule changes both by less
/// than 0.013 at this step size.
#[test]
fn a_heat_bath_has_its_temperature() {
    const PATHS: u32 = 1500;
    let integrator = Integrator::new(thermal(1.0, 1.0), Midpoint);
    assert!(integrator.plan().in_lanes);
    let summary = Ensemble::new(&integrator)
        .paths(u64::from(PATHS))
        .seed(11)
        .steps(0.1, 120)
        .every(120)
        .start(State::new(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros()))
        .observe("height", |_, state: &State<Vector3<f64>>| state.q.z)
        .observe(
            "temperature",
            |thermal: &Thermal, state: &State<Vector3<f64>>| thermal.temperature(state),
        )
        .run()
        .unwrap();
    assert!(summary.failures().is_empty());
    let exact = [1.0 - 1.0 / 1.0_f64.tanh(), 1.0];
    for (statistics, exact) in summary.statistics().iter().zip(exact) {
        let (mean, variance) = (statistics.mean(), statistics.variance());
        let last = mean.len() - 1;
        let error = (variance[last] / f64::from(PATHS)).sqrt();
        let distance = (mean[last] - exact).abs();
        println!("{} ± {error}, exact {exact}", mean[last]);
        assert!(distance < 0.013 + 4.0 * error, "{distance} {error}");
    }
}
