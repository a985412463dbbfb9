//! Measured orders of steps with rotations: rows of the table of system, rule, noise and expected order.
//!
//! The error is the root mean square over paths of the distance between the ends at T = 1 of 2ᵏ and 2ᵏ⁺¹ steps on the same path, so that no
//! reference solution is needed: both ends have an error of the same order. The order is the slope of the logarithms, and its standard error
//! comes from the scatter between batches of paths.

use sve_runtime::prelude::*;
use sve_runtime::{Coordinates, Dims, FixedSize, StrongOrder, System, Variational};

const BATCHES: usize = 16;
const SEED: u64 = 2026;

/// Standard errors of a slope that are accepted.
const SIGMAS: f64 = 4.0;

/// Largest standard error of a slope.
const LARGEST_ERROR: f64 = 0.03;

/// Exponents of the step sizes 2⁻ᵏ. The error of the smallest step compares 2⁻¹¹ with 2⁻¹².
const LEVELS: [u32; 5] = [7, 8, 9, 10, 11];

struct Linear {
    chi: Vector3<f64>,
}

#[variational(midpoint)]
impl Linear {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[h1]
    fn turn(&self, _r: Rotation3<f64>, pi: Vector3<f64>) -> f64 {
        self.chi.dot(&pi)
    }
}

struct Quadratic {
    k: Vector3<f64>,
}

#[variational(midpoint)]
impl Quadratic {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[h1]
    fn shake(&self, _r: Rotation3<f64>, pi: Vector3<f64>) -> f64 {
        0.5 * pi.dot(&self.k.component_mul(&pi))
    }
}

struct Commuting {
    chi: Vector3<f64>,
}

#[variational(midpoint)]
impl Commuting {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[h1]
    fn turns(&self, _r: Rotation3<f64>, pi: Vector3<f64>) -> [f64; 2] {
        let along = self.chi.dot(&pi);
        [along, 0.5 * along * along]
    }
}

/// The noise of Arnaudon, De Castro and Holm: its three components do not commute.
struct Isotropic {
    s: f64,
}

#[variational(midpoint)]
impl Isotropic {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[h1]
    fn kicks(&self, _r: Rotation3<f64>, pi: Vector3<f64>) -> [f64; 3] {
        [self.s * pi.x, self.s * pi.y, self.s * pi.z]
    }
}

struct HeavyTop {
    s: f64,
}

#[variational(midpoint)]
impl HeavyTop {
    fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z) - 2.0 * r[(2, 2)]
    }
    #[gamma]
    fn wind(&self, r: Rotation3<f64>) -> f64 {
        self.s * r[(0, 0)]
    }
}

/// A heavy top without noise.
struct QuietTop;

#[variational(midpoint)]
impl QuietTop {
    fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z) - 2.0 * r[(2, 2)]
    }
}

/// A momentum in space beside a momentum in the body: they commute with each other, which the bracket of rotations must know.
struct SpaceAndBody {
    s: f64,
}

#[variational(midpoint)]
impl SpaceAndBody {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[h1]
    fn kicks(&self, r: Rotation3<f64>, pi: Vector3<f64>) -> [f64; 2] {
        [self.s * (r * pi).x, self.s * pi.z]
    }
}

/// A body on a spring that pulls at a point beside its centre.
struct Tethered {
    s: f64,
}

#[variational(midpoint)]
impl Tethered {
    fn lagrangian(
        &self,
        q: Vector3<f64>,
        r: Rotation3<f64>,
        v: Vector3<f64>,
        w: Vector3<f64>,
    ) -> f64 {
        let end = q + r * Vector3::new(0.3, -0.2, 0.8);
        0.75 * v.norm_squared() + 0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
            - 0.6 * end.norm_squared()
    }
    #[h1]
    fn kick(&self, q: Vector3<f64>, r: Rotation3<f64>, p: Vector3<f64>, pi: Vector3<f64>) -> f64 {
        self.s * (r.inverse_transform_vector(&p).dot(&pi) + q.z * pi.x)
    }
}

fn slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
}

/// Returns the squared distance of two states. Quaternions are continuous along a path, so that those of two steps on the same path have the same sign.
fn distance2<Q: FixedSize>(a: &State<Q>, b: &State<Q>) -> f64 {
    let values = |state: &State<Q>| {
        let mut values = vec![0.0; Q::STORED_VALUES + Q::DEGREES_OF_FREEDOM];
        let (q, p) = values.split_at_mut(Q::STORED_VALUES);
        sve_runtime::Configuration::store(&state.q, q);
        sve_runtime::Configuration::store(&state.p, p);
        values
    };
    let pairs = values(a).into_iter().zip(values(b));
    pairs.map(|(a, b)| (a - b).powi(2)).sum()
}

/// Measures the strong order on `BATCHES` times `paths` paths, and prints and checks a row of the table.
fn row<S, Q, const N: usize, const M: usize>(
    system: S,
    noise: &str,
    paths: usize,
    expected: f64,
    start: State<Q>,
) where
    S: Variational<Midpoint> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let integrator = Integrator::new(system, Midpoint);
    let plan = integrator.plan();
    let order = match plan.strong_order {
        StrongOrder::One => 1.0,
        StrongOrder::Half { .. } => 0.5,
        StrongOrder::Deterministic => f64::from(plan.deterministic_order),
        other => panic!("{other:?}"),
    };
    assert_eq!(order, expected, "{}: {noise}", plan.system);
    let finest = LEVELS[LEVELS.len() - 1] + 1;
    let x: Vec<f64> = LEVELS.iter().map(|&k| -f64::from(k)).collect();
    let mut total = vec![0.0; LEVELS.len()];
    let mut slopes = Vec::new();
    for batch in 0..BATCHES {
        let mut squares = vec![0.0; LEVELS.len()];
        for member in 0..paths {
            let h = 0.5_f64.powi(finest as i32);
            let source = Wiener::new(SEED).path((batch * paths + member) as u64);
            let fine = Recorded::record(source, h, M, 1 << finest).unwrap();
            let end = |level: u32| {
                let path = fine.coarsen(1 << (finest - level)).unwrap();
                let end = integrator.trajectory(start, path.h(), &path).last();
                end.unwrap().unwrap()
            };
            let ends: Vec<State<Q>> = (LEVELS[0]..=finest).map(end).collect();
            for (square, pair) in squares.iter_mut().zip(ends.windows(2)) {
                *square += distance2(&pair[0], &pair[1]);
            }
        }
        for (sum, square) in total.iter_mut().zip(&squares) {
            *sum += square;
        }
        let y: Vec<f64> = squares.iter().map(|s| 0.5 * s.log2()).collect();
        slopes.push(slope(&x, &y));
    }
    let y: Vec<f64> = total.iter().map(|s| 0.5 * s.log2()).collect();
    let order = slope(&x, &y);
    let mean = slopes.iter().sum::<f64>() / BATCHES as f64;
    let variance = slopes.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (BATCHES - 1) as f64;
    let error = (variance / BATCHES as f64).sqrt();
    println!(
        "| {} | midpoint | {noise} | {expected} | {order:.3} ± {error:.3} |",
        plan.system
    );
    assert!(error <= LARGEST_ERROR, "{noise}: {error}");
    assert!(
        (order - expected).abs() <= SIGMAS * error,
        "{noise}: {order} ± {error}"
    );
}

fn body() -> State<UnitQuaternion<f64>> {
    let attitude = UnitQuaternion::from_euler_angles(0.4, -0.7, 1.1);
    State::new(attitude, Vector3::new(0.7, 1.1, -0.4))
}

fn pair() -> State<(Vector3<f64>, UnitQuaternion<f64>)> {
    let State { q, p, .. } = body();
    let (at, push) = (Vector3::new(0.5, -0.3, 0.2), Vector3::new(-0.2, 0.4, 0.6));
    State::new((at, q), (push, p))
}

#[test]
fn noises_of_the_body_momentum() {
    let chi = Vector3::new(0.3, -0.2, 0.5);
    row(Linear { chi }, "χ·Π", 20, 1.0, body());
    let k = Vector3::new(0.5, 0.2, -0.3);
    row(Quadratic { k }, "½ Π·KΠ", 20, 1.0, body());
    row(Commuting { chi }, "χ·Π, ½ (χ·Π)²", 20, 1.0, body());
}

#[test]
fn noises_of_the_body_momentum_that_do_not_commute() {
    row(Isotropic { s: 0.4 }, "σΠ₁, σΠ₂, σΠ₃", 20, 0.5, body());
}

#[test]
fn noises_of_the_attitude() {
    row(HeavyTop { s: 0.5 }, "γ = s R₁₁", 20, 1.0, body());
    row(SpaceAndBody { s: 0.4 }, "s (RΠ)₁, s Π₃", 20, 1.0, body());
    row(Tethered { s: 0.3 }, "s (p·RΠ + q₃Π₁)", 20, 1.0, pair());
}

/// Slopes without noise, at T = 1.
#[test]
fn without_noise() {
    let integrator = Integrator::new(QuietTop, Midpoint);
    let plan = integrator.plan();
    assert_eq!(
        (plan.strong_order, plan.deterministic_order),
        (StrongOrder::Deterministic, 2)
    );
    let end = |level: u32| {
        let steps = 1_u32 << level;
        let mut state = body();
        for _ in 0..steps {
            integrator
                .step(&mut state, 1.0 / f64::from(steps), &[])
                .unwrap();
        }
        state
    };
    let errors = LEVELS.map(|k| 0.5 * distance2(&end(k), &end(k + 1)).log2());
    let order = slope(&LEVELS.map(|k| -f64::from(k)), &errors);
    println!("| {} | midpoint | none | 2 | {order:.4} |", plan.system);
    assert!((order - 2.0).abs() < 0.01, "{order}");
}
