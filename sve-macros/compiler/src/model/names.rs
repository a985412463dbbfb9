//! Names of symbols in formulas for users. `explain/mod.rs` describes the notation.

use super::configuration::{Block, Factor, RotationEntry};
use super::{Family, Meaning, Quantity, Symbols, Unknown};
use crate::algebra::{Arena, Expr, Notation, Symbol};

/// Letters that have a meaning of their own.
const LETTERS: [&str; 6] = ["q", "v", "p", "t", "h", "L"];

/// The names of symbols in formulas.
pub(crate) struct SymbolNames<'a> {
    symbols: &'a Symbols,
    /// In the equations of a step, the letters of the rule's own variables. Parameters of the same
    /// name get other names.
    of_step: Option<&'static [&'static str]>,
}

impl<'a> SymbolNames<'a> {
    /// Returns the names in formulas of the system.
    pub(crate) fn of_system(symbols: &'a Symbols) -> Self {
        let of_step = None;
        Self { symbols, of_step }
    }

    /// Returns the names in the equations of a step. The rule has variables with these letters.
    pub(crate) fn of_step(symbols: &'a Symbols, letters: &'static [&'static str]) -> Self {
        let of_step = Some(letters);
        Self { symbols, of_step }
    }

    /// Returns the names of all parameters; two of them never share a name.
    pub(crate) fn parameters(&self) -> Vec<String> {
        let meanings = self.symbols.meanings().iter();
        let names = meanings.filter_map(|meaning| match meaning {
            Meaning::Parameter { access, .. } => Some(self.parameter(&access.to_string())),
            _ => None,
        });
        names.collect()
    }

    /// Returns a field as the user spells it, without `self.` if the name is unambiguous.
    fn parameter(&self, access: &str) -> String {
        let path: String = access.split_whitespace().collect();
        let path = path.replace("r#", "");
        let Some(field) = path.strip_prefix("self.") else {
            return path;
        };
        let name = field.split(['.', '[']).next().unwrap_or(field);
        let taken =
            LETTERS.contains(&name) || self.of_step.is_some_and(|letters| letters.contains(&name));
        if taken || name.starts_with(|c: char| c.is_ascii_digit()) {
            path
        } else {
            field.to_owned()
        }
    }

    /// Returns `q₀[i]`, or `q₀` if there is one coordinate; for a rotation `ω[i]`, `Π₀[i]` and
    /// similar names.
    pub(crate) fn component(&self, letter: &str, i: usize) -> String {
        component(letter, i, self.symbols)
    }

    /// Returns `(Π × RᵀdR)[i]`, the change of a body momentum by the rotation of the body; `None`
    /// for the momentum of a vector.
    pub(crate) fn transport(&self, i: usize) -> Option<String> {
        let blocks = self.symbols.configuration.blocks();
        let mut rotations = blocks.iter().filter(|b| b.factor == Factor::Rotation);
        rotations.find(|block| block.directions.contains(&i))?;
        let name = component("p", i, self.symbols);
        Some(name.replacen('Π', "(Π × RᵀdR)", 1))
    }

    /// Returns `q₀[i]`, or the entry `R₀[row, column]` of a rotation.
    pub(crate) fn entry(&self, letter: &str, rotation: &str, i: usize) -> String {
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

impl Symbols {
    /// Returns a formula of the system, if it is no longer than `limit`.
    pub(crate) fn formula(&self, expr: Expr, limit: usize, arena: &Arena) -> Option<String> {
        let text = arena.display(expr, limit, &SymbolNames::of_system(self))?;
        Some(text.text)
    }
}

/// Returns the name of an unknown of a step in formulas.
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

/// Returns a component in a direction: `v[i]`, or `ω[i]` for a rotation, with the letter for
/// rotations in place of the letter for vectors.
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

/// Letters for vectors, and the letters of the same quantities for rotations.
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

/// Returns the number of constraints, which is at least the number of the largest multiplier.
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

impl Notation for SymbolNames<'_> {
    fn symbol(&self, symbol: Symbol) -> String {
        match self.symbols.meaning(symbol) {
            Meaning::Parameter { name, .. } if self.symbols.energy == Some(symbol) => name.clone(),
            Meaning::Parameter { access, .. } => self.parameter(&access.to_string()),
            Meaning::Time if self.of_step.is_some() => "t₀".to_owned(),
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
            Meaning::Radius(_)
            | Meaning::Sum(_)
            | Meaning::Slot(_)
            | Meaning::Read(_)
            | Meaning::Partial => self.symbols.name(symbol),
            Meaning::Total(i) => format!("S[{i}]"),
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

    fn name(&self, _: Expr) -> Option<&str> {
        None
    }
}
