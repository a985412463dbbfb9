//! Bounds of the derivatives of impulses, for steps whose equations join all sites.
//!
//! Input: a scene with the first derivatives of its terms. Output: the same scene with rows of the
//! middle and the half width of a box in each component, and with terms that add, in the place of
//! impulses, a lower and an upper bound of the row sums of `−∂I/∂q` over the box: the diagonal
//! entry minus and plus the magnitudes of all others (Gershgorin). The loops, the terms and the
//! pairs are those of the scene, so one table of segments serves both.
//!
//! A term under a condition on numbers counts where the condition may hold within the box, and may
//! vanish there. A rounded number is that of the middle. At a jump between two values of either, L
//! has no derivative, and nothing is bounded.

mod h1;
mod sums;

use std::collections::{BTreeSet, HashMap, HashSet};

use super::{Derived, Kinetic, Term};
use crate::algebra::intervals::{Flavour, Intervals, Range, intervals};
use crate::algebra::{Arena, Expr, Purpose, Symbol};
use crate::model::Meaning;
use crate::model::domain;
use crate::model::scene::{Comparison, Condition, Head, Int, Row, Scene, Slot, SlotArray, SumId};
use sums::{OfSum, may_vanish};

const EXPLICIT: &str =
    "use `initial_point`, `endpoint`, `stormer_verlet`, or a composition of them";

/// Returns the scene of bounds with the owner of its expressions, or the reason why there is none.
pub(crate) fn slopes(derived: &Derived, arena: &Arena) -> Result<(Derived, Arena), String> {
    if matches!(derived.kinetic, Kinetic::Sites { .. }) {
        return Err(format!(
            "`midpoint` is for scenes with the kinetic energy `0.5 * m * v[i] * v[i]` of each component, and this one has another: {EXPLICIT}"
        ));
    }
    let (mut all, mut arena) = (derived.clone(), arena.clone());
    all.scene.row = Row::Array(2 * derived.scene.row.len());
    let radii = all.declare_radii(derived.scene.row.len());
    let sums = sums::declare(&mut all.scene, derived);
    let ranges = radii.iter().map(|(&s, &radius)| (s, Range::Within(radius)));
    let of_sums = sums.iter().map(|(&s, of_sum)| (s, of_sum.range()));
    let mut bounds = Bounds {
        ranges: ranges.chain(of_sums).collect(),
        sums,
        velocities: derived.scene.velocities(),
        momenta: derived.scene.momenta(),
        arena: &mut arena,
        step: derived.step,
    };
    for sum in &mut all.scene.sums {
        if let Head::If(condition) = &sum.head {
            sum.head = Head::If(bounds.may_hold(condition, true));
        }
    }
    sums::bound(&mut all, &derived.scene, &mut bounds)
        .ok_or_else(|| no_bounds("a sum that enters formulas"))?;
    for term in all.terms.iter_mut().chain(&mut all.drags) {
        let may_vanish = may_vanish(term.sum, &derived.scene);
        let function = &derived.roots[term.root].function;
        bounds
            .bound(term, &derived.scene, may_vanish)
            .ok_or_else(|| no_bounds(&format!("`{function}`")))?;
    }
    for term in all.h1.iter_mut().flatten() {
        let function = &derived.roots[term.root].function;
        bounds
            .bound_h1(term)
            .ok_or_else(|| no_bounds(&format!("`{function}`")))?;
    }
    all.gather_pairs(&mut arena);
    Ok((all, arena))
}

fn no_bounds(place: &str) -> String {
    format!(
        "`midpoint` bounds the derivatives of impulses, and a function in {place} has no bounds: {EXPLICIT}"
    )
}

impl Derived {
    /// Returns whether the derivatives of impulses with respect to nodes are a symmetric matrix: no
    /// force depends on places, none on velocities beside friction, and there is no H₁.
    pub(crate) fn is_symmetric(&self) -> bool {
        let forces = self.scene.forces.iter();
        let forces: Vec<SumId> = forces
            .flat_map(|force| force.components.iter().flatten().copied())
            .collect();
        let is_force = |sum| {
            self.scene
                .around(sum)
                .any(|around| forces.contains(&around))
        };
        let has_in_drifts = !self.drags.is_empty() || self.h1.iter().any(|terms| !terms.is_empty());
        !has_in_drifts && !self.terms.iter().any(|term| is_force(term.sum))
    }

    /// Declares the half width of the box of each coordinate, velocity and momentum. Returns them
    /// by these.
    fn declare_radii(&mut self, size: usize) -> HashMap<Symbol, Symbol> {
        let symbols = (0..self.scene.symbols.meanings().len() as u32).map(Symbol);
        let coordinates = symbols.filter_map(|symbol| match self.scene.slot(symbol)? {
            Slot {
                array:
                    array @ (SlotArray::Configuration(_)
                    | SlotArray::Velocity(_)
                    | SlotArray::Momentum(_)),
                component,
            } => {
                let (array, component) = (array.clone(), component + size);
                Some((symbol, Slot { array, component }))
            }
            _ => None,
        });
        let coordinates: Vec<(Symbol, Slot)> = coordinates.collect();
        let declare = |(symbol, slot)| {
            self.scene.slots.push(slot);
            let meaning = Meaning::Slot(self.scene.slots.len() - 1);
            (symbol, self.scene.symbols.declare(meaning))
        };
        coordinates.into_iter().map(declare).collect()
    }
}

struct Bounds<'a> {
    /// The ranges of coordinates, velocities, momenta and sums.
    ranges: HashMap<Symbol, Range>,
    sums: HashMap<Symbol, OfSum>,
    /// The velocities, with their sites and components.
    velocities: HashMap<Symbol, (Int, usize)>,
    momenta: HashSet<Symbol>,
    arena: &'a mut Arena,
    step: Symbol,
}

impl Bounds<'_> {
    /// Replaces the impulses of a term by bounds of their derivatives. Returns `None` if a function
    /// has no bounds.
    fn bound(&mut self, term: &mut Term, scene: &Scene, may_vanish: bool) -> Option<()> {
        let sites = term.sites.iter();
        let mut all: Vec<Symbol> = sites
            .flat_map(|&site| scene.row_of(site).map(|row| row.0))
            .collect();
        let slopes = term.slopes.iter().flatten();
        let read = slopes.flat_map(|&slope| self.moving(slope));
        // sums and velocities
        let read: BTreeSet<Symbol> = read.filter(|s| !all.contains(s)).collect();
        all.extend(read);
        let mut bounds = Vec::new();
        for (&site, slopes) in term.sites.iter().zip(&term.slopes) {
            let entries = self.entries(slopes, &all, term.is_noise);
            let Intervals {
                middle,
                radii,
                conditions,
            } = self.intervals(entries)?;
            let rows = middle.chunks(all.len()).zip(radii.chunks(all.len()));
            let (mut lower, mut upper) = (Vec::new(), Vec::new());
            for (component, (middle, radii)) in rows.enumerate() {
                let mut own: Vec<Symbol> = Vec::new();
                own.extend(scene.row_of(site).find(|c| c.1 == component).map(|c| c.0));
                let velocity = self.velocities.iter();
                let velocity = velocity.filter(|(_, at)| **at == (site, component));
                own.extend(velocity.map(|velocity| *velocity.0));
                let [mut low, mut high] = self.row(&all, &own, middle, radii);
                if may_vanish {
                    [low, high] = [self.half(low, -0.5), self.half(high, 0.5)];
                }
                lower.push(low);
                upper.push(high);
            }
            lower.extend(upper);
            bounds.push(lower);
            term.conditions.push(conditions);
        }
        term.gradient.clone_from(&bounds);
        term.impulses = bounds;
        // the step size is a factor already
        term.is_noise = true;
        Some(())
    }

    /// Returns −∂I/∂q, a row for each component of a site. For a velocity v = 2 (m − q₀)/h, the
    /// derivative with respect to its node m.
    fn entries(&mut self, slopes: &[Expr], all: &[Symbol], is_noise: bool) -> Vec<Expr> {
        let step = self.arena.symbol(self.step);
        let mut entries = Vec::new();
        for &slope in slopes {
            for &symbol in all {
                let entry = self.arena.diff(slope, symbol);
                let entry = self.arena.neg(entry);
                // the value of a noise has its increment as a factor
                entries.push(if is_noise {
                    entry
                } else if self.velocities.contains_key(&symbol) {
                    self.arena.scale(2.0, entry)
                } else {
                    self.arena.mul(step, entry)
                });
            }
        }
        entries
    }

    fn intervals(&mut self, mut entries: Vec<Expr>) -> Option<Intervals> {
        let domain = domain::conditions(&entries, self.arena);
        let mut borders: Vec<Expr> = domain.iter().map(|condition| condition.value).collect();
        let stable = entries.iter_mut().chain(&mut borders).collect();
        self.arena.stabilise(Purpose::Step, stable);
        intervals(&entries, &borders, &self.ranges, Flavour::Box, self.arena)
    }

    /// Returns the bounds of a row sum. In a shorter step velocities keep more of their part than
    /// places: what places add to a force of velocities never makes the bounds narrower.
    fn row(
        &mut self,
        all: &[Symbol],
        own: &[Symbol],
        middle: &[Expr],
        radii: &[Expr],
    ) -> [Expr; 2] {
        let entries = all.iter().zip(middle.iter().zip(radii));
        let entries = entries.map(|(&symbol, (&middle, &radius))| (symbol, [middle, radius]));
        let (of_velocities, of_places): (Vec<_>, Vec<_>) =
            entries.partition(|entry| self.velocities.contains_key(&entry.0));
        let places = self.sum_of_row(&of_places, own);
        if of_velocities.is_empty() {
            return places;
        }
        let [low, high] = self.sum_of_row(&of_velocities, own);
        let [below, above] = [self.half(places[0], -0.5), self.half(places[1], 0.5)];
        [self.arena.add(low, below), self.arena.add(high, above)]
    }

    /// Returns the entries of the coordinate `own`, minus and plus the magnitudes of the others,
    /// and of what sums add.
    fn sum_of_row(&mut self, entries: &[(Symbol, [Expr; 2])], own: &[Symbol]) -> [Expr; 2] {
        let (mut centre, mut width) = (Vec::new(), Vec::new());
        for &(symbol, [middle, radius]) in entries {
            width.push((1.0, self.times_slope(radius, symbol)));
            if own.contains(&symbol) {
                centre.push((1.0, middle));
            } else {
                let middle = self.arena.abs(middle);
                width.push((1.0, self.times_slope(middle, symbol)));
            }
        }
        let [centre, width] = [centre, width].map(|sum| self.arena.sum(0.0, &sum));
        [self.arena.sub(centre, width), self.arena.add(centre, width)]
    }

    /// Returns the smaller of a number and 0 for the sign −½, and the larger one for ½.
    fn half(&mut self, number: Expr, sign: f64) -> Expr {
        let size = self.arena.abs(number);
        self.arena.sum(0.0, &[(0.5, number), (sign, size)])
    }

    /// Returns a condition that is true if `condition`, or its negation, holds somewhere in the
    /// box.
    fn may_hold(&mut self, condition: &Condition, is_wanted: bool) -> Condition {
        let mut both = |a: &Condition, b: &Condition| {
            [a, b].map(|part| Box::new(self.may_hold(part, is_wanted)))
        };
        match condition {
            Condition::Integers(..) if is_wanted => condition.clone(),
            Condition::Integers(..) => Condition::Not(Box::new(condition.clone())),
            Condition::Not(inner) => self.may_hold(inner, !is_wanted),
            Condition::And(a, b) | Condition::Or(a, b) => {
                let [a_may, b_may] = both(a, b);
                match (condition, is_wanted) {
                    (Condition::And(..), true) | (Condition::Or(..), false) => {
                        Condition::And(a_may, b_may)
                    }
                    _ => Condition::Or(a_may, b_may),
                }
            }
            &Condition::Numbers(comparison, a, b) => {
                let difference = self.arena.sub(a, b);
                let bounds = intervals(&[difference], &[], &self.ranges, Flavour::Box, self.arena);
                let bounds = bounds.filter(|bounds| bounds.conditions.is_empty());
                let zero = self.arena.constant(0.0);
                let Some(Intervals { middle, radii, .. }) = bounds else {
                    return Condition::Numbers(Comparison::Equal, zero, zero);
                };
                let [lower, upper] = [
                    self.arena.sub(middle[0], radii[0]),
                    self.arena.add(middle[0], radii[0]),
                ];
                let is_below = Condition::Numbers(Comparison::LessOrEqual, lower, zero);
                let is_above = Condition::Numbers(Comparison::LessOrEqual, zero, upper);
                match (comparison, is_wanted) {
                    (Comparison::Equal, true) => {
                        Condition::And(Box::new(is_below), Box::new(is_above))
                    }
                    (Comparison::Equal, false) => Condition::Numbers(Comparison::Equal, zero, zero),
                    (Comparison::Less | Comparison::LessOrEqual, true) => is_below,
                    (Comparison::Less | Comparison::LessOrEqual, false) => is_above,
                }
            }
        }
    }
}
