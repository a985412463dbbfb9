//! The change of a number of a scene along a generator.
//!
//! A read of a site changes by the entry of the generator at the index of the read: by its formula
//! with this index in the place of its counter. A velocity changes by Dξ v + `ξ_t`, a momentum by
//! −(Dξ)ᵀ p. The change of a sum is the sum of the changes of its summands.
//!
//! A sum whose summand does not vanish is a symbol. Two sums with the same bounds and the same
//! summand, up to the name of the counter and to factors that do not depend on it, are multiples of
//! one symbol, so that they cancel where a formula contains both: along a shift of all angles,
//! (Σ cos θ)² + (Σ sin θ)² changes by −2 Σ cos θ Σ sin θ + 2 Σ sin θ Σ cos θ. A condition is a
//! factor with a symbol, too: it holds or does not hold, also after the change.

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Node, Symbol, Vanishing};
use crate::model::Meaning;
use crate::model::scene::{
    Condition, Counter, Head, Int, IntNode, Scene, SiteField, Slot, SlotArray, Sum, SumId,
};

/// The direction of a change.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Along {
    Generator,
    /// The motion: sites move with their velocities, and the time passes.
    Motion,
    /// A component of a site, of which alone the number is a function.
    Component(usize),
}

/// Where a number stands: integers in the place of counters, and the number of loops around it.
#[derive(Clone, Default)]
pub(super) struct Frame {
    pub(super) by: HashMap<Counter, Int>,
    depth: usize,
}

/// The meaning of a symbol of a change.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Formal {
    /// The sum of this summand.
    Sum(Head, Expr),
    /// 1 if the condition holds, else 0.
    Holds(Condition),
}

/// The change along a generator, in copies of a scene and an arena.
pub(super) struct Change {
    pub(super) scene: Scene,
    pub(super) arena: Arena,
    pub(super) evidence: Vanishing,
    generator: Vec<Option<SumId>>,
    slots: HashMap<Slot, Symbol>,
    formals: HashMap<Formal, Symbol>,
    meanings: HashMap<Symbol, Formal>,
    /// The counters of loops by their depth.
    counters: Vec<(Counter, Int)>,
}

impl Change {
    pub(super) fn new(scene: Scene, arena: Arena, symmetry: &SiteField) -> Self {
        let symbols = (0..scene.symbols.meanings().len() as u32).map(Symbol);
        let slots = symbols.filter_map(|symbol| Some((scene.slot(symbol)?.clone(), symbol)));
        Self {
            slots: slots.collect(),
            generator: symmetry.components.clone(),
            evidence: Vanishing::Proved,
            formals: HashMap::new(),
            meanings: HashMap::new(),
            counters: Vec::new(),
            scene,
            arena,
        }
    }

    /// Returns the change of a number.
    pub(super) fn of(&mut self, number: Expr, frame: &Frame, along: Along) -> Expr {
        let symbols: Vec<Symbol> = self.arena.symbols_of(number).collect();
        let mut parts = Vec::new();
        for symbol in symbols {
            if let Some(rate) = self.rate(symbol, frame, along) {
                let slope = self.arena.diff(number, symbol);
                let slope = self.value(slope, frame);
                parts.push((1.0, self.arena.mul(slope, rate)));
            }
        }
        self.arena.sum(0.0, &parts)
    }

    /// Returns whether a change vanishes, and remembers the evidence.
    pub(super) fn vanishes(&mut self, change: Expr) -> bool {
        let evidence = self.arena.vanishing(change);
        self.evidence = self.evidence.max(evidence.unwrap_or(Vanishing::Proved));
        evidence.is_some()
    }

    /// Returns the terms of a sum.
    pub(super) fn terms(&mut self, number: Expr) -> Vec<(f64, Expr)> {
        let one = self.arena.constant(1.0);
        match self.arena.node(number) {
            Node::Sum(constant, terms) => {
                let terms = terms.iter().map(|&(term, c)| (c.get(), term));
                let terms = terms.chain([(constant.get(), one)]);
                terms.filter(|term| term.0 != 0.0).collect()
            }
            _ => vec![(1.0, number)],
        }
    }

    /// Returns the sums in an expression, with their symbols.
    pub(super) fn sums_in(&self, number: Expr) -> Vec<(SumId, Symbol)> {
        let symbols = self.arena.symbols_of(number);
        let sums = symbols.filter_map(|symbol| Some((self.sum_of(symbol)?, symbol)));
        sums.collect()
    }

    /// Returns whether an expression contains symbols for sums and conditions.
    pub(super) fn has_formal(&self, number: Expr) -> bool {
        let mut symbols = self.arena.symbols_of(number);
        symbols.any(|symbol| self.meanings.contains_key(&symbol))
    }

    /// Returns the sum of a symbol.
    pub(super) fn sum_of(&self, symbol: Symbol) -> Option<SumId> {
        match self.scene.symbols.meaning(symbol) {
            Meaning::Sum(sum) => Some(SumId(*sum)),
            _ => None,
        }
    }

    /// Returns the change of a symbol; `None` if it does not change.
    fn rate(&mut self, symbol: Symbol, frame: &Frame, along: Along) -> Option<Expr> {
        if let Some(sum) = self.sum_of(symbol) {
            return Some(self.sum(sum, frame, Some(along)));
        }
        if symbol == self.scene.time {
            return (along == Along::Motion).then(|| self.arena.constant(1.0));
        }
        let Slot { array, component } = self.scene.slot(symbol)?.clone();
        let (SlotArray::Configuration(site)
        | SlotArray::Velocity(site)
        | SlotArray::Momentum(site)) = array
        else {
            return None;
        };
        let at = self.scene.integers.replaced(site, &frame.by);
        Some(match (array, along) {
            (_, Along::Component(of)) => self.arena.constant(f64::from(u8::from(of == component))),
            (SlotArray::Momentum(_), _) => self.momentum(component, at, frame),
            (SlotArray::Configuration(_), Along::Generator) => {
                self.field(component, at, frame, None)
            }
            (SlotArray::Configuration(_), Along::Motion) => {
                let array = SlotArray::Velocity(at);
                self.read(Slot { array, component })
            }
            _ => self.field(component, at, frame, Some(Along::Motion)),
        })
    }

    /// Returns the change of a component of a momentum, −(Dξ)ᵀ p.
    fn momentum(&mut self, component: usize, at: Int, frame: &Frame) -> Expr {
        let parts = (0..self.generator.len()).map(|of| {
            let slope = self.field(of, at, frame, Some(Along::Component(component)));
            let array = SlotArray::Momentum(at);
            let p = self.read(Slot {
                array,
                component: of,
            });
            (-1.0, self.arena.mul(p, slope))
        });
        let parts: Vec<(f64, Expr)> = parts.collect();
        self.arena.sum(0.0, &parts)
    }

    /// Returns a component of the generator at a site, or its change.
    pub(super) fn field(
        &mut self,
        component: usize,
        at: Int,
        frame: &Frame,
        along: Option<Along>,
    ) -> Expr {
        let sum = self.generator[component].map(|sum| self.scene.sums[sum.0].clone());
        let Some(Sum {
            head: Head::For { counter, from, .. },
            summand,
            ..
        }) = sum
        else {
            return self.arena.constant(0.0);
        };
        let index = self.scene.integers.integer(IntNode::Add(at, from));
        let frame = Frame {
            by: HashMap::from([(counter, index)]),
            depth: frame.depth,
        };
        self.value_or_change(summand, &frame, along)
    }

    fn value_or_change(&mut self, number: Expr, frame: &Frame, along: Option<Along>) -> Expr {
        match along {
            None => self.value(number, frame),
            Some(along) => self.of(number, frame, along),
        }
    }

    /// Returns a number at its place.
    pub(super) fn value(&mut self, number: Expr, frame: &Frame) -> Expr {
        let symbols: Vec<Symbol> = self.arena.symbols_of(number).collect();
        let mut by = HashMap::new();
        for symbol in symbols {
            if let Some(sum) = self.sum_of(symbol) {
                by.insert(symbol, self.sum(sum, frame, None));
            } else if let Some(slot) = self.scene.slot(symbol).cloned() {
                let slot = self.placed(slot, frame);
                by.insert(symbol, self.read(slot));
            }
        }
        self.arena.substitute(number, &by)
    }

    /// Returns a read at its place.
    fn placed(&mut self, slot: Slot, frame: &Frame) -> Slot {
        let (integers, by) = (&mut self.scene.integers, &frame.by);
        let array = match slot.array {
            SlotArray::Configuration(at) => SlotArray::Configuration(integers.replaced(at, by)),
            SlotArray::Velocity(at) => SlotArray::Velocity(integers.replaced(at, by)),
            SlotArray::Momentum(at) => SlotArray::Momentum(integers.replaced(at, by)),
            SlotArray::Number(number) => SlotArray::Number(integers.replaced(number, by)),
            SlotArray::Field(access) => SlotArray::Field(integers.replaced_in(access, by)),
            SlotArray::Rounded(number) => SlotArray::Rounded(self.value(number, frame)),
            other => other,
        };
        Slot { array, ..slot }
    }

    /// Returns the symbol of a read.
    fn read(&mut self, slot: Slot) -> Expr {
        let Scene { slots, symbols, .. } = &mut self.scene;
        let symbol = *self.slots.entry(slot.clone()).or_insert_with(|| {
            slots.push(slot);
            symbols.declare(Meaning::Slot(slots.len() - 1))
        });
        self.arena.symbol(symbol)
    }

    /// Returns a sum, or its change.
    fn sum(&mut self, sum: SumId, frame: &Frame, along: Option<Along>) -> Expr {
        let Sum { head, summand, .. } = self.scene.sums[sum.0].clone();
        if let Head::If(condition) = &head {
            let holds = self.holds(condition, frame);
            let inner = self.value_or_change(summand, frame, along);
            return self.arena.mul(holds, inner);
        }
        let total = self.total(&head, frame, |x, frame| {
            x.value_or_change(summand, frame, along)
        });
        total.unwrap_or(summand)
    }

    /// Returns the sum of a summand over the rounds of a loop; `None` if the head is no loop.
    pub(super) fn total(
        &mut self,
        head: &Head,
        frame: &Frame,
        summand: impl FnOnce(&mut Self, &Frame) -> Expr,
    ) -> Option<Expr> {
        let Head::For { counter, from, to } = *head else {
            return None;
        };
        let [from, to] = [from, to].map(|bound| self.scene.integers.replaced(bound, &frame.by));
        let mut inner = frame.clone();
        let (own, index) = self.counter(inner.depth);
        inner.depth += 1;
        inner.by.insert(counter, index);
        let summand = summand(self, &inner);
        if self.vanishes(summand) {
            return Some(self.arena.constant(0.0));
        }
        let counter = own;
        let head = Head::For { counter, from, to };
        let parts = self.terms(summand).into_iter().map(|(c, term)| {
            let factors = match self.arena.node(term) {
                Node::Product(factors) => factors.clone(),
                _ => vec![(term, 1)],
            };
            let (bound, free): (Vec<_>, Vec<_>) = factors
                .into_iter()
                .partition(|factor| self.depends(factor.0, own));
            let total = self.total_of(&head, &bound);
            let free = self.arena.product(&free);
            (c, self.arena.mul(free, total))
        });
        let parts: Vec<(f64, Expr)> = parts.collect();
        Some(self.arena.sum(0.0, &parts))
    }

    /// Returns the sum of a product over the rounds of a loop.
    fn total_of(&mut self, head: &Head, factors: &[(Expr, i32)]) -> Expr {
        if let (Head::For { from, to, .. }, []) = (head, factors) {
            let is_length = matches!(self.scene.integers.node(*to), IntNode::Length(_));
            if is_length && self.scene.integers.value(*from) == Some(0) {
                let (array, component) = (SlotArray::Number(*to), 0);
                return self.read(Slot { array, component });
            }
        }
        let summand = self.arena.product(factors);
        self.formal(Formal::Sum(head.clone(), summand))
    }

    /// Returns the counter of loops with this number of loops around them.
    fn counter(&mut self, depth: usize) -> (Counter, Int) {
        while self.counters.len() <= depth {
            let counter = self.scene.integers.counter("i".to_owned());
            self.counters.push(counter);
        }
        self.counters[depth]
    }

    fn formal(&mut self, formal: Formal) -> Expr {
        let symbols = &mut self.scene.symbols;
        let symbol = *self
            .formals
            .entry(formal.clone())
            .or_insert_with(|| symbols.declare(Meaning::Partial));
        self.meanings.insert(symbol, formal);
        self.arena.symbol(symbol)
    }

    /// Returns the factor of a condition.
    fn holds(&mut self, condition: &Condition, frame: &Frame) -> Expr {
        let condition = match condition {
            Condition::Not(inner) => {
                let inner = self.holds(inner, frame);
                return self.arena.sum(1.0, &[(-1.0, inner)]);
            }
            Condition::And(a, b) => {
                let [a, b] = [a, b].map(|condition| self.holds(condition, frame));
                return self.arena.mul(a, b);
            }
            Condition::Or(a, b) => {
                let [a, b] = [a, b].map(|condition| self.holds(condition, frame));
                let both = self.arena.mul(a, b);
                return self.arena.sum(0.0, &[(1.0, a), (1.0, b), (-1.0, both)]);
            }
            &Condition::Integers(comparison, a, b) => {
                let [a, b] = [a, b].map(|x| self.scene.integers.replaced(x, &frame.by));
                Condition::Integers(comparison, a, b)
            }
            &Condition::Numbers(comparison, a, b) => {
                let [a, b] = [a, b].map(|x| self.value(x, frame));
                Condition::Numbers(comparison, a, b)
            }
        };
        self.formal(Formal::Holds(condition))
    }

    /// Returns whether a number depends on a counter.
    fn depends(&mut self, number: Expr, counter: Counter) -> bool {
        let symbols: Vec<Symbol> = self.arena.symbols_of(number).collect();
        symbols.into_iter().any(|symbol| {
            let mut integers = Vec::new();
            let mut numbers = Vec::new();
            match self.meanings.get(&symbol) {
                Some(Formal::Sum(Head::For { from, to, .. }, summand)) => {
                    integers.extend([*from, *to]);
                    numbers.push(*summand);
                }
                Some(Formal::Holds(Condition::Integers(_, a, b))) => integers.extend([*a, *b]),
                Some(Formal::Holds(Condition::Numbers(_, a, b))) => numbers.extend([*a, *b]),
                _ => {}
            }
            match self.scene.slot(symbol).map(|slot| slot.array.clone()) {
                Some(
                    SlotArray::Configuration(at)
                    | SlotArray::Velocity(at)
                    | SlotArray::Momentum(at),
                ) => integers.push(at),
                Some(SlotArray::Number(number)) => integers.push(number),
                Some(SlotArray::Field(access)) => {
                    integers.push(self.scene.integers.integer(IntNode::Field(access)));
                }
                Some(SlotArray::Rounded(number)) => numbers.push(number),
                _ => {}
            }
            let has = |int: Int| self.scene.has_counter(int, counter);
            integers.into_iter().any(has) || numbers.into_iter().any(|e| self.depends(e, counter))
        })
    }
}
