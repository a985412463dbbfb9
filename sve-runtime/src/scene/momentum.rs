//! Momenta of symmetries.

use core::ops::AddAssign;

use super::IndexError;
use super::errors::{check_length, index_error};
use crate::error::StepError;
use crate::phase::configuration::Site;
use crate::phase::state::State;

/// Number of partial sums. It is fixed, so that a sum has the same bits on every machine.
const PARTS: usize = 8;

/// A sum whose terms are added to one partial sum after the other.
#[derive(Default)]
pub struct PartialSums {
    parts: [f64; PARTS],
    next: usize,
}

impl AddAssign<f64> for PartialSums {
    #[inline(always)]
    fn add_assign(&mut self, term: f64) {
        self.parts[self.next % PARTS] += term;
        self.next += 1;
    }
}

impl PartialSums {
    /// Returns the sum of the partial sums, which are added in pairs.
    #[inline(always)]
    pub fn total(self) -> f64 {
        let mut parts = self.parts;
        let mut half = PARTS / 2;
        while half > 0 {
            for at in 0..half {
                parts[at] += parts[at + half];
            }
            half /= 2;
        }
        parts[0]
    }
}

/// Returns a momentum ⟨p, ξ⟩ that `sum` adds from the time and the rows of q and p, of the
/// generator `name` with `entries` entries.
///
/// # Errors
/// [`StepError::Length`] if there are not as many momenta or entries as sites, and
/// [`StepError::Index`].
pub fn momentum<Q: Site>(
    state: &State<Vec<Q>>,
    name: &'static str,
    entries: impl FnOnce(usize) -> Result<i64, IndexError>,
    sum: impl FnOnce(usize, f64, &[Q::Row], &[Q::Row]) -> Result<PartialSums, IndexError>,
) -> Result<f64, StepError> {
    let State { t, q, p } = state;
    let (t, n) = (*t, q.len());
    check_length("p", p.len(), n, t)?;
    let entries = entries(n).map_err(|error| index_error(error, t))?;
    let entries = usize::try_from(entries).unwrap_or_default();
    check_length(&format!("the result of `{name}`"), entries, n, t)?;
    let sum = sum(n, t, Q::rows(q), Q::rows(p));
    Ok(sum.map_err(|error| index_error(error, t))?.total())
}
