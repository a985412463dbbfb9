//! The colours of Okabe and Ito, distinguishable with all common kinds of colour vision and in grey
//! print.
//!
//! Source: M. Okabe, K. Ito, "Color Universal Design" (2008), <https://jfly.uni-koeln.de/color/>.

/// Red, green, blue.
pub type Color = (u8, u8, u8);

/// Black.
pub const BLACK: Color = (0, 0, 0);
/// Orange.
pub const ORANGE: Color = (230, 159, 0);
/// Sky blue.
pub const SKY: Color = (86, 180, 233);
/// Bluish green.
pub const GREEN: Color = (0, 158, 115);
/// Blue.
pub const BLUE: Color = (0, 114, 178);
/// Vermilion.
pub const VERMILION: Color = (213, 94, 0);
/// Reddish purple.
pub const PURPLE: Color = (204, 121, 167);
/// Grey of frames and of the background.
pub const GREY: Color = (130, 130, 130);

/// A cycle for curves of equal rank.
pub const CYCLE: [Color; 7] = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK];
