//! The action of a Gauss rule in its textbook form, and the equations of its stages.

use std::fmt::Write as _;

use super::step::{StepTexts, features};
use crate::algebra::Arena;
use crate::discretise::stages::{Form, Stages};
use crate::rules::gauss::Quadrature;
use crate::rules::{Features, Rule, Textbook};
use crate::system::mechanics::Mechanics;
use crate::system::model::Model;

/// Fewest stages with which the runtime begins by fixed-point iteration.
pub(crate) const STAGES_OF_FIXED_POINT: usize = 4;

/// Writes down a step of so many stages.
pub(crate) fn gauss(
    rule: Rule,
    count: usize,
    stages: &Stages,
    model: &Model,
    mechanics: &Mechanics,
    arena: &Arena,
) -> StepTexts {
    let features = features(model, mechanics, None, arena);
    let Textbook {
        action,
        notation,
        work,
    } = rule.textbook(&features);
    let mut lines = vec![action];
    if model.force.is_some() {
        lines.push(format!("with the virtual work h·{work} beside δS"));
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
    let has_fixed_point = !matches!(stages.form, Form::General) && count >= STAGES_OF_FIXED_POINT;
    let solver = if has_fixed_point {
        "fixed-point iteration, Newton's method where it does not contract,"
    } else {
        "Newton's method"
    };
    let mut lines = vec![format!("{solver} for {unknowns} at {count} stages")];
    lines.push(format!("  ∂L/∂v({}) = p₀ + Σⱼ (aᵢⱼ/bⱼ)·Fⱼ", point("ᵢ")));
    // writing to a string does not fail
    let mut displacement = "h·bᵢ·Vᵢ".to_owned();
    if stages.moves_position {
        let _ = write!(displacement, " + bᵢ·Σ ∂H₁/∂p({}Qᵢ, Pᵢ)·ΔW", t("tᵢ"));
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
        let _ = write!(impulse, " + bᵢ·Σ ∂γ/∂q({}Qᵢ)·ΔW", t("tᵢ"));
    }
    if features.hamiltonians > 0 {
        let _ = write!(impulse, " − bᵢ·Σ ∂H₁/∂q({}Qᵢ, Pᵢ)·ΔW", t("tᵢ"));
    }
    lines.push(format!("  Fᵢ = {impulse}"));
    if features.hamiltonians > 0 {
        lines.push(format!("  Pᵢ = ∂L/∂v({})", point("ᵢ")));
    }
    let Quadrature { c, b, .. } = Quadrature::new(count);
    for (name, list) in [("c", c), ("b", b)] {
        let list: Vec<String> = list.iter().map(|x| format!("{x:.6}")).collect();
        lines.push(format!("  {name} = {}", list.join(", ")));
    }
    lines
}
