//! The quantities at the quadrature nodes of a rule. Each has an identity in the arena, by which
//! later stages find it.

use crate::algebra::{Arena, Expr, Identity, Node};

/// The node at the end of a step with constraints. No rule uses this number.
pub(crate) const END: usize = 1 << 20;

/// The bit of identities of other intermediate results.
pub(super) const OTHERS: u64 = 1 << 63;

/// A quantity at a quadrature node of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AtNode {
    /// Number of the node.
    pub(crate) node: usize,
    pub(crate) quantity: NodeQuantity,
}

impl AtNode {
    /// Returns the identity of the intermediate result of the quantity in the arena.
    pub(crate) fn identity(self) -> Identity {
        let (kind, index) = match self.quantity {
            NodeQuantity::Time => (0, 0),
            NodeQuantity::Position(i) => (1, i),
            NodeQuantity::Velocity(i) => (2, i),
        };
        Identity((self.node as u64) << 34 | kind << 32 | index as u64)
    }

    /// Returns the quantity that an expression represents; `None` if the expression is not a
    /// quantity at a node.
    pub(crate) fn of(expr: Expr, arena: &Arena) -> Option<Self> {
        let Node::Opaque(_, Some(Identity(bits))) = *arena.node(expr) else {
            return None;
        };
        if bits & OTHERS != 0 {
            return None;
        }
        let index = (bits & 0xffff_ffff) as usize;
        let quantity = match bits >> 32 & 3 {
            0 => NodeQuantity::Time,
            1 => NodeQuantity::Position(index),
            _ => NodeQuantity::Velocity(index),
        };
        Some(Self {
            node: (bits >> 34) as usize,
            quantity,
        })
    }
}

/// The quantities at a quadrature node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NodeQuantity {
    Time,
    /// A component of the position.
    Position(usize),
    /// A component of the velocity.
    Velocity(usize),
}

impl std::fmt::Display for AtNode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let node = match self.node {
            0 => "node".to_owned(),
            number => format!("node{number}"),
        };
        match self.quantity {
            NodeQuantity::Time => write!(f, "t_{node}"),
            NodeQuantity::Position(i) => write!(f, "q_{node}_{i}"),
            NodeQuantity::Velocity(i) => write!(f, "v_{node}_{i}"),
        }
    }
}
