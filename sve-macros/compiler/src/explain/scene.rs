//! A scene as text: its summands and the impulses that they give, each with its loops.

mod midpoint;

use std::fmt::Write as _;

use super::symmetry_caveat;
use crate::algebra::{Arena, Notation};
use crate::catalogue::{Nodes, Rule};
use crate::model::scene::{Processes, SceneNames, SceneNoise};
use crate::scene::{Derived, Kinetic, Summand, Term, is_implicit};

const CHEBYSHEV: &str = "Chebyshev";
const PIECEWISE: &str = "only piecewise smooth: it jumps or bends where a condition on numbers changes, or a rounded number";

/// The texts about a scene.
#[allow(clippy::struct_excessive_bools)] // properties that do not depend on one another
pub(crate) struct SceneTexts {
    /// L, summand by summand, and the noises.
    system: String,
    /// The conserved momenta, each with its name.
    momenta: Vec<(String, String)>,
    pub(crate) motion: String,
    /// The impulses of the sites.
    sweep: Vec<String>,
    /// The friction of the sites.
    friction: Vec<String>,
    /// The impulses of other forces of velocities, and the impulses and displacements by all H₁.
    in_drifts: [Vec<String>; 3],
    /// Whose iteration solves a step of the midpoint rule.
    iteration: &'static str,
    is_piecewise: bool,
    has_masses: bool,
    has_gamma: bool,
    has_forces: bool,
    has_noise_forces: bool,
}

/// Returns the number of processes of a noise.
fn of_noise(noise: &SceneNoise, names: &SceneNames<'_>) -> String {
    let processes = match &noise.processes {
        Processes::Listed(list) if list.len() == 1 => "one process".to_owned(),
        Processes::Listed(list) => format!("{} processes", list.len()),
        Processes::Each(sums) => {
            let number = match sums.len() {
                1 => "a process".to_owned(),
                n => format!("{n} processes"),
            };
            format!("{number} {}", names.loops(sums.first().copied()))
        }
    };
    let letter = if noise.is_h1 { "H₁" } else { "γ" };
    format!("{letter} {}: {processes}", noise.name)
}

/// Prints a scene.
pub(crate) fn scene(derived: &Derived, arena: &Arena) -> SceneTexts {
    let names = SceneNames {
        scene: &derived.scene,
        arena,
        each: &derived.each,
    };
    let has_force = |is_noise| {
        let mut forces = derived.scene.forces.iter();
        forces.any(|force| force.is_noise == is_noise)
    };
    let has_gamma = derived.scene.noises.iter().any(|noise| !noise.is_h1);
    let [has_forces, has_noise_forces] = [false, true].map(has_force);
    SceneTexts {
        system: system(derived, &names),
        momenta: momenta(derived, &names),
        motion: motion(derived, [has_gamma, has_forces, has_noise_forces]),
        sweep: sweep(&derived.terms, "I", names),
        friction: friction(derived, names),
        in_drifts: [
            sweep(&derived.drags, "D", names),
            sweep(&derived.h1[0], "K", names),
            sweep(&derived.h1[1], "X", names),
        ],
        iteration: if derived.is_symmetric() {
            CHEBYSHEV
        } else {
            "Richardson"
        },
        is_piecewise: derived.scene.is_piecewise(arena),
        has_masses: has_masses(derived),
        has_gamma,
        has_forces,
        has_noise_forces,
    }
}

/// Returns whether the momenta of sites are multiples of their velocities.
fn has_masses(derived: &Derived) -> bool {
    matches!(derived.kinetic, Kinetic::Masses(_))
}

/// Prints a line for each summand of a sum.
fn summands(name: &str, list: &[Summand], names: &SceneNames<'_>) -> Vec<String> {
    let lines = list.iter().map(|summand| {
        let (value, loops) = (names.formula(summand.value), names.loops(summand.sum));
        format!("{name} += {value} {loops}").trim_end().to_owned()
    });
    lines.collect()
}

/// Prints the sums, L, the noises and the forces.
fn system(derived: &Derived, names: &SceneNames<'_>) -> String {
    let totals = derived.totals.iter();
    let totals =
        totals.flat_map(|total| summands(&names.symbol(total.symbol), &total.summands, names));
    let inner = derived.inner.all.iter().enumerate();
    let inner = inner.flat_map(|(number, (_, list))| summands(&format!("S{number}"), list, names));
    let noises = derived.scene.noises.iter();
    let forces = derived.scene.forces.iter().map(|force| {
        let letter = if force.is_noise {
            "f, of a process,"
        } else {
            "F"
        };
        format!("{letter} {}: an entry for each site", force.name)
    });
    let lines = totals
        .chain(inner)
        .chain(summands("L", &derived.lagrangian, names))
        .chain(noises.map(|noise| of_noise(noise, names)))
        .chain(forces);
    lines.collect::<Vec<_>>().join("\n")
}

/// Prints the momenta of symmetries, each with its name.
fn momenta(derived: &Derived, names: &SceneNames<'_>) -> Vec<(String, String)> {
    let momenta = derived.momenta.iter().map(|momentum| {
        let name = &momentum.name;
        let mut lines = summands(
            &format!("conserved {name}_momentum"),
            &momentum.summands,
            names,
        );
        let caveat = symmetry_caveat(momentum.evidence);
        lines.extend(caveat.map(|caveat| format!("the symmetry {name} is {caveat}")));
        (name.clone(), lines.join("\n"))
    });
    momenta.collect()
}

/// Prints the equations of motion.
fn motion(derived: &Derived, [has_gamma, has_forces, has_noise_forces]: [bool; 3]) -> String {
    let text = |is_there, text| if is_there { text } else { "" };
    let has_h1 = derived.scene.noises.iter().any(|noise| noise.is_h1);
    let gamma = text(has_gamma, " + Σ ∂γ/∂q ∘ dW");
    let noise_force = text(has_noise_forces, " + Σ f ∘ dW");
    let [shift, kick] = [" + Σ ∂H₁/∂p ∘ dW", " − Σ ∂H₁/∂q ∘ dW"].map(|h1| text(has_h1, h1));
    let force = if has_forces {
        "(∂L/∂q + F)"
    } else {
        "∂L/∂q"
    };
    let [velocity, separator] = if has_masses(derived) {
        ["dq = M⁻¹ p dt", "\n"]
    } else {
        ["dq = v dt", "\np = ∂L/∂v(v)\n"]
    };
    format!("{velocity}{shift}{separator}dp = {force} dt{gamma}{kick}{noise_force}")
}

impl SceneTexts {
    /// Returns L, the noises, the forces, whether they are smooth, and the conserved momenta.
    pub(crate) fn system(&self) -> String {
        let momenta = self.momenta.iter().map(|(_, text)| text.as_str());
        let lines = [self.system.as_str()].into_iter();
        let lines = lines.chain(self.is_piecewise.then_some(PIECEWISE));
        lines.chain(momenta).collect::<Vec<_>>().join("\n")
    }

    /// Returns the momentum of a symmetry.
    pub(crate) fn momentum(&self, symmetry: &str) -> &str {
        let mut momenta = self.momenta.iter();
        momenta
            .find(|momentum| momentum.0 == symmetry)
            .map_or("", |momentum| &momentum.1)
    }

    /// Returns all formulas of the motion, by which stored states know the system.
    pub(crate) fn formulas(&self) -> String {
        let lines = [&self.system]
            .into_iter()
            .chain(&self.sweep)
            .chain(&self.friction)
            .chain(self.in_drifts.iter().flatten());
        lines.map(String::as_str).collect::<Vec<_>>().join("\n")
    }

    /// Returns whether the velocities of drifts are momenta divided by masses.
    fn is_plain(&self) -> bool {
        self.has_masses && self.in_drifts.iter().all(Vec::is_empty)
    }

    fn has_h1(&self) -> bool {
        self.in_drifts[1..].iter().any(|lines| !lines.is_empty())
    }

    /// Returns what a step solves: the kinds of blocks, and their unknowns.
    pub(crate) fn blocks(
        &self,
        rule: Rule,
        kinetic: &Kinetic,
    ) -> Vec<(&'static str, &'static str)> {
        if is_implicit(rule) {
            return vec![match self.iteration {
                _ if self.has_h1() => ("FixedPoint", "the nodes and velocities of all sites"),
                CHEBYSHEV => (CHEBYSHEV, "q₁ − q₀"),
                _ => ("FixedPoint", "q₁ − q₀"),
            }];
        }
        let of_site = match kinetic {
            Kinetic::Masses(_) => None,
            Kinetic::Sites { is_affine, .. } => Some(if *is_affine { "Linear" } else { "Newton" }),
        };
        let has_drags = !self.in_drifts[0].is_empty();
        let acts_before = !matches!(rule.nodes, Nodes::One { c } if c == 1.0);
        let is_joined = has_drags && acts_before || self.has_h1();
        let mut blocks = Vec::new();
        blocks.extend(of_site.map(|kind| (kind, "the velocity of each site")));
        blocks.extend(is_joined.then_some(("FixedPoint", "the velocities of all sites")));
        blocks
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
        let mut action = format!("S_d = h {nodes} + ⟨p, q₁ − q₀ − h v⟩");
        if self.has_gamma {
            let noises = nodes.replace(", v)", ")").replace('L', "γ");
            write!(action, " + Σ {noises} ΔW").ok();
        }
        if self.has_h1() {
            let h1 = nodes.replace(", v)", ", p)").replace('L', "H₁");
            write!(action, " − Σ {h1} ΔW").ok();
        }
        let nodes = [(start, "q₀"), (end, "q₁")];
        let nodes = nodes.map(|(part, q)| part.map(|part| (part, q)));
        let nodes = || nodes.into_iter().flatten();
        let mut work = Vec::new();
        if self.has_forces {
            work.extend(nodes().map(|(part, q)| format!("{part}h F({q}, v)·δ{q}")));
        }
        if self.has_noise_forces {
            work.extend(nodes().map(|(part, q)| format!("{part}Σ f({q})·δ{q} ΔW")));
        }
        if !work.is_empty() {
            let work = work.join(" + ");
            write!(action, "\nwith the virtual work {work} beside δS").ok();
        }
        let kick = |part: &str, at: &str| format!("kick: p += {part}I({at}), a sweep at {at}");
        let mut step = Vec::new();
        step.extend(start.map(|part| kick(part, "q₀")));
        step.extend(self.drift(start, end));
        step.extend(end.map(|part| kick(part, "q₁")));
        if self.is_plain() {
            step.push("all in place".to_owned());
        }
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
        let without = match (self.friction.is_empty(), self.in_drifts[0].is_empty()) {
            (true, true) => "",
            (false, true) => ", F without the friction −N v",
            (true, false) => ", F without D",
            (false, false) => ", F without −N v and D",
        };
        let text = |is_there, text| if is_there { text } else { "" };
        let noises = text(self.has_gamma, " + Σ ∂γ/∂q ΔW");
        let pushes = text(self.has_noise_forces, " + Σ f ΔW");
        step.push(format!(
            "the impulses are I = h {force}{noises}{pushes}{without}:"
        ));
        let all = self.sweep.iter().chain(&self.friction);
        step.extend(all.chain(self.in_drifts.iter().flatten()).cloned());
    }

    /// Returns the drift, with what depends on velocities or momenta before it and after it.
    fn drift(&self, start: Option<&str>, end: Option<&str>) -> Vec<String> {
        let [drags, kicks, shifts] = &self.in_drifts;
        let has_friction = !self.friction.is_empty();
        if self.is_plain() {
            let damped = |part: Option<&str>, how: [&str; 2]| {
                let part = part.filter(|_| has_friction);
                part.map(|part| format!("friction: p {} (1 {} {part}h N M⁻¹)", how[0], how[1]))
            };
            let lines = [
                damped(start, ["/=", "+"]),
                Some("drift: q₁ = q₀ + h M⁻¹ p".to_owned()),
                damped(end, ["*=", "−"]),
            ];
            return lines.into_iter().flatten().collect();
        }
        // a term of the side of a node, where there are such terms
        let term = |is_there: bool, part: Option<&str>, text: &str| match part {
            Some(part) if is_there => text.replace('#', part),
            _ => String::new(),
        };
        let [friction, drag] = [has_friction, !drags.is_empty()];
        let [kick, shift] = [kicks, shifts].map(|lines| !lines.is_empty());
        let momentum = if self.has_masses {
            "M v"
        } else {
            "∂L/∂v(v)"
        };
        let implied = term(friction, start, " + #h N v");
        let before = term(drag, start, " + #D(q₀, v)") + &term(kick, start, " + #K(q₀, p)");
        let moved = term(shift, start, " + #X(q₀, p)") + &term(shift, end, " + #X(q₁, p)");
        let after = term(friction, end, " − #h N v")
            + &term(drag, end, " + #D(q₁, v)")
            + &term(kick, end, " + #K(q₁, p)");
        vec![
            format!("velocities: p{implied} = (p of the kick){before} with p = {momentum}"),
            format!("drift: q₁ = q₀ + h v{moved}"),
            format!("momenta: p{after}"),
        ]
    }
}

/// Returns the impulse, or another row named by `letter`, of each site of each term.
fn sweep(terms: &[Term], letter: &str, names: SceneNames<'_>) -> Vec<String> {
    let mut lines = Vec::new();
    for term in terms {
        let loops = names.loops(term.sum);
        for at in term.receivers(names.arena) {
            let (site, impulses) = (term.sites[at], &term.impulses[at]);
            for (component, &impulse) in impulses.iter().enumerate() {
                if names.arena.constant_value(impulse) == Some(0.0) {
                    continue;
                }
                let index = names.scene.integers.text(site);
                let component = names.component(component);
                let impulse = names.formula(impulse);
                lines.push(format!("{letter}[{index}]{component} += {impulse} {loops}"));
            }
        }
    }
    lines
}

/// Returns the friction of each component of a site.
fn friction(derived: &Derived, names: SceneNames<'_>) -> Vec<String> {
    let frictions = derived.frictions.iter();
    let lines = frictions.map(|friction| {
        let index = derived.scene.integers.text(friction.site);
        let component = names.component(friction.component);
        let (value, loops) = (names.formula(friction.value), names.loops(friction.sum));
        format!("N[{index}]{component} += {value} {loops}")
    });
    lines.collect()
}
