//! How things are called in formulas; the notation is in `mod.rs`.

use std::collections::HashMap;

use crate::model::{Meaning, Quantity, Symbols};
use crate::rule::Rule;
use crate::symbolic::{Arena, Expr, Function, Node, Notation, Symbol};

/// Letters that have a meaning of their own.
const LETTERS: [&str; 6] = ["q", "v", "p", "t", "h", "L"];

/// Names of symbols and of subexpressions.
pub(super) struct Names<'a> {
    symbols: &'a Symbols,
    /// The rule, in the equations of a step.
    rule: Option<Rule>,
    /// What parameters are called; two of them never share a name.
    parameters: Vec<String>,
    named: HashMap<Expr, String>,
    counts: HashMap<char, usize>,
    /// Names that were given, by what they stand for.
    given: HashMap<String, String>,
}

impl<'a> Names<'a> {
    pub(super) fn new(symbols: &'a Symbols, rule: Option<Rule>) -> Self {
        let meanings = symbols.meanings().iter();
        let parameters = meanings
            .filter_map(|m| match m {
                Meaning::Parameter { access, .. } => Some(parameter(&access.to_string(), rule)),
                _ => None,
            })
            .collect();
        Self {
            symbols,
            rule,
            parameters,
            named: HashMap::new(),
            counts: HashMap::new(),
            given: HashMap::new(),
        }
    }

    /// Calls an expression by a name.
    pub(super) fn call(&mut self, expr: Expr, name: String) {
        self.named.entry(expr).or_insert(name);
    }

    /// Gives an expression, written `text`, a name of its own.
    pub(super) fn number(&mut self, expr: Expr, text: String, arena: &Arena) {
        if let Some(name) = self.given.get(&text) {
            self.named.insert(expr, name.clone());
            return;
        }
        let letter = match arena.node(expr) {
            Node::Call(Function::Sin, _) => 's',
            Node::Call(Function::Cos, _) => 'c',
            Node::Call(Function::Sqrt, _) => 'r',
            Node::Call(..) | Node::Call2(..) => 'f',
            _ => 'u',
        };
        let count = self.counts.entry(letter).or_default();
        loop {
            *count += 1;
            let name = format!("{letter}{count}");
            if !self.parameters.contains(&name) {
                self.named.insert(expr, name.clone());
                self.given.insert(text, name);
                return;
            }
        }
    }

    /// Calls an intermediate result of the step, `q₀ + c d` and the like, by its name; others have none and are written out.
    pub(super) fn call_node(&mut self, expr: Expr, arena: &Arena) {
        let Node::Opaque(content) = *arena.node(expr) else {
            return;
        };
        let Node::Sum(_, terms) = arena.node(content) else {
            return;
        };
        let symbols = terms
            .iter()
            .filter_map(|&(term, c)| match arena.node(term) {
                Node::Symbol(symbol) if c.get() == 1.0 => Some(*symbol),
                _ => None,
            });
        let name = symbols.into_iter().find_map(|s| self.node(s));
        if let Some(name) = name {
            self.call(expr, name);
        }
    }

    /// The node that a symbol of the start moves to.
    fn node(&self, start: Symbol) -> Option<String> {
        let rule = self.rule?;
        let (letter, i) = match self.symbols.meaning(start) {
            Meaning::Time if rule == Rule::Midpoint => return Some("t̄".to_owned()),
            Meaning::Time => return Some("t₁".to_owned()),
            Meaning::Start(Quantity::Position, i) => match rule {
                Rule::Midpoint => ("q̄", *i),
                Rule::Taylor2 => ("q̂", *i),
                Rule::Endpoint | Rule::InitialPoint => ("q₁", *i),
            },
            Meaning::Unknown(name) if rule == Rule::Taylor2 => match name.split_once('_') {
                Some(("v", i)) => ("v̂", i.parse().ok()?),
                _ => return None,
            },
            _ => return None,
        };
        Some(self.component(letter, i))
    }

    /// `q₀[i]`, or `q₀` where there is one coordinate.
    pub(super) fn component(&self, letter: &str, i: usize) -> String {
        component(letter, i, coordinates(self.symbols))
    }
}

/// What an unknown of a step is called.
pub(crate) fn unknown(symbols: &Symbols, symbol: Symbol) -> String {
    let name = symbols.name(symbol);
    let Some((base, Ok(i))) = name.rsplit_once('_').map(|(base, i)| (base, i.parse())) else {
        return name;
    };
    let letter = match base {
        "d" => "Δq",
        "mu" => "μ",
        "nu" => "ν",
        other => other,
    };
    component(letter, i, coordinates(symbols))
}

fn component(letter: &str, i: usize, of: usize) -> String {
    if of == 1 {
        letter.to_owned()
    } else {
        format!("{letter}[{i}]")
    }
}

fn coordinates(symbols: &Symbols) -> usize {
    let is_position = |m: &&Meaning| matches!(m, Meaning::Position(_));
    symbols.meanings().iter().filter(is_position).count()
}

fn processes(symbols: &Symbols) -> usize {
    let is_increment = |m: &&Meaning| matches!(m, Meaning::Wiener(_));
    symbols.meanings().iter().filter(is_increment).count()
}

/// A field as the user writes it, without `self.` where that is clear.
fn parameter(access: &str, rule: Option<Rule>) -> String {
    let path: String = access.split_whitespace().collect();
    let path = path.replace("r#", "");
    let Some(field) = path.strip_prefix("self.") else {
        return path;
    };
    let name = field.split(['.', '[']).next().unwrap_or(field);
    let taken = LETTERS.contains(&name) || (name == "a" && rule == Some(Rule::Taylor2));
    if taken || name.starts_with(|c: char| c.is_ascii_digit()) {
        path
    } else {
        field.to_owned()
    }
}

impl Notation for Names<'_> {
    fn symbol(&self, symbol: Symbol) -> String {
        match self.symbols.meaning(symbol) {
            Meaning::Parameter { access, .. } => parameter(&access.to_string(), self.rule),
            Meaning::Time if self.rule.is_some() => "t₀".to_owned(),
            Meaning::Time => "t".to_owned(),
            Meaning::StepSize => "h".to_owned(),
            Meaning::Position(i) => self.component("q", *i),
            Meaning::Velocity(i) => self.component("v", *i),
            Meaning::Momentum(i) => self.component("p", *i),
            Meaning::Start(Quantity::Position, i) => self.component("q₀", *i),
            Meaning::Start(Quantity::Momentum, i) => self.component("p₀", *i),
            Meaning::Wiener(i) => component("ΔW", *i, processes(self.symbols)),
            Meaning::Unknown(_) => unknown(self.symbols, symbol),
        }
    }

    fn place(&self, symbol: Symbol) -> u8 {
        match self.symbols.meaning(symbol) {
            Meaning::StepSize => 0,
            Meaning::Parameter { .. } => 1,
            Meaning::Wiener(_) => 2,
            _ => 3,
        }
    }

    fn name(&self, expr: Expr) -> Option<&str> {
        self.named.get(&expr).map(String::as_str)
    }
}
