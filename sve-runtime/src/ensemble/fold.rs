//! Memories of any type along each path.
//!
//! Input: functions that begin, update and read a memory. Output: an observable of the values that
//! are read. Invariant: a memory sees the start and the state after each step, in order.

use core::marker::PhantomData;

use super::Ensemble;
use super::observe::Function;
use super::observer::{Kind, Observable, Observer, Seen};
use super::systems::Systems;
use super::tile::Place;
use crate::ensemble::PathMethod;
use crate::error::StepError;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::lanes::{LANES, Lane, Mask};
use crate::system::{Dimensions, StateLanesOf, StateOf, System};

impl<'a, I: PathMethod, K> Ensemble<'a, I, K> {
    /// Takes statistics of a memory of any type: `begin` makes it from the start of a path,
    /// `update` is called with the state after each step (and with the state at which a path
    /// [stops](Self::stop_at)), and `value` returns the recorded number.
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
        B: Fn(&I::System, &StateOf<I::System>) -> T + Sync + 'a,
        U: Fn(&mut T, &I::System, &StateOf<I::System>) + Sync + 'a,
        V: Fn(&T) -> f64 + Sync + 'a,
    {
        let fold = Fold {
            begin,
            update,
            value,
            memory: PhantomData,
        };
        self.add(name, fold)
    }
}

/// An observer with a memory of type `T`.
struct Fold<T, B, U, V> {
    begin: B,
    update: U,
    value: V,
    memory: PhantomData<fn() -> T>,
}

impl<S, T, B, U, V> Function<S> for Fold<T, B, U, V>
where
    S: System,
    T: Send,
    B: Fn(&S, &StateOf<S>) -> T + Sync,
    U: Fn(&mut T, &S, &StateOf<S>) + Sync,
    V: Fn(&T) -> f64 + Sync,
{
    /// Evaluates the memory that begins at each state.
    fn tile(&self, systems: &Systems<'_, S>, states: &StateLanesOf<S>, values: &mut Lane) {
        systems.each(|lane, system| {
            let state = <S::Dims as Dimensions>::get(states, lane);
            values[lane] = (self.value)(&(self.begin)(system, &state));
        });
    }

    fn value(&self, system: &S, state: &StateOf<S>) -> Result<f64, StepError> {
        Ok((self.value)(&(self.begin)(system, state)))
    }
}

impl<S, T, B, U, V> Observable<S> for Fold<T, B, U, V>
where
    S: System,
    T: Send,
    B: Fn(&S, &StateOf<S>) -> T + Sync,
    U: Fn(&mut T, &S, &StateOf<S>) + Sync,
    V: Fn(&T) -> f64 + Sync,
{
    fn kind(&self) -> Kind {
        Kind::Fold
    }

    fn function(&self) -> &dyn Function<S> {
        self
    }

    fn has_hidden_memory(&self) -> bool {
        true
    }

    fn observer(&self, tiles: usize, _: u64) -> Box<dyn Observer<S> + '_> {
        Box::new(FoldMemory {
            fold: self,
            tiles: (0..tiles).map(|_| Vec::new()).collect(),
        })
    }
}

/// The memories of a [`Fold`]: for each tile and each lane one memory, from the start on.
struct FoldMemory<'f, T, B, U, V> {
    fold: &'f Fold<T, B, U, V>,
    tiles: Vec<Vec<T>>,
}

impl<S, T, B, U, V> Observer<S> for FoldMemory<'_, T, B, U, V>
where
    S: System,
    T: Send,
    B: Fn(&S, &StateOf<S>) -> T + Sync,
    U: Fn(&mut T, &S, &StateOf<S>) + Sync,
    V: Fn(&T) -> f64 + Sync,
{
    fn update(&mut self, seen: &Seen<'_, S>) -> Mask {
        let Seen {
            systems, states, ..
        } = *seen;
        let memories = &mut self.tiles[seen.tile];
        if seen.step.number == 0 {
            let begin = |lane| (self.fold.begin)(systems.of(lane), &S::Dims::get(states, lane));
            *memories = (0..LANES).map(begin).collect();
        } else {
            dispatch(UpdateTile {
                update: &self.fold.update,
                memories,
                systems,
                states,
            });
        }
        0
    }

    fn values(&self, seen: &Seen<'_, S>, values: &mut Lane) {
        for (value, memory) in values.iter_mut().zip(&self.tiles[seen.tile]) {
            *value = (self.fold.value)(memory);
        }
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
    systems: &'a Systems<'a, S>,
    states: &'a StateLanesOf<S>,
}

impl<S: System, T, U: Fn(&mut T, &S, &StateOf<S>)> Kernel for UpdateTile<'_, S, T, U> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.systems.each(
            #[inline(always)]
            |lane, system| {
                let state = <S::Dims as Dimensions>::get(self.states, lane);
                (self.update)(&mut self.memories[lane], system, &state);
            },
        );
    }
}
