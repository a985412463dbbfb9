//! Ranges of axes around the drawn points.

use std::ops::Range;

/// Room on each side, as a fraction of the length of the axis.
const ROOM: f64 = 0.05;

/// Returns the range of the finite numbers among `numbers`, with room around them; a range of
/// length 1 for a single number.
pub(super) fn around(numbers: impl IntoIterator<Item = f64>) -> Range<f64> {
    let finite = numbers.into_iter().filter(|x| x.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    if low > high {
        return 0.0..1.0;
    }
    // Numbers that differ by rounding errors count as one number.
    let length = high - low;
    let room = if length > 1e-12 * low.abs().max(high.abs()) {
        ROOM * length
    } else {
        0.5 * low.abs().max(f64::from(u8::from(low == 0.0)))
    };
    low - room..high + room
}
