//! A step of a variational integrator is a symplectic map, with noise too: `MᵀΩM = Ω` for its Jacobian `M`, measured by
//! differences at random points of every model with every rule.

use sve_models::differences::derivative;
use sve_models::functions::Point;
use sve_models::oracle::{cases, oscillator};
use sve_models::random::Random;

/// Differences are good to 1e-12 (see `differences`) times the condition of the Jacobian, which is below 100 here; a
/// step that is not symplectic is wrong by the order of h², 1e-2.
const BOUND: f64 = 1e-9;

/// Largest entry of `MᵀΩM − Ω`.
fn defect(start: &Point, step: impl Fn(&Point) -> Point) -> f64 {
    let n = start.q.len();
    let image = |column: usize, d: f64, row: usize| {
        let mut from = start.clone();
        if column < n {
            from.q[column] += d;
        } else {
            from.p[column - n] += d;
        }
        let to = step(&from);
        if row < n { to.q[row] } else { to.p[row - n] }
    };
    let m: Vec<Vec<f64>> = (0..2 * n)
        .map(|row| {
            (0..2 * n)
                .map(|column| derivative(|d| image(column, d, row)))
                .collect()
        })
        .collect();
    let mut worst = 0.0;
    for a in 0..2 * n {
        for b in 0..2 * n {
            let mut bracket: f64 = (0..n)
                .map(|i| m[i][a] * m[n + i][b] - m[n + i][a] * m[i][b])
                .sum();
            if b == a + n {
                bracket -= 1.0;
            }
            if a == b + n {
                bracket += 1.0;
            }
            if bracket.is_nan() {
                return f64::NAN;
            }
            worst = bracket.abs().max(worst);
        }
    }
    worst
}

#[test]
fn every_step_is_symplectic() {
    let mut random = Random::new(1);
    let mut worst: f64 = 0.0;
    for case in cases() {
        let model = case.model();
        // a force contracts or feeds the symplectic form: see `forces`
        if model.is_forced() {
            continue;
        }
        for _ in 0..5 {
            let start = model.point(&mut random);
            let dw = random.vector(case.dimensions().1, -0.3, 0.3);
            let defect = defect(&start, |from| case.stepped(from, 0.1, &dw));
            worst = worst.max(defect);
            assert!(
                defect < BOUND,
                "{} at {start:?} with dw = {dw:?}: {defect:e}",
                case.name()
            );
        }
    }
    println!("largest defect {worst:e}");
}

/// The scheme that the paper prints as symplectic Euler–Maruyama is backward Euler. Its determinant is 1/(1+h²).
#[test]
fn the_printed_scheme_is_not() {
    let h = 0.1;
    let printed = |from: &Point| {
        let (q, p) = (from.q[0], from.p[0]);
        let kick = 0.3 * oscillator().sigma;
        // q₁ = q₀ + h p₁, p₁ = p₀ − h q₁ + σΔW, solved for p₁
        let p = (p - h * q + kick) / (1.0 + h * h);
        Point::new(&[q + h * p], &[p])
    };
    let defect = defect(&Point::new(&[0.7], &[-0.4]), printed);
    let expected = 1.0 - 1.0 / (1.0 + h * h);
    assert!((defect - expected).abs() < BOUND, "{defect:e}");
    assert!(defect > 1e6 * BOUND);
}
