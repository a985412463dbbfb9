//! The forces of all pairs of bodies by the instructions of AVX-512.
#![cfg(target_arch = "x86_64")]

use std::arch::x86_64::{
    __m512d, _mm512_fmadd_pd, _mm512_fnmadd_pd, _mm512_mask_storeu_pd, _mm512_maskz_div_pd,
    _mm512_maskz_loadu_pd, _mm512_mul_pd, _mm512_reduce_add_pd, _mm512_set1_pd, _mm512_sqrt_pd,
    _mm512_sub_pd,
};

/// Returns whether this machine has the instructions.
pub(crate) fn is_here() -> bool {
    std::arch::is_x86_feature_detected!("avx512f")
}

/// Adds the forces of all pairs, from arrays of coordinates and of forces. Call it where
/// [`is_here`].
pub(crate) fn all_pairs(
    x: &[[f64; 3]],
    f: &mut [[f64; 3]],
    arrays: &mut [Vec<f64>; 6],
    softening: f64,
) {
    for (i, (x, f)) in x.iter().zip(&*f).enumerate() {
        for k in 0..3 {
            (arrays[k][i], arrays[3 + k][i]) = (x[k], f[k]);
        }
    }
    // Safety: the machine has the instructions.
    unsafe { between(x.len(), arrays, softening) };
    for (i, f) in f.iter_mut().enumerate() {
        *f = std::array::from_fn(|k| arrays[3 + k][i]);
    }
}

#[target_feature(enable = "avx512f")]
fn between(n: usize, arrays: &mut [Vec<f64>; 6], softening: f64) {
    let [softening, one] = [softening, 1.0].map(|x| _mm512_set1_pd(x));
    for i in 0..n {
        let own: [__m512d; 3] = std::array::from_fn(|k| _mm512_set1_pd(arrays[k][i]));
        let mut sums = [_mm512_set1_pd(0.0); 3];
        for j in (i + 1..n).step_by(8) {
            let mask = if n - j < 8 { (1 << (n - j)) - 1 } else { 255 };
            // Safety: the mask has the numbers from `j` to `n`.
            let load = |of: &Vec<f64>| unsafe { _mm512_maskz_loadu_pd(mask, of.as_ptr().add(j)) };
            let d: [__m512d; 3] = std::array::from_fn(|k| _mm512_sub_pd(load(&arrays[k]), own[k]));
            let r2 = d.iter().fold(softening, |r2, &d| _mm512_fmadd_pd(d, d, r2));
            let cube = _mm512_mul_pd(r2, _mm512_sqrt_pd(r2));
            let c = _mm512_maskz_div_pd(mask, one, cube);
            for k in 0..3 {
                sums[k] = _mm512_fmadd_pd(c, d[k], sums[k]);
                let force = _mm512_fnmadd_pd(c, d[k], load(&arrays[3 + k]));
                // Safety: as above.
                unsafe { _mm512_mask_storeu_pd(arrays[3 + k].as_mut_ptr().add(j), mask, force) };
            }
        }
        for k in 0..3 {
            arrays[3 + k][i] += _mm512_reduce_add_pd(sums[k]);
        }
    }
}
