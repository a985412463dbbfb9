//! The names of subexpressions in formulas; `model/names.rs` has the names of symbols.

use std::collections::HashMap;

use crate::algebra::{self, Arena, Expr, Notation, Symbol};
use crate::catalogue::Rule;
use crate::model::{AtNode, END, NodeQuantity, SymbolNames, Symbols};
use crate::rules::{self, Discretisation};

/// Names of symbols and of subexpressions.
pub(super) struct Names<'a> {
    pub(super) symbols: SymbolNames<'a>,
    /// The rule, in the equations of a step.
    rule: Option<Box<dyn Discretisation>>,
    /// The names of parameters.
    parameters: Vec<String>,
    named: HashMap<Expr, String>,
    counts: HashMap<char, usize>,
    /// Given names, by the texts that they replace.
    given: HashMap<String, String>,
}

impl<'a> Names<'a> {
    pub(super) fn new(symbols: &'a Symbols, rule: Option<Rule>) -> Self {
        let rule = rule.map(rules::discretisation);
        let symbols = match &rule {
            Some(rule) => SymbolNames::of_step(symbols, rule.letters()),
            None => SymbolNames::of_system(symbols),
        };
        Self {
            parameters: symbols.parameters(),
            symbols,
            rule,
            named: HashMap::new(),
            counts: HashMap::new(),
            given: HashMap::new(),
        }
    }

    /// Gives an expression a name.
    pub(super) fn call(&mut self, expr: Expr, name: String) {
        self.named.entry(expr).or_insert(name);
    }

    /// Gives an expression, whose text is `text`, a new numbered name.
    pub(super) fn number(&mut self, expr: Expr, text: String, arena: &Arena) {
        if let Some(name) = self.given.get(&text) {
            self.named.insert(expr, name.clone());
            return;
        }
        let letter = match arena.node(expr) {
            algebra::Node::Call(function, _) => function.entry().letter,
            algebra::Node::Call2(..) => 'f',
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

    /// Gives an intermediate result of the step such as `q₀ + c d` its name. Other intermediate
    /// results have no name and are written out.
    pub(super) fn call_node(&mut self, expr: Expr, arena: &Arena) {
        let Some(rule) = &self.rule else { return };
        let Some(AtNode { node, quantity }) = AtNode::of(expr, arena) else {
            return;
        };
        let letter = match quantity {
            NodeQuantity::Time if node == END => "t₁",
            NodeQuantity::Position(_) if node == END => "q₁",
            _ => rule.point(node).name(quantity),
        };
        let name = match quantity {
            NodeQuantity::Time => letter.to_owned(),
            NodeQuantity::Position(i) => {
                let is_end = rule.point(node).is_end();
                let rotation = if is_end { "R₁" } else { "R̄" };
                self.symbols.entry(letter, rotation, i)
            }
            NodeQuantity::Velocity(i) => self.symbols.component(letter, i),
        };
        self.call(expr, name);
    }
}

impl Notation for Names<'_> {
    fn symbol(&self, symbol: Symbol) -> String {
        self.symbols.symbol(symbol)
    }

    fn place(&self, symbol: Symbol) -> u8 {
        self.symbols.place(symbol)
    }

    fn name(&self, expr: Expr) -> Option<&str> {
        self.named.get(&expr).map(String::as_str)
    }
}
