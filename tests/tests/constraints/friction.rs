//! RATTLE with a friction that is linear in the velocity, and with a noise force: Newton's method
//! has one unknown for each constraint, and the steps are those of equations that are solved in all
//! unknowns.

use sve_models::checks::assert_close;
use sve_runtime::nalgebra::{SMatrix, SVector};
use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;

const H: f64 = 0.02;

/// A chain of five beads in a bath. The force on bead i also has `more` times `$more`.
macro_rules! chain {
    ($name:ident, |$this:ident, $q:ident, $v:ident, $i:ident| $more:expr $(, $($gust:tt)*)?) => {
        #[derive(Clone, Debug)]
        struct $name {
            m: [f64; 5],
            g: f64,
            nu: f64,
            sigma: f64,
            more: f64,
        }

        #[variational(stormer_verlet)]
        impl $name {
            fn lagrangian(&self, q: [Vector2<f64>; 5], v: [Vector2<f64>; 5]) -> f64 {
                let mut l = 0.0;
                for i in 0..5 {
                    l += 0.5 * self.m[i] * v[i].norm_squared() - self.m[i] * self.g * q[i].y;
                }
                l
            }
            #[gamma]
            fn bath(&self, q: [Vector2<f64>; 5]) -> [Vector2<f64>; 5] {
                q.map(|q| self.sigma * q)
            }
            #[force]
            fn friction(&$this, $q: [Vector2<f64>; 5], $v: [Vector2<f64>; 5]) -> [Vector2<f64>; 5] {
                let mut f = $v;
                for $i in 0..5 {
                    f[$i] = -$this.nu * $v[$i] + $this.more * $more;
                }
                f
            }
            #[constraint]
            fn rods(&self, q: [Vector2<f64>; 5]) -> [f64; 5] {
                let mut rods = [0.5 * (q[0].norm_squared() - 1.0); 5];
                for i in 1..5 {
                    rods[i] = 0.5 * ((q[i] - q[i - 1]).norm_squared() - 1.0);
                }
                rods
            }
            $($($gust)*)?
        }

        impl $name {
            fn new() -> Self {
                let m = [1.0, 1.3, 0.8, 1.1, 0.9];
                Self { m, g: 9.8, nu: 0.7, sigma: 0.3, more: 0.0 }
            }
        }
    };
}

chain!(Chain, |self, _q, v, i| v[i]);
chain!(Placed, |self, q, v, i| q[i].x.powi(2) * v[i]);
chain!(Coupled, |self, _q, v, i| v[0] + v[1] + v[2] + v[3] + v[4]);
chain!(
    Stirred,
    |self, _q, v, i| v[i],
    #[force(noise)]
    fn stir(&self, q: [Vector2<f64>; 5], _v: [Vector2<f64>; 5]) -> [Vector2<f64>; 5] {
        q.map(|q| Vector2::new(-q.y, q.x))
    }
);

/// The chain in motion, hanging aslant.
fn start() -> State<[Vector2<f64>; 5]> {
    let q = std::array::from_fn(|i| (1.0 + i as f64) * Vector2::new(0.6, -0.8));
    let p = std::array::from_fn(|i| 0.3 * (1.0 + i as f64) * Vector2::new(0.8, 0.6));
    State::new(q, p)
}

fn increments(step: usize) -> [f64; 10] {
    std::array::from_fn(|a| 0.1 * ((7 * step + 3 * a) as f64).sin())
}

/// Kinds and sizes of the blocks that are solved by Newton's method, or with a matrix.
fn blocks(plan: &sve_runtime::Plan) -> Vec<(BlockKind, usize)> {
    let sizes = plan.blocks.iter().map(|b| (b.kind, b.unknowns.len()));
    sizes
        .filter(|&(kind, n)| kind == BlockKind::Newton || n > 1)
        .collect()
}

#[test]
fn newton_has_an_unknown_for_each_constraint_with_friction() {
    let expected = [(BlockKind::Newton, 5), (BlockKind::Linear, 5)];
    let chain = Integrator::new(Chain::new(), StormerVerlet);
    assert_eq!(blocks(chain.plan()), expected, "{}", chain.plan());
    let placed = Integrator::new(Placed::new(), StormerVerlet);
    assert_eq!(blocks(placed.plan()), expected, "{}", placed.plan());
    let stirred = Integrator::new(Stirred::new(), StormerVerlet);
    assert_eq!(blocks(stirred.plan()), expected, "{}", stirred.plan());
    // velocities that a force couples stay unknowns
    let coupled = Integrator::new(Coupled::new(), StormerVerlet);
    assert_eq!(blocks(coupled.plan())[0], (BlockKind::Newton, 15));
}

#[test]
fn steps_are_those_of_newtons_method_in_all_unknowns() {
    let chain = Integrator::new(Chain::new(), StormerVerlet);
    let coupled = Integrator::new(Coupled::new(), StormerVerlet);
    let (mut state, mut expected) = (start(), start());
    for k in 0..300 {
        let dw = increments(k);
        chain.step(&mut state, H, &dw).unwrap();
        coupled.step(&mut expected, H, &dw).unwrap();
        for i in 0..5 {
            assert_close(state.q[i].as_slice(), expected.q[i].as_slice(), 1e-12, k);
            assert_close(state.p[i].as_slice(), expected.p[i].as_slice(), 1e-12, k);
        }
        expected = state;
    }
}

/// One step by hand: Newton's method in the multipliers, then the projection. The noise force turns
/// q by a right angle.
fn rattle(
    chain: &Chain,
    q: SVector<f64, 10>,
    p: SVector<f64, 10>,
    dw: &[f64; 10],
    stir: f64,
) -> [SVector<f64, 10>; 2] {
    type Row = SVector<f64, 10>;
    let m = Row::from_fn(|i, _| chain.m[i / 2]);
    let turned = |q: Row| Row::from_fn(|k, _| if k % 2 == 0 { -q[k + 1] } else { q[k - 1] });
    let slopes = |q: &Row| {
        let mut slopes = SMatrix::<f64, 5, 10>::zeros();
        for k in 0..10 {
            let before = if k < 2 { 0.0 } else { q[k - 2] };
            slopes[(k / 2, k)] = q[k] - before;
            if k >= 2 {
                slopes[(k / 2, k - 2)] = before - q[k];
            }
        }
        slopes
    };
    let value = |q: &Row| {
        SVector::<f64, 5>::from_fn(|i, _| {
            let side = |k: usize| q[k] - if k < 2 { 0.0 } else { q[k - 2] };
            0.5 * (side(2 * i).powi(2) + side(2 * i + 1).powi(2) - 1.0)
        })
    };
    let pushes = Row::from_fn(|k, _| {
        let weight = if k % 2 == 1 { -m[k] * chain.g } else { 0.0 };
        H * weight + chain.sigma * dw[k]
    });
    let half = |q: Row| 0.5 * (pushes + stir * turned(q));
    let heavy = m.add_scalar(0.5 * H * chain.nu);
    let at_start = slopes(&q);
    let velocity = |lambda: &SVector<f64, 5>| {
        (p + half(q) + at_start.transpose() * lambda).component_div(&heavy)
    };
    let mut lambda = SVector::<f64, 5>::zeros();
    for _ in 0..20 {
        let end = q + H * velocity(&lambda);
        let mut moved = at_start.transpose();
        for (k, mut row) in moved.row_iter_mut().enumerate() {
            row *= H / heavy[k];
        }
        let jacobian = slopes(&end) * moved;
        lambda -= jacobian.lu().solve(&value(&end)).unwrap();
    }
    let v = velocity(&lambda);
    let end = q + H * v;
    let free = m.component_mul(&v) + half(end) - 0.5 * H * chain.nu * v;
    let at_end = slopes(&end);
    let over_masses = SMatrix::<f64, 10, 5>::from_fn(|k, i| at_end[(i, k)] / m[k]);
    let mu = (at_end * over_masses)
        .lu()
        .solve(&(at_end * free.component_div(&m)))
        .unwrap();
    [end, free - at_end.transpose() * mu]
}

#[test]
fn stormer_verlet_with_friction_and_a_noise_force_is_rattle() {
    let chain = Chain::new();
    let quiet = Integrator::new(&chain, StormerVerlet);
    let stirred = Integrator::new(Stirred::new(), StormerVerlet);
    for stir in [0.0, 0.4] {
        let mut state = start();
        for k in 0..100 {
            let (dw, stir) = (increments(k), stir * (5.0 * k as f64).cos());
            let [q, p] = [state.q, state.p].map(|x| SVector::from_fn(|i, _| x[i / 2][i % 2]));
            let [q, p] = rattle(&chain, q, p, &dw, stir);
            if stir == 0.0 {
                quiet.step(&mut state, H, &dw).unwrap();
            } else {
                let all = std::array::from_fn(|a| if a < 10 { dw[a] } else { stir });
                stirred.step(&mut state, H, &all).unwrap();
            }
            let flat = |x: [Vector2<f64>; 5]| x.map(|x| [x.x, x.y]).concat();
            assert_close(&flat(state.q), q.as_slice(), 1e-12, k);
            assert_close(&flat(state.p), p.as_slice(), 1e-12, k);
        }
    }
}

/// A negative friction whose coefficient m + ½hν has changed its sign: the solution of the
/// equations is not connected with the motion.
#[test]
fn a_friction_beyond_its_pole_is_an_error() {
    let mut chain = Chain::new();
    chain.nu = -150.0;
    let integrator = Integrator::new(&chain, StormerVerlet);
    let before = start();
    let mut state = before;
    assert!(integrator.step(&mut state, H, &[0.0; 10]).is_err());
    assert_eq!(state, before);
}
