//! Lanes: many states that are stepped at once, by vector instructions. Ensembles use them.
//!
//! Invariant: the result of a lane depends on that lane only, and operations are not fused. A path
//! has the same bits in any lane, beside any neighbours, with vectors of any width.

pub(crate) mod dispatch;
pub(crate) mod elementary;
pub(crate) mod newton;
pub(crate) mod solve;

/// Number of states that are stepped at once: four registers of AVX-512, eight of AVX2. The loops
/// of a step over the lanes are fused, so that as many independent chains of operations are
/// executed at the same time.
pub const LANES: usize = 32;

/// A number for each lane.
pub type Lane = [f64; LANES];

/// A set of lanes, bit `l` for lane `l`.
pub type Mask = u32;

/// All lanes.
pub(crate) const ALL: Mask = Mask::MAX >> (Mask::BITS as usize - LANES);

/// Returns 0 if the equations of a lane are solved and its new state is finite, otherwise 1.
#[inline(always)]
pub fn needs_scalar_step<const N: usize>(q: [f64; N], p: [f64; N], solved: bool) -> u64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += q[i] + p[i];
    }
    u64::from(!((sum.abs() < f64::INFINITY) & solved))
}

/// Returns the lanes whose number is not zero.
#[inline(always)]
pub fn marked(numbers: &Lane) -> Mask {
    let mut any = false;
    for number in numbers {
        any |= *number != 0.0;
    }
    if any { collect(numbers) } else { 0 }
}

#[cold]
fn collect(numbers: &Lane) -> Mask {
    let lanes = numbers.iter().enumerate();
    lanes.fold(0, |mask, (lane, &number)| {
        mask | Mask::from(number != 0.0) << lane
    })
}

/// Numbers for the lanes, aligned to cache lines: loads and stores across two cache lines take
/// twice as long.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Aligned<T>(pub T);

/// Returns work space for numbers that one loop over the lanes computes and a later one uses.
#[inline(always)]
pub const fn rows<const K: usize>() -> Aligned<[Lane; K]> {
    Aligned([[0.0; LANES]; K])
}
