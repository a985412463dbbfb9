//! Steps conserve the momenta of symmetries, and what breaks a symmetry moves its momentum.

use sve_runtime::nalgebra::{Vector2, Vector3};
use sve_runtime::prelude::*;

use crate::common::{numbers, spread};
use crate::symmetric::{
    centred, charges, pairs, planar, positive, ring, rotors, rows, stars, vectors,
};

/// Checks that all rules keep momenta over 2000 steps: to the rounding of the steps and of their
/// sums, which adds up as in a random walk. `explicit` leaves the midpoint rule out. `for` has
/// another number of steps.
macro_rules! assert_kept {
    (explicit $system:expr, $q:expr, $p:expr, $noise:expr, $($momentum:ident),+) => {{
        let (system, q, p) = (&$system, $q, $p);
        assert_kept!(@each system, q, p, $noise, [$($momentum),+],
            InitialPoint, Endpoint, StormerVerlet,
            Composed::new(StormerVerlet, KahanLi8), Split::new(BlanesMoan4));
    }};
    (@each $system:ident, $q:ident, $p:ident, $noise:expr, $momenta:tt, $($rule:expr),*) => {
        assert_kept!(for 2_000, $system, $q, $p, $noise, $momenta, $($rule),*)
    };
    (for $steps:expr, $system:ident, $q:ident, $p:ident, $noise:expr, $momenta:tt, $($rule:expr),*) => {$(
        let start = State::new($q.to_vec(), $p.to_vec());
        let integrator = Integrator::new($system, $rule);
        let mut path = integrator.trajectory(start.clone(), 0.01, $noise);
        let end = path.advance($steps).expect("steps").clone();
        assert_kept!(@momenta $system, start, end, stringify!($rule), $momenta);
    )*};
    (@momenta $system:ident, $start:ident, $end:ident, $rule:expr, [$($momentum:ident),+]) => {$(
        let [before, after] = [&$start, &$end].map(|s| $system.$momentum(s).expect("a momentum"));
        assert!((after - before).abs() < 2e-12, "{} {}: {before} {after}", $rule, stringify!($momentum));
        let turned = numbers(&$end.p).iter().zip(numbers(&$start.p)).any(|(a, b)| (a - b).abs() > 0.1);
        assert!(turned, "nothing happened");
    )+};
    ($system:expr, $q:expr, $p:expr, $noise:expr, $($momentum:ident),+) => {{
        let (system, q, p) = (&$system, $q, $p);
        assert_kept!(@each system, q, p, $noise, [$($momentum),+], Midpoint);
        assert_kept!(explicit *system, q, p, $noise, $($momentum),+);
    }};
}

#[test]
fn all_rules_keep_momenta_with_noise_that_keeps_them() {
    let (mass, sigma) = (positive(12, 3), 0.2);
    let ring = ring::scene::System {
        mass: mass.clone(),
        beta: 0.4,
        sigma,
    };
    assert_kept!(
        ring,
        spread(12, 1),
        spread(12, 2),
        Wiener::new(5),
        shift_momentum
    );
    let stars = stars::scene::System {
        m: mass.clone(),
        sigma: 0.05,
    };
    let q = vectors::<5>(3).map(|q| 2.0 * q);
    assert_kept!(
        stars,
        q,
        vectors::<5>(4),
        Wiener::new(6),
        along_momentum,
        turn_momentum
    );
}

#[test]
fn all_rules_keep_momenta() {
    let planar = planar::scene::System { k: 0.7 };
    assert_kept!(planar, pairs::<4>(5), pairs::<4>(6), NoNoise, turn_momentum);
    let rotors = rotors::scene::System {
        j: 0.8,
        weight: positive(9, 4),
    };
    assert_kept!(explicit rotors, spread(9, 7), spread(9, 8), NoNoise, angle_momentum);
    let centred = centred::scene::System { k: 0.6 };
    let (q, p) = (pairs::<4>(11), pairs::<4>(12));
    assert_kept!(explicit centred, q, p, NoNoise, turn_momentum, shift_momentum);
    let charges = charges::scene::System {
        charge: positive(4, 9),
    };
    assert_kept!(
        charges,
        rows::<4>(9),
        rows::<4>(10),
        NoNoise,
        phase_momentum
    );
}

/// Relativistic bodies in a vector potential, with a force across the direction in which all may be
/// moved.
struct Fast {
    a: [f64; 2],
    k: f64,
}

#[variational(initial_point, endpoint, stormer_verlet)]
impl Fast {
    fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += self.a[0] * v[i][0] + self.a[1] * v[i][1];
            l -= (1.0 - v[i][0] * v[i][0] - v[i][1] * v[i][1]).sqrt();
            let j = (i + 1) % q.len();
            l -= 0.5 * self.k * ((q[j][0] - q[i][0]).powi(2) + (q[j][1] + q[i][1]).powi(2));
        }
        l
    }

    #[force]
    fn drag(&self, _q: &[[f64; 2]], v: &[[f64; 2]]) -> Vec<[f64; 2]> {
        v.iter()
            .map(|v| [0.0, -0.5 * (0.1 + v[0] * v[0]).sqrt() * v[1]])
            .collect()
    }

    #[symmetry]
    fn along(&self, q: &[[f64; 2]]) -> Vec<[f64; 2]> {
        q.iter().map(|_| [1.0, 0.0]).collect()
    }
}

/// Relativistic bodies in a round well, with a drag towards the middle, and with noises that turn
/// and stretch them.
struct Turning {
    k: f64,
    sigma: f64,
}

#[variational(stormer_verlet)]
impl Turning {
    fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l -= (1.0 - v[i][0] * v[i][0] - v[i][1] * v[i][1]).sqrt();
            l -= self.k * (q[i][0] * q[i][0] + q[i][1] * q[i][1]);
        }
        l
    }

    #[h1]
    fn spin(&self, q: &[[f64; 2]], p: &[[f64; 2]]) -> f64 {
        let mut h = 0.0;
        for i in 0..q.len() {
            h += self.sigma * (q[i][0] * p[i][1] - q[i][1] * p[i][0]);
        }
        h
    }

    #[h1]
    fn swap(&self, q: &[[f64; 2]], p: &[[f64; 2]]) -> Vec<f64> {
        (0..q.len())
            .map(|i| {
                let j = (i + 1) % q.len();
                self.sigma * (q[i][0] * p[j][0] + q[i][1] * p[j][1])
            })
            .collect()
    }

    #[force]
    fn drag(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> Vec<[f64; 2]> {
        (0..q.len())
            .map(|i| {
                let inwards = -0.5 * (q[i][0] * v[i][0] + q[i][1] * v[i][1]);
                [inwards * q[i][0], inwards * q[i][1]]
            })
            .collect()
    }

    #[symmetry]
    fn turn(&self, q: &[[f64; 2]]) -> Vec<[f64; 2]> {
        q.iter().map(|q| [-q[1], q[0]]).collect()
    }
}

/// Momenta are those of the whole: kinetic energies, forces of velocities and noises that move
/// positions leave them.
#[test]
fn drifts_with_solved_velocities_keep_momenta() {
    let (a, k) = ([0.3, -0.2], 0.7);
    let (q, p) = (pairs::<5>(1), pairs::<5>(2));
    let fast = &Fast { a, k };
    assert_kept!(for 500, fast, q, p, NoNoise, [along_momentum],
        InitialPoint, Endpoint, StormerVerlet, Split::new(BlanesMoan4));
    let turning = &Turning { k, sigma: 0.1 };
    let p = p.map(|p| [p[0] + 1.0, p[1]]);
    assert_kept!(for 500, turning, q, p, Wiener::new(3), [turn_momentum],
        StormerVerlet, Composed::new(StormerVerlet, KahanLi8));
}

/// Atoms of Lennard and Jones with a cut-off, from lists of neighbours.
struct Cluster {
    near: Neighbours<3>,
    cut2: f64,
}

#[variational(stormer_verlet)]
impl Cluster {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i].norm_squared();
            for k in self.near.start[i]..self.near.start[i + 1] {
                let r2 = (q[self.near.list[k]] - q[i]).norm_squared();
                if r2 < self.cut2 {
                    let s6 = 1.0 / r2.powi(3);
                    l -= 4.0 * (s6 * s6 - s6);
                }
            }
        }
        l
    }

    #[symmetry]
    fn x(&self, q: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        q.iter().map(|_| Vector3::new(1.0, 0.0, 0.0)).collect()
    }

    #[symmetry]
    fn about_x(&self, q: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        q.iter().map(|q| Vector3::new(0.0, -q.z, q.y)).collect()
    }

    #[symmetry]
    fn about_z(&self, q: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        q.iter().map(|q| Vector3::new(-q.y, q.x, 0.0)).collect()
    }
}

#[test]
fn a_cluster_with_lists_keeps_momentum_and_angular_momentum() {
    let grid = (0..64).map(|i| [i % 4, i / 4 % 4, i / 16].map(|x| 1.12 * f64::from(x)));
    let q: Vec<Vector3<f64>> = grid.map(Vector3::from).collect();
    let p: Vec<Vector3<f64>> = vectors::<64>(5).map(|p| 0.8 * p).to_vec();
    let mut near = Neighbours::open(2.5, 0.4).expect("a cut-off");
    near.rebuild(&q).expect("lists");
    let mut cluster = Integrator::new(Cluster { near, cut2: 6.25 }, StormerVerlet);
    let mut state = State::new(q, p);
    let momenta = |system: &Cluster, state: &State<Vec<Vector3<f64>>>| {
        let momenta = [
            system.x_momentum(state),
            system.about_x_momentum(state),
            system.about_z_momentum(state),
        ];
        momenta.map(|momentum| momentum.expect("a momentum"))
    };
    let before = momenta(cluster.system(), &state);
    let mut rebuilt = 0;
    for _ in 0..10_000 {
        if !cluster.system().near.is_valid(&state.q) {
            cluster.system_mut().near.rebuild(&state.q).expect("lists");
            rebuilt += 1;
        }
        cluster.step(&mut state, 0.002, &[]).expect("a step");
    }
    assert!(rebuilt > 10, "{rebuilt}");
    let after = momenta(cluster.system(), &state);
    for (before, after) in before.into_iter().zip(after) {
        // the terms of an angular momentum are of the order of 100 and are rounded in each step
        assert!((after - before).abs() < 1e-10, "{before} {after}");
        assert!(before.abs() > 0.1);
    }
}

/// Discs in a periodic box, in which translations are symmetries and rotations are none.
struct Box2 {
    side: f64,
}

#[variational(stormer_verlet)]
impl Box2 {
    fn lagrangian(&self, q: &[Vector2<f64>], v: &[Vector2<f64>]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i].norm_squared();
            for j in 0..i {
                let mut r2 = 0.0;
                for axis in 0..2 {
                    let d = q[j][axis] - q[i][axis];
                    r2 += (d - self.side * (d / self.side).round()).powi(2);
                }
                if r2 < 1.0 {
                    l -= 5.0 * (1.0 - r2).powi(4);
                }
            }
        }
        l
    }

    #[symmetry]
    fn y(&self, q: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
        q.iter().map(|_| Vector2::new(0.0, 1.0)).collect()
    }
}

#[test]
fn a_periodic_box_keeps_the_momentum() {
    let q: Vec<Vector2<f64>> = pairs::<30>(1).map(|q| 1.5 * Vector2::from(q)).to_vec();
    let p: Vec<Vector2<f64>> = pairs::<30>(2).map(|p| Vector2::from(p) * 2.0).to_vec();
    let system = Integrator::new(Box2 { side: 3.0 }, StormerVerlet);
    let start = State::new(q, p);
    let mut path = system.trajectory(start.clone(), 0.005, NoNoise);
    let end = path.advance(10_000).expect("steps");
    let [before, after] = [&start, end].map(|state| system.system().y_momentum(state));
    assert!((after.expect("one") - before.expect("one")).abs() < 1e-11);
    assert!(end.q.iter().any(|q| q.y.abs() > 5.0), "none left the box");
}

/// The ring in a field, with the noise of a bath: neither leaves the momentum as it is.
struct Driven {
    field: f64,
    well: f64,
    sigma: f64,
}

#[variational(initial_point, stormer_verlet)]
impl Driven {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = 0.0;
        for i in 0..n {
            l += 0.5 * v[i] * v[i] - 0.5 * (q[(i + 1) % n] - q[i]).powi(2);
            l += self.field * q[i] - self.well * q[i].powi(4);
        }
        l
    }

    #[gamma]
    fn bath(&self, q: &[f64]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * q).collect()
    }
}

/// The force and the increments of each site add to the momentum, as the proofs of the messages
/// say: by n F h and by σ Σ ΔW.
#[test]
fn what_breaks_a_symmetry_moves_its_momentum() {
    let n = 20;
    let total = |state: &State<Vec<f64>>| state.p.iter().sum::<f64>();
    let start = State::new(spread(n, 1), spread(n, 2));
    let after = |system: &Driven, dw: &[f64]| {
        let integrator = Integrator::new(system, StormerVerlet);
        let mut state = start.clone();
        for _ in 0..100 {
            integrator.step(&mut state, 0.05, dw).expect("a step");
        }
        total(&state) - total(&start)
    };
    let rest = [0.0; 20];
    let driven = |field, well, sigma| Driven { field, well, sigma };
    let free = after(&driven(0.0, 0.0, 0.0), &rest);
    assert!(free.abs() < 1e-13, "{free}");
    let fallen = after(&driven(0.3, 0.0, 0.0), &rest);
    assert!((fallen - 20.0 * 0.3 * 5.0).abs() < 1e-12, "{fallen}");
    let held = after(&driven(0.0, 0.25, 0.0), &rest);
    assert!(held.abs() > 1e-2, "{held}");
    let dw = spread(n, 3);
    let pushed = after(&driven(0.0, 0.0, 0.7), &dw);
    let expected = 100.0 * 0.7 * dw.iter().sum::<f64>();
    assert!((pushed - expected).abs() < 1e-11, "{pushed} {expected}");
}
