//! The system and its equations of motion, in the first-order Stratonovich form.

use super::motion::motion;
use super::names::Names;
use super::page::Page;
use super::shown;
use crate::algebra::{Arena, Expr, Sum, Vanishing};
use crate::model::{Constraint, Model, NoiseKind, NoiseTerm};
use crate::system::classify::Classified;
use crate::system::commutation::Commutation;
use crate::system::symmetry::MomentumMap;

/// The texts about the system, which are the same for all rules.
pub(crate) struct SystemTexts {
    /// L.
    pub(crate) lagrangian: String,
    /// The noise terms as the user writes them: γ, not −γ. Empty if there are none.
    pub(crate) noises: String,
    /// F. Empty if there is none.
    pub(crate) force: String,
    /// The constraints. Empty if there are none.
    pub(crate) constraints: String,
    /// The conserved momenta. Empty if there are none.
    pub(crate) momenta: String,
    /// `dq = …`, `dp = …`, `p = ∂L/∂v`.
    pub(crate) motion: String,
}

impl SystemTexts {
    /// Returns L, the noise terms, the force and the conserved momenta.
    pub(crate) fn system(&self) -> String {
        let Self {
            lagrangian,
            noises,
            force,
            constraints,
            momenta,
            motion: _,
        } = self;
        let parts = [lagrangian, noises, force, constraints, momenta];
        let parts: Vec<&str> = parts
            .into_iter()
            .map(String::as_str)
            .filter(|text| !text.is_empty())
            .collect();
        parts.join("\n")
    }
}

/// Prints the system.
pub(crate) fn system(system: &Classified, arena: &Arena) -> SystemTexts {
    let model = &system.model;
    let mut page = Page::new(arena, Names::new(&model.symbols, None));
    SystemTexts {
        lagrangian: lagrangian(model, &mut page).join("\n"),
        noises: noises(model, &system.commutation, &mut page).join("\n"),
        force: force(model, &mut page).join("\n"),
        constraints: constraints(model, &mut page).join("\n"),
        momenta: conserved(&system.momenta, &mut page).join("\n"),
        motion: motion(system, arena).join("\n"),
    }
}

fn lagrangian(model: &Model, page: &mut Page<'_>) -> Vec<String> {
    page.name_parts(&[model.lagrangian]);
    let name = if model.time_scale.is_some() {
        "L̃"
    } else {
        "L"
    };
    let mut lines = vec![format!("{name} = {}", page.formula(model.lagrangian))];
    lines.extend(page.explanations(|_| false));
    if let Some(scale) = model.time_scale {
        lines.push(format!("time scale s = {}", page.formula(scale)));
        lines.extend(page.explanations(|_| false));
        lines.extend(OF_TIME_SCALES.map(str::to_owned));
    }
    lines
}

/// The remarks on a system with a time scale.
const OF_TIME_SCALES: [&str; 3] = [
    "dt = s(q) dτ, L̃(q, v) = s (L(q, v/s) + E): h is a step of τ, v = dq/dτ, p is the momentum of L; in the equations t is τ, and L is L̃",
    "steps are symplectic for K = s (H − E) at equal steps of τ with a fixed E, the energy at the start",
    "H oscillates about E without drift; the map between equal times t is not symplectic",
];

fn noises(model: &Model, commutation: &Commutation, page: &mut Page<'_>) -> Vec<String> {
    let count = shown(model.noises.len());
    let some = &model.noises[..count];
    let mut roots: Vec<Expr> = some.iter().map(|noise| noise.hamiltonian).collect();
    let forces = some.iter().filter_map(|noise| noise.force.as_ref());
    roots.extend(forces.flat_map(|force| &force[..shown(force.len())]));
    page.name_parts(&roots);
    let lines = some.iter().map(|noise| noise_line(noise, page));
    let mut lines = Page::list(lines.collect(), model.noises.len(), "noises");
    lines.extend(page.explanations(|_| false));
    lines.extend(commutation_caveat(commutation).map(ToOwned::to_owned));
    if model.noises.iter().any(|noise| noise.force.is_some()) {
        lines.push(OF_NOISE_FORCES.to_owned());
    }
    lines
}

/// The remark on noises that are forces.
const OF_NOISE_FORCES: &str = "f is a force that acts with its process: a step keeps no symplectic form, and a momentum only if f does no work along its symmetry";

/// Returns the formula of a noise; of a force its components.
fn noise_line(noise: &NoiseTerm, page: &mut Page<'_>) -> String {
    let NoiseTerm {
        name,
        kind,
        hamiltonian,
        force,
    } = noise;
    let (letter, sign) = match kind {
        NoiseKind::Gamma => ("γ", -1.0),
        NoiseKind::H1 | NoiseKind::TangentH1 => ("H₁", 1.0),
        NoiseKind::Force => ("f", 1.0),
    };
    let formula = match force {
        Some(force) => {
            let some = &force[..shown(force.len())];
            let components = some.iter().map(|&f| page.formula(f));
            let components = Page::list(components.collect(), force.len(), "components");
            match components.as_slice() {
                [only] => only.clone(),
                all => format!("({})", all.join(", ")),
            }
        }
        None => {
            let mut sum = Sum::default();
            sum.add(sign, *hamiltonian, page.arena);
            page.sum(&sum)
        }
    };
    format!("{letter} {name} = {formula}")
}

fn constraints(model: &Model, page: &mut Page<'_>) -> Vec<String> {
    let count = shown(model.constraints.len());
    let some = &model.constraints[..count];
    let roots: Vec<Expr> = some.iter().map(|constraint| constraint.value).collect();
    page.name_parts(&roots);
    let lines = some
        .iter()
        .map(|Constraint { name, value }| format!("φ {name} = {} = 0", page.formula(*value)));
    let lines = lines.collect();
    let mut lines = Page::list(lines, model.constraints.len(), "constraints");
    lines.extend(page.explanations(|_| false));
    lines
}

/// Returns the remark on noises whose commutation is not proved.
fn commutation_caveat(commutation: &Commutation) -> Option<&'static str> {
    match commutation {
        Commutation::All(Vanishing::Proved) | Commutation::NonCommuting(..) => None,
        Commutation::All(Vanishing::Evaluated) => Some(
            "that the noises commute is checked, not proved: their brackets are zero to 28 digits at random points",
        ),
        Commutation::All(Vanishing::Undecided) => Some(
            "whether the noises commute cannot be decided: their brackets are within the rounding of the constants",
        ),
    }
}

/// Returns the remark on a symmetry that is not proved.
pub(crate) fn symmetry_caveat(evidence: Vanishing) -> Option<&'static str> {
    match evidence {
        Vanishing::Proved => None,
        Vanishing::Evaluated => Some(
            "checked, not proved: what should not change along it changes by less than 28 digits at random points",
        ),
        Vanishing::Undecided => Some(
            "not decided: what should not change along it changes within the rounding of the constants, so that the momentum is conserved to that rounding at least",
        ),
    }
}

fn force(model: &Model, page: &mut Page<'_>) -> Vec<String> {
    let Some(force) = &model.force else {
        return Vec::new();
    };
    let some = &force[..shown(force.len())];
    page.name_parts(some);
    let lines = some.iter().enumerate().map(|(i, &f)| {
        let name = page.names.symbols.component("F", i);
        format!("{name} = {}", page.formula(f))
    });
    let mut lines = Page::list(lines.collect(), force.len(), "components of F");
    lines.extend(page.explanations(|_| false));
    lines
}

fn conserved(momenta: &[MomentumMap], page: &mut Page<'_>) -> Vec<String> {
    let some = &momenta[..shown(momenta.len())];
    let values: Vec<Expr> = some.iter().map(|map| map.value).collect();
    page.name_parts(&values);
    let lines = some.iter().map(|map| {
        let MomentumMap {
            name,
            value,
            is_affine,
            evidence: _,
        } = map;
        let whose = if *is_affine {
            "conserved"
        } else {
            "conserved by the motion"
        };
        format!("{whose} {name}_momentum = {}", page.formula(*value))
    });
    let mut lines = Page::list(lines.collect(), momenta.len(), "symmetries");
    lines.extend(page.explanations(|_| false));
    for map in some {
        let caveat = symmetry_caveat(map.evidence);
        lines.extend(caveat.map(|caveat| format!("the symmetry {} is {caveat}", map.name)));
    }
    lines
}
