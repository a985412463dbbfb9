//! A step and a trajectory do not allocate: counted, for explicit, linear and Newton steps.

use allocation_counter::measure;
use sve_models::oracle::{cases, double_pendulum, kubo, mixed, oscillator, pendulum};
use sve_models::random::Random;
use sve_runtime::Variational;
use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

fn allocations(run: impl FnOnce()) -> u64 {
    measure(run).count_total
}

/// The counter sees an allocation.
#[test]
fn are_counted() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1.0]))), 1);
    assert_eq!(allocations(|| ()), 0);
}

#[test]
fn no_step_allocates() {
    let mut random = Random::new(20);
    for case in cases() {
        let start = case.model().point(&mut random);
        let dw = vec![0.1; case.dimensions().1];
        let mut count = u64::MAX;
        case.watched(&start, 0.01, &dw, 10, &mut |steps| {
            count = allocations(steps);
        });
        assert_eq!(count, 0, "{}", case.plan());
    }
}

fn trajectory<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    kind: BlockKind,
    start: State<[f64; N]>,
) where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    assert_eq!(integrator.plan().kind(), kind);
    let recorded = Recorded::record(Wiener::new(1), 0.01, M, 1000).unwrap();
    let mut sum = 0.0;
    let count = allocations(|| {
        for state in integrator.trajectory(start, 0.01, &recorded) {
            sum += state.unwrap().q[0];
        }
        for state in integrator.trajectory(start, 0.01, NoNoise).take(1000) {
            sum += state.unwrap().q[0];
        }
    });
    assert!(sum.is_finite());
    assert_eq!(count, 0, "{}", integrator.plan());

    // a Wiener path keeps its increments in place
    let count = allocations(|| {
        for state in integrator
            .trajectory(start, 0.01, Wiener::new(1))
            .take(1000)
        {
            sum += state.unwrap().q[0];
        }
    });
    assert_eq!(count, 0, "{}", integrator.plan());
}

/// Steps that are solved by continuation do not allocate either. Far beyond useful step sizes there
/// are many of them.
#[test]
fn in_a_step_that_is_followed() {
    let system = double_pendulum();
    let integrator = Integrator::new(&system, Midpoint);
    let mut random = Random::new(3);
    let (mut solved, mut lost) = (0, 0);
    for _ in 0..300 {
        let mut state = State::new(random.array(-3.0, 3.0), random.array(-3.0, 3.0));
        let mut result = Ok(());
        let count = allocations(|| result = integrator.step(&mut state, 0.5, &[0.0; 2]));
        if result.is_ok() {
            assert_eq!(count, 0);
            solved += 1;
        } else {
            lost += 1;
        }
    }
    // some of these steps fail
    assert!(solved > 100 && lost > 10, "{solved} {lost}");
}

#[test]
fn in_a_trajectory() {
    let start = State::new([1.0], [0.5]);
    trajectory(
        &Integrator::new(oscillator(), Endpoint),
        BlockKind::Explicit,
        start,
    );
    trajectory(&Integrator::new(kubo(), Midpoint), BlockKind::Linear, start);
    trajectory(
        &Integrator::new(pendulum(), Midpoint),
        BlockKind::Newton,
        start,
    );
    let start = State::new([0.2, 0.1], [0.1, 0.2]);
    trajectory(
        &Integrator::new(mixed(), Midpoint),
        BlockKind::Newton,
        start,
    );
}

struct Wells {
    sigma: f64,
}

#[variational(gauss(3), gauss(4))]
impl Wells {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.25 * (q * q - 1.0).powi(2)
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// Newton's method, fixed-point iteration, and the change from one to the other.
#[test]
fn no_step_of_many_stages_allocates() {
    let wells = &Wells { sigma: 0.3 };
    for h in [0.01, 2.0] {
        let count = allocations(|| {
            let mut ends = [State::new([1.2], [0.3]); 2];
            Integrator::new(wells, Gauss::<3>)
                .step(&mut ends[0], h, &[0.1])
                .unwrap();
            Integrator::new(wells, Gauss::<4>)
                .step(&mut ends[1], h, &[0.1])
                .unwrap();
        });
        assert_eq!(count, 0, "h = {h}");
    }
}
