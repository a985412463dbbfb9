//! Derivatives of a step: the tangent map, and the sensitivity to each parameter.
//!
//! Input: the linearised step that the macro generated. Output: `dy/dz = ∂y/∂z − ∂y/∂x (∂R/∂x)⁻¹ ∂R/∂z` for the results y, the
//! unknowns x with their residuals R, and z the state at the start with the parameters (implicit-function theorem).

use core::ops::{Index, Mul};

use crate::Integrator;
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::linear;
use crate::mechanics::Field;
use crate::method::Method;
use crate::newton::SolveError;
use crate::state::State;
use crate::step::{explain, solve_step};
use crate::system::{Dims, System, Variational};

/// The tangent map of a step, `∂(q₁,p₁)/∂(q₀,p₀)`: a matrix of `2N` rows and columns, first the coordinates, then the momenta.
///
/// `tangent[row][column]` is an entry. The product of the maps of successive steps, the later one on the left, is that of all.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent<const N: usize> {
    /// Row by row.
    entries: Vec<f64>,
}

/// The derivatives of `(q₁, p₁)` in the parameters of the system.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity<const N: usize> {
    names: &'static [&'static str],
    fields: Vec<Field<[f64; N]>>,
}

impl<const N: usize> Tangent<N> {
    /// The map that leaves everything where it is.
    #[must_use]
    pub fn identity() -> Self {
        let mut entries = vec![0.0; 4 * N * N];
        for i in 0..2 * N {
            entries[i * (2 * N + 1)] = 1.0;
        }
        Self { entries }
    }

    /// The change of the result for a small change of the start.
    #[must_use]
    pub fn apply(&self, change: &Field<[f64; N]>) -> Field<[f64; N]> {
        let image = |row: usize| -> f64 {
            let (along_q, along_p) = self[row].split_at(N);
            let terms = along_q.iter().zip(&change.q);
            terms
                .chain(along_p.iter().zip(&change.p))
                .map(|(a, b)| a * b)
                .sum()
        };
        Field {
            q: core::array::from_fn(image),
            p: core::array::from_fn(|i| image(N + i)),
        }
    }

    /// The largest entry of `MᵀΩM − Ω`: how far the map is from a symplectic one.
    #[must_use]
    pub fn symplectic_defect(&self) -> f64 {
        let mut worst: f64 = 0.0;
        for a in 0..2 * N {
            for b in 0..2 * N {
                let mut form = 0.0;
                for i in 0..N {
                    form += self[i][a] * self[N + i][b] - self[N + i][a] * self[i][b];
                }
                let expected = f64::from(i8::from(b == a + N) - i8::from(a == b + N));
                worst = worst.max((form - expected).abs());
            }
        }
        worst
    }
}

impl<const N: usize> Index<usize> for Tangent<N> {
    type Output = [f64];

    /// A row.
    fn index(&self, row: usize) -> &[f64] {
        &self.entries[2 * N * row..2 * N * (row + 1)]
    }
}

impl<const N: usize> Mul for &Tangent<N> {
    type Output = Tangent<N>;

    fn mul(self, earlier: &Tangent<N>) -> Tangent<N> {
        let size = 2 * N;
        let mut entries = vec![0.0; size * size];
        for row in 0..size {
            for (k, &factor) in self[row].iter().enumerate() {
                for column in 0..size {
                    entries[size * row + column] += factor * earlier[k][column];
                }
            }
        }
        Tangent { entries }
    }
}

impl<const N: usize> Sensitivity<N> {
    /// The derivative in a parameter, by its name in the source without `self`: `k`, `l[0]`, `body.mass`. Nothing where L, the noises
    /// and the force have no such parameter.
    #[must_use]
    pub fn get(&self, parameter: &str) -> Option<&Field<[f64; N]>> {
        let at = self.names.iter().position(|&name| name == parameter)?;
        self.fields.get(at)
    }

    /// Parameters with the derivatives in them.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Field<[f64; N]>)> {
        self.names.iter().copied().zip(&self.fields)
    }

    /// Goes on to the derivatives after a further step, given that step's own: `S ← M S + s`.
    pub fn advance(&mut self, tangent: &Tangent<N>, step: &Self) {
        for (total, own) in self.fields.iter_mut().zip(&step.fields) {
            let mut moved = tangent.apply(total);
            moved.add_scaled(1.0, own);
            *total = moved;
        }
    }
}

/// One step with its derivatives.
pub(crate) fn derivatives<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    state: &mut State<Q>,
    h: f64,
    dw: &[f64; M],
) -> Result<(Tangent<N>, Sensitivity<N>), StepError>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    Q::in_coordinates(state, |state| {
        derivatives_in_coordinates(integrator, state, h, dw)
    })
}

fn derivatives_in_coordinates<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    state: &mut State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> Result<(Tangent<N>, Sensitivity<N>), StepError>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let prepared = Method::prepare(integrator, h)?;
    let mut end = *state;
    let unknowns = solve_step(integrator, &prepared, &mut end, h, dw)?;
    let linear = integrator.system().linearise(state, h, dw, &unknowns);
    let solved = linear.solve(!S::RETURNS.is_state());
    let all = solved.map_err(|error| explain(error, state, h, dw))?;
    let columns = 2 * N + S::PARAMETERS.len();
    let entry = |row: usize, column: usize| all[columns * row + column];
    let tangent = Tangent {
        entries: all
            .chunks(columns)
            .flat_map(|row| &row[..2 * N])
            .copied()
            .collect(),
    };
    let field = |parameter: usize| Field {
        q: core::array::from_fn(|i| entry(i, 2 * N + parameter)),
        p: core::array::from_fn(|i| entry(N + i, 2 * N + parameter)),
    };
    let sensitivity = Sensitivity {
        names: S::PARAMETERS,
        fields: (0..S::PARAMETERS.len()).map(field).collect(),
    };
    *state = end;
    Ok((tangent, sensitivity))
}

/// The entries of a matrix that are not zero.
#[derive(Clone, Copy, Debug)]
pub struct Entries<'a> {
    /// Row and column of each.
    pub places: &'a [(usize, usize)],
    /// Their values.
    pub values: &'a [f64],
}

impl Entries<'_> {
    fn dense(&self, rows: usize, columns: usize) -> Vec<f64> {
        let mut dense = vec![0.0; rows * columns];
        for (&(row, column), &value) in self.places.iter().zip(self.values) {
            dense[columns * row + column] = value;
        }
        dense
    }
}

/// The equations of a step and its results, to first order.
#[derive(Clone, Debug)]
pub struct Linearisation {
    unknowns: usize,
    outputs: usize,
    inputs: usize,
    residual_by_unknowns: Vec<f64>,
    residual_by_inputs: Vec<f64>,
    output_by_unknowns: Vec<f64>,
    output_by_inputs: Vec<f64>,
}

impl Linearisation {
    /// From the numbers of unknowns, outputs and inputs, and ∂R/∂x, ∂R/∂z, ∂y/∂x, ∂y/∂z.
    #[must_use]
    pub fn new(
        [unknowns, outputs, inputs]: [usize; 3],
        [rx, rz, yx, yz]: [Entries<'_>; 4],
    ) -> Self {
        Self {
            unknowns,
            outputs,
            inputs,
            residual_by_unknowns: rx.dense(unknowns, unknowns),
            residual_by_inputs: rz.dense(unknowns, inputs),
            output_by_unknowns: yx.dense(outputs, unknowns),
            output_by_inputs: yz.dense(outputs, inputs),
        }
    }

    /// `dy/dz`, row by row; with `increments` the results are differences to the state at the start, which is added.
    fn solve(mut self, increments: bool) -> Result<Vec<f64>, SolveError> {
        let moves = &mut self.residual_by_inputs;
        linear::eliminate_many(&mut self.residual_by_unknowns, moves, self.unknowns)?;
        let mut all = self.output_by_inputs;
        for row in 0..self.outputs {
            let result = &mut all[self.inputs * row..self.inputs * (row + 1)];
            if increments {
                result[row] += 1.0;
            }
            let slopes = &self.output_by_unknowns[self.unknowns * row..];
            let moves = moves.chunks(self.inputs);
            for (&slope, moves) in slopes[..self.unknowns].iter().zip(moves) {
                for (x, by) in result.iter_mut().zip(moves) {
                    *x -= slope * by;
                }
            }
        }
        if all.iter().all(|x| x.is_finite()) {
            Ok(all)
        } else {
            Err(SolveError::NonFinite)
        }
    }
}
