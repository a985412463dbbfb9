//! The solution of a step followed from h → 0 without noise, apart from the library: its own
//! equations, made of the derivatives of L, G and φ, Newton's method with differenced Jacobians,
//! and strides so short that the prediction of each point is within a twentieth of the stride.
//!
//! The unknowns are `w = d/h`, p and λ:
//!
//! ```text
//! 0 = p − p₀ − (1 − c) g − Dφ(q₀)ᵀ λ      0 = w − v − Σ ∂G/∂p ΔW / h + …      0 = φ(t₁, q₀ + h w)/h
//! ```

use sve_runtime::__private::VectorCoordinates;
use sve_runtime::nalgebra::{DMatrix, DVector};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, NoiseJet, System};

/// The rules whose equations are known here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scheme {
    /// One node at this part of the step.
    OneNode(f64),
    /// Störmer and Verlet.
    Trapezoidal,
}

/// How far the solution of a step was followed.
pub(super) enum Followed<const N: usize> {
    /// To the whole step: `q₁ − q₀`.
    Whole([f64; N]),
    /// To this part of the step size, and then to this part of the increments.
    Ends([f64; 2]),
    /// More points were needed than are computed.
    Unknown,
}

/// Largest distance of a point from its prediction, relative to the stride.
const DEVIATION: f64 = 0.05;

/// First and largest stride, and the smallest one, at which a path ends.
const STRIDES: [f64; 3] = [1e-3, 0.04, 1e-10];

/// The equations of a step.
struct Equations<'a, S, Q: VectorCoordinates<N>, const N: usize> {
    system: &'a S,
    state: &'a State<Q>,
    scheme: Scheme,
}

impl<S, Q, const N: usize, const M: usize> Equations<'_, S, Q, N>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    /// The velocity of a momentum, and `∂L/∂q`, for L of second degree in the velocities.
    fn motion(&self, t: f64, q: &[f64; N], p: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let rest = self.system.lagrangian_jet(t, q, &[0.0; N]);
        let mass = DMatrix::from_fn(N, N, |i, j| rest.dvv[i][j]);
        let relative = DVector::from_fn(N, |i, _| p[i] - rest.dv[i]);
        let v = mass.lu().solve(&relative).unwrap();
        let velocity: [f64; N] = core::array::from_fn(|i| v[i]);
        let jet = self.system.lagrangian_jet(t, q, &velocity);
        (v, DVector::from_fn(N, |i, _| jet.dq[i]))
    }

    fn gradients(&self, t: f64, q: &[f64; N]) -> (DVector<f64>, DMatrix<f64>) {
        let mut jets = Vec::new();
        self.system.constraint_jets(t, q, &mut |jet| jets.push(jet));
        (
            DVector::from_fn(jets.len(), |k, _| jets[k].value),
            DMatrix::from_fn(jets.len(), N, |k, i| jets[k].dq[i]),
        )
    }

    fn residual(&self, x: &DVector<f64>, h: f64, dw: &[f64; M]) -> DVector<f64> {
        let (t, q0, p0) = (
            self.state.t,
            self.state.q.coordinates(),
            Q::components(&self.state.p),
        );
        let w: [f64; N] = core::array::from_fn(|i| x[i]);
        let p = DVector::from_fn(N, |i, _| x[N + i]);
        let count = x.len() - 2 * N;
        let lambda = DVector::from_fn(count, |k, _| x[2 * N + k]);
        let at = |part: f64| core::array::from_fn(|i| q0[i] + part * h * w[i]);
        let start = self.gradients(t, &q0).1;
        let end = self.gradients(t + h, &at(1.0)).0;
        let impulse = start.transpose() * lambda;
        let values: [f64; N] = core::array::from_fn(|i| p[i]);
        let mut out = DVector::zeros(x.len());
        // (place, weight of the node, weight of its impulse in the balance of p₀)
        let nodes: Vec<(f64, f64, f64)> = match self.scheme {
            Scheme::OneNode(c) => vec![(c, 1.0, 1.0 - c)],
            Scheme::Trapezoidal => vec![(0.0, 0.5, 1.0), (1.0, 0.5, 0.0)],
        };
        for i in 0..N {
            out[i] = p[i] - p0[i] - impulse[i];
            out[N + i] = w[i];
        }
        if self.scheme == Scheme::Trapezoidal {
            self.trapezoidal_velocity(&mut out, &p, h, at(1.0));
        }
        for (place, weight, share) in nodes {
            let (time, q) = (t + place * h, at(place));
            let (v, force) = if self.scheme == Scheme::Trapezoidal {
                let v = self.mean_velocity(&p, h, &q0, &at(1.0));
                let velocity: [f64; N] = core::array::from_fn(|i| v[i]);
                let jet = self.system.lagrangian_jet(time, &q, &velocity);
                (None, DVector::from_fn(N, |i, _| jet.dq[i]))
            } else {
                let (v, force) = self.motion(time, &q, &p);
                (Some(v), force)
            };
            let jets: [NoiseJet<N>; M] = self.system.noise_jets(time, &q, &values);
            for i in 0..N {
                let (mut kick, mut shift) = (h * force[i], 0.0);
                for (jet, dw) in jets.iter().zip(dw) {
                    kick -= jet.dq[i] * dw;
                    shift += jet.dp[i] * dw;
                }
                // the correction, (c − ½) Σ ⟨∂G_a/∂p, ∂G_b/∂q⟩ ΔW_a ΔW_b
                if let Scheme::OneNode(c) = self.scheme {
                    for (a, da) in jets.iter().zip(dw) {
                        for (b, db) in jets.iter().zip(dw) {
                            for j in 0..N {
                                kick += (c - 0.5)
                                    * da
                                    * db
                                    * (a.dqp[i][j] * b.dq[j] + a.dp[j] * b.dqq[j][i]);
                                shift -= (c - 0.5)
                                    * da
                                    * db
                                    * (a.dpp[j][i] * b.dq[j] + a.dp[j] * b.dqp[j][i]);
                            }
                        }
                    }
                }
                out[i] -= share * weight * kick;
                out[N + i] -= weight * shift / h + v.as_ref().map_or(0.0, |v| v[i]);
            }
        }
        for k in 0..count {
            out[2 * N + k] = end[k] / h;
        }
        out
    }

    /// The velocity with the mean momentum of both ends.
    fn mean_velocity(
        &self,
        p: &DVector<f64>,
        h: f64,
        q0: &[f64; N],
        q1: &[f64; N],
    ) -> DVector<f64> {
        let t = self.state.t;
        let [first, last] =
            [(t, q0), (t + h, q1)].map(|(t, q)| self.system.lagrangian_jet(t, q, &[0.0; N]));
        let mass = DMatrix::from_fn(N, N, |i, j| 0.5 * (first.dvv[i][j] + last.dvv[i][j]));
        let relative = DVector::from_fn(N, |i, _| p[i] - 0.5 * (first.dv[i] + last.dv[i]));
        mass.lu().solve(&relative).unwrap()
    }

    fn trapezoidal_velocity(&self, out: &mut DVector<f64>, p: &DVector<f64>, h: f64, q1: [f64; N]) {
        let v = self.mean_velocity(p, h, &self.state.q.coordinates(), &q1);
        for i in 0..N {
            out[N + i] -= v[i];
        }
    }

    fn jacobian(&self, x: &DVector<f64>, h: f64, dw: &[f64; M]) -> DMatrix<f64> {
        let size = x.len();
        let mut jacobian = DMatrix::zeros(size, size);
        for j in 0..size {
            let step = 1e-6 * (1.0 + x[j].abs());
            let [above, below] = [step, -step].map(|step| {
                let mut there = x.clone();
                there[j] += step;
                self.residual(&there, h, dw)
            });
            jacobian.set_column(j, &((above - below) / (2.0 * step)));
        }
        jacobian
    }

    /// The solution near a point; `None` if Newton's method does not find one quickly.
    fn solve(&self, guess: &DVector<f64>, h: f64, dw: &[f64; M]) -> Option<DVector<f64>> {
        let factors = self.jacobian(guess, h, dw).lu();
        let mut x = guess.clone();
        let mut before = f64::INFINITY;
        for _ in 0..12 {
            let update = factors.solve(&self.residual(&x, h, dw))?;
            let size = update.norm();
            if !(size.is_finite() && size < 0.5 * before) {
                return (before < 1e-9 * (1.0 + x.norm())).then_some(x);
            }
            x -= update;
            before = size;
            if size < 1e-13 * (1.0 + x.norm()) {
                return Some(x);
            }
        }
        None
    }

    /// The solution without a step: `v = w = ` the part of the velocity of p₀ along the
    /// constraints.
    fn start(&self) -> DVector<f64> {
        let (t, q0) = (self.state.t, self.state.q.coordinates());
        let p0 = DVector::from_column_slice(&Q::components(&self.state.p));
        let jet = self.system.lagrangian_jet(t, &q0, &[0.0; N]);
        let mass = DMatrix::from_fn(N, N, |i, j| jet.dvv[i][j]);
        let mut jets = Vec::new();
        self.system
            .constraint_jets(t, &q0, &mut |jet| jets.push(jet));
        let slopes = DMatrix::from_fn(jets.len(), N, |k, i| jets[k].dq[i]);
        let directions = mass.clone().lu().solve(&slopes.transpose()).unwrap();
        let relative = DVector::from_fn(N, |i, _| p0[i] - jet.dv[i]);
        let v = mass.lu().solve(&relative).unwrap();
        let rates = DVector::from_fn(jets.len(), |k, _| jets[k].dt) + &slopes * &v;
        let lambda = -(&slopes * &directions).lu().solve(&rates).unwrap();
        let w = v + &directions * &lambda;
        let p = p0 + slopes.transpose() * &lambda;
        let mut x = DVector::zeros(2 * N + jets.len());
        x.rows_mut(0, N).copy_from(&w);
        x.rows_mut(N, N).copy_from(&p);
        x.rows_mut(2 * N, jets.len()).copy_from(&lambda);
        x
    }
}

/// Follows the solution of a step.
pub(super) fn follow<S, Q, const N: usize, const M: usize>(
    system: &S,
    scheme: Scheme,
    state: &State<Q>,
    h: f64,
    dw: &[f64; M],
) -> Followed<N>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let equations = Equations {
        system,
        state,
        scheme,
    };
    let start = equations.start();
    // lengths: the displacement, so that a path is as long as the motion
    let place = |at: f64, x: &DVector<f64>| at * h * x.rows(0, N).clone_owned();
    let step = |at: f64, guess: &DVector<f64>| equations.solve(guess, at * h, &[0.0; M]);
    let along = |at: f64, x: &DVector<f64>| place(at, x);
    let end = match path(start, 0.0, step, along) {
        Ok(Some(end)) => end,
        Ok(None) => return Followed::Unknown,
        Err(at) => return Followed::Ends([at, 0.0]),
    };
    let step = |at: f64, guess: &DVector<f64>| equations.solve(guess, h, &dw.map(|dw| at * dw));
    let along = |_: f64, x: &DVector<f64>| place(1.0, x);
    let size = place(1.0, &end).norm();
    let end = if dw.iter().all(|&dw| dw == 0.0) {
        end
    } else {
        match path(end, size, step, along) {
            Ok(Some(end)) => end,
            Ok(None) => return Followed::Unknown,
            Err(at) => return Followed::Ends([1.0, at]),
        }
    };
    Followed::Whole(core::array::from_fn(|i| h * end[i]))
}

/// Follows a path from 0 to 1, whose points have places; `size` is added to lengths that strides
/// are compared with. Returns its end; `None` after too many points.
///
/// # Errors
/// Where the path ends before.
fn path(
    start: DVector<f64>,
    size: f64,
    solve: impl Fn(f64, &DVector<f64>) -> Option<DVector<f64>>,
    place: impl Fn(f64, &DVector<f64>) -> DVector<f64>,
) -> Result<Option<DVector<f64>>, f64> {
    let [mut stride, largest, smallest] = STRIDES;
    let (mut at, mut here) = (0.0, start);
    let mut before: Option<(f64, DVector<f64>)> = None;
    for _ in 0..5000 {
        let there = if at + stride >= 1.0 { 1.0 } else { at + stride };
        let guess = match &before {
            Some((earlier, x)) => &here + (&here - x) * ((there - at) / (at - earlier)),
            None => here.clone(),
        };
        let found = solve(there, &guess).filter(|found| {
            let deviation = (place(there, found) - place(there, &guess)).norm();
            let moved = (place(there, found) - place(at, &here)).norm();
            before.is_none() || deviation <= DEVIATION * moved + 1e-11 * (1.0 + size)
        });
        match found {
            Some(found) => {
                if there == 1.0 {
                    return Ok(Some(found));
                }
                before = Some((at, core::mem::replace(&mut here, found)));
                at = there;
                stride = (1.6 * stride).min(largest);
            }
            None => {
                stride *= 0.4;
                if stride < smallest {
                    return Err(at);
                }
                // a line through points that are far apart does not predict the end of a short
                // stride
                if let Some((earlier, x)) = &mut before
                    && at - *earlier > 3.0 * stride
                {
                    let nearer = at - stride;
                    let guess = &here - (&here - &*x) * (stride / (at - *earlier));
                    if let Some(found) = solve(nearer, &guess) {
                        (*earlier, *x) = (nearer, found);
                    }
                }
            }
        }
    }
    Ok(None)
}
