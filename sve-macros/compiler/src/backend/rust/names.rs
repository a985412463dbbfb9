//! Names of temporaries: by what a value is, where that is known, otherwise by its operation with a number.
//!
//! Input: a program and the labels of some of its values. Output: a name for each value. Invariant: no two names that are in
//! scope together are equal, and none is that of an input or of a variable that emitted code declares otherwise.

use std::collections::{HashMap, HashSet};

use proc_macro2::{Ident, Span};

use crate::algebra::{self, Arena, Expr, Function, Symbol};
use crate::program::{Operation, Program, Scheduler, Tier, Value};
use crate::rules::action::{Node, node};
use crate::system::model::{Meaning, Quantity, Symbols};

/// Variables of emitted code that are no values of the program.
const DECLARED: [&str; 31] = [
    "q",
    "v",
    "p",
    "h",
    "t",
    "dw",
    "dq",
    "dv",
    "dp",
    "dqt",
    "dvt",
    "time",
    "state",
    "value",
    "newton",
    "prepared",
    "states",
    "kept",
    "lane",
    "any",
    "next",
    "q_lane",
    "p_lane",
    "guess",
    "origin",
    "refinement",
    "fallback",
    "rounding",
    "unknowns",
    "rhs",
    "solution",
];

/// Longest name of an angle or argument.
const WORD: usize = 40;

/// What values are, as far as it is known.
#[derive(Default)]
pub(super) struct Labels {
    values: HashMap<Value, String>,
    /// Angles of pairs of sine and cosine.
    pairs: HashMap<Value, String>,
}

impl Labels {
    /// Calls a value; the first name stays.
    pub(super) fn call(&mut self, value: Value, name: String) {
        self.values.entry(value).or_insert(name);
    }

    /// Calls the values of a vector `name_0`, `name_1`, …, counted from `first`.
    pub(super) fn vector(&mut self, name: &str, first: usize, values: &[Value]) {
        for (i, &value) in values.iter().enumerate() {
            self.call(value, format!("{name}_{}", first + i));
        }
    }

    /// Calls the entries of a matrix `name_0_1`, rows and columns counted from `first`.
    pub(super) fn matrix(&mut self, name: &str, first: usize, rows: &[Vec<Value>]) {
        for (i, row) in rows.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                self.call(value, format!("{name}_{}_{}", first + i, first + j));
            }
        }
    }

    /// Calls the entries of a matrix that is applied to the state `map_0_1`, rows and columns in the order q, p.
    pub(super) fn map(
        &mut self,
        scheduler: &Scheduler<'_>,
        arena: &Arena,
        symbols: &Symbols,
        rows: &[Expr],
    ) {
        let column = |e: Expr| match arena.node(e) {
            algebra::Node::Symbol(symbol) => match symbols.meaning(*symbol) {
                Meaning::Start(Quantity::Position, j) => Some(*j),
                Meaning::Start(Quantity::Momentum, j) => Some(rows.len() / 2 + j),
                _ => None,
            },
            _ => None,
        };
        for (i, &row) in rows.iter().enumerate() {
            for term in arena.operands_of(row) {
                if let algebra::Node::Product(factors) = arena.node(term)
                    && let [(a, 1), (b, 1)] = factors.as_slice()
                    && let (Some(j), entry) = match column(*a) {
                        Some(j) => (Some(j), *b),
                        None => (column(*b), *a),
                    }
                    && let Some(value) = scheduler.known(entry)
                {
                    self.call(value, format!("map_{i}_{j}"));
                    // sums take negations in
                    if let Operation::Neg(opposite) = scheduler.operation(value) {
                        self.call(opposite, format!("minus_map_{i}_{j}"));
                    }
                }
            }
        }
    }

    /// Calls nodes, given expressions and functions of them by their names, of all that `roots` are made of.
    pub(super) fn expressions(
        &mut self,
        scheduler: &Scheduler<'_>,
        arena: &Arena,
        symbols: &Symbols,
        given: &[(Expr, String)],
        roots: &[Expr],
    ) {
        let words = Words {
            arena,
            symbols,
            given,
        };
        for e in arena.reachable(roots, |_| true) {
            let Some(value) = scheduler.known(e) else {
                continue;
            };
            match *arena.node(e) {
                algebra::Node::Opaque(_) => {
                    if let Some(word) = words.named(e) {
                        self.call(value, word);
                    }
                }
                algebra::Node::Call(function, x) => {
                    if let Some(word) = words.of(x) {
                        match scheduler.operation(value) {
                            Operation::SinOf(pair) | Operation::CosOf(pair) => {
                                self.pairs.entry(pair).or_insert(word);
                            }
                            _ => self.call(value, format!("{}_{word}", function.name())),
                        }
                    }
                }
                _ => {}
            }
        }
    }
}

/// Words for expressions that are short to say.
struct Words<'a> {
    arena: &'a Arena,
    symbols: &'a Symbols,
    given: &'a [(Expr, String)],
}

impl Words<'_> {
    /// Given names, and `q_node_0` for a node.
    fn named(&self, expr: Expr) -> Option<String> {
        if let Some((_, name)) = self.given.iter().find(|g| g.0 == expr) {
            return Some(name.clone());
        }
        match node(expr, self.symbols, self.arena)? {
            Node::Time => Some("t_node".to_owned()),
            Node::Position(i) => Some(format!("q_node_{i}")),
            Node::Velocity(i) => Some(format!("v_node_{i}")),
        }
    }

    /// A symbol, a name, or `a_minus_b`.
    fn of(&self, expr: Expr) -> Option<String> {
        let word = match self.arena.node(expr) {
            algebra::Node::Sum(constant, terms) if constant.get() == 0.0 => {
                match terms.as_slice() {
                    [(a, c), (b, d)] if c.get() == 1.0 && d.get().abs() == 1.0 => {
                        let between = if d.get() < 0.0 { "minus" } else { "plus" };
                        format!("{}_{between}_{}", self.word(*a)?, self.word(*b)?)
                    }
                    _ => return None,
                }
            }
            _ => self.word(expr)?,
        };
        (word.len() <= WORD).then_some(word)
    }

    fn word(&self, expr: Expr) -> Option<String> {
        match self.arena.node(expr) {
            algebra::Node::Symbol(symbol) => Some(input_name(self.symbols, *symbol).to_string()),
            algebra::Node::Opaque(_) => self.named(expr),
            _ => None,
        }
    }
}

/// The name of a symbol in generated code; fields of the user's struct cannot clash with anything else.
pub(super) fn input_name(symbols: &Symbols, symbol: Symbol) -> Ident {
    match symbols.meaning(symbol) {
        Meaning::Parameter { name, .. } => local(&format!("self_{name}")),
        _ => local(&symbols.name(symbol)),
    }
}

pub(super) fn local(name: &str) -> Ident {
    Ident::new(name, Span::call_site())
}

/// A name for each value that has a statement; for a pair of sine and cosine, of its angle.
pub(super) struct Names(HashMap<Value, String>);

impl Names {
    pub(super) fn new(program: &Program, symbols: &Symbols, labels: &Labels) -> Self {
        let mut scope = Scope::new(program, symbols);
        let mut names: HashMap<Value, String> = HashMap::new();
        for (value, instruction) in program.in_order() {
            scope.enter(instruction.tier);
            let known = |v: Value| match program.get(v).operation {
                Operation::Input(symbol) => Some(input_name(symbols, symbol).to_string()),
                _ => labels.values.get(&v).cloned(),
            };
            let number = value.index();
            let wanted = match instruction.operation {
                Operation::Input(_)
                | Operation::Constant(_)
                | Operation::SinOf(_)
                | Operation::CosOf(_) => continue,
                Operation::SinCos(_) | Operation::Turn(..) => {
                    let angle = match (labels.pairs.get(&value), instruction.operation) {
                        (Some(word), _) => Some(word.clone()),
                        (None, Operation::SinCos(angle)) => known(angle),
                        _ => None,
                    };
                    let angle = angle.unwrap_or_else(|| number.to_string());
                    let parts = |angle: &str| [format!("sin_{angle}"), format!("cos_{angle}")];
                    names.insert(value, scope.free(angle, number, parts));
                    continue;
                }
                operation => match labels.values.get(&value) {
                    Some(label) => label.clone(),
                    None => match operation {
                        Operation::Mul(a, b) if a == b && known(a).is_some() => {
                            format!("{}_squared", known(a).unwrap_or_default())
                        }
                        Operation::Call(function, a) if !matches!(function, Function::Powf(_)) => {
                            let argument = known(a).unwrap_or_else(|| number.to_string());
                            format!("{}_{argument}", function.name())
                        }
                        _ => format!("{}_{number}", prefix(operation)),
                    },
                },
            };
            names.insert(value, scope.free(wanted, number, |name| [name.to_owned()]));
        }
        Self(names)
    }

    pub(super) fn of(&self, value: Value) -> Ident {
        match self.0.get(&value) {
            Some(name) => local(name),
            None => local(&format!("value_{}", value.index())),
        }
    }

    /// The names of sine and cosine of a pair.
    pub(super) fn pair(&self, both: Value) -> [Ident; 2] {
        let angle = self.0.get(&both).cloned();
        let angle = angle.unwrap_or_else(|| both.index().to_string());
        ["sin", "cos"].map(|part| local(&format!("{part}_{angle}")))
    }
}

fn prefix(operation: Operation) -> &'static str {
    match operation {
        Operation::Add(..) | Operation::Sub(..) => "sum",
        Operation::Mul(..) => "product",
        Operation::Div(..) => "ratio",
        Operation::Neg(_) => "minus",
        Operation::Abs(_) => "size",
        Operation::Recip(_) => "inverse",
        Operation::Call(function, _) => function.name(),
        Operation::Call2(function, ..) => function.name(),
        _ => "value",
    }
}

/// Names that are taken. Those of a guess and of an iteration are in a block of their own.
struct Scope {
    tier: Tier,
    outer: HashSet<String>,
    inner: HashSet<String>,
}

impl Scope {
    fn new(program: &Program, symbols: &Symbols) -> Self {
        let inputs = program.all().filter_map(|(_, i)| match i.operation {
            Operation::Input(symbol) => Some(input_name(symbols, symbol).to_string()),
            _ => None,
        });
        let declared = DECLARED.map(ToOwned::to_owned);
        Self {
            tier: Tier::Prepare,
            outer: inputs.chain(declared).collect(),
            inner: HashSet::new(),
        }
    }

    fn enter(&mut self, tier: Tier) {
        if tier != self.tier {
            self.tier = tier;
            self.inner.clear();
        }
    }

    /// A name whose parts are all free, which they are not afterwards.
    fn free<const N: usize>(
        &mut self,
        wanted: String,
        number: usize,
        parts: impl Fn(&str) -> [String; N],
    ) -> String {
        let taken = |name: &String| self.outer.contains(name) || self.inner.contains(name);
        let mut name = wanted;
        if parts(&name).iter().any(taken) {
            name = format!("{name}_{number}");
        }
        while parts(&name).iter().any(taken) {
            name.push('_');
        }
        let scope = match self.tier {
            Tier::Guess(_) | Tier::Iterate(_) => &mut self.inner,
            _ => &mut self.outer,
        };
        scope.extend(parts(&name));
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Tiers;
    use crate::system::model::{Family, Unknown};

    /// Names of `x + h` with x known before a step, in the iteration of a block and after it, each labelled alike.
    #[test]
    fn names_in_scope_together_differ() {
        let (mut arena, mut symbols, mut tiers) = (Arena::new(), Symbols::default(), Tiers::new());
        let step = symbols.declare(Meaning::StepSize);
        let h = arena.symbol(step);
        let places = [
            Tier::State,
            Tier::State,
            Tier::Iterate(0),
            Tier::Iterate(0),
            Tier::Solved(0),
            Tier::Iterate(1),
        ];
        let mut roots = Vec::new();
        for (i, tier) in places.into_iter().enumerate() {
            let symbol = symbols.declare(Unknown::of(Family::Displacement)(i));
            tiers.insert(symbol, tier);
            let x = arena.symbol(symbol);
            roots.push(arena.add(x, h));
        }
        let last = arena.call(Function::Exp, roots[0]);
        roots.push(last);
        let mut scheduler = Scheduler::new(&arena, &symbols, tiers, &roots);
        let values = scheduler.values(&roots);
        let program = scheduler.finish(&values);
        let all_named = |names: [&str; 7]| {
            let mut labels = Labels::default();
            for (&value, name) in values.iter().zip(names) {
                labels.call(value, name.to_owned());
            }
            let names = Names::new(&program, &symbols, &labels);
            values
                .iter()
                .map(|&v| names.of(v).to_string())
                .collect::<Vec<_>>()
        };

        let found = all_named(["a", "a", "b", "b", "b", "b", "c"]);
        assert_eq!(found[0], "a");
        assert_ne!(found[1], "a");
        assert_eq!(found[2], "b");
        assert_ne!(found[3], "b");
        // those of an iteration are out of scope after it
        assert_eq!(found[4], "b");
        assert_ne!(found[5], "b");
        // what is known before an iteration is in scope in it
        assert_ne!(all_named(["a", "b", "a", "c", "d", "e", "f"])[2], "a");
        // inputs and variables of emitted code
        for taken in ["d_3", "h", "state", "guess"] {
            assert_ne!(all_named([taken, "b", "a", "c", "d", "e", "f"])[0], taken);
        }
    }
}
