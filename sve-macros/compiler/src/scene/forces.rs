//! Forces of a scene: what they add to the impulses of their sites, friction, and drags.
//!
//! A force on a site has three parts. One without velocities is added by a kick. A friction `−ν v`
//! of a component by its own velocity acts while the site moves: the velocity is that of the drift.
//! Any other function of velocities, of any site, is a drag: it acts with the velocities of the
//! drift too, which before the drift are the solution of equations of all sites.

use proc_macro2::Span;

use super::{Coefficient, Summand, Term, Terms};
use crate::algebra::{Expr, Node, Symbol};
use crate::model::Meaning;
use crate::model::scene::{Head, Int, SiteField, SlotArray, SumId};

/// The parts of all forces.
pub(super) struct Forces {
    pub(super) terms: Vec<Term>,
    pub(super) frictions: Vec<Coefficient>,
    pub(super) drags: Vec<Term>,
}

impl Terms<'_> {
    /// Returns the parts of all forces.
    pub(super) fn forces(&mut self) -> Forces {
        let mut all = Forces {
            terms: Vec::new(),
            frictions: Vec::new(),
            drags: Vec::new(),
        };
        for SiteField {
            name,
            at,
            is_noise,
            components,
        } in self.scene.forces.clone()
        {
            let increment = is_noise.then(|| self.listed_increment());
            for (component, sum) in components.into_iter().enumerate() {
                let Some((sum, site)) = sum.and_then(|sum| Some((sum, self.scene.site_of(sum)?)))
                else {
                    continue;
                };
                let root = self.root(Some(sum), &name);
                let weight = increment.unwrap_or_else(|| self.arena.constant(1.0));
                let mut summands = Vec::new();
                // a force is its value: it has no derivatives
                self.sum(root, sum, weight, [&mut summands, &mut Vec::new()]);
                if is_noise {
                    self.check_noise(&name, at, &summands);
                    let terms = summands.iter();
                    let terms = terms.map(|summand| self.force_term(summand, site, component));
                    all.terms
                        .extend(terms.flatten().map(|term| Term { is_noise, ..term }));
                    continue;
                }
                for mut summand in summands {
                    all.frictions
                        .extend(self.friction(&mut summand, site, component));
                    let [at_rest, drag] = self.by_velocities(&summand);
                    all.terms.extend(self.force_term(&at_rest, site, component));
                    all.drags.extend(self.force_term(&drag, site, component));
                }
            }
        }
        all
    }

    /// Reports a force of a noise that reads velocities.
    fn check_noise(&mut self, name: &str, at: Span, summands: &[Summand]) {
        let mut values = summands.iter().map(|summand| summand.value);
        let is_velocity = |array: &SlotArray| matches!(array, SlotArray::Velocity(_));
        if values.any(|value| self.slots_of(value).iter().any(|slot| is_velocity(slot.1))) {
            let message = format!(
                "the noise force `{name}` reads velocities, which those of scenes, systems whose coordinates are slices, do not: make it a function of `t` and `q`"
            );
            self.errors.push(at, message);
        }
    }

    /// Takes the friction out of a summand, if there is one.
    fn friction(
        &mut self,
        summand: &mut Summand,
        site: Int,
        component: usize,
    ) -> Option<Coefficient> {
        let Summand {
            root, sum, value, ..
        } = *summand;
        let is_own = |array: &SlotArray, of| {
            matches!(array, SlotArray::Velocity(at) if *at == site) && of == component
        };
        let slots = self.slots_of(value).into_iter();
        let mut own = slots.filter(|slot| is_own(slot.1, slot.2)).map(|s| s.0);
        let own = own.next()?;
        let slope = self.arena.diff(value, own);
        if self.varies(sum, slope, &[]).is_some() {
            return None;
        }
        let rest = [(own, self.arena.constant(0.0))].into_iter().collect();
        summand.value = self.arena.substitute(value, &rest);
        let value = self.arena.scale(-1.0, slope);
        Some(Coefficient {
            root,
            sum,
            site,
            component,
            value,
        })
    }

    /// Splits a summand into its terms without velocities and those with velocities.
    fn by_velocities(&mut self, summand: &Summand) -> [Summand; 2] {
        let (constant, terms) = match self.arena.node(summand.value) {
            Node::Sum(constant, terms) => (constant.get(), terms.clone()),
            _ => (0.0, vec![(summand.value, crate::algebra::Bits::new(1.0))]),
        };
        let terms: Vec<(f64, Expr)> = terms.iter().map(|&(e, c)| (c.get(), e)).collect();
        let (with, without): (Vec<_>, Vec<_>) = terms.into_iter().partition(|&(_, term)| {
            let slots = self.slots_of(term);
            slots.iter().any(|s| matches!(s.1, SlotArray::Velocity(_)))
        });
        [(constant, without), (0.0, with)].map(|(constant, terms)| Summand {
            value: self.arena.sum(constant, &terms),
            ..summand.clone()
        })
    }

    /// Returns the name of a time, input, coordinate or velocity that a number or a condition
    /// around it depends on, beside some slots.
    pub(super) fn varies(
        &mut self,
        sum: Option<SumId>,
        number: Expr,
        beside: &[Symbol],
    ) -> Option<String> {
        let conditions = self.scene.heads(sum).flat_map(Head::numbers);
        let read: Vec<Expr> = conditions.chain([number]).collect();
        read.into_iter().find_map(|expr| {
            if self.arena.contains(expr, self.scene.time) {
                return Some("`t`".to_owned());
            }
            if let Some(input) = self.input_in(expr) {
                return Some(format!("`{input}`"));
            }
            let slots = self.slots_of(expr);
            let mut slots = slots.iter().filter(|slot| !beside.contains(&slot.0));
            let found = slots.find(|slot| slot.1.moves())?;
            let text = self.text(found.0);
            Some(if found.1.is_computed() {
                text
            } else {
                format!("`{text}`")
            })
        })
    }

    /// Returns the name of an input that a number depends on, also through the value of a sum.
    pub(super) fn input_in(&self, number: Expr) -> Option<String> {
        let symbols = &self.scene.symbols;
        let mut read = self.arena.symbols_of(number);
        read.find_map(|symbol| match *symbols.meaning(symbol) {
            Meaning::Parameter { input: Some(_), .. } => Some(symbols.source(symbol)),
            Meaning::Sum(sum) => self.input_in(self.scene.sums[sum].summand),
            _ => None,
        })
    }

    /// Returns the term of a component of a force; `None` if the force is zero.
    fn force_term(&mut self, summand: &Summand, site: Int, component: usize) -> Option<Term> {
        let Summand {
            root, sum, value, ..
        } = *summand;
        if self.arena.is_zero(value) {
            return None;
        }
        let mut sites = vec![site];
        for (_, array, _) in self.slots_of(value) {
            if let SlotArray::Configuration(other) = array
                && !sites.contains(other)
            {
                sites.push(*other);
            }
        }
        let zero = self.arena.constant(0.0);
        let mut gradient = vec![vec![zero; self.scene.row.len()]; sites.len()];
        gradient[0][component] = value;
        Some(Term {
            root,
            sum,
            is_noise: false,
            sites,
            columns: self.columns_of(&[value]),
            slopes: Vec::new(),
            conditions: Vec::new(),
            impulses: Vec::new(),
            gradient,
            increment: None,
        })
    }
}
