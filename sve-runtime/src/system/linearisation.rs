//! The linearised step that the macro generates, and its solution by the implicit-function theorem
//! (`docs/mathematics.md`, section 8).
//!
//! Input: a step and its results, linearised around a solved step. Output: the matrix of all
//! derivatives; or tangent vectors after the step, from tangent vectors before it; or derivatives
//! of a function by the state before the step, from its derivatives by the state after it.

use nalgebra::DMatrix;

use crate::lanes::{Aligned, Lane, rows};
use crate::phase::Field;
use crate::phase::tangents::KeepUnknowns;
use crate::solve::dense::{Factors, factored};
use crate::solve::{SolveError, lu};
use crate::system::Dimensions;

impl<V> Field<V> {
    /// Returns the vector zero of a system with these sizes.
    pub(crate) fn zero<D: Dimensions<Vector = V>>() -> Self {
        let [q, p] = [D::ZERO, D::ZERO];
        Self { q, p }
    }
}

impl<const N: usize> Field<[f64; N]> {
    /// The vector zero.
    pub(crate) const ZERO: Self = Self {
        q: [0.0; N],
        p: [0.0; N],
    };
}

/// The entries of a matrix.
#[derive(Clone, Copy, Debug)]
pub enum Entries<'a> {
    /// The entries that are not zero.
    Listed {
        /// Row and column of each entry.
        places: &'a [(usize, usize)],
        /// Value of each entry.
        values: &'a [f64],
    },
    /// All, row by row.
    Rows {
        /// Number of columns.
        columns: usize,
        /// Value of each entry.
        values: &'a [f64],
    },
}

impl Entries<'_> {
    /// A matrix without entries.
    const NONE: Self = Entries::Listed {
        places: &[],
        values: &[],
    };

    fn dense(&self, rows: usize, columns: usize) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(rows, columns);
        self.each(|row, column, value| dense[(row, column)] = value);
        dense
    }

    /// Visits row, column and value of each entry.
    #[inline(always)]
    fn each(&self, mut visit: impl FnMut(usize, usize, f64)) {
        match *self {
            Self::Listed { places, values } => {
                for (&(row, column), &value) in places.iter().zip(values) {
                    visit(row, column, value);
                }
            }
            Self::Rows { columns, values } => {
                for (row, values) in values.chunks_exact(columns).enumerate() {
                    for (column, &value) in values.iter().enumerate() {
                        visit(row, column, value);
                    }
                }
            }
        }
    }
}

/// The equations of a step and its results, linearised around a solved step.
#[derive(Clone, Copy, Debug)]
pub struct Linearisation<'a> {
    unknowns: usize,
    outputs: usize,
    inputs: usize,
    residual_by_unknowns: Entries<'a>,
    residual_by_inputs: Entries<'a>,
    output_by_unknowns: Entries<'a>,
    output_by_inputs: Entries<'a>,
    intermediate_by_inputs: Entries<'a>,
    output_by_intermediates: Entries<'a>,
}

/// Tangent vectors of the states of a path, which a step carries along.
#[derive(Debug)]
pub struct Directions<'a, V> {
    /// The tangent vectors.
    pub fields: &'a mut [Field<V>],
    /// The parameter that varies with each vector in this step; `None` if no parameter varies.
    pub parameters: &'a [Option<usize>],
}

impl<V> Directions<'_, V> {
    /// Returns the same vectors for a part of the step.
    #[inline(always)]
    pub(crate) fn reborrow(&mut self) -> Directions<'_, V> {
        Directions {
            fields: self.fields,
            parameters: self.parameters,
        }
    }
}

/// The derivative of a function of the states of a path, by a state and by the parameters in the
/// steps from this state on.
#[derive(Debug)]
pub struct Covector<'a, V> {
    /// The derivative by the state.
    pub state: &'a mut Field<V>,
    /// The derivative by each parameter.
    pub parameters: &'a mut [f64],
}

impl<V> Covector<'_, V> {
    /// Returns the same derivatives for a part of the step.
    #[inline(always)]
    pub(crate) fn reborrow(&mut self) -> Covector<'_, V> {
        Covector {
            state: self.state,
            parameters: self.parameters,
        }
    }
}

impl<'a> Linearisation<'a> {
    /// Stores ∂R/∂x, ∂R/∂z, ∂y/∂x, ∂y/∂z for the numbers of unknowns x, outputs y and inputs z.
    #[inline(always)]
    #[must_use]
    pub fn new(
        [unknowns, outputs, inputs]: [usize; 3],
        [rx, rz, yx, yz]: [Entries<'a>; 4],
    ) -> Self {
        Self {
            unknowns,
            outputs,
            inputs,
            residual_by_unknowns: rx,
            residual_by_inputs: rz,
            output_by_unknowns: yx,
            output_by_inputs: yz,
            intermediate_by_inputs: Entries::NONE,
            output_by_intermediates: Entries::NONE,
        }
    }

    /// Adds intermediate values w(z), at most as many as coordinates, by dw/dz and ∂y/∂w: the
    /// derivative of y is then `∂y/∂z + ∂y/∂w dw/dz`.
    #[inline(always)]
    #[must_use]
    pub fn through(self, [wz, yw]: [Entries<'a>; 2]) -> Self {
        Self {
            intermediate_by_inputs: wz,
            output_by_intermediates: yw,
            ..self
        }
    }

    /// Returns `dy/dz`. If `increments` is true, the results are differences from the state at the
    /// start, whose derivative is added.
    ///
    /// # Errors
    /// [`SolveError`] if ∂R/∂x is singular, or the result is not finite.
    pub(crate) fn solve(&self, increments: bool) -> Result<DMatrix<f64>, SolveError> {
        let [unknowns, outputs, inputs] = [self.unknowns, self.outputs, self.inputs];
        let moves = lu::solve(
            self.residual_by_unknowns.dense(unknowns, unknowns),
            self.residual_by_inputs.dense(unknowns, inputs),
        )?;
        let slopes = self.output_by_unknowns.dense(outputs, unknowns);
        let mut all = self.output_by_inputs.dense(outputs, inputs);
        if increments {
            (0..all.nrows()).for_each(|i| all[(i, i)] += 1.0);
        }
        let coordinates = outputs / 2;
        let intermediates = self.intermediate_by_inputs.dense(coordinates, inputs);
        self.output_by_intermediates.each(|row, w, value| {
            for column in 0..inputs {
                all[(row, column)] += value * intermediates[(w, column)];
            }
        });
        // The terms are added one by one: a product of matrices may contract operations, with other
        // bits on other machines.
        for column in 0..all.ncols() {
            for row in 0..all.nrows() {
                for k in 0..moves.nrows() {
                    all[(row, column)] -= slopes[(row, k)] * moves[(k, column)];
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

/// The unknowns of a step, `[f64; K]`, and the solution of its linearised equations. Nothing is
/// allocated.
pub trait Unknowns: Copy + AsRef<[f64]> + AsMut<[f64]> {
    /// The unknowns of each lane.
    type Lanes: KeepUnknowns;
    /// Returns memory for the unknowns of each lane.
    fn lanes() -> Self::Lanes;
    /// Carries tangent vectors along the step: `y ← dy/dz z`.
    ///
    /// # Errors
    /// As [`Linearisation::solve`]; the vectors are then invalid.
    fn push_forward<const N: usize>(
        linear: &Linearisation<'_>,
        increments: bool,
        directions: Directions<'_, [f64; N]>,
    ) -> Result<(), SolveError>;

    /// Carries derivatives by the result of the step back to its start: `λ ← (dy/dz)ᵀ λ`. The
    /// derivatives by the parameters are added to the earlier ones.
    ///
    /// # Errors
    /// As [`Linearisation::solve`]; the derivatives are then invalid.
    fn pull_back<const N: usize>(
        linear: &Linearisation<'_>,
        increments: bool,
        covector: Covector<'_, [f64; N]>,
    ) -> Result<(), SolveError>;
}

impl<const K: usize> Unknowns for [f64; K] {
    type Lanes = Aligned<[Lane; K]>;

    #[inline(always)]
    fn lanes() -> Self::Lanes {
        rows()
    }

    #[inline(always)]
    fn push_forward<const N: usize>(
        linear: &Linearisation<'_>,
        increments: bool,
        directions: Directions<'_, [f64; N]>,
    ) -> Result<(), SolveError> {
        let factors = factors::<K>(&linear.residual_by_unknowns, false)?;
        for (field, parameter) in directions.fields.iter_mut().zip(directions.parameters) {
            let before = *field;
            let input = |column: usize| match column.checked_sub(2 * N) {
                Some(varied) => f64::from(u8::from(*parameter == Some(varied))),
                None => *entry(&mut { before }, column),
            };
            let mut rhs = [0.0; K];
            linear.residual_by_inputs.each(|row, column, value| {
                rhs[row] += value * input(column);
            });
            let moves = factors.solve(&rhs);
            if !increments {
                *field = Field::ZERO;
            }
            linear.output_by_inputs.each(|row, column, value| {
                *entry(field, row) += value * input(column);
            });
            linear.output_by_unknowns.each(|row, unknown, value| {
                *entry(field, row) -= value * moves[unknown];
            });
            let mut intermediates = [0.0; N];
            linear.intermediate_by_inputs.each(|row, column, value| {
                intermediates[row] += value * input(column);
            });
            linear.output_by_intermediates.each(|row, w, value| {
                *entry(field, row) += value * intermediates[w];
            });
            finite(field)?;
        }
        Ok(())
    }

    #[inline(always)]
    fn pull_back<const N: usize>(
        linear: &Linearisation<'_>,
        increments: bool,
        covector: Covector<'_, [f64; N]>,
    ) -> Result<(), SolveError> {
        let factors = factors::<K>(&linear.residual_by_unknowns, true)?;
        let Covector { state, parameters } = covector;
        let mut after = *state;
        let mut rhs = [0.0; K];
        linear.output_by_unknowns.each(|row, unknown, value| {
            rhs[unknown] += value * *entry(&mut after, row);
        });
        let multipliers = factors.solve(&rhs);
        if !increments {
            *state = Field::ZERO;
        }
        let mut add = |column: usize, term: f64| match column.checked_sub(2 * N) {
            Some(parameter) => parameters[parameter] += term,
            None => *entry(state, column) += term,
        };
        linear.output_by_inputs.each(|row, column, value| {
            add(column, value * *entry(&mut after, row));
        });
        linear.residual_by_inputs.each(|row, column, value| {
            add(column, -value * multipliers[row]);
        });
        let mut intermediates = [0.0; N];
        linear.output_by_intermediates.each(|row, w, value| {
            intermediates[w] += value * *entry(&mut after, row);
        });
        linear.intermediate_by_inputs.each(|row, column, value| {
            add(column, value * intermediates[row]);
        });
        finite(state)?;
        if parameters.iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            Err(SolveError::NonFinite)
        }
    }
}

/// Returns the factors of a square matrix or of its transpose.
#[inline(always)]
fn factors<const K: usize>(
    matrix: &Entries<'_>,
    transposed: bool,
) -> Result<Factors<K>, SolveError> {
    let mut dense = [[0.0; K]; K];
    matrix.each(|row, column, value| {
        if transposed {
            dense[column][row] = value;
        } else {
            dense[row][column] = value;
        }
    });
    factored(&dense).ok_or(SolveError::Singular { iteration: 0 })
}

/// Returns the component with this number of a vector of phase space: the components along q come
/// first, then the components along p.
#[inline(always)]
fn entry<const N: usize>(field: &mut Field<[f64; N]>, number: usize) -> &mut f64 {
    if number < N {
        &mut field.q[number]
    } else {
        &mut field.p[number - N]
    }
}

#[inline(always)]
fn finite<const N: usize>(field: &Field<[f64; N]>) -> Result<(), SolveError> {
    if field.q.iter().chain(&field.p).all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(SolveError::NonFinite)
    }
}
