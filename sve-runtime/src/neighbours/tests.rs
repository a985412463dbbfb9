//! Lists against all pairs, their expiry, and the order of space.

use super::order::hilbert;
use super::{NeighbourError, Neighbours, squared};
use crate::noise::threefry;

/// Returns numbers in [0, 1).
fn uniform<const D: usize>(seed: u64, count: usize) -> Vec<[f64; D]> {
    let number = |k: usize, axis: usize| {
        let [word, ..] = threefry::block([k as u64, axis as u64, 0, 0], [seed, 0, 0, 0]);
        (word >> 11) as f64 / (1_u64 << 53) as f64
    };
    let at = |k| core::array::from_fn(|axis| number(k, axis));
    (0..count).map(at).collect()
}

/// Returns the rows that all pairs give.
fn all_pairs<const D: usize>(near: &Neighbours<D>, q: &[[f64; D]], reach: f64) -> Vec<Vec<usize>> {
    let is_near = |i: usize, j: usize| squared(near.separation(q[i], q[j])) <= reach * reach;
    let row = |i| (i + 1..q.len()).filter(|&j| is_near(i, j)).collect();
    (0..q.len()).map(row).collect()
}

/// Checks the lists of some positions and returns the number of pairs.
fn check<const D: usize>(mut near: Neighbours<D>, q: &[[f64; D]]) -> usize {
    near.rebuild(q).unwrap();
    assert_eq!((near.start.len(), near.start[0]), (q.len() + 1, 0));
    assert_eq!(near.start[q.len()], near.list.len());
    let expected = all_pairs(&near, q, near.cutoff() + near.skin());
    for (i, expected) in expected.iter().enumerate() {
        assert_eq!(
            near.of(i),
            expected,
            "row {i} of {} in {:?}",
            q.len(),
            near.lengths()
        );
    }
    near.list.len()
}

/// Checks random gases, in space and in boxes, with particles on both sides of the borders.
fn check_gases<const D: usize>() {
    let mut pairs = 0;
    for (seed, count) in (0..).zip([0, 1, 2, 3, 20, 400, 400, 400]) {
        for side in [2.0, 2.000_01, 2.9, 3.0, 4.5, 10.0, 40.0] {
            let mut q = uniform::<D>(seed, count);
            for at in q.iter_mut().flatten() {
                *at = side * (3.0 * *at - 1.0);
            }
            pairs += check(Neighbours::open(0.8, 0.2).unwrap(), &q);
            let mut lengths = [side; D];
            pairs += check(Neighbours::periodic(0.8, 0.2, lengths).unwrap(), &q);
            lengths[D - 1] = 1.7 * side;
            lengths[0] = f64::INFINITY;
            pairs += check(Neighbours::periodic(1.0, 0.0, lengths).unwrap(), &q);
        }
    }
    assert!(pairs > 100_000, "{pairs}");
}

#[test]
fn lists_are_those_of_all_pairs() {
    check_gases::<1>();
    check_gases::<2>();
    check_gases::<3>();
}

/// Particles on a lattice lie on the borders of cells and boxes, and many distances equal the
/// reach.
#[test]
fn lattices_on_borders_of_cells_have_all_pairs() {
    let q: Vec<_> = (0..6 * 5 * 4)
        .map(|k| [k / 20, k / 4 % 5, k % 4].map(f64::from))
        .collect();
    for (cutoff, per_particle) in [(1.0, 3), (2.0, 16)] {
        let lengths = [6.0, 5.0, 4.0];
        let pairs = check(Neighbours::periodic(cutoff, 0.0, lengths).unwrap(), &q);
        let doubled = if cutoff == 2.0 { 120 / 2 } else { 0 }; // both images at half the box
        assert_eq!(pairs, 120 * per_particle - doubled);
        check(Neighbours::open(cutoff, 0.0).unwrap(), &q);
    }
}

/// Checks particles that are far apart, and dense clusters in a large box: buckets are shared.
#[test]
fn clusters_far_apart_have_all_pairs() {
    let mut q = uniform::<3>(1, 300);
    for (k, at) in q.iter_mut().enumerate() {
        *at = at.map(|x| 4.0 * x);
        at[k % 3] += [0.0, 1e5, -3e7][k / 100];
    }
    assert!(check(Neighbours::open(1.0, 0.0).unwrap(), &q) > 300);
    assert!(check(Neighbours::periodic(1.0, 0.0, [1e8; 3]).unwrap(), &q) > 300);
}

#[test]
fn lists_expire_where_twice_a_displacement_exceeds_the_skin() {
    let mut near = Neighbours::periodic(1.0, 0.5, [8.0, 8.0]).unwrap();
    let q = [[0.25, 1.0], [3.0, 3.0]];
    assert!(!near.is_valid(&q));
    assert!(near.update(&q).unwrap());
    assert!(!near.update(&q).unwrap());
    let moved = |axis: usize, by: f64| {
        let mut q = q;
        q[1][axis] += by;
        q
    };
    for axis in [0, 1] {
        for sign in [1.0, -1.0] {
            assert!(near.is_valid(&moved(axis, sign * 0.25)));
            assert!(!near.is_valid(&moved(axis, sign * 0.250_000_000_1)));
            // into another image
            assert!(near.is_valid(&moved(axis, sign * 8.25)));
            assert!(!near.is_valid(&moved(axis, sign * 7.5)));
        }
    }
    assert!(!near.is_valid(&moved(0, f64::NAN)));
    assert!(!near.is_valid(&q[..1]));
    let empty: [[f64; 2]; 0] = [];
    near.rebuild(&empty).unwrap();
    assert!(near.is_valid(&empty) && near.start == [0]);
}

/// Moves one particle as fast as the bound for so many steps, and for one more.
#[test]
fn lists_are_valid_for_the_steps_that_a_speed_allows() {
    let mut near = Neighbours::periodic(1.0, 0.5, [8.0]).unwrap();
    let start = [[0.25], [3.0]];
    assert_eq!(near.valid_steps(&start, 1.0, 0.01), 0);
    near.rebuild(&start).unwrap();
    // the last one in another image
    for (before, speed, h) in [(0.0, 3.0, 0.0101), (0.1, 0.7, 0.02), (-8.2, 5.0, -0.003)] {
        let at = |steps: u64| [[0.25], [3.0 + before + steps as f64 * speed * h]];
        let steps = near.valid_steps(&at(0), speed, h);
        assert!(steps > 2 && near.is_valid(&at(steps)), "{steps}");
        assert!(!near.is_valid(&at(steps + 1)), "{steps}");
    }
    assert_eq!(near.valid_steps(&start, 0.0, 0.01), u64::MAX);
    assert_eq!(near.valid_steps(&start, f64::NAN, 0.01), 0);
    assert_eq!(near.valid_steps(&[[0.25], [3.3]], 1.0, 0.01), 0);
    assert_eq!(near.valid_steps(&[[0.25], [f64::NAN]], 1.0, 0.01), 0);
}

#[test]
fn valid_lists_have_every_pair_within_the_cutoff() {
    let (side, skin) = (7.0, 0.4);
    let mut near = Neighbours::periodic(1.0, skin, [side; 3]).unwrap();
    let q = uniform::<3>(5, 1000)
        .iter()
        .map(|at| at.map(|x| side * x))
        .collect::<Vec<_>>();
    near.rebuild(&q).unwrap();
    for seed in 0..5 {
        let mut moved = q.clone();
        for (at, direction) in moved.iter_mut().zip(uniform::<3>(100 + seed, 1000)) {
            let direction = direction.map(|x| x - 0.5);
            let length = 2.0 * squared(direction).sqrt() * (1.0 + 1e-9);
            *at = core::array::from_fn(|axis| at[axis] + skin * direction[axis] / length);
        }
        assert!(near.is_valid(&moved));
        let mut skipped = 0;
        for (i, within) in all_pairs(&near, &moved, 1.0).iter().enumerate() {
            assert!(within.iter().all(|j| near.of(i).contains(j)));
            skipped += near.of(i).len() - within.len();
        }
        assert!(skipped > 100);
    }
}

#[test]
fn vectors_are_positions() {
    use nalgebra::Vector2;
    let mut near = Neighbours::open(1.0, 0.1).unwrap();
    near.rebuild(&[Vector2::new(0.0, 0.0), Vector2::new(0.5, 0.5)])
        .unwrap();
    assert_eq!(near.list, [1]);
}

#[test]
fn wrong_numbers_are_errors_that_name_them() {
    use NeighbourError::{Box, Cutoff, Length, Position, Skin};
    for cutoff in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(
            Neighbours::<3>::open(cutoff, 0.1).unwrap_err(),
            Cutoff { cutoff }
        );
    }
    assert!(Neighbours::<3>::open(f64::NAN, 0.1).is_err());
    assert_eq!(
        Neighbours::<2>::open(1.0, -0.1).unwrap_err(),
        Skin { skin: -0.1 }
    );
    let short = Neighbours::periodic(1.0, 0.5, [3.0, 2.999]).unwrap_err();
    assert_eq!(
        short,
        Box {
            axis: 1,
            length: 2.999,
            reach: 1.5
        }
    );
    assert!(Neighbours::periodic(1.0, 0.5, [f64::NAN]).is_err());
    for periodic in [false, true] {
        let length = if periodic { 4.0 } else { f64::INFINITY };
        let mut near = Neighbours::periodic(1.0, 0.5, [length; 2]).unwrap();
        near.rebuild(&[[0.0, 0.0], [1.0, 0.0]]).unwrap();
        let before = near.clone();
        for value in [f64::INFINITY, f64::NEG_INFINITY, 1e12] {
            let error = near
                .rebuild(&[[0.0; 2], [1.0; 2], [0.0, value]])
                .unwrap_err();
            assert_eq!(
                error,
                Position {
                    particle: 2,
                    axis: 1,
                    value
                }
            );
        }
        assert!(near.rebuild(&[[0.0; 2], [f64::NAN, 0.0]]).is_err());
        assert!(near.order(&[[0.0; 2], [f64::NAN, 0.0]]).is_err());
        assert_eq!(near, before);
    }
    let order = Neighbours::open(1.0, 0.0).unwrap().order(&[[0.0]]).unwrap();
    assert_eq!(
        order.apply(&[1, 2]).unwrap_err(),
        Length {
            expected: 1,
            found: 2
        }
    );
}

/// The curve visits all cells of a cube, one after the other.
#[test]
fn the_curve_steps_to_a_neighbour() {
    let mut cells: Vec<[u32; 3]> = (0..512).map(|k| [k / 64, k / 8 % 8, k % 8]).collect();
    cells.sort_unstable_by_key(|&cell| hilbert(cell));
    for (place, cell) in cells.iter().enumerate() {
        assert_eq!(hilbert(*cell), place as u64);
    }
    for pair in cells.windows(2) {
        let steps: u32 = (0..3)
            .map(|axis| pair[0][axis].abs_diff(pair[1][axis]))
            .sum();
        assert_eq!(steps, 1);
    }
}

/// Numbers the particles of a shuffled lattice anew.
#[test]
fn the_order_of_space_is_a_permutation_that_brings_neighbours_together() {
    let side = 12;
    let count = side * side * side;
    let mut places: Vec<_> = uniform::<1>(9, count).into_iter().zip(0..count).collect();
    places.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap());
    let at = |k: usize| [k / (side * side), k / side % side, k % side].map(|x| x as f64 - 5.0);
    let q: Vec<[f64; 3]> = places.into_iter().map(|(_, k)| at(k)).collect();
    let mut near = Neighbours::periodic(1.1, 0.1, [side as f64; 3]).unwrap();
    let distance = |near: &Neighbours<3>| {
        let rows = (0..count).map(|i| near.of(i).iter().map(|j| j - i).sum::<usize>());
        rows.sum::<usize>() as f64 / near.list.len() as f64
    };
    near.rebuild(&q).unwrap();
    let before = distance(&near);
    let order = near.order(&q).unwrap();
    let mut numbers = order.old_numbers().to_vec();
    assert!((0..count).all(|new| order.new_numbers()[numbers[new]] == new));
    numbers.sort_unstable();
    assert!(numbers.into_iter().eq(0..count));
    near.rebuild(&order.apply(&q).unwrap()).unwrap();
    let after = distance(&near);
    // random numbers are a third of all apart
    assert!((before / count as f64 - 1.0 / 3.0).abs() < 0.02, "{before}");
    assert!(after < 0.3 * before, "{after} of {before}");
}
