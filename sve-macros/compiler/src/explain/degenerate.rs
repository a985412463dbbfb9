//! The equations of motion of a degenerate Lagrangian: `ω dq = ∇H dt − ∇γ ∘ dW` for massless coordinates, `0 = ∂L/∂q` for algebraic ones.

use super::names::Names;
use super::page::Page;
use super::shown;
use super::system::{Line, increment};
use crate::algebra::{Arena, Expr, Sum};
use crate::model::Model;
use crate::system::degeneracy::{Degeneracy, Role};
use crate::system::mechanics::Mechanics;

/// The equations of motion, coordinate by coordinate, and the momenta.
pub(super) fn motion(
    degeneracy: &Degeneracy,
    model: &Model,
    mechanics: &Mechanics,
    arena: &Arena,
) -> Vec<String> {
    let n = model.dof();
    let count = shown(n);
    let mut page = Page::new(arena, Names::new(&model.symbols, None));
    let mut roots: Vec<Expr> = degeneracy.rest_slopes[..count].to_vec();
    roots.extend(degeneracy.two_form[..count].iter().flatten());
    roots.extend(&mechanics.lagrangian.dv[..count]);
    for noise in &mechanics.noises {
        roots.extend(noise.dq[..count].iter().chain(&noise.dp[..count]));
    }
    page.name_parts(&roots);
    let equations = (0..count).flat_map(|i| match degeneracy.roles[i] {
        Role::Massive => {
            let moved = moved(i, mechanics, &mut page);
            vec![moved, pushed(i, degeneracy, mechanics, &mut page)]
        }
        Role::Massless => vec![paired(i, degeneracy, mechanics, &mut page)],
        Role::Algebraic => {
            let mut slope = Sum::default();
            slope.add(1.0, degeneracy.rest_slopes[i], arena);
            vec![format!("0 = {}", page.sum(&slope))]
        }
    });
    let mut lines: Vec<String> = equations.collect();
    if count < n {
        lines.push(format!("… ({} more coordinates)", n - count));
    }
    let momenta = (0..count).map(|i| {
        let name = page.names.symbols.component("p", i);
        format!("{name} = {}", page.formula(mechanics.lagrangian.dv[i]))
    });
    let momenta: Vec<String> = momenta.collect();
    lines.extend(Page::list(momenta, n, "momenta"));
    lines.extend(page.explanations(|_| false));
    lines
}

/// `dq = v dt + ∂G/∂p ∘ dW`.
fn moved(i: usize, mechanics: &Mechanics, page: &mut Page<'_>) -> String {
    let mut line = Line::new(&page.names.symbols.component("dq", i));
    line.push(
        false,
        &format!("{} dt", page.names.symbols.component("v", i)),
    );
    kicks(&mut line, mechanics, page, |noise| (1.0, noise.dp[i]));
    line.text
}

/// `dp = ∂L₀/∂q dt + Σ ∂α_k/∂q ∘ dq_k − ∂G/∂q ∘ dW`.
fn pushed(i: usize, degeneracy: &Degeneracy, mechanics: &Mechanics, page: &mut Page<'_>) -> String {
    let mut line = Line::new(&page.names.symbols.component("dp", i));
    let mut force = Sum::default();
    force.add(1.0, degeneracy.rest_slopes[i], page.arena);
    line.add(page, &force, "dt");
    for (k, &slope) in degeneracy.slopes[i].iter().enumerate() {
        moving(&mut line, slope, k, page);
    }
    kicks(&mut line, mechanics, page, |noise| (-1.0, noise.dq[i]));
    line.text
}

/// `Σ_k ω_ik dq_k = −∂L₀/∂q_i dt + ∂G/∂q_i ∘ dW`.
fn paired(i: usize, degeneracy: &Degeneracy, mechanics: &Mechanics, page: &mut Page<'_>) -> String {
    let mut left = Line::new("");
    for (k, &entry) in degeneracy.two_form[i].iter().enumerate() {
        moving(&mut left, entry, k, page);
    }
    let left = left.text;
    let mut line = Line::new(left.strip_prefix(" = ").unwrap_or(&left));
    let mut slope = Sum::default();
    slope.add(-1.0, degeneracy.rest_slopes[i], page.arena);
    line.add(page, &slope, "dt");
    kicks(&mut line, mechanics, page, |noise| (1.0, noise.dq[i]));
    line.text
}

/// Adds a coefficient times the differential of a coordinate.
fn moving(line: &mut Line, coefficient: Expr, of: usize, page: &mut Page<'_>) {
    let mut term = Sum::default();
    term.add(1.0, coefficient, page.arena);
    if term.is_zero() {
        return;
    }
    let (negative, factor) = page.factor(&term);
    let differential = page.names.symbols.component("dq", of);
    match factor.as_str() {
        "1" => line.push(negative, &differential),
        factor => line.push(negative, &format!("{factor} ∘ {differential}")),
    }
}

/// Adds the noises to an equation.
fn kicks(
    line: &mut Line,
    mechanics: &Mechanics,
    page: &mut Page<'_>,
    of: impl Fn(&crate::system::mechanics::NoiseJet) -> (f64, Expr),
) {
    let noises = &mechanics.noises;
    for (at, noise) in noises.iter().enumerate() {
        let (sign, slope) = of(noise);
        let mut kick = Sum::default();
        kick.add(sign, slope, page.arena);
        line.add(page, &kick, &increment(at, noises.len()));
    }
}
