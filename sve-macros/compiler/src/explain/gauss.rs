//! The action of a Gauss rule in its textbook form, and the equations of its stages.

use super::action::{features, with_notation};
use super::step::StepTexts;
use crate::algebra::Arena;
use crate::catalogue::Rule;
use crate::discretise::stages::Stages;
use crate::rules::discretisation;
use crate::rules::gauss::Quadrature;
use crate::rules::textbook::Features;
use crate::system::classify::Classified;

/// Prints a step with this number of stages. `half_factor` is ½κ of the option `weak2`, if the
/// action has its term.
pub(crate) fn gauss(
    rule: Rule,
    count: usize,
    half_factor: Option<f64>,
    stages: &Stages,
    system: &Classified,
    arena: &Arena,
) -> StepTexts {
    let features = features(rule, system, half_factor, arena);
    let textbook = discretisation(rule).textbook(&features);
    StepTexts {
        action: with_notation(rule, textbook, Vec::new(), &features, system),
        step: equations(rule, count, stages, &features).join("\n"),
        domain: Vec::new(),
    }
}

/// Returns the equations of the stages, the results, and the coefficients.
fn equations(rule: Rule, count: usize, stages: &Stages, features: &Features) -> Vec<String> {
    let t = features.time("tᵢ");
    let point = format!("{t}Qᵢ, Vᵢ");
    let solver = if stages.has_fixed_point(count) {
        "fixed-point iteration, Newton's method where it does not contract,"
    } else {
        "Newton's method"
    };
    let (b, dw) = features.increment_at_stage();
    let mut unknowns = "Vᵢ";
    let mut displacement = vec!["h·bᵢ·Vᵢ".to_owned()];
    if stages.moves_position {
        unknowns = "Vᵢ, Yᵢ";
        let slope = format!("∂K/∂p({t}Qᵢ, Pᵢ)");
        let term = features.potential("h·|h|·bᵢ", &slope, 1);
        displacement.push(format!(" + {b}Σ ∂H₁/∂p({t}Qᵢ, Pᵢ)·{dw}"));
        displacement.push(term.replacen('−', "+", 1));
    }
    let displacement = displacement.concat();
    let t_of_forces = features.time_of_forces("tᵢ");
    let with_forces = if t.is_empty() { &t_of_forces } else { &t };
    let mut impulse = vec![if features.is_forced {
        format!("h·bᵢ·(∂L/∂q + F)({with_forces}Qᵢ, Vᵢ)")
    } else {
        format!("h·bᵢ·∂L/∂q({point})")
    }];
    if features.gammas > 0 {
        impulse.push(format!(" + {b}Σ ∂γ/∂q({t}Qᵢ)·{dw}"));
    }
    if features.noise_forces > 0 {
        impulse.push(format!(" + {b}Σ f({t_of_forces}Qᵢ, Vᵢ)·{dw}"));
        let push = format!("D({t_of_forces}Qᵢ)");
        impulse.push(features.push("h·|h|·bᵢ", &push, 1));
    }
    let mut p = "";
    if features.hamiltonians > 0 {
        impulse.push(format!(" − {b}Σ ∂H₁/∂q({t}Qᵢ, Pᵢ)·{dw}"));
        p = ", Pᵢ";
    }
    impulse.push(features.potential("h·|h|·bᵢ", &format!("∂K/∂q({t}Qᵢ{p})"), 1));
    let impulse = impulse.concat();
    let mut lines = vec![
        format!("{solver} for {unknowns} at {count} stages"),
        format!("  ∂L/∂v({point}) = p₀ + Σⱼ (aᵢⱼ/bⱼ)·Fⱼ"),
        format!("  Yᵢ = {displacement}"),
        "then".to_owned(),
        "  q₁ = q₀ + Σᵢ Yᵢ".to_owned(),
        "  p₁ = p₀ + Σᵢ Fᵢ".to_owned(),
        "with".to_owned(),
        "  Qᵢ = q₀ + Σⱼ (aᵢⱼ/bⱼ)·Yⱼ".to_owned(),
        format!("  Fᵢ = {impulse}"),
    ];
    if features.hamiltonians > 0 {
        lines.push(format!("  Pᵢ = ∂L/∂v({point})"));
    }
    let Quadrature { c, b, .. } = Quadrature::new(count);
    for (name, list) in [("c", c), ("b", b)] {
        let list: Vec<String> = list.iter().map(|x| format!("{x:.6}")).collect();
        lines.push(format!("  {name} = {}", list.join(", ")));
    }
    lines.push(
        "an iteration is counted as a sweep over the stages, without Jacobian and linear solve"
            .to_owned(),
    );
    if stages.has_adapted_steps(rule, count) {
        lines.push(
            "`.tolerance(tol)` adapts the size of the steps: accurate paths, with an error of about tol per characteristic time, for short times; such steps are not symplectic, and conserve no momenta"
                .to_owned(),
        );
    }
    lines
}
