//! Observers with memory: integrals, maxima and crossings along each path, and memories of any type.
//!
//! Input: functions of the system and a state. Output: observables whose values depend on all steps until the recorded time. Invariant: a memory sees the
//! start and the state after each step, in order.

use core::marker::PhantomData;

use super::Ensemble;
use super::memory::{Kind, LastStep, PathMemory};
use super::observe::{Closure, Observable};
use super::tile::Place;
use crate::error::Observed;
use crate::error::StepError;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{LANES, Lane, Mask};
use crate::phase::configuration::Coordinates;
use crate::phase::state::State;
use crate::system::{Dimensions, Dims, StateLanesOf, StateOf, System};
use crate::trajectory::Method;

impl<'a, I, S, Q, const N: usize, const M: usize> Ensemble<'a, I>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Takes statistics of the integral ∫f dt of a function along each path, from the start to the recorded time, by the trapezoidal rule over all steps.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator;
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let oscillator = Integrator::new(Oscillator, Midpoint);
    /// let summary = Ensemble::new(&oscillator)
    ///     .paths(10).steps(0.01, 1000)
    ///     .start(State::new([1.0], [0.0]))
    ///     .integral("area", |_, state| state.q[0])
    ///     .maximum("speed", |_, state| state.p[0].abs())
    ///     .crossings("turns", |_, state| state.p[0])
    ///     .run()?;
    /// // q = cos t, p = −sin t, until t = 10
    /// assert!((summary["area"].mean()[1] - 10_f64.sin()).abs() < 1e-3);
    /// assert!((summary["speed"].mean()[1] - 1.0).abs() < 1e-4);
    /// assert_eq!(summary["turns"].mean()[1], 3.0);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn integral<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&S, &State<Q>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name.into(), Closure::new(function), Kind::Integral)
    }

    /// Takes statistics of the greatest value that a function has had along each path: at the start, after each step until the recorded time, and where a path [stops](Self::stop_at).
    ///
    /// What lies between two steps is not seen. For a function with a smooth motion the maximum is too small by O(h²). A function that the noise moves itself, such as
    /// a momentum with noise of strength σ, has a mean maximum that is too small by about 0.58 σ√h (Chernoff 1965; Broadie, Glasserman and Kou 1997).
    /// [`integral`](Self::integral) has an example.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().maximum("highest", |_, state| state.q[0]).run()?;
    /// assert_eq!(summary["highest"].mean()[0], 1.0); // at the start
    /// assert!(summary["highest"].min()[1] >= 1.0);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn maximum<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&S, &State<Q>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name.into(), Closure::new(function), Kind::Maximum)
    }

    /// Takes statistics of the number of times that a function has changed its sign from one step to the next, along each path.
    ///
    /// A value of exactly 0 after a step is a change, leaving from there is none. Two changes within a step are not seen. [`integral`](Self::integral) has an example.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().crossings("zeros", |_, state| state.q[0]).run()?;
    /// assert_eq!(summary["zeros"].mean()[0], 0.0);
    /// assert!(summary["zeros"].mean()[1] > 0.0);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn crossings<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&S, &State<Q>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add(name.into(), Closure::new(function), Kind::Crossings)
    }

    /// Takes statistics of a memory of any type: `begin` makes it from the start of a path, `update` is called with the state after each step (and with the
    /// state at which a path [stops](Self::stop_at)), and `value` is what is recorded.
    ///
    /// A path on which the value at a recorded time is not finite fails.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Pendulum;
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { 0.3 * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let pendulum = Integrator::new(Pendulum, Midpoint);
    /// let summary = Ensemble::new(&pendulum)
    ///     .paths(100).seed(1).steps(0.05, 400)
    ///     .start(State::new([1.0], [0.0]))
    ///     // the width of the interval that a path has visited
    ///     .fold(
    ///         "width",
    ///         |_, state| [state.q[0], state.q[0]],
    ///         |[low, high], _, state| {
    ///             *low = low.min(state.q[0]);
    ///             *high = high.max(state.q[0]);
    ///         },
    ///         |[low, high]| high - low,
    ///     )
    ///     .run()?;
    /// assert_eq!(summary["width"].mean()[0], 0.0);
    /// assert!(summary["width"].min()[1] > 1.0);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn fold<T, B, U, V>(self, name: impl Into<String>, begin: B, update: U, value: V) -> Self
    where
        T: Send + 'a,
        B: Fn(&S, &State<Q>) -> T + Sync + 'a,
        U: Fn(&mut T, &S, &State<Q>) + Sync + 'a,
        V: Fn(&T) -> f64 + Sync + 'a,
    {
        let fold = Fold {
            begin,
            update,
            value,
            memory: PhantomData,
        };
        self.add(name.into(), fold, Kind::Fold)
    }
}

/// An observer with a memory of type `T`.
struct Fold<T, B, U, V> {
    begin: B,
    update: U,
    value: V,
    memory: PhantomData<fn() -> T>,
}

impl<S, T, B, U, V> Observable<S> for Fold<T, B, U, V>
where
    S: System,
    T: Send,
    B: Fn(&S, &StateOf<S>) -> T + Sync,
    U: Fn(&mut T, &S, &StateOf<S>) + Sync,
    V: Fn(&T) -> f64 + Sync,
{
    /// Evaluates the memory that begins at each state.
    fn tile(&self, system: &S, states: &StateLanesOf<S>, values: &mut Lane) {
        for (lane, value) in values.iter_mut().enumerate() {
            let state = <S::Dims as Dimensions>::get(states, lane);
            *value = (self.value)(&(self.begin)(system, &state));
        }
    }

    fn value(&self, system: &S, state: &StateOf<S>) -> Result<f64, StepError> {
        Ok((self.value)(&(self.begin)(system, state)))
    }

    fn memory(&self, tiles: usize) -> Option<Box<dyn PathMemory<S> + '_>> {
        Some(Box::new(FoldMemory {
            fold: self,
            tiles: (0..tiles).map(|_| Vec::new()).collect(),
        }))
    }
}

/// The memories of a [`Fold`]: for each tile one for each lane, from the start on.
struct FoldMemory<'f, T, B, U, V> {
    fold: &'f Fold<T, B, U, V>,
    tiles: Vec<Vec<T>>,
}

impl<S, T, B, U, V> PathMemory<S> for FoldMemory<'_, T, B, U, V>
where
    S: System,
    T: Send,
    B: Fn(&S, &StateOf<S>) -> T + Sync,
    U: Fn(&mut T, &S, &StateOf<S>) + Sync,
    V: Fn(&T) -> f64 + Sync,
{
    fn update(
        &mut self,
        tile: usize,
        system: &S,
        states: &StateLanesOf<S>,
        step: &LastStep,
    ) -> Mask {
        let memories = &mut self.tiles[tile];
        if step.number == 0 {
            let begin = |lane| (self.fold.begin)(system, &S::Dims::get(states, lane));
            *memories = (0..LANES).map(begin).collect();
        } else {
            dispatch(UpdateTile {
                update: &self.fold.update,
                memories,
                system,
                states,
            });
        }
        0
    }

    fn values(&self, tile: usize, _: &LastStep) -> Lane {
        let memories = &self.tiles[tile];
        core::array::from_fn(|lane| (self.fold.value)(&memories[lane]))
    }

    fn move_lane(&mut self, from: Place, to: Place) {
        if from.tile == to.tile {
            return self.tiles[to.tile].swap(from.lane, to.lane);
        }
        if let Ok([source, target]) = self.tiles.get_disjoint_mut([from.tile, to.tile]) {
            core::mem::swap(&mut source[from.lane], &mut target[to.lane]);
        }
    }
}

/// The update of the memories of a tile.
struct UpdateTile<'a, S: System, T, U> {
    update: &'a U,
    memories: &'a mut [T],
    system: &'a S,
    states: &'a StateLanesOf<S>,
}

impl<S: System, T, U: Fn(&mut T, &S, &StateOf<S>)> Kernel for UpdateTile<'_, S, T, U> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (lane, memory) in self.memories.iter_mut().enumerate().take(LANES) {
            let state = <S::Dims as Dimensions>::get(self.states, lane);
            (self.update)(memory, self.system, &state);
        }
    }
}
