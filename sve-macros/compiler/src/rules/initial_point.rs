//! The rule with its node at the start of the step.

use super::one_node::OneNode;

pub(super) static INITIAL_POINT: OneNode = OneNode {
    attribute_name: "initial_point",
    type_name: "InitialPoint",
    deterministic_order: 1,
    weak2: None,
    place: 0.0,
    time: "t₀",
    position: "q₀",
    time_is: None,
    position_is: None,
};
