//! A number by which shards and checkpoints of the same run know one another.
//!
//! Input: the settings, and the first steps of path 0, which stand for what cannot be looked at: parameters, method, closures.
//! Output: 64 bits. Invariant: equal runs have equal numbers, on other machines too: computed values enter in single precision, where the last
//! digit of a platform's functions does not show.
//!
//! Source: the hash is FNV-1a (Fowler, Noll, Vo), `http://www.isthe.com/chongo/tech/comp/fnv/`.

use super::flight::Flight;
use super::increments::Law;
use super::run::Run;
use crate::method::Method;
use crate::noise::lanes::Increments as Source;
use crate::system::{Dims, System};

/// Steps of path 0 that are looked at.
const STEPS: u64 = 8;

struct Hash(u64);

impl Hash {
    fn add(&mut self, word: u64) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn add_computed(&mut self, value: f64) {
        self.add(u64::from((value as f32).to_bits()));
    }
}

impl<I, S, const N: usize, const M: usize> Run<'_, I>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M>>,
{
    pub(super) fn fingerprint(self) -> u64 {
        let mut hash = Hash(0xcbf2_9ce4_8422_2325);
        let ensemble = self.ensemble;
        let (law, exponent) = match ensemble.law {
            Law::Drawn(Source::Normal) => (0, 0.0),
            Law::Drawn(Source::ThreePoint) => (3, 0.0),
            Law::Truncated { exponent } => (1, exponent),
            Law::None => (2, 0.0),
        };
        hash.add(law);
        hash.add(exponent.to_bits());
        hash.add(ensemble.seed);
        hash.add(self.h.to_bits());
        hash.add(self.steps);
        hash.add(u64::from(ensemble.keep_final_states));
        hash.add(N as u64);
        hash.add(M as u64);
        self.look(&mut hash);
        hash.0
    }

    /// The first steps of path 0.
    fn look(self, hash: &mut Hash) {
        let Ok(mut flight) = Flight::new(self, 0, Some(0)) else {
            return;
        };
        let system = self.ensemble.method.system();
        for step in 0..=STEPS.min(self.steps) {
            flight.advance(step);
            let Some(state) = flight.only() else {
                return;
            };
            for value in state.q.iter().chain(&state.p) {
                hash.add_computed(*value);
            }
            for observable in &self.ensemble.observables {
                hash.add_computed(observable.value(system, &state).unwrap_or(f64::NAN));
            }
        }
    }
}
