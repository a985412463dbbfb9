//! A step that fails leaves the state as it was, and a trajectory ends before the step that fails.

use sve_runtime::__private::StepShear as Shear;
use sve_runtime::__private::scene::{Phase, Prepared, Row, Scene};
use sve_runtime::StepError;

use super::gathered::{ENDPOINT, H, VERLET, advance, numbers, rows};
use super::scenes::{Argon, AsWritten, Chain, Lattice, Ring};

/// Makes steps in blocks until one fails. Returns their number, the error and the state.
fn until_failure<S: Scene<Row = [f64; 1]>>(
    scene: &S,
    shears: &[Shear],
    start: &[Vec<[f64; 1]>; 2],
) -> (u64, StepError, [Vec<[f64; 1]>; 2]) {
    let [mut q, mut p] = start.clone();
    let (made, result) = advance(scene, shears, [&mut q, &mut p], 10_000);
    (made, result.unwrap_err(), [q, p])
}

#[test]
fn an_overflow_is_found_at_its_step_and_the_state_before_it_restored() {
    // the quartic bonds are too stiff for this step
    let chain = Chain {
        beta: 500.0,
        mass: 1.0,
    };
    for n in [2, 40, 1500] {
        for shears in [&VERLET[..], &ENDPOINT] {
            let start = [rows(n, 1), rows(n, 2)];
            let (made, error, end) = until_failure(&chain, shears, &start);
            assert!(made > 0, "{made}");
            let mut prepared = Prepared::new(&chain, n, 0.0).unwrap();
            let [mut q, mut p] = start;
            for step in 0..made {
                let (q, p) = (&mut q, &mut p);
                let time = [step as f64 * H, H];
                let result = prepared.step(&chain, shears, &mut Phase { q, p }, time, &[], true);
                assert_eq!(result, Ok(()));
            }
            assert_eq!(end, [q.clone(), p.clone()]);
            let time = [made as f64 * H, H];
            let mut state = Phase {
                q: &mut q,
                p: &mut p,
            };
            let result = prepared.step(&chain, shears, &mut state, time, &[], true);
            assert_eq!(result, Err(error.clone()));
            assert_eq!(end, [q, p]);
            assert!(
                matches!(error, StepError::NonFiniteCoordinate { .. }),
                "{error}"
            );
        }
    }
}

#[test]
fn one_coordinate_of_many_that_is_not_finite_is_named() {
    let n = 100_000;
    let chain = Chain {
        beta: 0.1,
        mass: 1.0,
    };
    for at in [0, 600, n - 1] {
        for value in [f64::NAN, f64::INFINITY, 1.5e308] {
            let mut start = [rows::<[f64; 1]>(n, 1), rows(n, 2)];
            start[1][at][0] = value;
            start[0][at][0] = value.abs();
            let (made, error, [q, p]) = until_failure(&chain, &ENDPOINT, &start);
            let bits = |rows: &[[f64; 1]]| rows.iter().map(|x| x[0].to_bits()).collect::<Vec<_>>();
            assert_eq!((made, bits(&q)), (0, bits(&start[0])));
            assert_eq!(bits(&p), bits(&start[1]));
            let text = error.to_string();
            let named = if value.is_finite() {
                format!("gave a p[{}] that is not finite", at.saturating_sub(1))
            } else {
                format!("q[{at}] is {}", value.abs())
            };
            assert!(text.contains(&named), "{text}");
            assert!(text.len() < 300);
        }
    }
}

fn ring(next: Vec<i64>) -> Ring {
    let n = next.len();
    Ring {
        k: vec![1.0; n],
        mass: vec![1.0; n],
        sigma: 0.1,
        s: vec![0.1; n],
        next,
    }
}

fn index(text: &str, index: i64, length: usize) -> StepError {
    let text = text.into();
    StepError::Index {
        t: 0.0,
        text,
        index,
        length,
    }
}

/// Makes a step of a scene with all increments zero. Checks that the state is unchanged after an
/// error.
fn step<S: Scene>(scene: &S, n: usize) -> Result<(), StepError> {
    let mut prepared = Prepared::new(scene, n, 0.0)?;
    let start = [rows::<S::Row>(n, 1), rows(n, 2)];
    let [mut q, mut p] = start.clone();
    let mut state = Phase {
        q: &mut q,
        p: &mut p,
    };
    let dw = vec![0.0; prepared.processes()];
    let result = prepared.step(scene, &VERLET, &mut state, [0.0, H], &dw, true);
    if result.is_err() {
        for (end, start) in [q, p].iter().zip(&start) {
            assert_eq!(S::Row::numbers(end), S::Row::numbers(start));
        }
    }
    result
}

#[test]
fn indices_out_of_range() {
    let n = 100;
    let text = "`q[self.next[i]]` in `lagrangian` (i = 70)";
    for wrong in [-1, n as i64, i64::MIN, i64::MAX] {
        let mut next: Vec<i64> = (0..n as i64).rev().collect();
        next[70] = wrong;
        let expected = Err(index(text, wrong, n));
        let ring = ring(next);
        assert_eq!(step(&ring, n), expected);
        assert_eq!(step(&AsWritten(&ring), n), expected);
    }
    // fields that are too short
    let next: Vec<i64> = (0..n as i64).collect();
    for (field, text) in [
        ("k", "`self.k[i]` in `lagrangian` (i = 60)"),
        ("s", "`self.s[i]` in `noise` (i = 60)"),
        ("mass", "`self.mass[i]` in `lagrangian` (i = 60)"),
    ] {
        let mut ring = ring(next.clone());
        match field {
            "k" => ring.k.truncate(60),
            "s" => ring.s.truncate(60),
            _ => ring.mass.truncate(60),
        }
        assert_eq!(step(&ring, n), Err(index(text, 60, 60)));
        assert_eq!(step(&AsWritten(&ring), n), Err(index(text, 60, 60)));
    }
    // a list
    let argon = Argon {
        start: vec![0, 1, 2],
        list: vec![1, 7],
        cut2: 100.0,
        mass: 1.0,
    };
    let text = "`q[self.list[k]]` in `lagrangian` (i = 1, k = 1)";
    assert_eq!(step(&argon, 2), Err(index(text, 7, 2)));
    let message = step(&argon, 2).unwrap_err().to_string();
    assert!(message.starts_with(&format!("{text} has the index 7 at t = 0")));
}

#[test]
fn masses_without_an_inverse() {
    for wrong in [0.0, f64::NAN, f64::INFINITY] {
        let mut ring = ring((0..50).collect());
        ring.mass[33] = wrong;
        let error = step(&ring, 50).unwrap_err();
        let start = format!("the mass of v[33] is {wrong} at t = 0");
        assert!(error.to_string().starts_with(&start), "{error}");
    }
    let argon = Argon {
        start: vec![0; 3],
        list: vec![],
        cut2: 1.0,
        mass: 0.0,
    };
    let text = step(&argon, 2).unwrap_err().to_string();
    assert!(text.starts_with("the mass of v[0][0] is 0"), "{text}");
}

#[test]
fn a_failed_nest_leaves_no_impulse_behind() {
    // the loop of the springs fails after some instances, and is then repaired
    let mut next: Vec<i64> = (0..64).collect();
    next[40] = 64;
    let mut ring = ring(next);
    let mut prepared = Prepared::new(&AsWritten(&ring), 64, 0.0).unwrap();
    let dw = numbers(65, 1);
    let start = [rows::<[f64; 1]>(64, 1), rows(64, 2)];
    let made = |ring: &Ring, prepared: &mut Prepared| {
        let [mut q, mut p] = start.clone();
        let mut state = Phase {
            q: &mut q,
            p: &mut p,
        };
        let result = prepared.step(&AsWritten(ring), &VERLET, &mut state, [0.0, H], &dw, true);
        (result, [q, p])
    };
    let failed = made(&ring, &mut prepared);
    assert!(failed.0.is_err());
    assert_eq!(failed.1, start);
    ring.next[40] = 3;
    let repaired = made(&ring, &mut prepared);
    assert_eq!(
        repaired,
        made(
            &ring,
            &mut Prepared::new(&AsWritten(&ring), 64, 0.0).unwrap()
        )
    );
}

#[test]
fn sites_that_no_loop_reads_move_on() {
    let lattice = Lattice {
        sides: [4, 10],
        around: 0,
    };
    // the loops visit 40 sites of 50
    assert_eq!(step(&lattice, 50), Ok(()));
    assert!(matches!(step(&lattice, 39), Err(StepError::Index { .. })));
}
