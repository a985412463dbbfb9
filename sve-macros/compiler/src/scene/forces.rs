//! Forces of a scene: what they add to the impulses of their sites, and friction.
//!
//! A force `f − ν v` on a site has a part without velocities, which a kick adds, and a friction of
//! each component, which acts while the site moves: the velocity is that of the drift.

use super::kinetic::numbers;
use super::{Coefficient, Summand, Term, Terms};
use crate::algebra::{Expr, Symbol};
use crate::model::scene::{Head, Int, SiteField, SlotArray, SumId};

const WORKS: &str = "forces of scenes depend on velocities by a friction `-nu * v[i]` of each component of their site alone, with constants that may differ from site to site";

impl Terms<'_> {
    /// Returns the terms of all forces, and the friction of the components of sites.
    pub(super) fn forces(&mut self) -> (Vec<Term>, Vec<Coefficient>) {
        let (mut all, mut frictions) = (Vec::new(), Vec::new());
        for SiteField {
            name, components, ..
        } in self.scene.forces.clone()
        {
            for (component, sum) in components.into_iter().enumerate() {
                let Some((sum, site)) = sum.and_then(|sum| Some((sum, self.scene.site_of(sum)?)))
                else {
                    continue;
                };
                let root = self.root(Some(sum), &name);
                let (mut summands, one) = (Vec::new(), self.arena.constant(1.0));
                // a force is its value: it has no derivatives
                self.sum(root, sum, one, [&mut summands, &mut Vec::new()]);
                for summand in summands {
                    frictions.extend(self.friction(&summand, site, component));
                    let at_rest = self.at_rest(&summand);
                    all.extend(self.force_term(&at_rest, site, component));
                }
            }
        }
        (all, frictions)
    }

    /// Returns the friction in a summand, if there is one.
    fn friction(&mut self, summand: &Summand, site: Int, component: usize) -> Option<Coefficient> {
        let Summand { root, sum, value } = *summand;
        let velocities: Vec<(Symbol, bool)> = self
            .slots_of(value)
            .into_iter()
            .filter_map(|(symbol, array, of)| match array {
                SlotArray::Velocity(at) => Some((symbol, *at == site && of == component)),
                _ => None,
            })
            .collect();
        let (own, is_own) = *velocities.iter().min_by_key(|velocity| velocity.1)?;
        let slope = self.arena.diff(value, own);
        let text = self.text(own);
        let mistake = if is_own {
            let varies = self.varies(sum, slope);
            varies.map(|read| {
                format!("the friction of the velocity `{text}` depends on {read}: {WORKS}")
            })
        } else {
            Some(format!(
                "this force depends on the velocity `{text}`, which is not that of its own component: {WORKS}"
            ))
        };
        if let Some(mistake) = mistake {
            let at = self.place(sum);
            self.errors.push(at, mistake);
            return None;
        }
        let value = self.arena.scale(-1.0, slope);
        Some(Coefficient {
            root,
            sum,
            site,
            component,
            value,
        })
    }

    /// Returns the name of a time, coordinate or velocity that a number or a condition around it
    /// depends on.
    pub(super) fn varies(&mut self, sum: Option<SumId>, number: Expr) -> Option<String> {
        let conditions = self.scene.heads(sum).filter_map(|head| match head {
            Head::If(condition) => Some(numbers(condition)),
            Head::For { .. } => None,
        });
        let read: Vec<Expr> = conditions.flatten().chain([number]).collect();
        read.into_iter().find_map(|expr| {
            if self.arena.contains(expr, self.scene.time) {
                return Some("`t`".to_owned());
            }
            let slots = self.slots_of(expr);
            let found = slots.iter().find(|slot| slot.1.moves())?;
            let text = self.text(found.0);
            Some(if found.1.is_computed() {
                text
            } else {
                format!("`{text}`")
            })
        })
    }

    /// Returns the term of a component of a force; `None` if the force is zero.
    fn force_term(&mut self, summand: &Summand, site: Int, component: usize) -> Option<Term> {
        let Summand { root, sum, value } = *summand;
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
