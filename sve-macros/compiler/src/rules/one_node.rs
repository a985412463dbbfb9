//! The rules with one node, at `q̄ = q₀ + c d`, `t̄ = t₀ + c h`:
//!
//! ```text
//! S_d = h L(t̄,q̄,v) + ⟨p, d − h v⟩ − Σ G_a(t̄,q̄,p) ΔW_a
//!       + (c − ½) Σ_ab ⟨∂G_a/∂p, ∂G_b/∂q⟩ ΔW_a ΔW_b
//! ```
//!
//! The last term is the Stratonovich correction. A force does the work `⟨h F(t̄,q̄,v), δq̄⟩`, that
//! of a noise `⟨f_a(t̄,q̄,v) ΔW_a, δq̄⟩`, with a correction of its own
//! ([`correction`](super::correction)).

use std::collections::HashMap;

use super::Discretisation;
use super::action::{Discrete, Variables};
use super::degenerate::{END, INNER, SHIFTED};
use super::rotations::{NodePlace, RotationAtNode};
use super::textbook::{self, Features, Point, Textbook};
use crate::algebra::{Expr, Symbol};
use crate::model::chart::{Chart, Midpoint};
use crate::model::configuration::{Block, Factor};
use crate::model::{Family, NodeQuantity, Unknown};

/// A rule with one node.
pub(super) struct OneNode {
    /// c.
    pub(super) place: f64,
}

impl Discretisation for OneNode {
    fn action(&self, x: &mut Variables<'_>) -> Discrete {
        let c = self.place;
        let n = x.model.dof();
        let v = x.symbols.declare_all(n, Unknown::of(Family::Velocity));
        let p = x.symbols.declare_all(n, Unknown::of(Family::Momentum));
        let h = x.arena.symbol(x.h);
        let mut node = HashMap::new();
        let t = x.arena.symbol(x.model.time);
        let t_node = x.arena.sum(0.0, &[(1.0, t), (c, h)]);
        node.insert(x.model.time, x.at_node(0, NodeQuantity::Time, t_node));
        let mut rotations = Vec::new();
        for block in x.model.configuration().blocks() {
            if block.factor == Factor::Rotation {
                rotations.push(rotation_at_midpoint(x, &block, &mut node));
            }
            for (entry, i) in block.entries.zip(block.directions) {
                if block.factor != Factor::Rotation {
                    let (q, d) = (
                        x.arena.symbol(x.start_q[entry]),
                        x.arena.symbol(x.displacement[i]),
                    );
                    let at = x.arena.sum(0.0, &[(1.0, q), (c, d)]);
                    let at = x.at_node(0, NodeQuantity::Position(entry), at);
                    node.insert(x.model.q[entry], at);
                }
                node.insert(x.model.v[i], x.arena.symbol(v[i]));
                node.insert(x.model.p[i], x.arena.symbol(p[i]));
            }
        }

        let mut terms = vec![(1.0, x.lagrangian(&node))];
        terms.extend((0..n).map(|i| x.displaced(i, v[i], p[i])));
        terms.extend(x.noises(1.0, &node));
        // the factor of the correction is zero in the middle of the step
        if c != 0.5 {
            let noises = 0..x.model.noises.len();
            let fields: Vec<_> = noises.map(|a| x.field(a, 0..n)).collect();
            let correction = x.stratonovich(&fields, &node);
            terms.push((c - 0.5, correction));
        }
        let value = x.arena.sum(0.0, &terms);
        let mut work = x.work(1.0, 0, &node);
        if c != 0.5 {
            work.extend(x.correction_work(c, &node));
        }
        Discrete {
            value,
            internal: v.into_iter().chain(p).collect(),
            work,
            rotations,
        }
    }

    fn point(&self, node: usize) -> Point {
        let position = match node {
            END => return textbook::END,
            INNER => "q̄",
            SHIFTED => "q*",
            _ => self.written().position,
        };
        Point {
            position,
            ..self.written()
        }
    }

    fn textbook(&self, system: &Features) -> Textbook {
        let displacement = system.pairing("p", "q₁ − q₀ − h·v");
        let mut textbook = system.textbook(&[self.written()], &displacement);
        // the Stratonovich correction
        if self.place != 0.5 && system.moves_both {
            let sign = if self.place > 0.5 { '+' } else { '−' };
            let correction = if system.gammas + system.hamiltonians == 1 {
                "⟨∂H₁/∂p, ∂H₁/∂q⟩·ΔW²"
            } else {
                textbook.notation.push("G = −γ or H₁".to_owned());
                "Σ ⟨∂G[i]/∂p, ∂G[j]/∂q⟩·ΔW[i]·ΔW[j]"
            };
            textbook.action = format!("{} {sign} ½·{correction}", textbook.action);
        }
        if self.place != 0.5 && system.corrects_forces {
            let sign = if self.place > 0.5 { '−' } else { '+' };
            let q = self.written().position;
            textbook.work = format!(
                "{} {sign} ½·Σ (⟨P[i, j], δ{q}⟩ − ⟨Q[i, j], δp⟩)·ΔW[i]·ΔW[j]",
                textbook.work
            );
            textbook.notation.push(CORRECTED.to_owned());
        }
        textbook
    }
}

/// The notation of the correction of noises that are forces.
const CORRECTED: &str = "(Q, P)[i, j] the part with f of ∂X[i]/∂q·∂G[j]/∂p + ∂X[i]/∂p·(∂G[j]/∂q − f[j]), X = (∂G/∂p, f − ∂G/∂q)";

impl OneNode {
    fn written(&self) -> Point {
        if self.place == 0.0 {
            textbook::START
        } else if self.place == 1.0 {
            textbook::END
        } else {
            textbook::MIDDLE
        }
    }
}

/// Adds the entries of a rotation at the node of the midpoint rule, halfway along the geodesic.
/// Other rules with one node do not apply to rotations ([`applicable`](super::applicable)).
fn rotation_at_midpoint(
    x: &mut Variables<'_>,
    block: &Block,
    node: &mut HashMap<Symbol, Expr>,
) -> RotationAtNode {
    let [start, increment] = x.motion(block);
    let Midpoint { entries, quarter } = Chart::new(&increment, x.arena).midpoint(&start, x.arena);
    let place = NodePlace::Middle { quarter };
    x.rotation(block, (0, place), entries, node)
}
