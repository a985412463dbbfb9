//! The rotations at the nodes of a rule.

use std::collections::HashMap;

use super::action::Variables;
use crate::algebra::{Expr, Symbol};
use crate::model::configuration::Block;
use crate::model::{Meaning, NodeQuantity};

/// A rotation at a node.
pub(crate) struct RotationAtNode {
    /// Number of its first entry in the configuration.
    pub(crate) first: usize,
    pub(crate) entries: Vec<Symbol>,
    pub(crate) values: Vec<Expr>,
    /// The number of the node among those of the rule.
    pub(crate) node: usize,
    pub(crate) place: NodePlace,
}

/// The place of a node in a step.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum NodePlace {
    Start,
    /// Halfway along the geodesic. `quarter` is `tan(θ/4)/θ`, for a step that turns by the angle θ.
    Middle {
        quarter: Expr,
    },
    End,
}

/// Returns the values of the entries of rotations at the nodes.
pub(crate) fn values_at_nodes(rotations: &[RotationAtNode]) -> HashMap<Symbol, Expr> {
    let pairs = rotations
        .iter()
        .flat_map(|r| r.entries.iter().zip(&r.values));
    pairs.map(|(&entry, &value)| (entry, value)).collect()
}

impl Variables<'_> {
    /// Returns the symbols of the start and of the displacement of a block, as expressions.
    pub(super) fn motion(&mut self, block: &Block) -> [Vec<Expr>; 2] {
        let start = self.start_q[block.entries.clone()].iter();
        let displacement = self.displacement[block.directions.clone()].iter();
        let start = start.map(|&s| self.arena.symbol(s)).collect();
        let displacement = displacement.map(|&s| self.arena.symbol(s)).collect();
        [start, displacement]
    }

    /// Declares symbols for the entries of a rotation at the node of this number, and adds them to
    /// the variables there.
    pub(super) fn rotation(
        &mut self,
        block: &Block,
        (number, place): (usize, NodePlace),
        values: Vec<Expr>,
        node: &mut HashMap<Symbol, Expr>,
    ) -> RotationAtNode {
        let mut rotation = RotationAtNode {
            first: block.entries.start,
            entries: Vec::new(),
            values: Vec::new(),
            node: number,
            place,
        };
        for (entry, value) in block.entries.clone().zip(values) {
            let symbol = self.symbols.declare(Meaning::NodeEntry(entry));
            node.insert(self.model.q[entry], self.arena.symbol(symbol));
            rotation.entries.push(symbol);
            let value = match place {
                NodePlace::Start => value,
                _ => self.at_node(number, NodeQuantity::Position(entry), value),
            };
            rotation.values.push(value);
        }
        rotation
    }
}
