//! Where paths start, and the generator for starts drawn at random.

use core::convert::Infallible;

use crate::noise::{box_muller, threefry};

/// Separates these draws from the increments of the same seed and path.
const DOMAIN: u64 = u64::from_le_bytes(*b"start   ");

/// The start of a path, by its number.
type Draw<'a, T> = Box<dyn Fn(u64, &mut StartRng) -> T + Sync + 'a>;

/// Where paths start.
pub(super) enum Start<'a, T> {
    /// All at one state.
    Same(T),
    /// Each at its own.
    Drawn(Draw<'a, T>),
}

/// The generator of random numbers for the start of a path: a function of seed and path alone.
///
/// It is a generator of the `rand` crates (`rand_core` 0.10), so any distribution of theirs can be drawn from it;
/// [`normal`](Self::normal) and [`uniform`](Self::uniform) need no further crate. Its numbers are independent of the path's Wiener increments.
///
/// Generator: Threefry4x64-13 under the key (seed, path, domain, 0), as for [`Wiener`](crate::noise::Wiener) with another domain.
#[derive(Clone, Debug)]
pub struct StartRng {
    key: [u64; 4],
    counter: u64,
    words: [u64; 4],
    /// Words of the block already given.
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

    /// The next word.
    fn word(&mut self) -> u64 {
        if self.used == 4 {
            self.words = threefry::block([self.counter, 0, 0, 0], self.key);
            self.counter += 1;
            self.used = 0;
        }
        self.used += 1;
        self.words[self.used - 1]
    }

    /// A standard normal.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let [first, second] = box_muller::pair(self.word(), self.word(), 1.0);
        self.spare = Some(second);
        first
    }

    /// A number uniform between 0 and 1, a multiple of 2⁻⁵³, never 1.
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
