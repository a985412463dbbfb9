//! Increments of a Wiener path at the stages of a Gauss rule.
//!
//! Input: the increment of each process over a step, and words of a separate domain for the higher
//! coefficients of the path in Legendre polynomials. Output: the increments at the stages.
//! Invariant: a pure function of seed, path, step and process; coefficient `k ≥ 1` of process `a`
//! of `M` has number `(k − 1) M + a`, for every number of stages. Lanes of paths have the bits of
//! single paths.

use super::counter_path::CounterPath;
use super::distribution::Distribution;
#[cfg(feature = "ensemble")]
use super::lanes::{self, Draw, Rows};
use super::wiener::Normal;
use super::{Noise as _, NoiseError};
use crate::gauss::stage_noise;
#[cfg(feature = "ensemble")]
use crate::lanes::{Aligned, LANES};

/// Normals of the higher coefficients.
#[derive(Clone, Copy, Debug)]
pub(super) struct HigherCoefficients;

impl Distribution for HigherCoefficients {
    const DOMAIN: u64 = u64::from_le_bytes(*b"legendre");

    #[inline(always)]
    fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
        Normal::four(words, scale)
    }
}

/// Largest number of increments for which a step allocates nothing: eight processes at eight
/// stages.
const FEW: usize = 64;

/// The higher coefficients of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct StagePath(CounterPath<HigherCoefficients>);

impl StagePath {
    pub(super) fn new(seed: u64) -> Self {
        Self(CounterPath::new(seed))
    }

    pub(super) fn path(&self, path: u64) -> Self {
        Self(self.0.path(path))
    }

    /// Fills `dw` with the increments at the stages of a step. `whole` gives the increments over
    /// the step.
    pub(super) fn increments(
        &mut self,
        whole: &mut CounterPath<Normal>,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        if stage_noise::weights(stages).is_none() {
            return Err(NoiseError::NoStages { stages });
        }
        let processes = dw.len() / stages;
        let (mut few, mut many) = ([0.0; FEW], Vec::new());
        let coefficients = if dw.len() <= FEW {
            &mut few[..dw.len()]
        } else {
            many.resize(dw.len(), 0.0);
            &mut many[..]
        };
        let (first, higher) = coefficients.split_at_mut(processes);
        whole.increments(step, h, first)?;
        self.0.increments(step, h, higher)?;
        for (process, parts) in dw.chunks_exact_mut(stages).enumerate() {
            let coefficient = |k: usize| coefficients[k * processes + process];
            stage_noise::from_coefficients(coefficient, parts);
        }
        Ok(())
    }
}

/// Fills `out` with the increments at the stages of all processes of all tiles over blocks of four
/// steps, as [`fill`](lanes::fill) does with the increments over the steps: the stages of a process
/// follow one another.
#[cfg(feature = "ensemble")]
pub(crate) fn fill_stages(draw: &Draw<'_>, stages: usize, out: &mut [Rows]) {
    let processes = draw.processes;
    let higher_draw = Draw {
        processes: (stages - 1) * processes,
        ..*draw
    };
    let zeros = Aligned([[0.0; LANES]; 4]);
    let mut first = vec![zeros; out.len() / stages];
    let mut higher = vec![zeros; out.len() - first.len()];
    lanes::fill::<Normal>(draw, &mut first);
    lanes::fill::<HigherCoefficients>(&higher_draw, &mut higher);
    for (number, rows) in out.chunks_exact_mut(stages).enumerate() {
        let (tile, process) = (number / processes, number % processes);
        let of_tile = &higher[tile * higher_draw.processes..][..higher_draw.processes];
        for place in (0..4 * LANES).map(|i| (i / LANES, i % LANES)) {
            let coefficient = |k: usize| {
                let row = match k {
                    0 => &first[number],
                    _ => &of_tile[(k - 1) * processes + process],
                };
                row.0[place.0][place.1]
            };
            let mut parts = [0.0; stage_noise::MOST_STAGES];
            stage_noise::from_coefficients(coefficient, &mut parts[..stages]);
            for (row, part) in rows.iter_mut().zip(parts) {
                row.0[place.0][place.1] = part;
            }
        }
    }
}
