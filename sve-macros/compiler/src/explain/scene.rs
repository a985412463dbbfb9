//! A scene as text: its summands and the impulses that they give, each with its loops.

use std::fmt::Write as _;

use crate::algebra::{Arena, Expr, Notation, Symbol};
use crate::catalogue::{Nodes, Rule};
use crate::model::SymbolNames;
use crate::model::scene::{Comparison, Condition, Head, Processes, SlotArray, SumId};
use crate::scene::{Derived, Summand, is_implicit};

/// Characters of a formula, beyond which its text is left out.
const LONGEST: usize = 600;

/// The texts about a scene.
pub(crate) struct SceneTexts {
    /// L, summand by summand, and the noises.
    pub(crate) system: String,
    pub(crate) motion: String,
    /// The impulses of the sites.
    sweep: Vec<String>,
    /// The friction of the sites.
    friction: Vec<String>,
    has_forces: bool,
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
    let summands = |name: String, list: &[Summand]| {
        let lines = list.iter().map(|summand| {
            let (value, loops) = (writer.formula(summand.value), writer.loops(summand.sum));
            format!("{name} += {value} {loops}")
        });
        lines.collect::<Vec<_>>()
    };
    let totals = derived.totals.iter();
    let totals = totals.flat_map(|total| summands(writer.symbol(total.symbol), &total.summands));
    let inner = derived
        .scene
        .slots
        .iter()
        .filter_map(|slot| match slot.array {
            SlotArray::Sum(sum) => Some(summands(
                format!("S{}", sum.0),
                derived.inner.summands_of(sum),
            )),
            _ => None,
        });
    let forces = derived.scene.forces.iter();
    let forces = forces.map(|force| format!("F {}: an entry for each site", force.name));
    let has_forces = !derived.scene.forces.is_empty();
    let force = if has_forces {
        "(∂L/∂q + F)"
    } else {
        "∂L/∂q"
    };
    SceneTexts {
        system: totals
            .chain(inner.flatten())
            .chain(summands("L".to_owned(), &derived.lagrangian))
            .chain(noises)
            .chain(forces)
            .collect::<Vec<_>>()
            .join("\n"),
        motion: format!("dq = M⁻¹ p dt\ndp = {force} dt + Σ ∂γ/∂q ∘ dW"),
        sweep: writer.sweep(),
        friction: writer.friction(),
        has_forces,
    }
}

impl SceneTexts {
    /// Returns all formulas of the system, by which stored states know it.
    pub(crate) fn formulas(&self) -> String {
        let lines = [&self.system]
            .into_iter()
            .chain(&self.sweep)
            .chain(&self.friction);
        lines.map(String::as_str).collect::<Vec<_>>().join("\n")
    }

    /// Returns the discrete action and the step of a rule.
    pub(crate) fn step(&self, rule: Rule) -> [String; 2] {
        if is_implicit(rule) {
            return self.implicit_step();
        }
        let (nodes, start, end) = match rule.nodes {
            Nodes::One { c: 0.0 } => ("L(t₀, q₀, v)", Some(""), None),
            Nodes::Ends => ("(L(t₀, q₀, v) + L(t₁, q₁, v))/2", Some("½ "), Some("½ ")),
            _ => ("L(t₁, q₁, v)", None, Some("")),
        };
        let noises = nodes.replace(", v)", ")").replace('L', "γ");
        let mut action = format!("S_d = h {nodes} + ⟨p, q₁ − q₀ − h v⟩ + Σ {noises} ΔW");
        if self.has_forces {
            let at = |part: Option<&str>, at| part.map(|part| format!("{part}h F({at}, v)·δ{at}"));
            let work: Vec<String> = at(start, "q₀").into_iter().chain(at(end, "q₁")).collect();
            write!(
                action,
                "\nwith the virtual work {} beside δS",
                work.join(" + ")
            )
            .ok();
        }
        let kick = |part: &str, at: &str| format!("kick: p += {part}I({at}), a sweep at {at}");
        let mut step = Vec::new();
        step.extend(start.map(|part| kick(part, "q₀")));
        let damped = |part: Option<&str>, how: [&str; 2]| {
            let part = part.filter(|_| !self.friction.is_empty());
            part.map(|part| format!("friction: p {} (1 {} {part}h N M⁻¹)", how[0], how[1]))
        };
        step.extend(damped(start, ["/=", "+"]));
        step.push("drift: q₁ = q₀ + h M⁻¹ p".to_owned());
        step.extend(damped(end, ["*=", "−"]));
        step.extend(end.map(|part| kick(part, "q₁")));
        step.push("all in place".to_owned());
        self.push_impulses(&mut step);
        [action, step.join("\n")]
    }

    /// Returns the discrete action and the step of the midpoint rule.
    fn implicit_step(&self) -> [String; 2] {
        let mut action =
            "S_d = h L(t̄, q̄, v) + ⟨p, q₁ − q₀ − h v⟩ + Σ γ(t̄, q̄) ΔW,  q̄ = (q₀ + q₁)/2".to_owned();
        if self.has_forces {
            action.push_str("\nwith the virtual work h F(q̄, v)·δq̄ beside δS");
        }
        let (mass, friction) = if self.friction.is_empty() {
            ("M", "")
        } else {
            ("(M + h N/2)", " − N d")
        };
        let mut step = vec![
            format!("solve: d = h {mass}⁻¹ (p₀ + I(q₀ + d/2)/2), sweeps of Chebyshev's iteration"),
            format!("end: q₁ = q₀ + d, p₁ = p₀ + I{friction}"),
            "the root is unique within boxes around the motion: Gershgorin's bounds of 1 − h M⁻¹ ∂I/∂q / 4 are positive there".to_owned(),
        ];
        self.push_impulses(&mut step);
        [action, step.join("\n")]
    }

    /// Adds the impulses of the sites.
    fn push_impulses(&self, step: &mut Vec<String>) {
        let force = if self.has_forces {
            "(∂L/∂q + F)"
        } else {
            "∂L/∂q"
        };
        let without = if self.friction.is_empty() {
            ""
        } else {
            ", F without the friction −N v"
        };
        step.push(format!(
            "the impulses are I = h {force} + Σ ∂γ/∂q ΔW{without}:"
        ));
        step.extend(self.sweep.iter().chain(&self.friction).cloned());
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
            for at in term.receivers(self.arena) {
                let (site, impulses) = (term.sites[at], &term.impulses[at]);
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

    /// Returns the friction of each component of a site.
    fn friction(&self) -> Vec<String> {
        let frictions = self.derived.frictions.iter();
        let lines = frictions.map(|friction| {
            let index = self.derived.scene.integers.text(friction.site);
            let component = self.component(friction.component);
            let (value, loops) = (self.formula(friction.value), self.loops(friction.sum));
            format!("N[{index}]{component} += {value} {loops}")
        });
        lines.collect()
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
                SlotArray::Rounded(number) => return format!("round({})", self.formula(number)),
                SlotArray::Weight(number) => return format!("({})", self.formula(number)),
                SlotArray::Sum(sum) => return format!("S{}", sum.0),
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
