//! Saved states, files and snapshots of scenes.

use std::path::PathBuf;

use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;
use sve_runtime::{Rule, SaveError};

use crate::common::spread;

/// A ring with noise at each site, and a spring that depends on time.
struct Ring {
    sigma: f64,
}

#[variational(stormer_verlet, endpoint)]
impl Ring {
    fn lagrangian(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            let d = q[(i + 1) % q.len()] - q[i];
            l += 0.5 * v[i] * v[i] - (0.5 + 0.1 * t.sin()) * d * d - 0.25 * d.powi(4);
        }
        l
    }

    #[gamma]
    fn bath(&self, q: &[f64]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * q.sin()).collect()
    }
}

/// Bodies in wells, without interaction.
struct Wells;

#[variational(stormer_verlet)]
impl Wells {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        (0..q.len())
            .map(|i| 0.5 * (v[i].norm_squared() - q[i].norm_squared()))
            .sum()
    }
}

fn ring() -> Integrator<Ring, StormerVerlet> {
    Integrator::new(Ring { sigma: 0.3 }, StormerVerlet)
}

fn start(n: usize) -> State<Vec<f64>> {
    State::at(0.3, spread(n, 1), spread(n, 2))
}

fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("sve-scenes-{}-{name}", std::process::id()))
}

/// Reads a file that `write` writes, and removes it.
fn written(name: &str, write: impl FnOnce(&PathBuf)) -> Vec<u8> {
    let path = scratch(name);
    write(&path);
    let bytes = std::fs::read(&path).expect("a file");
    std::fs::remove_file(path).expect("it is removed");
    bytes
}

/// Returns header and numbers of an array of `NumPy`.
fn npy(bytes: &[u8]) -> (String, Vec<f64>) {
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let (header, data) = bytes.split_at(10 + length);
    assert!(header.starts_with(b"\x93NUMPY\x01\0") && header.len() % 64 == 0);
    let (numbers, rest) = data.as_chunks::<8>();
    assert!(rest.is_empty());
    let header = String::from_utf8_lossy(&header[10..]).trim_end().to_owned();
    (
        header,
        numbers.iter().map(|x| f64::from_le_bytes(*x)).collect(),
    )
}

/// The bits of a path do not depend on which of its states are saved.
#[test]
fn saved_states_have_the_bits_of_the_trajectory() {
    for n in [3, 700] {
        let ring = ring();
        let path = || ring.trajectory(start(n), 0.05, Wiener::new(4));
        let whole: Vec<_> = path().take(200).map(|s| s.expect("a step")).collect();
        let mut saved = path().every(70);
        assert_eq!(saved.next(), Some(Ok(start(n))));
        for k in [70, 140] {
            let state = saved.next().expect("a state").expect("a step");
            assert_eq!((&state.q, &state.p), (&whole[k - 1].q, &whole[k - 1].p));
        }
        let nth = path().nth(199).expect("a state").expect("a step");
        assert_eq!(nth, whole[199]);
        // the last state is within a step
        let mut ended = path().every(90).until(0.3 + 190.5 * 0.05);
        let states: Vec<_> = ended.by_ref().map(|s| s.expect("a step")).collect();
        assert_eq!((states.len(), ended.state()), (4, &whole[189]));
        assert_eq!(states[2].q, whole[179].q);
        assert_ne!(states[3].q, whole[189].q);
        let at: Vec<_> = path().at([3.3, 3.32]).map(|s| s.expect("a step")).collect();
        assert_eq!((at[0].t, &at[0].q), (3.3, &whole[59].q));
        assert!(at[1].t == 3.32 && at[1].q != at[0].q && at[1].q != whole[60].q);
    }
}

#[test]
fn a_stored_scene_is_continued_with_the_same_bits() {
    fn check<R: Rule<Ring, Increments = [f64]>>(rule: R) {
        let ring = Integrator::new(Ring { sigma: 0.3 }, rule);
        let noise = Wiener::new(9);
        let mut path = ring.trajectory(start(300), 0.05, noise);
        for stop in [0, 1, 99, 101] {
            path.advance(stop).expect("steps");
            let text = serde_json::to_string(&path.snapshot()).expect("text");
            let snapshot: Snapshot<State<Vec<f64>>> =
                serde_json::from_str(&text).expect("a snapshot");
            assert_eq!(snapshot, path.snapshot());
            let mut whole = ring.trajectory(start(300), 0.05, noise);
            let steps = path.step();
            let mut rest = ring.resume(snapshot, noise).expect("it goes on");
            let expected = whole.advance(steps + 130).expect("steps");
            assert_eq!(rest.advance(130).expect("steps"), expected);
            assert_eq!(rest.step(), steps + 130);
        }
    }
    check(StormerVerlet);
    check(Composed::new(StormerVerlet, KahanLi8));
    // vectors, and a scene that was stored from another value of its fields: nothing is carried
    let wells = Integrator::new(Wells, StormerVerlet);
    let q = vec![Vector3::new(1.0, -0.0, 1.0 / 3.0); 2];
    let mut path = wells.trajectory(State::new(q.clone(), q), 0.1, NoNoise);
    path.advance(5).expect("steps");
    let text = serde_json::to_string(&path.snapshot()).expect("text");
    let snapshot = serde_json::from_str(&text).expect("a snapshot");
    let mut rest = wells.resume(snapshot, NoNoise).expect("it goes on");
    assert_eq!(
        rest.advance(5).expect("steps"),
        path.advance(5).expect("steps")
    );
}

#[test]
fn frames_are_an_array_of_numpy() {
    let ring = ring();
    for n in [0, 3] {
        let path = || {
            let path = ring.trajectory(start(n), 0.1, Wiener::new(1));
            path.every(4).until(1.4)
        };
        let (header, numbers) = npy(&written("ring.npy", |file| {
            path().to_npy(file).expect("a file");
        }));
        assert_eq!(
            header,
            format!(
                "{{'descr': [('t', '<f8'), ('q', '<f8', ({n},)), ('p', '<f8', ({n},))], 'fortran_order': False, 'shape': (4,), }}"
            )
        );
        let states = path().map(|s| s.expect("a step"));
        let expected: Vec<f64> = states
            .flat_map(|s| [vec![s.t], s.q, s.p].concat())
            .collect();
        assert_eq!(numbers, expected);
    }
    // sites of several numbers, and no frames
    let wells = Integrator::new(Wells, StormerVerlet);
    let q = vec![Vector3::new(1.0, 2.0, 3.0); 2];
    let path = || wells.trajectory(State::new(q.clone(), q.clone()), 0.1, NoNoise);
    let array = |times: &[f64]| {
        npy(&written("wells.npy", |file| {
            path()
                .at(times)
                .progress(true)
                .to_npy(file)
                .expect("a file");
        }))
    };
    let (header, numbers) = array(&[0.0]);
    assert!(
        header.contains("('q', '<f8', (2, 3)), ('p', '<f8', (2, 3))"),
        "{header}"
    );
    let row = [1.0, 2.0, 3.0];
    assert_eq!(numbers, [&[0.0][..], &row, &row, &row, &row].concat());
    let (header, numbers) = array(&[]);
    assert!(
        header.contains("'shape': (0,)") && numbers.is_empty(),
        "{header}"
    );
}

#[test]
fn frames_are_extended_xyz() {
    let wells = Integrator::new(Wells, StormerVerlet);
    let q = vec![Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.1, 0.2, 0.3)];
    let path = || {
        let path = wells.trajectory(State::new(q.clone(), q.clone()), 0.1, NoNoise);
        path.every(5).until(1.0)
    };
    let xyz = Xyz::new().periodic([9.0; 3]).species(["O", "H"]);
    let bytes = written("wells.xyz", |file| {
        path().to_xyz(file, &xyz).expect("a file");
    });
    let mut expected = Vec::new();
    for state in path() {
        let State { t, q, p } = state.expect("a step");
        let rows =
            |sites: &[Vector3<f64>]| sites.iter().map(|x| (*x).into()).collect::<Vec<[f64; 3]>>();
        xyz.write_frame(&mut expected, t, &rows(&q), &rows(&p))
            .expect("a frame");
    }
    assert!(bytes == expected && expected.len() > 300);
    // sites of one number are bodies on a line
    let bytes = written("ring.xyz", |file| {
        let ring = ring();
        let path = ring.trajectory(start(3), 0.1, NoNoise).at([0.3]);
        path.to_xyz(file, &Xyz::<1>::new()).expect("a file");
    });
    assert_eq!(String::from_utf8_lossy(&bytes).lines().count(), 5);
}

/// A file is complete or not there, and the reason is that of the step or of the file.
#[test]
fn frames_that_cannot_be_written_are_errors() {
    let ring = ring();
    let path = || ring.trajectory(start(3), 0.1, Wiener::new(1));
    let file = scratch("none");
    assert!(matches!(
        path().every(2).to_npy(&file),
        Err(SaveError::NoEnd)
    ));
    let one = Xyz::<1>::new();
    assert!(matches!(
        path().every(2).to_xyz(&file, &one),
        Err(SaveError::NoEnd)
    ));
    let error = path().every(0).until(1.0).to_npy(&file);
    assert!(matches!(
        error,
        Err(SaveError::Step(StepError::SavedInterval { .. }))
    ));
    // h so large that a state is not finite
    let error = ring
        .trajectory(start(3), 1e80, NoNoise)
        .every(1)
        .until(1e82)
        .to_npy(&file);
    assert!(
        matches!(
            error,
            Err(SaveError::Step(StepError::NonFiniteCoordinate { .. }))
        ),
        "{error:?}"
    );
    let error = path()
        .until(1.0)
        .to_xyz(&file, &Xyz::<1>::new().species(["A", "B"]));
    let text = error.expect_err("two names").to_string();
    assert!(text.contains("2 names for 3 bodies"), "{text}");
    assert!(!file.exists());
}
