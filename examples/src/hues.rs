//! The hues of the variational rules, the same in all figures.

use crate::palette::{self, Color};

/// The midpoint rule.
pub const MIDPOINT: Color = palette::BLUE;
/// The rule of the initial point.
pub const INITIAL_POINT: Color = palette::GREEN;
/// The rule of the endpoint.
pub const ENDPOINT: Color = palette::SKY;
/// The rule of Störmer and Verlet.
pub const STORMER_VERLET: Color = palette::VERMILION;
