//! Kernels compiled for the vectors of the machine, for the code written by hand.
//!
//! Unlike the library's kernels, these may contract a product and a sum into one operation: they
//! are limits, and need not have the same bits on other machines. A kernel's `FUSED` is true if it
//! may contract.

/// Work compiled for several widths of vectors.
pub(crate) trait Kernel {
    /// Does the work.
    fn run<const FUSED: bool>(self);
}

/// A kernel that may not contract, like the kernels of the library.
pub(crate) struct Plain<K>(pub(crate) K);

impl<K: Kernel> Kernel for Plain<K> {
    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        self.0.run::<false>();
    }
}

/// Runs a kernel with the widest vectors of this machine.
pub(crate) fn dispatch<K: Kernel>(kernel: K) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        let wide = has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("avx512bw");
        if wide && has!("fma") {
            // Safety: the machine has the instructions that the function is compiled for.
            #[allow(unsafe_code)]
            return unsafe { avx512(kernel) };
        }
        if has!("avx2") && has!("fma") {
            // Safety: as above.
            #[allow(unsafe_code)]
            return unsafe { avx2(kernel) };
        }
    }
    kernel.run::<false>();
}

/// Returns the name of the vectors that [`dispatch`] uses.
pub(crate) fn name() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        let wide = has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("avx512bw");
        if wide && has!("fma") {
            return "AVX-512";
        }
        if has!("avx2") && has!("fma") {
            return "AVX2";
        }
    }
    "the vectors of every machine of the target"
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]
fn avx512<K: Kernel>(kernel: K) {
    kernel.run::<true>();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn avx2<K: Kernel>(kernel: K) {
    kernel.run::<true>();
}

/// Returns `a b + c`, in one operation if `FUSED`.
#[inline(always)]
pub(crate) fn fma<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}
