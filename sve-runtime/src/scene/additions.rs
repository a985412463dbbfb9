//! Impulses that are added to momenta, with tests of the results.

use super::Row;
use super::drift::all_finite;

/// Returns the number of the first component that is not finite.
#[cold]
pub(super) fn first_not_finite(numbers: &[f64]) -> usize {
    let found = numbers.iter().position(|x| !x.is_finite());
    found.unwrap_or_default()
}

/// Adds the impulses of a kick, and then, if `TWICE`, those of a second one.
///
/// # Errors
/// The number of a component whose sum is not finite, if sums are tested; nothing is then added.
#[inline(always)]
pub(super) fn move_all<const TWICE: bool, R: Row>(
    to: &mut [R],
    impulses: [&[R]; 2],
    is_tested: bool,
) -> Result<(), usize> {
    let (to, [first, second]) = (R::numbers_mut(to), impulses.map(R::numbers));
    let impulses = || first.iter().zip(second);
    let added = |(to, (first, second)): (&f64, (&f64, &f64))| {
        if TWICE {
            to + first + second
        } else {
            to + first
        }
    };
    let mut sums = to.iter().zip(impulses()).map(added);
    if is_tested && !all_finite(sums.clone()) {
        return Err(sums.position(|x| !x.is_finite()).unwrap_or_default());
    }
    for (to, impulses) in to.iter_mut().zip(impulses()) {
        *to = added((&*to, impulses));
    }
    Ok(())
}

/// Adds impulses to listed nodes, as [`move_all`].
///
/// # Errors
/// As [`move_all`].
#[inline(always)]
pub(super) fn move_to_nodes<const TWICE: bool, R: Row>(
    nodes: &[u32],
    to: &mut [R],
    impulses: [&[R]; 2],
    is_tested: bool,
) -> Result<(), usize> {
    let of_node = |at: usize| impulses.map(|impulses| &impulses[at..=at]);
    for (at, &node) in nodes.iter().enumerate().filter(|_| is_tested) {
        let moved = move_all::<TWICE, _>(&mut [to[node as usize]], of_node(at), true);
        if let Err(component) = moved {
            return Err(node as usize * R::LENGTH + component);
        }
    }
    for (at, &node) in nodes.iter().enumerate() {
        let to = core::slice::from_mut(&mut to[node as usize]);
        move_all::<TWICE, _>(to, of_node(at), false)?;
    }
    Ok(())
}
