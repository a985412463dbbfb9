//! The rule of Störmer and Verlet: the trapezoidal mean of L at both ends, with one velocity,
//!
//! ```text
//! S_d = ½h [L(t₀,q₀,v) + L(t₁,q₁,v)] + ⟨p, d − h v⟩ − ½ Σ [G_a(t₀,q₀,p) + G_a(t₁,q₁,p)] ΔW_a
//! ```
//!
//! It is symmetric, so it needs no Stratonovich correction. For L = T(v) − V(q) with constant
//! masses and noise in q alone the step is explicit: kick, drift, kick. With constraints the step
//! is RATTLE (Andersen 1983). A force does half of its work at each end. Source: Hairer, Lubich,
//! Wanner, *Geometric numerical integration illustrated by the Störmer–Verlet method*, Acta
//! Numerica 12 (2003).

use std::collections::HashMap;

use super::Discretisation;
use super::action::{Discrete, Variables};
use super::rotations::{NodePlace, RotationAtNode};
use super::textbook::{self, Features, Point, Textbook};
use crate::algebra::{Expr, Symbol};
use crate::model::chart::Chart;
use crate::model::configuration::Factor;
use crate::model::{Family, NodeQuantity, Unknown};

pub(super) struct StormerVerlet;

/// The node at the end of the step. The other node is the start, whose quantities are the state.
const END: usize = 0;

impl Discretisation for StormerVerlet {
    fn action(&self, x: &mut Variables<'_>) -> Discrete {
        let n = x.model.dof();
        let v = x.symbols.declare_all(n, Unknown::of(Family::Velocity));
        let p = x.symbols.declare_all(n, Unknown::of(Family::Momentum));
        let (nodes, rotations) = ends(x, &v, &p);
        let mut terms = Vec::new();
        for node in &nodes {
            terms.push((0.5, x.lagrangian(node)));
            terms.extend(x.noises(0.5, node));
        }
        terms.extend((0..n).map(|i| x.displaced(i, v[i], p[i])));
        let value = x.arena.sum(0.0, &terms);
        let numbered = nodes.iter().enumerate();
        let work = numbered.flat_map(|(number, node)| x.work(0.5, number, node));
        let work = work.collect();
        Discrete {
            value,
            internal: v.into_iter().chain(p).collect(),
            work,
            rotations,
        }
    }

    fn point(&self, _: usize) -> Point {
        textbook::END
    }

    fn textbook(&self, system: &Features) -> Textbook {
        let displacement = system.pairing("p", "q₁ − q₀ − h·v");
        system.textbook(&[textbook::START, textbook::END], &displacement)
    }
}

/// Returns the values of the model's variables at the start and at the end, and the rotations
/// there.
fn ends(
    x: &mut Variables<'_>,
    v: &[Symbol],
    p: &[Symbol],
) -> ([HashMap<Symbol, Expr>; 2], Vec<RotationAtNode>) {
    let (mut start, mut end) = (HashMap::new(), HashMap::new());
    let (t, h) = (x.arena.symbol(x.model.time), x.arena.symbol(x.h));
    let t_end = x.arena.add(t, h);
    end.insert(x.model.time, x.at_node(END, NodeQuantity::Time, t_end));
    let mut rotations = Vec::new();
    for block in x.model.configuration().blocks() {
        let [from, moved] = x.motion(&block);
        if block.factor == Factor::Rotation {
            let to = Chart::new(&moved, x.arena).end(&from, x.arena);
            rotations.push(x.rotation(&block, (0, NodePlace::Start), from, &mut start));
            rotations.push(x.rotation(&block, (1, NodePlace::End), to, &mut end));
        } else {
            for (entry, (q, d)) in block.entries.clone().zip(from.into_iter().zip(moved)) {
                let q_end = x.arena.add(q, d);
                let q_end = x.at_node(END, NodeQuantity::Position(entry), q_end);
                start.insert(x.model.q[entry], q);
                end.insert(x.model.q[entry], q_end);
            }
        }
        for i in block.directions {
            for node in [&mut start, &mut end] {
                node.insert(x.model.v[i], x.arena.symbol(v[i]));
                node.insert(x.model.p[i], x.arena.symbol(p[i]));
            }
        }
    }
    ([start, end], rotations)
}
