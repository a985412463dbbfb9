//! Scenes as `#[variational]` prints them. With `STREAM = false` each loop is made as it is
//! written.
#![allow(clippy::cast_sign_loss)] // indices that were checked

use sve_runtime::__private::scene::{
    Contributions, Counts, Impulses, IndexError, Instances, Loop, Pair, Reads, Scene, Stop,
    Streams, Term, add, entry,
};

fn one(x: f64) -> [f64; 1] {
    [x]
}

/// A chain with free ends:
/// `L = Σ ½ m v[i]² − Σ (½ d² + ¼ β d⁴)` with `d = q[i] − q[i − 1]`.
pub(crate) struct Chain<const STREAM: bool> {
    pub beta: f64,
    pub mass: f64,
}

fn bond(beta: f64, a: f64, b: f64) -> f64 {
    let d = a - b;
    d + beta * (d * d * d)
}

impl<const STREAM: bool> Contributions<Impulses> for Chain<STREAM> {
    type Numbers = [f64; 1];
    type Counts = Counts<2, 0, 0>;

    #[inline(always)]
    fn node(&self, h: f64, _: f64, _: &[f64], reads: &impl Reads<[f64; 1]>) -> [f64; 1] {
        let ([a], [b], [c]) = (reads.row(0), reads.own(), reads.row(1));
        [h * (bond(self.beta, c, b) - bond(self.beta, b, a))]
    }

    #[inline(always)]
    fn contribution(
        &self,
        pair: usize,
        h: f64,
        _: f64,
        _: &[f64],
        streams: &Streams<'_, [f64; 1]>,
        to: &mut [[f64; 1]],
    ) {
        match pair {
            0 => add::<_, 1, 0, 0>(
                streams,
                to,
                #[inline(always)]
                |at| one(-h * bond(self.beta, at.own()[0], at.row(0)[0])),
            ),
            _ => add::<_, 1, 0, 0>(
                streams,
                to,
                #[inline(always)]
                |at| one(h * bond(self.beta, at.row(0)[0], at.own()[0])),
            ),
        }
    }

    #[inline(always)]
    fn nest(
        &self,
        _: usize,
        h: f64,
        _: f64,
        _: &[f64],
        q: &[[f64; 1]],
        to: &mut [[f64; 1]],
    ) -> Result<(), IndexError> {
        for i in 1..q.len() {
            let force = h * bond(self.beta, q[i][0], q[i - 1][0]);
            to[i][0] -= force;
            to[i - 1][0] += force;
        }
        Ok(())
    }
}

impl<const STREAM: bool> Scene for Chain<STREAM> {
    type Row = [f64; 1];
    const LOOPS: &'static [Loop] = &[Loop {
        text: "the loop at line 9 of `lagrangian`",
        is_stream: STREAM,
    }];
    const TERMS: &'static [Term] = &[Term {
        in_loop: 0,
        slots: &["`q[i]` in `lagrangian`", "`q[i - 1]` in `lagrangian`"],
        columns: 0,
        has_increment: false,
    }];
    const PAIRS: &'static [Pair] = &[pair(0, 0, &[1]), pair(0, 1, &[0])];
    const NODE_PAIRS: usize = 2;
    const READS_TIME: bool = false;

    fn instances(&self, _: usize, n: usize, to: &mut Instances) -> Result<(), Stop> {
        (1..n as i64).try_for_each(|i| to.instance(0, &[i, i - 1], &[], 0))
    }

    fn masses(&self, _: usize, masses: &mut [[f64; 1]]) -> Result<(), IndexError> {
        for mass in masses.as_flattened_mut() {
            *mass += self.mass;
        }
        Ok(())
    }

    fn lagrangian(&self, _: f64, q: &[[f64; 1]], v: &[[f64; 1]]) -> Result<f64, IndexError> {
        let kinetic: f64 = v.iter().map(|v| 0.5 * self.mass * v[0] * v[0]).sum();
        let potential = |two: &[[f64; 1]]| {
            let d = two[1][0] - two[0][0];
            0.5 * d * d + 0.25 * self.beta * d.powi(4)
        };
        Ok(kinetic - q.windows(2).map(potential).sum::<f64>())
    }

    fn processes(&self, _: usize) -> Result<usize, IndexError> {
        Ok(0)
    }
}

const fn pair(term: usize, slot: usize, rows: &'static [usize]) -> Pair {
    Pair {
        term,
        slot,
        rows,
        columns: &[],
        reads_increment: false,
    }
}

/// A ring of springs, or springs in any other order, with the strengths `k`, an external force that depends on time, masses, a
/// noise with one process and a noise with a process for each site:
/// `L = Σ ½ m[i] v[i]² − Σ ½ k[i] (q[next[i]] − q[i])² + Σ q[i] sin t`, `γ = σ Σ q[i]` and
/// `γ[i] = s[i] q[i]²`.
pub(crate) struct Ring<const STREAM: bool> {
    pub k: Vec<f64>,
    pub mass: Vec<f64>,
    pub sigma: f64,
    pub s: Vec<f64>,
    pub next: Vec<i64>,
}

impl<const STREAM: bool> Contributions<Impulses> for Ring<STREAM> {
    type Numbers = [f64; 1];
    type Counts = Counts<2, 3, 1>;

    #[inline(always)]
    fn node(&self, h: f64, t: f64, dw: &[f64], reads: &impl Reads<[f64; 1]>) -> [f64; 1] {
        let ([q], [next], [before]) = (reads.own(), reads.row(0), reads.row(1));
        let springs = reads.column(0) * (next - q) - reads.column(1) * (q - before);
        let noise = self.sigma * dw[0] + 2.0 * reads.column(2) * q * reads.increment(0);
        [h * (springs + t.sin()) + noise]
    }

    #[inline(always)]
    fn contribution(
        &self,
        pair: usize,
        h: f64,
        t: f64,
        dw: &[f64],
        streams: &Streams<'_, [f64; 1]>,
        to: &mut [[f64; 1]],
    ) {
        match pair {
            0 => add::<_, 1, 1, 0>(
                streams,
                to,
                #[inline(always)]
                |at| {
                    let spring = at.column(0) * (at.row(0)[0] - at.own()[0]);
                    one(h * (spring + t.sin()))
                },
            ),
            1 => add::<_, 1, 1, 0>(
                streams,
                to,
                #[inline(always)]
                |at| one(-h * at.column(0) * (at.own()[0] - at.row(0)[0])),
            ),
            _ => add::<_, 0, 1, 1>(
                streams,
                to,
                #[inline(always)]
                |at| one(self.sigma * dw[0] + 2.0 * at.column(0) * at.own()[0] * at.increment(0)),
            ),
        }
    }

    #[inline(always)]
    fn nest(
        &self,
        number: usize,
        h: f64,
        t: f64,
        dw: &[f64],
        q: &[[f64; 1]],
        to: &mut [[f64; 1]],
    ) -> Result<(), IndexError> {
        let n = q.len() as i64;
        for i in 0..n {
            let [own] = q[i as usize];
            if number == 0 {
                let next = *entry(&self.next, i, "`self.next[i]` in `lagrangian`")?;
                let [other] = *entry(q, next, "`q[self.next[i]]` in `lagrangian`")?;
                let k = *entry(&self.k, i, "`self.k[i]` in `lagrangian`")?;
                to[i as usize][0] += h * (k * (other - own) + t.sin());
                to[next as usize][0] -= h * (k * (other - own));
            } else {
                let s = *entry(&self.s, i, "`self.s[i]` in `noise`")?;
                to[i as usize][0] += self.sigma * dw[0] + 2.0 * s * own * dw[1 + i as usize];
            }
        }
        Ok(())
    }
}

impl<const STREAM: bool> Scene for Ring<STREAM> {
    type Row = [f64; 1];
    const LOOPS: &'static [Loop] = &[
        Loop {
            text: "the loop at line 3 of `lagrangian`",
            is_stream: STREAM,
        },
        Loop {
            text: "the loop at line 2 of `noise`",
            is_stream: STREAM,
        },
    ];
    const TERMS: &'static [Term] = &[
        Term {
            in_loop: 0,
            slots: &[
                "`q[i]` in `lagrangian`",
                "`q[self.next[i]]` in `lagrangian`",
            ],
            columns: 1,
            has_increment: false,
        },
        Term {
            in_loop: 1,
            slots: &["`q[i]` in `noise`"],
            columns: 1,
            has_increment: true,
        },
    ];
    const PAIRS: &'static [Pair] = &[
        Pair {
            columns: &[0],
            ..pair(0, 0, &[1])
        },
        Pair {
            columns: &[0],
            ..pair(0, 1, &[0])
        },
        Pair {
            term: 1,
            slot: 0,
            rows: &[],
            columns: &[0],
            reads_increment: true,
        },
    ];
    const NODE_PAIRS: usize = 3;
    const READS_TIME: bool = true;

    fn instances(&self, number: usize, n: usize, to: &mut Instances) -> Result<(), Stop> {
        for i in 0..n as i64 {
            if number == 0 {
                let k = *entry(&self.k, i, "`self.k[i]` in `lagrangian`")?;
                let next = *entry(&self.next, i, "`self.next[i]` in `lagrangian`")?;
                to.instance(0, &[i, next], &[k], 0)?;
            } else {
                let s = *entry(&self.s, i, "`self.s[i]` in `noise`")?;
                to.instance(1, &[i], &[s], 1 + i as usize)?;
            }
        }
        Ok(())
    }

    fn masses(&self, n: usize, masses: &mut [[f64; 1]]) -> Result<(), IndexError> {
        for i in 0..n {
            masses[i][0] += entry(&self.mass, i as i64, "`self.mass[i]` in `lagrangian`")?;
        }
        Ok(())
    }

    fn lagrangian(&self, t: f64, q: &[[f64; 1]], v: &[[f64; 1]]) -> Result<f64, IndexError> {
        let n = q.len();
        Ok((0..n)
            .map(|i| {
                let d = q[self.next[i] as usize][0] - q[i][0];
                0.5 * self.mass[i] * v[i][0] * v[i][0] - 0.5 * self.k[i] * d * d + q[i][0] * t.sin()
            })
            .sum())
    }

    fn processes(&self, n: usize) -> Result<usize, IndexError> {
        Ok(1 + n)
    }
}

/// A lattice of `sides[0] × sides[1] × …` sites with a potential (q² − 1)²/4 at each of them and
/// springs to the next ones, at open borders or around them.
pub(crate) struct Lattice<const D: usize, const STREAM: bool> {
    pub sides: [usize; D],
    pub is_periodic: bool,
}

impl<const D: usize, const STREAM: bool> Lattice<D, STREAM> {
    /// Calls a function for each site, with the number of the site and its next one in each
    /// direction, if there is one.
    #[inline(always)]
    fn visit<E>(
        &self,
        mut to: impl FnMut(i64, [Option<i64>; D]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut strides = [1; D];
        for d in (0..D - 1).rev() {
            strides[d] = strides[d + 1] * self.sides[d + 1] as i64;
        }
        let sites = self.sides.iter().product::<usize>() as i64;
        let mut at = [0; D];
        for site in 0..sites {
            let mut next = [None; D];
            for d in 0..D {
                let side = self.sides[d] as i64;
                if at[d] + 1 < side {
                    next[d] = Some(site + strides[d]);
                } else if self.is_periodic {
                    next[d] = Some(site + strides[d] * (1 - side));
                }
            }
            to(site, next)?;
            for d in (0..D).rev() {
                at[d] += 1;
                if at[d] < self.sides[d] as i64 {
                    break;
                }
                at[d] = 0;
            }
        }
        Ok(())
    }
}

fn site(q: f64) -> f64 {
    -q * (q * q - 1.0)
}

macro_rules! lattice {
    ($dimension:literal, $rows:literal, [$($direction:literal),*]) => {
        impl<const STREAM: bool> Contributions<Impulses> for Lattice<$dimension, STREAM> {
            type Numbers = [f64; 1];
            type Counts = Counts<$rows, 0, 0>;

            #[inline(always)]
            fn node(&self, h: f64, _: f64, _: &[f64], reads: &impl Reads<[f64; 1]>) -> [f64; 1] {
                let [own] = reads.own();
                let mut force = site(own);
                $(force += (reads.row(2 * $direction)[0] - own) - (own - reads.row(2 * $direction + 1)[0]);)*
                [h * force]
            }

            #[inline(always)]
            fn contribution(
                &self,
                pair: usize,
                h: f64,
                _: f64,
                _: &[f64],
                streams: &Streams<'_, [f64; 1]>,
                to: &mut [[f64; 1]],
            ) {
                match pair {
                    0 => add::<_, 0, 0, 0>(streams, to, #[inline(always)] |at| one(h * site(at.own()[0]))),
                    _ => add::<_, 1, 0, 0>(streams, to, #[inline(always)] |at| one(h * (at.row(0)[0] - at.own()[0]))),
                }
            }

            #[inline(always)]
            fn nest(
                &self,
                _: usize,
                h: f64,
                _: f64,
                _: &[f64],
                q: &[[f64; 1]],
                to: &mut [[f64; 1]],
            ) -> Result<(), IndexError> {
                self.visit(|c, next| {
                    let [own] = *entry(q, c, "`q[c]` in `lagrangian`")?;
                    to[c as usize][0] += h * site(own);
                    for next in next.into_iter().flatten() {
                        let [other] = *entry(q, next, "`q[c + stride]` in `lagrangian`")?;
                        to[c as usize][0] += h * (other - own);
                        to[next as usize][0] -= h * (other - own);
                    }
                    Ok(())
                })
            }
        }

        impl<const STREAM: bool> Scene for Lattice<$dimension, STREAM> {
            type Row = [f64; 1];
            const LOOPS: &'static [Loop] = &[Loop {
                text: "the loop at line 4 of `lagrangian`",
                is_stream: STREAM,
            }];
            const TERMS: &'static [Term] = &[
                Term {
                    in_loop: 0,
                    slots: &["`q[c]` in `lagrangian`"],
                    columns: 0,
                    has_increment: false,
                },
                $(Term {
                    in_loop: 0,
                    slots: &[
                        concat!("`q[c + stride[", $direction, "]]` in `lagrangian`"),
                        "`q[c]` in `lagrangian`",
                    ],
                    columns: 0,
                    has_increment: false,
                },)*
            ];
            const PAIRS: &'static [Pair] = &[
                pair(0, 0, &[]),
                $(pair($direction + 1, 0, &[1]), pair($direction + 1, 1, &[0]),)*
            ];
            const NODE_PAIRS: usize = Self::PAIRS.len();
            const READS_TIME: bool = false;

            fn instances(&self, _: usize, _: usize, to: &mut Instances) -> Result<(), Stop> {
                self.visit(|c, next| {
                    to.instance(0, &[c], &[], 0)?;
                    for d in 0..$dimension {
                        if let Some(next) = next[d] {
                            to.instance(d + 1, &[next, c], &[], 0)?;
                        }
                    }
                    Ok(())
                })
            }

            fn masses(&self, _: usize, masses: &mut [[f64; 1]]) -> Result<(), IndexError> {
                for mass in masses.as_flattened_mut() {
                    *mass += 1.0;
                }
                Ok(())
            }

            fn lagrangian(&self, _: f64, q: &[[f64; 1]], v: &[[f64; 1]]) -> Result<f64, IndexError> {
                let mut l = v.iter().map(|v| 0.5 * v[0] * v[0]).sum::<f64>();
                self.visit(|c, next| {
                    let [own] = q[c as usize];
                    l -= 0.25 * (own * own - 1.0).powi(2);
                    for next in next.into_iter().flatten() {
                        let d = q[next as usize][0] - own;
                        l -= 0.5 * d * d;
                    }
                    Ok(())
                })?;
                Ok(l)
            }

            fn processes(&self, _: usize) -> Result<usize, IndexError> {
                Ok(0)
            }
        }
    };
}

lattice!(1, 2, [0]);
lattice!(2, 4, [0, 1]);
lattice!(3, 6, [0, 1, 2]);

/// Atoms with the potential of Lennard and Jones up to a cut-off, for the pairs of a list by rows.
pub(crate) struct Argon {
    pub start: Vec<usize>,
    pub list: Vec<usize>,
    pub cut2: f64,
    pub mass: f64,
}

impl Contributions<Impulses> for Argon {
    type Numbers = [f64; 3];
    type Counts = Counts<0, 0, 0>;

    #[inline(always)]
    fn node(&self, _: f64, _: f64, _: &[f64], _: &impl Reads<[f64; 3]>) -> [f64; 3] {
        [0.0; 3]
    }

    #[inline(always)]
    fn contribution(
        &self,
        _: usize,
        _: f64,
        _: f64,
        _: &[f64],
        _: &Streams<'_, [f64; 3]>,
        _: &mut [[f64; 3]],
    ) {
    }

    #[inline(always)]
    fn nest(
        &self,
        _: usize,
        h: f64,
        _: f64,
        _: &[f64],
        q: &[[f64; 3]],
        to: &mut [[f64; 3]],
    ) -> Result<(), IndexError> {
        let to = &mut to[..q.len()];
        for i in 0..q.len() {
            let a = q[i];
            let mut own = [0.0; 3];
            let at = i as i64;
            let from = *entry(&self.start, at, "`self.start[i]` in `lagrangian`")?;
            let end = *entry(&self.start, at + 1, "`self.start[i + 1]` in `lagrangian`")?;
            for k in from..end {
                let j = *entry(&self.list, k as i64, "`self.list[k]` in `lagrangian`")?;
                let b = *entry(q, j as i64, "`q[self.list[k]]` in `lagrangian`")?;
                let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
                let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                if r2 > self.cut2 {
                    continue;
                }
                let c = 1.0 / r2;
                let s = c * c * c;
                let w = h * (24.0 * c * s * (2.0 * s - 1.0));
                for x in 0..3 {
                    own[x] -= w * d[x];
                    to[j][x] += w * d[x];
                }
            }
            for x in 0..3 {
                to[i][x] += own[x];
            }
        }
        Ok(())
    }
}

impl Scene for Argon {
    type Row = [f64; 3];
    const LOOPS: &'static [Loop] = &[Loop {
        text: "the loop at line 5 of `lagrangian`",
        is_stream: false,
    }];
    const TERMS: &'static [Term] = &[];
    const PAIRS: &'static [Pair] = &[];
    const NODE_PAIRS: usize = 0;
    const READS_TIME: bool = false;

    fn instances(&self, _: usize, _: usize, _: &mut Instances) -> Result<(), Stop> {
        Ok(())
    }

    fn masses(&self, _: usize, masses: &mut [[f64; 3]]) -> Result<(), IndexError> {
        for mass in masses.as_flattened_mut() {
            *mass += self.mass;
        }
        Ok(())
    }

    fn lagrangian(&self, _: f64, q: &[[f64; 3]], v: &[[f64; 3]]) -> Result<f64, IndexError> {
        let kinetic: f64 = v
            .as_flattened()
            .iter()
            .map(|v| 0.5 * self.mass * v * v)
            .sum();
        let mut potential = 0.0;
        for i in 0..q.len() {
            for &j in &self.list[self.start[i]..self.start[i + 1]] {
                let r2: f64 = (0..3).map(|x| (q[j][x] - q[i][x]).powi(2)).sum();
                if r2 <= self.cut2 {
                    potential += 4.0 * (r2.powi(-6) - r2.powi(-3));
                }
            }
        }
        Ok(kinetic - potential)
    }

    fn processes(&self, _: usize) -> Result<usize, IndexError> {
        Ok(0)
    }
}

/// Bodies that attract one another: a bond of a list for each pair, or all pairs.
pub(crate) struct Bodies<const ALL: bool> {
    pub bonds: Vec<[usize; 2]>,
    pub k: f64,
    pub length: f64,
    pub softening: f64,
}

impl<const ALL: bool> Contributions<Impulses> for Bodies<ALL> {
    type Numbers = [f64; 3];
    type Counts = Counts<0, 0, 0>;

    #[inline(always)]
    fn node(&self, _: f64, _: f64, _: &[f64], _: &impl Reads<[f64; 3]>) -> [f64; 3] {
        [0.0; 3]
    }

    #[inline(always)]
    fn contribution(
        &self,
        _: usize,
        _: f64,
        _: f64,
        _: &[f64],
        _: &Streams<'_, [f64; 3]>,
        _: &mut [[f64; 3]],
    ) {
    }

    #[inline(always)]
    fn nest(
        &self,
        _: usize,
        h: f64,
        _: f64,
        _: &[f64],
        q: &[[f64; 3]],
        to: &mut [[f64; 3]],
    ) -> Result<(), IndexError> {
        let to = &mut to[..q.len()];
        if ALL {
            for i in 0..q.len() {
                let a = q[i];
                let mut own = [0.0; 3];
                for j in i + 1..q.len() {
                    let b = q[j];
                    let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
                    let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + self.softening;
                    let w = h * (self.k / (r2 * r2.sqrt()));
                    for x in 0..3 {
                        own[x] += w * d[x];
                        to[j][x] -= w * d[x];
                    }
                }
                for x in 0..3 {
                    to[i][x] += own[x];
                }
            }
            return Ok(());
        }
        for &[i, j] in &self.bonds {
            let a = *entry(q, i as i64, "`q[self.bonds[k][0]]` in `lagrangian`")?;
            let b = *entry(q, j as i64, "`q[self.bonds[k][1]]` in `lagrangian`")?;
            let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            let r = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let w = h * (self.k * (r - self.length) / r);
            let g = [w * d[0], w * d[1], w * d[2]];
            for x in 0..3 {
                to[i][x] += g[x];
            }
            for x in 0..3 {
                to[j][x] -= g[x];
            }
        }
        Ok(())
    }
}

impl<const ALL: bool> Scene for Bodies<ALL> {
    type Row = [f64; 3];
    const LOOPS: &'static [Loop] = &[Loop {
        text: "the loop at line 6 of `lagrangian`",
        is_stream: false,
    }];
    const TERMS: &'static [Term] = &[];
    const PAIRS: &'static [Pair] = &[];
    const NODE_PAIRS: usize = 0;
    const READS_TIME: bool = false;

    fn instances(&self, _: usize, _: usize, _: &mut Instances) -> Result<(), Stop> {
        Ok(())
    }

    fn masses(&self, _: usize, masses: &mut [[f64; 3]]) -> Result<(), IndexError> {
        for mass in masses.as_flattened_mut() {
            *mass += 1.0;
        }
        Ok(())
    }

    fn lagrangian(&self, _: f64, q: &[[f64; 3]], v: &[[f64; 3]]) -> Result<f64, IndexError> {
        let kinetic: f64 = v.as_flattened().iter().map(|v| 0.5 * v * v).sum();
        let square =
            |i: usize, j: usize| -> f64 { (0..3).map(|x| (q[j][x] - q[i][x]).powi(2)).sum() };
        let mut potential = 0.0;
        if ALL {
            for i in 0..q.len() {
                for j in i + 1..q.len() {
                    potential -= self.k / (square(i, j) + self.softening).sqrt();
                }
            }
        }
        for &[i, j] in &self.bonds {
            potential += 0.5 * self.k * (square(i, j).sqrt() - self.length).powi(2);
        }
        Ok(kinetic - potential)
    }

    fn processes(&self, _: usize) -> Result<usize, IndexError> {
        Ok(0)
    }
}
