//! Bounds of the derivatives at a node over a box of times, positions, velocities and momenta. With
//! these bounds, the Gauss rules prove which solution of a step they found.
//!
//! Input: the derivatives of the model. Output: expressions of the magnitudes of second
//! derivatives, from the centre of the box and half its widths; none if the system is too large or
//! has a function without bounds. The runtime combines the magnitudes for all stages
//! (`gauss/connected.rs`).

use std::collections::HashMap;

use crate::algebra::intervals::{Flavour, Intervals, Range, intervals};
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::domain;
use crate::model::{Argument, Meaning, Model, Symbols};
use crate::system::mechanics::{Mechanics, NoiseJet, less};

/// Largest number of coordinates of a system with bounds. The bounds take about as long to compute
/// as the second derivatives.
const BOUNDED: usize = 4;

/// The number of solutions of a step of many stages, as far as it is known. Linear equations of
/// noise forces that depend on velocities have bounds too: see `structure/block.rs`.
pub(crate) enum Uniqueness {
    /// The equations are linear and have one solution.
    Linear,
    /// The bounds can prove that there is one solution.
    Bounded(Box<NodeBounds>),
    /// There are no bounds.
    Unknown,
}

/// Bounds over a box. Matrices have rows by the component that is differentiated.
pub(crate) struct NodeBounds {
    /// Midpoints and radii of `∂²L/∂v²`.
    pub(crate) mass: [Vec<Vec<Expr>>; 2],
    /// Magnitudes and radii of the derivatives of `∂L/∂v` in time, and below in position.
    pub(crate) momentum_by_time: [Vec<Expr>; 2],
    pub(crate) momentum_by_position: [Vec<Vec<Expr>>; 2],
    /// Magnitudes of the derivatives of `∂L/∂q + F` in time, position and velocity.
    pub(crate) force: (Vec<Expr>, [Vec<Vec<Expr>>; 2]),
    pub(crate) noises: Vec<NoiseBounds>,
    /// Expressions that must be positive for the bounds to hold.
    pub(crate) conditions: Vec<Expr>,
}

/// Magnitudes of derivatives of a noise over a box.
pub(crate) struct NoiseBounds {
    /// `∂G/∂q − f`, `∂G/∂p`, and their derivatives in time.
    pub(crate) vectors: [Vec<Expr>; 4],
    /// `∂(∂G/∂q − f)/∂q`, `∂²G/∂q∂p` with rows by q, `∂²G/∂p²`, `∂f/∂v`.
    pub(crate) matrices: [Vec<Vec<Expr>>; 4],
}

/// Derives the bounds. Declares the radii of the box in `symbols`.
pub(crate) fn uniqueness(
    model: &Model,
    mechanics: &Mechanics,
    symbols: &mut Symbols,
    arena: &mut Arena,
) -> Uniqueness {
    let derivatives = Derivatives::new(model, mechanics, arena);
    let moving = [&model.q[..], &model.v, &model.p].concat();
    let second = derivatives.second();
    let reads_velocity = mechanics.noises.iter().any(|noise| noise.reads_velocity);
    let moves = |&e: &Expr| moving.iter().any(|&s| arena.contains(e, s));
    if !reads_velocity && !second.iter().any(moves) {
        return Uniqueness::Linear;
    }
    if model.dof() > BOUNDED {
        return Uniqueness::Unknown;
    }
    let ranges = ranges(model, symbols);
    match derivatives.bounds(model, &ranges, arena) {
        Some(bounds) => Uniqueness::Bounded(Box::new(bounds)),
        None => Uniqueness::Unknown,
    }
}

fn ranges(model: &Model, symbols: &mut Symbols) -> HashMap<Symbol, Range> {
    let mut ranges = HashMap::new();
    let mut within = |symbol: Symbol, axis: Argument| {
        let radius = symbols.declare(Meaning::Radius(axis));
        ranges.insert(symbol, Range::Within(radius));
    };
    within(model.time, Argument::Time);
    for (i, &symbol) in model.q.iter().enumerate() {
        within(symbol, Argument::Position(i));
    }
    for (i, &symbol) in model.v.iter().enumerate() {
        within(symbol, Argument::Velocity(i));
    }
    for (i, &symbol) in model.p.iter().enumerate() {
        within(symbol, Argument::Momentum(i));
    }
    ranges
}

/// The derivatives that are bounded, in rows.
struct Derivatives {
    /// The derivatives of the momentum in velocity, position and time.
    momentum: Vec<Vec<Expr>>,
    /// The derivatives of the force in time, position and velocity.
    force: Vec<Vec<Expr>>,
    /// For each noise the rows of [`of_noise`].
    noises: Vec<Vec<Vec<Expr>>>,
}

impl Derivatives {
    fn new(model: &Model, mechanics: &Mechanics, arena: &mut Arena) -> Self {
        let l = &mechanics.lagrangian;
        let n = model.dof();
        let transposed = |m: &[Vec<Expr>]| -> Vec<Vec<Expr>> {
            (0..n).map(|i| (0..n).map(|j| m[j][i]).collect()).collect()
        };
        let mut momentum = l.dvv.clone();
        momentum.extend(transposed(&l.dqv));
        momentum.push(l.dvt.clone());
        let mut force = vec![l.dqt.clone()];
        force.extend(l.dqq.iter().chain(&l.dqv).cloned());
        if let Some(jet) = &mechanics.force {
            let more = std::iter::once(&jet.dt).chain(&jet.dq).chain(&jet.dv);
            for (row, more) in force.iter_mut().zip(more) {
                for (entry, &more) in row.iter_mut().zip(more) {
                    *entry = arena.add(*entry, more);
                }
            }
        }
        let noises = mechanics.noises.iter();
        Self {
            noises: noises.map(|jet| of_noise(jet, model, arena)).collect(),
            momentum,
            force,
        }
    }

    /// Returns the second derivatives. If they do not depend on positions, velocities and momenta,
    /// the equations of a step are linear.
    fn second(&self) -> Vec<Expr> {
        let of_noises = self.noises.iter().flat_map(|noise| &noise[4..]);
        let rows = self.momentum.iter().chain(&self.force).chain(of_noises);
        rows.flatten().copied().collect()
    }

    fn bounds(
        &self,
        model: &Model,
        ranges: &HashMap<Symbol, Range>,
        arena: &mut Arena,
    ) -> Option<NodeBounds> {
        let n = model.dof();
        let rows =
            |flat: &[Expr]| -> Vec<Vec<Expr>> { flat.chunks(n).map(<[Expr]>::to_vec).collect() };
        let noises = model.noises.iter().map(|noise| noise.hamiltonian);
        let mut defined: Vec<Expr> = noises.chain([model.lagrangian]).collect();
        defined.extend(model.forces().flatten());
        let domain = domain::conditions(&defined, arena);
        let domain: Vec<Expr> = domain.iter().map(|c| c.value).collect();
        // The bounds use how much the derivatives of the momentum vary. For all other derivatives
        // magnitudes are enough, and no sine or cosine must be computed for these.
        let momentum = self.momentum.concat();
        let momentum = intervals(&momentum, &domain, ranges, Flavour::Box, arena)?;
        let others = [&self.force[..], &self.noises.concat()].concat().concat();
        let others = intervals(&others, &[], ranges, Flavour::Global, arena)?;
        let [of_momentum, others_size] =
            [&momentum, &others].map(|intervals| rows(&magnitudes(intervals, arena)));
        let (middle, radii) = (rows(&momentum.middle), rows(&momentum.radii));
        let mut conditions = [momentum.conditions, others.conditions].concat();
        conditions.sort_unstable();
        conditions.dedup();
        let mut others = others_size.into_iter();
        let mut next = |count: usize| -> Vec<Vec<Expr>> { others.by_ref().take(count).collect() };
        let force = (next(1).concat(), [next(n), next(n)]);
        let noises = (0..model.noises.len()).map(|_| NoiseBounds {
            vectors: std::array::from_fn(|_| next(1).concat()),
            matrices: std::array::from_fn(|_| next(n)),
        });
        Some(NodeBounds {
            noises: noises.collect(),
            mass: [middle[..n].to_vec(), radii[..n].to_vec()],
            momentum_by_position: [of_momentum[n..2 * n].to_vec(), radii[n..2 * n].to_vec()],
            momentum_by_time: [of_momentum[2 * n].clone(), radii[2 * n].clone()],
            force,
            conditions,
        })
    }
}

/// Returns the field of a noise, `∂G/∂q − f` and `∂G/∂p`, its derivatives in time, in positions and
/// momenta, and that of f in velocities.
fn of_noise(jet: &NoiseJet, model: &Model, arena: &mut Arena) -> Vec<Vec<Expr>> {
    let against = jet.against(arena);
    let mut by_position = jet.dqq.clone();
    let mut by_velocity = vec![vec![arena.constant(0.0); model.dof()]; model.dof()];
    if let Some(force) = &jet.force {
        for (row, more) in by_position.iter_mut().zip(&force.dq) {
            *row = less(row, more, arena);
        }
        by_velocity.clone_from(&force.dv);
    }
    let mut by_time =
        |row: &[Expr]| -> Vec<Expr> { row.iter().map(|&e| arena.diff(e, model.time)).collect() };
    let (against_by_time, dp_by_time) = (by_time(&against), by_time(&jet.dp));
    let vectors = [against, jet.dp.clone(), against_by_time, dp_by_time];
    let matrices = [by_position, jet.dqp.clone(), jet.dpp.clone(), by_velocity];
    vectors
        .into_iter()
        .chain(matrices.into_iter().flatten())
        .collect()
}

/// Returns `|middle| + radius`.
fn magnitudes(intervals: &Intervals, arena: &mut Arena) -> Vec<Expr> {
    let parts = intervals.middle.iter().zip(&intervals.radii);
    let magnitude = |(&middle, &radius): (&Expr, &Expr)| {
        let size = arena.abs(middle);
        arena.add(size, radius)
    };
    parts.map(magnitude).collect()
}
