//! The starts of paths, and the generator for random starts.

use core::convert::Infallible;
use core::fmt;

use crate::noise::{box_muller, threefry};
use crate::phase::configuration::Configuration;
use crate::phase::state::State;

/// Part of the generator's key that separates these draws from the increments of the same seed and
/// path.
const DOMAIN: u64 = u64::from_le_bytes(*b"start   ");

/// Returns the start of a path.
type Draw<'a, T> = Box<dyn Fn(u64, &mut StartRng) -> T + Sync + 'a>;

/// The starts of the paths of an ensemble: one state for all of them, or a state for each.
///
/// [`Ensemble::start`](super::Ensemble::start) takes a plain state, or random starts as
/// [`Starts::each`].
pub struct Starts<'a, T>(pub(super) Start<'a, T>);

/// The two kinds of starts.
pub(super) enum Start<'a, T> {
    /// One state for all paths.
    Same(T),
    /// A state for each path.
    Drawn(Draw<'a, T>),
}

impl<'a, T> Starts<'a, T> {
    /// Starts each path in its own state: a function of the number of the path and of a generator
    /// for this path. All paths have to start at the same time.
    ///
    #[doc = include_str!("example.md")]
    /// // positions and momenta of the temperature kT = 4
    /// let summary = ensemble()
    ///     .start(Starts::each(|_path, rng| State::new([2.0 * rng.normal()], [2.0 * rng.normal()])))
    ///     .run()?;
    /// assert!((summary["q"].variance()[0] - 4.0).abs() < 3.0);
    #[doc = include_str!("../example_end.md")]
    pub fn each(draw: impl Fn(u64, &mut StartRng) -> T + Sync + 'a) -> Self {
        Self(Start::Drawn(Box::new(draw)))
    }
}

impl<Q: Configuration> From<State<Q>> for Starts<'_, State<Q>> {
    /// Starts all paths in one state.
    fn from(state: State<Q>) -> Self {
        Self(Start::Same(state))
    }
}

impl<T: fmt::Debug> fmt::Debug for Starts<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Start::Same(state) => f.debug_tuple("Starts").field(state).finish(),
            Start::Drawn(_) => f.write_str("Starts::each(…)"),
        }
    }
}

/// The generator of random numbers for the start of a path. Its numbers depend on seed and path
/// only.
///
/// It is a generator of the `rand` crates (`rand_core` 0.10), so it serves any distribution of
/// theirs. [`normal`](Self::normal) and [`uniform`](Self::uniform) need no further crate. The
/// numbers are independent of the path's Wiener increments.
///
/// Generator: Threefry4x64-13 under the key (seed, path, domain, 0), as for
/// [`Wiener`](crate::noise::Wiener) with another domain.
#[derive(Clone, Debug)]
pub struct StartRng {
    key: [u64; 4],
    counter: u64,
    words: [u64; 4],
    /// Number of words of the block already used.
    used: usize,
    /// The second normal of a pair.
    spare: Option<f64>,
}

impl StartRng {
    pub(super) fn new(seed: u64, path: u64) -> Self {
        Self {
            key: [seed, path, DOMAIN, 0],
            counter: 0,
            words: [0; 4],
            used: 4,
            spare: None,
        }
    }

    /// Returns the next word.
    fn word(&mut self) -> u64 {
        if self.used == 4 {
            self.words = threefry::block([self.counter, 0, 0, 0], self.key);
            self.counter += 1;
            self.used = 0;
        }
        self.used += 1;
        self.words[self.used - 1]
    }

    /// Returns a standard normal number.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let [first, second] = box_muller::pair(self.word(), self.word(), 1.0);
        self.spare = Some(second);
        first
    }

    /// Returns a uniform number from 0 to 1, a multiple of 2⁻⁵³ below 1.
    pub fn uniform(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

impl rand_core::TryRng for StartRng {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok((self.word() >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.word())
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for part in bytes.chunks_mut(8) {
            part.copy_from_slice(&self.word().to_le_bytes()[..part.len()]);
        }
        Ok(())
    }
}
