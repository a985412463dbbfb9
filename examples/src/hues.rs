//! The hues of rules and of methods for comparison, the same in all figures.

use crate::palette::{self, Color};

/// The midpoint rule.
pub const MIDPOINT: Color = palette::BLUE;
/// The rule of the initial point.
pub const INITIAL_POINT: Color = palette::GREEN;
/// The rule of the endpoint.
pub const ENDPOINT: Color = palette::SKY;
/// The rule of Störmer and Verlet.
pub const STORMER_VERLET: Color = palette::VERMILION;
/// The methods of Euler and Maruyama, forward and backward.
pub const EULER_MARUYAMA: Color = palette::GREY;
/// The method of Heun.
pub const HEUN: Color = palette::ORANGE;
/// The method of Runge and Kutta of order 4.
pub const RUNGE_KUTTA_4: Color = palette::BLACK;
/// The rules of Gauss.
pub const GAUSS: Color = palette::PURPLE;
/// The rule of a Taylor series.
pub const TAYLOR: Color = (122, 78, 45);
/// heyoka, which occurs in no figure with the method of Heun.
pub const HEYOKA: Color = palette::ORANGE;
/// The exact solution.
pub const EXACT: Color = palette::BLACK;
/// A path with noise beside the path of the same method without.
pub const WITH_NOISE: Color = (80, 50, 145);
