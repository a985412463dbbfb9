//! Baselines: methods for comparison, one in each file, on the first-order form
//! (`docs/mathematics.md`, sections 1 and 4).
//!
//! Input: the derivatives that the macro generated for the same Lagrangian and noises. Output: a
//! [`OneStepMethod`](crate::OneStepMethod); trajectories, ensembles and studies take a baseline
//! wherever they take an [`Integrator`](crate::Integrator).
//!
//! | method | stochastic | deterministic order | strong order |
//! | --- | --- | --- | --- |
//! | [`EulerMaruyama`] | Itô, corrected drift | 1 | ½, 1 with additive noise |
//! | [`BackwardEulerMaruyama`] | Itô, corrected drift | 1 | ½, 1 with additive noise |
//! | [`Heun`] | Stratonovich | 2 | 1 if the noises commute, otherwise ½ |
//! | [`Baoab`] | Langevin systems | 2 | 1; weak order 2 |
//! | [`RungeKutta4`] | no | 4 | |
//! | [`TaylorSeries2`] | no | 2 | |
//!
//! None of these methods is symplectic.

/// Implements `OneStepMethod` for a baseline that has a field `system` and a function `increment`.
///
/// The second argument names the number of Wiener processes; without it, the baseline is for
/// systems without noise. The brackets list the fields that are options of the method.
macro_rules! method_by_increment {
    ($name:ident) => {
        method_by_increment!(@ $name, [], 0,);
    };
    ($name:ident, $m:ident, [$($option:ident),*]) => {
        method_by_increment!(@ $name, [$($option),*], $m, const $m: usize);
    };
    (@ $name:ident, [$($option:ident),*], $m:tt, $($generic:tt)*) => {
        impl<S, Q, const N: usize, $($generic)*> crate::method::OneStepMethod for $name<S>
        where
            S: System<Dims = Dims<N, $m, Q>>,
            Q: VectorCoordinates<N>,
        {
            type System = S;
            type Increments = [f64; $m];
            type Prepared = ();

            fn system(&self) -> &S {
                &self.system
            }

            fn identify(&self, to: &mut dyn core::hash::Hasher) {
                to.write(stringify!($name).as_bytes());
                $(to.write(format!("{:?}", self.$option).as_bytes());)*
            }

            fn describe(&self) -> String {
                let options: &[String] = &[$(format!(", {} = {:?}", stringify!($option), self.$option)),*];
                stringify!($name).to_owned() + &options.concat()
            }

            #[inline]
            fn prepare(&self, h: f64) -> Result<(), crate::error::StepError> {
                const { crate::mechanics::constraints::assert_unconstrained::<S>() }
                crate::integrator::accept::check_step_size(h)
            }

            #[inline]
            fn step_prepared(
                &self,
                (): &(),
                state: &mut State<Q>,
                h: f64,
                dw: &[f64; $m],
            ) -> Result<(), crate::error::StepError> {
                const { assert!(S::ROLES.is_empty(), "{}", crate::mechanics::degenerate::NEEDS_REGULAR) };
                Q::in_coordinates(state, |state| match self.increment(state, h, dw) {
                    Ok(d) => crate::integrator::accept::advance(state, h, dw, &d.q, &d.p),
                    Err(error) => Err(crate::error::step_error(error, state, h, dw)),
                })
            }
        }
    };
}

mod backward_euler_maruyama;
mod baoab;
mod euler_maruyama;
mod explicit;
mod heun;
mod runge_kutta4;
mod taylor_series2;

pub use backward_euler_maruyama::BackwardEulerMaruyama;
pub use baoab::Baoab;
pub use euler_maruyama::EulerMaruyama;
pub use heun::Heun;
pub use runge_kutta4::RungeKutta4;
pub use taylor_series2::TaylorSeries2;

use crate::system::Dims;

#[doc(hidden)]
/// The [`System::Dims`](crate::system::System::Dims) of a system without noise, which deterministic
/// methods require.
#[diagnostic::on_unimplemented(
    message = "this method is for systems without noise",
    label = "the system has a `#[gamma]` or an `#[h1]`",
    note = "use `baseline::Heun` or `baseline::EulerMaruyama`, or take the noise out of the `impl` block"
)]
pub trait NoiseFree {}

impl<const N: usize, Q> NoiseFree for Dims<N, 0, Q> {}
