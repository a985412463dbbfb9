//! The action of a Gauss rule in its textbook form, and the equations of its stages.

use std::fmt::Write as _;

use super::step::{StepTexts, features, potential};
use crate::algebra::Arena;
use crate::catalogue::Rule;
use crate::discretise::stages::Stages;
use crate::rules::gauss::Quadrature;
use crate::rules::{Features, Textbook, discretisation};
use crate::system::classify::Classified;

/// Writes down a step of so many stages; `half_factor` is ½κ of the option `weak2`, if the action has its term.
pub(crate) fn gauss(
    rule: Rule,
    count: usize,
    half_factor: Option<f64>,
    stages: &Stages,
    system: &Classified,
    arena: &Arena,
) -> StepTexts {
    let model = &system.model;
    let features = features(rule, system, half_factor, arena);
    let Textbook {
        action,
        mut notation,
        work,
    } = discretisation(rule).textbook(&features);
    let mut lines = vec![action];
    if model.force.is_some() {
        lines.push(format!("with the virtual work h·{work} beside δS"));
    }
    if half_factor.is_some() {
        notation.push(potential(model).to_owned());
    }
    lines.push(notation.join(", "));
    StepTexts {
        action: lines.join("\n"),
        step: equations(count, stages, &features).join("\n"),
        domain: Vec::new(),
    }
}

/// The equations of the stages, the results, and the coefficients.
fn equations(count: usize, stages: &Stages, features: &Features) -> Vec<String> {
    let t = |name: &str| {
        if features.is_timed {
            format!("{name}, ")
        } else {
            String::new()
        }
    };
    let point = |i: &str| format!("{}Q{i}, V{i}", t(&format!("t{i}")));
    let unknowns = if stages.moves_position {
        "Vᵢ, Yᵢ"
    } else {
        "Vᵢ"
    };
    let solver = if stages.has_fixed_point(count) {
        "fixed-point iteration, Newton's method where it does not contract,"
    } else {
        "Newton's method"
    };
    let mut lines = vec![format!("{solver} for {unknowns} at {count} stages")];
    lines.push(format!("  ∂L/∂v({}) = p₀ + Σⱼ (aᵢⱼ/bⱼ)·Fⱼ", point("ᵢ")));
    let (b, dw) = features.increment_at_stage();
    // writing to a string does not fail
    let mut displacement = "h·bᵢ·Vᵢ".to_owned();
    if stages.moves_position {
        let _ = write!(displacement, " + {b}Σ ∂H₁/∂p({}Qᵢ, Pᵢ)·{dw}", t("tᵢ"));
        let slope = format!("∂K/∂p({}Qᵢ, Pᵢ)", t("tᵢ"));
        let term = features.potential("h·|h|·bᵢ", &slope, 1);
        displacement.push_str(&term.replacen('−', "+", 1));
    }
    lines.push(format!("  Yᵢ = {displacement}"));
    lines.push("then".to_owned());
    lines.push("  q₁ = q₀ + Σᵢ Yᵢ".to_owned());
    lines.push("  p₁ = p₀ + Σᵢ Fᵢ".to_owned());
    lines.push("with".to_owned());
    lines.push("  Qᵢ = q₀ + Σⱼ (aᵢⱼ/bⱼ)·Yⱼ".to_owned());
    let mut impulse = if features.force_is_timed.is_some() {
        format!("h·bᵢ·(∂L/∂q + F)({})", point("ᵢ"))
    } else {
        format!("h·bᵢ·∂L/∂q({})", point("ᵢ"))
    };
    if features.gammas > 0 {
        let _ = write!(impulse, " + {b}Σ ∂γ/∂q({}Qᵢ)·{dw}", t("tᵢ"));
    }
    if features.hamiltonians > 0 {
        let _ = write!(impulse, " − {b}Σ ∂H₁/∂q({}Qᵢ, Pᵢ)·{dw}", t("tᵢ"));
    }
    let p = if features.hamiltonians > 0 {
        ", Pᵢ"
    } else {
        ""
    };
    let slope = format!("∂K/∂q({}Qᵢ{p})", t("tᵢ"));
    impulse.push_str(&features.potential("h·|h|·bᵢ", &slope, 1));
    lines.push(format!("  Fᵢ = {impulse}"));
    if features.hamiltonians > 0 {
        lines.push(format!("  Pᵢ = ∂L/∂v({})", point("ᵢ")));
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
    lines
}
