//! The hash-consed arena of expressions.
//!
//! Invariants: a node's operands were created before it, so ascending order is an order of evaluation and no walk needs
//! recursion; equal nodes have equal names; the interning maps are only looked up, never iterated, so that the same input
//! gives the same output.

use std::collections::HashMap;

/// An expression: a name of a node in its arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Expr(u32);

/// A free variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Symbol(pub(crate) u32);

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

/// Functions of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Function {
    Sqrt,
    Cbrt,
    Exp,
    Exp2,
    ExpM1,
    Ln,
    Ln1p,
    Log2,
    Log10,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    /// A power with a constant exponent that is neither integer nor half-integer.
    Powf(Bits),
}

/// Functions of two arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Binary {
    Atan2,
    Hypot,
    Pow,
}

/// What an expression is made of.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Node {
    Constant(Bits),
    Symbol(Symbol),
    /// `constant + Σ coefficient · term`; terms ascending, none a sum or a constant, no coefficient zero.
    Sum(Bits, Vec<(Expr, Bits)>),
    /// `Π base^exponent`; bases ascending, none a product or a constant, no exponent zero.
    Product(Vec<(Expr, i32)>),
    Call(Function, Expr),
    Call2(Binary, Expr, Expr),
    /// The same value as its operand, but not opened by the rules of sums and products: a named intermediate result.
    Opaque(Expr),
}

/// The symbols that an expression contains, as an index of interned sets.
type SetId = u32;

/// Owner of all expressions of one expansion.
pub(crate) struct Arena {
    nodes: Vec<Node>,
    names: HashMap<Node, Expr>,
    /// Symbols in each node.
    contents: Vec<SetId>,
    sets: Vec<Vec<u64>>,
    set_names: HashMap<Vec<u64>, SetId>,
    pub(super) derivatives: HashMap<(Expr, Symbol), Expr>,
}

impl Arena {
    pub(crate) fn new() -> Self {
        Self {
            nodes: Vec::new(),
            names: HashMap::new(),
            contents: Vec::new(),
            sets: vec![Vec::new()],
            set_names: HashMap::from([(Vec::new(), 0)]),
            derivatives: HashMap::new(),
        }
    }

    pub(crate) fn node(&self, expr: Expr) -> &Node {
        &self.nodes[expr.0 as usize]
    }

    /// The operands of an expression.
    pub(crate) fn operands_of(&self, expr: Expr) -> impl Iterator<Item = Expr> + '_ {
        operands(self.node(expr))
    }

    /// Number of nodes so far.
    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The value of a constant expression.
    pub(crate) fn constant_value(&self, expr: Expr) -> Option<f64> {
        match self.node(expr) {
            Node::Constant(bits) => Some(bits.get()),
            _ => None,
        }
    }

    /// Whether the constants of a node, those of its operands aside, are finite.
    pub(crate) fn is_finite(&self, expr: Expr) -> bool {
        match self.node(expr) {
            Node::Constant(bits) => bits.get().is_finite(),
            Node::Sum(constant, terms) => {
                constant.get().is_finite() && terms.iter().all(|t| t.1.get().is_finite())
            }
            _ => true,
        }
    }

    /// Whether `symbol` occurs in `expr`.
    pub(crate) fn contains(&self, expr: Expr, symbol: Symbol) -> bool {
        let set = &self.sets[self.contents[expr.0 as usize] as usize];
        let (word, bit) = (symbol.0 as usize / 64, symbol.0 % 64);
        set.get(word).is_some_and(|w| w >> bit & 1 == 1)
    }

    /// The expression of a symbol, if there is one yet.
    pub(crate) fn known_symbol(&self, symbol: Symbol) -> Option<Expr> {
        self.names.get(&Node::Symbol(symbol)).copied()
    }

    /// The symbols that occur in `expr`, ascending.
    pub(crate) fn symbols_of(&self, expr: Expr) -> impl Iterator<Item = Symbol> + '_ {
        let set = &self.sets[self.contents[expr.0 as usize] as usize];
        set.iter().enumerate().flat_map(|(word, &bits)| {
            (0..64u32)
                .filter(move |bit| bits >> bit & 1 == 1)
                .map(move |bit| Symbol(word as u32 * 64 + bit))
        })
    }

    /// The name of a node whose invariants hold.
    pub(super) fn intern(&mut self, node: Node) -> Expr {
        if let Some(&expr) = self.names.get(&node) {
            return expr;
        }
        let set = self.content_of(&node);
        let expr = Expr(self.nodes.len() as u32);
        self.nodes.push(node.clone());
        self.contents.push(set);
        self.names.insert(node, expr);
        expr
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
                for operand in operands(node) {
                    join(&self.sets[self.contents[operand.0 as usize] as usize]);
                }
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

    /// Everything that `roots` are made of and `wanted` accepts, operands before users.
    pub(crate) fn reachable(&self, roots: &[Expr], wanted: impl Fn(Expr) -> bool) -> Vec<Expr> {
        let mut seen = vec![false; self.nodes.len()];
        let mut stack: Vec<Expr> = Vec::new();
        let mut found = Vec::new();
        let visit = |expr: Expr, seen: &mut Vec<bool>, stack: &mut Vec<Expr>| {
            if !seen[expr.0 as usize] && wanted(expr) {
                seen[expr.0 as usize] = true;
                stack.push(expr);
            }
        };
        for &root in roots {
            visit(root, &mut seen, &mut stack);
        }
        while let Some(expr) = stack.pop() {
            found.push(expr);
            for operand in operands(self.node(expr)) {
                visit(operand, &mut seen, &mut stack);
            }
        }
        found.sort_unstable();
        found
    }

    /// `expr` with symbols replaced.
    pub(crate) fn substitute(&mut self, expr: Expr, by: &HashMap<Symbol, Expr>) -> Expr {
        let touched = self.reachable(&[expr], |e| self.symbols_of(e).any(|s| by.contains_key(&s)));
        let mut done: HashMap<Expr, Expr> = HashMap::with_capacity(touched.len());
        for e in touched {
            let of = |x: Expr| done.get(&x).copied().unwrap_or(x);
            let new = match self.node(e).clone() {
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
                Node::Opaque(x) => self.opaque(of(x)),
            };
            done.insert(e, new);
        }
        done.get(&expr).copied().unwrap_or(expr)
    }
}

/// The operands of a node.
pub(super) fn operands(node: &Node) -> impl Iterator<Item = Expr> + '_ {
    let (list, pair): (Box<dyn Iterator<Item = Expr> + '_>, [Option<Expr>; 2]) = match node {
        Node::Constant(_) | Node::Symbol(_) => (Box::new(std::iter::empty()), [None, None]),
        Node::Sum(_, terms) => (Box::new(terms.iter().map(|t| t.0)), [None, None]),
        Node::Product(factors) => (Box::new(factors.iter().map(|f| f.0)), [None, None]),
        Node::Call(_, x) | Node::Opaque(x) => (Box::new(std::iter::empty()), [Some(*x), None]),
        Node::Call2(_, x, y) => (Box::new(std::iter::empty()), [Some(*x), Some(*y)]),
    };
    list.chain(pair.into_iter().flatten())
}
