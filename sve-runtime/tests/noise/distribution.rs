//! The distribution of the increments. Seeds are fixed, and bounds are five standard errors, so a
//! failure is a fault: chance alone would exceed one of the few hundred bounds here for one choice
//! of seeds in several thousand.

use rand::{SeedableRng, rngs::StdRng};
use sve_runtime::noise::{FromRng, Noise, ThreePoint, Truncated, Wiener};

use crate::statistics::{Finding, Sample, normal_cdf, normal_moment};

const BOUND: f64 = 5.0;

/// Where neighbours are compared.
const SEED: u64 = 100;
const PATH: u64 = 10;

/// Sequential increments of one process.
fn sample(mut noise: impl Noise, h: f64, n: usize) -> Vec<f64> {
    let mut dw = [0.0];
    (0..n as u64)
        .map(|step| {
            noise.increments(step, h, &mut dw).unwrap();
            dw[0]
        })
        .collect()
}

fn assert_normal(name: &str, z: &mut [f64]) {
    let n = z.len() as f64;
    for k in 1..=8 {
        let mean = z.iter().map(|z| z.powi(k)).sum::<f64>() / n;
        let exact = normal_moment(k);
        let variance = normal_moment(2 * k) - exact.powi(2);
        let error = (mean - exact) / (variance / n).sqrt();
        assert!(
            error.abs() < BOUND,
            "{name}: moment {k} is {mean}, {error} standard errors off"
        );
    }
    // Kolmogorov and Smirnov: √n D > 2.7 has probability 2 exp(−2·2.7²) = 9e-7
    z.sort_unstable_by(f64::total_cmp);
    let distance = z.iter().enumerate().map(|(i, &z)| {
        let cdf = normal_cdf(z);
        (cdf - i as f64 / n).max((i + 1) as f64 / n - cdf)
    });
    let scaled = distance.fold(0.0, f64::max) * n.sqrt();
    assert!(scaled < 2.7, "{name}: Kolmogorov distance {scaled}");
    // both tails beyond 4: Poisson counts
    for side in [-1.0, 1.0] {
        let expected = n * normal_cdf(-4.0);
        let count = z.iter().filter(|z| *z * side > 4.0).count() as f64;
        assert!(
            (count - expected).abs() < BOUND * expected.sqrt(),
            "{name}: {count} beyond 4, expected {expected}"
        );
    }
}

/// Neither the values nor their squares are correlated.
fn assert_independent(name: &str, a: &[f64], b: &[f64]) {
    let n = a.len().min(b.len()) as f64;
    let (mut values, mut squares) = (0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        values += a * b;
        // z² − 1 has variance 2
        squares += (a * a - 1.0) * (b * b - 1.0) / 2.0;
    }
    for (of, sum) in [("values", values), ("squares", squares)] {
        let error = sum / n.sqrt();
        assert!(
            error.abs() < BOUND,
            "{name}: {of} correlated, {error} standard errors"
        );
    }
}

/// Moments to the eighth, tails, the distances of Kolmogorov and Smirnov and of Anderson and
/// Darling, counts of bins, on 10⁷ draws.
#[test]
fn ten_million_draws_are_normal() {
    let mut sample = Sample::new();
    let mut z = [0.0; 4];
    for path in 0..25 {
        let mut noise = Wiener::new(77).path(path);
        for step in 0..100_000 {
            noise.increments(step, 1.0, &mut z).unwrap();
            for z in z {
                sample.add(z);
            }
        }
    }
    for finding in sample.findings() {
        let (value, expected) = (finding.value, finding.expected);
        let Finding {
            what, deviation, ..
        } = &finding;
        assert!(
            finding.holds(),
            "{what}: {value} for {expected}, {deviation} standard errors"
        );
    }
}

/// The statistics see what they are for: a normal cut off at 3.9, one with a variance off by 1 %,
/// and one with gaps.
#[test]
fn the_statistics_see_small_faults() {
    type Fault = fn(f64) -> f64;
    let faults: [(&str, Fault); 3] = [
        ("above 4", |z| z.min(3.9)),
        ("moment 2", |z| 1.005 * z),
        ("χ² of bins", |z| (z * 128.0).round() / 128.0),
    ];
    for (what, fault) in faults {
        let mut sample = Sample::new();
        for z in self::sample(Wiener::new(78), 1.0, 2_000_000) {
            sample.add(fault(z));
        }
        let found = sample
            .findings()
            .into_iter()
            .find(|finding| finding.what == what);
        assert!(found.is_some_and(|finding| !finding.holds()), "{what}");
    }
}

/// Probabilities by counts, moments to the fifth, and that nothing is correlated.
#[test]
fn three_points_have_their_law() {
    let n = 1_000_000;
    let z = sample(ThreePoint::new(9), 1.0, n);
    let root_3 = 3.0_f64.sqrt();
    let n = n as f64;
    for (value, probability) in [(-root_3, 1.0 / 6.0), (0.0, 2.0 / 3.0), (root_3, 1.0 / 6.0)] {
        let count = z.iter().filter(|&&z| z == value).count() as f64;
        let error = (count - n * probability) / (n * probability * (1.0 - probability)).sqrt();
        assert!(error.abs() < BOUND, "{value}: {count}");
    }
    assert!(z.iter().all(|z| z.abs() == root_3 || *z == 0.0));
    // E z^2k = 3^(k−1)
    for k in 1..=5 {
        let mean = z.iter().map(|z| z.powi(k)).sum::<f64>() / n;
        let variance = 3.0_f64.powi(k - 1) - normal_moment(k).powi(2);
        let error = (mean - normal_moment(k)) / (variance / n).sqrt();
        assert!(error.abs() < BOUND, "moment {k}: {mean}");
    }
    let increments = |seed, path| sample(ThreePoint::new(seed).path(path), 1.0, 100_000);
    let base = increments(SEED, PATH);
    for lag in 1..=5 {
        assert_independent(
            &format!("lag {lag}"),
            &base[lag..],
            &base[..base.len() - lag],
        );
    }
    assert_independent("seeds", &base, &increments(SEED + 1, PATH));
    assert_independent("paths", &base, &increments(SEED, PATH + 1));
    // nor with the normal ones of the same seed and path
    let normal = sample(Wiener::new(SEED).path(PATH), 1.0, 100_000);
    assert_independent("normal", &base, &normal);
}

#[test]
fn wiener_is_normal() {
    assert_normal("steps", &mut sample(Wiener::new(2024), 1.0, 1_000_000));
}

#[test]
fn first_increments_of_many_paths_are_normal() {
    let paths = Wiener::new(7);
    let of_path = |path| paths.clone().path(path).increment(0, 0, 1.0);
    assert_normal("paths", &mut (0..200_000).map(of_path).collect::<Vec<_>>());
    let of_seed = |seed| Wiener::new(seed).increment(0, 0, 1.0);
    assert_normal("seeds", &mut (0..200_000).map(of_seed).collect::<Vec<_>>());
}

#[test]
fn foreign_generators_give_normals() {
    let noise = FromRng::new(StdRng::seed_from_u64(2024));
    let mut z = sample(noise, 1.0, 300_000);
    for lag in 1..=3 {
        assert_independent(&format!("rand, lag {lag}"), &z[lag..], &z[..z.len() - lag]);
    }
    assert_normal("rand", &mut z);
}

#[test]
fn variance_is_the_step_size() {
    let n = 100_000;
    let standard_error = (2.0 / n as f64).sqrt();
    for (seed, h) in [1e-300, 1e-6, 0.1, 1.0, 50.0, 1e300]
        .into_iter()
        .enumerate()
    {
        let dw = sample(Wiener::new(seed as u64), h, n);
        let ratio = dw.iter().map(|dw| dw / h * dw).sum::<f64>() / n as f64;
        assert!(
            (ratio - 1.0).abs() < BOUND * standard_error,
            "h = {h}: {ratio}"
        );
    }
}

#[test]
fn neighbouring_seeds_and_paths_are_independent() {
    let n = 50_000;
    let base = sample(Wiener::new(SEED).path(PATH), 1.0, n);
    let flipped = (0..64).step_by(7).map(|bit| 1_u64 << bit);
    for other in [3, u64::MAX].into_iter().chain(flipped) {
        let seed = sample(Wiener::new(SEED ^ other).path(PATH), 1.0, n);
        assert_independent(&format!("seed ^ {other}"), &base, &seed);
        let path = sample(Wiener::new(SEED).path(PATH ^ other), 1.0, n);
        assert_independent(&format!("path ^ {other}"), &base, &path);
    }
    // seed and path do not mix
    let swapped = sample(Wiener::new(PATH).path(SEED), 1.0, n);
    assert_independent("swapped", &base, &swapped);
    let [a, b] = [
        Wiener::new(SEED + 1).path(PATH),
        Wiener::new(SEED).path(PATH + 1),
    ];
    assert_independent("equal sums", &sample(a, 1.0, n), &sample(b, 1.0, n));
}

#[test]
fn processes_are_independent() {
    let mut path = Wiener::new(SEED).path(PATH);
    let mut processes = vec![Vec::new(); 4];
    for step in 0..100_000 {
        let mut dw = [0.0; 4];
        path.increments(step, 1.0, &mut dw).unwrap();
        for (process, dw) in processes.iter_mut().zip(dw) {
            process.push(dw);
        }
    }
    for a in 0..4 {
        for b in 0..a {
            assert_independent(&format!("processes {a}, {b}"), &processes[a], &processes[b]);
        }
    }
}

#[test]
fn steps_are_independent() {
    let z = sample(Wiener::new(5), 1.0, 200_000);
    for lag in 1..=9 {
        assert_independent(&format!("lag {lag}"), &z[lag..], &z[..z.len() - lag]);
    }
    // within a block every pair of places on its own, above all the two normals of a pair
    let place = |at: usize| z.iter().skip(at).step_by(4).copied().collect::<Vec<_>>();
    for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
        assert_independent(&format!("places {i}, {j}"), &place(i), &place(j));
    }
}

/// Milstein, Repin, Tretyakov: 0 ≤ E(ξ² − ξ̂²) ≤ (1 + 2 √(2k|ln h|)) hᵏ, and E(ξ − ξ̂)² ≤ hᵏ.
#[test]
fn truncation_loses_as_little_as_published() {
    let (n, h, k) = (400_000, 0.2_f64, 2.0);
    let free = sample(Wiener::new(8), h, n);
    let clipped = Truncated::new(Wiener::new(8)).exponent(k, 1.0).unwrap();
    let clipped = sample(clipped, h, n);
    let (mut lost, mut cut) = (0.0, 0.0);
    for (a, b) in free.iter().zip(&clipped) {
        lost += (a * a - b * b) / h / n as f64;
        cut += (a - b).powi(2) / h / n as f64;
    }
    let bound = (1.0 + 2.0 * (2.0 * k * h.ln().abs()).sqrt()) * h.powf(k);
    assert!(0.0 < lost && lost < bound, "{lost} against {bound}");
    assert!(0.0 < cut && cut < h.powf(k), "{cut}");
}

/// The table of [`Truncated`]: the part that is clipped, and c² = E(|ξ| − A)₊², with the standard
/// errors of what is rare.
#[test]
fn truncation_loses_what_its_table_says() {
    let n = 1_000_000;
    let free = sample(Wiener::new(9), 1.0, n);
    for (deviations, one_in, c) in [(3.0, 370.0, 2.0e-2), (4.0, 15_800.0, 2.5e-3)] {
        let clipped = Truncated::new(Wiener::new(9))
            .deviations(deviations)
            .unwrap();
        let clipped = sample(clipped, 1.0, n);
        let lost: Vec<f64> = free.iter().zip(&clipped).map(|(a, b)| a - b).collect();
        let count = lost.iter().filter(|x| **x != 0.0).count() as f64;
        let expected = n as f64 / one_in;
        assert!(
            (count - expected).abs() < BOUND * expected.sqrt() + 0.01 * expected,
            "{count}"
        );
        let square = lost.iter().map(|x| x * x).sum::<f64>() / n as f64;
        let fourth = lost.iter().map(|x| x.powi(4)).sum::<f64>() / n as f64;
        let error = (fourth / n as f64).sqrt();
        assert!(
            (square - c * c).abs() < BOUND * error + 0.05 * c * c,
            "{square:e} {error:e}"
        );
    }
}
