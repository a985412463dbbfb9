//! Run-time dispatch: compiles code for several widths of vectors and chooses the widest one that
//! the machine has.
//!
//! Input: a kernel, whose whole body is inlined. Output: its result, with the same bits for all
//! versions: wider vectors change no rounding, since Rust never contracts a multiplication and an
//! addition into a fused operation. A fused operation that the source requests (`mul_add`) is exact
//! everywhere; it is an instruction in the versions for x86-64, and elsewhere can be a slow call of
//! the library.
//!
//! Builds with debug assertions have the version for every machine alone: as a rule they are not
//! optimised, and would compile the same loops three times.

/// A computation that is compiled for several widths of vectors. `run` and everything it calls in
/// its loops have to be `#[inline(always)]`.
pub(crate) trait Kernel {
    /// The result.
    type Output;
    /// Computes the result.
    fn run(self) -> Self::Output;
}

/// Whether kernels are compiled for more than the vectors that every machine of the target has.
const FOR_THIS_MACHINE: bool = cfg!(not(debug_assertions));

/// Runs a kernel with the widest vectors of this machine.
#[inline]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if FOR_THIS_MACHINE && has_avx512() {
            // Safety: the machine has the instructions that the function is compiled for.
            #[allow(unsafe_code)]
            return unsafe { avx512(kernel) };
        }
        if FOR_THIS_MACHINE && has_avx2() {
            // Safety: as above.
            #[allow(unsafe_code)]
            return unsafe { avx2(kernel) };
        }
    }
    // Other machines use the vectors that every machine of the target has: two numbers on x86-64
    // and AArch64.
    kernel.run()
}

/// Returns whether kernels run with the vectors of AVX-512.
#[inline]
pub(crate) fn has_avx512() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("avx512bw") && has!("fma")
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn has_avx2() -> bool {
    use std::arch::is_x86_feature_detected as has;
    has!("avx2") && has!("fma")
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]
fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

/// A computation that calls instructions by name, so that it has to know the vectors for which it
/// is compiled. Otherwise like [`Kernel`].
pub(crate) trait VectorKernel {
    /// The result.
    type Output;
    /// Computes the result. `AVX512` is true if the machine has the vectors of AVX-512.
    fn run<const AVX512: bool>(self) -> Self::Output;
}

/// Runs a kernel with the widest vectors of this machine.
#[inline]
pub(crate) fn dispatch_vectors<K: VectorKernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if FOR_THIS_MACHINE && has_avx512() {
            // Safety: the machine has the instructions that the function is compiled for.
            #[allow(unsafe_code)]
            return unsafe { avx512(ForVectors::<K, true>(kernel)) };
        }
        if FOR_THIS_MACHINE && has_avx2() {
            // Safety: as above.
            #[allow(unsafe_code)]
            return unsafe { avx2(ForVectors::<K, false>(kernel)) };
        }
    }
    kernel.run::<false>()
}

/// A kernel compiled with or without the vectors of AVX-512.
#[derive(Clone)]
struct ForVectors<K, const AVX512: bool>(K);

impl<K: VectorKernel, const AVX512: bool> Kernel for ForVectors<K, AVX512> {
    type Output = K::Output;

    #[inline(always)]
    fn run(self) -> K::Output {
        self.0.run::<AVX512>()
    }
}

/// Returns the results of all versions that this machine can run, for tests.
#[cfg(all(test, feature = "ensemble"))]
pub(crate) fn vector_versions<K: VectorKernel + Clone>(kernel: &K) -> Vec<K::Output> {
    let mut results = versions(&ForVectors::<K, false>(kernel.clone()));
    if has_avx512() {
        results.extend(versions(&ForVectors::<K, true>(kernel.clone())));
    }
    results
}

/// Returns the results of all versions that this machine can run, for tests.
#[cfg(test)]
#[allow(unsafe_code)]
pub(crate) fn versions<K: Kernel + Clone>(kernel: &K) -> Vec<K::Output> {
    let mut results = vec![kernel.clone().run(), dispatch(kernel.clone())];
    #[cfg(target_arch = "x86_64")]
    {
        if has_avx2() {
            // Safety: the features were detected.
            results.push(unsafe { avx2(kernel.clone()) });
        }
        if has_avx512() {
            // Safety: as above.
            results.push(unsafe { avx512(kernel.clone()) });
        }
    }
    results
}

#[cfg(test)]
mod tests {
    use super::{Kernel, versions};

    #[derive(Clone)]
    struct Sum<'a>(&'a [f64]);

    impl Kernel for Sum<'_> {
        type Output = f64;
        #[inline(always)]
        fn run(self) -> f64 {
            self.0.iter().sum()
        }
    }

    #[test]
    fn every_version_gives_the_same() {
        let numbers: Vec<f64> = (0..1000).map(|i| f64::from(i).sin()).collect();
        let plain = Sum(&numbers).run();
        for version in versions(&Sum(&numbers)) {
            assert_eq!(version, plain);
        }
    }
}
