//! The linearised step of a Gauss rule, for tangent maps and sensitivities (`docs/mathematics.md`,
//! section 8).

use super::jacobian::{displacement, jacobian, moves_position, row, velocity};
use super::stages::product;
use super::step::{Stage, Step};
use super::tableau::Tableau;
use crate::phase::configuration::VectorCoordinates;
use crate::system::linearisation::{Entries, Linearisation};
use crate::system::{Dims, System};

/// Derivatives by a parameter at a point.
#[derive(Clone, Copy, Debug)]
pub struct ParameterJet<const N: usize, const M: usize> {
    /// Derivatives of `∂L/∂q`.
    pub dq: [f64; N],
    /// Derivatives of `∂L/∂v`.
    pub dv: [f64; N],
    /// Derivatives of the force.
    pub force: [f64; N],
    /// Derivatives of `∂G_a/∂q − f_a` for each noise.
    pub noise_against: [[f64; N]; M],
    /// Derivatives of `∂G_a/∂p` for each noise.
    pub noise_dp: [[f64; N]; M],
}

/// A system whose equations of motion are differentiated by the parameters.
pub trait ByParameters<const N: usize, const M: usize>: System {
    /// Visits the derivatives by each parameter, in the order of
    /// [`PARAMETERS`](System::PARAMETERS).
    fn parameter_jets(
        &self,
        t: f64,
        q: &[f64; N],
        v: &[f64; N],
        p: &[f64; N],
        visit: &mut dyn FnMut(ParameterJet<N, M>),
    );
}

impl<Sys, Q, const S: usize, const N: usize, const M: usize> Step<'_, Sys, S, N, M>
where
    Sys: System<Dims = Dims<N, M, Q>> + ByParameters<N, M>,
    Q: VectorCoordinates<N>,
{
    /// Linearises the equations and results around the solution `x`. Returns the result of `then`.
    pub(super) fn linearise<const K: usize, T>(
        &self,
        x: &[f64; K],
        then: impl FnOnce(Linearisation<'_>) -> T,
    ) -> T {
        let unknowns = self.unknowns(x);
        let stages = self.stages(&unknowns);
        let inputs = 2 * N + Sys::PARAMETERS.len();
        let mut all = Matrices::<N, K>::zeros(inputs);
        jacobian(&self.weights, &stages, &mut all.residual_by_unknowns);
        self.outputs(&stages, &mut all);
        Self::start(&stages, &mut all);
        for j in 0..S {
            let mut q = self.state.q;
            for n in 0..N {
                q[n] += unknowns.moves[j][n];
            }
            self.parameters(j, &q, &unknowns.velocities[j], &stages[j], &mut all);
        }
        then(Linearisation::new([K, 2 * N, inputs], all.entries()))
    }

    /// Adds the derivatives of the results `Σ Y_j` and `Σ F_j` by the unknowns.
    fn outputs<const K: usize>(&self, stages: &[Stage<N>; S], all: &mut Matrices<N, K>) {
        let ratio_of = const { &Tableau::<S>::VALUES.ratio_of };
        for m in 0..N {
            let [positions, momenta] = &mut all.output_by_unknowns;
            for n in 0..N {
                let by_positions = row(stages, |stage| stage.impulse.by_position[m][n]);
                // The effects of the stages k through all stages.
                let through = product(ratio_of, &by_positions);
                for k in 0..S {
                    let by_velocity = stages[k].impulse.by_velocity[m][n];
                    let velocity = velocity::<S>(k, n);
                    if moves_position::<S, N, K>() {
                        momenta[m][velocity] = by_velocity;
                        momenta[m][displacement::<S, N>(k, n)] = through[k];
                    } else {
                        momenta[m][velocity] = by_velocity + self.weights[k] * through[k];
                    }
                }
            }
            for k in 0..S {
                if moves_position::<S, N, K>() {
                    positions[m][displacement::<S, N>(k, m)] = 1.0;
                } else {
                    positions[m][velocity::<S>(k, m)] = self.weights[k];
                }
            }
        }
    }

    /// Adds the derivatives of the equations and of the results by the state at the start.
    fn start<const K: usize>(stages: &[Stage<N>; S], all: &mut Matrices<N, K>) {
        let ratio = const { &Tableau::<S>::VALUES.ratio };
        for m in 0..N {
            for n in 0..N {
                let by_positions = row(stages, |stage| stage.impulse.by_position[m][n]);
                let impulses = product(ratio, &by_positions);
                for i in 0..S {
                    let row = velocity::<S>(i, m);
                    *all.residual_by_input(row, n) = stages[i].lagrangian.dqv[n][m] - impulses[i];
                    if moves_position::<S, N, K>() {
                        let row = displacement::<S, N>(i, m);
                        *all.residual_by_input(row, n) = -stages[i].shift.by_position[m][n];
                    }
                    *all.output_by_input(N + m, n) += stages[i].impulse.by_position[m][n];
                }
            }
            for i in 0..S {
                *all.residual_by_input(velocity::<S>(i, m), N + m) = -1.0;
            }
        }
    }

    /// Adds the derivatives of the equations and results by the parameters at stage `j`.
    fn parameters<const K: usize>(
        &self,
        j: usize,
        q: &[f64; N],
        v: &[f64; N],
        stage: &Stage<N>,
        all: &mut Matrices<N, K>,
    ) {
        if Sys::PARAMETERS.is_empty() {
            return;
        }
        let ratio = const { &Tableau::<S>::VALUES.ratio };
        let (t, p) = (self.times[j], &stage.lagrangian.dv);
        let noises = self.system.noise_jets(t, q, p);
        let mut column = 2 * N;
        let mut visit = |jet: ParameterJet<N, M>| {
            for m in 0..N {
                let mut impulse = self.weights[j] * (jet.dq[m] + jet.force[m]);
                let mut shift = 0.0;
                for a in 0..M {
                    let part = self.noise[a][j];
                    impulse -= part * jet.noise_against[a][m];
                    shift += part * jet.noise_dp[a][m];
                    for k in 0..N {
                        // through the momentum of the stage
                        impulse -= part * noises[a].dqp[m][k] * jet.dv[k];
                        shift += part * noises[a].dpp[m][k] * jet.dv[k];
                    }
                }
                for i in 0..S {
                    *all.residual_by_input(velocity::<S>(i, m), column) -= ratio[j][i] * impulse;
                }
                *all.residual_by_input(velocity::<S>(j, m), column) += jet.dv[m];
                if moves_position::<S, N, K>() {
                    *all.residual_by_input(displacement::<S, N>(j, m), column) = -shift;
                }
                *all.output_by_input(N + m, column) += impulse;
            }
            column += 1;
        };
        self.system.parameter_jets(t, q, v, p, &mut visit);
    }
}

/// ∂R/∂x, ∂R/∂z, ∂y/∂x, ∂y/∂z.
struct Matrices<const N: usize, const K: usize> {
    residual_by_unknowns: [[f64; K]; K],
    /// The rows of the results along q, then those along p.
    output_by_unknowns: [[[f64; K]; N]; 2],
    /// Number of inputs z.
    inputs: usize,
    /// The rows of the residuals by the inputs, then those of the results.
    by_inputs: Vec<f64>,
}

impl<const N: usize, const K: usize> Matrices<N, K> {
    fn zeros(inputs: usize) -> Self {
        Self {
            residual_by_unknowns: [[0.0; K]; K],
            output_by_unknowns: [[[0.0; K]; N]; 2],
            inputs,
            by_inputs: vec![0.0; (K + 2 * N) * inputs],
        }
    }

    fn residual_by_input(&mut self, row: usize, input: usize) -> &mut f64 {
        &mut self.by_inputs[row * self.inputs + input]
    }

    fn output_by_input(&mut self, row: usize, input: usize) -> &mut f64 {
        self.residual_by_input(K + row, input)
    }

    fn entries(&self) -> [Entries<'_>; 4] {
        let rows = |columns, values| Entries::Rows { columns, values };
        let (residuals, outputs) = self.by_inputs.split_at(K * self.inputs);
        [
            rows(K, self.residual_by_unknowns.as_flattened()),
            rows(self.inputs, residuals),
            rows(K, self.output_by_unknowns.as_flattened().as_flattened()),
            rows(self.inputs, outputs),
        ]
    }
}
