//! Test systems: each Lagrangian with its jet differentiated by hand (`mechanics.rs` checks them by
//! differences).

use sve_runtime::system::{Dims, LagrangianJet, NoiseJet, System};

pub(crate) const fn lagrangian_zero<const N: usize>() -> LagrangianJet<N> {
    LagrangianJet {
        value: 0.0,
        dq: [0.0; N],
        dv: [0.0; N],
        dqq: [[0.0; N]; N],
        dqv: [[0.0; N]; N],
        dvv: [[0.0; N]; N],
        dqt: [0.0; N],
        dvt: [0.0; N],
    }
}

pub(crate) const fn noise_zero<const N: usize>() -> NoiseJet<N> {
    NoiseJet {
        dq: [0.0; N],
        dp: [0.0; N],
        dqq: [[0.0; N]; N],
        dqp: [[0.0; N]; N],
        dpp: [[0.0; N]; N],
    }
}

/// `L = ½v² − ½q²`, `γ = σq`.
#[derive(Clone, Copy)]
pub(crate) struct Oscillator {
    pub(crate) sigma: f64,
}

impl System for Oscillator {
    type Dims = Dims<1, 1>;
    type Itself = Self;
    type EulerNumbers = ();
    const AFFINE_MOMENTUM: bool = true;

    fn itself(&self) -> &Self {
        self
    }

    fn lagrangian_jet(&self, _t: f64, [q]: &[f64; 1], [v]: &[f64; 1]) -> LagrangianJet<1> {
        LagrangianJet {
            value: 0.5 * v * v - 0.5 * q * q,
            dq: [-q],
            dv: [*v],
            dqq: [[-1.0]],
            dvv: [[1.0]],
            ..lagrangian_zero()
        }
    }

    fn noise_jets(&self, _t: f64, _q: &[f64; 1], _p: &[f64; 1]) -> [NoiseJet<1>; 1] {
        [NoiseJet {
            dq: [-self.sigma],
            ..noise_zero()
        }]
    }
}

/// `L = v²/(2a) − a q²/2`, `H₁ = σ(q² + p²)/2`.
#[derive(Clone, Copy)]
pub(crate) struct Kubo {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

impl System for Kubo {
    type Dims = Dims<1, 1>;
    type Itself = Self;
    type EulerNumbers = ();
    const AFFINE_MOMENTUM: bool = true;

    fn itself(&self) -> &Self {
        self
    }

    fn lagrangian_jet(&self, _t: f64, [q]: &[f64; 1], [v]: &[f64; 1]) -> LagrangianJet<1> {
        let a = self.a;
        LagrangianJet {
            value: v * v / (2.0 * a) - a * q * q / 2.0,
            dq: [-a * q],
            dv: [v / a],
            dqq: [[-a]],
            dvv: [[1.0 / a]],
            ..lagrangian_zero()
        }
    }

    fn noise_jets(&self, _t: f64, [q]: &[f64; 1], [p]: &[f64; 1]) -> [NoiseJet<1>; 1] {
        [NoiseJet {
            dq: [self.sigma * q],
            dp: [self.sigma * p],
            dqq: [[self.sigma]],
            dpp: [[self.sigma]],
            ..noise_zero()
        }]
    }
}

/// `L = ½v² + g cos q`.
#[derive(Clone, Copy)]
pub(crate) struct Pendulum {
    pub(crate) g: f64,
}

impl System for Pendulum {
    type Dims = Dims<1, 0>;
    type Itself = Self;
    type EulerNumbers = ();
    const AFFINE_MOMENTUM: bool = true;

    fn itself(&self) -> &Self {
        self
    }

    fn lagrangian_jet(&self, _t: f64, [q]: &[f64; 1], [v]: &[f64; 1]) -> LagrangianJet<1> {
        LagrangianJet {
            value: 0.5 * v * v + self.g * q.cos(),
            dq: [-self.g * q.sin()],
            dv: [*v],
            dqq: [[-self.g * q.cos()]],
            dvv: [[1.0]],
            ..lagrangian_zero()
        }
    }

    fn noise_jets(&self, _t: f64, _q: &[f64; 1], _p: &[f64; 1]) -> [NoiseJet<1>; 0] {
        []
    }
}

/// A particle in the plane, `q = (r, θ)`: `L = ½m(ṙ² + r²θ̇²) + k/r`, `γ = σ₁ r cos θ`,
/// `H₁ = σ₂ p_r p_θ / r`.
#[derive(Clone, Copy)]
pub(crate) struct Polar {
    pub(crate) m: f64,
    pub(crate) k: f64,
    pub(crate) sigma: [f64; 2],
}

impl System for Polar {
    type Dims = Dims<2, 2>;
    type Itself = Self;
    type EulerNumbers = ();
    const AFFINE_MOMENTUM: bool = true;

    fn itself(&self) -> &Self {
        self
    }

    fn lagrangian_jet(&self, _t: f64, [r, _]: &[f64; 2], [vr, w]: &[f64; 2]) -> LagrangianJet<2> {
        let Self { m, k, .. } = self;
        LagrangianJet {
            value: 0.5 * m * (vr * vr + r * r * w * w) + k / r,
            dq: [m * r * w * w - k / (r * r), 0.0],
            dv: [m * vr, m * r * r * w],
            dqq: [[m * w * w + 2.0 * k / r.powi(3), 0.0], [0.0, 0.0]],
            dqv: [[0.0, 2.0 * m * r * w], [0.0, 0.0]],
            dvv: [[*m, 0.0], [0.0, m * r * r]],
            ..lagrangian_zero()
        }
    }

    fn noise_jets(&self, _t: f64, [r, a]: &[f64; 2], [pr, pa]: &[f64; 2]) -> [NoiseJet<2>; 2] {
        let [s1, s2] = self.sigma;
        let gamma = NoiseJet {
            dq: [-s1 * a.cos(), s1 * r * a.sin()],
            dqq: [[0.0, s1 * a.sin()], [s1 * a.sin(), s1 * r * a.cos()]],
            ..noise_zero()
        };
        let h1 = NoiseJet {
            dq: [-s2 * pr * pa / (r * r), 0.0],
            dp: [s2 * pa / r, s2 * pr / r],
            dqq: [[2.0 * s2 * pr * pa / r.powi(3), 0.0], [0.0, 0.0]],
            dqp: [[-s2 * pa / (r * r), -s2 * pr / (r * r)], [0.0, 0.0]],
            dpp: [[0.0, s2 / r], [s2 / r, 0.0]],
        };
        [gamma, h1]
    }
}

/// A damped oscillator with a velocity-dependent potential: `L = eᶜᵗ(½v² − ½kq²) + b t q v`.
///
/// Its motion is `q̈ + c q̇ + (k + b e⁻ᶜᵗ) q = 0`; its momentum is affine in v, not linear, where
/// q ≠ 0.
#[derive(Clone, Copy)]
pub(crate) struct Damped {
    pub(crate) c: f64,
    pub(crate) k: f64,
    pub(crate) b: f64,
}

impl System for Damped {
    type Dims = Dims<1, 0>;
    type Itself = Self;
    type EulerNumbers = ();
    const AFFINE_MOMENTUM: bool = true;

    fn itself(&self) -> &Self {
        self
    }

    fn lagrangian_jet(&self, t: f64, [q]: &[f64; 1], [v]: &[f64; 1]) -> LagrangianJet<1> {
        let Self { c, k, b } = self;
        let e = (c * t).exp();
        LagrangianJet {
            value: e * (0.5 * v * v - 0.5 * k * q * q) + b * t * q * v,
            dq: [-e * k * q + b * t * v],
            dv: [e * v + b * t * q],
            dqq: [[-e * k]],
            dqv: [[b * t]],
            dvv: [[e]],
            dqt: [-c * e * k * q + b * v],
            dvt: [c * e * v + b * q],
        }
    }

    fn noise_jets(&self, _t: f64, _q: &[f64; 1], _p: &[f64; 1]) -> [NoiseJet<1>; 0] {
        []
    }
}

/// A relativistic particle on a spring: `L = −√(1 − |v|²) − ½k|q|²`, defined for `|v| < 1` alone.
#[derive(Clone, Copy)]
pub(crate) struct Relativistic<const N: usize> {
    pub(crate) k: f64,
}

impl<const N: usize> System for Relativistic<N> {
    type Dims = Dims<N, 0>;
    type Itself = Self;
    type EulerNumbers = ();
    const AFFINE_MOMENTUM: bool = false;

    fn itself(&self) -> &Self {
        self
    }

    fn lagrangian_jet(&self, _t: f64, q: &[f64; N], v: &[f64; N]) -> LagrangianJet<N> {
        let s = (1.0 - v.iter().map(|v| v * v).sum::<f64>()).sqrt();
        let mut jet = lagrangian_zero();
        jet.value = -s - 0.5 * self.k * q.iter().map(|q| q * q).sum::<f64>();
        for i in 0..N {
            jet.dq[i] = -self.k * q[i];
            jet.dv[i] = v[i] / s;
            jet.dqq[i][i] = -self.k;
            for j in 0..N {
                jet.dvv[i][j] = v[i] * v[j] / s.powi(3) + if i == j { 1.0 / s } else { 0.0 };
            }
        }
        jet
    }

    fn noise_jets(&self, _t: f64, _q: &[f64; N], _p: &[f64; N]) -> [NoiseJet<N>; 0] {
        []
    }
}
