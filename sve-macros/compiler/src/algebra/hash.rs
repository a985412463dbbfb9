//! A hasher for the small keys of the arena: one rotation and one multiplication for each word.
//!
//! The default hasher is made for keys that an attacker chooses, and took a fifth of the time of an
//! expansion. It is also seeded at random; this hasher is not.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A map that is looked up and never iterated.
pub(crate) type Map<K, V> = HashMap<K, V, BuildHasherDefault<Multiply>>;

/// State of the hash.
#[derive(Clone, Copy, Default)]
pub(crate) struct Multiply(u64);

impl Multiply {
    fn word(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

impl Hasher for Multiply {
    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        for &word in words {
            self.word(u64::from_le_bytes(word));
        }
        for &byte in rest {
            self.word(u64::from(byte));
        }
    }

    fn write_u32(&mut self, x: u32) {
        self.word(u64::from(x));
    }

    fn write_i32(&mut self, x: i32) {
        self.word(u64::from(x.cast_unsigned()));
    }

    fn write_u64(&mut self, x: u64) {
        self.word(x);
    }

    fn write_usize(&mut self, x: usize) {
        self.word(x as u64);
    }

    fn write_isize(&mut self, x: isize) {
        self.word(x.cast_unsigned() as u64);
    }

    fn finish(&self) -> u64 {
        // a hash table uses low and high bits, and the multiplication mixed only the high ones
        self.0 ^ (self.0 >> 32)
    }
}
