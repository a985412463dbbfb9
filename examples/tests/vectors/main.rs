//! Steps of scenes have the same bits with the vectors of every machine and with the wider ones of
//! this machine.
//!
//! Builds with debug assertions have one version of each step, so that this runs with `--release`.
//! The versions for AVX-512 run on machines that have it.

#![cfg(any(not(debug_assertions), clippy))]

#[allow(dead_code)] // wrappers of scenes that only the tests of the runtime use
#[path = "../../../sve-runtime/tests/scene/scenes.rs"]
mod printed;
mod scenes;

use std::f64::consts::TAU;

use sve_runtime::__private::{Vectors, use_vectors};
use sve_runtime::StepError;
use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

use printed::{Bodies, Lattice, Polymer};
use scenes::{Chain, Dragged, Ring, Rotors};

/// The size of a step, and the number of steps of a trajectory; a block has more.
const H: f64 = 0.02;
const STEPS: u64 = 20;

/// The numbers of a state, as they are stored.
type Bits = Vec<u64>;

/// Checks that a computation has the same bits with all vectors of this machine.
fn check(what: &str, compute: &dyn Fn() -> Result<Bits, StepError>) {
    assert!(use_vectors(Vectors::Base));
    let base = compute().unwrap_or_else(|error| panic!("{what}: {error}"));
    for vectors in [Vectors::Avx2, Vectors::Avx512] {
        if use_vectors(vectors) {
            let bits = compute().unwrap_or_else(|error| panic!("{what}, {vectors:?}: {error}"));
            let others = base.iter().zip(&bits).filter(|(x, y)| x != y).count();
            let all = base.len();
            assert_eq!(
                others, 0,
                "{what}, {vectors:?}: {others} of {all} numbers differ"
            );
        }
    }
}

/// Checks a trajectory, whose steps are made in a block, and single steps, which test each number.
macro_rules! check {
    ($scene:expr, $start:expr, $processes:expr, $($rule:expr),+) => {{
        let (scene, start, processes) = (&$scene, $start, $processes);
        $(
            let what = concat!(stringify!($scene), ", ", stringify!($rule));
            let integrator = Integrator::new(scene, $rule);
            check(what, &|| {
                let path = || integrator.trajectory(start.clone(), H, Wiener::new(3));
                let mut state = path().advance(STEPS)?.clone();
                let mut bits = bits_of(&state);
                let one_by_one = path().take(STEPS as usize).last();
                assert_eq!(one_by_one, Some(Ok(state.clone())), "{what}");
                for seed in 0..3 {
                    let dw: Vec<f64> = spread(processes, seed).map(|x| 0.1 * x).collect();
                    integrator.step(&mut state, H, &dw)?;
                }
                bits.extend(bits_of(&state));
                Ok(bits)
            });
        )+
    }};
}

fn bits_of<Q: Site>(state: &State<Vec<Q>>) -> Bits
where
    Vec<Q>: sve_runtime::Configuration<Momentum = Vec<Q>>,
{
    let numbers = [&state.q, &state.p].map(|sites| sites.iter().flat_map(|site| site.numbers()));
    numbers.into_iter().flatten().map(f64::to_bits).collect()
}

/// A site as its numbers.
trait Site: Copy {
    fn numbers(self) -> Vec<f64>;
}

impl Site for f64 {
    fn numbers(self) -> Vec<f64> {
        vec![self]
    }
}

impl Site for Vector3<f64> {
    fn numbers(self) -> Vec<f64> {
        self.as_slice().to_vec()
    }
}

/// Returns different numbers between −1 and 1.
fn spread(n: usize, seed: u64) -> impl Iterator<Item = f64> {
    let at = move |i: usize| (TAU * (0.618_033_988_749_895 * i as f64 + 0.1 * seed as f64)).sin();
    (0..n).map(at)
}

fn sites(n: usize) -> State<Vec<f64>> {
    State::new(spread(n, 1).collect(), spread(n, 2).collect())
}

/// Returns bodies near the sites of a square lattice.
fn bodies(n: usize) -> State<Vec<Vector3<f64>>> {
    let side = n.isqrt();
    let near = |(i, x): (usize, f64)| {
        Vector3::new((i % side) as f64 + 0.2 * x, (i / side) as f64 - 0.1 * x, x)
    };
    let q = spread(n, 4).enumerate().map(near).collect();
    State::new(
        q,
        spread(n, 5)
            .map(|x| Vector3::new(0.3 * x, 0.2 - x, 0.1))
            .collect(),
    )
}

#[test]
fn steps_of_scenes_have_the_same_bits_with_all_vectors() {
    gathered();
    listed();
    written();
    with_velocities();
    assert!(use_vectors(Vectors::Base));
}

/// Scenes whose loops are gathered from slices. Their lengths are no multiples of a tile, which has
/// 1024 sites, or of a vector.
fn gathered() {
    let n = 2 * 1024 + 77;
    let chain = Chain {
        mass: spread(n, 6).map(|x| 2.0 + x).collect(),
        sigma: 0.1,
    };
    check!(
        chain,
        sites(n),
        n,
        InitialPoint,
        Endpoint,
        StormerVerlet,
        Midpoint
    );
    check!(chain, sites(n), n, Composed::new(StormerVerlet, KahanLi8));
    let ring = Ring { beta: 0.5, nu: 0.3 };
    check!(ring, sites(n), 0, Endpoint, StormerVerlet);
    let lattice = Lattice {
        sides: [37, 31],
        around: 1,
    };
    check!(lattice, sites(37 * 31), 0, Endpoint);
}

/// Lists of bonds, which are gathered where they have runs.
fn listed() {
    let n = 1000;
    // chains of 25 atoms, in the order of their atoms, and bonds between any atoms
    let chains = (1..n).filter(|i| i % 25 != 0).map(|i| [i - 1, i]);
    let any = (0..n / 2).map(|i| [i, (i * i + 1) % n]);
    let any = any.filter(|[i, j]| i != j);
    for bonds in [chains.collect(), any.collect()] {
        let (k, length) = (0.7, 1.1);
        let polymer = Polymer { bonds, k, length };
        check!(polymer, bodies(n), 0, Endpoint);
    }
    // two noises, and neighbours from a list without runs
    let ring = printed::Ring {
        k: spread(n, 7).map(|x| 1.0 + 0.5 * x).collect(),
        mass: spread(n, 8).map(|x| 2.0 + x).collect(),
        sigma: 0.1,
        s: spread(n, 9).collect(),
        next: (0..n as i64).map(|i| (7 * i + 3) % n as i64).collect(),
    };
    check!(ring, sites(n), 1 + n, Endpoint, StormerVerlet);
}

/// Sums over all pairs, which are made in blocks, and sums that enter formulas.
fn written() {
    let (k, softening) = (0.01, 0.5);
    let pairs = Bodies { k, softening };
    check!(pairs, bodies(150), 0, Endpoint);
    let (coupling, sigma) = (0.8, 0.2);
    let rotors = Rotors { coupling, sigma };
    check!(rotors, sites(1001), 1000, Endpoint, StormerVerlet);
}

/// A scene whose drifts need velocities, for forces and for H₁.
fn with_velocities() {
    let dragged = Dragged { sigma: 0.1 };
    check!(dragged, sites(1001), 1001, StormerVerlet);
}
