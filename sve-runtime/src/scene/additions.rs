//! Impulses that are added to momenta, with tests of the results.

use super::Row;
use super::drift::all_finite;

/// Returns the number of the first component that is not finite.
#[cold]
pub(super) fn first_not_finite(numbers: &[f64]) -> usize {
    let found = numbers.iter().position(|x| !x.is_finite());
    found.unwrap_or_default()
}

/// Adds impulses once or twice.
///
/// # Errors
/// The number of a component whose sum is not finite, if sums are tested; nothing is then added.
#[inline(always)]
pub(super) fn move_all<const TWICE: bool, R: Row>(
    to: &mut [R],
    sum: &mut [R],
    is_tested: bool,
) -> Result<(), usize> {
    let (to, sum) = (R::numbers_mut(to), R::numbers_mut(sum));
    let sums = to
        .iter()
        .zip(&*sum)
        .map(|(&to, &sum)| added::<TWICE>(to, sum));
    if is_tested && !all_finite(sums) {
        for (sum, &to) in sum.iter_mut().zip(&*to) {
            *sum = added::<TWICE>(to, *sum);
        }
        return Err(first_not_finite(sum));
    }
    for (to, sum) in to.iter_mut().zip(sum) {
        *to = added::<TWICE>(*to, *sum);
    }
    Ok(())
}

#[inline(always)]
fn added<const TWICE: bool>(to: f64, sum: f64) -> f64 {
    if TWICE { to + sum + sum } else { to + sum }
}

/// Adds impulses to listed nodes, as [`move_all`].
///
/// # Errors
/// As [`move_all`].
#[inline(always)]
pub(super) fn move_to_nodes<const TWICE: bool, R: Row>(
    nodes: &[u32],
    to: &mut [R],
    sum: &mut [R],
    is_tested: bool,
) -> Result<(), usize> {
    for (at, &node) in nodes.iter().enumerate().filter(|_| is_tested) {
        let (mut row, mut of_node) = ([to[node as usize]], [sum[at]]);
        let moved = move_all::<TWICE, _>(&mut row, &mut of_node, true);
        if let Err(component) = moved {
            return Err(node as usize * R::LENGTH + component);
        }
    }
    for (&node, sum) in nodes.iter().zip(sum) {
        let sum = core::slice::from_mut(sum);
        move_all::<TWICE, _>(core::slice::from_mut(&mut to[node as usize]), sum, false)?;
    }
    Ok(())
}
