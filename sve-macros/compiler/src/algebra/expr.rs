//! The hash-consed arena of expressions.
//!
//! Invariants: the operands of a node were created before it, so ascending order is an order of
//! evaluation and no walk needs recursion; equal nodes have equal names; the interning maps are
//! only looked up, never iterated, so the same input gives the same output.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;

pub(crate) use super::functions::{Binary, Function};
use super::hash::Map;

/// An expression: a name of a node in its arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Expr(u32);

impl Expr {
    /// Returns the position of the node in its arena.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// A free variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Symbol(pub(crate) u32);

/// The mark by which later stages recognise an intermediate result. The algebra does not interpret
/// it, beside the rules of [`Arena::differentiate_by`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Identity(pub(crate) u64);

/// Returns the argument of an intermediate result that is a function of one argument, and the
/// derivative with respect to it; `None` if the result has not the form of the function any more.
pub(crate) type Slope = fn(&mut Arena, Expr) -> Option<[Expr; 2]>;

/// A constant, compared and hashed by its bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Bits(u64);

impl Bits {
    pub(crate) fn new(value: f64) -> Self {
        // one zero: −0 and 0 are the same constant
        Self((value + 0.0).to_bits())
    }

    pub(crate) fn get(self) -> f64 {
        f64::from_bits(self.0)
    }
}

/// The operation of an expression and its operands.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Node {
    Constant(Bits),
    Symbol(Symbol),
    /// `constant + Σ coefficient · term`; terms ascending, none a sum or a constant, no coefficient
    /// zero.
    Sum(Bits, Vec<(Expr, Bits)>),
    /// `Π base^exponent`; bases ascending, none a product or a constant, no exponent zero.
    Product(Vec<(Expr, i32)>),
    Call(Function, Expr),
    Call2(Binary, Expr, Expr),
    /// An intermediate result: the value of its operand, not expanded by the rules of sums and
    /// products. The identity is not part of the value; it stays when symbols in the operand are
    /// replaced.
    Opaque(Expr, Option<Identity>),
}

/// Cost of a new node in the budget. A new node is likely to be differentiated, scheduled and
/// printed.
const NODE: usize = 1_000;

/// Additional cost of each operand of a new node.
const OPERAND: usize = 300;

/// The symbols that an expression contains, as an index of interned sets.
type SetId = u32;

/// Owner of the expressions of one derivation. An expression has the same meaning in every copy of
/// the arena made after the expression.
#[derive(Clone)]
pub(crate) struct Arena {
    nodes: Vec<Node>,
    names: Map<Node, Expr>,
    /// The set of symbols of each node.
    contents: Vec<SetId>,
    sets: Vec<Vec<u64>>,
    set_names: Map<Vec<u64>, SetId>,
    pub(super) derivatives: Map<(Expr, Symbol), Expr>,
    pub(super) slopes: Map<Identity, Slope>,
    /// The nodes that walks have visited.
    marks: RefCell<Marks>,
    /// True if folding has lost a constant: one too small to change the constant it was added to,
    /// or a product that underflowed. An expression that the algebra simplifies to 0 may then be
    /// different from 0.
    pub(super) has_lost_constants: Cell<bool>,
    /// Remaining work; see `budget`.
    pub(super) budget: Cell<usize>,
}

/// Marks of a walk. A node is marked if its entry is the number of the walk.
#[derive(Clone, Default)]
struct Marks {
    walk: u32,
    of: Vec<u32>,
}

impl Arena {
    pub(crate) fn new() -> Self {
        Self {
            nodes: Vec::new(),
            names: Map::default(),
            contents: Vec::new(),
            sets: vec![Vec::new()],
            set_names: Map::from_iter([(Vec::new(), 0)]),
            derivatives: Map::default(),
            slopes: Map::default(),
            marks: RefCell::default(),
            has_lost_constants: Cell::new(false),
            budget: Cell::new(usize::MAX),
        }
    }

    pub(crate) fn node(&self, expr: Expr) -> &Node {
        &self.nodes[expr.0 as usize]
    }

    /// Returns the operands of an expression.
    pub(crate) fn operands_of(&self, expr: Expr) -> impl Iterator<Item = Expr> {
        let mut list = Vec::new();
        each_operand(self.node(expr), |operand| list.push(operand));
        list.into_iter()
    }

    /// Returns the number of nodes.
    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Returns the value of a constant expression.
    pub(crate) fn constant_value(&self, expr: Expr) -> Option<f64> {
        match self.node(expr) {
            Node::Constant(bits) => Some(bits.get()),
            _ => None,
        }
    }

    /// Returns whether the constants of a node itself, not of its operands, are finite.
    pub(crate) fn is_finite(&self, expr: Expr) -> bool {
        match self.node(expr) {
            Node::Constant(bits) => bits.get().is_finite(),
            Node::Sum(constant, terms) => {
                constant.get().is_finite() && terms.iter().all(|t| t.1.get().is_finite())
            }
            _ => true,
        }
    }

    /// Returns whether `symbol` occurs in `expr`.
    pub(crate) fn contains(&self, expr: Expr, symbol: Symbol) -> bool {
        let set = &self.sets[self.contents[expr.0 as usize] as usize];
        let (word, bit) = (symbol.0 as usize / 64, symbol.0 % 64);
        set.get(word).is_some_and(|w| w >> bit & 1 == 1)
    }

    /// Returns the expression of a symbol if it exists already.
    pub(crate) fn known_symbol(&self, symbol: Symbol) -> Option<Expr> {
        self.names.get(&Node::Symbol(symbol)).copied()
    }

    /// Returns the symbols that occur in `expr`, ascending.
    pub(crate) fn symbols_of(&self, expr: Expr) -> impl Iterator<Item = Symbol> + '_ {
        let set = &self.sets[self.contents[expr.0 as usize] as usize];
        set.iter().enumerate().flat_map(|(word, &bits)| {
            (0..64u32)
                .filter(move |bit| bits >> bit & 1 == 1)
                .map(move |bit| Symbol(word as u32 * 64 + bit))
        })
    }

    /// Returns the name of a node, which must satisfy the invariants, and creates the node if it is
    /// new.
    pub(super) fn intern(&mut self, node: Node) -> Expr {
        if let Some(&expr) = self.names.get(&node) {
            return expr;
        }
        let mut size = 0;
        each_operand(&node, |_| size += 1);
        if self.is_exhausted() && size > 0 {
            return self.intern(Node::Constant(Bits::new(0.0)));
        }
        let set = self.content_of(&node);
        self.spend(NODE + OPERAND * size + self.sets[set as usize].len());
        let expr = Expr(self.nodes.len() as u32);
        self.nodes.push(node.clone());
        self.contents.push(set);
        self.names.insert(node, expr);
        expr
    }

    /// Returns the product of these factors if it exists already.
    pub(super) fn known_product(&self, factors: &[(Expr, i32)]) -> Option<Expr> {
        self.names.get(&Node::Product(factors.to_vec())).copied()
    }

    fn content_of(&mut self, node: &Node) -> SetId {
        let mut set: Vec<u64> = Vec::new();
        let mut join = |other: &[u64]| {
            if set.len() < other.len() {
                set.resize(other.len(), 0);
            }
            for (a, b) in set.iter_mut().zip(other) {
                *a |= b;
            }
        };
        match node {
            Node::Symbol(symbol) => {
                let mut one = vec![0; symbol.0 as usize / 64 + 1];
                one[symbol.0 as usize / 64] = 1 << (symbol.0 % 64);
                join(&one);
            }
            _ => {
                each_operand(node, |operand| {
                    join(&self.sets[self.contents[operand.index()] as usize]);
                });
            }
        }
        if let Some(&id) = self.set_names.get(&set) {
            return id;
        }
        let id = self.sets.len() as SetId;
        self.sets.push(set.clone());
        self.set_names.insert(set, id);
        id
    }

    /// Returns the accepted subexpressions of `roots`, operands before users. The walk does not
    /// enter a subexpression that `wanted` rejects.
    pub(crate) fn reachable(&self, roots: &[Expr], wanted: impl Fn(Expr) -> bool) -> Vec<Expr> {
        if self.is_exhausted() {
            return Vec::new();
        }
        // a walk within `wanted` finds no marks here and creates its own
        let mut marks = self.marks.take();
        marks.walk += 1;
        marks.of.resize(self.nodes.len(), 0);
        let mut work = 1;
        let mut stack: Vec<Expr> = Vec::new();
        let mut found = Vec::new();
        let visit = |expr: Expr, marks: &mut Marks, stack: &mut Vec<Expr>| {
            let mark = &mut marks.of[expr.index()];
            if *mark != marks.walk && wanted(expr) {
                *mark = marks.walk;
                stack.push(expr);
            }
        };
        for &root in roots {
            visit(root, &mut marks, &mut stack);
        }
        while let Some(expr) = stack.pop() {
            found.push(expr);
            each_operand(self.node(expr), |operand| {
                work += 1;
                visit(operand, &mut marks, &mut stack);
            });
        }
        self.marks.replace(marks);
        self.spend(work);
        found.sort_unstable();
        found
    }

    /// Replaces symbols in `expr`.
    pub(crate) fn substitute(&mut self, expr: Expr, by: &HashMap<Symbol, Expr>) -> Expr {
        self.substitute_all(&[expr], by)[0]
    }

    /// Replaces symbols in each of `exprs`; shared subexpressions are rebuilt once.
    pub(crate) fn substitute_all(
        &mut self,
        exprs: &[Expr],
        by: &HashMap<Symbol, Expr>,
    ) -> Vec<Expr> {
        let mut replaced = Vec::new();
        for symbol in by.keys() {
            let word = symbol.0 as usize / 64;
            if replaced.len() <= word {
                replaced.resize(word + 1, 0);
            }
            replaced[word] |= 1 << (symbol.0 % 64);
        }
        let mut done = Map::default();
        let mut results = Vec::with_capacity(exprs.len());
        for &expr in exprs {
            if self.has_any(expr, &replaced) {
                let touched = self.reachable(&[expr], |e| {
                    self.has_any(e, &replaced) && !done.contains_key(&e)
                });
                for e in touched {
                    let new = self.rebuild(e, by, &done);
                    done.insert(e, new);
                }
            }
            results.push(done.get(&expr).copied().unwrap_or(expr));
        }
        results
    }

    /// Replaces subexpressions in each of `exprs`; shared subexpressions are rebuilt once.
    pub(crate) fn replace_all(&mut self, exprs: &[Expr], by: &HashMap<Expr, Expr>) -> Vec<Expr> {
        let none = HashMap::new();
        let mut done: Map<Expr, Expr> = by.iter().map(|(&old, &new)| (old, new)).collect();
        for e in self.reachable(exprs, |e| !by.contains_key(&e)) {
            let new = self.rebuild(e, &none, &done);
            done.insert(e, new);
        }
        exprs
            .iter()
            .map(|e| done.get(e).copied().unwrap_or(*e))
            .collect()
    }

    /// Returns whether any symbol of a set occurs in `expr`.
    fn has_any(&self, expr: Expr, set: &[u64]) -> bool {
        let own = &self.sets[self.contents[expr.index()] as usize];
        own.iter().zip(set).any(|(a, b)| a & b != 0)
    }

    /// Rebuilds a node with its symbol or its operands replaced.
    fn rebuild(&mut self, e: Expr, by: &HashMap<Symbol, Expr>, done: &Map<Expr, Expr>) -> Expr {
        let of = |x: Expr| done.get(&x).copied().unwrap_or(x);
        match self.node(e).clone() {
            Node::Constant(_) => e,
            Node::Symbol(symbol) => by.get(&symbol).copied().unwrap_or(e),
            Node::Sum(constant, terms) => {
                let terms: Vec<_> = terms.iter().map(|&(x, c)| (c.get(), of(x))).collect();
                self.sum(constant.get(), &terms)
            }
            Node::Product(factors) => {
                let factors: Vec<_> = factors.iter().map(|&(x, k)| (of(x), k)).collect();
                self.product(&factors)
            }
            Node::Call(function, x) => self.call(function, of(x)),
            Node::Call2(function, x, y) => self.call2(function, of(x), of(y)),
            Node::Opaque(x, identity) => self.intermediate(of(x), identity),
        }
    }
}

/// Calls `f` with each operand of a node.
pub(super) fn each_operand(node: &Node, mut f: impl FnMut(Expr)) {
    match node {
        Node::Constant(_) | Node::Symbol(_) => {}
        Node::Sum(_, terms) => terms.iter().for_each(|t| f(t.0)),
        Node::Product(factors) => factors.iter().for_each(|t| f(t.0)),
        Node::Call(_, x) | Node::Opaque(x, _) => f(*x),
        Node::Call2(_, x, y) => {
            f(*x);
            f(*y);
        }
    }
}
