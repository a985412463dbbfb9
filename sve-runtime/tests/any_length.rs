//! A scene by hand: a ring of springs whose number of sites is that of the state. It goes through
//! integrators, rules, compositions and trajectories as the scenes of the macro do.

#![allow(missing_docs)]

use std::cell::Cell;
use std::sync::OnceLock;

use sve_runtime::__private::{
    AnySystem, Formulas, Kind, Mode, Names, Operations, Plan, QuadraticKineticEnergy, Separable,
    Shear, StepShear, Steps, StrongOrder, Walker, shears,
};
use sve_runtime::Rule;
use sve_runtime::noise::NoiseError;
use sve_runtime::prelude::*;

const NONE: Operations = Operations {
    arithmetic: 0,
    transcendental: 0,
    angle_additions: 0,
};

const PLAN: Plan = Plan {
    system: "Ring",
    rule: "",
    substeps: None,
    degrees_of_freedom: 0,
    noises: 0,
    blocks: &[],
    deterministic_order: 1,
    strong_order: StrongOrder::Deterministic,
    weak_order: 1,
    conserved: &[],
    in_lanes: false,
    degenerate: None,
    prepare: NONE,
    step: NONE,
    carried: NONE,
    iteration: NONE,
    formulas: Formulas {
        system: "",
        motion: "",
        action: "",
        step: "",
    },
};

/// Unit masses in a ring of springs, each pushed by a noise of its own if `sigma` is not zero.
#[derive(Clone, Copy, Debug)]
struct Ring {
    k: f64,
    sigma: f64,
}

impl Ring {
    fn processes(&self, n: usize) -> usize {
        if self.sigma == 0.0 { 0 } else { n }
    }

    fn shear(&self, shear: StepShear, state: &mut State<Vec<f64>>, dw: &[f64]) {
        let n = state.q.len();
        for i in 0..n {
            match shear {
                StepShear::Drift { h, .. } => state.q[i] += h * state.p[i],
                StepShear::Kick { h, part, .. } => {
                    let (left, right) = (state.q[(i + n - 1) % n], state.q[(i + 1) % n]);
                    state.p[i] += h * self.k * (left - 2.0 * state.q[i] + right);
                    if let Some(dw) = dw.get(i) {
                        state.p[i] += self.sigma * part * dw;
                    }
                }
                StepShear::Midpoint { .. } => unreachable!("the rules of the ring are shears"),
            }
        }
    }

    fn is_finite(state: &State<Vec<f64>>) -> bool {
        state.q.iter().chain(&state.p).all(|x| x.is_finite())
    }
}

impl AnySystem for Ring {
    type Configuration = Vec<f64>;
    type Target = Self;
    type Stepped = Self;
    type Kind = Rings;
    type StateLanes = ();
    const NAMES: Names = Names {
        parameters: &["k", "sigma"],
        coordinates: &["q"],
        momenta: &["p"],
    };
    const FORMULAS_HASH: u64 = 1;

    fn target(&self) -> &Self {
        self
    }

    fn visit_parameters(&self, visit: &mut dyn FnMut(f64)) {
        visit(self.k);
        visit(self.sigma);
    }
}

impl AnySystem for &Ring {
    type Configuration = Vec<f64>;
    type Target = Ring;
    type Stepped = Ring;
    type Kind = Rings;
    type StateLanes = ();

    fn target(&self) -> &Ring {
        self
    }
}

impl Separable for Ring {}
impl QuadraticKineticEnergy for Ring {}

macro_rules! rule {
    ($rule:ident, $name:literal, $order:literal, $shears:expr) => {
        impl Rule<Ring> for $rule {
            type Increments = [f64];
            type Prepared = ();
            type Memory = ();
            const STAGES: usize = 1;
            const SUBSTEPS: usize = 1;
            const PLAN: &'static Plan = &Plan {
                rule: $name,
                deterministic_order: $order,
                ..PLAN
            };
            const HAS_INCREMENTS: bool = false;

            fn prepare(_: &Ring, _: f64) {}

            fn walk<M: Mode<Ring, [f64]>>(
                _: Walker<'_, Ring, Self>,
                (): &(),
                (): &mut (),
                h: f64,
                dw: &M::Increments,
                mode: &mut M,
            ) -> Result<(), M::Failure> {
                mode.shears(&$shears, h, dw)
            }
        }
    };
}
rule!(
    InitialPoint,
    "initial_point",
    1,
    [Shear::Kick(1.0), Shear::Drift(1.0)]
);
rule!(
    Endpoint,
    "endpoint",
    1,
    [Shear::Drift(1.0), Shear::Kick(1.0)]
);
rule!(
    StormerVerlet,
    "stormer_verlet",
    2,
    [Shear::Kick(0.5), Shear::Drift(1.0), Shear::Kick(0.5)]
);

struct Rings;

/// Tables that are made at the first step.
type Tables = OnceLock<()>;

impl Kind for Rings {
    type Cache = Tables;
}

thread_local! {
    /// How often tables were made, and the numbers of single steps, of steps in blocks and of
    /// blocks.
    static COUNTS: Cell<[u64; 4]> = const { Cell::new([0; 4]) };
}

fn counted(at: usize, number: u64) {
    let mut counts = COUNTS.get();
    counts[at] += number;
    COUNTS.set(counts);
}

/// Largest number of steps of a block.
const BLOCK: u64 = 16;

impl<R: Rule<Ring, Increments = [f64]>> Steps<Ring, R> for Rings {
    type Prepared = Vec<StepShear>;

    fn prepare(walker: Walker<'_, Ring, R>, _: &Tables, h: f64) -> Vec<StepShear> {
        let mut all = Vec::new();
        shears(walker, &R::prepare(walker.system, h), h, &mut all);
        all
    }

    fn step(
        walker: Walker<'_, Ring, R>,
        tables: &Tables,
        prepared: &Vec<StepShear>,
        state: &mut State<Vec<f64>>,
        h: f64,
        dw: &[f64],
    ) -> Result<(), StepError> {
        assert_eq!(dw.len(), walker.system.processes(state.q.len()));
        tables.get_or_init(|| counted(0, 1));
        counted(1, 1);
        let before = state.clone();
        for &shear in prepared {
            walker.system.shear(shear, state, dw);
        }
        if Ring::is_finite(state) {
            state.t += h;
            return Ok(());
        }
        *state = before;
        let (q, p) = (state.q.clone(), state.p.clone());
        let t = state.t;
        Err(StepError::NonFiniteResult { t, h, q, p })
    }

    fn next_step(
        walker: Walker<'_, Ring, R>,
        tables: &Tables,
        prepared: &mut Vec<StepShear>,
        state: &mut State<Vec<f64>>,
        h: f64,
        dw: &[f64],
    ) -> Result<(), StepError> {
        Self::step(walker, tables, prepared, state, h, dw)
    }

    fn next_steps(
        walker: Walker<'_, Ring, R>,
        tables: &Tables,
        prepared: &mut Vec<StepShear>,
        state: &mut State<Vec<f64>>,
        _: f64,
        dw: &mut [f64],
        count: u64,
        draw: &mut dyn FnMut(u64, &mut [f64]) -> Option<f64>,
    ) -> u64 {
        let before = state.clone();
        let mut made = 0;
        while made < count.min(BLOCK) {
            let Some(end) = draw(made, dw) else {
                break;
            };
            for &shear in &*prepared {
                walker.system.shear(shear, state, dw);
            }
            state.t = end;
            made += 1;
        }
        tables.get_or_init(|| counted(0, 1));
        counted(3, 1);
        if Ring::is_finite(state) {
            counted(2, made);
            return made;
        }
        *state = before;
        0
    }

    fn processes(
        walker: Walker<'_, Ring, R>,
        _: &Tables,
        state: &State<Vec<f64>>,
    ) -> Result<usize, StepError> {
        Ok(walker.system.processes(state.q.len()))
    }
}

/// The same ring of eight sites, of the macro.
struct Eight {
    k: f64,
    sigma: f64,
}

#[variational(initial_point, endpoint, stormer_verlet)]
impl Eight {
    fn lagrangian(&self, q: [f64; 8], v: [f64; 8]) -> f64 {
        let mut l = 0.0;
        for i in 0..8 {
            l += 0.5 * v[i] * v[i] - 0.5 * self.k * (q[(i + 1) % 8] - q[i]).powi(2);
        }
        l
    }
    #[gamma]
    fn pushes(&self, q: [f64; 8]) -> [f64; 8] {
        q.map(|q| self.sigma * q)
    }
}

const Q: [f64; 8] = [0.3, -0.2, 0.5, 0.1, -0.4, 0.25, 0.0, 0.7];
const P: [f64; 8] = [0.0, 0.1, -0.3, 0.2, 0.05, -0.6, 0.4, 0.15];

fn start() -> State<Vec<f64>> {
    State::new(Q.to_vec(), P.to_vec())
}

fn ring<R: Rule<Ring>>(rule: R) -> Integrator<Ring, R> {
    Integrator::new(Ring { k: 2.0, sigma: 0.3 }, rule)
}

/// The steps of the scene and of the unrolled system are the same to rounding, by any rule.
#[test]
fn a_scene_makes_the_steps_of_the_unrolled_system() {
    fn check<R, T>(rule: R, fixed: T)
    where
        R: Rule<Ring, Increments = [f64]>,
        T: Rule<Eight, Increments = [f64; 8]>,
    {
        let scene = ring(rule);
        let fixed = Integrator::new(Eight { k: 2.0, sigma: 0.3 }, fixed);
        assert_eq!(
            scene.plan().deterministic_order,
            fixed.plan().deterministic_order
        );
        let (mut state, mut expected) = (start(), State::new(Q, P));
        let dw = [0.1, -0.2, 0.05, 0.3, 0.0, -0.1, 0.02, 0.07];
        scene.step(&mut state, 0.1, &dw).unwrap();
        scene.step(&mut state, 0.1, &dw[..]).unwrap();
        fixed.step(&mut expected, 0.1, &dw).unwrap();
        fixed.step(&mut expected, 0.1, &dw).unwrap();
        let pairs = (state.q.iter().zip(expected.q)).chain(state.p.iter().zip(expected.p));
        for (x, expected) in pairs {
            assert!((x - expected).abs() < 1e-14, "{x} {expected}");
        }
        assert_eq!(state.t, expected.t);
    }
    check(InitialPoint, InitialPoint);
    check(Endpoint, Endpoint);
    check(StormerVerlet, StormerVerlet);
    check(
        Composed::new(StormerVerlet, KahanLi8),
        Composed::new(StormerVerlet, KahanLi8),
    );
    check(Split::new(BlanesMoan4), Split::new(BlanesMoan4));
    check(Split::new(BlanesMoanRkn6), Split::new(BlanesMoanRkn6));
}

#[test]
fn a_scene_without_noise_takes_no_increments() {
    let system = Ring { k: 2.0, sigma: 0.0 };
    let by_reference = Integrator::new(&system, StormerVerlet);
    let (mut state, mut other) = (start(), start());
    by_reference.step(&mut state, 0.1, &[]).unwrap();
    Integrator::new(system, StormerVerlet)
        .step(&mut other, 0.1, &[])
        .unwrap();
    assert_eq!(state, other);
}

/// Many steps at once, single steps and any adapter give the same bits.
#[test]
fn a_trajectory_has_the_same_states_however_it_is_walked() {
    let ring = ring(StormerVerlet);
    let path = || ring.trajectory(start(), 0.05, Wiener::new(3));
    let states: Vec<_> = path().take(100).map(Result::unwrap).collect();
    assert_eq!(states[99].t, 5.0);
    let mut at_once = path();
    assert_eq!(at_once.advance(0).unwrap(), &start());
    assert_eq!(at_once.advance(40).unwrap(), &states[39]);
    assert_eq!(at_once.advance(60).unwrap(), &states[99]);
    assert_eq!(at_once.step(), 100);
    assert_eq!(path().nth(99).unwrap().unwrap(), states[99]);
    for (k, state) in path().every(3).take(30).enumerate() {
        let expected = if k == 0 {
            start()
        } else {
            states[3 * k - 1].clone()
        };
        assert_eq!(state.unwrap().q, expected.q);
    }
    let until: Vec<_> = path().every(10).until(5.0).map(Result::unwrap).collect();
    assert_eq!(
        (until.len(), until[10].q.clone()),
        (11, states[99].q.clone())
    );
    let at: Vec<_> = path().at([0.5, 0.52, 5.0]).map(Result::unwrap).collect();
    assert_eq!((&at[0].q, &at[2].q), (&states[9].q, &states[99].q));
    assert!(at[1].q != at[0].q && at[1].t == 0.52);
}

/// Draws that follow one another, so that no step can be repeated.
struct Draws(f64);

impl Noise for Draws {
    fn increments(&mut self, _: u64, _: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        for dw in dw {
            self.0 = (self.0 * 1.7 + 0.1).fract();
            *dw = 0.1 * (self.0 - 0.5);
        }
        Ok(())
    }
}

#[test]
fn only_replayable_increments_are_drawn_for_many_steps() {
    let single = ring(Endpoint);
    let mut path = single.trajectory(start(), 0.05, Draws(0.3));
    let end = path.advance(50).unwrap().clone();
    assert_eq!(COUNTS.get(), [1, 50, 0, 0]);
    let expected = single
        .trajectory(start(), 0.05, Draws(0.3))
        .take(50)
        .last()
        .unwrap()
        .unwrap();
    assert_eq!(end, expected);
    // four blocks of 16, 16, 16 and 2 steps
    COUNTS.set([0; 4]);
    let mut ring = ring(Endpoint);
    ring.trajectory(start(), 0.05, NoNoise).advance(50).unwrap();
    assert_eq!(COUNTS.get(), [1, 0, 50, 4]);
    // tables stay until the system changes
    ring.trajectory(start(), 0.05, NoNoise).advance(1).unwrap();
    assert_eq!(COUNTS.get(), [1, 0, 51, 5]);
    ring.system_mut().k = 1.0;
    ring.trajectory(start(), 0.05, NoNoise).advance(1).unwrap();
    assert_eq!(COUNTS.get(), [2, 0, 52, 6]);
}

/// A step that fails within a block is found, and the state is the one before it.
#[test]
fn a_failing_step_is_the_same_in_a_block() {
    let ring = Integrator::new(Ring { k: 1e9, sigma: 0.3 }, Endpoint);
    let path = || ring.trajectory(start(), 1.0, Wiener::new(5));
    let states: Vec<_> = path().collect();
    let (error, before) = states.split_last().unwrap();
    assert!(before.len() > 17, "{}", before.len());
    let mut at_once = path();
    assert_eq!(
        &at_once.advance(1000).unwrap_err(),
        error.as_ref().unwrap_err()
    );
    assert_eq!(at_once.step(), before.len() as u64);
    assert_eq!(at_once.state(), before[before.len() - 1].as_ref().unwrap());
    assert!(at_once.next().is_none());
    assert!(path().nth(1000).is_none());
}

#[test]
fn a_recorded_path_ends_with_an_error_that_says_so() {
    let ring = ring(Endpoint);
    let recorded = Recorded::record(Wiener::new(2), 0.1, 8, 20).unwrap();
    let mut path = ring.trajectory(start(), 0.1, &recorded);
    let error = path.advance(30).unwrap_err();
    let StepError::Noise { source, .. } = &error else {
        panic!("{error}");
    };
    assert!(matches!(source, NoiseError::Exhausted { .. }), "{error}");
    assert_eq!(path.step(), 20);
    let expected = ring.trajectory(start(), 0.1, Wiener::new(2)).nth(19);
    assert_eq!(path.state(), &expected.unwrap().unwrap());
}

#[test]
fn a_snapshot_continues_bit_for_bit() {
    let ring = ring(Composed::new(StormerVerlet, KahanLi8));
    let mut path = ring.trajectory(start(), 0.1, Wiener::new(9));
    path.advance(33).unwrap();
    let snapshot = path.snapshot();
    #[cfg(feature = "serde")]
    let snapshot: Snapshot<State<Vec<f64>>> =
        serde_json::from_str(&serde_json::to_string(&snapshot).unwrap()).unwrap();
    let mut resumed = ring.resume(snapshot, Wiener::new(9)).unwrap();
    assert_eq!(resumed.step(), 33);
    assert_eq!(resumed.advance(50).unwrap(), path.advance(50).unwrap());
}
