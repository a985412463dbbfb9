//! Ensembles of systems with constraints: steps in lanes against the same ensemble with steps of
//! single paths.

use std::hint::black_box;

use sve_runtime::__private::VectorCoordinates;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{OneStepMethod, StepError, Variational};

use crate::{DOUBLE, DOUBLE_STEPS, Task, side};

/// A particle on the unit sphere in a heat bath.
#[derive(Clone, Copy)]
struct Sphere {
    g: f64,
    nu: f64,
    s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Sphere {
    fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    #[force]
    fn friction(&self, _q: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {
        v * -self.nu
    }

    #[gamma]
    fn bath(&self, q: Vector3<f64>) -> Vector3<f64> {
        q * self.s
    }

    #[constraint]
    fn sphere(&self, q: Vector3<f64>) -> f64 {
        0.5 * (q.norm_squared() - 1.0)
    }
}

/// A particle on the unit sphere that is turned about an axis at random.
#[derive(Clone, Copy)]
struct Turned {
    g: f64,
    s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Turned {
    fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    #[h1]
    fn turn(&self, q: Vector3<f64>, p: Vector3<f64>) -> f64 {
        self.s * q.cross(&p).dot(&Vector3::new(1.0, -2.0, 2.0))
    }

    #[constraint]
    fn sphere(&self, q: Vector3<f64>) -> f64 {
        0.5 * (q.norm_squared() - 1.0)
    }
}

/// A double pendulum of two rods in Cartesian coordinates, in a field that is not homogeneous.
#[derive(Clone, Copy)]
struct Rods {
    m: [f64; 2],
    l: [f64; 2],
    g: f64,
    s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Rods {
    fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 {
        let [m1, m2] = self.m;
        0.5 * m1 * (v[0].powi(2) + v[1].powi(2)) + 0.5 * m2 * (v[2].powi(2) + v[3].powi(2))
            - self.g * (m1 * q[1] + m2 * q[3])
    }

    #[gamma]
    fn pulls(&self, q: [f64; 4]) -> [f64; 2] {
        [self.s * q[2] * q[3], self.s * q[1] * q[0]]
    }

    #[constraint]
    fn rods(&self, q: [f64; 4]) -> [f64; 2] {
        let [x, y] = [q[2] - q[0], q[3] - q[1]];
        [
            0.5 * (q[0].powi(2) + q[1].powi(2) - self.l[0].powi(2)),
            0.5 * (x.powi(2) + y.powi(2) - self.l[1].powi(2)),
        ]
    }
}

/// A method whose ensembles step one path at a time.
struct OneByOne<I>(I);

impl<I: OneStepMethod> OneStepMethod for OneByOne<I> {
    type System = I::System;
    type Increments = I::Increments;
    type Prepared = I::Prepared;

    fn system(&self) -> &Self::System {
        self.0.system()
    }

    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError> {
        self.0.prepare(h)
    }

    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut sve_runtime::system::StateOf<Self::System>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError> {
        self.0.step_prepared(prepared, state, h, dw)
    }
}

/// Returns the mean of a component of p at the end of the paths.
fn run<I, Q, const N: usize, const M: usize>(method: &I, start: State<Q>) -> f64
where
    I: OneStepMethod<Increments = [f64; M], Prepared: Sync> + Sync,
    I::System: System<Dims = Dims<N, M, Q>> + Sync,
    Q: VectorCoordinates<N> + Sync,
{
    let summary = Ensemble::new(method)
        .paths(DOUBLE as u64)
        .seed(1)
        .steps(black_box(0.01), DOUBLE_STEPS as u64)
        .start(start)
        .observe("p", |_, state: &State<Q>| Q::components(&state.p)[0])
        .run();
    let summary = summary.expect("a run");
    assert_eq!(summary.failed(), 0, "no path fails");
    let means = summary.statistics()[0].mean();
    means[means.len() - 1]
}

fn task<S, R, Q, const N: usize, const M: usize>(
    name: &'static str,
    (system, rule): (S, R),
    start: State<Q>,
) -> Task<'static>
where
    S: Variational<R, Prepared: Sync, Memory: Sync>
        + System<Dims = Dims<N, M, Q>>
        + Copy
        + Sync
        + 'static,
    R: Copy + Sync + 'static,
    Q: VectorCoordinates<N> + Sync + 'static,
{
    let start = Integrator::new(system, rule).consistent(start);
    let start = start.expect("a consistent start");
    let single = OneByOne(Integrator::new(system, rule));
    let lanes = Integrator::new(system, rule);
    Task {
        name,
        count: DOUBLE * DOUBLE_STEPS,
        sides: vec![
            side("sve, scalar steps", move || run(&single, start)),
            side("sve", move || run(&lanes, start)).wanted(0.5),
        ],
    }
}

pub(crate) fn tasks() -> Vec<Task<'static>> {
    let sphere = Sphere {
        g: 9.8,
        nu: 0.5,
        s: 1.0,
    };
    let turned = Turned { g: 9.8, s: 0.1 };
    let rods = Rods {
        m: [1.0, 0.5],
        l: [1.0, 0.7],
        g: 9.8,
        s: 0.3,
    };
    let at = State::new(Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.3, 0.5, 0.2));
    let hung = State::new([0.8, -0.6, 1.2, -1.1], [0.1, 0.2, 0.3, 0.2]);
    vec![
        task("sphere initial_point", (sphere, InitialPoint), at),
        task("sphere endpoint", (sphere, Endpoint), at),
        task("sphere midpoint", (sphere, Midpoint), at),
        task("sphere verlet", (sphere, StormerVerlet), at),
        task("turned initial_point", (turned, InitialPoint), at),
        task("turned endpoint", (turned, Endpoint), at),
        task("turned midpoint", (turned, Midpoint), at),
        task("turned verlet", (turned, StormerVerlet), at),
        task("rods initial_point", (rods, InitialPoint), hung),
        task("rods endpoint", (rods, Endpoint), hung),
        task("rods midpoint", (rods, Midpoint), hung),
        task("rods verlet", (rods, StormerVerlet), hung),
    ]
}
