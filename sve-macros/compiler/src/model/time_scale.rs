//! The Lagrangian in a scaled time τ, with dt = s(q) dτ:
//!
//! ```text
//! L̃(q, w) = s(q) (L(q, w/s(q)) + E)        w = dq/dτ = s v
//! ```
//!
//! Its momenta ∂L̃/∂w = ∂L/∂v are those of L, its Hamiltonian is K = s (H − E), which is zero along
//! a path of the energy E, and ∂L̃/∂E = s is the rate of the time. Source: Hairer, Lubich, Wanner,
//! *Geometric Numerical Integration* (2006), section VIII.2.1.
//!
//! Invariant: the term s E makes ∂L̃/∂q = s ∂L/∂q − (H − E) ∂s/∂q. The second part is zero along
//! the path, and without it no step would be symplectic.

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Node, Symbol};

/// Returns L̃ as a function of q and w. The symbols of velocities stand for w.
pub(crate) fn in_scaled_time(
    lagrangian: Expr,
    scale: Expr,
    energy: Symbol,
    velocities: &[Symbol],
    arena: &mut Arena,
) -> Expr {
    let (constant, terms) = match arena.node(lagrangian) {
        Node::Sum(constant, terms) => (constant.get(), terms.clone()),
        _ => (0.0, Vec::new()),
    };
    let terms: Vec<(f64, Expr)> = if terms.is_empty() {
        vec![(1.0, lagrangian)]
    } else {
        terms.iter().map(|&(term, c)| (c.get(), term)).collect()
    };
    let mut scaled = Vec::new();
    // each term alone, so that powers of s cancel within a term
    for (c, term) in terms {
        scaled.push((c, scaled_term(term, scale, velocities, arena)));
    }
    let energy = arena.symbol(energy);
    scaled.push((1.0, arena.mul(scale, energy)));
    scaled.push((constant, scale));
    arena.sum(0.0, &scaled)
}

/// Returns s T(q, w/s) of a term T(q, v).
fn scaled_term(term: Expr, scale: Expr, velocities: &[Symbol], arena: &mut Arena) -> Expr {
    if velocities.iter().all(|&v| !arena.contains(term, v)) {
        return arena.mul(scale, term);
    }
    // Euler's identity for homogeneous functions of degree 2, as kinetic energies are
    let mut identity = vec![(-2.0, term)];
    for &v in velocities {
        let (slope, v) = (arena.diff(term, v), arena.symbol(v));
        identity.push((1.0, arena.mul(slope, v)));
    }
    let identity = arena.sum(0.0, &identity);
    if arena.is_zero(identity) {
        return arena.div(term, scale);
    }
    let mut by = HashMap::new();
    for &v in velocities {
        let w = arena.symbol(v);
        by.insert(v, arena.div(w, scale));
    }
    let term = arena.substitute(term, &by);
    arena.mul(scale, term)
}
