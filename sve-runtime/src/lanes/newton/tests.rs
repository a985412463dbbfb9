//! Iterations in lanes against the scalar method.

use super::{
    Acceptance, ContractingLanes, Evaluation, LANES, Lane, Newton, NewtonLanes, SingleLanes,
};
use crate::lanes::solve::{Solved, solved};

/// Iterates all lanes until they have ended.
fn iterate<const K: usize, A: Acceptance<K>>(
    mut iterations: NewtonLanes<K, A>,
    at: impl Fn(usize, [f64; K]) -> Evaluation<K, A::Jacobian>,
) -> NewtonLanes<K, A> {
    while iterations.next_iteration() {
        for lane in 0..LANES {
            let point = iterations.point(lane);
            iterations.update(lane, &at(lane, point));
        }
    }
    iterations
}

/// The equation `x³ + x = a`.
fn cube(x: f64, a: f64) -> Evaluation<1> {
    Evaluation {
        residual: [x * x * x + x - a],
        magnitude: [(x * x * x).abs() + x.abs() + a.abs()],
        jacobian: [[3.0 * x * x + 1.0]],
        curvature: 6.0 * x,
    }
}

/// The intersection of the circle of radius √2 and the diagonal.
fn circle([x, y]: [f64; 2]) -> Evaluation<2> {
    Evaluation {
        residual: [x * x + y * y - 2.0, x - y],
        magnitude: [x * x + y * y + 2.0, x.abs() + y.abs()],
        jacobian: [[2.0 * x, 2.0 * y], [1.0, -1.0]],
        curvature: f64::NAN,
    }
}

/// Solves `x³ + x = a` from `x = a` with Chebyshev's update in all lanes.
fn cubic(a: &Lane, newton: &Newton) -> NewtonLanes<1> {
    let mut iterations = NewtonLanes::<1>::new(newton);
    for lane in 0..LANES {
        iterations.start(lane, [a[lane]], [0.0]);
    }
    iterate(iterations, |lane, [x]| cube(x, a[lane]))
}

fn values() -> Lane {
    core::array::from_fn(|lane| 0.07 * lane as f64 - 1.1)
}

#[test]
fn roots_are_those_of_the_scalar_method() {
    let (a, newton) = (values(), Newton::default());
    let iterations = cubic(&a, &newton);
    for lane in 0..LANES {
        assert!(iterations.has_converged(lane));
        let x = iterations.point(lane)[0];
        let [expected] = newton.solve([a[lane]], |&[x]| cube(x, a[lane])).unwrap();
        assert!(
            (x - expected).abs() <= 2.0 * f64::EPSILON * x.abs(),
            "{x} {expected}"
        );
    }
}

#[test]
fn converged_lanes_do_not_change() {
    let newton = Newton::default();
    let together = cubic(&values(), &newton);
    for lane in 0..LANES {
        let alone = cubic(&[values()[lane]; LANES], &newton);
        assert_eq!(alone.point(0), together.point(lane));
    }
}

#[test]
fn a_lane_that_does_not_converge_fails() {
    let newton = Newton::default();
    let mut a = values();
    a[3] = f64::NAN;
    a[5] = f64::INFINITY;
    let iterations = cubic(&a, &newton);
    for lane in 0..LANES {
        assert_eq!(
            iterations.has_converged(lane),
            ![3, 5].contains(&lane),
            "{lane}"
        );
    }
    // The scalar method's limit of iterations holds for lanes too.
    let few = Newton {
        max_iterations: 1,
        ..newton
    };
    let iterations = cubic(&[4.0; LANES], &few);
    assert!((0..LANES).all(|lane| !iterations.has_converged(lane)));
}

#[test]
fn a_lane_whose_root_is_not_accepted_fails() {
    let mut iterations = cubic(&values(), &Newton::default());
    for lane in 0..LANES {
        iterations.accept(lane, lane % 3 != 0);
    }
    assert!((0..LANES).all(|lane| iterations.has_converged(lane) == (lane % 3 != 0)));
    // An accepted root does not revive a lane that did not converge.
    let mut a = values();
    a[3] = f64::NAN;
    let mut iterations = cubic(&a, &Newton::default());
    iterations.accept(3, true);
    assert!(!iterations.has_converged(3));
}

#[test]
fn a_lane_with_a_singular_jacobian_fails() {
    let iterations = NewtonLanes::<1>::new(&Newton::default());
    let iterations = iterate(iterations, |_, _| Evaluation {
        residual: [1.0],
        magnitude: [1.0],
        jacobian: [[0.0]],
        curvature: 1.0,
    });
    assert!(
        (0..LANES)
            .all(|lane| !iterations.has_converged(lane) || !iterations.point(lane)[0].is_finite())
    );
}

#[test]
fn several_unknowns_converge() {
    let mut iterations = NewtonLanes::<2>::new(&Newton::default());
    for lane in 0..LANES {
        iterations.start(lane, [1.0 + 0.01 * lane as f64, 1.1], [0.0; 2]);
    }
    let iterations = iterate(iterations, |_, point| circle(point));
    for lane in 0..LANES {
        assert!(iterations.has_converged(lane));
        for x in iterations.point(lane) {
            assert!((x - 1.0).abs() <= 4.0 * f64::EPSILON, "{x}");
        }
    }
}

/// Intersects the circle of radius √2 with the diagonal, from points at several distances of the
/// intersection, with a sign of the determinant.
fn intersection(sign: f64) -> ContractingLanes<2> {
    let mut iterations = ContractingLanes::<2>::new(&Newton::default());
    for lane in 0..LANES {
        iterations.start(lane, [1.0 + 0.006 * lane as f64, 1.0], sign);
    }
    iterate(iterations, |_, point| {
        let at = circle(point);
        Evaluation {
            jacobian: solved(&at.jacobian, &at.residual),
            residual: at.residual,
            magnitude: at.magnitude,
            curvature: at.curvature,
        }
    })
}

#[test]
fn the_root_of_a_contracting_iteration_is_accepted() {
    // the determinant is −2 (x + y)
    let iterations = intersection(-1.0);
    assert!((0..5).all(|lane| iterations.has_converged(lane)));
    assert!((0..5).all(|lane| (iterations.point(lane)[0] - 1.0).abs() < 1e-15));
    // From afar the first update leaves more than 1/64 of the first residual.
    assert!((20..LANES).all(|lane| !iterations.has_converged(lane)));
    let unknown = intersection(f64::NAN);
    assert!((0..5).all(|lane| unknown.has_converged(lane)));
}

#[test]
fn a_determinant_of_the_other_sign_fails_a_lane() {
    let iterations = intersection(1.0);
    assert!((0..LANES).all(|lane| !iterations.has_converged(lane)));
}

/// Solves `x² = 4` from several points. Some are out of reach by Kantorovich's condition, |f f″| ≤
/// ½ f′², or leave more than 1/64 of the residual.
#[test]
fn a_single_unknown_contracts_by_its_second_derivative() {
    let mut iterations = ContractingLanes::<1>::new(&Newton::default());
    let guess = |lane: usize| 0.25 + 0.15 * lane as f64;
    for lane in 0..LANES {
        iterations.start(lane, [guess(lane)], 1.0);
    }
    let iterations = iterate(iterations, |_, [x]| Evaluation {
        residual: [x * x - 4.0],
        magnitude: [x * x + 4.0],
        jacobian: Solved {
            by: [f64::NAN],
            determinant: 2.0 * x,
        },
        curvature: 2.0,
    });
    for lane in 0..LANES {
        let x = guess(lane);
        let (residual, slope) = (x * x - 4.0, 2.0 * x);
        let newton = residual / slope;
        let next = x - newton * (1.0 + newton / slope);
        let contracts = (next * next - 4.0).abs() <= residual.abs() / 64.0;
        let is_near = residual.abs() <= x * x && contracts;
        assert_eq!(iterations.has_converged(lane), is_near, "{x}");
        assert!(!is_near || (iterations.point(lane)[0] - 2.0).abs() < 1e-15);
    }
}

/// Solves `x³ + x = a` from `x = a` in all lanes. Returns the iterations and the number of
/// evaluations.
fn single_cubic(a: &Lane, newton: &Newton) -> (SingleLanes, u32) {
    let mut iterations = SingleLanes::new(newton);
    for lane in 0..LANES {
        iterations.start(lane, [a[lane]], [0.0], &cube(a[lane], a[lane]));
    }
    let mut evaluations = 1;
    while iterations.next_iteration() {
        for lane in 0..LANES {
            let [x] = iterations.point(lane);
            iterations.update(lane, &cube(x, a[lane]));
        }
        evaluations += 1;
    }
    (iterations, evaluations)
}

#[test]
fn single_roots_are_those_of_the_scalar_method_in_any_units() {
    let newton = Newton::default();
    for scale in [1.0, 0.1, 1e-3, 1e-9, 1e-60, 1e-120, 1e-300, 0.0] {
        let a = values().map(|a| scale * a);
        let (iterations, evaluations) = single_cubic(&a, &newton);
        assert!(scale > 0.1 || evaluations <= 3, "{scale:e}: {evaluations}");
        for lane in 0..LANES {
            let [expected] = newton.solve([a[lane]], |&[x]| cube(x, a[lane])).unwrap();
            let x = iterations.point(lane)[0];
            assert!(iterations.has_converged(lane), "{scale:e} {x:e}");
            assert!(
                (x - expected).abs() <= 2.0 * f64::EPSILON * x.abs(),
                "{x} {expected}"
            );
        }
    }
}

#[test]
fn a_third_evaluation_is_omitted_only_if_it_would_change_nothing() {
    // The residual after the last update, in twice the precision: (x³ + x − a) at x + e.
    let (a, newton) = (values().map(|a| 0.3 * a), Newton::default());
    let loose = Newton {
        tolerance: 0.0,
        ..newton
    };
    let (quick, few) = single_cubic(&a, &newton);
    let (slow, many) = single_cubic(&a, &loose);
    assert!(few < many, "{few} {many}");
    for lane in 0..LANES {
        let (x, y) = (quick.point(lane)[0], slow.point(lane)[0]);
        assert!((x - y).abs() <= f64::EPSILON * x.abs(), "{x} {y}");
    }
}

#[test]
fn single_lanes_do_not_feel_their_neighbours() {
    let newton = Newton::default();
    let (together, _) = single_cubic(&values(), &newton);
    for lane in 0..LANES {
        let (alone, _) = single_cubic(&[values()[lane]; LANES], &newton);
        assert_eq!(alone.point(0), together.point(lane));
    }
}

#[test]
fn single_lanes_fail_where_they_do_not_converge() {
    let newton = Newton::default();
    let mut a = values();
    (a[3], a[5], a[7]) = (f64::NAN, f64::INFINITY, 1e200);
    let (iterations, _) = single_cubic(&a, &newton);
    for lane in 0..LANES {
        let fails = [3, 5, 7].contains(&lane);
        assert_eq!(iterations.has_converged(lane), !fails, "{lane}");
    }
    for max_iterations in [0, 1] {
        let few = Newton {
            max_iterations,
            ..newton
        };
        let (iterations, evaluations) = single_cubic(&[0.5; LANES], &few);
        assert_eq!(evaluations, 1);
        assert!((0..LANES).all(|lane| !iterations.has_converged(lane)));
    }
    let (mut iterations, _) = single_cubic(&values(), &newton);
    for lane in 0..LANES {
        iterations.accept(lane, lane % 3 != 0);
    }
    assert!((0..LANES).all(|lane| iterations.has_converged(lane) == (lane % 3 != 0)));
}

/// Evaluations whose magnitude overflows: no residual is small relative to infinity.
#[test]
fn an_infinite_magnitude_is_no_scale() {
    let at = Evaluation {
        residual: [1.0],
        magnitude: [f64::INFINITY],
        jacobian: [[1.0]],
        curvature: 0.0,
    };
    let mut iterations = SingleLanes::new(&Newton::default());
    for lane in 0..LANES {
        iterations.start(lane, [0.0], [0.0], &at);
    }
    while iterations.next_iteration() {
        for lane in 0..LANES {
            iterations.update(lane, &at);
        }
    }
    assert!((0..LANES).all(|lane| !iterations.has_converged(lane)));
}
