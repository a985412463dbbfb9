//! Symmetries of a scene: the test that its functions are invariant, and the momenta ⟨p, ξ⟩.
//!
//! Input: the tree of sums with the generators ξ, which are functions of the own site. Output: the
//! momenta, or an error that names each term which is not invariant. The kinetic energy ½ Σ m v² is
//! invariant only if ξ is affine in q and does not depend on time, so all steps conserve the
//! momenta. With another kinetic energy or an H₁, ξ of another form is an error.
//!
//! The test is made in copies of the scene and the arena, so that steps do not depend on it.

mod change;

use change::{Along, Change, Frame};
use proc_macro2::Span;

use super::{Derived, Kinetic, Summand, Terms};
use crate::algebra::{Arena, Expr, Notation, Symbol, Vanishing};
use crate::errors::Errors;
use crate::model::scene::{
    Processes, Scene, SceneNames, SceneNoise, SiteField, Slot, SlotArray, SumId,
};

/// A momentum that a symmetry conserves.
#[derive(Clone)]
pub(crate) struct SceneMomentum {
    /// Source name of the symmetry.
    pub(crate) name: String,
    /// The sum over the entries of the generator, for each component that is not zero.
    pub(crate) sums: Vec<SumId>,
    /// The terms of ⟨p, ξ⟩.
    pub(crate) summands: Vec<Summand>,
    /// The evidence of the invariance along ξ.
    pub(crate) evidence: Vanishing,
}

/// Largest number of characters of a formula in a message.
const READABLE: usize = 160;

/// A term that changes along a generator, with its sum and the rate of the change.
struct Broken {
    sum: Option<SumId>,
    term: Expr,
    rate: Expr,
}

/// A function that has to be invariant, with the sum whose summand it is.
type Invariant = (String, Expr, Option<SumId>);

/// Checks the symmetries of a scene, and adds the evidence to their momenta.
pub(super) fn check(scene: &Scene, arena: &Arena, derived: &mut Derived) -> syn::Result<()> {
    let mut errors = Errors::new();
    let has_masses = matches!(derived.kinetic, Kinetic::Masses(_));
    let is_explicit = has_masses && derived.h1.iter().all(Vec::is_empty);
    for (symmetry, momentum) in scene.symmetries.iter().zip(&mut derived.momenta) {
        let mut change = Change::new(scene.clone(), arena.clone(), symmetry);
        if symmetry.components.iter().all(Option::is_none) {
            errors.push(symmetry.at, moves_nothing(&symmetry.name));
        } else if let Some((at, mistake)) = change.nonlocal(symmetry) {
            errors.push(at, mistake);
        } else if !is_explicit && !change.is_affine(symmetry) {
            let message = format!(
                "the generator `{}` depends on time, or is not affine in the coordinates of its site: with `#[h1]`, or a kinetic energy that is no sum of `0.5 * m * v[i] * v[i]`, steps conserve the momenta of affine generators alone, such as translations and rotations",
                symmetry.name
            );
            errors.push(symmetry.at, message);
        } else {
            change.check_functions(symmetry, &mut errors);
            change.check_work(symmetry, &mut errors);
            momentum.evidence = change.evidence;
        }
    }
    errors.finish(())
}

/// Returns the message for a generator that is zero.
pub(crate) fn moves_nothing(name: &str) -> String {
    format!(
        "the symmetry `{name}` moves nothing: return the velocity of each coordinate along it, such as `[-q[1], q[0]]` for a rotation"
    )
}

/// Returns the Lagrangian and the noises, each with its name in messages.
fn functions(scene: &Scene) -> Vec<Invariant> {
    let mut functions = vec![("the Lagrangian".to_owned(), scene.lagrangian, None)];
    for SceneNoise {
        name, processes, ..
    } in &scene.noises
    {
        let all: Vec<(Expr, Option<SumId>)> = match processes {
            Processes::Listed(list) => list.iter().map(|&gamma| (gamma, None)).collect(),
            Processes::Each(sums) => {
                let summand = |&sum: &SumId| (scene.sums[sum.0].summand, Some(sum));
                sums.iter().map(summand).collect()
            }
        };
        let names = (0..).map(|at| match all.len() {
            1 => format!("the noise `{name}`"),
            _ => format!("the noise `{name}[{at}]`"),
        });
        let named = names.zip(&all);
        functions.extend(named.map(|(name, &(gamma, sum))| (name, gamma, sum)));
    }
    functions
}

fn at_rate(rate: Option<String>) -> String {
    rate.map(|rate| format!(" at the rate {rate}"))
        .unwrap_or_default()
}

impl Terms<'_> {
    /// Returns the momenta of the symmetries.
    pub(super) fn momenta(&mut self) -> Vec<SceneMomentum> {
        let symmetries = self.scene.symmetries.clone().into_iter();
        let momenta = symmetries.map(|symmetry| {
            let (mut summands, mut sums) = (Vec::new(), Vec::new());
            for (component, sum) in symmetry.components.into_iter().enumerate() {
                let Some((sum, site)) = sum.and_then(|sum| Some((sum, self.scene.site_of(sum)?)))
                else {
                    continue;
                };
                let array = SlotArray::Momentum(site);
                let p = self.slot(Slot { array, component });
                let p = self.arena.symbol(p);
                // a momentum is its value: it has no derivatives
                self.sum(0, sum, p, [&mut summands, &mut Vec::new()]);
                sums.push(sum);
            }
            SceneMomentum {
                name: symmetry.name,
                sums,
                summands,
                evidence: Vanishing::Proved,
            }
        });
        momenta.collect()
    }
}

impl Change {
    /// Returns the mistake of a generator that reads more than its own site, with its place.
    fn nonlocal(&mut self, symmetry: &SiteField) -> Option<(Span, String)> {
        let name = &symmetry.name;
        for &root in symmetry.components.iter().flatten() {
            let own = SlotArray::Configuration(self.scene.site_of(root)?);
            let sums = self.scene.sums.iter().enumerate();
            let within = sums.filter(|(at, _)| self.is_within(SumId(*at), root));
            for (_, sum) in within {
                let conditions = sum.head.numbers().into_iter();
                let mut reads = conditions.flat_map(|e| self.arena.symbols_of(e));
                if let Some(read) =
                    reads.find(|&read| self.is_moving(read) || read == self.scene.time)
                {
                    return Some((
                        sum.at,
                        format!(
                            "this condition of the generator `{name}` depends on `{}`: conditions of generators are of indices and fields",
                            self.names().symbol(read)
                        ),
                    ));
                }
                let is_other =
                    |&read: &Symbol| self.scene.slot(read).is_none_or(|slot| slot.array != own);
                let mut reads = self.arena.symbols_of(sum.summand);
                if let Some(read) = reads.find(|read| self.is_moving(*read) && is_other(read)) {
                    return Some((
                        sum.at,
                        format!(
                            "the generator `{name}` reads `{}`: an entry depends on its own site alone, as in `q.iter().map(|q| …).collect()`",
                            self.names().symbol(read)
                        ),
                    ));
                }
            }
        }
        None
    }

    fn is_within(&self, sum: SumId, root: SumId) -> bool {
        let mut around = self.scene.around(Some(sum));
        around.any(|around| around == root)
    }

    /// Returns whether a read may differ from step to step.
    fn is_moving(&self, read: Symbol) -> bool {
        self.scene.slot(read).is_some_and(|slot| slot.array.moves())
    }

    /// Returns whether a generator that reads its own site is affine in it and does not depend on
    /// time.
    fn is_affine(&mut self, symmetry: &SiteField) -> bool {
        let roots = symmetry.components.iter().flatten();
        let sums = (self.scene.sums.iter().enumerate())
            .filter(|(at, _)| roots.clone().any(|&root| self.is_within(SumId(*at), root)));
        let summands: Vec<Expr> = sums.map(|(_, sum)| sum.summand).collect();
        summands.into_iter().all(|summand| {
            let reads: Vec<Symbol> = self.arena.symbols_of(summand).collect();
            let varies = |&read: &Symbol| self.is_moving(read) || self.sum_of(read).is_some();
            let variables: Vec<Symbol> = reads.iter().copied().filter(varies).collect();
            let mut seconds = Vec::new();
            for &first in &variables {
                let slope = self.arena.diff(summand, first);
                seconds.extend(variables.iter().map(|&v| self.arena.diff(slope, v)));
            }
            let zeros = self.arena.zeros(&seconds);
            !reads.contains(&self.scene.time) && zeros.into_iter().all(|is_zero| is_zero)
        })
    }

    /// Checks that the Lagrangian and the noises are invariant.
    fn check_functions(&mut self, symmetry: &SiteField, errors: &mut Errors) {
        for (whose, value, sum) in functions(&self.scene) {
            let rate = self.of(value, &Frame::default(), Along::Generator);
            if self.vanishes(rate) {
                continue;
            }
            let one = self.arena.constant(1.0);
            let mut broken = Vec::new();
            self.broken(value, one, sum, &mut broken);
            if broken.is_empty() {
                let term = value;
                broken.push(Broken { sum, term, rate });
            }
            for Broken { sum, term, rate } in broken {
                let [term, rate] = [term, rate].map(|number| self.text(number));
                let message = format!(
                    "`{}` is not a symmetry of each term of {whose}: {}{} changes along it{}; correct the generator, or remove `#[symmetry]`",
                    symmetry.name,
                    term.unwrap_or_else(|| "a term".to_owned()),
                    self.loops(sum),
                    at_rate(rate),
                );
                errors.push(symmetry.at, message);
            }
        }
    }

    /// Checks that the forces do no work.
    fn check_work(&mut self, symmetry: &SiteField, errors: &mut Errors) {
        let forces = self.scene.forces.clone();
        let works = forces.iter().map(|force| {
            let sum = *force.components.iter().flatten().next()?;
            let power = self.power(force, &Frame::default())?;
            Some((force, sum, power, self.total_power(force)?))
        });
        let works: Vec<_> = works.flatten().collect();
        // the work of a noise is not that of others
        let of = |is_noise| works.iter().filter(move |work| work.0.is_noise == is_noise);
        let of_forces: Vec<(f64, Expr)> = of(false).map(|work| (1.0, work.3)).collect();
        let mut totals = vec![self.arena.sum(0.0, &of_forces)];
        totals.extend(of(true).map(|work| work.3));
        if totals.into_iter().all(|total| self.vanishes(total)) {
            return;
        }
        let at_work: Vec<bool> = works.iter().map(|work| !self.vanishes(work.2)).collect();
        let is_known = at_work.contains(&true);
        for ((force, sum, power, _), at_work) in works.into_iter().zip(at_work) {
            if is_known && !at_work {
                continue;
            }
            let message = format!(
                "the force `{}` does work at single sites along the symmetry `{}`{}{}, so that its momentum may change; remove `#[symmetry]`, or the force along it",
                force.name,
                symmetry.name,
                at_rate(self.text(power)),
                self.loops(Some(sum)),
            );
            errors.push(symmetry.at, message);
        }
    }

    /// Returns the work that a force does in an instance of its loop.
    fn power(&mut self, force: &SiteField, frame: &Frame) -> Option<Expr> {
        let mut products = Vec::new();
        for (component, sum) in force.components.iter().enumerate() {
            let Some(sum) = *sum else { continue };
            let site = self.scene.site_of(sum)?;
            let site = self.scene.integers.replaced(site, &frame.by);
            let value = self.value(self.scene.sums[sum.0].summand, frame);
            let field = self.field(component, site, frame, None);
            products.push((1.0, self.arena.mul(value, field)));
        }
        Some(self.arena.sum(0.0, &products))
    }

    /// Returns the work that a force does.
    fn total_power(&mut self, force: &SiteField) -> Option<Expr> {
        let first = force.components.iter().flatten().next()?;
        let head = self.scene.sums[first.0].head.clone();
        self.total(&head, &Frame::default(), |x, frame| {
            x.power(force, frame)
                .unwrap_or_else(|| x.arena.constant(0.0))
        })
    }

    /// Appends the terms of a number, times `weight`, that change along the generator.
    fn broken(&mut self, number: Expr, weight: Expr, sum: Option<SumId>, to: &mut Vec<Broken>) {
        for (c, term) in self.terms(number) {
            let term = self.arena.scale(c, term);
            let rate = self.of(term, &Frame::default(), Along::Generator);
            if self.vanishes(rate) {
                continue;
            }
            if let Some((inner, slope)) = self.multiple_of_sum(term) {
                let weight = self.arena.mul(weight, slope);
                self.broken(self.scene.sums[inner.0].summand, weight, Some(inner), to);
                continue;
            }
            let [term, rate] = [term, rate].map(|number| self.arena.mul(weight, number));
            to.push(Broken { sum, term, rate });
        }
    }

    /// Returns the sum of which an expression is a multiple, and its factor, which is invariant.
    fn multiple_of_sum(&mut self, term: Expr) -> Option<(SumId, Expr)> {
        let mut sums = self.sums_in(term).into_iter();
        let (sum, symbol) = sums.next().filter(|_| sums.next().is_none())?;
        let slope = self.arena.diff(term, symbol);
        let number = self.arena.symbol(symbol);
        let multiple = self.arena.mul(slope, number);
        let change = self.of(slope, &Frame::default(), Along::Generator);
        (multiple == term && self.vanishes(change)).then_some((sum, slope))
    }

    /// Returns a formula, if it can be read.
    fn text(&self, number: Expr) -> Option<String> {
        if self.has_formal(number) {
            return None;
        }
        let text = self.arena.display(number, READABLE, &self.names());
        text.map(|text| text.text)
    }

    fn loops(&self, sum: Option<SumId>) -> String {
        match self.names().loops(sum) {
            loops if loops.is_empty() => loops,
            loops => format!(" {loops}"),
        }
    }

    fn names(&self) -> SceneNames<'_> {
        SceneNames {
            scene: &self.scene,
            arena: &self.arena,
            each: &[],
        }
    }
}
