//! States along a path, one a step.

use crate::Integrator;
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::method::Method;
use crate::noise::{Halves, Noise, NoiseError, Part};
use crate::snapshot::Snapshot;
use crate::state::State;
use crate::step::{self, is_time};
use crate::system::{Dimensions, Dims, IncrementsOf, StateOf, System, Variational};

/// The states after each step, from [`Method::trajectory`].
///
/// Ends after an error, and where a recorded path ends; otherwise it has no end: `take` what is needed.
#[derive(Debug)]
pub struct Trajectory<'a, I: Method, W> {
    method: &'a I,
    noise: W,
    state: StateOf<I::System>,
    start: f64,
    h: f64,
    prepared: Option<I::Prepared>,
    step: u64,
    over: bool,
    refinement: Option<Refinement<W>>,
    refinements: Refinements,
    compensation: Option<Compensation<I>>,
}

/// Which steps of a trajectory were made in smaller ones, see [`Trajectory::refine`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Refinements {
    /// Number of steps that were.
    pub steps: u64,
    /// How often the smallest part of any of them was halved.
    pub deepest: u32,
}

/// What is done where a step fails.
#[derive(Debug)]
struct Refinement<W> {
    depth: u32,
    /// [`Halves::halves_of`], which only some sources have.
    halves: HalvesOf<W>,
}

type HalvesOf<W> = fn(&W, Part, f64, &[f64], &mut [f64], &mut [f64]);

/// What rounding took from the state.
#[derive(Debug)]
struct Compensation<I: Method> {
    /// The low parts of the coordinates and momenta.
    rest: StateOf<I::System>,
    step: CompensatedStep<I>,
}

/// A step that keeps in the second state what rounding takes from the first.
pub(crate) type CompensatedStep<I> = fn(
    &I,
    &<I as Method>::Prepared,
    &mut StateOf<<I as Method>::System>,
    &mut StateOf<<I as Method>::System>,
    f64,
    &IncrementsOf<<I as Method>::System>,
) -> Result<(), StepError>;

/// The time `start + steps h`, rounded once: by a fused operation, which has the same bits on every machine.
#[inline]
pub(crate) fn time_after(start: f64, steps: u64, h: f64) -> f64 {
    let steps = steps as f64;
    if start == 0.0 {
        // rounded once without it, which is faster where the machine has no fused operation
        steps * h
    } else {
        steps.mul_add(h, start)
    }
}

impl<'a, I: Method, W: Noise> Trajectory<'a, I, W> {
    pub(crate) fn new(method: &'a I, state: StateOf<I::System>, h: f64, noise: W) -> Self {
        Self {
            start: state.t,
            method,
            noise,
            state,
            h,
            prepared: None,
            step: 0,
            over: false,
            refinement: None,
            refinements: Refinements::default(),
            compensation: None,
        }
    }

    pub(crate) fn resume(
        method: &'a I,
        snapshot: Snapshot<StateOf<I::System>>,
        noise: W,
    ) -> Result<Self, StepError> {
        let Snapshot {
            start,
            h,
            step,
            state,
            rest,
            refinements,
        } = snapshot;
        let t = state.t;
        let compensated = |rest| match method.compensated_step() {
            Some(step) => Ok(Compensation { rest, step }),
            None => Err(StepError::Uncompensated { t }),
        };
        Ok(Self {
            start,
            step,
            refinements,
            compensation: rest.map(compensated).transpose()?,
            ..Self::new(method, state, h, noise)
        })
    }

    /// What it takes to continue from here with [`Method::resume`], with the bits of this trajectory.
    pub fn snapshot(&self) -> Snapshot<StateOf<I::System>> {
        Snapshot {
            start: self.start,
            h: self.h,
            step: self.step,
            state: self.state,
            rest: self.compensation.as_ref().map(|low| low.rest),
            refinements: self.refinements,
        }
    }

    /// Number of steps made so far, those before a snapshot included: the next one has the increments of this step of the noise.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Makes a step that fails in two halves on the same path, and each of these that fails likewise, up to `depth` times.
    ///
    /// The halves of the increments are those of a Brownian bridge, a pure function of seed, path, step and place, so a
    /// trajectory has the same bits whenever it is repeated. Its states stay those of the steps of length `h`, at the
    /// same times. [`refinements`](Self::refinements) says how often it was needed. Where the smallest parts fail as
    /// well, the error is that of the first of them.
    ///
    /// A step that is made in parts only where it fails depends on the path: the law of the states is no longer exactly that
    /// of the rule. So this is for rare failures; a count that grows like the number of steps asks for a smaller `h`.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A pendulum with noise of fourth degree in the momentum: for a large ΔW the step has no solution.
    /// struct Rotor;
    ///
    /// #[variational(midpoint)]
    /// impl Rotor {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }
    ///     #[h1]
    ///     fn jitter(&self, _q: f64, p: f64) -> f64 { 0.1 * p.powi(4) }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let rotor = Integrator::new(Rotor, Midpoint);
    /// let start = State::new([0.0], [2.0]);
    /// let plain = rotor.trajectory(start, 0.5, Wiener::new(1)).take(1000).last().unwrap();
    /// assert!(matches!(plain, Err(StepError::BranchLost { .. })));
    ///
    /// let mut path = rotor.trajectory(start, 0.5, Wiener::new(1)).refine(16);
    /// for _ in 0..1000 {
    ///     path.next().unwrap()?;
    /// }
    /// println!("{:?}", path.refinements());
    /// assert!(path.refinements().steps > 0);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn refine(mut self, depth: u32) -> Self
    where
        W: Halves,
    {
        let halves = W::halves_of;
        self.refinement = Some(Refinement { depth, halves });
        self
    }

    /// Which of the steps so far were made in smaller ones.
    pub fn refinements(&self) -> Refinements {
        self.refinements
    }

    /// The state reached so far.
    pub fn state(&self) -> &StateOf<I::System> {
        &self.state
    }

    fn advance(&mut self) -> Result<Option<StateOf<I::System>>, StepError> {
        let prepared = match &self.prepared {
            Some(prepared) => prepared,
            None => self.prepared.insert(self.method.prepare(self.h)?),
        };
        let mut dw: IncrementsOf<I::System> = <<I::System as System>::Dims>::NO_INCREMENTS;
        match self.noise.increments(self.step, self.h, dw.as_mut()) {
            Ok(()) => {}
            Err(NoiseError::Exhausted { .. }) => return Ok(None),
            Err(source) => {
                let t = self.state.t;
                return Err(StepError::Noise { t, source });
            }
        }
        let end = time_after(self.start, self.step + 1, self.h);
        let t = self.state.t;
        // a time that was not finite before is for the step to report
        if !is_time(t, end) && t.is_finite() {
            return Err(StepError::Time { t, h: self.h, end });
        }
        // what is rare has its own way out, so that the usual step is compiled as if there were nothing else
        if self.compensation.is_some() {
            return self.compensated_step(end, &{ dw });
        }
        let made = self
            .method
            .step_prepared(prepared, &mut self.state, self.h, &dw);
        match made {
            Ok(()) => Ok(Some(self.arrive(end))),
            Err(error) => self.refined(error, end, &{ dw }),
        }
    }

    /// The state after a step was made, at a time that was rounded once, where adding `h` again and again would drift.
    #[inline(always)]
    fn arrive(&mut self, t: f64) -> StateOf<I::System> {
        self.step += 1;
        self.state.t = t;
        self.state
    }

    #[inline(never)]
    fn compensated_step(
        &mut self,
        end: f64,
        dw: &IncrementsOf<I::System>,
    ) -> Result<Option<StateOf<I::System>>, StepError> {
        if let (Some(prepared), Some(Compensation { rest, step })) =
            (&self.prepared, &mut self.compensation)
            && let Err(error) = step(self.method, prepared, &mut self.state, rest, self.h, dw)
        {
            return self.refined(error, end, dw);
        }
        Ok(Some(self.arrive(end)))
    }

    /// The step in smaller ones, where that was asked for.
    #[cold]
    #[inline(never)]
    fn refined(
        &mut self,
        error: StepError,
        end: f64,
        dw: &IncrementsOf<I::System>,
    ) -> Result<Option<StateOf<I::System>>, StepError> {
        let Some(refinement) = &self.refinement else {
            return Err(error);
        };
        let mut state = self.state;
        let whole = Part::whole(self.step);
        let deepest = self.halved(refinement, error, whole, self.h, dw, &mut state)?;
        self.state = state;
        self.refinements.steps += 1;
        self.refinements.deepest = self.refinements.deepest.max(deepest);
        Ok(Some(self.arrive(end)))
    }

    /// A part of a step that failed as a whole, in its halves; how often the smallest of its parts was halved.
    fn halved(
        &self,
        refinement: &Refinement<W>,
        error: StepError,
        part: Part,
        h: f64,
        dw: &IncrementsOf<I::System>,
        state: &mut StateOf<I::System>,
    ) -> Result<u32, StepError> {
        let halves = part.halves().filter(|_| part.level() < refinement.depth);
        let Some(halves) = halves else {
            return Err(error);
        };
        let (mut left, mut right) = (*dw, *dw);
        (refinement.halves)(
            &self.noise,
            part,
            h,
            dw.as_ref(),
            left.as_mut(),
            right.as_mut(),
        );
        let h = 0.5 * h;
        // an h that underflows is an error of its own; the first one says more
        let prepared = self.method.prepare(h).map_err(|_| error)?;
        let mut deepest = part.level() + 1;
        for (half, dw) in halves.into_iter().zip([left, right]) {
            if let Err(error) = self.method.step_prepared(&prepared, state, h, &dw) {
                let below = self.halved(refinement, error, half, h, &dw, state)?;
                deepest = deepest.max(below);
            }
        }
        Ok(deepest)
    }
}

impl<S, R, W: Noise, Q, const N: usize, const M: usize> Trajectory<'_, Integrator<S, R>, W>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Keeps what rounding takes from coordinates and momenta at each step, and gives it back at the next: for runs of many
    /// steps, where it makes the random walk of rounding errors shorter.
    ///
    /// It helps where the increments of a step have digits that the state has not: explicit and linear steps, and coordinates. The
    /// momentum of an implicit midpoint step is p₀ + 2(p̄ − p₀), where p̄ is rounded like the state: there nothing is to be kept, and
    /// the walk stays. A systematic error of a step, and thus a drift, is not made smaller either. A step in parts, see [`refine`](Self::refine), keeps what was carried up to it.
    ///
    /// A compile-time error for linear steps with noise in the momentum, which give states and no increments.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator;
    ///
    /// #[variational(endpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let oscillator = Integrator::new(Oscillator, Endpoint);
    /// let h = 1e-3;
    /// // what this rule conserves exactly
    /// let conserved = |s: &State<[f64; 1]>| s.q[0] * s.q[0] + s.p[0] * s.p[0] + h * s.q[0] * s.p[0];
    /// let path = oscillator.trajectory(State::new([1.0], [0.0]), h, NoNoise).compensated();
    /// let end = path.take(100_000).last().unwrap()?;
    /// assert!((conserved(&end) - 1.0).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Source: Kahan's sum as in Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006), section VIII.5.
    #[must_use]
    pub fn compensated(mut self) -> Self {
        const {
            assert!(
                !S::RETURNS.is_state(),
                "this step is a linear map from state to state: it has no increments to be summed with compensation"
            );
        }
        // one that was resumed has its low parts
        self.compensation.get_or_insert_with(|| Compensation {
            rest: State::new(Q::origin(), Q::no_momentum()),
            step: step::compensated_step,
        });
        self
    }
}

impl<I: Method, W: Noise> Iterator for Trajectory<'_, I, W> {
    type Item = Result<StateOf<I::System>, StepError>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.over {
            return None;
        }
        let item = self.advance().transpose();
        self.over = !matches!(item, Some(Ok(_)));
        item
    }
}
