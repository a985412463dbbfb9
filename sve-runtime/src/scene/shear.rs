//! Steps that are shears: kicks, which change the momenta at fixed places, and drifts, which change
//! the places at fixed momenta.
//!
//! A shear is made in place and needs no second state. A number that is not finite stays so in all
//! later shears. Therefore, many steps without noise are made in blocks: the state is copied, the
//! steps are made without tests, and the result is tested. If it is not finite, the steps are
//! repeated from the copy with a test each, so that the step that fails is known, and the state
//! before it is restored.

use super::segments::Segments;
use super::sweep::{AreFinite, Buffers, DriftAlone, InverseMasses, Kick, Sweep};
use super::{IndexError, Layout, Row, Scene};
use crate::error::StepError;
use crate::lanes::dispatch::dispatch;

/// A shear of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shear {
    /// The impulse of the potential and of the noises is added to the momenta.
    Kick {
        /// The time over which the potential acts.
        h: f64,
        /// The fraction of the increments of the step.
        part: f64,
        /// The time of the node, from the start of the step.
        at: f64,
    },
    /// The sites move with their velocities.
    Drift {
        /// The time over which they move.
        h: f64,
    },
}

/// Steps between tests, at least.
const BLOCK: u64 = 64;

/// The arrays of a state of a scene, of the length for which its steps are prepared.
#[derive(Debug)]
pub struct Phase<'a, R> {
    /// The configuration.
    pub q: &'a mut [R],
    /// The momenta.
    pub p: &'a mut [R],
}

/// What is known about a scene for a number of sites, and the arrays that its steps need.
#[derive(Clone, Debug)]
pub struct Prepared<R> {
    n: usize,
    processes: usize,
    segments: Segments,
    masses: InverseMasses,
    buffers: Buffers<R>,
    /// The state before a step or block.
    before: [Vec<R>; 2],
    /// The increments of a kick.
    dw: Vec<f64>,
}

impl<R: Row> Prepared<R> {
    /// Executes the indices of a scene of `n` sites, and reads its masses.
    ///
    /// # Errors
    /// An index that is out of range; a mass without an inverse.
    pub fn new<S: Scene<Row = R>>(scene: &S, n: usize, t: f64) -> Result<Self, StepError> {
        let index = |error| index_error(error, t);
        let mut masses = vec![R::ZERO; n];
        scene.masses(n, &mut masses).map_err(index)?;
        let segments = Segments::new(scene, n).map_err(index)?;
        Ok(Self {
            n,
            processes: scene.processes(n).map_err(index)?,
            masses: inverse(R::numbers(&masses), t, R::LENGTH)?,
            buffers: Buffers::new(&segments, n),
            segments,
            before: [vec![R::ZERO; n], vec![R::ZERO; n]],
            dw: Vec::new(),
        })
    }

    /// Returns the number of sites.
    pub fn sites(&self) -> usize {
        self.n
    }

    /// Returns the number of Wiener processes.
    pub fn processes(&self) -> usize {
        self.processes
    }

    /// Returns the velocities of momenta.
    pub fn velocities(&self, p: &[R]) -> Vec<R> {
        let mut v = p.to_vec();
        for (at, v) in R::numbers_mut(&mut v).iter_mut().enumerate() {
            *v *= match &self.masses {
                InverseMasses::Uniform(inverse) => *inverse,
                InverseMasses::Each(inverse) => inverse[at],
            };
        }
        v
    }

    /// Returns what is known about the loops.
    pub fn layout<S: Scene<Row = R>>(&self) -> Layout {
        let masses = match &self.masses {
            InverseMasses::Uniform(_) => 0,
            InverseMasses::Each(inverse) => inverse.len(),
        };
        let numbers = masses + self.buffers.len() + 2 * self.n * R::LENGTH + self.dw.len();
        Layout::new::<S>(self.n, &self.segments, numbers * size_of::<f64>())
    }

    /// Makes one step from the time `t`.
    ///
    /// # Errors
    /// An index that is out of range; a result that is not finite. The state is then unchanged.
    pub fn step<S: Scene<Row = R>>(
        &mut self,
        scene: &S,
        shears: &[Shear],
        state: &mut Phase<'_, R>,
        [t, h]: [f64; 2],
        dw: &[f64],
    ) -> Result<(), StepError> {
        self.keep(state);
        let error = match self.make(scene, shears, state, &|_| t, 0..1, dw, true) {
            Ok(true) => return Ok(()),
            Ok(false) => not_finite(state, t, h),
            Err(error) => index_error(error, t),
        };
        self.restore(state);
        Err(error)
    }

    /// Makes steps without noise; step `k` begins at the time `time(k)`. Returns the number of
    /// steps made, and the error of the next one.
    pub fn advance<S: Scene<Row = R>>(
        &mut self,
        scene: &S,
        shears: &[Shear],
        state: &mut Phase<'_, R>,
        time: &impl Fn(u64) -> f64,
        h: f64,
        steps: u64,
    ) -> (u64, Result<(), StepError>) {
        let block = BLOCK + (1 << 16) / (self.n as u64 + 1);
        let mut made = 0;
        while made < steps {
            let end = steps.min(made + block);
            self.keep(state);
            let result = self.make(scene, shears, state, time, made..end, &[], false);
            let is_finite = |rows: &[R]| dispatch(AreFinite(R::numbers(rows)));
            if result != Ok(true) || !is_finite(state.q) || !is_finite(state.p) {
                self.restore(state);
                for step in made..end {
                    let result = self.step(scene, shears, state, [time(step), h], &[]);
                    if result.is_err() {
                        return (step, result);
                    }
                }
            }
            made = end;
        }
        (steps, Ok(()))
    }

    fn keep(&mut self, state: &Phase<'_, R>) {
        self.before[0].copy_from_slice(state.q);
        self.before[1].copy_from_slice(state.p);
    }

    #[cold]
    fn restore(&self, state: &mut Phase<'_, R>) {
        state.q.copy_from_slice(&self.before[0]);
        state.p.copy_from_slice(&self.before[1]);
    }

    /// Makes steps, each a list of shears. A drift and the kick after it are one sweep, and so are
    /// two equal kicks: their impulse is computed once, and added twice. Returns whether the result is finite, if it is
    /// tested.
    #[allow(clippy::too_many_arguments)]
    fn make<S: Scene<Row = R>>(
        &mut self,
        scene: &S,
        shears: &[Shear],
        state: &mut Phase<'_, R>,
        time: &impl Fn(u64) -> f64,
        steps: core::ops::Range<u64>,
        dw: &[f64],
        is_tested: bool,
    ) -> Result<bool, IndexError> {
        let same = |(step, one): (u64, Shear), (later, other): (u64, Shear)| {
            let time = |step, shear| match shear {
                Shear::Kick { at, .. } if S::READS_TIME => time(step) + at,
                _ => 0.0,
            };
            let key = |shear| match shear {
                Shear::Kick { h, part, .. } => Some([h, part]),
                Shear::Drift { .. } => None,
            };
            key(one) == key(other) && time(step, one) == time(later, other)
        };
        let of_step = |step| shears.iter().map(move |&shear| (step, shear));
        let mut shears = steps.flat_map(of_step).peekable();
        let mut is_finite = true;
        let mut drift = None;
        while let Some((step, shear)) = shears.next() {
            match shear {
                Shear::Drift { h } => {
                    if let Some(before) = drift.replace(h) {
                        is_finite &= self.drift(state, before, is_tested);
                    }
                }
                Shear::Kick { h, part, at } => {
                    let is_twice = shears.next_if(|&next| same((step, shear), next)).is_some();
                    self.dw.clear();
                    self.dw.extend(dw.iter().map(|dw| part * dw));
                    let (drift, kick) = (drift.take(), [h, time(step) + at]);
                    is_finite &= if is_twice {
                        self.sweep::<S, true>(scene, state, drift, kick, is_tested)
                    } else {
                        self.sweep::<S, false>(scene, state, drift, kick, is_tested)
                    }?;
                }
            }
        }
        if let Some(h) = drift {
            is_finite &= self.drift(state, h, is_tested);
        }
        Ok(is_finite)
    }

    fn drift(&self, state: &mut Phase<'_, R>, h: f64, is_tested: bool) -> bool {
        dispatch(DriftAlone {
            masses: &self.masses,
            h,
            q: state.q,
            p: state.p,
            is_tested,
        })
    }

    fn sweep<S: Scene<Row = R>, const TWICE: bool>(
        &mut self,
        scene: &S,
        state: &mut Phase<'_, R>,
        drift: Option<f64>,
        [h, t]: [f64; 2],
        is_tested: bool,
    ) -> Result<bool, IndexError> {
        let dw = &self.dw;
        dispatch(Sweep::<S, TWICE> {
            scene,
            segments: &self.segments,
            masses: &self.masses,
            drift,
            kick: Kick { h, t, dw },
            q: state.q,
            p: state.p,
            buffers: &mut self.buffers,
            is_tested,
        })
    }
}

/// Returns the inverse of each mass.
fn inverse(masses: &[f64], t: f64, length: usize) -> Result<InverseMasses, StepError> {
    if let Some(at) = masses
        .iter()
        .position(|&mass| mass == 0.0 || !mass.is_finite())
    {
        return Err(StepError::Mass {
            t,
            what: name("v", at, length),
            mass: masses[at],
        });
    }
    Ok(match masses {
        [first, others @ ..] if others.iter().all(|mass| mass == first) => {
            InverseMasses::Uniform(1.0 / first)
        }
        _ => InverseMasses::Each(masses.iter().map(|mass| 1.0 / mass).collect()),
    })
}

/// Returns the name of a component: `p[5]`, or `p[5][2]` in a row of several.
pub(crate) fn name(array: &str, at: usize, length: usize) -> String {
    match length {
        1 => format!("{array}[{at}]"),
        _ => format!("{array}[{}][{}]", at / length, at % length),
    }
}

fn index_error(error: IndexError, t: f64) -> StepError {
    let IndexError {
        text,
        index,
        length,
    } = error;
    StepError::Index {
        t,
        text: text.into(),
        index,
        length,
    }
}

/// Returns the error of a step whose result is not finite.
#[cold]
fn not_finite<R: Row>(state: &Phase<'_, R>, t: f64, h: f64) -> StepError {
    let find = |array: &str, rows: &[R]| {
        let mut numbers = R::numbers(rows).iter();
        numbers
            .position(|x| !x.is_finite())
            .map(|at| name(array, at, R::LENGTH))
    };
    let what = find("q", state.q).or_else(|| find("p", state.p));
    StepError::NonFiniteCoordinate {
        t,
        h,
        what: what.unwrap_or_default(),
    }
}
