//! Times of steps.

/// Returns the time `start + steps h`, rounded once by a fused operation, which has the same bits on every machine.
#[inline]
pub(crate) fn time_after(start: f64, steps: u64, h: f64) -> f64 {
    let steps = steps as f64;
    if start == 0.0 {
        // The product alone is rounded once too, and is faster on machines without a fused operation.
        steps * h
    } else {
        steps.mul_add(h, start)
    }
}

/// Returns whether a step can lead from the time `t` to `end`.
#[inline]
pub(crate) fn is_next_time(t: f64, end: f64) -> bool {
    end.is_finite() && end != t
}
