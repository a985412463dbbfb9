//! Formulas of a scene as text.

use super::{Comparison, Condition, Each, Head, Scene, SlotArray, SumId};
use crate::algebra::{Arena, Expr, Notation, Symbol};
use crate::model::{Meaning, SymbolNames};

/// Characters of a formula, beyond which its text is left out.
const LONGEST: usize = 600;

/// The names in formulas of a scene.
#[derive(Clone, Copy)]
pub(crate) struct SceneNames<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) arena: &'a Arena,
    /// The increments of functions with a process for each instance.
    pub(crate) each: &'a [Each],
}

impl SceneNames<'_> {
    pub(crate) fn formula(&self, expr: Expr) -> String {
        let text = self.arena.display(expr, LONGEST, self);
        text.map_or_else(|| "a long formula".to_owned(), |text| text.text)
    }

    /// Returns the index of a component; nothing for numbers.
    pub(crate) fn component(&self, component: usize) -> String {
        match self.scene.row.len() {
            1 => String::new(),
            _ => format!("[{component}]"),
        }
    }

    /// Returns the loops and conditions around the summand of a sum, the outermost first.
    pub(crate) fn loops(&self, sum: Option<SumId>) -> String {
        let heads = self
            .scene
            .heads(sum)
            .filter(|head| !self.scene.is_once(head));
        let heads = heads.map(|head| self.head(head));
        let mut heads: Vec<String> = heads.collect();
        heads.reverse();
        heads.join(", ")
    }

    fn head(&self, head: &Head) -> String {
        let integers = &self.scene.integers;
        match head {
            Head::For { counter, from, to } => {
                let [from, to] = [from, to].map(|bound| integers.text(*bound));
                format!("for {} in {from}..{to}", integers.name(*counter))
            }
            Head::If(condition) => format!("if {}", self.condition(condition)),
        }
    }

    fn condition(&self, condition: &Condition) -> String {
        let sign = |comparison| match comparison {
            Comparison::Equal => "==",
            Comparison::Less => "<",
            Comparison::LessOrEqual => "<=",
        };
        match condition {
            Condition::Integers(comparison, a, b) => {
                let [a, b] = [a, b].map(|int| self.scene.integers.text(*int));
                format!("{a} {} {b}", sign(*comparison))
            }
            Condition::Numbers(comparison, a, b) => {
                let [a, b] = [a, b].map(|expr| self.formula(*expr));
                format!("{a} {} {b}", sign(*comparison))
            }
            Condition::Not(inner) => format!("not ({})", self.condition(inner)),
            Condition::And(a, b) => {
                format!("({}) and ({})", self.condition(a), self.condition(b))
            }
            Condition::Or(a, b) => format!("({}) or ({})", self.condition(a), self.condition(b)),
        }
    }
}

impl Notation for SceneNames<'_> {
    fn symbol(&self, symbol: Symbol) -> String {
        let scene = self.scene;
        if let Some(slot) = scene.slot(symbol) {
            let component = match slot.array {
                SlotArray::Rounded(number) => return format!("round({})", self.formula(number)),
                SlotArray::Weight(number) => return format!("({})", self.formula(number)),
                SlotArray::Sum(number) => return format!("S{number}"),
                SlotArray::Configuration(_) | SlotArray::Velocity(_) | SlotArray::Momentum(_) => {
                    self.component(slot.component)
                }
                SlotArray::Field(_) | SlotArray::Number(_) => String::new(),
            };
            return format!("{}{component}", scene.text(slot));
        }
        if let Meaning::Sum(sum) = scene.symbols.meaning(symbol) {
            let sum = &scene.sums[*sum];
            return format!("(Σ {} {})", self.formula(sum.summand), self.head(&sum.head));
        }
        match self.each.iter().find(|each| each.increment == symbol) {
            Some(_) => "ΔW".to_owned(),
            None => SymbolNames::of_system(&scene.symbols).symbol(symbol),
        }
    }

    fn place(&self, symbol: Symbol) -> u8 {
        SymbolNames::of_system(&self.scene.symbols).place(symbol)
    }

    fn name(&self, _: Expr) -> Option<&str> {
        None
    }
}
