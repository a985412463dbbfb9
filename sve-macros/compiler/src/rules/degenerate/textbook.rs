//! The actions of degenerate Lagrangians in their textbook form.

use crate::rules::{Features, Textbook};
use crate::system::degeneracy::{Degeneracy, Form, Role};

/// The action with its parts as functions.
pub(crate) fn textbook(
    degeneracy: &Degeneracy,
    c: f64,
    plain: Textbook,
    system: &Features,
) -> Textbook {
    let form = degeneracy.form(c == 0.5);
    let has_mass = !degeneracy.of(Role::Massive).is_empty();
    let Textbook {
        action,
        mut notation,
        work,
    } = plain;
    let t = if system.is_timed { "t̄, " } else { "" };
    let (place, node) = match form {
        Form::Projected => ("q*", "q* = (q₀ + q₁)/2 + λ"),
        Form::Internal => (
            "x̄, ȳ",
            "x̄ is the node of the coordinates whose velocities occur, ȳ that of the others, a variable",
        ),
        Form::Eliminated => ("q̄", "the nodes of the algebraic coordinates are variables"),
        Form::Plain => ("q̄", ""),
    };
    if form == Form::Eliminated {
        notation.push(node.to_owned());
        return Textbook {
            action,
            notation,
            work,
        };
    }
    let mut terms = vec!["S = ".to_owned()];
    if has_mass {
        terms.push(format!(
            "h·L₀({t}{place}, v) + ⟨p, x₁ − x₀ − h·v⟩ + ⟨α({place}), y₁ − y₀⟩"
        ));
        notation.push("L = L₀(q, dx/dt) + ⟨α(q), dy/dt⟩".to_owned());
    } else {
        let (one_form, moved) = match form {
            Form::Internal => ("ϑ", "x₁ − x₀"),
            _ => ("α", "q₁ − q₀"),
        };
        terms.push(format!("⟨{one_form}({place}), {moved}⟩ − h·H({t}{place})"));
        notation.push(match form {
            Form::Internal => "L = ⟨ϑ(x, y), dx/dt⟩ − H up to a total derivative".to_owned(),
            _ => "L = ⟨α(q), dq/dt⟩ − H".to_owned(),
        });
    }
    if system.gammas > 0 {
        let sum = if system.gammas > 1 { "Σ " } else { "" };
        terms.push(format!(" + {sum}γ({t}{place})·ΔW"));
    }
    match form {
        Form::Projected => {
            terms.push(" + ⟨λ, α(q₀) − α(q₁)⟩".to_owned());
            notation.retain(|text| !text.starts_with("q̄ ="));
            notation.push(format!("{node}, and λ such that p₁ = α(q₁)"));
        }
        Form::Internal => {
            notation.push(format!("{node}, and y₁ such that ∂S/∂x₁ = ϑ(x₁, y₁)"));
            if c != 0.5 && system.gammas > 0 {
                let sign = if c > 0.5 { '+' } else { '−' };
                terms.push(format!(
                    " {sign} ½·Σ ⟨w[i], ∂G[j]/∂x − ϑ_xᵀ·w[j]⟩·ΔW[i]·ΔW[j]"
                ));
                notation.push("G = −γ, ϑ_yᵀ·w = ∂G/∂y".to_owned());
            }
        }
        _ => notation.push("p₁ = α(q₁)".to_owned()),
    }
    Textbook {
        action: terms.concat(),
        notation,
        work,
    }
}
