//! The rule with its node at the end of the step.

use super::one_node::OneNode;

pub(super) static ENDPOINT: OneNode = OneNode {
    attribute_name: "endpoint",
    type_name: "Endpoint",
    deterministic_order: 1,
    weak2: None,
    place: 1.0,
    time: "t₁",
    position: "q₁",
    time_is: Some("t₁ = t₀ + h"),
    position_is: None,
};
