//! The linearised step of a Gauss rule, for tangent maps and sensitivities (`docs/mathematics.md`,
//! section 8).

use nalgebra::DMatrix;

use super::jacobian::{displacement, jacobian, moves_position, velocity};
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
        let mut by_unknowns = [[0.0; K]; K];
        jacobian(&self.weights, &stages, &mut by_unknowns);
        let inputs = 2 * N + Sys::PARAMETERS.len();
        let mut all = Matrices {
            residual_by_unknowns: DMatrix::from_fn(K, K, |i, j| by_unknowns[i][j]),
            residual_by_inputs: DMatrix::zeros(K, inputs),
            output_by_unknowns: DMatrix::zeros(2 * N, K),
            output_by_inputs: DMatrix::zeros(2 * N, inputs),
        };
        for j in 0..S {
            self.outputs::<K>(j, &stages, &mut all);
            Self::start::<K>(j, &stages, &mut all);
            let mut q = self.state.q;
            for n in 0..N {
                q[n] += unknowns.moves[j][n];
            }
            self.parameters::<K>(j, &q, &unknowns.velocities[j], &stages[j], &mut all);
        }
        let matrices = [
            all.residual_by_unknowns,
            all.residual_by_inputs,
            all.output_by_unknowns,
            all.output_by_inputs,
        ];
        let places = matrices.each_ref().map(places);
        let entries = core::array::from_fn(|i| Entries {
            places: &places[i],
            values: matrices[i].as_slice(),
        });
        then(Linearisation::new([K, 2 * N, inputs], entries))
    }

    /// Adds the derivatives of the results `Σ Y_j` and `Σ F_j` by the unknowns of stage `k`.
    fn outputs<const K: usize>(&self, k: usize, stages: &[Stage<N>; S], all: &mut Matrices) {
        let ratio = const { &Tableau::<S>::VALUES.ratio };
        for m in 0..N {
            for n in 0..N {
                let mut through = 0.0;
                for j in 0..S {
                    through += ratio[k][j] * stages[j].impulse.by_position[m][n];
                }
                let by_velocity = stages[k].impulse.by_velocity[m][n];
                let velocity = velocity::<S>(k, n);
                if moves_position::<S, N, K>() {
                    all.output_by_unknowns[(N + m, velocity)] = by_velocity;
                    all.output_by_unknowns[(N + m, displacement::<S, N>(k, n))] = through;
                } else {
                    all.output_by_unknowns[(N + m, velocity)] =
                        by_velocity + self.weights[k] * through;
                }
            }
            if moves_position::<S, N, K>() {
                all.output_by_unknowns[(m, displacement::<S, N>(k, m))] = 1.0;
            } else {
                all.output_by_unknowns[(m, velocity::<S>(k, m))] = self.weights[k];
            }
        }
    }

    /// Adds the derivatives of the equations of stage `i` and of the results by the state at the
    /// start.
    fn start<const K: usize>(i: usize, stages: &[Stage<N>; S], all: &mut Matrices) {
        let ratio = const { &Tableau::<S>::VALUES.ratio };
        for m in 0..N {
            for n in 0..N {
                let mut impulses = 0.0;
                for j in 0..S {
                    impulses += ratio[j][i] * stages[j].impulse.by_position[m][n];
                }
                let row = velocity::<S>(i, m);
                all.residual_by_inputs[(row, n)] = stages[i].lagrangian.dqv[n][m] - impulses;
                if moves_position::<S, N, K>() {
                    let row = displacement::<S, N>(i, m);
                    all.residual_by_inputs[(row, n)] = -stages[i].shift.by_position[m][n];
                }
                all.output_by_inputs[(N + m, n)] += stages[i].impulse.by_position[m][n];
            }
            all.residual_by_inputs[(velocity::<S>(i, m), N + m)] = -1.0;
        }
    }

    /// Adds the derivatives of the equations and results by the parameters at stage `j`.
    fn parameters<const K: usize>(
        &self,
        j: usize,
        q: &[f64; N],
        v: &[f64; N],
        stage: &Stage<N>,
        all: &mut Matrices,
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
                    all.residual_by_inputs[(velocity::<S>(i, m), column)] -= ratio[j][i] * impulse;
                }
                all.residual_by_inputs[(velocity::<S>(j, m), column)] += jet.dv[m];
                if moves_position::<S, N, K>() {
                    all.residual_by_inputs[(displacement::<S, N>(j, m), column)] = -shift;
                }
                all.output_by_inputs[(N + m, column)] += impulse;
            }
            column += 1;
        };
        self.system.parameter_jets(t, q, v, p, &mut visit);
    }
}

/// Returns row and column of each entry of a matrix, in the order of storage.
fn places(matrix: &DMatrix<f64>) -> Vec<(usize, usize)> {
    let (rows, columns) = matrix.shape();
    let columns = (0..columns).flat_map(|column| (0..rows).map(move |row| (row, column)));
    columns.collect()
}

/// ∂R/∂x, ∂R/∂z, ∂y/∂x, ∂y/∂z.
struct Matrices {
    residual_by_unknowns: DMatrix<f64>,
    residual_by_inputs: DMatrix<f64>,
    output_by_unknowns: DMatrix<f64>,
    output_by_inputs: DMatrix<f64>,
}
