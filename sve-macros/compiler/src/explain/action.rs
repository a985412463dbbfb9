//! The discrete action of a rule, in its textbook form and written out, and the meanings of its
//! symbols.

use super::names::Names;
use super::page::Page;
use crate::algebra::{Arena, Expr, Sum};
use crate::catalogue::{Rule, RuleOption};
use crate::model::{AtNode, Constraint, Meaning, Model, NoiseKind, NoiseTerm, Symbols};
use crate::rules::action::Action;
use crate::rules::textbook::{Features, Textbook};
use crate::rules::{degenerate, discretisation};
use crate::system::classify::Classified;

/// Returns the text of an action: its textbook form, the action written out if it is short, and the
/// meanings of the symbols.
pub(super) fn with_notation(
    rule: Rule,
    textbook: Textbook,
    written_out: Vec<String>,
    features: &Features,
    system: &Classified,
) -> String {
    let Textbook {
        action,
        mut notation,
        work,
    } = textbook;
    if !written_out.is_empty() {
        notation.push("Δq = q₁ − q₀".to_owned());
    }
    if features.potential.is_some() {
        let has_potential = features.gammas + features.hamiltonians > 0;
        notation.extend(has_potential.then(|| potential(&system.model).to_owned()));
        let has_push = features.noise_forces > 0;
        notation.extend(has_push.then(|| PUSH.to_owned()));
    }
    let mut lines = vec![action];
    lines.extend(written_out);
    if !work.is_empty() {
        lines.push(format!("with the virtual work {work} beside δS"));
    }
    if !notation.is_empty() {
        lines.push(notation.join(", "));
    }
    if (system.mechanics.noises.iter()).any(|noise| noise.reads_velocity) {
        lines.extend(pole(rule, system.model.dof()).map(ToOwned::to_owned));
    }
    lines.join("\n")
}

/// The definition of D of the option `weak2`.
const PUSH: &str = "D = Σ ∂f/∂q·M⁻¹·f with M = ∂²L/∂v²";

/// Returns the remark on noise forces that depend on velocities. For f = σp and `y = σΔW` steps
/// divide by 1 − y/2 in the symmetric rules, by 1 − y + y²/2 from the initial point, by nothing at
/// the endpoint, and by the denominators of the diagonal Padé approximants of eʸ in Gauss rules. If
/// forces turn velocities, y stands for complex numbers too, of which each of these but the
/// endpoint has poles.
fn pole(rule: Rule, coordinates: usize) -> Option<&'static str> {
    let has_real_pole = !rule.has_correction() && rule.stages().is_none_or(|s| s % 2 == 1);
    if has_real_pole {
        return Some(
            "a noise force depends on velocities: for f = σ·p this step has a pole at some σ·ΔW, so that its means by Gaussian increments do not exist; `endpoint` has none if f is linear in p, `gauss(2)` none for the friction of one coordinate, and `Truncated` bounds the increments",
        );
    }
    let is_free = rule.node() == Some(1.0) || coordinates == 1;
    (!is_free).then_some(
        "a noise force depends on velocities: where it turns them, a large increment may meet a pole of this step; `endpoint` has none if f is linear in p, and `Truncated` bounds the increments",
    )
}

/// Returns the constraints in the textbook form of an action.
pub(super) fn constraints(model: &Model, arena: &Arena) -> String {
    let is_timed = |c: &Constraint| arena.contains(c.value, model.time);
    let [t0, t1] = if model.constraints.iter().any(is_timed) {
        ["t₀, ", "t₁, "]
    } else {
        ["", ""]
    };
    match model.constraints.len() {
        0 => String::new(),
        1 => format!(" + λ·φ({t0}q₀) + μ·φ({t1}q₁)"),
        _ => format!(" + ⟨λ, φ({t0}q₀)⟩ + ⟨μ, φ({t1}q₁)⟩"),
    }
}

/// Returns the action in its textbook form.
pub(super) fn textbook(rule: Rule, system: &Classified, features: &Features) -> Textbook {
    let plain = discretisation(rule).textbook(features);
    match (&system.degeneracy, rule.node()) {
        (Some(degeneracy), Some(node)) => degenerate::textbook(degeneracy, node, plain, features),
        _ => plain,
    }
}

/// Returns the properties of the system that show in the textbook form of an action.
pub(super) fn features(
    rule: Rule,
    system: &Classified,
    potential: Option<f64>,
    arena: &Arena,
) -> Features {
    let (model, mechanics) = (&system.model, &system.mechanics);
    let timed = |e: Expr| arena.contains(e, model.time);
    let noises = &model.noises;
    let count = |kind| noises.iter().filter(|noise| noise.kind == kind).count();
    let (gammas, noise_forces) = (count(NoiseKind::Gamma), count(NoiseKind::Force));
    let given = |list: &[Expr]| list.iter().any(|&e| arena.constant_value(e) != Some(0.0));
    let moves_q = mechanics.noises.iter().any(|g| given(&g.dp));
    let moves_p = mechanics.noises.iter().any(|g| given(&g.dq));
    let reads_velocity = (mechanics.noises.iter()).any(|g| g.reads_velocity);
    Features {
        degrees_of_freedom: model.dof(),
        is_timed: timed(model.lagrangian) || noises.iter().any(|g| timed(g.hamiltonian)),
        is_forced: model.force.is_some(),
        forces_are_timed: model.forces().flatten().any(|&e| timed(e)),
        potential,
        has_stage_noise: rule.options.contain(RuleOption::StageNoise),
        gammas,
        hamiltonians: noises.len() - gammas - noise_forces,
        noise_forces,
        corrects_forces: noise_forces > 0 && (moves_q || reads_velocity),
        moves_both: moves_q && moves_p,
    }
}

/// Returns the definition of K of the option `weak2`.
fn potential(model: &Model) -> &'static str {
    let is_gamma = |noise: &NoiseTerm| noise.kind == NoiseKind::Gamma;
    let are_gamma = model.noises.iter().all(is_gamma);
    match (are_gamma, model.noises.len(), model.dof()) {
        (true, 1, 1) => "K = (∂γ/∂q)²/(∂²L/∂v²)",
        (true, _, 1) => "K = Σ (∂γ/∂q)²/(∂²L/∂v²)",
        (true, 1, _) => "K = ⟨∂γ/∂q, M⁻¹·∂γ/∂q⟩ with M = ∂²L/∂v²",
        (true, _, _) => "K = Σ ⟨∂γ/∂q, M⁻¹·∂γ/∂q⟩ with M = ∂²L/∂v²",
        (false, _, _) => "K = Σ {G, {G, H} + ∂G/∂t} with G = −γ or H₁",
    }
}

/// Returns the action as the expression that is differentiated, and its parts; an empty text if it
/// is long.
pub(super) fn written_out(
    rule: Rule,
    action: &Action,
    symbols: &Symbols,
    arena: &Arena,
) -> Vec<String> {
    let mut page = Page::new(arena, Names::new(symbols, Some(rule)));
    page.name_parts(&[action.value]);
    let mut sum = Sum::default();
    sum.add(1.0, action.value, arena);
    sum.terms
        .sort_by_key(|&(term, _)| textbook_place(term, action, symbols, arena));
    let Some(text) = page.whole(&sum) else {
        return Vec::new();
    };
    let mut lines = vec![format!("S = {text}")];
    // the textbook form explains the nodes already
    lines.extend(page.explanations(|e| AtNode::of(e, arena).is_some()));
    lines
}

/// Returns the rank of a term: L comes first, then the constraints, then the noise.
fn textbook_place(term: Expr, action: &Action, symbols: &Symbols, arena: &Arena) -> u8 {
    let is_noise = |s| matches!(symbols.meaning(s), Meaning::Wiener(_));
    if arena.symbols_of(term).any(is_noise) {
        return 2;
    }
    let h = arena.known_symbol(action.h);
    let is_h = |factor| Some(factor) == h;
    u8::from(!arena.operands_of(term).any(is_h))
}
