//! Places of checkpoints for the walk of a discrete adjoint, which reads states from the last to
//! the first.
//!
//! Input: the number of steps ahead of a kept state and the number of states that can still be
//! kept. Output: the distance to the next one. The number of times that a step is made is then the
//! least possible one (A. Griewank, A. Walther, *Algorithm 799: revolve*, ACM Trans. Math. Software
//! 26, 2000).

/// The memory that states may take, in bytes, as long as more of them save steps.
const MEMORY: usize = 16 << 20;

/// Returns a number of states of this size in bytes: all if they fit into the memory that they may
/// take, and else so many that a step is made at most twice before the walk passes it. With c
/// states this number of steps is (c + 1)(c + 2)/2.
pub(super) fn enough(steps: u64, size: usize) -> usize {
    let twice = steps.saturating_mul(2).isqrt() as usize + 1;
    let all = usize::try_from(steps).unwrap_or(usize::MAX);
    twice.max(all.min(MEMORY / size.max(1)))
}

/// Returns the distance to the next checkpoint, for so many steps and so many states that can be
/// kept.
///
/// With `free` states and `r` repetitions β(free, r) = (free + r)!/(free! r!) steps can be walked
/// backwards; β(f, r) = β(f − 1, r) + β(f, r − 1) are the parts behind and before the checkpoint.
pub(super) fn distance(steps: u64, free: u64) -> u64 {
    if steps <= free.saturating_add(1) {
        // each state is kept
        return 1;
    }
    let (mut repetitions, mut behind) = (0, 1_u64);
    // β(free, r) grows with r
    while reach(free, repetitions) < steps {
        repetitions += 1;
        behind = reach(free - 1, repetitions);
    }
    steps.saturating_sub(behind).max(1)
}

/// Returns (c + r)!/(c! r!), or the largest number.
fn reach(checkpoints: u64, repetitions: u64) -> u64 {
    let (small, large) = (
        checkpoints.min(repetitions),
        u128::from(checkpoints.max(repetitions)),
    );
    let mut reach: u128 = 1;
    for i in 1..=u128::from(small) {
        // The result is a binomial coefficient after each factor.
        reach = reach * (large + i) / i;
        if reach > u128::from(u64::MAX) {
            return u64::MAX;
        }
    }
    reach as u64
}

#[cfg(test)]
mod tests {
    use super::{MEMORY, distance, enough, reach};

    /// Counts how often steps are made to walk back over `steps` steps, with the greatest number of
    /// states that are kept.
    fn walk(steps: u64, checkpoints: usize) -> (u64, usize) {
        let (mut kept, mut reached, mut made, mut most) = (vec![0], steps, 0, 0);
        while reached > 0 {
            let at = *kept.last().unwrap();
            let left = reached - at;
            let free = checkpoints - (kept.len() - 1);
            if left > 1 && free > 0 {
                let next = distance(left, free as u64);
                assert!((1..left).contains(&next));
                made += next;
                kept.push(at + next);
                most = most.max(kept.len() - 1);
                continue;
            }
            made += left - 1;
            reached -= 1;
            if left == 1 {
                kept.pop();
            }
        }
        (made, most)
    }

    #[test]
    fn steps_are_repeated_as_seldom_as_the_checkpoints_allow() {
        for steps in [1, 2, 3, 10, 100, 1000, 4321] {
            for checkpoints in [1, 2, 3, 7, 20, 100] {
                let (made, kept) = walk(steps, checkpoints);
                let c = checkpoints as u64;
                let repetitions = (0..=steps).find(|&r| reach(c, r) >= steps).unwrap();
                assert!(kept <= checkpoints, "{steps} {checkpoints}: {kept}");
                assert!(made <= repetitions * steps, "{steps} {checkpoints}: {made}");
            }
            assert!(walk(steps, enough(steps, MEMORY)).0 <= 2 * steps);
            assert!(walk(steps, enough(steps, 8)).0 < steps);
        }
        assert_eq!(walk(100, 0).0, 99 * 100 / 2);
        assert_eq!(walk(100, 99).0, 99);
    }
}
