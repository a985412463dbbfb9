//! Scenes: systems of any number of sites, whose loops are known when the program runs.
//!
//! | file | part |
//! | --- | --- |
//! | `rows.rs` | the numbers of a site |
//! | `streams.rs` | what a printed loop reads: slices that advance by one from node to node |
//! | `index.rs` | indices that are out of range, with the round of the loops |
//! | `indices.rs` | the instances of the loops, cut into runs of consecutive indices |
//! | `segments.rs` | the runs, seen from the nodes that they contribute to |
//! | `pieces.rs` | consecutive nodes with contributions of the same pairs |
//! | `written.rs` | what loops read as they are written: rows and fields with checked indices |
//! | `blocks.rs` | inner loops over consecutive sites, in blocks |
//! | `sweep.rs` | a drift and the impulses of all loops, added to the momenta |
//! | `visit.rs` | the impulses of the nodes of a piece |
//! | `additions.rs` | impulses that are added to momenta, with tests of the results |
//! | `drift.rs` | the motion of sites with their velocities |
//! | `steps.rs` | steps that are lists of drifts and kicks, in place |
//! | `single.rs` | a single step, and the way back if it fails |
//! | `shear.rs` | tables for such steps, and blocks of steps |
//! | `midpoint.rs` | steps of the midpoint rule, whose equations join all sites |
//! | `work.rs` | its arrays |
//! | `gather.rs` | sweeps whose sums are used piece by piece |
//! | `relax.rs` | what the sweeps of such a step do with the impulses |
//! | `shifts.rs` | noises H₁ in such steps |
//! | `passes.rs` | what such a step computes for each component alone |
//! | `chebyshev.rs` | the iteration that solves these equations |
//! | `spectrum.rs` | bounds of the derivatives of impulses, from boxes around the motion |
//! | `masses.rs` | masses and friction |
//! | `kinetic.rs` | kinetic energies that are no sums of `½ m v²`, and their velocities |
//! | `mechanics.rs` | energies and velocities, for users |
//! | `momentum.rs` | momenta of symmetries |
//! | `errors.rs` | errors of steps, and the checks that find them |
//! | `drag.rs` | drifts with forces of velocities and H₁, and drifts of solved velocities |
//! | `layout.rs` | what is known about the loops of a scene of known size |
//!
//! The folder knows arrays, and of mechanics the kinetic energy of a site. A loop of the user is a
//! list of instances, and each instance reads some nodes, which are sites of the configuration.
//! Where the nodes of consecutive instances are consecutive, the derivatives are computed from
//! slices; any other loop is made as the user wrote it.

mod additions;
mod blocks;
mod chebyshev;
mod drag;
mod drift;
mod errors;
mod gather;
mod index;
mod indices;
mod kinetic;
mod layout;
mod masses;
mod mechanics;
mod midpoint;
mod momentum;
mod passes;
mod pieces;
mod relax;
mod rows;
mod segments;
mod shear;
mod shifts;
mod single;
mod spectrum;
mod steps;
mod streams;
mod sweep;
mod visit;
mod work;
mod written;

pub use blocks::{Added, Field, NoNumbers, consecutive, in_blocks};
pub(crate) use errors::check_length;
pub use index::{InLoops, IndexError, Instance, Stop, entry, within};
pub use indices::Instances;
pub use kinetic::{KineticForm, KineticJet, KineticTerms};
pub use layout::Layout;
pub use mechanics::SceneMechanics;
pub use midpoint::{MidpointStep, midpoint};
pub use momentum::{PartialSums, momentum};
pub use rows::Row;
pub use shear::{Phase, Prepared};
pub use streams::{At, Counts, Reads, StreamCounts, Streams, add};
pub use work::MidpointSolution;
pub use written::{
    Integer, accumulate, check, integer, place, position, quotient, remainder, row_if_any,
};

use crate::error::StepError;

/// The values that the loops of a scene add to each node. `W` is their kind: [`Impulses`] or
/// [`Slopes`].
pub trait Contributions<W> {
    /// The numbers of a node: what the loops read, and what they add.
    type Numbers: Row;
    /// The numbers of streams that [`node`](Self::node) reads: of rows, of columns and of
    /// increments, each in the order of [`Scene::PAIRS`].
    type Counts: StreamCounts;

    /// Returns the sum at a node to which each of the first [`Scene::NODE_PAIRS`] pairs contributes
    /// once. `#[inline(always)]`.
    ///
    /// `dw` has all increments of the step: those of listed processes, then those of terms; and
    /// then the totals.
    fn node(&self, h: f64, t: f64, dw: &[f64], reads: &impl Reads<Self::Numbers>) -> Self::Numbers;

    /// Adds the contributions of one pair to consecutive nodes, with [`add`]. `#[inline(always)]`.
    ///
    /// The streams are those of the pair alone.
    fn contribution(
        &self,
        pair: usize,
        h: f64,
        t: f64,
        dw: &[f64],
        streams: &Streams<'_, Self::Numbers>,
        to: &mut [Self::Numbers],
    );

    /// Adds the contributions of a loop as it is written, to an array of the length of `q`.
    /// `#[inline(always)]`.
    ///
    /// # Errors
    /// An index that is out of range.
    fn nest(
        &self,
        number: usize,
        h: f64,
        t: f64,
        dw: &[f64],
        q: &[Self::Numbers],
        to: &mut [Self::Numbers],
    ) -> Result<(), IndexError>;

    /// The number of sums that enter formulas, such as a mean field, and of the derivatives with
    /// respect to them; of what bounds these, for [`Slopes`].
    const TOTALS: usize = 0;

    /// Writes these numbers to the end of `dw`, the last one first.
    ///
    /// # Errors
    /// An index that is out of range.
    fn totals(&self, t: f64, q: &[Self::Numbers], dw: &mut [f64]) -> Result<(), IndexError> {
        let _ = (t, q, dw);
        Ok(())
    }

    /// Adds what reads velocities or momenta, at all sites. `of` has velocities for drags and
    /// momenta for H₁, and `dw` ends with the totals.
    ///
    /// # Errors
    /// An index that is out of range.
    #[allow(clippy::too_many_arguments)] // those of a nest, and another array
    fn in_drift(
        &self,
        part: InDrift,
        h: f64,
        t: f64,
        dw: &[f64],
        q: &[Self::Numbers],
        of: &[Self::Numbers],
        to: &mut [Self::Numbers],
    ) -> Result<(), IndexError> {
        let _ = (part, h, t, dw, q, of, to);
        Ok(())
    }
}

/// The impulses h (∂L/∂q + F) + Σ ΔW ∂γ/∂q of a step, at rows of the configuration.
#[derive(Clone, Copy, Debug)]
pub enum Impulses {}

/// Bounds of the derivatives of the impulses within boxes.
///
/// A node has the middle and the half width of its box in each component. For each component the
/// sums are a lower and an upper bound of the row sums of −∂(impulse)/∂q by Gershgorin: the
/// diagonal entry minus and plus the magnitudes of the others. They are NaN where there is no
/// bound.
#[derive(Clone, Copy, Debug)]
pub enum Slopes {}

/// The loops of a system of any number of sites. Implemented by `#[variational(…)]`.
///
/// A *term* is a summand of a loop together with the conditions around it, and an *instance* of a
/// term is one execution. The nodes that an instance reads are its *slots*. A *pair* is a term with
/// one of its slots: it contributes to the impulse of the node in the slot.
pub trait Scene: Contributions<Impulses, Numbers = <Self as Scene>::Row> {
    /// The numbers of a site.
    type Row: Row;
    /// The outermost loops.
    const LOOPS: &'static [Loop];
    /// The terms of all loops.
    const TERMS: &'static [Term];
    /// The pairs of the loops that are streams, by term and slot.
    const PAIRS: &'static [Pair];
    /// The number of pairs that [`node`](Contributions::node) adds: the first ones. The other pairs
    /// belong to terms for few nodes, such as the end of a chain.
    const NODE_PAIRS: usize;
    /// True if an impulse depends on the time itself, by a derivative, a condition, a total or a
    /// rounded number.
    const READS_TIME: bool;

    /// True if the derivatives of impulses with respect to nodes are a symmetric matrix: no force
    /// depends on places, none on velocities beside friction, and there is no H₁.
    const IS_SYMMETRIC: bool = true;

    /// Visits the instances of a loop in the order in which the loop is executed.
    ///
    /// # Errors
    /// A [`Stop`] of the visitor, or an index of a field that is out of range.
    fn instances(&self, number: usize, n: usize, to: &mut Instances) -> Result<(), Stop>;

    /// The form of the kinetic energy.
    const KINETIC: KineticForm = KineticForm::Masses;

    /// Adds the mass of each component of each of `n` sites, for a kinetic energy of masses.
    ///
    /// # Errors
    /// An index that is out of range.
    fn masses(&self, n: usize, masses: &mut [Self::Row]) -> Result<(), IndexError> {
        let _ = (n, masses);
        Ok(())
    }

    /// Visits the terms of another kinetic energy.
    ///
    /// # Errors
    /// An index that is out of range.
    fn kinetic_terms(&self, n: usize, to: &mut KineticTerms) -> Result<(), IndexError> {
        let _ = (n, to);
        Ok(())
    }

    /// Adds the derivatives of a term of the kinetic energy at the velocity of its site.
    fn kinetic(&self, term: usize, columns: &[f64], v: &Self::Row, to: &mut KineticJet<Self::Row>) {
        let _ = (term, columns, v, to);
    }

    /// Adds the friction ν of each component of each of `n` sites: of the forces −ν v.
    ///
    /// # Errors
    /// An index that is out of range.
    fn frictions(&self, n: usize, frictions: &mut [Self::Row]) -> Result<(), IndexError> {
        let _ = (n, frictions);
        Ok(())
    }

    /// Visits the forces, each with its name and the number of its entries for `n` sites.
    ///
    /// # Errors
    /// An index that is out of range.
    fn forces(&self, n: usize, visit: &mut dyn FnMut(&'static str, i64)) -> Result<(), IndexError> {
        let _ = (n, visit);
        Ok(())
    }

    /// True if forces depend on velocities in another way than friction.
    const HAS_DRAGS: bool = false;

    /// True if there are noises H₁.
    const HAS_H1: bool = false;

    /// Makes a step of the midpoint rule; called for scenes that list the rule.
    ///
    /// # Errors
    /// The errors of the function `midpoint` of this module.
    fn midpoint(&self, step: MidpointStep<'_, Self::Row>) -> Result<(), StepError> {
        let _ = step;
        unreachable!("the rules of this scene are shears")
    }

    /// Returns the Lagrangian.
    ///
    /// # Errors
    /// An index that is out of range.
    fn lagrangian(&self, t: f64, q: &[Self::Row], v: &[Self::Row]) -> Result<f64, IndexError>;

    /// Returns the number of Wiener processes for `n` sites.
    ///
    /// # Errors
    /// An index that is out of range.
    fn processes(&self, n: usize) -> Result<usize, IndexError>;
}

/// Returns whether something reads velocities or momenta beside the kinetic energy and friction.
pub(crate) const fn reads_motion<S: Scene>() -> bool {
    S::HAS_DRAGS || S::HAS_H1
}

/// The functions that read velocities or momenta. Of [`Slopes`], `Kicks` and `Shifts` are bounds of
/// row sums of the magnitudes of the derivatives by places, in the first half of a row, and by
/// momenta.
#[derive(Clone, Copy, Debug)]
pub enum InDrift {
    /// The impulses of drags over the time `h`.
    Drags,
    /// The impulses −Σ ΔW ∂H₁/∂q.
    Kicks,
    /// The displacements Σ ΔW ∂H₁/∂p.
    Shifts,
}

/// An outermost loop.
#[derive(Clone, Copy, Debug)]
pub struct Loop {
    /// Its place: "the loop at line 9 of `lagrangian`".
    pub text: &'static str,
    /// False if the loop is always made as it is written: an inner bound depends on an outer
    /// counter, a condition reads the configuration, or a site stays where it is in a loop.
    pub is_stream: bool,
    /// True if its impulses read increments.
    pub has_noise: bool,
}

/// A summand of a loop.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// Number of its outermost loop.
    pub in_loop: usize,
    /// The nodes that it reads, each as it is written: "`q[i - 1]` in `lagrangian`".
    pub slots: &'static [&'static str],
    /// Number of fields that it reads with an index.
    pub columns: usize,
    /// True for a noise with a process for each instance.
    pub has_increment: bool,
}

/// A term with one of its slots.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Number of the term.
    pub term: usize,
    /// Number of the slot, whose node gets the impulse.
    pub slot: usize,
    /// The other slots that the impulse depends on.
    pub rows: &'static [usize],
    /// The columns of the term that the impulse depends on.
    pub columns: &'static [usize],
    /// True if the impulse depends on the increment of the instance.
    pub reads_increment: bool,
}
