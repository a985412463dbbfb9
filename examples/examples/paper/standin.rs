#![allow(dead_code, clippy::all, clippy::pedantic)]
use sve_runtime::__private::SolveError;
use sve_runtime::*;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Pendulum { pub(crate) g: f64 }
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oscillator { pub(crate) sigma: f64 }
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kubo { pub(crate) a: f64, pub(crate) sigma: f64 }

fn jet(value: f64, dq: f64, dv: f64, dqq: f64, dvv: f64) -> LagrangianJet<1> {
    LagrangianJet { value, dq: [dq], dv: [dv], dqq: [[dqq]], dqv: [[0.0]], dvv: [[dvv]], dqt: [0.0], dvt: [0.0] }
}
impl System for Pendulum {
    type Dims = Dims<1, 0>;
    const AFFINE_MOMENTUM: bool = true;
    fn lagrangian_jet(&self, _: f64, q: &[f64; 1], v: &[f64; 1]) -> LagrangianJet<1> {
        jet(0.5 * v[0] * v[0] + self.g * q[0].cos(), -self.g * q[0].sin(), v[0], -self.g * q[0].cos(), 1.0)
    }
    fn noise_jets(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) -> [NoiseJet<1>; 0] { [] }
}
impl System for Oscillator {
    type Dims = Dims<1, 1>;
    const AFFINE_MOMENTUM: bool = true;
    fn lagrangian_jet(&self, _: f64, q: &[f64; 1], v: &[f64; 1]) -> LagrangianJet<1> {
        jet(0.5 * v[0] * v[0] - 0.5 * q[0] * q[0], -q[0], v[0], -1.0, 1.0)
    }
    fn noise_jets(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) -> [NoiseJet<1>; 1] {
        [NoiseJet { dq: [-self.sigma], dp: [0.0], dqq: [[0.0]], dqp: [[0.0]], dpp: [[0.0]] }]
    }
}
impl System for Kubo {
    type Dims = Dims<1, 1>;
    const AFFINE_MOMENTUM: bool = true;
    fn lagrangian_jet(&self, _: f64, q: &[f64; 1], v: &[f64; 1]) -> LagrangianJet<1> {
        let a = self.a;
        jet(0.5 * v[0] * v[0] / a - 0.5 * a * q[0] * q[0], -a * q[0], v[0] / a, -a, 1.0 / a)
    }
    fn noise_jets(&self, _: f64, q: &[f64; 1], p: &[f64; 1]) -> [NoiseJet<1>; 1] {
        let s = self.sigma;
        [NoiseJet { dq: [s * q[0]], dp: [s * p[0]], dqq: [[s]], dqp: [[0.0]], dpp: [[s]] }]
    }
}
const PLAN: Plan = Plan {
    system: "", rule: "", degrees_of_freedom: 1, noises: 1, blocks: &[], deterministic_order: 1,
    strong_order: StrongOrder::One, prepare: Operations { arithmetic: 0, transcendental: 0 },
    step: Operations { arithmetic: 0, transcendental: 0 }, iteration: Operations { arithmetic: 0, transcendental: 0 },
};
macro_rules! variational { ($system:ty, $rule:ty, $m:literal, |$s:ident, $state:ident, $h:ident, $dw:ident| $body:expr) => {
    impl Variational<$rule> for $system {
        type Prepared = ();
        const PLAN: &'static Plan = &PLAN;
        fn prepare(&self, _: f64) {}
        fn increment(&self, _: &(), $state: &State<1>, $h: f64, $dw: &[f64; $m], _: &Newton) -> Result<([f64; 1], [f64; 1]), SolveError> {
            let $s = self; let (q, p) = $body; Ok(([q], [p]))
        }
    }
}}
variational!(Oscillator, InitialPoint, 1, |s, z, h, dw| { let dp = -h * z.q[0] + s.sigma * dw[0]; (h * (z.p[0] + dp), dp) });
variational!(Oscillator, Endpoint, 1, |s, z, h, dw| { let dq = h * z.p[0]; (dq, -h * (z.q[0] + dq) + s.sigma * dw[0]) });
variational!(Oscillator, Midpoint, 1, |s, z, h, dw| {
    let g = s.sigma * dw[0]; let dq = h * (z.p[0] + 0.5 * g - 0.5 * h * z.q[0]) / (1.0 + 0.25 * h * h);
    (dq, -h * (z.q[0] + 0.5 * dq) + g)
});
variational!(Kubo, Midpoint, 1, |s, z, h, dw| {
    let x = s.a * h + s.sigma * dw[0]; let dq = x * (z.p[0] - 0.5 * x * z.q[0]) / (1.0 + 0.25 * x * x);
    (dq, -x * (z.q[0] + 0.5 * dq))
});
variational!(Pendulum, Taylor2, 0, |s, z, h, _dw| {
    let (q, p, g) = (z.q[0], z.p[0], s.g);
    let (a, b) = (-g * q.sin(), -g * q.cos());
    let f = |v: f64| {
        let (w, e) = (v + h * a, q + h * v);
        -0.5 * h * (v * (-1.0 / h - 0.5 * h * b) - g * q.sin() + w * (-1.0 / h + 0.5 * h * b) - g * e.sin() * (-0.5 * h * h * b)) - p
    };
    let mut v = p;
    for _ in 0..50 { let d = (f(v + 1e-6) - f(v - 1e-6)) / 2e-6; v -= f(v) / d; }
    let (w, e) = (v + h * a, q + h * v);
    (h * v + 0.5 * h * h * a, 0.5 * (v + w) - 0.5 * h * g * e.sin() - p)
});
