//! Bodies that all attract one another, in the plane and in space: 48 coordinates.

use sve_runtime::prelude::*;

/// In the plane.
struct Plane {
    m: f64,
    r: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2))]
impl Plane {
    fn lagrangian(&self, q: [f64; 48], v: [f64; 48]) -> f64 {
        let mut l = 0.0;
        for i in 0..24 {
            let (x, y) = (q[2 * i], q[2 * i + 1]);
            l += 0.5 * self.m * (v[2 * i].powi(2) + v[2 * i + 1].powi(2));
            l -= self.potential(x.powi(2) + y.powi(2));
            for j in 0..i {
                l -= self.potential((x - q[2 * j]).powi(2) + (y - q[2 * j + 1]).powi(2));
            }
        }
        l
    }

    fn potential(&self, squared: f64) -> f64 {
        -self.m * self.m / (squared + self.r * self.r).sqrt()
    }
}

/// In space, with a mass for each body.
struct Space {
    m: [f64; 16],
}

#[variational(midpoint, stormer_verlet)]
impl Space {
    fn lagrangian(&self, q: [[f64; 3]; 16], v: [[f64; 3]; 16]) -> f64 {
        let mut l = 0.0;
        for i in 0..16 {
            l += 0.5 * self.m[i] * (v[i][0].powi(2) + v[i][1].powi(2) + v[i][2].powi(2));
            for j in 0..i {
                let (x, y, z) = (q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]);
                l += self.m[i] * self.m[j] / (x * x + y * y + z * z).sqrt();
            }
        }
        l
    }
}

pub(crate) fn check() {
    let place = |i: usize| (1.0 + i as f64) * (2.4 * i as f64).sin();
    let state = || {
        let q = std::array::from_fn(place);
        State::new(q, std::array::from_fn(|i| 0.1 * (i as f64).cos()))
    };
    let plane = || Plane { m: 1.0, r: 0.5 };
    super::check(plane(), InitialPoint, state());
    super::check(plane(), Endpoint, state());
    super::check(plane(), Midpoint, state());
    super::check(plane(), StormerVerlet, state());
    super::check(plane(), Gauss::<2>, state());
    let state = State::new(
        std::array::from_fn(|i| [place(i), i as f64, (0.7 * i as f64).cos()]),
        std::array::from_fn(|i| [0.1 * (i as f64).cos(), 0.0, 0.1]),
    );
    let space = || Space {
        m: std::array::from_fn(|i| 1.0 + 0.1 * i as f64),
    };
    for integrated in [
        Integrator::new(space(), Midpoint).tangent(&state, 0.01, &[]),
        Integrator::new(space(), StormerVerlet).tangent(&state, 0.01, &[]),
    ] {
        let defect = integrated.map(|tangent| tangent.symplectic_defect());
        assert!(
            matches!(defect, Ok(defect) if defect < super::ROUNDING),
            "{defect:?}"
        );
    }
}
