//! Numbers that a trajectory carries between steps of a Gauss rule. The next step extrapolates its
//! first guess from them.
//!
//! Input: `L = 1 + R N S` numbers, the step size and `R` numbers for each coordinate at each stage.
//! Invariant: a guess changes the result of a step by no more than the rounding error of the
//! iteration. A step of another size does not use the numbers, and neither does a step with noise,
//! since increments of different steps are independent.

use super::stages::Rows;

/// Solves a step of size `h` from the stages of the step before. If this fails, or no stages are
/// recorded, solves it from the start. Replaces the numbers.
#[inline]
pub(super) fn solve_from_memory<
    T,
    const S: usize,
    const N: usize,
    const R: usize,
    const L: usize,
>(
    memory: &mut Option<[f64; L]>,
    h: f64,
    solve: impl Fn(Option<&[Rows<S, N>; R]>) -> Option<(T, [Rows<S, N>; R])>,
) -> Option<T> {
    const {
        assert!(
            L == 1 + R * N * S,
            "the step size and the rows of the stages"
        );
    };
    let before = memory
        .as_ref()
        .filter(|numbers| numbers[0] == h)
        .map(rows::<S, N, R, L>);
    let solved = before.and_then(|before| solve(Some(&before)));
    let Some((solution, stages)) = solved.or_else(|| solve(None)) else {
        *memory = None;
        return None;
    };
    let mut numbers = [h; L];
    let entries = stages.as_flattened().as_flattened();
    numbers[1..].copy_from_slice(entries);
    *memory = Some(numbers);
    Some(solution)
}

/// Returns the rows that follow the step size.
#[inline]
fn rows<const S: usize, const N: usize, const R: usize, const L: usize>(
    numbers: &[f64; L],
) -> [Rows<S, N>; R] {
    let mut rows = [[[0.0; S]; N]; R];
    rows.as_flattened_mut()
        .as_flattened_mut()
        .copy_from_slice(&numbers[1..]);
    rows
}
