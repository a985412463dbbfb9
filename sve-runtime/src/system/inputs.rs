//! Systems with inputs: values that are held over a step and given to it, like increments.
//!
//! The macro derives the steps of a system whose functions have the argument `u` for a type that
//! holds the values beside the system. So all that a system has, a system with held inputs has too,
//! and the inputs are parameters of it.

use core::ops::Index;

use super::{AnySystem, Kind, StateOf};
use crate::lanes::{LANES, Lane};

/// A system whose functions have the argument `u`; `#[variational]` implements this trait.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no inputs",
    note = "a system has inputs if the last argument of a function of its block is called `u`, as in `fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64`; without them, leave `inputs` and the `u` of the step out"
)]
pub trait WithInputs: AnySystem<Kind = Inputs> {
    /// The type of `u`.
    type Input;
    /// The numbers in `u`, `[f64; K]`.
    type Numbers: AsRef<[f64]> + Copy;
    #[doc(hidden)]
    /// A state in each lane; `()` for a scene.
    type Lanes: Clone;
    /// The system while its inputs are held.
    type Held<'a>: AnySystem<
            Configuration = <Self as AnySystem>::Configuration,
            StateLanes = Self::Lanes,
            Target = Self::Held<'a>,
            Stepped = Self::Held<'a>,
        > + Clone
    where
        Self: 'a;
    /// Returns the state of a lane; `None` for a scene.
    #[doc(hidden)]
    fn lane(states: &Self::Lanes, lane: usize) -> Option<StateOf<Self>>;
    /// Returns the numbers in `u`.
    fn numbers(u: &Self::Input) -> Self::Numbers;
    /// Returns the system while the inputs have these values.
    fn held(&self, u: &Self::Input) -> Self::Held<'_> {
        self.held_numbers(Self::numbers(u))
    }
    /// Returns the system while the numbers in its inputs have these values.
    #[doc(hidden)]
    fn held_numbers(&self, numbers: Self::Numbers) -> Self::Held<'_>;
    /// The numbers of a system between two steps: none is a number.
    #[doc(hidden)]
    const OPEN: Self::Numbers;
    /// Returns the inputs of a system that holds them.
    #[doc(hidden)]
    fn inputs_of<'h>(held: &'h mut Self::Held<'_>) -> &'h mut HeldInputs<Self::Numbers>;
}

/// The inputs that a system holds over a step: the same for all lanes, or others in each lane.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct HeldInputs<N> {
    all: N,
    /// The inputs of each lane, which steps in lanes read.
    lanes: Option<Box<[N; LANES]>>,
}

impl<N: Copy> HeldInputs<N> {
    /// Returns inputs that are the same for all lanes.
    #[inline(always)]
    pub fn new(all: N) -> Self {
        Self { all, lanes: None }
    }

    /// Sets the inputs of steps that are not in lanes.
    #[inline]
    pub(crate) fn set(&mut self, all: N) {
        self.all = all;
    }

    /// Returns the inputs of each lane, to be set.
    pub(crate) fn lanes(&mut self) -> &mut [N; LANES] {
        self.lanes
            .get_or_insert_with(|| Box::new([self.all; LANES]))
    }
}

impl<const K: usize> Index<usize> for HeldInputs<[f64; K]> {
    type Output = f64;

    #[inline(always)]
    fn index(&self, k: usize) -> &f64 {
        &self.all[k]
    }
}

/// Returns the inputs in lanes, a row for each number in them.
#[doc(hidden)]
#[inline(always)]
pub fn inputs<const K: usize>(held: &HeldInputs<[f64; K]>) -> [Lane; K] {
    let mut rows = [[0.0; LANES]; K];
    for (k, row) in rows.iter_mut().enumerate() {
        match &held.lanes {
            None => *row = [held.all[k]; LANES],
            Some(lanes) => {
                for lane in 0..LANES {
                    row[lane] = lanes[lane][k];
                }
            }
        }
    }
    rows
}

/// The kind of systems with inputs, whose steps need their values.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Inputs;

impl Kind for Inputs {
    type Cache = ();
}

#[diagnostic::do_not_recommend]
impl<'b, S: WithInputs> WithInputs for &'b S
where
    &'b S: AnySystem<Kind = Inputs, Configuration = S::Configuration>,
{
    type Input = S::Input;
    type Numbers = S::Numbers;
    type Lanes = S::Lanes;
    type Held<'a>
        = S::Held<'a>
    where
        Self: 'a;

    fn lane(states: &S::Lanes, lane: usize) -> Option<StateOf<S>> {
        S::lane(states, lane)
    }

    fn numbers(u: &S::Input) -> S::Numbers {
        S::numbers(u)
    }

    fn held_numbers(&self, numbers: S::Numbers) -> S::Held<'_> {
        (**self).held_numbers(numbers)
    }

    const OPEN: S::Numbers = S::OPEN;

    fn inputs_of<'h>(held: &'h mut S::Held<'_>) -> &'h mut HeldInputs<S::Numbers> {
        S::inputs_of(held)
    }
}
