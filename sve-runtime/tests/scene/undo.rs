//! A single step that fails after it has changed tiles moves them back.

use sve_runtime::__private::StepShear as Shear;
use sve_runtime::__private::scene::{Phase, Prepared, Row, Scene};
use sve_runtime::StepError;

use super::gathered::{ENDPOINT, H, INITIAL_POINT, VERLET, numbers, rows};
use super::scenes::{Chain, Lattice, Ring};

const ALL: [&[Shear]; 3] = [&ENDPOINT, &VERLET, &INITIAL_POINT];

/// Two drifts.
fn composed() -> Vec<Shear> {
    [VERLET, VERLET].concat()
}

fn step<R: Row, S: Scene<Row = R>>(
    prepared: &mut Prepared,
    scene: &S,
    shears: &[Shear],
    start: &[Vec<R>; 2],
    dw: &[f64],
) -> (Result<(), StepError>, [Vec<R>; 2]) {
    let [mut q, mut p] = start.clone();
    let mut state = Phase {
        q: &mut q,
        p: &mut p,
    };
    let result = prepared.step(scene, shears, &mut state, [0.0, H], dw, false);
    (result, [q, p])
}

/// Makes a step that fails, and returns its error and the restored state.
fn fail<R: Row, S: Scene<Row = R>>(
    prepared: &mut Prepared,
    scene: &S,
    shears: &[Shear],
    start: &[Vec<R>; 2],
    dw: &[f64],
) -> (StepError, [Vec<R>; 2]) {
    let (result, end) = step(prepared, scene, shears, start, dw);
    (result.unwrap_err(), end)
}

/// Checks that numbers that are not finite have their bits, and others differ by no more than some
/// rounding errors of the largest number of their site. A momentum to which a large impulse was
/// added may be lost, and the place by its motion.
fn assert_restored<R: Row>(
    end: &[Vec<R>; 2],
    start: &[Vec<R>; 2],
    has_large_impulse: impl Fn(usize) -> bool,
    what: &str,
) {
    let numbers = |state: &[Vec<R>; 2]| {
        let [q, p] = [&state[0], &state[1]].map(|rows| R::numbers(rows).to_vec());
        q.into_iter().zip(p).collect::<Vec<_>>()
    };
    for (at, (end, start)) in numbers(end).into_iter().zip(numbers(start)).enumerate() {
        let finite = [start.0, start.1, 1.0]
            .into_iter()
            .filter(|x| x.is_finite());
        let largest = finite.fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let rounding = 4.0 * f64::EPSILON * largest;
        let lost = if has_large_impulse(at / R::LENGTH) {
            start.1.abs()
        } else {
            0.0
        };
        for (x, y, lost) in [(end.0, start.0, H * lost), (end.1, start.1, lost)] {
            let is_restored = if y.is_finite() {
                (x - y).abs() <= rounding + lost
            } else {
                x.to_bits() == y.to_bits()
            };
            assert!(is_restored, "{what}: {x} for {y} at {at}");
        }
    }
}

fn is_input(error: &StepError) -> bool {
    matches!(error, StepError::NonFiniteInput { .. })
}

#[test]
fn tiles_before_the_one_that_fails_are_moved_back() {
    let n = 5000;
    let chain = Chain {
        beta: 0.5,
        mass: 1.25,
    };
    let mut prepared = Prepared::new(&chain, n, 0.0).unwrap();
    for shears in ALL {
        let good = [rows::<[f64; 1]>(n, 1), rows(n, 2)];
        let before = step(&mut prepared, &chain, shears, &good, &[]);
        assert_eq!(before.0, Ok(()));
        for at in [0, 1, 600, 1023, 1024, 1025, 2500, n - 2, n - 1] {
            // the bonds of a site at 1e150 overflow, and the site itself does not
            for (array, value) in [
                (0, f64::NAN),
                (1, f64::NAN),
                (0, f64::INFINITY),
                (1, f64::NEG_INFINITY),
                (0, 1e150),
                (1, 1e150),
                (1, f64::MAX),
            ] {
                if shears == INITIAL_POINT && array == 1 && value.is_finite() {
                    continue; // the next step overflows
                }
                let mut start = good.clone();
                start[array][at][0] = value;
                let (error, end) = fail(&mut prepared, &chain, shears, &start, &[]);
                if value.is_finite() {
                    let near = [at.saturating_sub(1), at, at + 1].map(|at| format!("p[{at}]"));
                    let StepError::NonFiniteCoordinate { what, .. } = &error else {
                        panic!("{error}");
                    };
                    assert!(near.contains(what), "{what} for {at}");
                } else {
                    assert!(is_input(&error), "{error}");
                }
                assert_restored(
                    &end,
                    &start,
                    |_| false,
                    &format!("{value} in {array} at {at}"),
                );
            }
        }
        // no impulse stays behind
        assert_eq!(step(&mut prepared, &chain, shears, &good, &[]), before);
    }
}

#[test]
fn copied_nodes_are_moved_back() {
    // borders of rows are copied to consecutive places
    let lattice = Lattice {
        sides: [9, 20, 30],
        around: 0,
    };
    let n = 9 * 20 * 30;
    let mut prepared = Prepared::new(&lattice, n, 0.0).unwrap();
    for shears in ALL {
        for at in [0, 29, 30, 599, 600, 2000, 2069, n - 1] {
            for value in [f64::NAN, 1e150] {
                let mut start = [rows::<[f64; 1]>(n, 3), rows(n, 4)];
                start[0][at][0] = value;
                let (_, end) = fail(&mut prepared, &lattice, shears, &start, &[]);
                let is_near =
                    |site: usize| value.is_finite() && [1, 30, 600].contains(&site.abs_diff(at));
                assert_restored(&end, &start, is_near, &format!("{value} at {at}"));
            }
        }
    }
}

#[test]
fn kicks_by_increments_are_moved_back() {
    let n = 3000;
    let ring = Ring {
        k: vec![1.0; n],
        mass: (0..n).map(|i| 1.0 + (i % 7) as f64).collect(),
        sigma: 0.3,
        s: vec![0.2; n],
        next: (0..n as i64).map(|i| (i + 1) % n as i64).collect(),
    };
    let mut prepared = Prepared::new(&ring, n, 0.0).unwrap();
    let start = [rows::<[f64; 1]>(n, 5), rows(n, 6)];
    for shears in ALL {
        for at in [0, 1, 700, n] {
            let mut dw = numbers(n + 1, 7);
            dw[at] = f64::NAN;
            let (error, end) = fail(&mut prepared, &ring, shears, &start, &dw);
            let named = format!("dw[{at}]");
            assert!(is_input(&error) && error.to_string().contains(&named));
            assert_restored(&end, &start, |_| false, &format!("increment {at}"));
        }
    }
}

/// Largest momenta can overflow on the way back: p + g is rounded up, and then so is (p + g) − g.
#[test]
fn an_overflow_on_the_way_back_gives_the_largest_number() {
    let h = 0.0625;
    let unit = 2.0f64.powi(971); // the last place of the largest number
    let n = 10_000;
    // Two rings, with ends so far apart that the first site has its impulse before the last tile
    // moves.
    let next = |i: i64| match i {
        1023 => 0,
        9999 => 1024,
        _ => i + 1,
    };
    let ring = Ring {
        k: vec![1.0; n],
        mass: vec![1e300; n],
        sigma: 0.0,
        s: vec![0.0; n],
        next: (0..n as i64).map(next).collect(),
    };
    let dw = vec![0.0; n + 1];
    let shears = [
        Shear::Drift {
            h,
            friction: [0.0; 2],
            parts: [0.0; 2],
            at: [0.0; 2],
        },
        Shear::Kick {
            h,
            part: 1.0,
            at: 0.0,
        },
    ];
    // an impulse of -1.5 units on the first site
    let mut start = [vec![[-1.5 * unit / h]; n], vec![[0.0]; n]];
    start[0][0] = [0.0];
    start[0][1023] = [0.0];
    start[1][0] = [f64::MAX];
    let mut prepared = Prepared::new(&ring, n, 0.0).unwrap();
    let (result, [_, p]) = step(&mut prepared, &ring, &shears, &start, &dw);
    assert_eq!(result, Ok(()));
    let moved = p[0][0];
    assert_eq!(
        (moved, moved + 1.5 * unit),
        (f64::MAX - unit, f64::INFINITY)
    );
    start[1][n - 1] = [f64::NAN];
    let (error, end) = fail(&mut prepared, &ring, &shears, &start, &dw);
    assert!(is_input(&error) && error.to_string().contains(&format!("p[{}]", n - 1)));
    assert_eq!(end[1][0], [f64::MAX]);
    assert_eq!(end[0][1..], start[0][1..]);
}

#[test]
fn steps_of_several_drifts_are_restored_bit_for_bit() {
    let n = 5000;
    let chain = Chain {
        beta: 0.5,
        mass: 1.25,
    };
    let mut prepared = Prepared::new(&chain, n, 0.0).unwrap();
    for at in [0, 2500, n - 1] {
        let mut start = [rows::<[f64; 1]>(n, 1), rows(n, 2)];
        start[0][at][0] = 1e100;
        let (_, end) = fail(&mut prepared, &chain, &composed(), &start, &[]);
        assert_eq!(end, start);
    }
}
