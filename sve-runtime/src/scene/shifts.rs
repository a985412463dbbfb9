//! Noises H₁ in steps of the midpoint rule.
//!
//! With the motion y = h v/2 of a node by its velocity, which has the momentum M v, and with the
//! displacements X = Σ ΔW ∂H₁/∂p and the impulses K = −Σ ΔW ∂H₁/∂q at the node m and this momentum,
//!
//! ```text
//! y = f (p₀ + (I + K)/2)/2,   m = q₀ + y + X/2
//! ```
//!
//! A sweep computes y from m, and then m from both. In the norm of the largest of |δm| and |δy|/θ
//! it contracts by at most the larger one of θ a + c and b/θ + e, where
//!
//! ```text
//! a = 1 + max |M/h| Σ |∂X/∂p|,   b = max |f/4| Σ |∂(I + K)/∂q|
//! c = max ½ Σ |∂X/∂q|,           e = max |f/2| |M/h| Σ |∂K/∂p|
//! ```
//!
//! are bounds over boxes. If this is below 1, the solution in the boxes is unique. For the
//! increments s h and s ΔW each of the four is smaller, so that it is connected with the limit of
//! short steps.

use super::masses::InverseMasses;
use super::passes::{Factor, Factors, Largest, Pass};
use super::sweep::Kick;
use super::{Contributions, Impulses, InDrift, IndexError, Row, Scene, Slopes};

/// θ a, at least: without impulses the best θ is 0.
const LEAST: f64 = 0.05;

/// The arrays of the noises H₁ of a scene, of the components of rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Shifts {
    /// The displacements X.
    pub(super) displacements: Vec<f64>,
    /// The momenta M v of the nodes.
    pub(super) momenta: Vec<f64>,
    /// The boxes of the momenta.
    boxes: Vec<f64>,
    /// Bounds of the derivatives of K, or of X.
    bounds: Vec<f64>,
    /// The velocities v around which the boxes are.
    pub(super) around: Vec<f64>,
    /// The largest difference of their motions h v from those without impulses.
    pub(super) largest: f64,
}

/// The iteration of a step with H₁.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contraction {
    /// The bound of the ratio of successive errors.
    pub(super) ratio: f64,
    /// θ.
    pub(super) weight: f64,
}

/// The bounds of derivatives of K or X: the largest row sums by places and by momenta.
#[derive(Clone, Copy)]
struct Bound {
    places: f64,
    momenta: f64,
}

impl Shifts {
    pub(super) fn len(&self) -> usize {
        let Self {
            displacements,
            momenta,
            boxes,
            bounds,
            around,
            ..
        } = self;
        let arrays = [displacements, momenta, boxes, bounds, around];
        arrays.iter().map(|array| array.len()).sum()
    }

    /// Makes room for a solution with `numbers` components.
    pub(super) fn begin(&mut self, numbers: usize) {
        for array in [&mut self.displacements, &mut self.momenta, &mut self.around] {
            array.resize(numbers, 0.0);
        }
        for array in [&mut self.boxes, &mut self.bounds] {
            array.resize(2 * numbers, 0.0);
        }
    }

    /// Puts the boxes around velocities, whose motions differ by at most `largest` from those
    /// without impulses.
    pub(super) fn set_boxes(&mut self, v: &[f64], largest: f64) {
        self.around.copy_from_slice(v);
        self.largest = largest;
    }

    /// Writes the momenta of velocities.
    pub(super) fn set_momenta(&mut self, v: &[f64], masses: &InverseMasses) {
        for (at, (p, v)) in self.momenta.iter_mut().zip(v).enumerate() {
            *p = v / masses.of(at);
        }
    }

    /// Writes the momenta of the velocities `v`, the displacements X at the nodes `m` and these
    /// momenta, and moves the nodes with both. Returns the largest update of a node.
    ///
    /// # Errors
    /// An index that is out of range.
    pub(super) fn follow<S: Scene>(
        &mut self,
        scene: &S,
        Kick { h, t, dw }: Kick<'_>,
        masses: &InverseMasses,
        [q, v, m]: [&[f64]; 3],
        to: &mut [f64],
    ) -> Result<Largest, IndexError> {
        self.set_momenta(v, masses);
        self.displacements.fill(0.0);
        let shifts = S::Row::rows_mut(&mut self.displacements);
        let momenta = S::Row::rows_mut(&mut self.momenta);
        let part = InDrift::Shifts;
        Contributions::<Impulses>::in_drift(
            scene,
            part,
            h,
            t,
            dw,
            S::Row::rows(m),
            momenta,
            shifts,
        )?;
        let mut largest = Largest::default();
        for (at, to) in to.iter_mut().enumerate() {
            *to = q[at] + 0.5 * (h * v[at] + self.displacements[at]);
            largest.add(*to - m[at]);
        }
        Ok(largest)
    }

    /// Returns how a sweep contracts, from the bound of |f/4| Σ |∂I/∂q| and the boxes of nodes and
    /// velocities; a component for which the noises have no bounds, if there is one.
    ///
    /// # Errors
    /// An index that is out of range.
    pub(super) fn contraction<S>(
        &mut self,
        scene: &S,
        kick: Kick<'_>,
        factors: &Factors,
        masses: &InverseMasses,
        [nodes, velocities]: [&[<S as Contributions<Slopes>>::Numbers]; 2],
        of_impulses: f64,
    ) -> Result<Result<Contraction, usize>, IndexError>
    where
        S: Scene + Contributions<Slopes>,
    {
        let size = S::Row::LENGTH;
        let rows = self.boxes.chunks_exact_mut(2 * size).enumerate();
        for ((site, to), v) in rows.zip(velocities) {
            let v = Row::numbers(core::slice::from_ref(v));
            for k in 0..size {
                let mass = 1.0 / masses.of(site * size + k);
                to[k] = mass * v[k];
                to[size + k] = mass.abs() * v[size + k];
            }
        }
        let kicks = self.bounds(scene, kick, nodes, InDrift::Kicks)?;
        if let Some(at) = unbounded(kicks, size) {
            return Ok(Err(at));
        }
        let kicks = factors.pass(LargestSums(kicks, size));
        let shifts = self.bounds(scene, kick, nodes, InDrift::Shifts)?;
        if let Some(at) = unbounded(shifts, size) {
            return Ok(Err(at));
        }
        let shifts = LargestSums(shifts, size).run(1.0);
        let mass = masses.largest() / kick.h.abs();
        let a = 1.0 + mass * shifts.momenta;
        let b = of_impulses + 0.25 * kicks.places;
        let (c, e) = (0.5 * shifts.places, 0.5 * mass * kicks.momenta);
        let weight = (b / a).sqrt().max(LEAST / a);
        let ratio = (weight * a + c).max(b / weight + e);
        Ok(Ok(Contraction { ratio, weight }))
    }

    /// Computes bounds of the derivatives of K or X: the row sums of the magnitudes of those by
    /// places and of those by momenta, for each component.
    fn bounds<S>(
        &mut self,
        scene: &S,
        Kick { h, t, dw }: Kick<'_>,
        nodes: &[<S as Contributions<Slopes>>::Numbers],
        part: InDrift,
    ) -> Result<&[f64], IndexError>
    where
        S: Scene + Contributions<Slopes>,
    {
        let to = <S as Contributions<Slopes>>::Numbers::rows_mut(&mut self.bounds);
        let momenta = <S as Contributions<Slopes>>::Numbers::rows_mut(&mut self.boxes);
        to.fill(Row::ZERO);
        Contributions::<Slopes>::in_drift(scene, part, h, t, dw, nodes, momenta, to)?;
        Ok(&self.bounds)
    }
}

/// Returns the first component with a bound that is not finite.
fn unbounded(bounds: &[f64], size: usize) -> Option<usize> {
    let at = bounds.iter().position(|bound| !bound.is_finite())?;
    Some(at / (2 * size) * size + at % size)
}

/// The largest row sums in rows of this many components, times the factors of the components.
struct LargestSums<'a>(&'a [f64], usize);

impl Pass for LargestSums<'_> {
    type Output = Bound;

    #[inline(always)]
    fn run(self, factors: impl Factor) -> Bound {
        let Self(bounds, size) = self;
        let [mut places, mut momenta] = [Largest::default(); 2];
        for (site, row) in bounds.chunks_exact(2 * size).enumerate() {
            for k in 0..size {
                let factor = factors.of(site * size + k);
                places.add(factor * row[k]);
                momenta.add(factor * row[size + k]);
            }
        }
        Bound {
            places: places.value(),
            momenta: momenta.value(),
        }
    }
}
