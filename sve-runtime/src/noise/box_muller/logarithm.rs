//! The logarithm of a uniform number, by a table of 16 entries.
//!
//! Input: a number u in (0, 1], as an integer below 2⁶⁴. Output: −2 ln u. Invariant: the result is
//! not negative, and its relative error is below 10⁻¹⁵, also next to u = 1.
//!
//! u = 2ᵉ m with ¾ < m ≤ 1.5. Four bits of m choose a number c near 1/m, so that −2 ln u = −2
//! ln(1 + r) + 2 ln c − 2e ln 2 with r = cm − 1 and −1/32 ≤ r ≤ 1/33. In the interval below 1, c =
//! 1, so that r is exact and small u − 1 keep their digits. A division would take as long as ten
//! multiplications; two registers of AVX-512 hold the table.

use core::f64::consts::LN_2;

/// The value 2⁶⁴ of u = 1.
const ONE: f64 = 2.0 * super::HALF;

/// Mask of the sign and exponent of a number.
const EXPONENT: u64 = 0xfff0_0000_0000_0000;
const EXPONENT_UNIT: f64 = (1_u64 << 52) as f64;

/// The bits of the smallest mantissa, which is the next number above ¾.
const SMALLEST: u64 = (0.75 * ONE).to_bits() + 1;

const ENTRIES: usize = 16;

/// The numbers c in units of 2⁻⁶⁴: one over the centre of each interval, and 1 for the interval
/// below 1.
const RECIPROCALS: [f64; ENTRIES] = {
    let mut c = [0.0; ENTRIES];
    let mut k = 0;
    while k < 8 {
        c[k] = 64.0 / (49 + 2 * k) as f64 / ONE;
        c[k + 8] = 32.0 / (33 + 2 * k) as f64 / ONE;
        k += 1;
    }
    c[7] = 1.0 / ONE;
    c
};

/// The numbers 2 ln c.
const LOGARITHMS: [f64; ENTRIES] = [
    0.534_125_570_498_090_3,
    0.454_114_901_270_692_15,
    0.377_182_339_615_099_95,
    0.303_099_796_254_401_75,
    0.231_663_631_050_243_3,
    0.162_691_278_907_904_8,
    0.096_018_438_372_721_32,
    0.0,
    -0.061_543_317_333_507_32,
    -0.179_224_317_379_374_33,
    -0.290_364_019_688_995_67,
    -0.395_651_486_659_839_85,
    -0.495_672_327_809_162_4,
    -0.590_928_425_787_671_8,
    -0.681_853_173_941_186_4,
    -0.768_823_397_820_664_1,
];

/// Coefficients of −2 ln(1 + r)/r, to a relative error of 8.2·10⁻¹⁶.
const POLYNOMIAL: [f64; 8] = [
    -2.0,
    0.999_999_999_999_959_6,
    -0.666_666_666_701_170_1,
    0.500_000_000_524_568_2,
    -0.399_999_778_803_071_6,
    0.333_331_821_610_582_17,
    -0.286_117_806_171_179_4,
    0.251_308_249_263_110_74,
];

/// A uniform number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Uniform {
    /// The number 2⁶⁴ u.
    u: f64,
}

impl Uniform {
    /// The number u = 1.
    pub(super) const ONE: Self = Self { u: ONE };

    /// Returns u = (w + ½)/2⁶⁴, rounded, for a rounded word w.
    #[inline(always)]
    pub(super) fn new(word: f64) -> Self {
        Self { u: word + 0.5 }
    }

    /// Returns the bits relative to the smallest mantissa: the exponent e, and below it the number
    /// of the entry.
    #[inline(always)]
    fn offset(self) -> u64 {
        self.u.to_bits().wrapping_sub(SMALLEST)
    }

    /// Returns the number of the table's entry in the lowest four bits.
    #[inline(always)]
    pub(super) fn entry(self) -> u64 {
        self.offset() >> 48
    }

    /// Returns the table's entry: c and 2 ln c.
    #[inline(always)]
    pub(super) fn constants(self) -> [f64; 2] {
        constants(self.entry())
    }

    /// Returns −2 ln u. `DIRECT` selects the conversion of words to numbers, see
    /// [`signed`](super::signed).
    #[inline(always)]
    pub(super) fn minus_two_ln<const DIRECT: bool>(self, [c, two_ln_c]: [f64; 2]) -> f64 {
        let exponent = self.offset() & EXPONENT;
        let m = f64::from_bits(self.u.to_bits().wrapping_sub(exponent));
        let r = m.mul_add(c, -1.0);
        let e = super::signed::<DIRECT>(exponent);
        // In this order the terms are rounded before the large one is added.
        e.mul_add(
            -2.0 * LN_2 / EXPONENT_UNIT,
            r.mul_add(super::polynomial(&POLYNOMIAL, r), two_ln_c),
        )
    }
}

#[inline(always)]
fn constants(entry: u64) -> [f64; 2] {
    let entry = entry as usize % ENTRIES;
    [RECIPROCALS[entry], LOGARITHMS[entry]]
}

/// Reads the table's entries for all lanes: a row of c and a row of 2 ln c.
#[inline(always)]
pub(super) fn look_up<const L: usize, const AVX512: bool>(
    entries: &[u64; L],
    rows: &mut [[f64; L]; 2],
) {
    #[cfg(target_arch = "x86_64")]
    if AVX512 {
        // Safety: the caller passes `AVX512` only if the machine has AVX-512.
        #[allow(unsafe_code)]
        unsafe {
            permute(entries, rows);
        }
        return;
    }
    for lane in 0..L {
        [rows[0][lane], rows[1][lane]] = constants(entries[lane]);
    }
}

/// Reads the table by permutations of registers. The compiler does not find these instructions: it
/// would read memory, one number at a time.
#[cfg(target_arch = "x86_64")]
#[inline]
#[target_feature(enable = "avx512f")]
#[allow(unsafe_code)]
fn permute<const L: usize>(entries: &[u64; L], rows: &mut [[f64; L]; 2]) {
    use core::arch::x86_64::{
        _mm512_loadu_epi64, _mm512_loadu_pd, _mm512_permutex2var_pd, _mm512_storeu_pd,
    };
    const WIDTH: usize = 8;
    const { assert!(L.is_multiple_of(WIDTH)) };
    for (table, row) in [&RECIPROCALS, &LOGARITHMS].into_iter().zip(rows) {
        // Safety: the table has two vectors.
        let [low, high] = unsafe {
            [
                _mm512_loadu_pd(table.as_ptr()),
                _mm512_loadu_pd(table.as_ptr().add(WIDTH)),
            ]
        };
        for (entries, row) in entries.chunks_exact(WIDTH).zip(row.chunks_exact_mut(WIDTH)) {
            // Safety: both parts have the length of a vector.
            unsafe {
                let entries = _mm512_loadu_epi64(entries.as_ptr().cast());
                _mm512_storeu_pd(row.as_mut_ptr(), _mm512_permutex2var_pd(low, entries, high));
            }
        }
    }
}
