//! Steps of scenes: lists of shears, made in place by tables that the integrator keeps.

use core::fmt;
use std::sync::{Mutex, PoisonError};

use super::Integrator;
use super::accept::check_step_size;
use super::steps::Steps;
use crate::error::StepError;
use crate::phase::configuration::Site;
use crate::phase::state::State;
use crate::rule::{Rule, StepShear, Walker, shears};
use crate::scene::{Layout, Phase, Prepared, Scene, check_length};
use crate::system::{AnySystem, Kind};
use crate::time::is_next_time;

/// The kind of systems whose length is that of the state.
#[derive(Clone, Copy, Debug)]
pub struct Scenes;

impl Kind for Scenes {
    type Cache = Tables;
}

/// The tables of a scene for the length of its last state. Steps of one integrator on several
/// threads wait for one another; threads with integrators of their own do not.
#[derive(Default)]
pub struct Tables(Mutex<Option<Kept>>);

struct Kept {
    prepared: Prepared,
    /// The shears of a step, and its length; NaN before the first step.
    shears: Vec<StepShear>,
    h: f64,
}

impl fmt::Debug for Tables {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Tables")
    }
}

impl Clone for Tables {
    /// Returns empty tables, which the first step fills.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Tables {
    /// Works with the tables of a scene of `n` sites.
    ///
    /// # Errors
    /// As [`Prepared::new`].
    fn with<S: Scene, T>(
        &self,
        scene: &S,
        n: usize,
        t: f64,
        work: impl FnOnce(&mut Kept) -> T,
    ) -> Result<T, StepError> {
        let is_poisoned = self.0.is_poisoned();
        let mut tables = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if is_poisoned {
            // a panic within a step may have left impulses behind
            *tables = None;
            self.0.clear_poison();
        }
        let kept = match &mut *tables {
            Some(kept) if kept.prepared.sites() == n => kept,
            other => other.insert(Kept {
                prepared: Prepared::new(scene, n, t)?,
                shears: Vec::new(),
                h: f64::NAN,
            }),
        };
        Ok(work(kept))
    }
}

impl Kept {
    /// Returns the tables, and the shears of a step of length `h`.
    fn for_steps<S, R: Rule<S>>(
        &mut self,
        walker: Walker<'_, S, R>,
        h: f64,
    ) -> (&mut Prepared, &[StepShear]) {
        if self.h != h {
            shears(walker, &R::prepare(walker.system, h), h, &mut self.shears);
            self.h = h;
        }
        (&mut self.prepared, &self.shears)
    }
}

impl<S, R, Q> Steps<S, R> for Scenes
where
    // The bound that determines `Q` comes first: with `Q::Row` before it, adapters that fold a
    // borrowed trajectory stop the compiler (rustc 1.95).
    S: AnySystem<Configuration = Vec<Q>> + Scene<Row = Q::Row>,
    R: Rule<S, Increments = [f64]>,
    Q: Site,
{
    /// The tables have what the steps need.
    type Prepared = ();

    fn prepare(_: Walker<'_, S, R>, _: &Tables, _: f64) {}

    fn step(
        walker: Walker<'_, S, R>,
        cache: &Tables,
        (): &(),
        state: &mut State<Vec<Q>>,
        h: f64,
        dw: &[f64],
    ) -> Result<(), StepError> {
        step(walker, cache, state, h, dw, false)
    }

    fn next_step(
        walker: Walker<'_, S, R>,
        cache: &Tables,
        (): &mut (),
        state: &mut State<Vec<Q>>,
        h: f64,
        dw: &[f64],
    ) -> Result<(), StepError> {
        // the state before a step of a trajectory that fails is its last one
        step(walker, cache, state, h, dw, true)
    }

    fn next_steps(
        walker: Walker<'_, S, R>,
        cache: &Tables,
        (): &mut (),
        state: &mut State<Vec<Q>>,
        h: f64,
        dw: &mut [f64],
        count: u64,
        draw: &mut dyn FnMut(u64, &mut [f64]) -> Option<f64>,
    ) -> u64 {
        let Ok(n) = sites(state) else {
            return 0;
        };
        let mut phase = Phase {
            q: Q::rows_mut(&mut state.q),
            p: Q::rows_mut(&mut state.p),
        };
        let (scene, t) = (walker.system, &mut state.t);
        // The single step that follows finds the error.
        let made = cache.with(scene, n, *t, |kept| {
            let (tables, shears) = kept.for_steps(walker, h);
            tables.block(scene, shears, &mut phase, t, dw, count, draw)
        });
        made.unwrap_or(0)
    }

    fn processes(
        walker: Walker<'_, S, R>,
        cache: &Tables,
        state: &State<Vec<Q>>,
    ) -> Result<usize, StepError> {
        let n = state.q.len();
        cache.with(walker.system, n, state.t, |kept| kept.prepared.processes())
    }
}

/// Makes a step. If it fails, the state is unchanged if `is_exact`, and otherwise restored as by
/// [`Prepared::step`].
fn step<S, R, Q>(
    walker: Walker<'_, S, R>,
    cache: &Tables,
    state: &mut State<Vec<Q>>,
    h: f64,
    dw: &[f64],
    is_exact: bool,
) -> Result<(), StepError>
where
    S: AnySystem<Configuration = Vec<Q>> + Scene<Row = Q::Row>,
    R: Rule<S, Increments = [f64]>,
    Q: Site,
{
    let t = state.t;
    if !t.is_finite() {
        let (what, value) = ("t".to_owned(), t);
        return Err(StepError::NonFiniteInput { what, value, t });
    }
    if !is_next_time(t, t + h) {
        return Err(StepError::Time { t, h, end: t + h });
    }
    let n = sites(state)?;
    let mut phase = Phase {
        q: Q::rows_mut(&mut state.q),
        p: Q::rows_mut(&mut state.p),
    };
    let scene = walker.system;
    cache.with(scene, n, t, |kept| {
        let (tables, shears) = kept.for_steps(walker, h);
        check_length("dw", dw.len(), tables.processes(), t)?;
        tables.step(scene, shears, &mut phase, [t, h], dw, is_exact)
    })??;
    state.t = t + h;
    Ok(())
}

/// Returns the number of sites.
fn sites<Q: Site>(state: &State<Vec<Q>>) -> Result<usize, StepError> {
    let n = state.q.len();
    check_length("p", state.p.len(), n, state.t)?;
    Ok(n)
}

impl<S, R, T, Q> Integrator<S, R>
where
    S: AnySystem<Target = T, Kind = Scenes>,
    T: AnySystem<Configuration = Vec<Q>> + Scene<Row = Q::Row>,
    R: Rule<T>,
    Q: Site,
{
    /// Returns how the loops of a scene are made from a state with steps of length `h`: which of
    /// them are gathered, in how many segments, and how many bytes that needs. For steps of
    /// `midpoint` it makes one from a copy of the state without noise, and tells the bounds of its
    /// equations and the number of sweeps.
    ///
    /// # Errors
    /// The error of a step from this state; of an explicit one as far as its lengths and indices
    /// are concerned.
    pub fn layout(&self, state: &State<Vec<Q>>, h: f64) -> Result<Layout, StepError> {
        check_step_size(h)?;
        let (scene, n) = (self.system().target(), sites(state)?);
        let mut end = state.clone();
        let arrays = [Q::rows_mut(&mut end.q), Q::rows_mut(&mut end.p)];
        (self.cache).with(scene, n, state.t, |kept| {
            let (prepared, shears) = kept.for_steps(self.walker(), h);
            let solved = prepared.solved(scene, shears, arrays, [state.t, h])?;
            let mut layout = prepared.layout::<T>(shears);
            layout.midpoint = solved;
            Ok(layout)
        })?
    }
}
