//! Loops that are gathered in segments make the same steps as loops that are made as they are
//! written, and as loops by hand; impulses are the derivatives of the Lagrangian.

use sve_runtime::__private::StepShear as Shear;
use sve_runtime::__private::scene::{Phase, Prepared, Row, Scene};
use sve_runtime::StepError;

use super::scenes::{Argon, AsWritten, Bodies, Chain, Lattice, Polymer, Ring};

pub(super) const VERLET: [Shear; 3] = [
    kick(0.5, 0.0),
    Shear::Drift {
        h: H,
        friction: [0.0; 2],
        parts: [0.0; 2],
        at: [0.0; 2],
    },
    kick(0.5, 1.0),
];
pub(super) const ENDPOINT: [Shear; 2] = [
    Shear::Drift {
        h: H,
        friction: [0.0; 2],
        parts: [0.0; 2],
        at: [0.0; 2],
    },
    kick(1.0, 1.0),
];
pub(super) const INITIAL_POINT: [Shear; 2] = [
    kick(1.0, 0.0),
    Shear::Drift {
        h: H,
        friction: [0.0; 2],
        parts: [0.0; 2],
        at: [0.0; 2],
    },
];
pub(super) const H: f64 = 0.05;

const fn kick(part: f64, at: f64) -> Shear {
    let (h, at) = (part * H, at * H);
    Shear::Kick { h, part, at }
}

/// Numbers between -1 and 1 without a pattern.
pub(super) fn numbers(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    std::iter::repeat_with(next).take(count).collect()
}

pub(super) fn rows<R: Row>(count: usize, seed: u64) -> Vec<R> {
    let mut rows = vec![R::ZERO; count];
    R::numbers_mut(&mut rows).copy_from_slice(&numbers(count * R::LENGTH, seed));
    rows
}

/// Increments that differ from step to step.
fn increments(processes: usize, step: u64) -> impl Iterator<Item = f64> {
    numbers(processes, 3 + step).into_iter().map(|x| 0.2 * x)
}

/// Makes steps one at a time.
fn single<S: Scene>(scene: &S, shears: &[Shear], q: &[S::Row], steps: u64) -> [Vec<S::Row>; 2] {
    let mut prepared = Prepared::new(scene, q.len(), 0.0).unwrap();
    let [mut q, mut p] = [q.to_vec(), rows(q.len(), 2)];
    for step in 0..steps {
        let dw: Vec<f64> = increments(prepared.processes(), step).collect();
        let (q, p) = (&mut q, &mut p);
        let time = [step as f64 * H, H];
        let made = prepared.step(scene, shears, &mut Phase { q, p }, time, &dw, false);
        assert_eq!(made, Ok(()));
    }
    [q, p]
}

/// Makes steps as a trajectory does: in blocks, and one at a time after a block that fails. Returns
/// the number of steps made, and the result of the last one.
pub(super) fn advance<S: Scene>(
    scene: &S,
    shears: &[Shear],
    [q, p]: [&mut [S::Row]; 2],
    steps: u64,
) -> (u64, Result<(), StepError>) {
    let mut prepared = Prepared::new(scene, q.len(), 0.0).unwrap();
    let mut state = Phase { q, p };
    let (mut made, mut t, processes) = (0, 0.0, prepared.processes());
    let mut dw = vec![0.0; processes];
    while made < steps {
        let mut draw = |step: u64, dw: &mut [f64]| {
            let drawn = increments(processes, made + step);
            dw.iter_mut().zip(drawn).for_each(|(dw, x)| *dw = x);
            Some((made + step + 1) as f64 * H)
        };
        let count = steps - made;
        match prepared.block(scene, shears, &mut state, &mut t, &mut dw, count, &mut draw) {
            0 => break,
            block => made += block,
        }
    }
    while made < steps {
        let time = [made as f64 * H, H];
        dw = increments(processes, made).collect();
        if let Err(error) = prepared.step(scene, shears, &mut state, time, &dw, true) {
            return (made, Err(error));
        }
        made += 1;
    }
    (made, Ok(()))
}

/// Makes steps in blocks.
fn blocks<S: Scene>(scene: &S, shears: &[Shear], q: &[S::Row], steps: u64) -> [Vec<S::Row>; 2] {
    let [mut q, mut p] = [q.to_vec(), rows(q.len(), 2)];
    let made = advance(scene, shears, [&mut q, &mut p], steps);
    assert_eq!(made, (steps, Ok(())));
    [q, p]
}

fn assert_near<R: Row>(a: &[Vec<R>; 2], b: &[Vec<R>; 2], tolerance: f64) {
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (R::numbers(a), R::numbers(b));
        assert_eq!(a.len(), b.len());
        let size = a.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
        for (at, (x, y)) in a.iter().zip(b).enumerate() {
            assert!((x - y).abs() <= tolerance * size, "{at}: {x} and {y}");
        }
    }
}

/// Checks that all ways to make steps agree, and that the impulse is the derivative of L.
fn check<S: Scene, W: Scene<Row = S::Row>>(scene: &S, as_written: &W, q: &[S::Row]) {
    let n = q.len();
    let mut prepared = Prepared::new(scene, n, 0.0).unwrap();
    for shears in [&VERLET[..], &ENDPOINT, &INITIAL_POINT] {
        let gathered = single(scene, shears, q, 3);
        assert_near(&gathered, &single(as_written, shears, q, 3), 1e-14);
        // the same bits in blocks, of several lengths
        for steps in [1, 3, if prepared.processes() == 0 { 80 } else { 10 }] {
            let one_by_one = single(scene, shears, q, steps);
            assert_eq!(blocks(scene, shears, q, steps), one_by_one);
            let one_by_one = single(as_written, shears, q, steps);
            assert_eq!(blocks(as_written, shears, q, steps), one_by_one);
        }
    }
    // dp/dt = ∂L/∂q, by differences
    let start = rows::<S::Row>(n, 6);
    let (t, mut p) = (0.7, start.clone());
    let mut state = Phase {
        q: &mut q.to_vec(),
        p: &mut p,
    };
    let shears = [Shear::Kick {
        h: 1.0,
        part: 1.0,
        at: 0.0,
    }];
    let dw = vec![0.0; prepared.processes()];
    let made = prepared.step(scene, &shears, &mut state, [t, 1.0], &dw, false);
    assert_eq!(made, Ok(()));
    let v = start.clone();
    let count = n * S::Row::LENGTH;
    for at in (0..count).step_by((count / 20).max(1)) {
        let shifted = |by: f64| {
            let mut q = q.to_vec();
            S::Row::numbers_mut(&mut q)[at] += by;
            scene.lagrangian(t, &q, &v).unwrap()
        };
        let force = (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
        let impulse = S::Row::numbers(&p)[at] - S::Row::numbers(&start)[at];
        let error = (impulse - force).abs();
        assert!(
            error < 1e-5 * (1.0 + force.abs()),
            "{at}: {impulse}, {force}"
        );
    }
}

const CHAIN: Chain = Chain {
    beta: 0.7,
    mass: 1.5,
};

fn check_ring(next: &[i64]) {
    let away = |seed| (numbers(next.len(), seed).iter().map(|x| 2.0 + x)).collect();
    let ring = Ring {
        k: away(10),
        mass: away(11),
        sigma: 0.3,
        s: away(12),
        next: next.to_vec(),
    };
    check(&ring, &AsWritten(&ring), &rows(next.len(), 1));
}

fn check_lattice<const D: usize>(sides: [usize; D])
where
    Lattice<D>: Scene<Row = [f64; 1]>,
{
    for around in [0, 1] {
        let lattice = Lattice { sides, around };
        check(
            &lattice,
            &AsWritten(&lattice),
            &rows(sides.iter().product(), 1),
        );
    }
}

#[test]
fn chains_of_any_length() {
    for n in [0, 1, 2, 3, 4, 100, 1023, 1024, 1025, 1026, 5001] {
        check(&CHAIN, &AsWritten(&CHAIN), &rows(n, 1));
    }
}

#[test]
fn the_bits_of_a_chain_are_those_of_loops_by_hand() {
    let (n, beta, mass) = (2000, 0.7, 1.5);
    let force = |d: f64| d + beta * (d * d * d);
    let [mut q, mut p] = [numbers(n, 1), numbers(n, 2)];
    for _ in 0..200 {
        for i in 0..n {
            q[i] += H * (1.0 / mass) * p[i];
        }
        p[0] += H * force(q[1] - q[0]);
        for i in 1..n - 1 {
            p[i] += H * (force(q[i + 1] - q[i]) - force(q[i] - q[i - 1]));
        }
        p[n - 1] += -H * force(q[n - 1] - q[n - 2]);
    }
    let [made_q, made_p] = blocks(&CHAIN, &ENDPOINT, &rows(n, 1), 200);
    assert_eq!(made_q.as_flattened(), q);
    assert_eq!(made_p.as_flattened(), p);
}

#[test]
fn rings_of_any_length_with_noise_masses_and_time() {
    for n in [0, 1, 2, 3, 4, 5, 100, 1025, 2500] {
        for shift in [0, 1, 2, 700] {
            let next: Vec<i64> = (0..n).map(|i| (i + shift) % n).collect();
            check_ring(&next);
        }
    }
}

/// Maps of any indices to any others: in pieces of one slope, with nodes that several instances
/// read, and nodes that none reads.
#[test]
fn maps_of_indices_in_pieces() {
    for seed in 1..40 {
        let n = 20 * seed as usize;
        let cut = |x: f64| ((x + 1.0) * 0.5 * n as f64) as i64;
        let mut next = Vec::new();
        for of_piece in numbers(12, seed).chunks(2) {
            let [start, length] = [cut(of_piece[0]), 1 + cut(of_piece[1]) / 3];
            next.extend((start..(start + length).min(n as i64)).take(n - next.len()));
        }
        next.resize(n, 0);
        check_ring(&next);
        // each node once
        let (half, rest) = (n as i64 / 2, n as i64 / 3);
        let turned = (0..n as i64).map(|i| {
            if i < rest {
                i + n as i64 - rest
            } else {
                i - rest
            }
        });
        check_ring(&turned.collect::<Vec<_>>());
        let swapped = (0..2 * half).map(|i| if i < half { i + half } else { i - half });
        check_ring(&swapped.collect::<Vec<_>>());
    }
}

#[test]
fn lattices_with_open_and_periodic_borders() {
    for sides in [[1, 1], [1, 9], [9, 1], [2, 2], [10, 10], [23, 40], [3, 700]] {
        check_lattice(sides);
    }
    check_lattice([30]);
    for sides in [[1, 1, 1], [2, 3, 4], [5, 6, 20], [10, 10, 10]] {
        check_lattice(sides);
    }
}

/// Returns bodies near a grid.
fn grid(n: usize) -> Vec<[f64; 3]> {
    let grid = |i: usize| [i % 4, i / 4 % 4, i / 16].map(|x| 1.1 * x as f64);
    (rows::<[f64; 3]>(n, 1).iter().enumerate())
        .map(|(i, noise)| std::array::from_fn(|x| grid(i)[x] + 0.02 * noise[x]))
        .collect()
}

/// A list of all pairs of which some are beyond the cut-off.
#[test]
fn atoms_of_a_list() {
    let n = 40;
    let mut argon = Argon {
        start: vec![0],
        list: Vec::new(),
        cut2: 4.0,
        mass: 2.0,
    };
    for i in 0..n {
        argon.list.extend(i + 1..n);
        argon.start.push(argon.list.len());
    }
    check(&argon, &argon, &grid(n));
}

#[test]
fn all_pairs_and_lists_of_bonds() {
    for n in [0, 1, 2, 3, 50] {
        let all = Bodies {
            k: 0.3,
            softening: 0.1,
        };
        check(&all, &all, &grid(n));
        let bonds = (1..n).map(|i| [i - 1, i]).chain((9..n).map(|i| [i, i - 9]));
        let list = Polymer {
            bonds: bonds.collect(),
            k: 2.0,
            length: 1.0,
        };
        check(&list, &AsWritten(&list), &grid(n));
    }
}

/// The parts of the loops of the scenes above.
#[test]
fn segments_are_few() {
    let layout = |sides, around| {
        let lattice = Lattice { sides, around };
        let n = sides[0] * sides[1];
        let prepared = Prepared::new(&lattice, n, 0.0).unwrap();
        prepared.layout::<Lattice<2>>(&ENDPOINT)
    };
    let open = layout([50, 40], 0);
    assert_eq!(
        (open.segments, open.instances),
        (150, 2000 + 49 * 40 + 50 * 39)
    );
    assert!((open.border - (2000.0 - 48.0 * 38.0) / 2000.0).abs() < 1e-15);
    let periodic = layout([50, 40], 1);
    assert_eq!((periodic.border, &*periodic.as_written), (0.0, &[][..]));
    // rows of 5 are too short
    let narrow = layout([50, 5], 0);
    assert_eq!(
        narrow.as_written,
        ["the loop `for c in 0..self.sides[0] * self.sides[1]` in `lagrangian`"]
    );
    let prepared = Prepared::new(&CHAIN, 1000, 0.0).unwrap();
    let chain = prepared.layout::<Chain>(&ENDPOINT);
    assert_eq!(
        (chain.segments, chain.instances, chain.border),
        (3, 999, 0.002)
    );
}
