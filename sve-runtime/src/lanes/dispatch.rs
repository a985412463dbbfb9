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
//! optimised, and would compile the same loops three times. In other builds a check can choose the
//! version, with [`use_vectors`].

use std::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// A computation that is compiled for several widths of vectors. `run` and everything it calls in
/// its loops have to be `#[inline(always)]`.
pub(crate) trait Kernel {
    /// The result.
    type Output;
    /// Computes the result.
    fn run(self) -> Self::Output;
}

/// True if kernels are compiled for more than the vectors that every machine of the target has.
const FOR_THIS_MACHINE: bool = cfg!(not(debug_assertions));

/// The vectors for which kernels are compiled, from the narrowest to the widest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Vectors {
    /// Those of every machine of the target: two numbers on x86-64 and `AArch64`.
    Base = 1,
    /// Four numbers.
    Avx2,
    /// Eight numbers.
    Avx512,
}

/// The number of the vectors in use; zero before the first kernel. The machine has these vectors.
static IN_USE: AtomicU8 = AtomicU8::new(0);

/// Runs a kernel with the widest vectors of this machine.
#[inline]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if FOR_THIS_MACHINE {
        match in_use() {
            // Safety: the machine has the instructions that the function is compiled for.
            #[allow(unsafe_code)]
            Vectors::Avx512 => return unsafe { avx512(kernel) },
            // Safety: as above.
            #[allow(unsafe_code)]
            Vectors::Avx2 => return unsafe { avx2(kernel) },
            Vectors::Base => {}
        }
    }
    base(kernel)
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn in_use() -> Vectors {
    match IN_USE.load(Relaxed) {
        0 => {
            // vectors that were chosen in the meantime stay
            let _ = IN_USE.compare_exchange(0, widest() as u8, Relaxed, Relaxed);
            in_use()
        }
        1 => Vectors::Base,
        2 => Vectors::Avx2,
        _ => Vectors::Avx512,
    }
}

/// Makes the kernels of all threads run with these vectors from now on. Returns false, and changes
/// nothing, if the machine lacks them or this build has no kernels for them.
pub fn use_vectors(vectors: Vectors) -> bool {
    let has_vectors = vectors <= widest() && (FOR_THIS_MACHINE || vectors == Vectors::Base);
    if has_vectors {
        IN_USE.store(vectors as u8, Relaxed);
    }
    has_vectors
}

/// Returns the widest vectors of this machine.
#[cold]
fn widest() -> Vectors {
    if has_avx512() {
        Vectors::Avx512
    } else if has_avx2() {
        Vectors::Avx2
    } else {
        Vectors::Base
    }
}

/// Returns whether the machine has the vectors of AVX-512.
#[inline]
pub(crate) fn has_avx512() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("avx512bw") && has_avx2()
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
}

#[inline]
fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        has!("avx2") && has!("fma")
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Is not inlined, as the versions below cannot be: each call would be a copy of the loops.
#[inline(never)]
fn base<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
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
    if FOR_THIS_MACHINE {
        match in_use() {
            // Safety: the machine has the instructions that the function is compiled for.
            #[allow(unsafe_code)]
            Vectors::Avx512 => return unsafe { avx512(ForVectors::<K, true>(kernel)) },
            // Safety: as above.
            #[allow(unsafe_code)]
            Vectors::Avx2 => return unsafe { avx2(ForVectors::<K, false>(kernel)) },
            Vectors::Base => {}
        }
    }
    base(ForVectors::<K, false>(kernel))
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
