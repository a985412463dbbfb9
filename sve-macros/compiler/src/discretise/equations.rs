//! Discrete action → implicit discrete Euler–Lagrange equations. The derivation is the same for
//! every rule.
//!
//! Input: an [`Action`]. Output: the equations that determine the unknowns, and equivalent
//! expressions of the momentum increment.
//!
//! ```text
//! 0 = ∂S/∂x   (each internal x)        0 = ∂S/∂d − ∂S/∂q₀ − p₀        p₁ − p₀ = ∂S/∂q₀
//! ```
//!
//! These are the equations of a vector; [`chart`](crate::model::chart) has the
//! equations of a rotation. If a momentum is a function of the configuration, this function
//! replaces p₀ and p₁, and equations at the end may be added
//! ([`Ends`](crate::rules::action::Ends)). If there is a force, its work under a variation of x is
//! added to each ∂S/∂x (Lagrange–d'Alembert principle).

use std::collections::HashMap;

use super::constrained;
use crate::algebra::{Arena, Expr, Node, Symbol};
use crate::model::Symbols;
use crate::model::chart::{Chart, Momenta};
use crate::model::configuration::{Block, Factor, cross, directions_of_rotation};
use crate::model::domain::Condition;
use crate::rules::action::{Action, Place, Work};
use crate::rules::constraints::MeanValue;
use crate::rules::rotations::{NodePlace, values_at_nodes};

/// The equations of a step.
pub(crate) struct Equations {
    /// The unknowns, in the order in which elimination is preferred.
    pub(crate) unknowns: Vec<Symbol>,
    /// The residuals, which vanish at a solution.
    pub(crate) residuals: Vec<Expr>,
    /// For each residual, the variable in which the action is varied, or the unknown that an
    /// equation at the end determines.
    pub(crate) variations: Vec<Symbol>,
    /// `q₁ − q₀`.
    pub(crate) dq: Vec<Expr>,
    /// `p₁ − p₀`: for each component, expressions that are equal at a solution.
    pub(crate) dp: Vec<Vec<Expr>>,
    /// The equations to leading order in the step size, if the first guess is solved from these.
    pub(crate) leading: Option<Leading>,
    /// Unknowns that are taken as known if this makes the other unknowns of their block explicit.
    pub(crate) torn: Vec<Symbol>,
    /// Conditions that must hold in addition to the equations.
    pub(crate) conditions: Vec<Condition<Expr>>,
    /// Additional results of a step.
    pub(crate) reported: Vec<Expr>,
    /// The entries of rotations at nodes at the end of the step.
    pub(crate) turned: Vec<Expr>,
    /// Expressions that must not be negative if a solution is accepted because its iteration
    /// contracts.
    pub(crate) guards: Vec<Expr>,
}

/// The equations to leading order in the step size.
pub(crate) struct Leading {
    /// One residual for each equation.
    pub(crate) residuals: Vec<Expr>,
    /// For each equation of a constraint, a form that has a limit for h → 0; `None` for other
    /// equations.
    pub(crate) mean_values: Vec<Option<MeanValue>>,
    /// For each residual its variation, as in [`Equations`].
    pub(crate) variations: Vec<Symbol>,
    /// For each residual the scale that it is compared with, if this is not the sum of the
    /// magnitudes of its terms.
    pub(crate) scales: Vec<Option<Expr>>,
    /// True if the determinant of their Jacobian has the same sign as at the solution.
    pub(crate) has_sign: bool,
}

/// Derives the equations of a step from its action.
pub(crate) fn equations(action: &Action, symbols: &Symbols, arena: &mut Arena) -> Equations {
    let mut rows = Rows::default();
    for &x in &action.internal {
        let stationary = variation_at_nodes(action, x, arena);
        rows.add(x, divide_out(arena, stationary, action.h));
    }
    for block in action.configuration.blocks() {
        rows.add_block(&block, action, arena);
    }
    let ends = &action.ends;
    let momenta = ends.momentum.iter().copied().zip(rows.p1.iter().copied());
    let at_end: HashMap<Symbol, Expr> = momenta.collect();
    for closure in &ends.closures {
        let residual = arena.substitute(closure.residual, &at_end);
        rows.add(closure.unknown, residual);
    }
    // elimination is preferred for displacements, then for multipliers, then for velocities
    let displacement = action.displacement.iter();
    let unknowns = displacement.chain(action.internal.iter().rev());
    let mut unknowns: Vec<Symbol> = unknowns.copied().collect();
    let closing = ends.closures.iter().map(|closure| closure.unknown);
    unknowns.extend(closing.filter(|unknown| !action.displacement.contains(unknown)));
    let dq = action.displacement.iter();
    let dq = dq.map(|&d| arena.symbol(d)).collect();
    let equations = Equations {
        unknowns,
        residuals: rows.residuals,
        variations: rows.variations,
        dq,
        dp: rows.dp,
        leading: None,
        torn: Vec::new(),
        conditions: Vec::new(),
        reported: Vec::new(),
        turned: action.turned().flat_map(|r| r.values.clone()).collect(),
        guards: Vec::new(),
    };
    match &action.enforced {
        Some(enforced) => {
            constrained::extend(equations, &rows.p1, enforced, action, symbols, arena)
        }
        None => equations,
    }
}

/// The equations that are complete so far.
#[derive(Default)]
struct Rows {
    residuals: Vec<Expr>,
    variations: Vec<Symbol>,
    dp: Vec<Vec<Expr>>,
    /// ∂S/∂d of the coordinates of vectors, which is p₁.
    p1: Vec<Expr>,
}

impl Rows {
    fn add(&mut self, variation: Symbol, residual: Expr) {
        self.variations.push(variation);
        self.residuals.push(residual);
    }

    /// Adds the momentum balances of a factor of the configuration.
    fn add_block(&mut self, block: &Block, action: &Action, arena: &mut Arena) {
        if block.factor == Factor::Rotation {
            let momenta = momenta_of_rotation(action, block, arena);
            // the unknowns are in descending order too, so that the pivots stand on the diagonal
            let turned = action.displacement[block.directions.clone()].iter();
            for (&turned, balance) in turned.zip(momenta.balance).rev() {
                self.add(turned, balance);
            }
            let changes = momenta.change.into_iter();
            self.dp.extend(changes.map(|change| vec![change]));
            return;
        }
        for (entry, i) in block.entries.clone().zip(block.directions.clone()) {
            self.add_coordinate(entry, i, action, arena);
        }
    }

    /// Adds the momentum balance of a coordinate of a vector.
    fn add_coordinate(&mut self, entry: usize, i: usize, action: &Action, arena: &mut Arena) {
        let ends = &action.ends;
        let end = variation_at_nodes(action, action.displacement[i], arena);
        self.p1.push(end);
        let function = ends.end.get(i).copied().flatten();
        if let Some(function) = function {
            let p0 = arena.symbol(action.start_p[i]);
            self.dp.push(vec![arena.sub(function, p0)]);
        }
        if ends.unbalanced.get(i) == Some(&true) {
            return;
        }
        let kick = variation_at_nodes(action, action.start_q[entry], arena);
        let p0 = match ends.start.get(i) {
            Some(&Some(function)) => function,
            _ => arena.symbol(action.start_p[i]),
        };
        let balance = arena.sum(0.0, &[(1.0, end), (-1.0, kick), (-1.0, p0)]);
        self.add(action.displacement[i], balance);
        if function.is_none() {
            // Each form is ∂S/∂q₀ plus a multiple of a residual. The multiple 1 gives ∂S/∂d − p₀.
            // The multiple 2 eliminates the force from the midpoint rule, p₁ = 2p − p₀.
            let mut form = |k| arena.sum(0.0, &[(1.0, kick), (k, balance)]);
            self.dp.push([0.0, 1.0, 2.0].map(&mut form).into());
        }
    }
}

/// The equations of the momentum of a rotation.
struct MomentaOfRotation {
    /// The residual, which vanishes at a solution.
    balance: Vec<Expr>,
    /// Π₁ − Π₀.
    change: Vec<Expr>,
}

/// Derives the momenta of a rotation from `g = ∂S/∂x` and τ, the derivative in the rotation at the
/// node ([`chart`](crate::model::chart)): `Π₁ − Π₀ = τ − x × g`.
fn momenta_of_rotation(action: &Action, block: &Block, arena: &mut Arena) -> MomentaOfRotation {
    let displacement = &action.displacement[block.directions.clone()];
    let x: Vec<Expr> = displacement.iter().map(|&s| arena.symbol(s)).collect();
    let g: Vec<Expr> = displacement
        .iter()
        .map(|&s| variation(action, s, arena))
        .collect();
    let at_nodes = action.rotations.iter();
    let at_nodes = at_nodes.filter(|node| node.first == block.entries.start);
    let mut torques = Vec::new();
    for node in at_nodes {
        let slopes: Vec<Expr> = node
            .entries
            .iter()
            .map(|&s| variation(action, s, arena))
            .collect();
        let mut torque = directions_of_rotation(&slopes, &node.entries, arena);
        for (k, i) in block.directions.clone().enumerate() {
            torque[k] = with_torque(torque[k], [node.node, i], &action.work, arena);
        }
        let zero = arena.constant(0.0);
        if torque.iter().any(|&torque| torque != zero) {
            torques.push((torque, node.place));
        }
    }
    let is_inner = |(_, place): &(_, NodePlace)| matches!(place, NodePlace::Middle { .. });
    let start = if torques.iter().any(is_inner) {
        Chart::new(&x, arena).momenta().at_start(&g, arena)
    } else {
        Momenta::new(&x, arena).at_start(&g, arena)
    };
    let turned = cross(&x, &g, arena);
    let mut balance: Vec<Vec<(f64, Expr)>> = Vec::new();
    let mut change = Vec::new();
    for (k, i) in block.directions.clone().enumerate() {
        let p0 = arena.symbol(action.start_p[i]);
        balance.push(vec![(1.0, start[k]), (-1.0, p0)]);
        change.push(vec![(-1.0, turned[k])]);
    }
    for (torque, place) in torques {
        let across = cross(&x, &torque, arena);
        for k in 0..torque.len() {
            match place {
                NodePlace::Start => balance[k].push((-1.0, torque[k])),
                NodePlace::Middle { quarter } => {
                    let across = arena.mul(quarter, across[k]);
                    balance[k].extend([(-0.5, torque[k]), (-0.5, across)]);
                }
                NodePlace::End => {}
            }
            change[k].push((1.0, torque[k]));
        }
    }
    let values = values_at_nodes(&action.rotations);
    let mut sums = |rows: Vec<Vec<(f64, Expr)>>| -> Vec<Expr> {
        let sums = rows.into_iter().map(|terms| {
            let sum = arena.sum(0.0, &terms);
            arena.substitute(sum, &values)
        });
        sums.collect()
    };
    MomentaOfRotation {
        balance: sums(balance),
        change: sums(change),
    }
}

/// Returns a variation in which the rotations at the nodes have their values.
fn variation_at_nodes(action: &Action, x: Symbol, arena: &mut Arena) -> Expr {
    let variation = variation(action, x, arena);
    if action.rotations.is_empty() {
        return variation;
    }
    arena.substitute(variation, &values_at_nodes(&action.rotations))
}

/// Returns `∂S/∂x` plus the work of the force on the coordinates of the nodes.
fn variation(action: &Action, x: Symbol, arena: &mut Arena) -> Expr {
    let mut terms = vec![(1.0, arena.diff(action.varied, x))];
    for Work { impulse, place } in &action.work {
        if let Place::Coordinate(place) = place {
            let displacement = arena.diff(*place, x);
            terms.push((1.0, arena.mul(*impulse, displacement)));
        }
    }
    arena.sum(0.0, &terms)
}

/// Returns the derivative in a direction of a rotation at a node, plus the torque of the force
/// about this axis. `turned` has the numbers of the node and of the direction.
fn with_torque(slope: Expr, turned: [usize; 2], work: &[Work], arena: &mut Arena) -> Expr {
    let turns = work.iter().filter_map(|work| match work.place {
        Place::Turn { node, direction } if [node, direction] == turned => Some((1.0, work.impulse)),
        _ => None,
    });
    let terms: Vec<(f64, Expr)> = [(1.0, slope)].into_iter().chain(turns).collect();
    arena.sum(0.0, &terms)
}

/// Divides a residual by the highest power of `h` that is a factor of each of its terms. The
/// quotient does not vanish with h.
fn divide_out(arena: &mut Arena, expr: Expr, h: Symbol) -> Expr {
    let h = arena.symbol(h);
    let power = |arena: &Arena, term: Expr| match arena.node(term) {
        _ if term == h => 1,
        Node::Product(factors) => factors.iter().find(|f| f.0 == h).map_or(0, |f| f.1),
        _ => 0,
    };
    let common = match arena.node(expr) {
        Node::Sum(constant, terms) if constant.get() == 0.0 => {
            terms.iter().map(|t| power(arena, t.0)).min().unwrap_or(0)
        }
        _ => power(arena, expr),
    };
    if common <= 0 {
        return expr;
    }
    match arena.node(expr).clone() {
        Node::Sum(_, terms) => {
            let terms: Vec<_> = terms
                .iter()
                .map(|&(term, c)| (c.get(), arena.product(&[(term, 1), (h, -common)])))
                .collect();
            arena.sum(0.0, &terms)
        }
        _ => arena.product(&[(expr, 1), (h, -common)]),
    }
}
