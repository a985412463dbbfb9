//! The internal form of a one-form: half of the velocities do not occur, up to a quadratic gauge.
//!
//! Input: α. Output: a splitting of the coordinates into equally many x and y, and a function ϑ
//! with α = (ϑ(x, y), 0) + ∇f, f quadratic. In (x, ϑ) the two-form is canonical, so y can be a
//! variable of the node (degenerate variational integrators: Ellison et al., 2018). A gauge f does
//! not change the equations of motion; since it is quadratic, it does not change the step either.

use super::{is_constant, is_regular};
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::Model;
use crate::system::inverse_mass;

/// Largest number of sets of coordinates that are tried for y.
const TRIED: usize = 500;

/// The form in which half of the velocities do not occur.
#[derive(Clone)]
pub(crate) struct Internal {
    /// The coordinates x whose velocities occur.
    pub(crate) outer: Vec<usize>,
    /// The coordinates y whose velocities do not occur.
    pub(crate) inner: Vec<usize>,
    /// ϑ, with one entry for each coordinate of `outer`.
    pub(crate) theta: Vec<Expr>,
    /// True if ϑ is affine in q.
    pub(crate) is_affine: bool,
    /// For each noise the vector w with `ϑ_yᵀ w = ∂G/∂y`, by which the noise moves x. `None` if w
    /// has no formula.
    pub(crate) shifts: Option<Vec<Vec<Expr>>>,
}

/// Finds the internal form among these coordinates.
pub(super) fn find(
    alpha: &[Expr],
    paired: &[usize],
    model: &Model,
    arena: &mut Arena,
) -> Option<Internal> {
    let half = paired.len() / 2;
    if half == 0 || paired.len() % 2 == 1 {
        return None;
    }
    let mut candidates: Vec<usize> = Vec::new();
    for &i in paired {
        let slopes: Vec<Expr> = model.q.iter().map(|&q| arena.diff(alpha[i], q)).collect();
        if slopes.into_iter().all(|e| is_constant(e, model, arena)) {
            candidates.push(i);
        }
    }
    // coordinates without velocity come first, and otherwise the later ones
    let has_velocity = |i: &usize| arena.constant_value(alpha[*i]) != Some(0.0);
    candidates.sort_by_key(|i| (has_velocity(i), std::cmp::Reverse(*i)));
    let mut chosen: Vec<usize> = (0..half).collect();
    for _ in 0..TRIED {
        if chosen.last().is_none_or(|&last| last >= candidates.len()) {
            return None;
        }
        let mut inner: Vec<usize> = chosen.iter().map(|&k| candidates[k]).collect();
        inner.sort_unstable();
        if let Some(found) = with_inner(inner, alpha, paired, model, arena) {
            return Some(found);
        }
        chosen = next(chosen, candidates.len())?;
    }
    None
}

/// Returns the next set of indices below `of`, in lexicographic order.
fn next(mut chosen: Vec<usize>, of: usize) -> Option<Vec<usize>> {
    let k = chosen.len();
    let at = (0..k).rev().find(|&at| chosen[at] + (k - at) < of)?;
    let first = chosen[at] + 1;
    for (step, index) in chosen[at..].iter_mut().enumerate() {
        *index = first + step;
    }
    Some(chosen)
}

/// Returns the form in which these coordinates have no velocities, if it exists.
fn with_inner(
    inner: Vec<usize>,
    alpha: &[Expr],
    paired: &[usize],
    model: &Model,
    arena: &mut Arena,
) -> Option<Internal> {
    let q = |i: usize| model.q[i];
    for (at, &j) in inner.iter().enumerate() {
        for &k in &inner[..at] {
            let [a, b] = [(j, k), (k, j)].map(|(j, k)| arena.diff(alpha[j], q(k)));
            let difference = arena.sub(a, b);
            if !arena.is_zero(difference) {
                return None;
            }
        }
    }
    let outer: Vec<usize> = paired
        .iter()
        .copied()
        .filter(|i| !inner.contains(i))
        .collect();
    // f = Σ y_j α_j(x, 0) + a quadratic function of y, so ϑ_i = α_i − Σ ∂_iα_j y_j
    let mut theta = Vec::new();
    for &i in &outer {
        let mut terms = vec![(1.0, alpha[i])];
        for &j in &inner {
            let slope = arena.diff(alpha[j], q(i));
            let y = arena.symbol(q(j));
            terms.push((-1.0, arena.mul(slope, y)));
        }
        theta.push(arena.sum(0.0, &terms));
    }
    // ϑ_yᵀ; y counts the rows
    let mut by_inner = Vec::new();
    for &j in &inner {
        by_inner.push(gradient(&theta, q(j), arena));
    }
    let all: Vec<usize> = (0..inner.len()).collect();
    if !is_regular(&by_inner, &all, arena) {
        return None;
    }
    let mut is_affine = true;
    for &symbol in &model.q {
        for slope in gradient(&theta, symbol, arena) {
            is_affine &= is_constant(slope, model, arena);
        }
    }
    let shifts = shifts(&by_inner, &inner, model, arena);
    Some(Internal {
        outer,
        inner,
        theta,
        is_affine,
        shifts,
    })
}

fn gradient(of: &[Expr], symbol: Symbol, arena: &mut Arena) -> Vec<Expr> {
    of.iter().map(|&e| arena.diff(e, symbol)).collect()
}

/// Returns, for each noise, the solution of `ϑ_yᵀ w = ∂G/∂y`.
fn shifts(
    by_inner: &[Vec<Expr>],
    inner: &[usize],
    model: &Model,
    arena: &mut Arena,
) -> Option<Vec<Vec<Expr>>> {
    let mut shifts = Vec::new();
    for noise in &model.noises {
        let slopes: Vec<Expr> = inner
            .iter()
            .map(|&j| arena.diff(noise.hamiltonian, model.q[j]))
            .collect();
        shifts.push(inverse_mass::solve(by_inner, &slopes, &model.q, arena).ok()?);
    }
    Some(shifts)
}
