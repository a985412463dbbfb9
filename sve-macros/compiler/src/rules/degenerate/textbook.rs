//! The actions of degenerate Lagrangians in their textbook form.

use crate::rules::textbook::{Features, Textbook, sum};
use crate::system::degeneracy::{Degeneracy, Form, Role};

/// Returns the action in terms of L₀, α and the noises as functions.
pub(crate) fn textbook(
    degeneracy: &Degeneracy,
    c: f64,
    mut plain: Textbook,
    system: &Features,
) -> Textbook {
    let form = degeneracy.form(c == 0.5);
    let notation = &mut plain.notation;
    if form == Form::Eliminated {
        notation.push("the nodes of the algebraic coordinates are variables".to_owned());
        return plain;
    }
    let t = system.time("t̄");
    let place = match form {
        Form::Projected => "q*",
        Form::Internal => "x̄, ȳ",
        _ => "q̄",
    };
    let (mut action, lagrangian) = if !degeneracy.of(Role::Massive).is_empty() {
        (
            format!("S = h·L₀({t}{place}, v) + ⟨p, x₁ − x₀ − h·v⟩ + ⟨α({place}), y₁ − y₀⟩"),
            "L = L₀(q, dx/dt) + ⟨α(q), dy/dt⟩",
        )
    } else if form == Form::Internal {
        (
            format!("S = ⟨ϑ({place}), x₁ − x₀⟩ − h·H({t}{place})"),
            "L = ⟨ϑ(x, y), dx/dt⟩ − H up to a total derivative",
        )
    } else {
        (
            format!("S = ⟨α({place}), q₁ − q₀⟩ − h·H({t}{place})"),
            "L = ⟨α(q), dq/dt⟩ − H",
        )
    };
    if system.gammas > 0 {
        let sum = sum(system.gammas);
        action = format!("{action} + {sum}γ({t}{place})·ΔW");
    }
    notation.push(lagrangian.to_owned());
    match form {
        Form::Projected => {
            action += " + ⟨λ, α(q₀) − α(q₁)⟩";
            notation.retain(|text| !text.starts_with("q̄ ="));
            notation.push("q* = (q₀ + q₁)/2 + λ, and λ such that p₁ = α(q₁)".to_owned());
        }
        Form::Internal => {
            notation.push("x̄ is the node of the coordinates whose velocities occur, ȳ that of the others, a variable, and y₁ such that ∂S/∂x₁ = ϑ(x₁, y₁)".to_owned());
            if c != 0.5 && system.gammas > 0 {
                let sign = if c > 0.5 { '+' } else { '−' };
                action = format!("{action} {sign} ½·Σ ⟨w[i], ∂G[j]/∂x − ϑ_xᵀ·w[j]⟩·ΔW[i]·ΔW[j]");
                notation.push("G = −γ, ϑ_yᵀ·w = ∂G/∂y".to_owned());
            }
        }
        _ => notation.push("p₁ = α(q₁)".to_owned()),
    }
    Textbook { action, ..plain }
}
