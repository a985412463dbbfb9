//! First passages: the first zero of a function along each path, and paths that stop at this zero.
//!
//! Input: functions of the system and a state. Output: the time of the first zero on each path, and
//! the paths that were never seen to pass. Invariant: a passage is a function of the path's states
//! and noise only, not of its lane, block or thread.
//!
//! Files: [`watch`] compares signs after each step, [`search`] finds the zero within a step,
//! [`counts`] sums up, [`survival`] has the public statistics, [`table`] writes them into files.

pub(super) mod counts;
mod search;
mod survival;
mod table;
pub(super) mod watch;

pub use survival::{Passages, Rate};

use self::counts::PassageRequest;
use super::Ensemble;
use super::observe::{Closure, Function};
use super::statistic::AnyRequest;
use crate::ensemble::PathMethod;
use crate::error::observed::Observed;
use crate::system::{StateOf, System};

/// A function whose first zero on each path is recorded.
pub(super) struct PassageFunction<'a, S: System> {
    pub(super) name: String,
    pub(super) function: Box<dyn Function<S> + 'a>,
    /// A path ends at the zero.
    pub(super) stops: bool,
}

impl<'a, I: PathMethod, K> Ensemble<'a, I, K> {
    /// Stops each path at the first zero of a function, as
    /// [`Trajectory::stop_at`](crate::Trajectory::stop_at) does, and records the time:
    /// [`Summary::passage`](super::Summary::passage) has the distribution of the times.
    ///
    /// A stopped path makes no more steps. Its state stays at the zero, with the time of the zero,
    /// and its observables keep these values in all later statistics: a mean at time t is the mean
    /// of the stopped process, E f(X at min(t, τ)). `observe("time", |_, state| state.t)` has the
    /// mean of min(t, τ), and [`keep_final_states`](Self::keep_final_states) the time and the place
    /// of each passage. A [`weight`](Self::weight) is integrated up to τ.
    ///
    /// Several functions may be given: a path stops at the first zero of any of them, and the other
    /// functions then count it as censored. If an observable is out of its [`bound`](Self::bound)
    /// or not finite at the stop, the path has not passed: it fails, and all functions count it as
    /// censored.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A particle in the well of V = −q³/3 + q/4, at temperature 1/24: a fourth of the barrier.
    /// struct Well;
    ///
    /// #[variational(midpoint)]
    /// impl Well {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q * q * q / 3.0 - 0.25 * q }
    ///     #[force]
    ///     fn friction(&self, _q: f64, v: f64) -> f64 { -v }
    ///     #[gamma]
    ///     fn kicks(&self, q: f64) -> f64 { (1.0_f64 / 12.0).sqrt() * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let well = Integrator::new(Well, Midpoint);
    /// let summary = Ensemble::new(&well)
    ///     .paths(1000).seed(1)
    ///     .steps(0.1, 2000).every(100)
    ///     .start(State::new([-0.5], [0.0]))
    ///     .stop_at("escape", |_, state| state.q[0] - 1.5)
    ///     .run()?;
    /// let escape = summary.passage("escape").unwrap();
    /// // the fraction that has not escaped, with its standard error; `None` once every path has
    /// // passed or is censored
    /// let inside = escape.survival()[20].expect("there are paths in the well");
    /// let error = escape.survival_error()[20].unwrap_or(0.0);
    /// // escapes per time, after the first ten units of time
    /// let rate = escape.rate(1);
    /// println!("{inside} ± {error}, {} ± {}", rate.value, rate.standard_error);
    /// // `t,passed,censored,at_risk,survival,survival_standard_error`; `to_csv` writes a file
    /// escape.write_csv(std::io::sink()).expect("a writer");
    /// # assert!(inside > 0.0 && inside < 1.0 && rate.standard_error < 0.1 * rate.value);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// **Detected zeros.** The signs of the function after successive steps are compared. If they
    /// differ, the step is halved twelve times on the same path of the noise, always towards the
    /// earlier change of sign, and the path is stopped at the zero of the secant of the last part:
    /// for a function with a smooth motion the time has the accuracy of the rule. Two zeros within
    /// a step are not detected. For a function of q, with noise in p alone, these are grazing
    /// encounters, a fraction of the passages that vanishes with h. A function that the noise moves
    /// itself returns within each step: its passages are detected late, as if the boundary were
    /// 0.58 σ√h farther away (Broadie, Glasserman and Kou 1997); compare two step sizes, or move
    /// the boundary by this distance. A path that starts at a zero does not stop at the start; its
    /// side is the side after the first step.
    ///
    /// The noise has to be known within steps: [`Wiener`](crate::noise::Wiener), also refined, or
    /// [`NoNoise`](crate::noise::NoNoise). A path whose function is not finite after a step fails,
    /// and so does a path on which the function jumps to the other sign, as at a pole, or a part of
    /// a step has no solution; such parts are made in smaller steps with [`refine`](Self::refine).
    #[must_use]
    pub fn stop_at<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add_passage(name.into(), Closure::new(function), true)
    }

    /// Records the first zero of a function along each path, as [`stop_at`](Self::stop_at) does,
    /// and lets the path go on.
    ///
    #[doc = include_str!("../example.md")]
    /// let summary = ensemble().first_passage("zero", |_, state| state.q[0]).run()?;
    /// let passed = summary.passage("zero").unwrap().passed()[1];
    /// assert!(passed > 0 && passed < 100);
    /// // the paths that passed go on
    /// assert_eq!(summary["q"].counts()[1], 100);
    #[doc = include_str!("../../example_end.md")]
    #[must_use]
    pub fn first_passage<F, O>(self, name: impl Into<String>, function: F) -> Self
    where
        F: Fn(&I::System, &StateOf<I::System>) -> O + Sync + 'a,
        O: Observed + 'a,
    {
        self.add_passage(name.into(), Closure::new(function), false)
    }

    fn add_passage(
        mut self,
        name: String,
        function: impl Function<I::System> + 'a,
        stops: bool,
    ) -> Self {
        let request = PassageRequest {
            name: name.clone(),
            function: self.observed.passages.len(),
        };
        self.observed.passages.push(PassageFunction {
            name,
            function: Box::new(function),
            stops,
        });
        self.take(AnyRequest::Passages(request))
    }
}

impl<I: PathMethod> Ensemble<'_, I> {
    /// Returns whether paths may stop before the end of the run.
    pub(super) fn has_stops(&self) -> bool {
        self.observed.passages.iter().any(|passage| passage.stops)
    }
}
