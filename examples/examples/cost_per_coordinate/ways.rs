//! Ways to make steps of a system: by a trajectory, by single steps, and by loops.

use std::hint::black_box;

use sve_runtime::prelude::*;
use sve_runtime::system::{AnySystem, StateOf};
use sve_runtime::{NeighbourError, Trajectory};

use crate::hand::{self, dispatch};
use crate::plain::{self, Rows};
use crate::scenes::{self, Atoms, BETA, Chain, Lattice, Polymer};

/// Something that makes steps.
pub(crate) trait Way {
    fn advance(&mut self, steps: u64);
    /// Returns the coordinates.
    fn q(&mut self) -> Vec<f64>;
}

/// A coordinate, or the three of a body.
pub(crate) trait Row: Copy {
    const ZERO: Self;
    /// Adds `h` times another row.
    fn add(&mut self, h: f64, other: Self);
}

impl Row for f64 {
    const ZERO: Self = 0.0;
    fn add(&mut self, h: f64, other: Self) {
        *self += h * other;
    }
}

impl Row for [f64; 3] {
    const ZERO: Self = [0.0; 3];
    fn add(&mut self, h: f64, other: Self) {
        self.iter_mut().zip(other).for_each(|(to, x)| *to += h * x);
    }
}

/// Rows whose coordinates can be listed.
pub(crate) trait Rowed {
    fn flat(&self) -> Vec<f64>;
}

impl Rowed for Vec<f64> {
    fn flat(&self) -> Vec<f64> {
        self.clone()
    }
}

impl Rowed for Vec<[f64; 3]> {
    fn flat(&self) -> Vec<f64> {
        self.as_flattened().to_vec()
    }
}

/// Loops by hand: a function of rows of positions, momenta and forces, and of the step.
struct Loops<R, F> {
    rows: [Vec<R>; 3],
    h: f64,
    step: F,
}

impl<R: Row, F: FnMut(Rows<'_, R>, f64)> Loops<R, F> {
    /// Starts loops of the rule of Störmer and Verlet at rest, with the forces at the start.
    fn new(start: &[R], h: f64, mut step: F) -> Self {
        let zeros = || vec![R::ZERO; start.len()];
        let mut rows = [start.to_vec(), zeros(), zeros()];
        step(rows.each_mut().map(Vec::as_mut_slice), 0.0);
        Self { rows, h, step }
    }

    /// Replaces the loops by loops that drift and then kick by whole steps, from momenta half a
    /// step later: the positions are the same.
    fn with_whole_kicks<G: FnMut(Rows<'_, R>, f64)>(self, step: G) -> Loops<R, G> {
        let Self {
            rows: [q, mut p, f],
            h,
            ..
        } = self;
        let pairs = p.iter_mut().zip(&f);
        pairs.for_each(|(p, &f)| p.add(0.5 * h, f));
        Loops {
            rows: [q, p, f],
            h,
            step,
        }
    }
}

impl<R: Row, F: FnMut(Rows<'_, R>, f64)> Way for Loops<R, F>
where
    Vec<R>: Rowed,
{
    fn advance(&mut self, steps: u64) {
        for _ in 0..steps {
            let rows = self.rows.each_mut().map(Vec::as_mut_slice);
            (self.step)(black_box(rows), self.h);
        }
    }

    fn q(&mut self) -> Vec<f64> {
        self.rows[0].flat()
    }
}

impl<M> Way for Trajectory<'_, M, NoNoise>
where
    M: OneStepMethod,
    M::System: AnySystem<Configuration: Rowed>,
{
    fn advance(&mut self, steps: u64) {
        black_box(Trajectory::advance(self, steps).expect("a finite state"));
    }

    fn q(&mut self) -> Vec<f64> {
        let state = Trajectory::advance(self, 0).expect("a finite state");
        state.q.flat()
    }
}

/// Single steps of a state.
struct Single<'a, M: OneStepMethod> {
    method: &'a M,
    state: StateOf<M::System>,
    h: f64,
}

impl<M> Way for Single<'_, M>
where
    M: OneStepMethod<Increments = [f64]>,
    M::System: AnySystem<Configuration: Rowed>,
{
    fn advance(&mut self, steps: u64) {
        for _ in 0..steps {
            let prepared = self.method.prepare(self.h).expect("a step size");
            self.method
                .step_prepared(&prepared, black_box(&mut self.state), self.h, &[])
                .expect("a finite state");
        }
    }

    fn q(&mut self) -> Vec<f64> {
        self.state.q.flat()
    }
}

/// Trajectory, single steps, loops as one writes them first, the best loops.
pub(crate) const WAYS: usize = 4;
pub(crate) type Ways<'a> = [Box<dyn Way + 'a>; WAYS];

/// A system of about so many coordinates with its start, in whichever types.
pub(crate) trait Scene {
    /// Number of coordinates.
    fn coordinates(&self) -> usize;
    fn ways(&self, h: f64) -> Ways<'_>;
}

/// A method with the start of its states.
struct Started<S: AnySystem> {
    integrator: Integrator<S, StormerVerlet>,
    start: StateOf<S>,
}

/// Implements [`Scene`] for a system with the loops of a function of the system, its start and the
/// step.
macro_rules! scene {
    ($system:ty, $loops:expr) => {
        impl Started<$system> {
            fn boxed(system: $system, start: StateOf<$system>) -> Box<dyn Scene> {
                let integrator = Integrator::new(system, StormerVerlet);
                Box::new(Self { integrator, start })
            }
        }

        impl Scene for Started<$system> {
            fn coordinates(&self) -> usize {
                self.start.q.flat().len()
            }

            fn ways(&self, h: f64) -> Ways<'_> {
                let (method, state) = (&self.integrator, self.start.clone());
                let path = method.trajectory(state.clone(), h, NoNoise);
                let [plain, best] = $loops(method.system(), &self.start.q, h);
                let single = Single { method, state, h };
                [Box::new(path), Box::new(single), plain, best]
            }
        }
    };
}

scene!(Chain, chain_loops);
scene!(Lattice, lattice_loops);
scene!(Atoms, atom_loops);
scene!(Polymer, bond_loops);

type Both<'a> = [Box<dyn Way + 'a>; 2];

fn chain_loops<'a>(&Chain { beta }: &Chain, start: &[f64], h: f64) -> Both<'a> {
    let plain = || Loops::new(start, h, move |rows, h| plain::chain(rows, h, beta));
    let best = plain().with_whole_kicks(move |[q, p, _], h| {
        dispatch(hand::Chain { q, p, h, beta });
    });
    [Box::new(plain()), Box::new(best)]
}

fn lattice_loops<'a>(&Lattice { sides }: &Lattice, start: &[f64], h: f64) -> Both<'a> {
    let plain = || Loops::new(start, h, move |rows, h| plain::lattice(rows, h, sides));
    let sides = [1, sides[0], sides[1]];
    let best = plain().with_whole_kicks(move |[q, p, _], h| {
        dispatch(hand::Lattice { sides, q, p, h });
    });
    [Box::new(plain()), Box::new(best)]
}

fn atom_loops<'a>(atoms: &'a Atoms, start: &[[f64; 3]], h: f64) -> Both<'a> {
    let (from, list) = (&atoms.near.start, &atoms.near.list);
    let plain = Loops::new(start, h, |rows, h| plain::atoms(rows, h, from, list));
    let [from, list] = [from, list].map(|of| of.iter().map(|&i| i as u32).collect::<Vec<_>>());
    let best = Loops::new(start, h, move |rows, h| {
        hand::verlet(rows, h, |q, f| hand::argon(&from, &list, q, f));
    });
    [Box::new(plain), Box::new(best)]
}

fn bond_loops<'a>(polymer: &'a Polymer, start: &[[f64; 3]], h: f64) -> Both<'a> {
    let plain = Loops::new(start, h, |rows, h| plain::bonds(rows, h, &polymer.bonds));
    let best = Loops::new(start, h, |rows, h| hand::verlet(rows, h, plain::chains));
    [Box::new(plain), Box::new(best)]
}

/// The kinds of scenes: their names, a step of theirs, one that does not move them out of their
/// lists, and a scene of about so many coordinates.
pub(crate) struct Kind {
    pub name: &'static str,
    pub h: f64,
    pub short: f64,
    pub scene: fn(usize) -> Result<Box<dyn Scene>, NeighbourError>,
}

pub(crate) const KINDS: [Kind; 4] = [
    Kind {
        name: "chain",
        h: 0.05,
        short: 0.05,
        scene: |n| {
            Ok(Started::<Chain>::boxed(
                Chain { beta: BETA },
                scenes::sites(n),
            ))
        },
    },
    Kind {
        name: "φ⁴ lattice",
        h: 0.05,
        short: 0.05,
        scene: |n| {
            Ok(Started::<Lattice>::boxed(
                scenes::lattice(n),
                scenes::sites(n),
            ))
        },
    },
    Kind {
        name: "bonds of polymers",
        h: 0.01,
        short: 1e-6,
        scene: |n| {
            Ok(Started::<Polymer>::boxed(
                scenes::polymer(n / 3),
                scenes::grid(n / 3),
            ))
        },
    },
    Kind {
        name: "atoms with lists",
        h: 0.002,
        short: 1e-6,
        scene: |n| {
            let start = scenes::grid(n / 3);
            Ok(Started::<Atoms>::boxed(scenes::atoms(&start)?, start))
        },
    },
];
