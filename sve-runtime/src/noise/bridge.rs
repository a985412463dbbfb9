//! Brownian bridges: the same path in smaller steps.
//!
//! Input: the increment over an interval. Output: the increments over its two halves, which sum to
//! it. Invariant: a half is a pure function of (seed, path, step, process, level, index) and the
//! increment of the whole. Given the increment of the whole, the increment of the left half is
//! normal with mean ΔW/2 and variance h/4, independent of everything outside the interval.
//!
//! With stage noise, the increments at the stages of both halves are drawn as independent numbers,
//! and moved by what their sums lack of the increments of the whole
//! ([`condition`](stage_noise::condition)). So the whole steps are those of the path. The halves
//! belong to its number of stages: of another number, and without stage noise, they are another
//! path with the same whole steps.
//!
//! Layout: the key of Threefry is (seed, path, domain, 0), the counter
//! (step, process / 4, 2^level + index, 0), and its four words give the four normals of four
//! processes. With stage noise the counter is (step, process, 2^level + index, 1 + n / 4) for
//! normal n of a process. The layout is part of the public contract.
//!
//! Source: Lévy's construction; Karatzas, Shreve, *Brownian Motion and Stochastic Calculus*, 2nd
//! ed., Springer (1991), section 2.3.

#[cfg(feature = "ensemble")]
use super::many_paths::{ManyPaths, PathData};
use super::{Halves, Noise, NoiseError, Replayable, Wiener, WithinSteps, box_muller, threefry};
use crate::error::check_step;
use crate::gauss::stage_noise;

/// Separates these draws from the increments of the path itself.
const DOMAIN: u64 = u64::from_le_bytes(*b"bridge  ");

/// Largest number of halvings of a step: the counter has 64 bits for level and index.
const DEEPEST: u32 = 63;

/// A dyadic interval of a step: one of its 2^`level` equal parts.
///
/// ```
/// use sve_runtime::noise::DyadicInterval;
///
/// let [left, right] = DyadicInterval::whole(10).halves().unwrap();
/// let [_, last] = right.halves().unwrap();
/// assert_eq!((left.level(), left.index()), (1, 0));
/// assert_eq!((last.step(), last.level(), last.index()), (10, 2, 3));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DyadicInterval {
    step: u64,
    level: u32,
    index: u64,
}

impl DyadicInterval {
    /// Returns the interval of a whole step.
    pub const fn whole(step: u64) -> Self {
        Self {
            step,
            level: 0,
            index: 0,
        }
    }

    /// Returns the two halves in order of time; `None` at level 63.
    pub const fn halves(self) -> Option<[Self; 2]> {
        if self.level == DEEPEST {
            return None;
        }
        let left = Self {
            level: self.level + 1,
            index: 2 * self.index,
            ..self
        };
        let right = Self {
            index: left.index + 1,
            ..left
        };
        Some([left, right])
    }

    /// Returns the same interval of the step `steps` later.
    pub(super) const fn later(self, steps: u64) -> Self {
        Self {
            step: self.step.wrapping_add(steps),
            ..self
        }
    }

    /// Returns the number of the step.
    pub const fn step(self) -> u64 {
        self.step
    }

    /// Returns the number of halvings of the step.
    pub const fn level(self) -> u32 {
        self.level
    }

    /// Returns the length of the interval as a fraction of the step.
    #[cfg(feature = "ensemble")]
    pub(crate) fn fraction(self) -> f64 {
        1.0 / (1_u64 << self.level) as f64
    }

    /// Returns the number of the interval among the intervals of its level, from 0.
    pub const fn index(self) -> u64 {
        self.index
    }
}

impl Wiener {
    /// Returns the increments over the two halves of an interval of length `h`, for a process whose
    /// increment over the interval is `whole`.
    ///
    /// They sum to `whole` up to rounding, and have the conditional distribution of a Brownian path
    /// with variance |h|. If `h` is NaN, returns NaN.
    ///
    /// ```
    /// use sve_runtime::noise::{DyadicInterval, Wiener};
    ///
    /// let path = Wiener::new(42).path(3);
    /// let (step, process, h) = (10, 0, 0.1);
    /// let whole = path.increment(step, process, h);
    /// let [left, right] = path.halves(DyadicInterval::whole(step), process, h, whole);
    /// assert!((left + right - whole).abs() < 1e-15);
    /// ```
    pub fn halves(&self, interval: DyadicInterval, process: usize, h: f64, whole: f64) -> [f64; 2] {
        let normals = self.normals(interval, process, 0.5 * h.abs().sqrt());
        split(whole, normals[process % 4])
    }

    /// Returns the same path in steps of `h / 2^depth`: the increments of `2^depth` steps from step
    /// `2^depth k` on sum to the increment of step `k` of length `h`.
    ///
    /// Refinements of different depths of the same path agree. With [stage
    /// noise](crate::StageNoise) the increments at the stages of the longer step follow from those
    /// of the shorter ones exactly; within a step of the path, rules of another number of stages
    /// have another path.
    ///
    /// ```
    /// use sve_runtime::noise::{Recorded, Wiener};
    ///
    /// let path = Wiener::new(42);
    /// let fine = Recorded::record(path.refine(3)?, 0.1 / 8.0, 1, 800)?;
    /// let coarse = fine.coarsen(8)?;
    /// for step in 0..100 {
    ///     let dw = coarse.get(step).unwrap()[0];
    ///     assert!((dw - path.increment(step as u64, 0, 0.1)).abs() < 1e-14);
    /// }
    /// # Ok::<(), sve_runtime::noise::NoiseError>(())
    /// ```
    ///
    /// # Errors
    /// [`NoiseError::Depth`] for a depth above 63.
    pub fn refine(self, depth: u32) -> Result<Refined, NoiseError> {
        if depth > DEEPEST {
            return Err(NoiseError::Depth { depth });
        }
        Ok(Refined {
            path: self,
            depth,
            at: None,
            processes: 0,
            increments: Vec::new(),
        })
    }

    /// Returns four normals for the group of four processes that contains `process`.
    #[inline]
    fn normals(&self, interval: DyadicInterval, process: usize, scale: f64) -> [f64; 4] {
        let words = words(self.0.seed, self.0.path, interval, process as u64 / 4);
        box_muller::four(words, scale)
    }
}

impl Wiener {
    /// Replaces the increments of a process at the stages of an interval of length `h` by those of
    /// one of its halves.
    fn halve_stages(
        &self,
        interval: DyadicInterval,
        process: usize,
        h: f64,
        half: usize,
        parts: &mut [f64],
    ) {
        let stages = parts.len();
        let weights = stage_noise::weights(stages).unwrap_or(&[]);
        let mut halves = [0.0; 2 * stage_noise::MOST_STAGES];
        let halves = &mut halves[..2 * stages];
        let number = (1 << interval.level) + interval.index;
        for (block, four) in (1..).zip(halves.chunks_mut(4)) {
            let counter = [interval.step, process as u64, number, block];
            let words = threefry::block(counter, [self.0.seed, self.0.path, DOMAIN, 0]);
            four.copy_from_slice(&box_muller::four(words, 1.0)[..four.len()]);
        }
        for (part, weight) in halves.iter_mut().zip(weights.iter().cycle()) {
            *part *= (0.5 * weight * h.abs()).sqrt();
        }
        stage_noise::condition(parts, halves);
        parts.copy_from_slice(&halves[half * stages..][..stages]);
    }
}

/// Returns the random words of an interval for a group of four processes.
#[inline(always)]
pub(super) fn words(seed: u64, path: u64, interval: DyadicInterval, group: u64) -> [u64; 4] {
    let number = (1 << interval.level) + interval.index;
    threefry::block([interval.step, group, number, 0], [seed, path, DOMAIN, 0])
}

/// Returns the halves of an increment; `deviation` is √h/2 times a standard normal.
#[inline(always)]
pub(super) fn split(whole: f64, deviation: f64) -> [f64; 2] {
    let left = 0.5 * whole + deviation;
    [left, whole - left]
}

/// A [`Wiener`] path in smaller steps, from [`Wiener::refine`].
///
/// Its step size is `h / 2^depth`, where `h` is the step size of the path. Steps can be evaluated
/// in any order; in sequence a step costs about two blocks of random words for each four processes.
///
/// Its only error is [`NoiseError::InvalidStep`], for a step size that is zero or not finite, or
/// whose product with `2^depth` is not finite.
#[derive(Clone, Debug)]
pub struct Refined {
    path: Wiener,
    depth: u32,
    /// The step and the step size of `increments`.
    at: Option<(u64, f64)>,
    processes: usize,
    /// Increments, level by level from the whole step down to the last interval, one entry for each
    /// process.
    increments: Vec<f64>,
}

impl Refined {
    /// Returns the first level at which two steps are in different intervals; `None` if the steps
    /// are the same.
    fn first_difference(&self, a: u64, b: u64) -> Option<u32> {
        let highest = (a ^ b).checked_ilog2()?;
        Some(self.depth.saturating_sub(highest))
    }

    /// Computes the increments of one level from the increments of the level above. The increments
    /// of level 0 come from the path.
    fn descend(&mut self, step: u64, level: u32, whole_h: f64) -> Result<(), NoiseError> {
        let processes = self.processes;
        let row = level as usize * processes;
        let whole_step = step >> self.depth;
        let Some(above) = level.checked_sub(1) else {
            return self
                .path
                .increments(whole_step, whole_h, &mut self.increments[..processes]);
        };
        let places = step - (whole_step << self.depth);
        // The number of the interval at this level. Its parity selects a half of the interval
        // above.
        let index = places >> (self.depth - level);
        let interval = DyadicInterval {
            step: whole_step,
            level: above,
            index: index / 2,
        };
        let scale = 0.5 * (whole_h / two_to(above)).abs().sqrt();
        for first in (0..processes).step_by(4) {
            let normals = self.path.normals(interval, first, scale);
            for process in first..processes.min(first + 4) {
                let whole = self.increments[row - processes + process];
                let halves = split(whole, normals[process - first]);
                self.increments[row + process] = halves[(index % 2) as usize];
            }
        }
        Ok(())
    }
}

impl Noise for Refined {
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        check_step(h)?;
        let whole_h = h * two_to(self.depth);
        check_step(whole_h)?;
        let mut first_level = Some(0);
        if let Some((last, last_h)) = self.at
            && last_h == h
            && self.processes == dw.len()
        {
            first_level = self.first_difference(last, step);
        }
        if let Some(first_level) = first_level {
            self.at = None;
            self.processes = dw.len();
            self.increments
                .resize((self.depth as usize + 1) * dw.len(), 0.0);
            for level in first_level..=self.depth {
                self.descend(step, level, whole_h)?;
            }
            self.at = Some((step, h));
        }
        let leaf = self.depth as usize * self.processes;
        dw.copy_from_slice(&self.increments[leaf..][..self.processes]);
        Ok(())
    }

    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let whole_h = h * two_to(self.depth);
        let mut interval = DyadicInterval::whole(step >> self.depth);
        let path = &mut self.path;
        path.stage_increments(interval.step, whole_h, stages, dw)?;
        while interval.level < self.depth {
            let h = whole_h / two_to(interval.level);
            let half = step >> (self.depth - 1 - interval.level) & 1;
            for (process, parts) in dw.chunks_exact_mut(stages).enumerate() {
                path.halve_stages(interval, process, h, half as usize, parts);
            }
            interval.level += 1;
            interval.index = 2 * interval.index + half;
        }
        Ok(())
    }

    fn within_steps(&self) -> Option<WithinSteps<'_>> {
        Some(WithinSteps::of(self))
    }

    fn is_replayable(&self) -> bool {
        true
    }
}

/// An interval of a step of `h / 2^depth` is an interval of the path itself. Below intervals of
/// level 63 the path is linear.
impl Replayable for Refined {}

/// The steps of the ensemble are parts of the steps of the path, as in a trajectory:
/// `steps(h / 2^depth, …)`.
#[cfg(feature = "ensemble")]
impl ManyPaths for Refined {
    fn many_paths(self) -> PathData {
        PathData {
            depth: self.depth,
            ..self.path.many_paths()
        }
    }
}

impl Halves for Refined {
    fn halves_of(
        &self,
        interval: DyadicInterval,
        h: f64,
        whole: &[f64],
        left: &mut [f64],
        right: &mut [f64],
    ) {
        let level = self.depth + interval.level;
        if level >= DEEPEST {
            for (process, whole) in whole.iter().enumerate() {
                (left[process], right[process]) = (0.5 * whole, 0.5 * whole);
            }
            return;
        }
        let step = interval.step >> self.depth;
        let place = interval.step - (step << self.depth);
        let index = (place << interval.level) + interval.index;
        let of_path = DyadicInterval { step, level, index };
        self.path.halves_of(of_path, h, whole, left, right);
    }
}

pub(super) fn two_to(level: u32) -> f64 {
    (1_u64 << level) as f64
}
