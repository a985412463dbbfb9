//! A scene as text: its summands and the impulses that they give, each with its loops.

use crate::algebra::{Arena, Expr, Notation, Symbol};
use crate::catalogue::{Nodes, Rule};
use crate::model::SymbolNames;
use crate::model::scene::{Comparison, Condition, Head, Processes, SlotArray, SumId};
use crate::scene::Derived;

/// Characters of a formula, beyond which its text is left out.
const LONGEST: usize = 600;

/// The texts about a scene.
pub(crate) struct SceneTexts {
    /// L, summand by summand, and the noises.
    pub(crate) system: String,
    pub(crate) motion: String,
    /// The impulses of the sites.
    sweep: Vec<String>,
}

/// Prints a scene.
pub(crate) fn scene(derived: &Derived, arena: &Arena) -> SceneTexts {
    let writer = Writer { derived, arena };
    let noises = derived.scene.noises.iter().map(|noise| {
        let processes = match &noise.processes {
            Processes::Listed(list) if list.len() == 1 => "one process".to_owned(),
            Processes::Listed(list) => format!("{} processes", list.len()),
            Processes::Each(sum) => format!("a process {}", writer.loops(Some(*sum))),
        };
        format!("γ {}: {processes}", noise.name)
    });
    let summands = derived.lagrangian.iter().map(|summand| {
        let (value, loops) = (writer.formula(summand.value), writer.loops(summand.sum));
        format!("L += {value} {loops}")
    });
    SceneTexts {
        system: summands.chain(noises).collect::<Vec<_>>().join("\n"),
        motion: "dq = M⁻¹ p dt\ndp = ∂L/∂q dt + Σ ∂γ/∂q ∘ dW".to_owned(),
        sweep: writer.sweep(),
    }
}

impl SceneTexts {
    /// Returns the discrete action and the step of a rule.
    pub(crate) fn step(&self, rule: Rule) -> [String; 2] {
        let (nodes, start, end) = match rule.nodes {
            Nodes::One { c: 0.0 } => ("L(t₀, q₀, v)", Some(""), None),
            Nodes::Ends => ("(L(t₀, q₀, v) + L(t₁, q₁, v))/2", Some("½ "), Some("½ ")),
            _ => ("L(t₁, q₁, v)", None, Some("")),
        };
        let noises = nodes.replace(", v)", ")").replace('L', "γ");
        let action = format!("S_d = h {nodes} + ⟨p, q₁ − q₀ − h v⟩ + Σ {noises} ΔW");
        let kick = |part: &str, at: &str| format!("kick: p += {part}I({at}), a sweep at {at}");
        let mut step = Vec::new();
        step.extend(start.map(|part| kick(part, "q₀")));
        step.push("drift: q₁ = q₀ + h M⁻¹ p".to_owned());
        step.extend(end.map(|part| kick(part, "q₁")));
        step.push("all in place, with the impulses I = h ∂L/∂q + Σ ∂γ/∂q ΔW:".to_owned());
        step.extend(self.sweep.iter().cloned());
        [action, step.join("\n")]
    }
}

struct Writer<'a> {
    derived: &'a Derived,
    arena: &'a Arena,
}

impl Writer<'_> {
    fn formula(&self, expr: Expr) -> String {
        let text = self.arena.display(expr, LONGEST, self);
        text.map_or_else(|| "a long formula".to_owned(), |text| text.text)
    }

    /// Returns the impulse of each site of each term.
    fn sweep(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let scene = &self.derived.scene;
        for term in &self.derived.terms {
            let loops = self.loops(term.sum);
            for (&site, impulses) in term.sites.iter().zip(&term.impulses) {
                for (component, &impulse) in impulses.iter().enumerate() {
                    let index = scene.integers.text(site);
                    let component = self.component(component);
                    let impulse = self.formula(impulse);
                    lines.push(format!("I[{index}]{component} += {impulse} {loops}"));
                }
            }
        }
        lines
    }

    /// Returns the index of a component; nothing for numbers.
    fn component(&self, component: usize) -> String {
        match self.derived.scene.row.len() {
            1 => String::new(),
            _ => format!("[{component}]"),
        }
    }

    /// Returns the loops and conditions around the summand of a sum, the outermost first.
    fn loops(&self, sum: Option<SumId>) -> String {
        let scene = &self.derived.scene;
        let heads = scene.heads(sum).map(|head| match head {
            Head::For { counter, from, to } => {
                let [from, to] = [from, to].map(|bound| scene.integers.text(*bound));
                format!("for {} in {from}..{to}", scene.integers.name(*counter))
            }
            Head::If(condition) => format!("if {}", self.condition(condition)),
        });
        let mut heads: Vec<String> = heads.collect();
        heads.reverse();
        heads.join(", ")
    }

    fn condition(&self, condition: &Condition) -> String {
        let sign = |comparison| match comparison {
            Comparison::Equal => "==",
            Comparison::Less => "<",
            Comparison::LessOrEqual => "<=",
        };
        match condition {
            Condition::Integers(comparison, a, b) => {
                let [a, b] = [a, b].map(|int| self.derived.scene.integers.text(*int));
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

impl Notation for Writer<'_> {
    fn symbol(&self, symbol: Symbol) -> String {
        let scene = &self.derived.scene;
        if let Some(slot) = scene.slot(symbol) {
            let component = match slot.array {
                SlotArray::Configuration(_) | SlotArray::Velocity(_) => {
                    self.component(slot.component)
                }
                SlotArray::Field(_) | SlotArray::Number(_) => String::new(),
            };
            return format!("{}{component}", scene.text(slot));
        }
        let is_increment = |each: &&(Symbol, SumId)| each.0 == symbol;
        match self.derived.each.iter().find(is_increment) {
            Some(_) => "ΔW".to_owned(),
            None => SymbolNames::of_system(&scene.symbols).symbol(symbol),
        }
    }

    fn place(&self, symbol: Symbol) -> u8 {
        SymbolNames::of_system(&self.derived.scene.symbols).place(symbol)
    }

    fn name(&self, _: Expr) -> Option<&str> {
        None
    }
}
