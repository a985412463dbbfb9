//! Fingerprints: hashes by which runs, studies and snapshots know that their steps are the same.
//!
//! Input: a method with its system. Output: a 64-bit hash each of the formulas, of the values of
//! the parameters, and of the method with its options, so that a message can name the one that
//! differs. Invariant: equal steps have equal hashes; every value enters with all its bits. Every
//! field that the block of a system reads is a parameter.
//!
//! Source of the hash: XXH64 (Y. Collet, `https://xxhash.com`), by the crate `twox-hash`.

use core::hash::Hasher as _;

use twox_hash::XxHash64;

use crate::method::OneStepMethod;
use crate::system::AnySystem as _;

/// A hasher with the same bits on machines of either byte order.
#[derive(Default)]
pub(crate) struct Hash(XxHash64);

impl Hash {
    pub(crate) fn add(&mut self, word: u64) {
        self.0.write(&word.to_le_bytes());
    }

    /// Adds all bits of a number; all NaNs count as the same.
    pub(crate) fn add_number(&mut self, x: f64) {
        self.add(if x.is_nan() { f64::NAN } else { x }.to_bits());
    }

    pub(crate) fn finish(&self) -> u64 {
        self.0.finish()
    }
}

/// Returns the hash of the data that a function adds.
pub(crate) fn hash(of: impl FnOnce(&mut Hash)) -> u64 {
    let mut hash = Hash::default();
    of(&mut hash);
    hash.finish()
}

/// The fingerprint of the steps of a method: everything that determines them besides state, step
/// size and increments.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct StepsFingerprint {
    formulas: u64,
    parameters: u64,
    method: u64,
}

/// The first part in which two methods differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StepsDifference {
    Formulas,
    Parameters,
    Method,
}

impl StepsFingerprint {
    /// Returns the fingerprint of a method with its system.
    pub(crate) fn of<I: OneStepMethod>(method: &I) -> Self {
        let system = method.system();
        Self {
            formulas: hash(|hash| hash.add(I::System::FORMULAS_HASH)),
            parameters: hash(|hash| system.visit_parameters(&mut |x| hash.add_number(x))),
            method: hash(|hash| method.identify(&mut hash.0)),
        }
    }

    /// Returns the first difference to another method.
    pub(crate) fn difference(&self, other: &Self) -> Option<StepsDifference> {
        [
            (self.formulas == other.formulas, StepsDifference::Formulas),
            (
                self.parameters == other.parameters,
                StepsDifference::Parameters,
            ),
            (self.method == other.method, StepsDifference::Method),
        ]
        .into_iter()
        .find_map(|(same, what)| (!same).then_some(what))
    }
}
