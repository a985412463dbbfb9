//! Code for vectors of each width gives the bits of single calls.

use super::super::*;
use super::numbers;
use crate::lanes::LANES;
use crate::lanes::dispatch::{Kernel, versions};

#[derive(Clone)]
struct Each<'a, F>(&'a [f64], F);

impl<F: Fn(f64, f64) -> f64> Kernel for Each<'_, F> {
    type Output = Vec<u64>;
    #[inline(always)]
    fn run(self) -> Vec<u64> {
        let mut out = vec![0.0; self.0.len()];
        for (x, out) in self.0.chunks_exact(LANES).zip(out.chunks_exact_mut(LANES)) {
            for lane in 0..LANES {
                out[lane] = self.1(x[lane], x[(lane + 1) % LANES]);
            }
        }
        // The bits of a NaN have no meaning.
        out.iter()
            .map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() })
            .collect()
    }
}

macro_rules! same {
    ($($f:ident($($x:ident),*) $expression:expr;)*) => {$({
        let numbers = numbers();
        let numbers = &numbers[..numbers.len() / LANES * LANES];
        let versions = versions(&Each(numbers, #[inline(always)] |$($x),*| $expression));
        for (i, chunk) in numbers.chunks_exact(LANES).enumerate() {
            for lane in 0..LANES {
                let one = std::hint::black_box(|$($x: f64),*| $expression)(chunk[lane], chunk[(lane + 1) % LANES]);
                let one = if one.is_nan() { u64::MAX } else { one.to_bits() };
                for version in &versions {
                    assert_eq!(version[i * LANES + lane], one, "{} {:e}", stringify!($f), chunk[lane]);
                }
            }
        }
    })*};
}

#[test]
fn vectors_of_any_width_give_the_same() {
    same! {
        sin(x, _y) sin_cos(x).0;
        cos(x, _y) sin_cos(x).1;
        tan(x, _y) tan(x);
        sin_cos_of_sum(x, y) sin_cos_of_sum(x, 0.5, y).0 + sin_cos_of_sum(x, 0.5, y).1;
        exp(x, _y) exp(x);
        exp2(x, _y) exp2(x);
        exp_m1(x, _y) exp_m1(x);
        ln(x, _y) ln(x);
        ln_1p(x, _y) ln_1p(x);
        log2(x, _y) log2(x);
        log10(x, _y) log10(x);
        sinh(x, _y) sinh(x);
        cosh(x, _y) cosh(x);
        tanh(x, _y) tanh(x);
        asinh(x, _y) asinh(x);
        acosh(x, _y) acosh(x);
        atanh(x, _y) atanh(x);
        asin(x, _y) asin(x);
        acos(x, _y) acos(x);
        atan(x, _y) atan(x);
        atan2(x, y) atan2(x, y);
        cbrt(x, _y) cbrt(x);
        hypot(x, y) hypot(x, y);
        powf(x, y) powf(x, y);
        power_log(x, y) power_log(x, y, 2);
    }
}
