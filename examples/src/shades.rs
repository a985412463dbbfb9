//! Colours for numbers: of many curves in an order, or of a quantity.

use crate::palette::Color;

/// Returns a colour for a number between 0 and 1, from blue over light blue and orange to red.
pub fn shade(part: f64) -> Color {
    let stops = [
        (0.0, (49, 54, 149)),
        (0.33, (116, 173, 209)),
        (0.66, (253, 174, 97)),
        (1.0, (165, 0, 38)),
    ];
    let x = part.clamp(0.0, 1.0);
    let at = stops
        .windows(2)
        .find(|w| x <= w[1].0)
        .unwrap_or(&stops[2..]);
    let part = (x - at[0].0) / (at[1].0 - at[0].0);
    #[allow(clippy::cast_sign_loss, clippy::cast_possible_truncation)] // between two colours
    let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))) as u8;
    let (a, b) = (at[0].1, at[1].1);
    (mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}
