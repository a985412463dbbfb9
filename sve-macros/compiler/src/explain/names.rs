//! How things are called in formulas; the notation is in `mod.rs`.

use std::collections::HashMap;

use crate::algebra::{self, Arena, Expr, Notation, Symbol};
use crate::rules::Rule;
use crate::rules::constraints::END;
use crate::system::configuration::{Block, Factor, RotationEntry};
use crate::system::model::{AtNode, Family, Meaning, NodeQuantity, Quantity, Symbols, Unknown};

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

    /// Calls an intermediate result of the step, `q₀ + c d` and the like, by its name; others have none and are written out.
    pub(super) fn call_node(&mut self, expr: Expr, arena: &Arena) {
        let Some(rule) = self.rule else { return };
        let Some(AtNode { node, quantity }) = AtNode::of(expr, arena) else {
            return;
        };
        let letter = match quantity {
            NodeQuantity::Time if node == END => "t₁",
            NodeQuantity::Position(_) if node == END => "q₁",
            _ => rule.notation(node, quantity),
        };
        let name = match quantity {
            NodeQuantity::Time => letter.to_owned(),
            NodeQuantity::Position(i) => self.entry(letter, "R̄", i),
            NodeQuantity::Velocity(i) => self.component(letter, i),
        };
        self.call(expr, name);
    }

    /// `q₀[i]`, or `q₀` where there is one coordinate; of a rotation `ω[i]`, `Π₀[i]` and the like.
    pub(super) fn component(&self, letter: &str, i: usize) -> String {
        component(letter, i, self.symbols)
    }

    /// `(Π × RᵀdR)[i]`, the change of a body momentum by the rotation of the body; `None` for the momentum of a vector.
    pub(super) fn transport(&self, i: usize) -> Option<String> {
        let blocks = self.symbols.configuration.blocks();
        let mut rotations = blocks.iter().filter(|b| b.factor == Factor::Rotation);
        rotations.find(|block| block.directions.contains(&i))?;
        let name = component("p", i, self.symbols);
        Some(name.replacen('Π', "(Π × RᵀdR)", 1))
    }

    /// `q₀[i]`, or the entry `R₀[row, column]` of a rotation.
    pub(super) fn entry(&self, letter: &str, rotation: &str, i: usize) -> String {
        match self.symbols.configuration.rotation_of(i) {
            Some(RotationEntry {
                number,
                row,
                column,
            }) => {
                let number = number.map_or(String::new(), |number| format!("[{number}]"));
                format!("{rotation}{number}[{row}, {column}]")
            }
            None => self.component(letter, i),
        }
    }
}

/// What an unknown of a step is called.
pub(crate) fn unknown(symbols: &Symbols, symbol: Symbol) -> String {
    let Meaning::Unknown(Unknown { family, index }) = *symbols.meaning(symbol) else {
        return symbols.name(symbol);
    };
    let letter = match family {
        Family::Displacement => "Δq",
        Family::Velocity => "v",
        Family::StageVelocity => "U",
        Family::Momentum => "p",
        Family::Acceleration => "a",
        Family::VelocityMultiplier | Family::EndMultiplier => "μ",
        Family::AccelerationMultiplier => "ν",
        Family::StartMultiplier | Family::Projection => "λ",
        Family::EndVelocity => "v₁",
        Family::NodeDisplacement => "Δq̄",
    };
    if family.is_multiplier_of_constraint() {
        return indexed(letter, index, multipliers(symbols, family));
    }
    component(letter, index, symbols)
}

/// A component in a direction: `v[i]`, or of a rotation `ω[i]`, with the letter for rotations in place of the letter for vectors.
fn component(letter: &str, i: usize, symbols: &Symbols) -> String {
    let blocks = symbols.configuration.blocks();
    let rotations = blocks
        .iter()
        .filter(|block| block.factor == Factor::Rotation);
    let rotations: Vec<&Block> = rotations.collect();
    if let Some(number) = rotations.iter().position(|b| b.directions.contains(&i)) {
        let letter = ROTATION.iter().find(|pair| pair.0 == letter);
        let letter = letter.map_or("x", |pair| pair.1);
        let at = i - rotations[number].directions.start;
        return match rotations.len() {
            1 => format!("{letter}[{at}]"),
            _ => format!("{letter}[{number}][{at}]"),
        };
    }
    let of = symbols.configuration.directions();
    indexed(letter, i, of)
}

/// Letters for vectors, and those of the same quantities for rotations.
const ROTATION: [(&str, &str); 7] = [
    ("dq", "(RᵀdR)"),
    ("v", "ω"),
    ("p", "Π"),
    ("p₀", "Π₀"),
    ("p₁", "Π₁"),
    ("dp", "dΠ"),
    ("Δq", "x"),
];

fn indexed(letter: &str, i: usize, of: usize) -> String {
    if of == 1 {
        letter.to_owned()
    } else {
        format!("{letter}[{i}]")
    }
}

/// The number of constraints, which is at least the number of the largest multiplier.
fn multipliers(symbols: &Symbols, of: Family) -> usize {
    let indices = symbols.meanings().iter().filter_map(|m| match m {
        Meaning::Unknown(Unknown { family, index }) if *family == of => Some(index + 1),
        _ => None,
    });
    indices.max().unwrap_or(1)
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
    let taken = LETTERS.contains(&name) || rule.is_some_and(|r| r.letters().contains(&name));
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
            Meaning::Position(i) => self.entry("q", "R", *i),
            Meaning::Velocity(i) => self.component("v", *i),
            Meaning::Momentum(i) => self.component("p", *i),
            Meaning::Start(Quantity::Position, i) => self.entry("q₀", "R₀", *i),
            Meaning::Start(Quantity::Momentum, i) => self.component("p₀", *i),
            Meaning::Wiener(i) => indexed("ΔW", *i, processes(self.symbols)),
            Meaning::NodeEntry(i) => self.entry("q̄", "R̄", *i),
            Meaning::Attitude(i) => format!("attitude[{i}]"),
            Meaning::Radius(_) => self.symbols.name(symbol),
            Meaning::End(i) => self.component("p₁", *i),
            Meaning::Unknown(_) | Meaning::Limit(_) => unknown(self.symbols, symbol),
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
