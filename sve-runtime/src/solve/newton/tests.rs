//! Newton's method on equations with known roots.

use std::cell::{Cell, RefCell};

use super::{Evaluation, Newton};
use crate::solve::SolveError;

/// One equation, its terms and its derivative.
fn scalar(terms: &[f64], derivative: f64) -> Evaluation<1> {
    Evaluation {
        residual: [terms.iter().sum()],
        magnitude: [terms.iter().map(|t| t.abs()).sum()],
        jacobian: [[derivative]],
        curvature: f64::NAN,
    }
}

/// Returns the result, and the number of evaluations.
fn counted<const K: usize>(
    newton: &Newton,
    guess: [f64; K],
    evaluate: impl Fn(&[f64; K]) -> Evaluation<K>,
) -> (Result<[f64; K], SolveError>, u32) {
    let count = Cell::new(0);
    let found = newton.solve(guess, |x| {
        count.set(count.get() + 1);
        evaluate(x)
    });
    (found, count.get())
}

fn square_root(x: &[f64; 1]) -> Evaluation<1> {
    scalar(&[x[0] * x[0], -2.0], 2.0 * x[0])
}

#[test]
fn converges_quadratically_without_a_confirming_evaluation() {
    let errors = RefCell::new(Vec::new());
    let (found, count) = counted(&Newton::default(), [1.5], |x| {
        errors.borrow_mut().push((x[0] - 2.0_f64.sqrt()).abs());
        square_root(x)
    });
    let error = (found.unwrap()[0] - 2.0_f64.sqrt()).abs();
    assert!(error <= f64::EPSILON, "{error:e}");
    // The errors are e₁ = e₀²/(2x): 9e-2, 2.5e-3, 2e-6, 1.6e-12. The root of the fifth iteration is
    // not evaluated.
    assert_eq!(count, 4);
    let errors = errors.into_inner();
    for pair in errors.windows(2) {
        let constant = pair[1] / pair[0].powi(2);
        assert!((constant - 0.5 / 2.0_f64.sqrt()).abs() < 0.05, "{errors:?}");
    }
    assert!(
        errors[3] > 1e-13,
        "one evaluation more than needed: {errors:?}"
    );
}

#[test]
fn a_root_that_is_guessed_costs_one_evaluation() {
    let (found, count) = counted(&Newton::default(), [2.0], |x| {
        scalar(&[x[0] * x[0], -4.0], 2.0 * x[0])
    });
    assert_eq!((found, count), (Ok([2.0]), 1));
    // all terms zero
    let (found, count) = counted(&Newton::default(), [0.0], |x| scalar(&[x[0]], 1.0));
    assert_eq!((found, count), (Ok([0.0]), 1));
    let (found, count) = counted(&Newton::default(), [], |_| Evaluation {
        residual: [],
        magnitude: [],
        jacobian: [],
        curvature: f64::NAN,
    });
    assert_eq!((found, count), (Ok([]), 1));
}

#[test]
fn a_linear_equation_takes_two_evaluations() {
    let (found, count) = counted(&Newton::default(), [0.0], |x| {
        scalar(&[3.0 * x[0], -6.0], 3.0)
    });
    assert_eq!((found, count), (Ok([2.0]), 2));
}

/// Evaluates two coupled equations, `x² + y − 3 = 0` and `x y − 2 + sin(x − 1) = 0`, in the given
/// units.
fn pair(units: [f64; 2], rows: [f64; 2], z: &[f64; 2]) -> Evaluation<2> {
    let (x, y) = (z[0] / units[0], z[1] / units[1]);
    let terms = [[x * x, y, -3.0], [x * y, -2.0, (x - 1.0).sin()]];
    let jacobian = [[2.0 * x, 1.0], [y + (x - 1.0).cos(), x]];
    let sum = |i: usize| terms[i].iter().sum::<f64>() * rows[i];
    let size = |i: usize| terms[i].iter().map(|t| t.abs()).sum::<f64>() * rows[i];
    Evaluation {
        residual: [sum(0), sum(1)],
        magnitude: [size(0), size(1)],
        curvature: f64::NAN,
        jacobian: core::array::from_fn(|i| {
            core::array::from_fn(|j| jacobian[i][j] * rows[i] / units[j])
        }),
    }
}

#[test]
fn units_do_not_matter() {
    let newton = Newton::default();
    let (reference, evaluations) = counted(&newton, [1.3, 1.6], |z| pair([1.0; 2], [1.0; 2], z));
    let reference = reference.unwrap();
    assert!(pair([1.0; 2], [1.0; 2], &reference).relative_residual() <= newton.tolerance);
    assert!(evaluations <= 6);
    let sizes = [-60, 0, 60].map(|k| 2.0_f64.powi(k));
    for ux in sizes {
        for uy in sizes {
            for r0 in sizes {
                for r1 in sizes {
                    let (found, count) = counted(&newton, [1.3 * ux, 1.6 * uy], |z| {
                        pair([ux, uy], [r0, r1], z)
                    });
                    assert_eq!(found, Ok([reference[0] * ux, reference[1] * uy]));
                    assert_eq!(count, evaluations);
                }
            }
        }
    }
}

#[test]
fn the_limit_is_an_error_with_numbers() {
    // Newton's method on x³ − 2x + 2 from 0 goes 0, 1, 0, 1 …
    let cycle = |x: &[f64; 1]| scalar(&[x[0].powi(3), -2.0 * x[0], 2.0], 3.0 * x[0].powi(2) - 2.0);
    let (found, count) = counted(&Newton::default(), [0.0], cycle);
    assert_eq!(count, 51);
    match found {
        Err(SolveError::NotConverged {
            iterations,
            residual,
            tolerance,
        }) => {
            assert_eq!(iterations, 50);
            assert_eq!(tolerance, Newton::default().tolerance);
            assert!(residual > 0.1);
        }
        other => panic!("{other:?}"),
    }
    let none = Newton {
        max_iterations: 0,
        ..Newton::default()
    };
    assert!(matches!(
        none.solve([1.5], square_root),
        Err(SolveError::NotConverged { iterations: 0, .. })
    ));
    // no root at all
    let (found, count) = counted(&Newton::default(), [0.7], |x| {
        scalar(&[x[0] * x[0], 1.0], 2.0 * x[0])
    });
    assert!(found.is_err() && count <= 51);
}

#[test]
fn a_singular_jacobian_is_an_error() {
    assert_eq!(
        Newton::default().solve([0.0], square_root),
        Err(SolveError::Singular { iteration: 1 })
    );
    let dependent = |z: &[f64; 2]| Evaluation {
        residual: [z[0] + z[1] - 1.0, 2.0 * z[0] + 2.0 * z[1] - 3.0],
        magnitude: [3.0; 2],
        jacobian: [[1.0, 1.0], [2.0, 2.0]],
        curvature: f64::NAN,
    };
    assert_eq!(
        Newton::default().solve([0.0; 2], dependent),
        Err(SolveError::Singular { iteration: 1 })
    );
}

#[test]
fn a_multiple_root_is_reached() {
    // linear convergence: the residual of (x − 1)³ shrinks by 8/27 an iteration, which is no stall
    let (found, _) = counted(&Newton::default(), [2.0], |x| {
        let e = x[0] - 1.0;
        Evaluation {
            residual: [e.powi(3)],
            magnitude: [1.0],
            jacobian: [[3.0 * e * e]],
            curvature: f64::NAN,
        }
    });
    let error = (found.unwrap()[0] - 1.0).abs();
    assert!(error <= Newton::default().tolerance.cbrt(), "{error:e}");
}

fn momentum(p: f64) -> impl Fn(&[f64; 1]) -> Evaluation<1> {
    move |v| {
        let s = (1.0 - v[0] * v[0]).sqrt();
        scalar(&[v[0] / s, -p], s.powi(-3))
    }
}

#[test]
fn an_update_out_of_the_domain_is_halved() {
    let (found, count) = counted(&Newton::default(), [0.0], momentum(5.0));
    assert!((found.unwrap()[0] - 5.0 / 26.0_f64.sqrt()).abs() < 1e-15);
    assert!(count < 25, "{count}");
    // a guess out of the domain comes back from the side of zero
    let found = Newton::default().solve([7.0], momentum(0.3)).unwrap();
    assert!((found[0] - 0.3 / 1.09_f64.sqrt()).abs() < 1e-15);
}

#[test]
fn a_steep_equation_is_solved_to_the_rounding_of_its_unknown() {
    // one unit in the last place of v changes the residual by 1e-16 p³, far more than its tolerance
    for p in [1e4, 1e5, 1e6, 1e7] {
        let (found, count) = counted(&Newton::default(), [0.0], momentum(p));
        let exact = p / (1.0 + p * p).sqrt();
        assert!((found.unwrap()[0] - exact).abs() <= f64::EPSILON, "{p:e}");
        assert!(count < 2000);
    }
    // no double below 1 has this momentum
    let (found, count) = counted(&Newton::default(), [0.0], momentum(1e9));
    assert!(matches!(
        found,
        Err(SolveError::NotConverged { .. } | SolveError::NonFinite)
    ));
    assert!(count < 5000);
}

#[test]
fn what_is_not_finite_is_an_error() {
    let newton = Newton::default();
    for bad in [f64::NAN, f64::INFINITY] {
        // the residual, at once and everywhere
        let (found, count) = counted(&newton, [1.0], |_| scalar(&[bad], 1.0));
        assert_eq!(found, Err(SolveError::NonFinite));
        assert!(count <= 61);
        // the Jacobian
        let (found, count) = counted(&newton, [1.0], |x| scalar(&[x[0], -3.0], bad));
        assert_eq!(found, Err(SolveError::NonFinite));
        assert!(count <= 2);
        let three = |z: &[f64; 3]| Evaluation {
            residual: *z,
            magnitude: [2.0; 3],
            jacobian: [[bad, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            curvature: f64::NAN,
        };
        assert!(newton.solve([1.0; 3], three).is_err());
        // the guess: zero is tried instead
        assert!(newton.solve([bad], square_root).is_err());
        let found = newton.solve([bad], |x| scalar(&[2.0 * x[0], -3.0], 2.0));
        assert_eq!(found, Ok([1.5]));
    }
    // A single NaN is found at any place among finite residuals.
    for place in 0..3 {
        let found = newton.solve([1.0; 3], |_| {
            let mut residual = [0.0; 3];
            residual[place] = f64::NAN;
            Evaluation {
                residual,
                magnitude: [1.0; 3],
                jacobian: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                curvature: f64::NAN,
            }
        });
        assert_eq!(found, Err(SolveError::NonFinite));
    }
    // a finite residual is not small because the sum of its terms' magnitudes overflows
    let found = newton.solve([1.0], |x| scalar(&[1.5e308, -1.2e308 * x[0]], -1.2e308));
    assert!(found.is_err(), "{found:?}");
}

#[test]
fn an_update_that_overflows_ends() {
    // e^{-x}: the root is at infinity
    let (found, count) = counted(&Newton::default(), [0.0], |x| {
        let e = (-x[0]).exp();
        scalar(&[e, -e * 1e-3, -1e-300], -e * 0.999)
    });
    assert!(count <= 51, "{count} {found:?}");
    let (found, count) = counted(&Newton::default(), [1e300], |x| {
        scalar(&[x[0] * 1e-300, 1.0], 2e-308)
    });
    assert!(found.is_err());
    assert!(count <= 200, "{count}");
}

#[test]
fn rounding_above_the_tolerance_is_accepted_where_it_stalls() {
    // The magnitudes do not show that the first term is a difference of large numbers, as in a
    // user's own body.
    let square = 7.0 / 3.0; // between two numbers that the blurred term can be
    for (large, worst) in [(1e3, 1e-12), (1e5, 1e-10), (1e7, 1e-8)] {
        let (found, count) = counted(&Newton::default(), [1.2], |x| {
            let blurred = (x[0] * x[0] + large) - large;
            scalar(&[blurred, -square], 2.0 * x[0])
        });
        let error = (found.unwrap()[0] - square.sqrt()).abs();
        assert!(error < worst, "{large:e}: {error:e}");
        assert!(count < 12, "{large:e}: {count}");
    }
}

#[test]
fn a_looser_tolerance_saves_evaluations() {
    let loose = Newton {
        tolerance: 1e-4,
        ..Newton::default()
    };
    let (found, count) = counted(&loose, [1.5], square_root);
    let error = (found.unwrap()[0] - 2.0_f64.sqrt()).abs();
    assert!(error < 1e-4 && count <= 3, "{error:e} {count}");
    // No residual meets these tolerances, so the iteration ends by the stall.
    for tolerance in [0.0, f64::NAN] {
        let strict = Newton {
            tolerance,
            ..Newton::default()
        };
        let (found, count) = counted(&strict, [1.5], square_root);
        assert!((found.unwrap()[0] - 2.0_f64.sqrt()).abs() <= f64::EPSILON && count < 12);
    }
}

mod blocks;
