//! A scene: a system whose number of coordinates is known when the program runs. Its loops are kept
//! as sums.
//!
//! Invariant: a sum occurs once, in the summand of its parent or in one root of the scene, and
//! parents come before their children. A condition contains no sum.

mod integers;
mod names;

use std::collections::{HashMap, HashSet};

use proc_macro2::{Span, TokenStream};

use super::{Meaning, Symbols};
use crate::algebra::{Arena, Expr, Symbol};
pub(crate) use integers::{Access, Array, Counter, Int, IntNode, Integers, Step};
pub(crate) use names::SceneNames;

/// The number of a sum. Its symbol has the meaning `Meaning::Sum`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct SumId(pub(crate) usize);

/// A kept loop: a sum over its rounds.
#[derive(Clone, Debug)]
pub(crate) struct Sum {
    pub(crate) parent: Option<SumId>,
    pub(crate) head: Head,
    pub(crate) summand: Expr,
    /// The place of the loop.
    pub(crate) at: Span,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Head {
    /// `for counter in from..to`.
    For {
        counter: Counter,
        from: Int,
        to: Int,
    },
    /// The summand if the condition holds, else nothing.
    If(Condition),
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Comparison {
    Equal,
    Less,
    LessOrEqual,
}

impl Comparison {
    pub(crate) fn holds<T: PartialOrd>(self, a: &T, b: &T) -> bool {
        match self {
            Self::Equal => a == b,
            Self::Less => a < b,
            Self::LessOrEqual => a <= b,
        }
    }
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Condition {
    Integers(Comparison, Int, Int),
    /// A cut-off.
    Numbers(Comparison, Expr, Expr),
    Not(Box<Condition>),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
}

/// A read of a row or a field with an index. Its symbol has the meaning `Meaning::Slot`; equal
/// reads have one symbol.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Slot {
    pub(crate) array: SlotArray,
    /// The component of a row; 0 for numbers.
    pub(crate) component: usize,
}

#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) enum SlotArray {
    Configuration(Int),
    Velocity(Int),
    Momentum(Int),
    /// A number that a field holds.
    Field(Access),
    /// An integer as a number.
    Number(Int),
    /// The integer nearest to a number that reads slots, such as the number of periods between two
    /// sites. It is a constant for derivatives.
    Rounded(Expr),
    /// The value of an inner sum, one of a list, in an instance of the sum around it. It is a
    /// constant for derivatives, and so is a weight.
    Sum(usize),
    /// The derivative with respect to such a value, with the weight of the sum around it.
    Weight(Expr),
}

impl SlotArray {
    /// Returns whether the read may differ from step to step.
    pub(crate) fn moves(&self) -> bool {
        !matches!(self, Self::Field(_) | Self::Number(_))
    }

    /// Returns whether the read is computed from other reads.
    pub(crate) fn is_computed(&self) -> bool {
        matches!(self, Self::Rounded(_) | Self::Sum(_) | Self::Weight(_))
    }
}

/// The type of a row of the configuration.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Row {
    /// `&[f64]`.
    Number,
    /// `&[[f64; D]]`.
    Array(usize),
    /// `&[SVector<f64, D>]`.
    Vector(usize),
}

impl Row {
    /// Returns the number of components of a row.
    pub(crate) fn len(self) -> usize {
        match self {
            Self::Number => 1,
            Self::Array(n) | Self::Vector(n) => n,
        }
    }
}

/// A system of any number of sites.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) symbols: Symbols,
    pub(crate) time: Symbol,
    pub(crate) row: Row,
    pub(crate) integers: Integers,
    pub(crate) slots: Vec<Slot>,
    pub(crate) sums: Vec<Sum>,
    pub(crate) lagrangian: Expr,
    pub(crate) noises: Vec<SceneNoise>,
    pub(crate) forces: Vec<SiteField>,
    /// The generators of symmetries.
    pub(crate) symmetries: Vec<SiteField>,
    /// As in [`Model`](super::Model).
    pub(crate) constants: Vec<(TokenStream, f64)>,
}

/// A function γ or H₁.
#[derive(Clone, Debug)]
pub(crate) struct SceneNoise {
    /// Source name.
    pub(crate) name: String,
    pub(crate) is_h1: bool,
    pub(crate) processes: Processes,
}

/// The processes of a noise.
#[derive(Clone, Debug)]
pub(crate) enum Processes {
    /// The noise of each process, of a function that returns `f64` or an array.
    Listed(Vec<Expr>),
    /// A function that returns a `Vec`, with the sum of each of the K components of an entry. The
    /// summand of sum k, a `For`, is that of the process `K (counter − from) + k`.
    Each(Vec<SumId>),
}

/// A component of the entries of a function that returns a `Vec`.
#[derive(Clone, Copy)]
pub(crate) struct Each {
    pub(crate) increment: Symbol,
    /// The sum over the entries.
    pub(crate) sum: SumId,
    /// Number of the component, and the number of components.
    pub(crate) component: usize,
    pub(crate) of: usize,
}

/// A force, or the generator of a symmetry.
#[derive(Clone, Debug)]
pub(crate) struct SiteField {
    /// Source name, and its place.
    pub(crate) name: String,
    pub(crate) at: Span,
    /// True for a force that acts with a Wiener process.
    pub(crate) is_noise: bool,
    /// For each component, the sum whose summand, a `For`, is the value at the site
    /// `counter − from`; `None` for a component that is zero everywhere.
    pub(crate) components: Vec<Option<SumId>>,
}

impl Head {
    /// Returns the numbers that a condition compares.
    pub(crate) fn numbers(&self) -> Vec<Expr> {
        let mut numbers = Vec::new();
        self.clone().replace(&mut |number| {
            numbers.push(number);
            number
        });
        numbers
    }

    /// Replaces the numbers that a condition compares.
    pub(crate) fn replace(&mut self, by: &mut dyn FnMut(Expr) -> Expr) {
        if let Self::If(condition) = self {
            condition.replace(by);
        }
    }
}

impl Condition {
    fn replace(&mut self, by: &mut dyn FnMut(Expr) -> Expr) {
        match self {
            Self::Integers(..) => {}
            Self::Numbers(_, a, b) => [a, b].into_iter().for_each(|number| *number = by(*number)),
            Self::Not(inner) => inner.replace(by),
            Self::And(a, b) | Self::Or(a, b) => {
                a.replace(by);
                b.replace(by);
            }
        }
    }
}

impl Scene {
    /// Returns a sum with the sums around it, the innermost first.
    pub(crate) fn around(&self, sum: Option<SumId>) -> impl Iterator<Item = SumId> + '_ {
        std::iter::successors(sum, |sum| self.sums[sum.0].parent)
    }

    /// Returns the formulas of L, the noises and the forces.
    pub(crate) fn formulas(&self) -> impl Iterator<Item = Expr> + '_ {
        let sums = self.sums.iter().flat_map(|sum| {
            let conditions = sum.head.numbers().into_iter();
            conditions.chain([sum.summand])
        });
        let listed = self.noises.iter().flat_map(|noise| match &noise.processes {
            Processes::Listed(list) => list.as_slice(),
            Processes::Each(_) => &[],
        });
        sums.chain(listed.copied()).chain([self.lagrangian])
    }

    /// Returns whether a condition on numbers or a rounded number depends on the state or the time.
    /// The functions of the scene are then smooth only between its jumps.
    pub(crate) fn is_piecewise(&self, arena: &Arena) -> bool {
        let conditions = self.sums.iter().flat_map(|sum| sum.head.numbers());
        let rounded = self.slots.iter().filter_map(|slot| match slot.array {
            SlotArray::Rounded(number) => Some(number),
            _ => None,
        });
        let moves = |symbol| {
            let slot = self.slot(symbol);
            symbol == self.time || slot.is_some_and(|slot| slot.array.moves())
        };
        conditions
            .chain(rounded)
            .any(|number| arena.symbols_of(number).any(moves))
    }

    /// Returns whether a head stands for what is outside of all loops.
    pub(crate) fn is_once(&self, head: &Head) -> bool {
        let Head::For { from, to, .. } = *head else {
            return false;
        };
        [from, to].map(|bound| self.integers.value(bound)) == [Some(0), Some(1)]
    }

    /// Returns the site of an entry of a force or a generator, of a `For`.
    pub(crate) fn site_of(&mut self, sum: SumId) -> Option<Int> {
        let Head::For { counter, from, .. } = self.sums[sum.0].head else {
            return None;
        };
        let counter = self.integers.integer(IntNode::Counter(counter));
        Some(match self.integers.value(from) {
            Some(0) => counter,
            _ => self.integers.integer(IntNode::Sub(counter, from)),
        })
    }

    /// Returns the symbols of the components of a site, with the numbers of the components.
    pub(crate) fn row_of(&self, site: Int) -> impl Iterator<Item = (Symbol, usize)> + '_ {
        let symbols = (0..self.symbols.meanings().len() as u32).map(Symbol);
        symbols.filter_map(move |symbol| match self.slot(symbol)? {
            Slot {
                array: SlotArray::Configuration(of),
                component,
            } if *of == site => Some((symbol, *component)),
            _ => None,
        })
    }

    /// Returns the symbols of the components of velocities, with their sites and components.
    pub(crate) fn velocities(&self) -> HashMap<Symbol, (Int, usize)> {
        let symbols = (0..self.symbols.meanings().len() as u32).map(Symbol);
        let velocities = symbols.filter_map(|symbol| match self.slot(symbol)? {
            &Slot {
                array: SlotArray::Velocity(of),
                component,
            } => Some((symbol, (of, component))),
            _ => None,
        });
        velocities.collect()
    }

    /// Returns the symbols of the components of momenta.
    pub(crate) fn momenta(&self) -> HashSet<Symbol> {
        let symbols = (0..self.symbols.meanings().len() as u32).map(Symbol);
        let is_momentum = |symbol: &Symbol| {
            let slot = self.slot(*symbol);
            slot.is_some_and(|slot| matches!(slot.array, SlotArray::Momentum(_)))
        };
        symbols.filter(is_momentum).collect()
    }

    /// Adds a sum within another one.
    pub(crate) fn child(&mut self, parent: SumId, head: Head) -> SumId {
        let Sum { summand, at, .. } = self.sums[parent.0];
        let parent = Some(parent);
        self.sums.push(Sum {
            parent,
            head,
            summand,
            at,
        });
        SumId(self.sums.len() - 1)
    }

    /// Returns the slot that a symbol denotes.
    pub(crate) fn slot(&self, symbol: Symbol) -> Option<&Slot> {
        match self.symbols.meaning(symbol) {
            Meaning::Slot(slot) => self.slots.get(*slot),
            _ => None,
        }
    }

    pub(crate) fn slot_mut(&mut self, symbol: Symbol) -> Option<&mut Slot> {
        match self.symbols.meaning(symbol) {
            Meaning::Slot(slot) => self.slots.get_mut(*slot),
            _ => None,
        }
    }

    /// Returns the heads of a sum and of the sums around it, the innermost first.
    pub(crate) fn heads(&self, sum: Option<SumId>) -> impl Iterator<Item = &Head> + '_ {
        self.around(sum).map(|sum| &self.sums[sum.0].head)
    }

    /// Returns a slot as the source may spell it.
    pub(crate) fn text(&self, slot: &Slot) -> String {
        let rows = |name: &str, index: Int| format!("{name}[{}]", self.integers.text(index));
        match &slot.array {
            SlotArray::Configuration(index) => rows("q", *index),
            SlotArray::Velocity(index) => rows("v", *index),
            SlotArray::Momentum(index) => rows("p", *index),
            SlotArray::Field(access) => self.integers.path_text(access),
            SlotArray::Number(integer) => self.integers.text(*integer),
            SlotArray::Rounded(_) => "a rounded number".to_owned(),
            SlotArray::Sum(_) | SlotArray::Weight(_) => "an inner sum".to_owned(),
        }
    }

    /// Returns whether a number depends on a symbol, also through numbers computed from others.
    pub(crate) fn depends(&self, number: Expr, symbol: Symbol, arena: &Arena) -> bool {
        arena.symbols_of(number).any(|read| {
            let inner = self.slot(read).and_then(|slot| match slot.array {
                SlotArray::Weight(inner) | SlotArray::Rounded(inner) => Some(inner),
                _ => None,
            });
            read == symbol || inner.is_some_and(|inner| self.depends(inner, symbol, arena))
        })
    }

    /// Returns the numbers that a step may read beside those of its terms: of conditions, and those
    /// from which others are computed.
    pub(crate) fn side_numbers(&self) -> Vec<Expr> {
        let conditions = self.sums.iter().flat_map(|sum| sum.head.numbers());
        let mut numbers: Vec<Expr> = conditions.collect();
        for slot in &self.slots {
            match slot.array {
                SlotArray::Rounded(number) | SlotArray::Weight(number) => numbers.push(number),
                SlotArray::Sum(_) => numbers.extend(self.sums.iter().map(|sum| sum.summand)),
                _ => {}
            }
        }
        numbers
    }
}
