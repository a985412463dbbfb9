//! The second-order Taylor variational integrator (Schmitt, Shingel, Leok): with the initial
//! velocity `v` and the acceleration `a` of the Euler–Lagrange flow at `(q₀, v)`,
//!
//! ```text
//! S_d = ½h [ L(q₀,v) + L(q₀+hv, v+ha) ] + ⟨μ, d − hv − ½h²a⟩
//!       + ½h² ⟨ν, L_vv a + L_vq v + L_vt − L_q⟩
//! ```
//!
//! `v` and `a` are defined by equations, so the action contains them with the multipliers μ and ν.
//! The multiplier ν is scaled by ½h² to have the size of a momentum. A force F enters the flow, as
//! `… − F` in the last bracket, and does half of its work at each end.

use std::collections::HashMap;

use super::Discretisation;
use super::action::{Discrete, Variables};
use super::textbook::{self, Features, Point, Textbook};
use crate::algebra::{Expr, Symbol};
use crate::model::{Family, NodeQuantity, Unknown};

pub(super) struct Taylor2;

/// The node at the predicted end of the step. The other node is the start, whose quantities are the
/// state.
const END: usize = 0;

/// The notation of the predicted end.
const PREDICTED: Point = Point {
    position: "q̂",
    velocity: "v̂",
    others_are: &["q̂ = q₀ + h·v", "v̂ = v + h·a"],
    ..textbook::END
};

impl Discretisation for Taylor2 {
    fn action(&self, x: &mut Variables<'_>) -> Discrete {
        let n = x.model.dof();
        let families = [
            Family::Velocity,
            Family::Acceleration,
            Family::VelocityMultiplier,
            Family::AccelerationMultiplier,
        ];
        let [v, a, mu, nu] = families.map(|f| x.symbols.declare_all(n, Unknown::of(f)));
        let h = x.arena.symbol(x.h);
        let t = x.arena.symbol(x.model.time);
        let (mut start, mut end) = (HashMap::new(), HashMap::new());
        let t_end = x.arena.add(t, h);
        end.insert(x.model.time, x.at_node(END, NodeQuantity::Time, t_end));
        for i in 0..n {
            let [q, v, a] = [x.start_q[i], v[i], a[i]].map(|s| x.arena.symbol(s));
            let (hv, ha) = (x.arena.mul(h, v), x.arena.mul(h, a));
            let (q_end, v_end) = (x.arena.add(q, hv), x.arena.add(v, ha));
            start.insert(x.model.q[i], q);
            start.insert(x.model.v[i], v);
            end.insert(
                x.model.q[i],
                x.at_node(END, NodeQuantity::Position(i), q_end),
            );
            end.insert(
                x.model.v[i],
                x.at_node(END, NodeQuantity::Velocity(i), v_end),
            );
        }
        let accelerations: Vec<Expr> = a.iter().map(|&s| x.arena.symbol(s)).collect();
        let mut terms = Vec::new();
        for node in [&start, &end] {
            terms.push((0.5, x.lagrangian(node)));
        }
        for i in 0..n {
            let [d, v, a, mu, nu] =
                [x.displacement[i], v[i], a[i], mu[i], nu[i]].map(|s| x.arena.symbol(s));
            let hv = x.arena.mul(h, v);
            let half_h2_a = x.arena.product(&[(h, 2), (a, 1)]);
            let constraint = x.arena.sum(0.0, &[(1.0, d), (-1.0, hv), (-0.5, half_h2_a)]);
            terms.push((1.0, x.arena.mul(mu, constraint)));
            let flow = euler_lagrange(x, i, &start, &accelerations);
            terms.push((0.5, x.arena.product(&[(h, 2), (nu, 1), (flow, 1)])));
        }
        let value = x.arena.sum(0.0, &terms);
        let mut work = x.work(0.5, 0, &start);
        work.extend(x.work(0.5, 1, &end));
        Discrete {
            value,
            internal: [v, a, mu, nu].concat(),
            work,
            rotations: Vec::new(),
        }
    }

    fn point(&self, _: usize) -> Point {
        PREDICTED
    }

    fn letters(&self) -> &'static [&'static str] {
        &["a"]
    }

    fn textbook(&self, system: &Features) -> Textbook {
        let drift = if system.is_timed { " + L_vt" } else { "" };
        let force = if system.is_forced { " − F" } else { "" };
        let displacement = system.pairing("μ", "q₁ − q₀ − h·v − h²·a/2");
        let flow = system.pairing("ν", &format!("L_vv·a + L_vq·v{drift} − L_q{force}"));
        system.textbook(
            &[textbook::START, PREDICTED],
            &format!("{displacement} + h²·{flow}/2"),
        )
    }
}

/// Returns component `i` of `L_vv a + L_vq v + L_vt − L_q − F` at a node.
fn euler_lagrange(
    x: &mut Variables<'_>,
    i: usize,
    node: &HashMap<Symbol, Expr>,
    a: &[Expr],
) -> Expr {
    let momentum = x.arena.diff(x.model.lagrangian, x.model.v[i]);
    let force = x.arena.diff(x.model.lagrangian, x.model.q[i]);
    let drift = x.arena.diff(momentum, x.model.time);
    let mut terms = vec![(1.0, drift), (-1.0, force)];
    terms.extend(x.model.force.iter().map(|f| (-1.0, f[i])));
    for j in 0..x.model.dof() {
        let v = x.arena.symbol(x.model.v[j]);
        let moved = x.arena.diff(momentum, x.model.q[j]);
        terms.push((1.0, x.arena.mul(moved, v)));
        let mass = x.arena.diff(momentum, x.model.v[j]);
        terms.push((1.0, x.arena.mul(mass, a[j])));
    }
    let sum = x.arena.sum(0.0, &terms);
    x.arena.substitute(sum, node)
}
