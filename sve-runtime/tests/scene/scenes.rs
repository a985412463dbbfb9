//! Scenes, and a wrapper that makes all their loops as they are written.

use sve_runtime::__private::scene::{
    Contributions, Counts, Impulses, IndexError, Instances, Loop, Pair, Reads, Row, Scene, Stop,
    Streams, Term,
};
use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

/// A chain with free ends.
pub(crate) struct Chain {
    pub beta: f64,
    pub mass: f64,
}

#[variational(initial_point, endpoint, stormer_verlet)]
impl Chain {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for v in v {
            l += 0.5 * self.mass * v * v;
        }
        for i in 1..q.len() {
            let d = q[i] - q[i - 1];
            l -= 0.5 * d * d + 0.25 * self.beta * d.powi(4);
        }
        l
    }
}

/// A ring of springs, or springs in any other order, with a force that depends on time, a noise
/// with one process and a noise with a process for each site.
pub(crate) struct Ring {
    pub k: Vec<f64>,
    pub mass: Vec<f64>,
    pub sigma: f64,
    pub s: Vec<f64>,
    pub next: Vec<i64>,
}

#[variational(initial_point, endpoint, stormer_verlet)]
#[allow(clippy::cast_sign_loss)] // negative indices are errors that are tested
impl Ring {
    fn lagrangian(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            let d = q[self.next[i] as usize] - q[i];
            l += 0.5 * self.mass[i] * v[i] * v[i] - 0.5 * self.k[i] * d * d + q[i] * t.sin();
        }
        l
    }

    #[gamma]
    fn common(&self, q: &[f64]) -> f64 {
        self.sigma * q.iter().sum::<f64>()
    }

    #[gamma]
    fn noise(&self, q: &[f64]) -> Vec<f64> {
        (0..q.len()).map(|i| self.s[i] * q[i] * q[i]).collect()
    }
}

/// A lattice of `sides[0] × sides[1] × …` sites, each in a double well and with springs to the next
/// sites. The borders are open if `around` is 0, and periodic if it is 1.
pub(crate) struct Lattice<const D: usize> {
    pub sides: [usize; D],
    pub around: usize,
}

macro_rules! lattices {
    ($($dimension:literal)*) => {$(
        #[variational(endpoint)]
        impl Lattice<$dimension> {
            fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
                let mut l = 0.0;
                for v in v {
                    l += 0.5 * v * v;
                }
                let mut sites = 1;
                for d in 0..$dimension {
                    sites *= self.sides[d];
                }
                for c in 0..sites {
                    l -= 0.25 * (q[c] * q[c] - 1.0).powi(2);
                    let mut stride = 1;
                    for d in 0..$dimension {
                        let side = self.sides[$dimension - 1 - d];
                        let at = c / stride % side;
                        if at + 1 < side + self.around {
                            let next = c + stride * ((at + 1) % side) - stride * at;
                            l -= 0.5 * (q[next] - q[c]).powi(2);
                        }
                        stride *= side;
                    }
                }
                l
            }
        }
    )*};
}
lattices!(1 2 3);

/// Atoms with the potential of Lennard and Jones up to a cut-off, for the pairs of a list by rows.
pub(crate) struct Argon {
    pub start: Vec<usize>,
    pub list: Vec<usize>,
    pub cut2: f64,
    pub mass: f64,
}

#[variational(stormer_verlet)]
impl Argon {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * self.mass * v[i].norm_squared();
            for k in self.start[i]..self.start[i + 1] {
                let r2 = (q[self.list[k]] - q[i]).norm_squared();
                if r2 > self.cut2 {
                    continue;
                }
                let s = 1.0 / (r2 * r2 * r2);
                l -= 4.0 * (s * s - s);
            }
        }
        l
    }
}

/// Bodies of which all pairs attract one another.
pub(crate) struct Bodies {
    pub k: f64,
    pub softening: f64,
}

#[variational(endpoint)]
impl Bodies {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i].norm_squared();
            for j in i + 1..q.len() {
                l += self.k / ((q[j] - q[i]).norm_squared() + self.softening).sqrt();
            }
        }
        l
    }
}

/// Atoms with bonds of a list.
pub(crate) struct Polymer {
    pub bonds: Vec<[usize; 2]>,
    pub k: f64,
    pub length: f64,
}

#[variational(endpoint)]
impl Polymer {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        for v in v {
            l += 0.5 * v.norm_squared();
        }
        for bond in &self.bonds {
            let r = (q[bond[1]] - q[bond[0]]).norm();
            l -= 0.5 * self.k * (r - self.length).powi(2);
        }
        l
    }
}

/// A scene all of whose loops are made as they are written.
pub(crate) struct AsWritten<'a, S>(pub &'a S);

impl<S: Scene> Contributions<Impulses> for AsWritten<'_, S> {
    type Numbers = S::Row;
    type Counts = Counts<0, 0, 0>;

    fn node(&self, _: f64, _: f64, _: &[f64], _: &impl Reads<S::Row>) -> S::Row {
        S::Row::ZERO
    }

    fn contribution(
        &self,
        _: usize,
        _: f64,
        _: f64,
        _: &[f64],
        _: &Streams<'_, S::Row>,
        _: &mut [S::Row],
    ) {
        unreachable!("no loop is a stream")
    }

    fn nest(
        &self,
        number: usize,
        h: f64,
        t: f64,
        dw: &[f64],
        q: &[S::Row],
        to: &mut [S::Row],
    ) -> Result<(), IndexError> {
        self.0.nest(number, h, t, dw, q, to)
    }
}

impl<S: Scene> AsWritten<'_, S> {
    /// The loops of scenes with up to three loops.
    const ALL: &'static [Loop; 3] = &[Self::of_loop(0), Self::of_loop(1), Self::of_loop(2)];

    const fn of_loop(number: usize) -> Loop {
        Loop {
            text: S::LOOPS[number % S::LOOPS.len()].text,
            is_stream: false,
            has_noise: S::LOOPS[number % S::LOOPS.len()].has_noise,
        }
    }
}

impl<S: Scene> Scene for AsWritten<'_, S> {
    type Row = S::Row;
    const LOOPS: &'static [Loop] = Self::ALL.split_at(S::LOOPS.len()).0;
    const TERMS: &'static [Term] = S::TERMS;
    const PAIRS: &'static [Pair] = &[];
    const NODE_PAIRS: usize = 0;
    const READS_TIME: bool = S::READS_TIME;

    fn instances(&self, _: usize, _: usize, _: &mut Instances) -> Result<(), Stop> {
        unreachable!("no loop is a stream")
    }

    fn masses(&self, n: usize, masses: &mut [S::Row]) -> Result<(), IndexError> {
        self.0.masses(n, masses)
    }

    fn lagrangian(&self, t: f64, q: &[S::Row], v: &[S::Row]) -> Result<f64, IndexError> {
        self.0.lagrangian(t, q, v)
    }

    fn processes(&self, n: usize) -> Result<usize, IndexError> {
        self.0.processes(n)
    }
}
