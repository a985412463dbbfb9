//! Run-time dispatch: code compiled for several widths of vectors, of which the machine's is chosen.
//!
//! Input: a kernel, whose whole body is inlined. Output: its result, with the same bits for all versions: wider vectors
//! change no rounding, since Rust never contracts a multiplication and an addition into a fused operation.

/// A computation that is compiled for several widths of vectors. `run` and everything it calls in its loops have to be `#[inline(always)]`.
pub(crate) trait Kernel {
    /// The result.
    type Output;
    /// Computes the result.
    fn run(self) -> Self::Output;
}

/// Runs a kernel with the widest vectors of this machine.
#[inline]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        if has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("avx512bw") {
            // Safety: the machine has the instructions that the function is compiled for.
            #[allow(unsafe_code)]
            return unsafe { avx512(kernel) };
        }
        if has!("avx2") {
            // Safety: as above.
            #[allow(unsafe_code)]
            return unsafe { avx2(kernel) };
        }
    }
    // Other machines use the vectors that every machine of the target has: two numbers on x86-64 and AArch64.
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2")]
fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

/// Returns the results of all versions that this machine can run, for tests.
#[cfg(test)]
#[allow(unsafe_code)]
pub(crate) fn versions<K: Kernel + Clone>(kernel: &K) -> Vec<K::Output> {
    let mut results = vec![kernel.clone().run(), dispatch(kernel.clone())];
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // Safety: the feature was detected.
        results.push(unsafe { avx2(kernel.clone()) });
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
