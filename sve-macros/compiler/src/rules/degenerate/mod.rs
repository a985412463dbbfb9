//! The rules with one node for degenerate Lagrangians, with p = α(q) at both ends. L is the sum of
//! L₀, a function of time, configuration and the velocities v of massive coordinates, and of ⟨α(q),
//! velocities of massless coordinates⟩.
//!
//! ```text
//! S_d = h L₀(t̄,q*,v) + ⟨p, d − h v⟩ + ⟨α(q*), d⟩ − Σ G_a(t̄,q*,p) ΔW_a
//!       + ⟨λ, α(q₀) − α(q₁)⟩        q* = q₀ + c d + λ
//! ```
//!
//! v and p belong to the massive coordinates and are internal. The action is not stationary in λ,
//! which is determined by p₁ = α(q₁). This is the symmetric projection of Kraus (arXiv:1708.07356)
//! with its multiplier as a displacement of both ends. In two cases the action is shorter:
//!
//! - α affine, midpoint: λ = 0, and p₁ = α(q₁) holds without being required.
//! - α = (ϑ(x, y), 0) + ∇f with a quadratic f: ȳ is internal, `S_d = ⟨ϑ(x̄,ȳ), d_x⟩ + …`, and y₁
//!   follows from `∂S_d/∂x₁ = ϑ(x₁, y₁)` (Ellison et al., 2018). Then the node may be anywhere,
//!   with the Stratonovich correction `(c − ½) Σ ⟨w_a, ∂G_b/∂x − ϑ_xᵀ w_b⟩ ΔW_a ΔW_b`,
//!   `ϑ_yᵀ w = ∂G/∂y`.
//!
//! The node of an algebraic coordinate is internal too, and the coordinate itself follows from
//! `0 = ∂L₀/∂q` at the end. The derivations are in `docs/mathematics.md`.

mod textbook;

use std::collections::HashMap;

use super::action::{Closure, Discrete, Ends, Variables};
use crate::algebra::{Expr, Symbol};
use crate::model::{Family, Meaning, NodeQuantity, Unknown};
use crate::system::degeneracy::{Degeneracy, Form, Internal, Role};
pub(crate) use textbook::textbook;

/// The end of the step as a node.
pub(super) const END: usize = 1;

/// The node of coordinates that are variables of the node.
pub(super) const INNER: usize = 2;

/// The node that its multiplier shifts.
pub(super) const SHIFTED: usize = 3;

/// Largest difference between p and α(q) at the start of a step, relative to the terms of both. It
/// is far above the rounding errors of a state, and far below the difference in a wrong
/// configuration.
const CONSISTENT: f64 = 1e-8;

/// The parts of the action.
struct Parts<'a> {
    degeneracy: &'a Degeneracy,
    /// The internal form, if the step has it.
    internal: Option<&'a Internal>,
    c: f64,
    /// The variables of the node, one for each coordinate that has them.
    v: Vec<Option<Symbol>>,
    p: Vec<Option<Symbol>>,
    /// The distance of the node from q₀, for coordinates for which it is a variable.
    inner: Vec<Option<Symbol>>,
    lambda: Vec<Option<Symbol>>,
}

/// Returns the action of a one-node rule at c, and the equations at the ends.
pub(super) fn action(c: f64, degeneracy: &Degeneracy, x: &mut Variables<'_>) -> (Discrete, Ends) {
    let n = x.model.dof();
    let form = degeneracy.form(c == 0.5);
    let internal = degeneracy
        .internal
        .as_ref()
        .filter(|_| form == Form::Internal);
    let is_inner = |i: usize| {
        let is_one = internal.is_some_and(|form| form.inner.contains(&i));
        is_one || degeneracy.is(i, Role::Algebraic)
    };
    let is_massive = |i: usize| degeneracy.is(i, Role::Massive);
    let is_projected = |i: usize| form == Form::Projected && degeneracy.is(i, Role::Massless);
    let parts = Parts {
        degeneracy,
        internal,
        c,
        v: declared(x, Family::Velocity, is_massive),
        p: declared(x, Family::Momentum, is_massive),
        inner: declared(x, Family::NodeDisplacement, is_inner),
        lambda: declared(x, Family::Projection, is_projected),
    };
    let node = parts.node(x);
    let end = end(x);
    let value = parts.value(&node, &end, x);
    let ends = parts.ends(form, &end, x);
    let internal = [&parts.inner, &parts.v, &parts.p];
    let internal = internal.into_iter().flatten().filter_map(|&s| s).collect();
    debug_assert_eq!(parts.v.len(), n);
    let discrete = Discrete {
        rotations: Vec::new(),
        value,
        internal,
        work: Vec::new(),
    };
    (discrete, ends)
}

/// Declares an unknown for some of the coordinates.
fn declared(
    x: &mut Variables<'_>,
    family: Family,
    wanted: impl Fn(usize) -> bool,
) -> Vec<Option<Symbol>> {
    let meaning = Unknown::of(family);
    (0..x.model.dof())
        .map(|i| wanted(i).then(|| x.symbols.declare(meaning(i))))
        .collect()
}

/// Returns the values of the model's coordinates at the end.
fn end(x: &mut Variables<'_>) -> HashMap<Symbol, Expr> {
    let (t, h) = (x.arena.symbol(x.model.time), x.arena.symbol(x.h));
    let t_end = x.arena.add(t, h);
    let mut end = HashMap::from([(x.model.time, t_end)]);
    for i in 0..x.model.dof() {
        let [q, d] = [x.start_q[i], x.displacement[i]].map(|s| x.arena.symbol(s));
        let q_end = x.arena.add(q, d);
        let q_end = x.at_node(END, NodeQuantity::Position(i), q_end);
        end.insert(x.model.q[i], q_end);
    }
    end
}

impl Parts<'_> {
    /// Returns the distance of the node from q₀.
    fn distance(&self, i: usize, x: &mut Variables<'_>) -> Expr {
        match (self.inner[i], self.lambda[i]) {
            (Some(inner), _) => x.arena.symbol(inner),
            (None, lambda) => {
                let d = x.arena.symbol(x.displacement[i]);
                let mut terms = vec![(self.c, d)];
                terms.extend(lambda.map(|lambda| (1.0, x.arena.symbol(lambda))));
                x.arena.sum(0.0, &terms)
            }
        }
    }

    /// Returns the values of the model's variables at the node. The velocities of massless
    /// coordinates do not occur.
    fn node(&self, x: &mut Variables<'_>) -> HashMap<Symbol, Expr> {
        let mut node = HashMap::new();
        let (t, h) = (x.arena.symbol(x.model.time), x.arena.symbol(x.h));
        let t_node = x.arena.sum(0.0, &[(1.0, t), (self.c, h)]);
        node.insert(x.model.time, x.at_node(0, NodeQuantity::Time, t_node));
        for i in 0..x.model.dof() {
            let q = x.arena.symbol(x.start_q[i]);
            let distance = self.distance(i, x);
            let at = x.arena.add(q, distance);
            let number = match (self.inner[i], self.lambda[i]) {
                (Some(_), _) => INNER,
                (None, Some(_)) => SHIFTED,
                (None, None) => 0,
            };
            let at = x.at_node(number, NodeQuantity::Position(i), at);
            node.insert(x.model.q[i], at);
            for (symbol, own) in [(x.model.v[i], self.v[i]), (x.model.p[i], self.p[i])] {
                if let Some(own) = own {
                    node.insert(symbol, x.arena.symbol(own));
                }
            }
        }
        node
    }

    /// Returns the coordinates on which the one-form of the step is defined, each with its
    /// component.
    fn one_form(&self) -> Vec<(usize, Expr)> {
        match self.internal {
            Some(form) => form.outer.iter().copied().zip(form.theta.clone()).collect(),
            None => {
                let paired = self.degeneracy.of(Role::Massless).into_iter();
                paired.map(|i| (i, self.degeneracy.alpha[i])).collect()
            }
        }
    }

    /// Returns a component of the one-form at a place. An affine component is written as its value
    /// at q₀ plus a linear term, so that differences do not cancel.
    fn one_form_at(
        &self,
        component: Expr,
        place: &HashMap<Symbol, Expr>,
        distance: impl Fn(usize, &mut Variables<'_>) -> Expr,
        x: &mut Variables<'_>,
    ) -> Expr {
        let is_affine = self
            .internal
            .map_or(self.degeneracy.is_affine, |form| form.is_affine);
        if !is_affine {
            return x.arena.substitute(component, place);
        }
        let start = start(x);
        let mut terms = vec![(1.0, x.arena.substitute(component, &start))];
        for i in 0..x.model.dof() {
            let slope = x.arena.diff(component, x.model.q[i]);
            let slope = x.arena.substitute(slope, &start);
            let distance = distance(i, x);
            terms.push((1.0, x.arena.mul(slope, distance)));
        }
        x.arena.sum(0.0, &terms)
    }

    /// Returns the discrete action.
    fn value(
        &self,
        node: &HashMap<Symbol, Expr>,
        end: &HashMap<Symbol, Expr>,
        x: &mut Variables<'_>,
    ) -> Expr {
        let h = x.arena.symbol(x.h);
        let rest = x.arena.substitute(self.degeneracy.rest, node);
        let mut terms = vec![(1.0, x.arena.mul(h, rest))];
        for i in 0..x.model.dof() {
            if let (Some(v), Some(p)) = (self.v[i], self.p[i]) {
                terms.push(x.displaced(i, v, p));
            }
        }
        for (i, component) in self.one_form() {
            let at_node = self.one_form_at(component, node, |k, x| self.distance(k, x), x);
            let d = x.arena.symbol(x.displacement[i]);
            terms.push((1.0, x.arena.mul(at_node, d)));
            if let Some(lambda) = self.lambda[i] {
                let lambda = x.arena.symbol(lambda);
                let start = start(x);
                let at_start = x.arena.substitute(component, &start);
                let at_end = x.arena.substitute(component, end);
                let difference = x.arena.sub(at_start, at_end);
                terms.push((1.0, x.arena.mul(lambda, difference)));
            }
        }
        terms.extend(x.noises(1.0, node));
        if self.c != 0.5 {
            let noises = 0..x.model.noises.len();
            let fields = noises.map(|a| match self.internal {
                Some(form) => internal_field(form, a, x),
                None => x.field(a, self.degeneracy.of(Role::Massive)),
            });
            let fields: Vec<_> = fields.collect();
            // the slope is taken at fixed p
            let correction = x.stratonovich(&fields, node);
            terms.push((self.c - 0.5, correction));
        }
        x.arena.sum(0.0, &terms)
    }

    /// Returns the conditions and equations at the ends.
    fn ends(&self, form: Form, end: &HashMap<Symbol, Expr>, x: &mut Variables<'_>) -> Ends {
        let n = x.model.dof();
        let momentum = x.symbols.declare_all(n, Meaning::End);
        let mut ends = Ends {
            unbalanced: self.inner.iter().map(Option::is_some).collect(),
            start: vec![None; n],
            end: vec![None; n],
            momentum,
            closures: Vec::new(),
            conditions: Vec::new(),
        };
        let start = start(x);
        for (i, component) in self.one_form() {
            ends.start[i] = Some(x.arena.substitute(component, &start));
            let closed = match (form, self.internal) {
                (Form::Projected, _) => self.lambda[i],
                (_, Some(internal)) => {
                    let at = internal.outer.iter().position(|&k| k == i);
                    at.map(|at| x.displacement[internal.inner[at]])
                }
                _ => None,
            };
            if let Some(unknown) = closed {
                let moved = |k: usize, x: &mut Variables<'_>| x.arena.symbol(x.displacement[k]);
                let at_end = self.one_form_at(component, end, moved, x);
                let p = x.arena.symbol(ends.momentum[i]);
                let residual = x.arena.sub(p, at_end);
                ends.closures.push(Closure { unknown, residual });
            }
        }
        for i in 0..n {
            if self.degeneracy.is(i, Role::Massive) {
                continue;
            }
            let alpha = self.degeneracy.alpha[i];
            ends.end[i] = Some(x.arena.substitute(alpha, end));
            let p = x.arena.symbol(x.start_p[i]);
            ends.conditions.push(consistent(p, alpha, &start, x));
        }
        for i in self.degeneracy.of(Role::Algebraic) {
            let slope = x.arena.diff(self.degeneracy.rest, x.model.q[i]);
            let residual = x.arena.substitute(slope, end);
            let unknown = x.displacement[i];
            ends.closures.push(Closure { unknown, residual });
            let zero = x.arena.constant(0.0);
            ends.conditions.push(consistent(zero, slope, &start, x));
        }
        ends
    }
}

/// Returns the values of the model's coordinates at the start. Time stays itself.
fn start(x: &mut Variables<'_>) -> HashMap<Symbol, Expr> {
    let pairs = x.model.q.iter().zip(&x.start_q);
    pairs.map(|(&q, &own)| (q, x.arena.symbol(own))).collect()
}

/// Returns an expression that is not negative if a number agrees with a function of q at the start:
/// the tolerance minus the difference, where the tolerance is relative to the terms of the function
/// to first order.
fn consistent(
    number: Expr,
    function: Expr,
    start: &HashMap<Symbol, Expr>,
    x: &mut Variables<'_>,
) -> Expr {
    let value = x.arena.substitute(function, start);
    let difference = x.arena.sub(number, value);
    let difference = x.arena.abs(difference);
    let mut terms = Vec::new();
    for part in [number, value] {
        terms.push((CONSISTENT, x.arena.abs(part)));
    }
    for &q in &x.model.q {
        let slope = x.arena.diff(function, q);
        let term = x.arena.product(&[(slope, 1)]);
        let q = x.arena.symbol(q);
        let term = x.arena.mul(term, q);
        let term = x.arena.substitute(term, start);
        terms.push((CONSISTENT, x.arena.abs(term)));
    }
    terms.push((-1.0, difference));
    x.arena.sum(0.0, &terms)
}

/// Returns, for each coordinate x, the shift w by a noise and the slope of the noise at fixed ϑ,
/// `∂G/∂x − ϑ_xᵀ w`.
fn internal_field(form: &Internal, noise: usize, x: &mut Variables<'_>) -> Vec<[Expr; 2]> {
    let g = x.model.noises[noise].hamiltonian;
    let zeros = vec![x.arena.constant(0.0); form.outer.len()];
    // without a formula, rules other than the midpoint rule are refused, so this value is not used
    let w = form.shifts.as_ref().map_or(zeros, |all| all[noise].clone());
    let mut field = Vec::new();
    for (at, &i) in form.outer.iter().enumerate() {
        let q = x.model.q[i];
        let mut terms = vec![(1.0, x.arena.diff(g, q))];
        for (&theta, &w) in form.theta.iter().zip(&w) {
            let slope = x.arena.diff(theta, q);
            terms.push((-1.0, x.arena.mul(slope, w)));
        }
        field.push([w[at], x.arena.sum(0.0, &terms)]);
    }
    field
}
