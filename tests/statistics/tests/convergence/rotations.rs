//! Strong orders of steps with rotations.
//!
//! Each end is compared with that of steps of half the size on the same path, so that no reference
//! solution is needed: both have an error of the same order.

use std::sync::LazyLock;

use sve_models::is_thorough;
use sve_models::orders::{Order, Path, Paths, Row, Tolerance, distance2, end, numbers};
use sve_runtime::__private::Coordinates;
use sve_runtime::Variational;
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// Steps 2⁻⁷ … 2⁻¹¹, the smallest against 2⁻¹².
static PATHS: LazyLock<Paths> = LazyLock::new(|| Paths {
    seed: 2026,
    batches: 16,
    count: if is_thorough() { 20 } else { 14 },
    coarsest: 7,
    levels: 5,
    finest: 12,
    tolerance: Tolerance {
        bias: 0.0,
        error: 0.03,
    },
});

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

#[variational(midpoint, stormer_verlet)]
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

/// A momentum in space beside a momentum in the body: they commute with each other, which the
/// bracket of rotations must know.
struct SpaceAndBody {
    s: f64,
}

#[variational(midpoint, stormer_verlet)]
impl SpaceAndBody {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[h1]
    fn kicks(&self, r: Rotation3<f64>, pi: Vector3<f64>) -> [f64; 2] {
        [self.s * (r * pi).x, self.s * pi.z]
    }
}

/// A heavy top with a noise of its attitude and its momentum.
struct ShakenTop {
    s: f64,
}

#[variational(midpoint, stormer_verlet)]
impl ShakenTop {
    fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z) - 2.0 * r[(2, 2)]
    }
    #[h1]
    fn kick(&self, r: Rotation3<f64>, pi: Vector3<f64>) -> f64 {
        self.s * (1.0 + r[(2, 0)]) * (pi.y + 0.5 * pi.x * pi.x - 0.3 * pi.z * pi.z)
    }
}

/// Torques that turn with the body.
struct Torques {
    f: [Vector3<f64>; 2],
}

#[variational(midpoint, stormer_verlet)]
impl Torques {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (0.8 * w.x * w.x + 1.1 * w.y * w.y + 1.7 * w.z * w.z)
    }
    #[force(noise)]
    fn first(&self, _r: Rotation3<f64>, _w: Vector3<f64>) -> Vector3<f64> {
        self.f[0]
    }
    #[force(noise)]
    fn second(&self, _r: Rotation3<f64>, _w: Vector3<f64>) -> Vector3<f64> {
        self.f[1]
    }
}

/// A torque beside a turn about an axis of the body.
struct TorqueAndTurn {
    f: Vector3<f64>,
}

#[variational(midpoint)]
impl TorqueAndTurn {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (0.8 * w.x * w.x + 1.1 * w.y * w.y + 1.7 * w.z * w.z)
    }
    #[h1]
    fn turn(&self, _r: Rotation3<f64>, pi: Vector3<f64>) -> f64 {
        0.5 * pi.z
    }
    #[force(noise)]
    fn torque(&self, _r: Rotation3<f64>, _w: Vector3<f64>) -> Vector3<f64> {
        self.f
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

/// Checks the strong order of a rule.
fn check<S, R, Q, const N: usize, const M: usize>(
    system: &S,
    rule: R,
    noise: &str,
    order: StrongOrder,
    start: State<Q>,
) where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    R: Copy + 'static,
    Q: Coordinates<N>,
{
    let integrator = Integrator::new(system, rule);
    assert_eq!(integrator.plan().strong_order, order, "{noise}");
    let path = |path| Path {
        fine: PATHS.record(path, M),
        end: None,
    };
    PATHS.check(noise, &[Row::new(system, rule, start)], path);
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
    let one = StrongOrder::One;
    let chi = Vector3::new(0.3, -0.2, 0.5);
    check(&Linear { chi }, Midpoint, "χ·Π", one, body());
    let k = Vector3::new(0.5, 0.2, -0.3);
    check(&Quadratic { k }, Midpoint, "½ Π·KΠ", one, body());
    check(&Commuting { chi }, Midpoint, "χ·Π, ½ (χ·Π)²", one, body());
}

#[test]
fn noises_of_the_body_momentum_that_do_not_commute() {
    let half = StrongOrder::Half {
        pair: ("kicks[0]", "kicks[1]"),
    };
    check(
        &Isotropic { s: 0.4 },
        Midpoint,
        "σΠ₁, σΠ₂, σΠ₃",
        half,
        body(),
    );
}

#[test]
fn noises_of_the_attitude() {
    let one = StrongOrder::One;
    let (top, shaken) = (HeavyTop { s: 0.5 }, SpaceAndBody { s: 0.4 });
    check(&top, Midpoint, "γ = s R₁₁", one, body());
    check(&shaken, Midpoint, "s (RΠ)₁, s Π₃", one, body());
    check(&top, StormerVerlet, "γ = s R₁₁", one, body());
    check(&shaken, StormerVerlet, "s (RΠ)₁, s Π₃", one, body());
    check(
        &Tethered { s: 0.3 },
        Midpoint,
        "s (p·RΠ + q₃Π₁)",
        one,
        pair(),
    );
}

/// A rule with a wrong factor of H₁ has an order too, but another limit.
#[test]
fn stormer_verlet_and_midpoint_have_the_same_limit() {
    let (top, start) = (ShakenTop { s: 0.4 }, body());
    let fine = Integrator::new(&top, Midpoint);
    let paths = Paths {
        count: 20,
        coarsest: 6,
        levels: 4,
        finest: 13,
        ..*PATHS
    };
    let row = Row::new(&top, StormerVerlet, start);
    let path = paths.against(1, |path| end(&fine, start, path));
    paths.check("H₁(R, Π), fine midpoint", &[row], path);
}

#[test]
fn torques_in_the_frame_of_the_body() {
    let one = StrongOrder::One;
    let f = [Vector3::new(0.4, 0.1, -0.2), Vector3::new(0.0, 0.5, 0.3)];
    check(&Torques { f }, Midpoint, "two torques", one, body());
    check(&Torques { f }, StormerVerlet, "two torques", one, body());
}

/// A parameter of the system decides whether they commute, so that the plan claims the lower order.
#[test]
fn a_torque_beside_a_turn() {
    let pair = ("turn", "torque");
    for (f, noise, order) in [
        (Vector3::new(0.0, 0.0, 0.6), "f along χ", 1.0),
        (Vector3::new(0.6, 0.0, 0.0), "f across χ", 0.5),
    ] {
        let system = TorqueAndTurn { f };
        let row = Row::new(&system, Midpoint, body());
        let plan = Integrator::new(&system, Midpoint).plan();
        assert_eq!(plan.strong_order, StrongOrder::Half { pair });
        let path = |path| Path {
            fine: PATHS.record(path, 2),
            end: None,
        };
        PATHS.check(noise, &[row.of_order(order)], path);
    }
}

#[test]
fn without_noise() {
    let integrator = Integrator::new(QuietTop, Midpoint);
    let plan = integrator.plan();
    assert_eq!(plan.strong_order, StrongOrder::Deterministic);
    let ends = [7, 8, 9, 10, 11, 12].map(|level| {
        let steps = 1_usize << level;
        let mut path = integrator.trajectory(body(), 1.0 / steps as f64, NoNoise);
        numbers(&path.nth(steps - 1).unwrap().unwrap())
    });
    let error = |pair: &[Vec<f64>]| distance2(&pair[0], &pair[1]).sqrt();
    let errors: Vec<f64> = ends.windows(2).map(error).collect();
    let tolerance = Tolerance {
        bias: 0.01,
        error: 0.0,
    };
    Order::of(&errors).check([plan.system, plan.rule, "none"], 2.0, tolerance);
    assert_eq!(plan.deterministic_order, 2);
}
