//! Data of several tests of ensembles: systems, starts, files, and runs in parts that have the
//! bits of the whole.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

use sve_models::models::{Kicked, Kubo, Oscillator};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

pub(crate) type KuboMethod = Integrator<Kubo, Midpoint>;

pub(crate) fn kubo() -> KuboMethod {
    Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint)
}

/// The oscillator with noise of strength 1.
pub(crate) fn oscillator<R>(rule: R) -> Integrator<Oscillator, R>
where
    Oscillator: sve_runtime::Variational<R>,
{
    Integrator::new(Oscillator { sigma: 1.0 }, rule)
}

/// A particle that moves freely.
pub(crate) fn free() -> Integrator<Kicked, Midpoint> {
    Integrator::new(Kicked { sigma: 0.0 }, Midpoint)
}

/// The path of a file that does not exist.
pub(crate) fn scratch(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_file(&path);
    path
}

/// The numbers that a function draws for the start of each path of an ensemble with this seed.
pub(crate) fn drawn<T: Send>(
    paths: u64,
    seed: u64,
    draw: impl Fn(u64, &mut StartRng) -> T + Sync,
) -> Vec<T> {
    let (method, all) = (free(), Mutex::new(BTreeMap::new()));
    let ensemble = Ensemble::new(&method)
        .paths(paths)
        .seed(seed)
        .steps(0.1, 1)
        .start(Starts::each(|path, rng| {
            all.lock().unwrap().insert(path, draw(path, rng));
            State::new([0.0], [0.0])
        }));
    ensemble.run().unwrap();
    drop(ensemble);
    all.into_inner().unwrap().into_values().collect()
}

/// Runs an ensemble on one thread, and asserts that other numbers of threads, shards that are
/// merged in each of these orders, and the stored form have the same bits.
pub(crate) fn run_in_parts<'a, I, const N: usize, const M: usize>(
    ensemble: impl Fn() -> Ensemble<'a, I>,
    threads: &[usize],
    orders: &[&[u64]],
) -> Summary
where
    I: Method<System: System<Dims = Dims<N, M>>> + Sync + 'a,
{
    let stored = |summary: &Summary| serde_json::to_string(summary).unwrap();
    let whole = ensemble().threads(1).run().unwrap();
    let text = stored(&whole);
    assert!(whole.is_complete());
    for &threads in threads {
        let run = ensemble().threads(threads).run().unwrap();
        assert_eq!((&run, stored(&run)), (&whole, text.clone()), "{threads}");
    }
    let mut runs = BTreeMap::new();
    for &order in orders {
        let of = order.len() as u64;
        let shards = runs.entry(of).or_insert_with(|| {
            let shard = |index| ensemble().shard(index, of).threads(1).run().unwrap();
            (0..of).map(shard).collect::<Vec<Summary>>()
        });
        let mut merged = shards[order[0] as usize].clone();
        for &index in &order[1..] {
            assert!(!merged.is_complete());
            merged.merge(shards[index as usize].clone()).unwrap();
        }
        let found = (&merged, stored(&merged));
        assert_eq!(found, (&whole, text.clone()), "{order:?}");
        assert_eq!(merged.failures(), whole.failures());
        assert_eq!(merged.passages(), whole.passages());
    }
    assert_eq!(serde_json::from_str::<Summary>(&text).unwrap(), whole);
    whole
}
