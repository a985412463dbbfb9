//! Derivatives of a step: the tangent map, and the sensitivity to each parameter
//! (`docs/mathematics.md`, section 8).
//!
//! Input: the linearised step that the macro generated. Output:
//! `dy/dz = ∂y/∂z − ∂y/∂x (∂R/∂x)⁻¹ ∂R/∂z` for the results y, the unknowns x with their residuals
//! R, and z the state at the start with the parameters (implicit-function theorem).

use core::ops::{Index, Mul};

use nalgebra::{DMatrix, SMatrix};

use super::Integrator;
use super::modes::SingleMode;
use super::step::solve_step;
use super::steps::walk_from;
use crate::error::{StepError, step_error};
use crate::method::OneStepMethod;
use crate::phase::Field;
use crate::phase::configuration::{Coordinates, FixedSize};
use crate::phase::state::State;
use crate::rule::{Rule, Walker};
use crate::system::equations::{Memory, StepEquations};
use crate::system::start::Tested;
use crate::system::{AnyIncrements, Dims, System};

/// The tangent map of a step, `∂(q₁,p₁)/∂(q₀,p₀)`: a matrix of `2N` rows and columns, first the
/// coordinates, then the momenta.
///
/// A rotation has canonical coordinates near each of its states: the vector ε of a small
/// rotation R exp(ε̂), in the body frame, and the conjugate momentum y, with `δy = δΠ + ½ ε × Π` to
/// first order. A [`Sensitivity`] has the same coordinates.
///
/// `tangent[row][column]` is an entry, and [`qq`](Self::qq), [`qp`](Self::qp), [`pq`](Self::pq) and
/// [`pp`](Self::pp) are the four blocks. The product of the maps of successive steps, the later one
/// on the left, is the map of all.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent<const N: usize> {
    /// The entries, row by row.
    entries: Vec<f64>,
}

/// The derivatives of `(q₁, p₁)` with respect to the parameters of the system; `V` is the type of
/// its momenta.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity<V> {
    names: &'static [&'static str],
    fields: Vec<Field<V>>,
}

impl<const N: usize> Tangent<N> {
    /// Returns the identity map.
    #[must_use]
    pub fn identity() -> Self {
        let mut entries = vec![0.0; 4 * N * N];
        for i in 0..2 * N {
            entries[i * (2 * N + 1)] = 1.0;
        }
        Self { entries }
    }

    /// Returns the change of the result for a small change of the start.
    #[must_use]
    pub fn apply<V>(&self, change: &Field<V>) -> Field<V>
    where
        V: FixedSize<Momentum = V>,
    {
        let [along_q, along_p] = [row::<V, N>(&change.q), row::<V, N>(&change.p)];
        let image = |row: usize| -> f64 {
            let terms = self[row].iter().zip(along_q.iter().chain(&along_p));
            terms.map(|(a, b)| a * b).sum()
        };
        Field {
            q: from_row::<V, N>(&core::array::from_fn(image)),
            p: from_row::<V, N>(&core::array::from_fn(|i| image(N + i))),
        }
    }

    /// Returns `∂q₁/∂q₀`.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator;
    ///
    /// #[variational(endpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
    ///         0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (q[0] * q[0] + 4.0 * q[1] * q[1])
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let oscillator = Integrator::new(Oscillator, Endpoint);
    /// let tangent = oscillator.tangent(&State::new([1.0, 0.0], [0.0, 1.0]), 0.5, &[])?;
    /// // q₁ = q₀ + h p₀, p₁ = p₀ − h k q₁
    /// assert_eq!(tangent.qq(), Matrix2::identity());
    /// assert_eq!(tangent.qp(), 0.5 * Matrix2::identity());
    /// assert_eq!(tangent.pq(), Matrix2::new(-0.5, 0.0, 0.0, -2.0));
    /// assert_eq!(tangent.to_dmatrix().determinant(), 1.0);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn qq(&self) -> SMatrix<f64, N, N> {
        self.block(0, 0)
    }

    /// Returns `∂q₁/∂p₀`.
    #[must_use]
    pub fn qp(&self) -> SMatrix<f64, N, N> {
        self.block(0, N)
    }

    /// Returns `∂p₁/∂q₀`.
    #[must_use]
    pub fn pq(&self) -> SMatrix<f64, N, N> {
        self.block(N, 0)
    }

    /// Returns `∂p₁/∂p₀`.
    #[must_use]
    pub fn pp(&self) -> SMatrix<f64, N, N> {
        self.block(N, N)
    }

    /// Returns the block with its first entry in this row and column.
    fn block(&self, row: usize, column: usize) -> SMatrix<f64, N, N> {
        SMatrix::from_fn(|i, j| self[row + i][column + j])
    }

    /// Returns the whole map as a matrix of `2N` rows and columns, for nalgebra's decompositions.
    #[must_use]
    pub fn to_dmatrix(&self) -> DMatrix<f64> {
        DMatrix::from_row_slice(2 * N, 2 * N, &self.entries)
    }

    /// Returns the largest entry of `MᵀΩM − Ω`, which is zero for a symplectic map.
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

    /// Returns a row.
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

impl<V> Sensitivity<V> {
    /// Returns the derivative with respect to a parameter, by its name in the source without
    /// `self`: `k`, `l[0]`, `body.mass`. `None` if L, the noises and the force have no such
    /// parameter.
    #[must_use]
    pub fn get(&self, parameter: &str) -> Option<&Field<V>> {
        let at = self.names.iter().position(|&name| name == parameter)?;
        self.fields.get(at)
    }

    /// Returns the parameters with their derivatives.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Field<V>)> {
        self.names.iter().copied().zip(&self.fields)
    }

    /// Advances the derivatives by a further step, given the tangent map and the derivatives of
    /// that step: `S ← M S + s`.
    pub fn advance<const N: usize>(&mut self, tangent: &Tangent<N>, step: &Self)
    where
        V: FixedSize<Momentum = V>,
    {
        for (total, own) in self.fields.iter_mut().zip(&step.fields) {
            *total = tangent.apply(total);
            total.q.retract(&row::<V, N>(&own.q));
            total.p.retract(&row::<V, N>(&own.p));
        }
    }
}

/// Returns the components of an element of a vector space.
fn row<V: FixedSize, const N: usize>(x: &V) -> [f64; N] {
    const { assert!(V::STORED_VALUES == N, "another number of components") }
    let mut row = [0.0; N];
    x.store(&mut row);
    row
}

/// Returns the element of a vector space with these components.
fn from_row<V: FixedSize, const N: usize>(row: &[f64; N]) -> V {
    const { assert!(V::STORED_VALUES == N, "another number of components") }
    let mut x = V::origin();
    x.restore(row);
    x
}

/// Makes one step and computes its derivatives.
pub(crate) fn derivatives<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    state: &mut State<Q>,
    h: f64,
    dw: &R::Increments,
) -> Result<(Tangent<N>, Sensitivity<Q::Momentum>), StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    let prepared = integrator.prepare(h)?;
    let mode = Derivatives { all: None };
    let walk = |state: &mut _| walk_from(integrator.walker(), &prepared, state, h, dw, mode);
    let Derivatives { all } = Q::in_coordinates(state, walk)?;
    let all = all.unwrap_or_else(|| DMatrix::identity(2 * N, 2 * N + S::PARAMETERS.len()));
    // The matrix is stored column by column, so its transpose is the map row by row.
    let tangent = Tangent {
        entries: all.columns(0, 2 * N).transpose().as_slice().to_vec(),
    };
    let field = |parameter: usize| {
        Field::<[f64; N]>::of::<Q>(Field {
            q: core::array::from_fn(|i| all[(i, 2 * N + parameter)]),
            p: core::array::from_fn(|i| all[(N + i, 2 * N + parameter)]),
        })
    };
    let sensitivity = Sensitivity {
        names: S::PARAMETERS,
        fields: (0..S::PARAMETERS.len()).map(field).collect(),
    };
    Ok((tangent, sensitivity))
}

/// The mode that makes steps and computes the derivatives of their result: rows by `(q₁, p₁)`,
/// columns by `(q₀, p₀)` and the parameters.
struct Derivatives {
    /// The derivatives of the substeps so far.
    all: Option<DMatrix<f64>>,
}

impl<S, I, Q, const N: usize, const M: usize> SingleMode<S, I> for Derivatives
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    Q: Coordinates<N>,
{
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        _: &mut S::Memory,
        state: &mut State<Q::Flat>,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>,
    {
        let (mut end, memory) = (*state, &mut S::Memory::none());
        let unknowns = solve_step(walker, prepared, memory, &mut end, h, dw)?;
        let solved = (walker.system).linearise(state, h, dw, &unknowns, |linear| {
            linear.solve(!S::RETURNS.is_state())
        });
        let step = solved.map_err(|error| step_error(error, state, h, dw.as_ref()))?;
        self.all = Some(match self.all.take() {
            None => step,
            Some(before) => chained::<N>(&step, &before, S::PARAMETERS.len()),
        });
        *state = end;
        Ok(())
    }
}

/// Returns the derivatives of the result of a substep, from the derivatives of the substep and of
/// its start.
#[inline]
fn chained<const N: usize>(
    step: &DMatrix<f64>,
    before: &DMatrix<f64>,
    parameters: usize,
) -> DMatrix<f64> {
    let (size, columns) = (2 * N, 2 * N + parameters);
    // Term by term: a product of matrices may contract operations, with other bits on other
    // machines.
    DMatrix::from_fn(size, columns, |row, column| {
        let direct = if column < size {
            0.0
        } else {
            step[(row, column)]
        };
        (0..size).fold(direct, |sum, k| sum + step[(row, k)] * before[(k, column)])
    })
}
