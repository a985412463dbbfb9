//! Gradients along single paths, backwards, beside the steps of these paths.

use std::hint::black_box;

use sve_runtime::prelude::*;

use crate::{ROUNDS, median, seconds};

/// Numbers of steps of a path. The states of the longest one do not fit into the memory that they
/// may take by default, so that its steps are made three times.
const STEPS: [u64; 3] = [2_000, 200_000, 2_000_000];

struct Pendulum {
    g: f64,
}

#[variational(midpoint, stormer_verlet, gauss(2), gauss(4), gauss(8))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// Prints the time of a gradient as a multiple of that of the steps, for each number of steps.
macro_rules! along {
    ($filter:expr, $name:literal, $rule:expr, $h:expr) => {
        if $filter.is_none_or(|word| concat!("along a path, ", $name).contains(word)) {
            let pendulum = Integrator::new(Pendulum { g: 1.0 }, $rule);
            let path = || pendulum.trajectory(State::new([1.0], [0.3]), $h, NoNoise);
            print!("{:28}", concat!("along a path, ", $name));
            for steps in STEPS {
                let (mut plain, mut gradient) = (Vec::new(), Vec::new());
                for _ in 0..ROUNDS {
                    plain.push(seconds(|| {
                        black_box(path().advance(steps).expect("steps").q[0]);
                    }));
                    gradient.push(seconds(|| {
                        let loss = path().gradient(steps, |k, s| (k == steps).then(|| s.q[0]));
                        black_box(loss.expect("a gradient").loss());
                    }));
                }
                print!(" | {steps:6}: {:5.2}", median(gradient) / median(plain));
            }
            println!();
        }
    };
}

pub(crate) fn run(filter: Option<&str>) {
    along!(filter, "midpoint", Midpoint, 0.05);
    along!(filter, "stormer_verlet", StormerVerlet, 0.05);
    along!(filter, "gauss(2)", Gauss::<2>, 0.05);
    along!(filter, "gauss(4)", Gauss::<4>, 0.1);
    along!(filter, "gauss(8)", Gauss::<8>, 0.4);
}
