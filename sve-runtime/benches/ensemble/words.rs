//! Random words in lanes: one sequential generator, and two generators that are functions of a
//! counter.
//!
//! Output: words as good as random, with a separate stream in each lane. [`check`] compares them
//! with the known answers of their authors.
//!
//! Sources: Blackman, Vigna, *Scrambled linear pseudorandom number generators* (2021) for
//! xoshiro256++; Salmon, Moraes, Dror, Shaw, *Parallel random numbers: as easy as 1, 2, 3*, SC '11
//! (2011) for the others.

use std::array::from_fn;

/// Streams of words, one for each lane.
pub(crate) trait Words<const W: usize>: Copy {
    /// Returns the next four words of a lane. All lanes have to be asked before
    /// [`advance`](Self::advance).
    fn four(&mut self, lane: usize) -> [u64; 4];
    /// Continues with the next words.
    fn advance(&mut self) {}
}

/// xoshiro256++, with one state for each lane.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Xoshiro<const W: usize>([[u64; W]; 4]);

impl<const W: usize> Xoshiro<W> {
    /// Returns states from the words of `SplitMix64`, as the authors advise.
    pub(crate) fn new(seed: u64) -> Self {
        let mut x = seed;
        let mut next = || {
            x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^ (z >> 31)
        };
        Self(from_fn(|_| from_fn(|_| next())))
    }

    /// Returns the next word of a lane.
    #[inline(always)]
    pub(crate) fn next(&mut self, lane: usize) -> u64 {
        let [a, b, c, d] = &mut self.0;
        let word = a[lane]
            .wrapping_add(d[lane])
            .rotate_left(23)
            .wrapping_add(a[lane]);
        let shifted = b[lane] << 17;
        c[lane] ^= a[lane];
        d[lane] ^= b[lane];
        b[lane] ^= c[lane];
        a[lane] ^= d[lane];
        c[lane] ^= shifted;
        d[lane] = d[lane].rotate_left(45);
        word
    }
}

impl<const W: usize> Words<W> for Xoshiro<W> {
    #[inline(always)]
    fn four(&mut self, lane: usize) -> [u64; 4] {
        [
            self.next(lane),
            self.next(lane),
            self.next(lane),
            self.next(lane),
        ]
    }
}

/// Philox4x32-10. Lane and key give the path, the counter gives the block.
#[derive(Clone, Copy)]
pub(crate) struct Philox {
    pub(crate) seed: u64,
    pub(crate) block: u64,
}

/// Makes ten rounds. Words of 32 bits stand in words of 64 bits, which vectors can multiply.
#[inline(always)]
fn philox(mut x: [u64; 4], [mut k0, mut k1]: [u64; 2]) -> [u64; 4] {
    const LOW: u64 = 0xffff_ffff;
    for _ in 0..10 {
        let (a, b) = (x[0] * 0xd251_1f53, x[2] * 0xcd9e_8d57);
        x = [
            (b >> 32) ^ x[1] ^ k0,
            b & LOW,
            (a >> 32) ^ x[3] ^ k1,
            a & LOW,
        ];
        k0 = (k0 + 0x9e37_79b9) & LOW;
        k1 = (k1 + 0xbb67_ae85) & LOW;
    }
    x
}

impl<const W: usize> Words<W> for Philox {
    #[inline(always)]
    fn four(&mut self, lane: usize) -> [u64; 4] {
        let key = [self.seed & 0xffff_ffff, self.seed >> 32];
        let (low, high) = (self.block & 0xffff_ffff, self.block >> 32);
        // A block has two words of 64 bits.
        let a = philox([low, high, lane as u64, 0], key);
        let b = philox([low, high, lane as u64, 1], key);
        let word = |x: [u64; 4], i: usize| x[i] | x[i + 1] << 32;
        [word(a, 0), word(a, 2), word(b, 0), word(b, 2)]
    }

    #[inline(always)]
    fn advance(&mut self) {
        self.block += 1;
    }
}

/// Threefry4x64-13. The path is part of the key, and the counter gives the block.
#[derive(Clone, Copy)]
pub(crate) struct Threefry {
    pub(crate) seed: u64,
    pub(crate) block: u64,
}

/// Makes thirteen rounds, written out: the compiler does not unroll a loop over them before it
/// turns lanes into vectors.
#[inline(always)]
fn threefry(mut x: [u64; 4], key: [u64; 4]) -> [u64; 4] {
    let [k0, k1, k2, k3] = key;
    let schedule = [k0, k1, k2, k3, 0x1bd1_1bda_a9fc_1a22 ^ k0 ^ k1 ^ k2 ^ k3];
    let key = |x: &mut [u64; 4], n: usize| {
        for i in 0..4 {
            x[i] = x[i].wrapping_add(schedule[(n + i) % 5]);
        }
        x[3] = x[3].wrapping_add(n as u64);
    };
    let mix = |x: &mut [u64; 4], a: usize, b: usize, rotation: u32| {
        x[a] = x[a].wrapping_add(x[b]);
        x[b] = x[b].rotate_left(rotation) ^ x[a];
    };
    let even = |x: &mut [u64; 4], r: [u32; 2]| {
        mix(x, 0, 1, r[0]);
        mix(x, 2, 3, r[1]);
    };
    let odd = |x: &mut [u64; 4], r: [u32; 2]| {
        mix(x, 0, 3, r[0]);
        mix(x, 2, 1, r[1]);
    };
    let first = |x: &mut [u64; 4]| {
        even(x, [14, 16]);
        odd(x, [52, 57]);
        even(x, [23, 40]);
        odd(x, [5, 37]);
    };
    key(&mut x, 0);
    first(&mut x);
    key(&mut x, 1);
    even(&mut x, [25, 33]);
    odd(&mut x, [46, 12]);
    even(&mut x, [58, 22]);
    odd(&mut x, [32, 32]);
    key(&mut x, 2);
    first(&mut x);
    key(&mut x, 3);
    even(&mut x, [25, 33]);
    x
}

impl<const W: usize> Words<W> for Threefry {
    #[inline(always)]
    fn four(&mut self, lane: usize) -> [u64; 4] {
        threefry([self.block, 0, 0, 0], [self.seed, lane as u64, 0, 0])
    }

    #[inline(always)]
    fn advance(&mut self) {
        self.block += 1;
    }
}

/// Compares each generator with the known answers that its authors publish.
///
/// # Panics
/// If a result differs.
pub(crate) fn check() {
    let mut sequence = Xoshiro([[1], [2], [3], [4]]);
    let first: [u64; 5] = from_fn(|_| sequence.next(0));
    let known = [
        41_943_041,
        58_720_359,
        3_588_806_011_781_223,
        3_591_011_842_654_386,
        9_228_616_714_210_784_205,
    ];
    assert_eq!(first, known, "xoshiro256++ from the state 1, 2, 3, 4");

    let pi = [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344];
    assert_eq!(
        philox([0; 4], [0; 2]),
        [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8],
        "Philox4x32-10 of zeros"
    );
    assert_eq!(
        philox(pi, [0xa409_3822, 0x299f_31d0]),
        [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
        "Philox4x32-10 of the digits of π"
    );
    assert_eq!(
        threefry([0; 4], [0; 4]),
        [
            0x4071_fabe_e1dc_8e05,
            0x02ed_3113_695c_9c62,
            0x3973_11b5_b89f_9d49,
            0xe212_92c3_2580_24bc
        ],
        "Threefry4x64-13 of zeros"
    );
}
