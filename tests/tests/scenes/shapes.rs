//! Sums in formulas in many shapes: impulses against differences of the user's function, and
//! energies against its values.

use sve_runtime::prelude::*;

use crate::common::spread;

/// Defines a system, whose `check` compares impulses and energy for small numbers of sites.
macro_rules! shape {
    ($name:ident, |$this:ident, $t:ident, $q:ident, $v:ident, $l:ident| { $($body:tt)* }) => {
        #[test]
        fn $name() {
            struct System {
                start: Vec<usize>,
                list: Vec<usize>,
            }
            #[variational(endpoint)]
            impl System {
                fn lagrangian(&$this, $t: f64, $q: &[f64], $v: &[f64]) -> f64 {
                    let mut $l = $v.iter().map(|v| 0.5 * v * v).sum::<f64>();
                    $($body)*
                    $l
                }
            }
            for n in [1, 2, 3, 7] {
                // two neighbours for each site, with repetitions
                let start = (0..=n).map(|i| 2 * i).collect();
                let list = (0..2 * n).map(|i| (5 * i + 1) % n).collect();
                let system = System { start, list };
                assert_eq!([system.start.len(), system.list.len()], [n + 1, 2 * n]);
                let (q, h) = (spread(n, 11), 0.1);
                let zero = vec![0.0; n];
                let mut state = State::at(0.4, q.clone(), zero.clone());
                let energy = system.hamiltonian(&state).expect("an energy");
                let expected = -system.lagrangian(0.4, &q, &zero);
                assert!((energy - expected).abs() <= 1e-13 * (1.0 + expected.abs()));
                Integrator::new(&system, Endpoint).step(&mut state, h, &[]).expect("a step");
                for i in 0..n {
                    let at = |by: f64| {
                        let mut moved = q.clone();
                        moved[i] += by;
                        system.lagrangian(0.4 + h, &moved, &zero)
                    };
                    let difference = |step: f64| (at(step) - at(-step)) / (2.0 * step);
                    let slope = (4.0 * difference(1e-3) - difference(2e-3)) / 3.0;
                    let off = (state.p[i] - h * slope).abs();
                    assert!(off < 1e-9 * (1.0 + slope.abs()), "{n} {i}: {off}");
                }
            }
        }
    };
}

shape!(products_of_sums, |self, t, q, v, l| {
    for i in 0..q.len() {
        let mut a = 0.0;
        let mut b = 0.0;
        for j in 0..q.len() {
            a += (q[i] * q[j]).sin();
            b += (q[j] - t).cos();
        }
        l -= 0.4 * a * b * q[i] + a;
    }
});

shape!(sums_under_conditions, |self, t, q, v, l| {
    for i in 0..q.len() {
        let mut a = 0.0;
        for j in 0..q.len() {
            let d = q[i] - q[j];
            if j != i && d * d < 0.8 {
                a += (1.0 - d * d / 0.8).powi(6) * t;
            }
        }
        if q[i] > 0.1 {
            l -= (1.0 + a).sqrt() * q[i];
        } else {
            l += a * a;
        }
    }
});

shape!(sums_over_lists, |self, t, q, v, l| {
    for i in 0..q.len() {
        let mut a = 0.1 * t;
        for k in self.start[i]..self.start[i + 1] {
            a += (q[self.list[k]] - q[i]).powi(2);
        }
        l -= (1.0 + a).ln();
    }
});

shape!(sums_of_four_levels, |self, t, q, v, l| {
    let mut top = 0.0;
    for i in 0..q.len() {
        let mut a = 0.0;
        for j in 0..q.len() {
            let mut b = 0.0;
            for k in 0..q.len() {
                let mut c = 0.0;
                for m in 0..=k {
                    c += (q[m] + 0.3 * q[j] - 0.1 * t).sin();
                }
                b += c * c * (q[k] * q[i]).cos() + c;
            }
            a += 0.001 * b.powi(2) + 0.01 * b * q[j];
        }
        l -= 0.4 * (1.0 + a * a).sqrt();
        top += a * (i as f64);
    }
    l -= (1.0 + top * top).sqrt();
});

shape!(outer_sums_in_loops, |self, t, q, v, l| {
    let s = q.iter().map(|x| x.cos()).sum::<f64>();
    for i in 0..q.len() {
        l -= 0.1 * s * s * q[i] + (10.0 + s * q[i] * q[i] + t).ln();
    }
});

shape!(
    sums_under_conditions_outside_of_loops,
    |self, t, q, v, l| {
        let n = q.len();
        if n > 1 {
            let s = q.iter().map(|x| (x - t).cos()).sum::<f64>();
            l -= s * s * q[0];
            if n > 2 {
                let u = q.iter().map(|x| x * x).sum::<f64>();
                l += (1.0 + u * s * s).sqrt() * q[n - 1];
            }
        }
    }
);

shape!(conditional_numbers_in_formulas, |self, t, q, v, l| {
    for i in 0..q.len() {
        let mut a = 0.1 * t;
        if i > 0 {
            a += q[i - 1] * q[i];
        }
        if i + 1 < q.len() {
            a += q[i + 1].sin() * q[i];
        }
        l -= (1.0 + a * a).sqrt();
    }
});
