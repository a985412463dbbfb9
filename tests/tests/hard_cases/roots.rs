//! Which solution a step takes: the one connected with no noise and h → 0, in single steps and in
//! lanes.

use sve_models::checks::assert_relative;
use sve_models::is_thorough;
use sve_models::random::Random;
use sve_runtime::__private::{LANES, StateLanes};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::wild::*;

/// Number of random states for each system and rule, divided among the step sizes.
fn samples() -> usize {
    if is_thorough() { 200_000 } else { 10_000 }
}

/// Returns whether two states agree up to the rounding errors of elementary functions, which an
/// ill-conditioned step amplifies.
fn agree<const N: usize>(a: &State<[f64; N]>, b: &State<[f64; N]>) -> bool {
    let near = |x: f64, y: f64| (x - y).abs() <= 1e-6 * (1.0 + y.abs());
    (0..N).all(|i| near(a.q[i], b.q[i]) && near(a.p[i], b.p[i]))
}

/// Steps random states, within `size` of zero in q and p, in lanes and one by one.
fn compare<S, R, const N: usize, const M: usize>(name: &str, system: S, rule: R, size: [f64; 2])
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    const SIZES: [f64; 4] = [0.1, 0.3, 1.0, 3.0];
    let integrator = Integrator::new(system, rule);
    let mut random = Random::new(42);
    for h in SIZES {
        let prepared = integrator.prepare(h).unwrap();
        for _ in 0..samples().div_ceil(SIZES.len() * LANES) {
            let mut states = StateLanes::splat(&State::new([0.0; N], [0.0; N]));
            let mut dw = [[0.0; LANES]; M];
            for lane in 0..LANES {
                let [t] = random.array(0.0, 1.0);
                let (q, p) = (
                    random.array(-size[0], size[0]),
                    random.array(-size[1], size[1]),
                );
                states.set(lane, &State::at(t, q, p));
                for row in &mut dw {
                    // a sum of three uniform numbers: as wide as a normal one, to three standard
                    // deviations
                    row[lane] = h.sqrt() * random.array::<3>(-1.0, 1.0).iter().sum::<f64>();
                }
            }
            let mut next = states;
            let left = integrator.step_lanes(&prepared, &states, &mut next, h, &dw);
            for lane in (0..LANES).filter(|lane| left >> lane & 1 == 0) {
                let start = states.get(lane);
                let mut single = start;
                let dw: [f64; M] = core::array::from_fn(|i| dw[i][lane]);
                let result = integrator.step(&mut single, h, &dw);
                assert!(
                    result.is_ok() && agree(&next.get(lane), &single),
                    "{name}, h = {h}: {start:?} {dw:?}\nlanes {:?}\nsingle {single:?} {result:?}",
                    next.get(lane)
                );
            }
        }
    }
}

macro_rules! lanes_take_the_solution_of_single_steps {
    ($($system:ident, $q:expr, $p:expr;)*) => {
        /// A lane has the solution of the single step: no lane takes another solution, or
        /// one where the single step errs.
        #[test]
        fn lanes_take_the_solution_of_single_steps() {
            $(
                compare(stringify!($system), $system, Midpoint, [$q, $p]);
                compare(stringify!($system), $system, Endpoint, [$q, $p]);
                compare(stringify!($system), $system, InitialPoint, [$q, $p]);
            )*
        }
    };
}

lanes_take_the_solution_of_single_steps! {
    DoubleWell, 1.5, 3.0;
    Kapitza, 3.0, 3.0;
    PoschlTeller, 1.0, 3.0;
    MathewsLakshmanan, 2.0, 3.0;
    QuarticKinetic, 1.5, 3.0;
    Pendulum, 3.0, 5.0;
    DoublePendulum, 3.0, 5.0;
    HenonHeiles, 0.6, 0.6;
    TurnedHenonHeiles, 0.6, 0.6;
    Rotor, 3.0, 3.0;
    Synchrotron, 3.0, 3.0;
    Kepler, 2.0, 1.5;
    GaussianWell, 2.0, 2.0;
    LorentzWell, 3.0, 2.0;
    Morse, 1.0, 1.0;
    CurvedMass, 2.0, 2.0;
    PolarOrbit, 2.0, 2.0;
    Actions, 1.5, 1.5;
    Bounded, 1.5, 1.0;
    RelativisticOscillator, 1.0, 2.0;
    CoshKinetic, 1.0, 2.0;
    TwoWaves, 3.0, 2.0;
    Chain, 1.0, 1.0;
}

/// The end of a step of one coordinate.
pub(super) fn end<S, R, const M: usize>(
    integrator: &Integrator<S, R>,
    [q, p]: [f64; 2],
    h: f64,
    dw: [f64; M],
) -> Result<[f64; 2], StepError>
where
    S: Variational<R> + System<Dims = Dims<1, M>>,
{
    let mut state = State::new([q], [p]);
    integrator.step(&mut state, h, &dw)?;
    Ok([state.q[0], state.p[0]])
}

/// The solution that is followed, in small steps.
mod followed {
    /// Follows the root of `value(x, s)` from `x` at s = 0 to s = 1, by Newton's method. The steps
    /// are so small that the root moves little compared with the length on which the equations
    /// change. Returns `None` if the slope vanishes.
    pub(super) fn root(
        mut x: f64,
        value: impl Fn(f64, f64) -> f64,
        slope: impl Fn(f64, f64) -> f64,
    ) -> Option<f64> {
        const STEPS: u32 = 20_000;
        for k in 1..=STEPS {
            let s = f64::from(k) / f64::from(STEPS);
            let from = x;
            for _ in 0..6 {
                x -= value(x, s) / slope(x, s);
            }
            if !(slope(x, s) > 0.0 && (x - from).abs() < 0.05) {
                return None;
            }
        }
        Some(x)
    }
}

/// The pendulum by the midpoint rule with steps longer than the period of its linearisation, where
/// most states have several solutions. The step takes the solution that a reference follows from
/// h = 0, then from zero noise.
#[test]
fn large_steps_of_the_pendulum() {
    let integrator = Integrator::new(Pendulum, Midpoint);
    let mut random = Random::new(7);
    let mut counts = [0; 2];
    for _ in 0..150 {
        let [q, p, size, noise] = random.array(-1.0, 1.0);
        let (q, p, h, w) = (3.0 * q, 5.0 * p, 1.2 + size, 2.0 * noise);
        let force = |x: f64, h: f64, w: f64| {
            let node = q + 0.5 * h * x;
            0.5 * h * 9.8 * node.sin() - 0.25 * w * node.cos()
        };
        let stiffness = |x: f64, h: f64, w: f64| {
            let node = q + 0.5 * h * x;
            0.5 * h * (0.5 * h * 9.8 * node.cos() + 0.25 * w * node.sin())
        };
        let still = followed::root(
            p,
            |x, s| x - p + force(x, s * h, 0.0),
            |x, s| 1.0 + stiffness(x, s * h, 0.0),
        );
        let noisy = still.and_then(|v| {
            followed::root(
                v,
                |x, s| x - p + force(x, h, s * w),
                |x, s| 1.0 + stiffness(x, h, s * w),
            )
        });
        let result = end(&integrator, [q, p], h, [w]);
        match (noisy, result) {
            (Some(v), Ok(found)) => {
                assert_relative(&found, &[q + h * v, 2.0 * v - p], 1e-9, "pendulum");
                counts[0] += 1;
            }
            (None, Err(StepError::BranchLost { .. })) => counts[1] += 1,
            (expected, found) => {
                panic!("q = {q}, p = {p}, h = {h}, w = {w}: {expected:?} {found:?}")
            }
        }
    }
    // few solutions end at a fold
    assert!(counts[0] > 120, "{counts:?}");
}

/// Steps whose first guess, the velocity without the quartic term, is far from the solution.
#[test]
fn solvable_steps_are_solved() {
    let integrator = Integrator::new(QuarticKinetic, Midpoint);
    for (start, h, dw, expected) in [
        (
            [-0.481_332_040_194_212_5, -20.493_974_040_470_974],
            0.1,
            [-0.254_772_974_347_881_5, -0.134_041_206_898_625_25],
            [-0.193_279_197_819, -20.505_848_240_2],
        ),
        (
            [0.714_377_362_312_135_7, 296.896_126_584_801_8],
            1e-3,
            [-0.009_166_298_756_512_831, -0.017_930_165_972_523_15],
            [-0.343_681_395_626, 296.896_456_156],
        ),
        (
            [0.918_906_553_392_246_9, -2.258_569_565_430_228],
            1.0,
            [-0.139_779_784_716_538_74, -1.502_384_025_610_929_3],
            [0.556_242_858_4, -2.761_397_928],
        ),
    ] {
        let found = end(&integrator, start, h, dw).unwrap();
        assert_relative(&found, &expected, 1e-9, h);
    }
}
