//! Statistics of standard normals, gathered as they come.
//!
//! Input: numbers. Output: how far each statistic is from its expectation, in
//! standard errors. Invariant: memory does not grow with the number of draws.

// places of bins, and small k
#![allow(clippy::cast_sign_loss)]

/// Bins a unit of z, of ±10.
const FINE: f64 = 512.0;
const REACH: f64 = 10.0;
const BINS: usize = (2.0 * REACH * FINE) as usize;

/// Draws of one source.
pub(crate) struct Sample {
    n: u64,
    /// Sums of zᵏ, k = 1 … 8.
    powers: [f64; 8],
    bins: Vec<u64>,
}

/// A statistic.
#[derive(Debug)]
pub(crate) struct Finding {
    pub(crate) what: String,
    pub(crate) value: f64,
    pub(crate) expected: f64,
    /// In standard errors.
    pub(crate) deviation: f64,
    /// The value that `deviation` exceeds once in about a million samples of true normals.
    pub(crate) bound: f64,
}

impl Finding {
    fn new(what: String, value: f64, expected: f64, standard_error: f64) -> Self {
        Self {
            what,
            value,
            expected,
            deviation: (value - expected) / standard_error,
            bound: 5.0,
        }
    }

    pub(crate) fn holds(&self) -> bool {
        self.deviation.abs() < self.bound
    }
}

/// E zᵏ of a standard normal: (k − 1)!! for even k.
pub(crate) fn normal_moment(k: i32) -> f64 {
    if k % 2 == 1 {
        0.0
    } else {
        (1..k).step_by(2).map(f64::from).product()
    }
}

/// Distribution function of the standard normal.
pub(crate) fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2)
}

impl Sample {
    pub(crate) fn new() -> Self {
        Self {
            n: 0,
            powers: [0.0; 8],
            bins: vec![0; BINS],
        }
    }

    #[inline]
    pub(crate) fn add(&mut self, z: f64) {
        self.n += 1;
        let mut power = 1.0;
        for sum in &mut self.powers {
            power *= z;
            *sum += power;
        }
        // a number out of reach is a fault of its own
        self.bins[((z + REACH) * FINE) as usize] += 1;
    }

    pub(crate) fn findings(&self) -> Vec<Finding> {
        let mut findings: Vec<Finding> = (1..=8).map(|k| self.moment(k)).collect();
        findings.extend([3.0, 4.0, 5.0, 5.5].into_iter().flat_map(|c| self.tails(c)));
        findings.extend(self.distribution());
        findings
    }

    fn moment(&self, k: i32) -> Finding {
        let n = self.n as f64;
        let exact = normal_moment(k);
        let variance = normal_moment(2 * k) - exact.powi(2);
        Finding::new(
            format!("moment {k}"),
            self.powers[k as usize - 1] / n,
            exact,
            (variance / n).sqrt(),
        )
    }

    /// Counts beyond ±c, where they are large enough to be nearly normal.
    fn tails(&self, c: f64) -> Vec<Finding> {
        let expected = self.n as f64 * normal_cdf(-c);
        if expected < 10.0 {
            return Vec::new();
        }
        let cut = ((REACH - c) * FINE) as usize;
        let below: u64 = self.bins[..cut].iter().sum();
        let above: u64 = self.bins[BINS - cut..].iter().sum();
        [("below -", below), ("above ", above)]
            .map(|(side, count)| {
                Finding::new(
                    format!("{side}{c}"),
                    count as f64,
                    expected,
                    expected.sqrt(),
                )
            })
            .into()
    }

    /// Distances of the distribution function at the borders of the bins, and of the counts of the
    /// bins.
    fn distribution(&self) -> [Finding; 3] {
        let n = self.n as f64;
        let (mut distance, mut square) = (0.0_f64, 0.0);
        let (mut chi, mut freedom, mut rest, mut rest_count) = (0.0, -1.0, 0.0, 0);
        let (mut below, mut lower) = (0, 0.0);
        for (bin, &count) in self.bins.iter().enumerate() {
            let upper = normal_cdf((bin + 1) as f64 / FINE - REACH);
            let probability = upper - lower;
            below += count;
            let difference = below as f64 / n - upper;
            distance = distance.max(difference.abs());
            if upper > 0.0 && upper < 1.0 {
                square += n * difference * difference / (upper * (1.0 - upper)) * probability;
            }
            // bins are joined until each may be taken as normal
            rest += n * probability;
            rest_count += count;
            if rest > 50.0 {
                chi += (rest_count as f64 - rest).powi(2) / rest;
                freedom += 1.0;
                (rest, rest_count) = (0.0, 0);
            }
            lower = upper;
        }
        [
            // √n D > 2.7 has probability 2 exp(−2·2.7²) = 9e-7
            Finding {
                bound: 2.7,
                ..Finding::new("Kolmogorov, Smirnov".into(), n.sqrt() * distance, 0.0, 1.0)
            },
            // P(A² > x) falls tenfold every 2.2: 0.05 at 2.49, 0.01 at 3.86, 1e-6 at 13
            Finding {
                bound: 13.0,
                ..Finding::new("Anderson, Darling".into(), square, 0.0, 1.0)
            },
            Finding::new("χ² of bins".into(), chi, freedom, f64::sqrt(2.0 * freedom)),
        ]
    }
}
