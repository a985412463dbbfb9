//! The rule with its node in the middle of the step, which needs no Stratonovich correction.

use super::Weak2;
use super::one_node::OneNode;

pub(super) static MIDPOINT: OneNode = OneNode {
    attribute_name: "midpoint",
    type_name: "Midpoint",
    deterministic_order: 2,
    weak2: Some(Weak2 {
        factor: 0.25,
        takes_h1: false,
    }),
    place: 0.5,
    time: "t̄",
    position: "q̄",
    time_is: Some("t̄ = t₀ + h/2"),
    position_is: Some("q̄ = (q₀ + q₁)/2"),
};
