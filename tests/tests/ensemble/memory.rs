//! Memory grows with recorded times and observables, not with paths and steps.

use allocation_counter::measure;
use sve_runtime::prelude::*;

use crate::runs::{KuboMethod, kubo};

/// The largest number of bytes that a run had at once, with what the summary keeps. On one thread,
/// whose own pool cannot be counted, so on this one.
fn peak(paths: u64, steps: u64, every: u64) -> u64 {
    let method = kubo();
    let counted = measure(|| {
        // a rayon pool of this thread alone
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .use_current_thread();
        pool.build().map_or_else(
            |_| drop(run(&method, paths, steps, every)),
            |pool| pool.install(|| drop(run(&method, paths, steps, every))),
        );
    });
    counted.bytes_max
}

fn run(method: &KuboMethod, paths: u64, steps: u64, every: u64) -> Summary {
    Ensemble::new(method)
        .paths(paths)
        .steps(0.01, steps)
        .every(every)
        .start(State::new([1.0], [0.0]))
        .observe("q", |_, state| state.q[0])
        .observe("p", |_, state| state.p[0])
        .run()
        .unwrap()
}

#[test]
fn does_not_grow_with_paths_and_steps() {
    // 101 recorded times, two observables: a block has 7.3 kB
    peak(64, 1, 1); // what is set up once
    let few = peak(640, 1000, 10);
    let block = 101 * (8 + 2 * 32);
    assert!(few > 2 * block, "{few}");
    // ten times the paths: the tree may be deeper by four
    let many = peak(6400, 1000, 10);
    assert!(many < few + 5 * block, "{few} {many}");
    // ten times the steps
    let long = peak(640, 10_000, 100);
    assert!(long.abs_diff(few) < block / 2, "{few} {long}");
    // ten times the records, so that something does grow: two blocks at least
    let fine = peak(640, 1000, 1);
    assert!(fine > few + 9 * 2 * block, "{few} {fine}");
}
