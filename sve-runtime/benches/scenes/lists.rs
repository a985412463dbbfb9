//! Atoms with lists: of neighbours within a cut-off, of bonds, and of angles.

use std::hint::black_box;

use sve_runtime::__private::StepShear as Shear;
use sve_runtime::__private::scene::Scene;
use sve_runtime::prelude::*;

use crate::measure::compare;
use crate::scenes::{Argon, Polymer};
use crate::{Path, hand};

/// A grid of atoms, in an order in which neighbours are near.
pub(crate) fn grid(side: usize) -> Vec<[f64; 3]> {
    let turned = |at: usize, row: usize| {
        if row.is_multiple_of(2) {
            at
        } else {
            side - 1 - at
        }
    };
    (0..side * side * side)
        .map(|i| {
            let (z, y) = (i / (side * side), i / side % side);
            let site = [turned(i % side, y + z * side), turned(y, z), z];
            let noise = |k: usize| 0.05 * ((i * 3 + k) as f64 * 12.9898).sin();
            std::array::from_fn(|k| 1.06 * site[k] as f64 + noise(k))
        })
        .collect()
}

/// Returns a half list by rows of all pairs nearer than 2.5.
fn half_list(x: &[[f64; 3]]) -> (Vec<usize>, Vec<usize>) {
    let cell = |x: &[f64; 3]| x.map(|x| ((x + 0.06) / 2.5).max(0.0) as i64);
    let mut cells = std::collections::HashMap::<[i64; 3], Vec<usize>>::new();
    for (i, x) in x.iter().enumerate() {
        cells.entry(cell(x)).or_default().push(i);
    }
    let (mut start, mut list) = (vec![0], Vec::new());
    for (i, a) in x.iter().enumerate() {
        let at = cell(a);
        for near in 0..27 {
            let near = [
                at[0] + near / 9 - 1,
                at[1] + near / 3 % 3 - 1,
                at[2] + near % 3 - 1,
            ];
            let others = cells.get(&near).map_or(&[][..], Vec::as_slice);
            list.extend(others.iter().filter(|&&j| {
                let r2: f64 = (0..3).map(|k| (x[j][k] - a[k]).powi(2)).sum();
                j > i && r2 < 6.25
            }));
        }
        start.push(list.len());
    }
    (start, list)
}

/// Returns a step so short that atoms stay in their order, with its shears.
fn short_steps() -> (f64, Vec<Shear>) {
    let h = 1e-6;
    let kick = |at: f64| Shear::Kick {
        h: 0.5 * h,
        part: 0.5,
        at,
    };
    (
        h,
        vec![
            kick(0.0),
            Shear::Drift {
                h,
                friction: [0.0; 2],
                parts: [0.0; 2],
                at: [0.0; 2],
            },
            kick(h),
        ],
    )
}

pub(crate) fn molecules(side: usize, is_asked: &dyn Fn(&str) -> bool) {
    let x = grid(side);
    let n = x.len();
    let (h, shears) = short_steps();
    let count = if n > 10_000 { 16 } else { 64 };
    let state = || [x.clone(), vec![[0.0; 3]; n], vec![[0.0; 3]; n]];

    let (start, list) = half_list(&x);
    let [short_start, short] =
        [&start, &list].map(|of| of.iter().map(|&i| i as u32).collect::<Vec<_>>());
    let pairs = list.len() as f64 * count as f64;
    let argon = Argon {
        start,
        list,
        cut2: 6.25,
        mass: 1.0,
    };
    let mut path = Path {
        shears: shears.clone(),
        ..Path::new(&argon, &x, true)
    };
    let row =
        |i: usize| (argon.list[argon.start[i]..argon.start[i + 1]].iter()).map(move |&j| [i, j]);
    let pairs_of_rows = (0..n).flat_map(row).collect();
    let flat = Pairs {
        pairs: pairs_of_rows,
        cut2: 6.25,
    };
    let mut flat = Path {
        shears: shears.clone(),
        ..Path::new(&flat, &x, true)
    };
    let [mut q, mut p, mut f] = state();
    compare(
        &format!("argon of {n} atoms, {} pairs", short.len()),
        is_asked,
        vec![
            (
                "by hand, half list",
                pairs,
                Box::new(|| {
                    for _ in 0..count {
                        hand::verlet([black_box(&mut q), &mut p, &mut f], h, |x, f| {
                            hand::argon(&short_start, &short, x, f);
                        });
                    }
                }),
            ),
            (
                "trajectory, Störmer–Verlet",
                pairs,
                Box::new(|| path.advance(count)),
            ),
            (
                "trajectory, flat list of pairs",
                pairs,
                Box::new(|| flat.advance(count)),
            ),
        ],
    );
}

/// The atoms of [`Argon`], with one list of all pairs.
struct Pairs {
    pairs: Vec<[usize; 2]>,
    cut2: f64,
}

#[variational(stormer_verlet)]
impl Pairs {
    fn lagrangian(&self, q: &[[f64; 3]], v: &[[f64; 3]]) -> f64 {
        let mut l = 0.0;
        for v in v {
            l += 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        }
        for k in 0..self.pairs.len() {
            let [i, j] = self.pairs[k];
            let mut r2 = 0.0;
            for axis in 0..3 {
                r2 += (q[j][axis] - q[i][axis]).powi(2);
            }
            if r2 > self.cut2 {
                continue;
            }
            let s = 1.0 / (r2 * r2 * r2);
            l -= 4.0 * (s * s - s);
        }
        l
    }
}

/// Angles of a list, with the potential 10 (cos + ½)².
struct Angles {
    list: Vec<[usize; 3]>,
}

#[variational(stormer_verlet)]
impl Angles {
    fn lagrangian(&self, q: &[[f64; 3]], v: &[[f64; 3]]) -> f64 {
        let mut l = 0.0;
        for v in v {
            l += 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        }
        for angle in 0..self.list.len() {
            let [i, j, k] = self.list[angle];
            let (mut a2, mut b2, mut ab) = (0.0, 0.0, 0.0);
            for axis in 0..3 {
                let (a, b) = (q[i][axis] - q[j][axis], q[k][axis] - q[j][axis]);
                a2 += a * a;
                b2 += b * b;
                ab += a * b;
            }
            l -= 10.0 * (ab / (a2 * b2).sqrt() + 0.5).powi(2);
        }
        l
    }
}

/// Angles of chains of 50, in the order of the atoms, and shuffled.
pub(crate) fn angles(side: usize, is_asked: &dyn Fn(&str) -> bool) {
    let x = grid(side);
    let n = x.len();
    let ordered = (2..n).filter(|k| k % 50 > 1).map(|k| [k - 2, k - 1, k]);
    let ordered: Vec<[usize; 3]> = ordered.collect();
    for (list, order) in [(shuffled(&ordered), "shuffled"), (ordered, "in order")] {
        let short: Vec<[u32; 3]> = list.iter().map(|angle| angle.map(|i| i as u32)).collect();
        let elements = list.len();
        let by_hand = |x: &[[f64; 3]], f: &mut [[f64; 3]]| hand::angles(&short, x, f);
        let title = format!("angles of {n} atoms, {order}");
        beside_plain_list((&title, is_asked), &Angles { list }, &x, elements, by_hand);
    }
}

/// Returns the elements of a list in another order.
fn shuffled<T: Copy>(list: &[T]) -> Vec<T> {
    let mut shuffled = list.to_vec();
    for i in 0..list.len() {
        shuffled.swap(i, i * 7919 % list.len());
    }
    shuffled
}

/// Bonds of a list in the order of the atoms, which has runs: of one chain and of chains of 50; and
/// the latter shuffled.
pub(crate) fn bonds(side: usize, is_asked: &dyn Fn(&str) -> bool) {
    let x = grid(side);
    let n = x.len();
    let chains = |length: usize| (1..n).filter(move |i| i % length != 0);
    let [one, many] = [n, 50].map(|length| chains(length).map(|i| [i - 1, i]).collect::<Vec<_>>());
    for (bonds, order) in [
        (one, "one chain"),
        (shuffled(&many), "shuffled"),
        (many, "chains of 50"),
    ] {
        let short: Vec<[u32; 2]> = bonds.iter().map(|bond| bond.map(|i| i as u32)).collect();
        let elements = bonds.len();
        let polymer = Polymer {
            bonds,
            k: 100.0,
            length: 1.0,
        };
        let by_hand = |x: &[[f64; 3]], f: &mut [[f64; 3]]| hand::bonds(&short, x, f);
        let title = format!("bonds of {n} atoms, {order}");
        beside_plain_list((&title, is_asked), &polymer, &x, elements, by_hand);
    }
}

/// Compares steps of a scene whose potential is the sum of a list with steps of which the forces of
/// the list are added by hand: the time of an element.
fn beside_plain_list<S: Scene<Row = [f64; 3]>>(
    (title, is_asked): (&str, &dyn Fn(&str) -> bool),
    scene: &S,
    x: &[[f64; 3]],
    elements: usize,
    by_hand: impl Fn(&[[f64; 3]], &mut [[f64; 3]]),
) {
    let (h, shears) = short_steps();
    let count = if x.len() > 10_000 { 16 } else { 64 };
    let units = elements as f64 * count as f64;
    let mut path = Path {
        shears,
        ..Path::new(scene, x, true)
    };
    let still = vec![[0.0; 3]; x.len()];
    let [mut q, mut p, mut f] = [x.to_vec(), still.clone(), still];
    let steps = || {
        for _ in 0..count {
            hand::verlet([black_box(&mut q), &mut p, &mut f], h, &by_hand);
        }
    };
    compare(
        title,
        is_asked,
        vec![
            ("by hand, plain list", units, Box::new(steps)),
            (
                "trajectory, Störmer–Verlet",
                units,
                Box::new(|| path.advance(count)),
            ),
        ],
    );
}
