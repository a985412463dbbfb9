//! The kinetic energy of a scene: a function of the velocities of each site, with numbers that do
//! not depend on the motion.
//!
//! The terms `½ m v²` of single components are masses. If there is any other term, such as one of
//! two components or `−m c² √(1 − v²/c²)`, the derivatives of all terms are kept: the velocity of a
//! site is then solved for.

use std::collections::HashMap;

use proc_macro2::Span;

use super::{Coefficient, Summand, Terms};
use crate::algebra::{Expr, Symbol};
use crate::model::domain;
use crate::model::scene::{Int, SlotArray, SumId};

/// The kinetic energy of all sites.
#[derive(Clone)]
pub(crate) enum Kinetic {
    /// `½ m v²` of each component.
    Masses(Vec<Coefficient>),
    /// Other functions of the velocities of a site.
    Sites {
        terms: Vec<KineticTerm>,
        /// True if the momenta are affine in the velocities.
        is_affine: bool,
    },
}

impl Kinetic {
    /// Returns the derivatives of all terms, except for masses.
    pub(super) fn derivatives_mut(&mut self) -> impl Iterator<Item = &mut Expr> {
        let terms = match self {
            Self::Masses(_) => &mut [],
            Self::Sites { terms, .. } => terms.as_mut_slice(),
        };
        terms.iter_mut().flat_map(|term| {
            term.momenta
                .iter_mut()
                .chain(term.masses.iter_mut().flatten())
        })
    }
}

/// A term of the kinetic energy of a site.
#[derive(Clone)]
pub(crate) struct KineticTerm {
    pub(crate) root: usize,
    pub(crate) sum: Option<SumId>,
    pub(crate) site: Int,
    /// The velocities that it reads, with their components.
    pub(crate) velocities: Vec<(Symbol, usize)>,
    /// The fields and integers that its derivatives read.
    pub(crate) columns: Vec<Symbol>,
    /// The derivative by each of the velocities.
    pub(crate) momenta: Vec<Expr>,
    /// The second derivatives by each of the velocities.
    pub(crate) masses: Vec<Vec<Expr>>,
    /// Numbers that are positive where the term is defined.
    pub(crate) conditions: Vec<Expr>,
}

/// Returns the kinetic energy. Velocities that occur in another way are mistakes.
pub(super) fn kinetic(terms: &mut Terms<'_>, summands: &[Summand]) -> Kinetic {
    for sum in 0..terms.scene.sums.len() {
        terms.check_condition(SumId(sum));
    }
    let mut found = Vec::new();
    for summand in summands {
        found.extend(terms.kinetic_terms(summand));
    }
    if found.is_empty() && terms.errors.count() == 0 {
        let message = "this Lagrangian has no kinetic energy: a loop over sites needs terms `0.5 * m * v[i] * v[i]`";
        terms.errors.push(Span::call_site(), message);
    }
    let masses: Option<Vec<_>> = found.iter().map(|term| terms.masses_of(term)).collect();
    match masses {
        Some(masses) => Kinetic::Masses(masses.into_iter().flatten().collect()),
        None => Kinetic::Sites {
            is_affine: found.iter().all(|term| terms.is_affine(term)),
            terms: found,
        },
    }
}

const WORKS: &str = "a term of the kinetic energy of a kept loop reads the velocities of one site, and fields and constants, as in `0.5 * self.m[i] * v[i] * v[i]`";

impl Terms<'_> {
    /// Checks that the condition of a sum does not read velocities.
    fn check_condition(&mut self, sum: SumId) {
        let sum = &self.scene.sums[sum.0];
        let reads_velocity = sum.head.numbers().into_iter().any(|number| {
            let slots = self.slots_of(number);
            slots.iter().any(|s| matches!(s.1, SlotArray::Velocity(_)))
        });
        let (at, numbers) = (sum.at, sum.head.numbers());
        if reads_velocity {
            let message = format!("this condition depends on a velocity: {WORKS}");
            self.errors.push(at, message);
        }
        if let Some(input) = numbers.into_iter().find_map(|number| self.input_in(number)) {
            let message = format!(
                "this condition depends on the input `{input}`: a condition of a kept loop reads fields and places; an input that is 0 or 1 may multiply the term"
            );
            self.errors.push(at, message);
        }
    }

    /// Returns the terms in a summand, one for each site.
    fn kinetic_terms(&mut self, summand: &Summand) -> Vec<KineticTerm> {
        let velocities: Vec<(Symbol, Int, usize)> = self
            .slots_of(summand.value)
            .into_iter()
            .filter_map(|(symbol, array, component)| match array {
                SlotArray::Velocity(site) => Some((symbol, *site, component)),
                _ => None,
            })
            .collect();
        let mut sites: Vec<Int> = Vec::new();
        for &(_, site, _) in &velocities {
            if !sites.contains(&site) {
                sites.push(site);
            }
        }
        let mut terms = Vec::new();
        for site in sites {
            match self.kinetic_term(summand, &velocities, site) {
                Ok(term) => terms.extend(term),
                Err(mistake) => {
                    self.errors.push(self.place(summand.sum), mistake);
                    return Vec::new();
                }
            }
        }
        terms
    }

    /// Returns the term of a site in a summand with these velocities; nothing if the summand does
    /// not depend on them.
    fn kinetic_term(
        &mut self,
        summand: &Summand,
        velocities: &[(Symbol, Int, usize)],
        site: Int,
    ) -> Result<Option<KineticTerm>, String> {
        let zero = self.arena.constant(0.0);
        let velocities = velocities.iter().copied();
        let (own, others): (Vec<_>, Vec<_>) = velocities.partition(|v| v.1 == site);
        let without: HashMap<Symbol, Expr> = others.iter().map(|v| (v.0, zero)).collect();
        let of_site: Vec<Symbol> = own.iter().map(|v| v.0).collect();
        let (mut momenta, mut masses) = (Vec::new(), Vec::new());
        for &(symbol, ..) in &own {
            let momentum = self.arena.diff(summand.value, symbol);
            let second = others.iter().find(|other| {
                let mixed = self.arena.diff(momentum, other.0);
                !self.arena.is_zero(mixed)
            });
            if let Some(&(second, ..)) = second {
                let [first, second] =
                    [symbol.min(second), symbol.max(second)].map(|v| self.text(v));
                return Err(format!(
                    "the velocities `{first}` and `{second}` of two sites occur in one term: {WORKS}"
                ));
            }
            let momentum = self.arena.substitute(momentum, &without);
            if let Some(read) = self.varies(summand.sum, momentum, &of_site) {
                let text = self.text(symbol);
                return Err(format!(
                    "the derivative of the Lagrangian by the velocity `{text}` depends on {read}: {WORKS}"
                ));
            }
            momenta.push(momentum);
            let of = own.iter().map(|v| self.arena.diff(momentum, v.0));
            masses.push(of.collect::<Vec<Expr>>());
        }
        if self
            .arena
            .zeros(&momenta)
            .into_iter()
            .all(|is_zero| is_zero)
        {
            return Ok(None);
        }
        let all: Vec<Expr> = domain::conditions(&[summand.value], self.arena)
            .into_iter()
            .map(|condition| condition.value)
            .filter(|&value| own.iter().any(|v| self.arena.contains(value, v.0)))
            .collect();
        let conditions = self.arena.substitute_all(&all, &without);
        let read = momenta.iter().chain(masses.iter().flatten());
        let read: Vec<Expr> = read.chain(&conditions).copied().collect();
        Ok(Some(KineticTerm {
            root: summand.root,
            sum: summand.sum,
            site,
            velocities: own.iter().map(|v| (v.0, v.2)).collect(),
            columns: self.columns_of(&read),
            momenta,
            masses,
            conditions,
        }))
    }

    /// Returns the masses of the components, if the term is a sum of `½ m v²` of them.
    fn masses_of(&mut self, term: &KineticTerm) -> Option<Vec<Coefficient>> {
        let zero = self.arena.constant(0.0);
        let at_rest: HashMap<Symbol, Expr> = term.velocities.iter().map(|v| (v.0, zero)).collect();
        let mut rest: Vec<Expr> = self.arena.substitute_all(&term.momenta, &at_rest);
        let mut masses = Vec::new();
        for (row, &(symbol, component)) in term.velocities.iter().enumerate() {
            let slopes = &term.masses[row];
            let off_diagonal = slopes.iter().enumerate().filter(|slope| slope.0 != row);
            rest.extend(off_diagonal.map(|slope| *slope.1));
            rest.push(self.arena.diff(slopes[row], symbol));
            masses.push(Coefficient {
                root: term.root,
                sum: term.sum,
                site: term.site,
                component,
                value: self.arena.substitute(slopes[row], &at_rest),
            });
        }
        let is_diagonal = self.arena.zeros(&rest).into_iter().all(|is_zero| is_zero);
        is_diagonal.then_some(masses)
    }

    /// Returns whether the momenta of a term are affine in its velocities.
    fn is_affine(&mut self, term: &KineticTerm) -> bool {
        let mut slopes = Vec::new();
        for &mass in term.masses.iter().flatten() {
            slopes.extend(term.velocities.iter().map(|v| self.arena.diff(mass, v.0)));
        }
        self.arena.zeros(&slopes).into_iter().all(|is_zero| is_zero)
    }

    /// Returns a slot as the source may spell it.
    pub(super) fn text(&self, symbol: Symbol) -> String {
        let Some(slot) = self.scene.slot(symbol) else {
            return self.scene.symbols.name(symbol);
        };
        let component = match self.scene.row.len() {
            1 => String::new(),
            _ => format!("[{}]", slot.component),
        };
        format!("{}{component}", self.scene.text(slot))
    }

    /// Returns the place of a sum.
    pub(super) fn place(&self, sum: Option<SumId>) -> Span {
        sum.map_or_else(Span::call_site, |sum| self.scene.sums[sum.0].at)
    }
}
