//! A step and a trajectory do not allocate: counted, for explicit, linear and Newton steps, and for
//! scenes after the first step.

use allocation_counter::measure;
use sve_models::oracle::{cases, double_pendulum, kubo, mixed, oscillator, pendulum};
use sve_models::random::Random;
use sve_runtime::Variational;
use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

fn allocations(run: impl FnOnce()) -> u64 {
    measure(run).count_total
}

/// The counter sees an allocation.
#[test]
fn are_counted() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1.0]))), 1);
    assert_eq!(allocations(|| ()), 0);
}

#[test]
fn no_step_allocates() {
    let mut random = Random::new(20);
    for case in cases() {
        let start = case.model().point(&mut random);
        let dw = vec![0.1; case.dimensions().1];
        let mut count = u64::MAX;
        case.watched(&start, 0.01, &dw, 10, &mut |steps| {
            count = allocations(steps);
        });
        assert_eq!(count, 0, "{}", case.plan());
    }
}

fn trajectory<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    kind: BlockKind,
    start: State<[f64; N]>,
) where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    assert_eq!(integrator.plan().kind(), kind);
    let recorded = Recorded::record(Wiener::new(1), 0.01, M, 1000).unwrap();
    let mut sum = 0.0;
    let count = allocations(|| {
        for state in integrator.trajectory(start, 0.01, &recorded) {
            sum += state.unwrap().q[0];
        }
        for state in integrator.trajectory(start, 0.01, NoNoise).take(1000) {
            sum += state.unwrap().q[0];
        }
    });
    assert!(sum.is_finite());
    assert_eq!(count, 0, "{}", integrator.plan());

    // a Wiener path keeps its increments in place
    let count = allocations(|| {
        for state in integrator
            .trajectory(start, 0.01, Wiener::new(1))
            .take(1000)
        {
            sum += state.unwrap().q[0];
        }
    });
    assert_eq!(count, 0, "{}", integrator.plan());
}

/// Steps that are solved by continuation do not allocate either. Far beyond useful step sizes there
/// are many of them.
#[test]
fn in_a_step_that_is_followed() {
    let system = double_pendulum();
    let integrator = Integrator::new(&system, Midpoint);
    let mut random = Random::new(3);
    let (mut solved, mut lost) = (0, 0);
    for _ in 0..300 {
        let mut state = State::new(random.array(-3.0, 3.0), random.array(-3.0, 3.0));
        let mut result = Ok(());
        let count = allocations(|| result = integrator.step(&mut state, 0.5, &[0.0; 2]));
        if result.is_ok() {
            assert_eq!(count, 0);
            solved += 1;
        } else {
            lost += 1;
        }
    }
    // some of these steps fail
    assert!(solved > 100 && lost > 10, "{solved} {lost}");
}

#[test]
fn in_a_trajectory() {
    let start = State::new([1.0], [0.5]);
    trajectory(
        &Integrator::new(oscillator(), Endpoint),
        BlockKind::Explicit,
        start,
    );
    trajectory(&Integrator::new(kubo(), Midpoint), BlockKind::Linear, start);
    trajectory(
        &Integrator::new(pendulum(), Midpoint),
        BlockKind::Newton,
        start,
    );
    let start = State::new([0.2, 0.1], [0.1, 0.2]);
    trajectory(
        &Integrator::new(mixed(), Midpoint),
        BlockKind::Newton,
        start,
    );
}

struct Wells {
    sigma: f64,
}

#[variational(gauss(3), gauss(4))]
impl Wells {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.25 * (q * q - 1.0).powi(2)
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// Newton's method, fixed-point iteration, and the change from one to the other.
#[test]
fn no_step_of_many_stages_allocates() {
    let wells = &Wells { sigma: 0.3 };
    for h in [0.01, 2.0] {
        let count = allocations(|| {
            let mut ends = [State::new([1.2], [0.3]); 2];
            Integrator::new(wells, Gauss::<3>)
                .step(&mut ends[0], h, &[0.1])
                .unwrap();
            Integrator::new(wells, Gauss::<4>)
                .step(&mut ends[1], h, &[0.1])
                .unwrap();
        });
        assert_eq!(count, 0, "h = {h}");
    }
}

/// A chain with a process a site, and springs between sites that a list names.
struct Net {
    sigma: f64,
    bonds: Vec<[usize; 2]>,
}

#[variational(stormer_verlet, midpoint)]
impl Net {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i] * v[i] - 0.5 * q[i] * q[i];
        }
        for i in 1..q.len() {
            l -= 0.25 * (q[i] - q[i - 1]).powi(4);
        }
        for k in 0..self.bonds.len() {
            l -= 0.5 * (q[self.bonds[k][1]] - q[self.bonds[k][0]]).powi(2);
        }
        l
    }

    #[gamma]
    fn bath(&self, q: &[f64]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * q.sin()).collect()
    }
}

/// Rotors with a mean field, a noise that moves them, and a force between them that depends on
/// their velocities.
struct Rotors {
    sigma: f64,
}

#[variational(stormer_verlet, midpoint)]
impl Rotors {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mean = q.iter().map(|q| q.cos()).sum::<f64>() / q.len() as f64;
        let kinetic: f64 = v.iter().map(|v| 0.5 * v * v).sum();
        kinetic + 0.5 * q.len() as f64 * mean * mean
    }

    #[h1]
    fn shake(&self, q: &[f64], p: &[f64]) -> Vec<f64> {
        (0..q.len())
            .map(|i| self.sigma * p[i] * q[i].sin())
            .collect()
    }

    #[force]
    fn drag(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        (0..q.len())
            .map(|i| 0.1 * (v[(i + 1) % q.len()] - v[i]).sin())
            .collect()
    }
}

const SITES: usize = 1000;

fn net() -> Integrator<Net, StormerVerlet> {
    Integrator::new(bonded(), StormerVerlet)
}

fn bonded() -> Net {
    let bonds = (0..SITES).map(|i| [i, i * i % SITES]).collect();
    Net { sigma: 0.1, bonds }
}

fn at_rest() -> State<Vec<f64>> {
    let q = (0..SITES).map(|i| (i as f64).sin()).collect();
    State::new(q, vec![0.0; SITES])
}

/// The first step makes the tables.
#[test]
fn no_step_of_a_scene_allocates_after_the_first() {
    let net = net();
    check_steps(|state, h, dw| net.step(state, h, dw));
    let bonded = Integrator::new(bonded(), Midpoint);
    check_steps(|state, h, dw| bonded.step(state, h, dw));
    let rotors = Integrator::new(Rotors { sigma: 0.2 }, StormerVerlet);
    check_steps(|state, h, dw| rotors.step(state, h, dw));
    let rotors = Integrator::new(Rotors { sigma: 0.2 }, Midpoint);
    check_steps(|state, h, dw| rotors.step(state, h, dw));
    for noise in [Some(Wiener::new(1)), None] {
        let count = match noise {
            Some(noise) => advanced(net.trajectory(at_rest(), 0.01, noise)),
            None => advanced(net.trajectory(at_rest(), 0.01, NoNoise)),
        };
        assert_eq!(count, 0, "with noise: {}", noise.is_some());
    }
}

fn check_steps(step: impl Fn(&mut State<Vec<f64>>, f64, &[f64]) -> Result<(), StepError>) {
    let (mut state, dw) = (at_rest(), vec![0.01; SITES]);
    let mut step = || step(&mut state, 0.01, &dw).unwrap();
    let first = allocations(&mut step);
    let rest = allocations(|| (0..10).for_each(|_| step()));
    assert!(first > 0 && rest == 0, "{first} {rest}");
}

/// Returns the number of allocations of a trajectory after its first steps.
fn advanced<I: OneStepMethod, W: Noise>(mut path: sve_runtime::Trajectory<'_, I, W>) -> u64 {
    path.advance(5).unwrap();
    allocations(|| {
        path.advance(100).unwrap();
    })
}

/// A chain of equal masses, whose tables do not grow with its length.
struct Springs;

#[variational(endpoint, stormer_verlet)]
impl Springs {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i] * v[i] - 0.25 * q[i].powi(4);
        }
        for i in 1..q.len() {
            l -= 0.5 * (q[i] - q[i - 1]).powi(2);
        }
        l
    }
}

/// Returns the arrays of the length of a chain that its first step leaves allocated.
fn kept(step: impl Fn(&mut State<Vec<f64>>) -> Result<(), StepError>) -> f64 {
    const MANY: usize = 100_000;
    let mut state = State::new(vec![0.1; MANY], vec![0.0; MANY]);
    let info = measure(|| step(&mut state).unwrap());
    info.bytes_current as f64 / (8 * MANY) as f64
}

/// A step that can be made backwards keeps no copy, or one of the momenta alone.
#[test]
fn an_integrator_keeps_only_the_copies_that_its_steps_need() {
    let endpoint = Integrator::new(Springs, Endpoint);
    let verlet = Integrator::new(Springs, StormerVerlet);
    let composed = Integrator::new(Springs, Composed::new(StormerVerlet, KahanLi8));
    let single = [
        kept(|state| endpoint.step(state, 0.1, &[])),
        kept(|state| verlet.step(state, 0.1, &[])),
        kept(|state| composed.step(state, 0.1, &[])),
    ];
    for (kept, arrays) in single.into_iter().zip([0.0, 1.0, 2.0]) {
        assert!((kept - arrays).abs() < 0.1, "{kept} {arrays}");
    }
}

/// Only states that are returned are copied.
#[test]
fn skipped_states_of_a_scene_are_not_copied() {
    let net = net();
    let path = || net.trajectory(at_rest(), 0.001, NoNoise);
    // the second step of a block is the first that shares a sweep
    path().advance(2).unwrap();
    let copies = |run: &mut dyn FnMut()| {
        let bytes = measure(run).bytes_total;
        bytes as f64 / (16 * SITES) as f64
    };
    // the start of each path is a copy that is not counted
    let mut paths = [path(), path(), path(), path()];
    for path in &mut paths {
        path.advance(1).unwrap();
    }
    let [nth, every, at, until] = paths;
    let mut nth = nth;
    let nth = copies(&mut || drop(nth.nth(99)));
    let mut every = every.every(100);
    let every = copies(&mut || drop(every.by_ref().take(4).last()));
    let mut at = at.at([0.1, 0.2]);
    let at = copies(&mut || drop(at.by_ref().last()));
    let mut until = until.every(1000).until(0.2);
    let until = copies(&mut || drop(until.by_ref().last()));
    for (copies, states) in [(nth, 1.0), (every, 4.0), (at, 2.0), (until, 2.0)] {
        assert!((copies - states).abs() < 0.01, "{copies} {states}");
    }
}

/// A file of frames needs the memory of a few states.
#[test]
fn frames_are_not_kept() {
    let net = net();
    let path = || {
        net.trajectory(at_rest(), 0.001, NoNoise)
            .every(1)
            .until(0.1)
    };
    let name = format!("sve-frames-{}", std::process::id());
    let file = std::env::temp_dir().join(name);
    let most = |write: &mut dyn FnMut()| {
        let bytes = measure(write).bytes_max;
        std::fs::remove_file(&file).unwrap();
        bytes as f64 / (16 * SITES) as f64
    };
    // the tables belong to the integrator
    path().nth(1).unwrap().unwrap();
    let npy = most(&mut || path().to_npy(&file).unwrap());
    let xyz = Xyz::<1>::new();
    let xyz = most(&mut || path().to_xyz(&file, &xyz).unwrap());
    // of 101 frames
    assert!(npy < 5.0 && xyz < 5.0, "{npy} {xyz}");
}
