//! All pairs of bodies, and lists of bonds, angles and neighbours with a cut-off.

use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

use crate::common::{numbers, spread};

mod vectors {
    use sve_runtime::nalgebra::Vector3;
    use sve_runtime::prelude::*;
    both! {
        struct { m: Vec<f64>, eps2: f64 }
        [Vector3<f64>] 5
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * self.m[i] * v[i].norm_squared();
                for j in 0..i {
                    let d = q[i] - q[j];
                    l += self.m[i] * self.m[j] / (d.norm_squared() + self.eps2).sqrt();
                }
            }
            l
        }
    }
}

mod arrays {
    use sve_runtime::prelude::*;
    both! {
        struct { m: Vec<f64>, eps2: f64 }
        [[f64; 3]] 4
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                for a in 0..3 {
                    l += 0.5 * self.m[i] * v[i][a].powi(2);
                }
            }
            // each pair twice, under a condition
            for i in 0..q.len() {
                for j in 0..q.len() {
                    if i != j {
                        let mut r2 = self.eps2;
                        for a in 0..3 {
                            r2 += (q[i][a] - q[j][a]).powi(2);
                        }
                        l += 0.5 * self.m[i] * self.m[j] / r2.sqrt();
                    }
                }
            }
            l
        }
    }
}

fn vectors_of<const N: usize>(seed: u64) -> [Vector3<f64>; N] {
    let numbers = spread(3 * N, seed);
    std::array::from_fn(|i| Vector3::from_column_slice(&numbers[3 * i..3 * i + 3]))
}

#[test]
fn all_pairs_step_as_unrolled_ones() {
    let m: Vec<f64> = (0..5).map(|i| 1.0 + 0.3 * f64::from(i)).collect();
    let fields = || m.clone();
    compare!(
        vectors {
            m: fields(),
            eps2: 0.2
        },
        vectors_of::<5>(1),
        vectors_of::<5>(2),
        []
    );
    let rows = |seed| vectors_of::<4>(seed).map(|row| [row.x, row.y, row.z]);
    compare!(
        arrays {
            m: fields(),
            eps2: 0.2
        },
        rows(3),
        rows(4),
        []
    );
}

/// A molecule: bonds and angles from lists, and the neighbours of each atom from one list by rows,
/// with parameters by kind and a cut-off.
struct Molecule {
    mass: Vec<f64>,
    bonds: Vec<[usize; 2]>,
    angles: Vec<(u32, u32, u32)>,
    start: Vec<usize>,
    list: Vec<usize>,
    kind: Vec<u8>,
    eps: [[f64; 2]; 2],
    cut2: f64,
}

#[variational(initial_point, endpoint, stormer_verlet)]
impl Molecule {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * self.mass[i] * v[i].norm_squared();
        }
        for bond in &self.bonds {
            let r = (q[bond[1]] - q[bond[0]]).norm();
            l -= 2.0 * (r - 1.0).powi(2);
        }
        for k in 0..self.angles.len() {
            let (a, b, c) = (self.angles[k].0, self.angles[k].1, self.angles[k].2);
            let (x, y) = (q[a as usize] - q[b as usize], q[c as usize] - q[b as usize]);
            l -= 0.3 * (x.dot(&y) / (x.norm() * y.norm()) + 0.2).powi(2);
        }
        for i in 0..q.len() {
            for k in self.start[i]..self.start[i + 1] {
                let j = self.list[k];
                let r2 = (q[j] - q[i]).norm_squared();
                if r2 > self.cut2 {
                    continue;
                }
                let s = 1.0 / (r2 * r2 * r2);
                l -= self.eps[self.kind[i] as usize][self.kind[j] as usize] * (s * s - s);
            }
        }
        l
    }
}

/// The same molecule of seven atoms, written out.
#[derive(Clone)]
struct Written;

const BONDS: [[usize; 2]; 8] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 4],
    [4, 5],
    [5, 6],
    [1, 2],
    [6, 0],
];
const ANGLES: [[usize; 3]; 3] = [[0, 1, 2], [1, 2, 3], [4, 5, 3]];
const PAIRS: [[usize; 2]; 5] = [[0, 2], [0, 3], [2, 5], [3, 6], [4, 6]];
const NEAR: [usize; 3] = [0, 2, 4];
const MASS: [f64; 7] = [1.0, 2.0, 1.5, 1.0, 3.0, 1.0, 0.5];

#[sve_comparison::stepped(initial_point, endpoint, stormer_verlet)]
impl Written {
    fn lagrangian(&self, q: [Vector3<f64>; 7], v: [Vector3<f64>; 7]) -> f64 {
        let mut l = 0.0;
        for i in 0..7 {
            l += 0.5 * MASS[i] * v[i].norm_squared();
        }
        for [a, b] in [
            [0, 1],
            [1, 2],
            [2, 3],
            [3, 4],
            [4, 5],
            [5, 6],
            [1, 2],
            [6, 0],
        ] {
            let r = (q[b] - q[a]).norm();
            l -= 2.0 * (r - 1.0).powi(2);
        }
        for [a, b, c] in [[0, 1, 2], [1, 2, 3], [4, 5, 3]] {
            let (x, y) = (q[a] - q[b], q[c] - q[b]);
            l -= 0.3 * (x.dot(&y) / (x.norm() * y.norm()) + 0.2).powi(2);
        }
        for [i, j] in [[0, 2], [2, 5], [4, 6]] {
            let r2 = (q[j] - q[i]).norm_squared();
            let s = 1.0 / (r2 * r2 * r2);
            l -= 0.1 * (1.0 + ((i % 2 + j % 2) as f64)) * (s * s - s);
        }
        l
    }
}

fn molecule(sites: &[Vector3<f64>]) -> Molecule {
    let row = |i: usize| PAIRS.iter().filter(move |pair| pair[0] == i);
    let mut start = vec![0];
    let mut list = Vec::new();
    for i in 0..7 {
        list.extend(row(i).map(|pair| pair[1]));
        start.push(list.len());
    }
    let r2 = |k: usize| (sites[PAIRS[k][0]] - sites[PAIRS[k][1]]).norm_squared();
    let cut2 = 3.4;
    for k in 0..PAIRS.len() {
        assert_eq!(r2(k) < cut2, NEAR.contains(&k), "{k}: {}", r2(k));
        assert!((r2(k) - cut2).abs() > 0.5, "{k}: {}", r2(k));
    }
    Molecule {
        mass: MASS.to_vec(),
        bonds: BONDS.to_vec(),
        angles: ANGLES
            .map(|[a, b, c]| (a as u32, b as u32, c as u32))
            .to_vec(),
        start,
        list,
        kind: (0..7).map(|i| i % 2).collect(),
        eps: [[0.1, 0.2], [0.2, 0.3]],
        cut2,
    }
}

/// Sites of which the near pairs are within the cut-off, and the others are not.
fn sites() -> [Vector3<f64>; 7] {
    [
        Vector3::new(0.0, 0.0, 0.0),
        Vector3::new(0.9, 0.3, 0.1),
        Vector3::new(1.2, 0.8, 0.4),
        Vector3::new(2.6, 0.7, 0.3),
        Vector3::new(2.7, 1.6, 0.9),
        Vector3::new(1.9, 1.9, 1.4),
        Vector3::new(1.4, 2.3, 0.6),
    ]
}

#[test]
fn molecules_step_as_written_out() {
    let (q, p) = (sites(), vectors_of::<7>(12).map(|p| 0.1 * p));
    let scene = molecule(&q);
    macro_rules! step {
        ($($rule:expr),*) => {$(
            let mut state = State::new(q.to_vec(), p.to_vec());
            Integrator::new(&scene, $rule).step(&mut state, 0.01, &[]).expect("a step");
            let mut expected = State::new(q, p);
            Integrator::new(&Written, $rule).step(&mut expected, 0.01, &[]).expect("a step");
            crate::common::assert_same(&state, &expected.q, &expected.p, stringify!($rule));
        )*};
    }
    step!(
        InitialPoint,
        Endpoint,
        StormerVerlet,
        Composed::new(StormerVerlet, KahanLi8)
    );
}

/// A bond in the list twice acts twice, and a bond from a site to itself not at all.
#[test]
fn duplicates_and_loops_of_a_list_are_terms_like_others() {
    struct Bonds {
        bonds: Vec<(usize, usize)>,
    }
    #[variational(endpoint)]
    impl Bonds {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
            for k in 0..self.bonds.len() {
                let (a, b) = (self.bonds[k].0, self.bonds[k].1);
                l -= 0.5 * (q[a] - q[b]).powi(2) + 0.125 * q[a] * q[b];
            }
            l
        }
    }
    let bonds = vec![(0, 2), (2, 0), (0, 2), (1, 1)];
    let p = impulses!(Bonds { bonds }, [1.0, 3.0, 5.0], 0.0, 1.0, &[]);
    // three bonds between 1 and 5; −q²/8 of the site itself
    assert_eq!(p, [3.0 * (4.0 - 0.625), -0.25 * 3.0, 3.0 * (-4.0 - 0.125)]);
}

/// The bonds of a chain in the order of its sites are gathered, with the bits of a loop over the
/// sites; in another order they are made as they are written. A change of the list is a change of
/// the runs.
#[test]
fn runs_of_a_list_are_gathered_like_loops() {
    struct Listed {
        bonds: Vec<[usize; 2]>,
        k: Vec<f64>,
    }
    #[variational(endpoint)]
    impl Listed {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
            for (bond, k) in self.bonds.iter().zip(&self.k) {
                l += k * (q[bond[1]] - q[bond[0]]).cos();
            }
            l
        }
    }
    struct Looped {
        k: Vec<f64>,
    }
    #[variational(endpoint)]
    impl Looped {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
            for i in 1..q.len() {
                l += self.k[i - 1] * (q[i] - q[i - 1]).cos();
            }
            l
        }
    }
    let n = 3000;
    let (start, k) = (State::new(spread(n, 5), spread(n, 6)), spread(n - 1, 7));
    let bonds: Vec<[usize; 2]> = (1..n).map(|i| [i - 1, i]).collect();
    let mut expected = start.clone();
    let looped = Integrator::new(Looped { k: k.clone() }, Endpoint);
    looped.step(&mut expected, 0.1, &[]).expect("a step");

    let mut listed = Integrator::new(Listed { bonds, k }, Endpoint);
    let mut state = start.clone();
    listed.step(&mut state, 0.1, &[]).expect("a step");
    assert_eq!(state, expected);
    let layout = listed.layout(&start, 0.1).expect("a layout");
    assert_eq!((layout.instances, layout.as_written.len()), (n - 1, 0));

    let Listed { bonds, k } = listed.system_mut();
    for at in 0..n - 1 {
        bonds.swap(at, (at * 1009) % (n - 1));
        k.swap(at, (at * 1009) % (n - 1));
    }
    let mut state = start.clone();
    listed.step(&mut state, 0.1, &[]).expect("a step");
    crate::common::assert_same(&state, &expected.q, &expected.p, "in another order");
    let layout = listed.layout(&start, 0.1).expect("a layout");
    assert_eq!((layout.instances, layout.as_written.len()), (0, 1));
}

/// The impulses of 10⁴ sites are differences of the user's function. L is a sum of terms of order
/// 1, so it is only summed over the sites near the one that moves.
#[test]
fn impulses_of_many_sites_are_differences_of_l() {
    struct Sites {
        k: Vec<f64>,
        bonds: Vec<[usize; 2]>,
    }
    #[variational(endpoint)]
    impl Sites {
        fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
            let n = q.len();
            let mut l = 0.0;
            for i in 0..n {
                l += 0.5 * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
                l -= self.k[i] * (q[i][0] * q[i][1]).sin();
                let d = [q[(i + 7) % n][0] - q[i][0], q[(i + 7) % n][1] - q[i][1]];
                l -= (1.0 + d[0] * d[0] + d[1] * d[1]).sqrt();
            }
            for b in &self.bonds {
                l -= (q[b[0]][0] - q[b[1]][1]).exp() * 0.01;
            }
            l
        }
    }
    let n = 10_000;
    let x = spread(2 * n, 3);
    let q: Vec<[f64; 2]> = x.chunks(2).map(|row| [row[0], row[1]]).collect();
    let bonds = (0..500).map(|k| [(k * 7919) % n, (k * 104_729 + 1) % n]);
    let sites = Sites {
        k: spread(n, 4),
        bonds: bonds.collect(),
    };
    let p = impulses!(&sites, q, [0.0; 2], 1.0, &[]);
    let v = vec![[0.0; 2]; n];
    for site in [
        0,
        1,
        6,
        7,
        4999,
        9992,
        9993,
        9999,
        sites.bonds[3][0],
        sites.bonds[5][1],
    ] {
        for component in 0..2 {
            let at = |by: f64| {
                let mut moved = q.clone();
                moved[site][component] += by;
                sites.lagrangian(&moved, &v)
            };
            let step = 1e-3;
            let slope =
                (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
            // L is of the order of 10⁴
            let found = p[site][component];
            assert!(
                (found - slope).abs() < 1e-8,
                "{site} {component}: {found} {slope}"
            );
        }
    }
    let total: f64 = numbers(&p).iter().map(|p| p.abs()).sum();
    assert!(total > 1e3);
}
