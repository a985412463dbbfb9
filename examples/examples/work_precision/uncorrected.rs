//! The Kubo oscillator's rules without the Stratonovich correction of the discrete action, which
//! the macro never omits.
//!
//! With x = a h + σ ΔW, endpoint: q₁ = q₀ + x p₀, p₁ = p₀ − x q₁; initial point: p₁ = p₀ − x q₀,
//! q₁ = q₀ + x p₁. They converge, but to the solution of another equation.

use sve_runtime::prelude::*;

use crate::systems::Kubo;

/// The quadrature node of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum QuadratureNode {
    InitialPoint,
    Endpoint,
}

/// A rule without the correction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uncorrected {
    pub(crate) kubo: Kubo,
    pub(crate) node: QuadratureNode,
}

impl OneStepMethod for Uncorrected {
    type System = Kubo;
    type Increments = [f64; 1];
    type Prepared = ();

    fn system(&self) -> &Kubo {
        &self.kubo
    }

    fn prepare(&self, h: f64) -> Result<(), StepError> {
        if h != 0.0 && h.is_finite() {
            Ok(())
        } else {
            Err(StepError::StepSize { h })
        }
    }

    fn step_prepared(
        &self,
        (): &(),
        state: &mut State<[f64; 1]>,
        h: f64,
        dw: &[f64; 1],
    ) -> Result<(), StepError> {
        let x = self.kubo.a * h + self.kubo.sigma * dw[0];
        let State { t, q: [q], p: [p] } = *state;
        let (q, p) = match self.node {
            QuadratureNode::Endpoint => {
                let q = q + x * p;
                (q, p - x * q)
            }
            QuadratureNode::InitialPoint => {
                let p = p - x * q;
                (q + x * p, p)
            }
        };
        if !(q + p).is_finite() {
            let (q, p) = (state.q.to_vec(), state.p.to_vec());
            return Err(StepError::NonFiniteResult { t, h, q, p });
        }
        *state = State::at(t + h, [q], [p]);
        Ok(())
    }
}
