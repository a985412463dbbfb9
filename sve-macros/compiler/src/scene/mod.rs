//! Scenes: the tree of sums → terms with their derivatives.
//!
//! Input: a [`Scene`]. Output: the sum of all loops as one flat list. A *term* is the summand of a
//! sum without its inner sums, multiplied by the weight with which the sum enters the Lagrangian or
//! the noise. The weight of a sum c of P is `ω(c) = ω(P) ∂summand(P)/∂c`, and it contains no sum.
//! So `h L + Σ γ ΔW` is the sum of all terms over all instances, and an impulse of a site is the
//! sum of the derivatives of the terms that read the site.

mod forces;
mod gather;
mod h1;
mod impulses;
mod inner;
mod kinetic;
mod share;
mod slopes;
mod streams;
mod symmetry;
mod term;
#[cfg(test)]
mod tests;
mod totals;

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Symbol};
use crate::catalogue::{Nodes, Rule};
use crate::errors::Errors;
use crate::model::Meaning;
use crate::model::scene::{Each, Int, Processes, Scene, SlotArray, SumId};
use forces::Forces;
pub(crate) use gather::{Gather, Read};
pub(crate) use inner::InnerTotals;
pub(crate) use kinetic::{Kinetic, KineticTerm};
pub(crate) use slopes::slopes;
pub(crate) use streams::{Pair, indices};
pub(crate) use symmetry::{SceneMomentum, moves_nothing};
pub(crate) use term::Term;
pub(crate) use totals::Total;

/// A scene with its derivatives.
#[derive(Clone)]
pub(crate) struct Derived {
    pub(crate) scene: Scene,
    /// The step size.
    pub(crate) step: Symbol,
    /// The outermost loops, and the functions outside of their loops.
    pub(crate) roots: Vec<Root>,
    /// The sums that enter formulas in another way than with a factor, and the derivatives with
    /// respect to them; each reads the ones before it.
    pub(crate) totals: Vec<Total>,
    /// The inner sums that enter formulas in such a way.
    pub(crate) inner: InnerTotals,
    /// The summands of the Lagrangian.
    pub(crate) lagrangian: Vec<Summand>,
    pub(crate) kinetic: Kinetic,
    /// The friction ν of the forces −ν v.
    pub(crate) frictions: Vec<Coefficient>,
    /// The terms of forces that depend on velocities in another way.
    pub(crate) drags: Vec<Term>,
    /// The terms of all H₁ in the impulses, and in the displacements.
    pub(crate) h1: [Vec<Term>; 2],
    /// The momenta of symmetries.
    pub(crate) momenta: Vec<SceneMomentum>,
    /// The terms of potentials, γ and forces.
    pub(crate) terms: Vec<Term>,
    /// The terms of streams with their sites, those of most nodes first, each as a loop over nodes
    /// computes it.
    pub(crate) pairs: Vec<(Pair, Gather)>,
    /// The number of pairs that most nodes have, and their impulses together.
    pub(crate) common: usize,
    pub(crate) node: Gather,
    /// Number of the processes of functions that return numbers or arrays, and of forces.
    pub(crate) listed: usize,
    /// The functions that return a `Vec`, component by component.
    pub(crate) each: Vec<Each>,
}

/// An outermost loop, or a function outside of its loops.
#[derive(Clone)]
pub(crate) struct Root {
    pub(crate) sum: Option<SumId>,
    /// Name of the function.
    pub(crate) function: String,
    /// True if the instances of the loop may be made ahead and executed by consecutive nodes.
    pub(crate) is_stream: bool,
}

/// A term, with the sum whose summand it is; without one it stands outside of all loops.
#[derive(Clone)]
pub(crate) struct Summand {
    pub(crate) root: usize,
    pub(crate) sum: Option<SumId>,
    pub(crate) value: Expr,
    /// Expressions that must be positive: the value is NaN elsewhere.
    pub(crate) conditions: Vec<Expr>,
}

/// A number of a component of a site, in each instance of a sum: its mass, or its friction.
#[derive(Clone)]
pub(crate) struct Coefficient {
    pub(crate) root: usize,
    pub(crate) sum: Option<SumId>,
    pub(crate) site: Int,
    pub(crate) component: usize,
    pub(crate) value: Expr,
}

impl Summand {
    fn new(root: usize, sum: Option<SumId>, value: Expr) -> Self {
        let conditions = Vec::new();
        Self {
            root,
            sum,
            value,
            conditions,
        }
    }
}

/// Returns whether the steps of a rule are equations that join all sites.
pub(crate) fn is_implicit(rule: Rule) -> bool {
    matches!(rule.nodes, Nodes::One { c } if c != 0.0 && c != 1.0)
}

/// Derives a scene.
pub(crate) fn derive(scene: Scene, arena: &mut Arena) -> syn::Result<Derived> {
    let mut errors = Errors::new();
    let read = scene.clone();
    let mut terms = Terms::new(scene, arena, &mut errors);
    let (summands, slopes) = terms.lagrangian();
    let kinetic = kinetic::kinetic(&mut terms, &summands);
    let all = summands.iter().chain(&slopes);
    let at_rest: Vec<Summand> = all.map(|s| terms.at_rest(s)).collect();
    let [noises, h1] = terms.noises();
    let Forces {
        terms: forces,
        frictions,
        drags,
    } = terms.forces();
    let momenta = terms.momenta();
    let mut list = Vec::new();
    for (summands, is_noise) in [(at_rest, false), (noises, true)] {
        let all = summands.iter().filter_map(|s| terms.term(s, is_noise));
        list.extend(all);
    }
    list.extend(forces);
    let h1 = terms.h1(&h1);
    let mut derived = Derived {
        step: terms.scene.symbols.declare(Meaning::StepSize),
        roots: terms.roots,
        totals: terms.totals,
        inner: terms.inner,
        lagrangian: summands,
        kinetic,
        frictions,
        drags,
        h1,
        momenta,
        terms: list,
        listed: terms.listed,
        each: terms.each,
        scene: terms.scene,
        pairs: Vec::new(),
        common: 0,
        node: Gather::default(),
    };
    errors.finish(())?;
    symmetry::check(&read, arena, &mut derived)?;
    derived.stabilise(arena);
    derived.compute_impulses(arena);
    derived.mark_streams(arena);
    derived.gather(arena);
    Ok(derived)
}

/// The work of a derivation.
struct Terms<'a> {
    scene: Scene,
    arena: &'a mut Arena,
    errors: &'a mut Errors,
    /// The symbols of the sums.
    sums: HashMap<Symbol, SumId>,
    roots: Vec<Root>,
    totals: Vec<Total>,
    inner: InnerTotals,
    listed: usize,
    each: Vec<Each>,
}

impl<'a> Terms<'a> {
    fn new(scene: Scene, arena: &'a mut Arena, errors: &'a mut Errors) -> Self {
        let meanings = scene.symbols.meanings().iter().enumerate();
        let sums = meanings.filter_map(|(at, meaning)| match meaning {
            Meaning::Sum(sum) => Some((Symbol(at as u32), SumId(*sum))),
            _ => None,
        });
        Self {
            sums: sums.collect(),
            scene,
            arena,
            errors,
            roots: Vec::new(),
            totals: Vec::new(),
            inner: InnerTotals::default(),
            listed: 0,
            each: Vec::new(),
        }
    }

    /// Returns the summands of the Lagrangian, and those of its totals with their weights, which
    /// have its derivatives and not its value.
    fn lagrangian(&mut self) -> (Vec<Summand>, Vec<Summand>) {
        let (mut found, mut slopes) = (Vec::new(), Vec::new());
        let value = self.scene.lagrangian;
        self.function("lagrangian", value, [&mut found, &mut slopes]);
        (found, slopes)
    }

    /// Returns the summands of all γ and of all H₁, each times its increment.
    fn noises(&mut self) -> [Vec<Summand>; 2] {
        let mut both = [Vec::new(), Vec::new()];
        for noise in self.scene.noises.clone() {
            let mut found = Vec::new();
            match noise.processes {
                Processes::Listed(gammas) => {
                    let mut products = Vec::new();
                    for gamma in gammas {
                        let increment = self.listed_increment();
                        products.push((1.0, self.arena.mul(increment, gamma)));
                    }
                    let total = self.arena.sum(0.0, &products);
                    // a noise is its derivatives: its value is not needed
                    let mut slopes = Vec::new();
                    self.function(&noise.name, total, [&mut found, &mut slopes]);
                    found.extend(slopes);
                }
                Processes::Each(sums) => {
                    let of = sums.len();
                    for (component, sum) in sums.into_iter().enumerate() {
                        let increment = Meaning::Read(self.scene.symbols.meanings().len());
                        let increment = self.scene.symbols.declare(increment);
                        self.each.push(Each {
                            increment,
                            sum,
                            component,
                            of,
                        });
                        let weight = self.arena.symbol(increment);
                        let root = self.root(Some(sum), &noise.name);
                        let mut slopes = Vec::new();
                        self.sum(root, sum, weight, [&mut found, &mut slopes]);
                        found.extend(slopes);
                    }
                }
            }
            both[usize::from(noise.is_h1)].extend(found);
        }
        both
    }

    /// Returns the increment of one more process of a function that returns numbers.
    fn listed_increment(&mut self) -> Expr {
        let increment = Meaning::Wiener(self.listed);
        self.listed += 1;
        let increment = self.scene.symbols.declare(increment);
        self.arena.symbol(increment)
    }

    /// Adds the summands of a function: those outside of its loops, and those of each loop; and
    /// those of its totals with their weights.
    fn function(&mut self, name: &str, value: Expr, [to, slopes]: [&mut Vec<Summand>; 2]) {
        let value = self.with_totals(name, value, None, slopes);
        for (sum, _) in self.sums_in(value) {
            if self.scene.is_once(&self.scene.sums[sum.0].head) {
                let summand = self.scene.sums[sum.0].summand;
                self.scene.sums[sum.0].summand = self.with_totals(name, summand, Some(sum), slopes);
            }
        }
        let one = self.arena.constant(1.0);
        let (own, inner) = self.parts(value, one);
        if self.arena.constant_value(own) != Some(0.0) {
            let (root, sum) = (self.root(None, name), None);
            to.push(Summand::new(root, sum, own));
        }
        for (sum, weight) in inner {
            let root = self.root(Some(sum), name);
            self.sum(root, sum, weight, [&mut *to, &mut *slopes]);
        }
    }

    /// Returns the sums in an expression, with their symbols.
    fn sums_in(&self, value: Expr) -> Vec<(SumId, Symbol)> {
        let symbols = self.arena.symbols_of(value);
        let mut sums: Vec<(SumId, Symbol)> = symbols
            .filter_map(|symbol| Some((*self.sums.get(&symbol)?, symbol)))
            .collect();
        sums.sort_by_key(|sum| sum.0.0);
        sums
    }

    fn root(&mut self, sum: Option<SumId>, function: &str) -> usize {
        self.roots.push(Root {
            sum,
            function: function.to_owned(),
            is_stream: false,
        });
        self.roots.len() - 1
    }

    /// Adds the summand of a sum with a weight, and those of its inner sums; to `slopes` the
    /// summands of inner totals with their weights, which have derivatives and no value.
    fn sum(&mut self, root: usize, sum: SumId, weight: Expr, [to, slopes]: [&mut Vec<Summand>; 2]) {
        let mut open = vec![(sum, weight, true)];
        while let Some((sum, weight, has_value)) = open.pop() {
            let entering = self.inner_totals(sum, weight);
            let (value, inner) = self.parts(self.scene.sums[sum.0].summand, weight);
            if self.arena.constant_value(value) != Some(0.0) {
                let to = if has_value { &mut *to } else { &mut *slopes };
                let sum = Some(sum);
                to.push(Summand::new(root, sum, value));
            }
            let inner = inner
                .into_iter()
                .map(|(sum, weight)| (sum, weight, has_value));
            let entering = entering
                .into_iter()
                .map(|(sum, weight)| (sum, weight, false));
            let all: Vec<_> = inner.chain(entering).collect();
            open.extend(all.into_iter().rev());
        }
    }

    /// Splits an expression into its part without sums, and the sums in it with their weights;
    /// both times `weight`. The expression is linear in its sums.
    fn parts(&mut self, value: Expr, weight: Expr) -> (Expr, Vec<(SumId, Expr)>) {
        let sums = self.sums_in(value);
        let zero = self.arena.constant(0.0);
        let mut inner = Vec::new();
        for &(sum, symbol) in &sums {
            let slope = self.arena.diff(value, symbol);
            inner.push((sum, self.arena.mul(weight, slope)));
        }
        let none: HashMap<Symbol, Expr> = sums.iter().map(|&(_, symbol)| (symbol, zero)).collect();
        let own = self.arena.substitute(value, &none);
        (self.arena.mul(weight, own), inner)
    }

    /// Returns the sums in a number whose factors contain sums, with their symbols.
    fn entering(&mut self, value: Expr) -> Vec<(SumId, Symbol)> {
        let sums = self.sums_in(value);
        let factors: Vec<Expr> = sums.iter().map(|s| self.arena.diff(value, s.1)).collect();
        let enters = |sum: &(SumId, Symbol)| factors.iter().any(|&f| self.arena.contains(f, sum.1));
        sums.into_iter().filter(enters).collect()
    }

    /// Returns a summand without velocities.
    fn at_rest(&mut self, summand: &Summand) -> Summand {
        let zero = self.arena.constant(0.0);
        let slots = self.slots_of(summand.value).into_iter();
        let velocities = slots.filter(|slot| matches!(slot.1, SlotArray::Velocity(_)));
        let velocities = velocities.map(|slot| (slot.0, zero)).collect();
        Summand {
            value: self.arena.substitute(summand.value, &velocities),
            ..summand.clone()
        }
    }
}
