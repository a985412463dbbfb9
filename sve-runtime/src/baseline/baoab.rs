//! BAOAB: kick, drift, exact friction and noise, drift, kick, for Langevin systems.
//!
//! ```text
//! B  p += ½h (−∂V/∂q + F(q, 0))
//! A  q += ½h M⁻¹p
//! O  dp = −Γ p dt + Σ dW over h, exactly
//! A, B again
//! ```
//!
//! Input: L = ½ vᵀMv − V without terms linear in v, a force F(q, v) = F(q, 0) − C v and noises γ of
//! the configuration. The friction Γ = C M⁻¹ and the noise Σ = ∂γ/∂q follow from the derivatives of
//! F and γ, so the temperature is determined by the system's own friction and noise. Invariant:
//! with a harmonic V, the distribution of q in equilibrium is exact for every stable h.
//!
//! Source: Leimkuhler, Matthews, *Rational construction of stochastic numerical methods for
//! molecular sampling*, Appl. Math. Res. Express (2013) 34–56.

use crate::error::{StepError, step_error};
use crate::integrator::accept;
use crate::mechanics::Noises;
use crate::mechanics::legendre;
use crate::method::OneStepMethod;
use crate::phase::Field;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::rule::QuadraticKineticEnergy;
use crate::solve::SolveError;
use crate::solve::dense;
use crate::system::jets::LagrangianJet;
use crate::system::{Dims, System};

/// Largest difference of two terms, relative to their size, that counts as zero: rounding errors of
/// derivatives and of the inverse mass matrix.
const ROUNDING: f64 = 1e-10;

/// The splitting BAOAB of Leimkuhler and Matthews, for systems with friction and a bath.
///
/// It takes the friction from the force, F(q, v) = F(q, 0) − C v, and the noise from `#[gamma]`:
/// nothing is given twice. The rates of friction, C M⁻¹, have to be a diagonal matrix, and noises
/// must not couple coordinates of different rates. Under these conditions friction and noise
/// together are solved exactly in distribution. In time it is of weak order 2, and of strong
/// order 1. With a harmonic potential its positions have the exact distribution at any stable h:
///
/// ```
/// use sve_runtime::baseline::Baoab;
/// use sve_runtime::Blocking;
/// use sve_runtime::prelude::*;
///
/// struct Langevin { nu: f64, kt: f64 }
///
/// #[variational(midpoint)]
/// impl Langevin {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
///     #[force]
///     fn friction(&self, _q: f64, v: f64) -> f64 { -self.nu * v }
///     #[gamma]
///     fn bath(&self, q: f64) -> f64 { (2.0 * self.nu * self.kt).sqrt() * q }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let method = Baoab::new(Langevin { nu: 1.0, kt: 0.5 });
/// let mut square = Blocking::new();
/// let path = method.trajectory(State::new([0.0], [0.0]), 1.0, Wiener::new(1));
/// for state in path.skip(100).take(100_000) {
///     square.push(state?.q[0].powi(2));
/// }
/// // kT, with a step of a sixth of a period
/// assert!((square.mean() - 0.5).abs() < 0.02);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Baoab<S> {
    system: S,
}

impl<S: QuadraticKineticEnergy> Baoab<S> {
    /// Creates the method for `system`.
    pub fn new(system: S) -> Self {
        Self { system }
    }
}

impl<S, Q, const N: usize, const M: usize> OneStepMethod for Baoab<S>
where
    S: System<Dims = Dims<N, M, Q>> + QuadraticKineticEnergy,
    Q: VectorCoordinates<N>,
{
    type System = S;
    type Increments = [f64; M];
    type Prepared = ();

    fn system(&self) -> &S {
        &self.system
    }

    fn prepare(&self, h: f64) -> Result<(), StepError> {
        accept::check_step_size(h)
    }

    /// # Errors
    /// The errors of every step, and [`StepError::NotLangevin`] if friction and noise cannot be
    /// solved exactly.
    fn step_prepared(
        &self,
        (): &(),
        state: &mut State<Q>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            let d = self.increment(state, h, dw)?;
            accept::advance(state, h, dw, &d.q, &d.p)
        })
    }
}

impl<S> Baoab<S> {
    /// Returns the increment `(q₁ − q₀, p₁ − p₀)`.
    fn increment<Q, const N: usize, const M: usize>(
        &self,
        start: &State<[f64; N]>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<Field<[f64; N]>, StepError>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let half = 0.5 * h;
        let singular = || {
            let error = legendre::velocity(&self.system, start).err();
            let error = error.unwrap_or(SolveError::Singular { iteration: 0 });
            step_error(error, start, h, dw)
        };
        let (mut q, mut p) = (start.q, start.p);
        let (first, rest) = self.force(start.t, &q);
        if rest.dv != [0.0; N] {
            let (t, what) = (start.t, "the momentum ∂L/∂v is not zero at rest".to_owned());
            return Err(StepError::NotLangevin { t, what });
        }
        let mass = dense::factored(&rest.dvv).ok_or_else(singular)?;
        add(&mut p, half, &first);
        let v = mass.solve(&p);
        add(&mut q, half, &v);
        let at = State::at(start.t + half, q, p);
        let relaxed = self.relaxation(&at, &v, &mass, h, dw)?;
        add(&mut p, 1.0, &relaxed);
        let w = mass.solve(&p);
        add(&mut q, half, &w);
        let (last, _) = self.force(start.t + h, &q);
        Ok(Field {
            q: core::array::from_fn(|i| half * (v[i] + w[i])),
            p: core::array::from_fn(|i| half * (first[i] + last[i]) + relaxed[i]),
        })
    }

    /// Returns the force at rest, −∂V/∂q + F(q, 0), and the derivatives of L there.
    fn force<Q, const N: usize, const M: usize>(
        &self,
        t: f64,
        q: &[f64; N],
    ) -> ([f64; N], LagrangianJet<N>)
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let jet = self.system.lagrangian_jet(t, q, &[0.0; N]);
        let mut force = jet.dq;
        if S::FORCED {
            add(
                &mut force,
                1.0,
                &self.system.force_jet(t, q, &[0.0; N]).value,
            );
        }
        (force, jet)
    }

    /// Returns the change of the momentum by friction and noise over a step, solved exactly in
    /// distribution.
    fn relaxation<Q, const N: usize, const M: usize>(
        &self,
        at: &State<[f64; N]>,
        v: &[f64; N],
        mass: &dense::Factors<N>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<[f64; N], StepError>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let refused = |what: &str| {
            let (t, what) = (at.t, what.to_owned());
            StepError::NotLangevin { t, what }
        };
        let rates = self.rates(at, v, mass).map_err(refused)?;
        let noises = Noises::at(&self.system, at);
        let moves_position = noises.jets.iter().flat_map(|jet| jet.dp).any(|x| x != 0.0);
        if moves_position || S::NOISE_READS_VELOCITY {
            return Err(refused("a noise depends on the momentum"));
        }
        let kicks = noises.kicks();
        let covariance = |i: usize, j: usize| kicks.iter().map(|g| g[i] * g[j]).sum::<f64>();
        for i in 0..N {
            for j in 0..i {
                let are_equal = (rates[i] - rates[j]).abs() <= ROUNDING * rates[i].abs();
                let scale = (covariance(i, i) * covariance(j, j)).sqrt();
                if !are_equal && covariance(i, j).abs() > ROUNDING * scale {
                    return Err(refused(
                        "a noise couples coordinates of different rates of friction",
                    ));
                }
            }
        }
        let noise = noises.field(dw).p;
        Ok(core::array::from_fn(|i| {
            let x = rates[i] * h;
            (-x).exp_m1() * at.p[i] + shrinkage(x) * noise[i]
        }))
    }

    /// Returns the rate of friction of each momentum, or the reason why it has none.
    fn rates<Q, const N: usize, const M: usize>(
        &self,
        at: &State<[f64; N]>,
        v: &[f64; N],
        mass: &dense::Factors<N>,
    ) -> Result<[f64; N], &'static str>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        if !S::FORCED {
            return Ok([0.0; N]);
        }
        let rest = self.system.force_jet(at.t, &at.q, &[0.0; N]);
        let moving = self.system.force_jet(at.t, &at.q, v).value;
        let mut rates = [0.0; N];
        let mut rows = [[0.0; N]; N];
        for i in 0..N {
            let terms: [f64; N] = core::array::from_fn(|j| rest.dv[i][j] * v[j]);
            let affine = rest.value[i] + terms.iter().sum::<f64>();
            let scale = rest.value[i].abs() + terms.iter().map(|x| x.abs()).sum::<f64>();
            if (moving[i] - affine).abs() > ROUNDING * (scale + moving[i].abs()) {
                return Err("the force is not affine in the velocity");
            }
            // The row is a row of C M⁻¹, since M is symmetric.
            rows[i] = mass.solve(&rest.dv[i].map(|x| -x));
            rates[i] = rows[i][i];
        }
        for i in 0..N {
            for j in (0..N).filter(|&j| j != i) {
                if rows[i][j].abs() > ROUNDING * (rates[i].abs() + rates[j].abs()) {
                    return Err("friction couples the momenta");
                }
            }
        }
        Ok(rates)
    }
}

/// Returns √((1 − e^(−2x))/(2x)): the standard deviation of ∫ e^(−x(1 − s)) dW over a unit of time,
/// relative to the standard deviation of W.
fn shrinkage(x: f64) -> f64 {
    if x == 0.0 {
        return 1.0;
    }
    (-(-2.0 * x).exp_m1() / (2.0 * x)).sqrt()
}

/// Adds a multiple of a row.
fn add<const N: usize>(to: &mut [f64; N], factor: f64, row: &[f64; N]) {
    for (to, x) in to.iter_mut().zip(row) {
        *to += factor * x;
    }
}
