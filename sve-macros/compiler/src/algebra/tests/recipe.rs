//! Descriptions of expressions without simplification: an oracle evaluates the description, and the
//! algebra builds the expression.

use super::number::Number;
use crate::algebra::expr::{Bits, Node};
use crate::algebra::{Arena, Binary, Expr, Function, Symbol};

/// All functions of one argument except powers.
pub(crate) const FUNCTIONS: &[Function] = Function::METHODS;

/// The functions of two arguments that can be written.
pub(crate) const BINARIES: &[Binary] = Binary::METHODS;

/// A way to create an expression from earlier ones. Indices wrap around.
#[derive(Clone, Debug)]
pub(crate) enum Make {
    Constant(f64),
    Symbol(usize),
    Sum(f64, Vec<(f64, usize)>),
    Product(Vec<(usize, i32)>),
    Call(Function, usize),
    Call2(Binary, usize, usize),
    Opaque(usize),
}

impl Make {
    /// Returns the value by plain evaluation.
    pub(crate) fn evaluate<T: Number>(&self, made: &[T]) -> T {
        let pick = |i: usize| made[i % made.len()];
        match self {
            Self::Constant(c) => T::of(*c),
            Self::Symbol(i) | Self::Opaque(i) => pick(*i),
            Self::Sum(constant, terms) => {
                let term = |&(c, i): &(f64, usize)| match c {
                    1.0 => pick(i),
                    _ => pick(i).scale(c),
                };
                let terms = terms.iter().map(term);
                match *constant {
                    0.0 => terms.reduce(T::plus).unwrap_or(T::of(0.0)),
                    constant => terms.fold(T::of(constant), T::plus),
                }
            }
            Self::Product(factors) => {
                let factors = factors.iter().map(|&(i, k)| pick(i).power(k));
                factors.reduce(T::times).unwrap_or(T::of(1.0))
            }
            Self::Call(f, i) => pick(*i).call(*f),
            Self::Call2(f, i, j) => pick(*i).call2(*f, pick(*j)),
        }
    }

    /// Returns the expression.
    pub(crate) fn build(&self, made: &[Expr], arena: &mut Arena) -> Expr {
        let pick = |i: usize| made[i % made.len()];
        match self {
            Self::Constant(c) => arena.constant(*c),
            Self::Symbol(i) => pick(*i),
            Self::Opaque(i) => arena.opaque(pick(*i)),
            Self::Sum(constant, terms) => {
                let terms: Vec<_> = terms.iter().map(|&(c, i)| (c, pick(i))).collect();
                arena.sum(*constant, &terms)
            }
            Self::Product(factors) => {
                let factors: Vec<_> = factors.iter().map(|&(i, k)| (pick(i), k)).collect();
                arena.product(&factors)
            }
            Self::Call(f, i) => arena.call(*f, pick(*i)),
            Self::Call2(f, i, j) => arena.call2(*f, pick(*i), pick(*j)),
        }
    }
}

/// Returns the values of all entries; the variables come first.
pub(crate) fn evaluate<T: Number>(recipe: &[Make], at: &[T]) -> Vec<T> {
    let mut made = at.to_vec();
    for make in recipe {
        made.push(make.evaluate(&made));
    }
    made
}

/// Returns the expressions of all entries; the variables come first.
pub(crate) fn build(recipe: &[Make], variables: &[Symbol], arena: &mut Arena) -> Vec<Expr> {
    let mut made: Vec<Expr> = variables.iter().map(|&s| arena.symbol(s)).collect();
    for make in recipe {
        made.push(make.build(&made, arena));
    }
    made
}

/// Returns the values of expressions. Each node of the arena is evaluated without rewriting.
pub(crate) fn values<T: Number>(arena: &Arena, exprs: &[Expr], at: impl Fn(Symbol) -> T) -> Vec<T> {
    let nodes = arena.reachable(exprs, |_| true);
    let mut done = std::collections::HashMap::with_capacity(nodes.len());
    for e in nodes {
        let of = |x: &Expr| -> T { done[x] };
        let value = match arena.node(e) {
            Node::Constant(bits) => T::of(bits.get()),
            Node::Symbol(symbol) => at(*symbol),
            Node::Opaque(x, _) => of(x),
            Node::Sum(constant, terms) => {
                terms.iter().fold(T::of(constant.get()), |sum, (x, c)| {
                    sum.plus(of(x).scale(c.get()))
                })
            }
            Node::Product(factors) => factors
                .iter()
                .fold(T::of(1.0), |product, (x, k)| product.times(of(x).power(*k))),
            Node::Call(function, x) => of(x).call(*function),
            Node::Call2(function, x, y) => of(x).call2(*function, of(y)),
        };
        done.insert(e, value);
    }
    exprs.iter().map(|e| done[e]).collect()
}

/// Splitmix64 (Steele, Lea, Flood 2014): a fixed sequence for each seed.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }

    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.below(1 << 40) as f64 / (1_u64 << 40) as f64
    }

    /// Returns a random element of a list.
    pub(crate) fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }
}

/// Returns a random recipe of `length` entries whose values at a point are all moderate, so that
/// rounding and conditioning are harmless. Half of the operands are among the latest entries, so
/// the recipe is about as deep as long.
pub(crate) fn grow(random: &mut Random, at: &[f64], length: usize) -> Vec<Make> {
    let mut recipe: Vec<Make> = Vec::new();
    let mut made = at.to_vec();
    while recipe.len() < length {
        let make = entry(random, made.len());
        let value = make.evaluate(&made);
        if value.is_finite() && value.abs() < 10.0 && value.abs() > 0.05 {
            recipe.push(make);
            made.push(value);
        }
    }
    recipe
}

fn entry(random: &mut Random, len: usize) -> Make {
    let index = |random: &mut Random| match random.below(2) {
        0 => len - 1 - random.below(3.min(len)),
        _ => random.below(len),
    };
    let coefficients = [1.0, -1.0, 0.5, -0.25, 2.0, 1.5];
    match random.below(12) {
        0 => Make::Opaque(index(random)),
        1..=4 => {
            let constant = if random.below(2) == 0 {
                0.0
            } else {
                random.of(&coefficients)
            };
            let terms = (0..=random.below(3)).map(|_| (random.of(&coefficients), index(random)));
            Make::Sum(constant, terms.collect())
        }
        5..=7 => {
            let exponents = [1, 1, 2, -1, 3, -2];
            let factors = (0..=random.below(3)).map(|_| (index(random), random.of(&exponents)));
            Make::Product(factors.collect())
        }
        8..=10 => {
            let function = match random.below(8) {
                0 => Function::Powf(Bits::new(random.of(&[0.3, -0.7, 1.6]))),
                _ => random.of(FUNCTIONS),
            };
            Make::Call(function, index(random))
        }
        _ => Make::Call2(random.of(BINARIES), index(random), index(random)),
    }
}
