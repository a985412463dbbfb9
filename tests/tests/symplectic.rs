//! A step of a variational integrator is a symplectic map, with noise too: `MᵀΩM = Ω` for its Jacobian `M`, measured by
//! differences at random points of every model with every rule.

use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};
use sve_tests::differences::derivative;
use sve_tests::oracle::{Model, Rule, Visitor, every_step, name, oscillator};
use sve_tests::random::Random;

/// Differences are good to 1e-12 (see `differences`) times the condition of the Jacobian, which is below 100 here; a
/// step that is not symplectic is wrong by the order of h², 1e-2.
const BOUND: f64 = 1e-9;

/// Largest entry of `MᵀΩM − Ω`.
fn defect<const N: usize>(
    start: &State<[f64; N]>,
    step: impl Fn(&State<[f64; N]>) -> State<[f64; N]>,
) -> f64 {
    let image = |column: usize, d: f64, row: usize| {
        let mut from = *start;
        if column < N {
            from.q[column] += d;
        } else {
            from.p[column - N] += d;
        }
        let to = step(&from);
        if row < N { to.q[row] } else { to.p[row - N] }
    };
    let m: Vec<Vec<f64>> = (0..2 * N)
        .map(|row| {
            (0..2 * N)
                .map(|column| derivative(|d| image(column, d, row)))
                .collect()
        })
        .collect();
    let mut worst = 0.0;
    for a in 0..2 * N {
        for b in 0..2 * N {
            let mut bracket: f64 = (0..N)
                .map(|i| m[i][a] * m[N + i][b] - m[N + i][a] * m[i][b])
                .sum();
            if b == a + N {
                bracket -= 1.0;
            }
            if a == b + N {
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

fn step_of<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: &State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> State<[f64; N]>
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let mut state = *start;
    integrator.step(&mut state, h, dw).unwrap();
    state
}

struct Symplectic {
    random: Random,
    worst: f64,
}

impl Visitor for Symplectic {
    fn visit<S, R, const N: usize, const M: usize>(&mut self, integrator: &Integrator<S, R>)
    where
        S: Model<N, M> + Variational<R>,
        R: Rule,
    {
        // a force contracts or feeds the symplectic form: see `forces`
        if S::FORCED {
            return;
        }
        for _ in 0..5 {
            let start = S::point(&mut self.random);
            let dw = self.random.array(-0.3, 0.3);
            let defect = defect(&start, |from| step_of(integrator, from, 0.1, &dw));
            self.worst = self.worst.max(defect);
            assert!(
                defect < BOUND,
                "{} at {start:?} with dw = {dw:?}: {defect:e}",
                name(integrator)
            );
        }
    }
}

#[test]
fn every_step_is_symplectic() {
    let mut check = Symplectic {
        random: Random::new(1),
        worst: 0.0,
    };
    every_step(&mut check);
    println!("largest defect {:e}", check.worst);
}

/// The scheme that the paper prints as symplectic Euler–Maruyama is backward Euler: its determinant is 1/(1+h²).
#[test]
fn the_printed_scheme_is_not() {
    let h = 0.1;
    let printed = |from: &State<[f64; 1]>| {
        let ([q], [p]) = (from.q, from.p);
        let kick = 0.3 * oscillator().sigma;
        // q₁ = q₀ + h p₁, p₁ = p₀ − h q₁ + σΔW, solved for p₁
        let p = (p - h * q + kick) / (1.0 + h * h);
        State::new([q + h * p], [p])
    };
    let defect = defect(&State::new([0.7], [-0.4]), printed);
    let expected = 1.0 - 1.0 / (1.0 + h * h);
    assert!((defect - expected).abs() < BOUND, "{defect:e}");
    assert!(defect > 1e6 * BOUND);
}
