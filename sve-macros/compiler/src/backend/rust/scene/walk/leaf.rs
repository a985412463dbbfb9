//! The code that the loops print in each instance.

use crate::algebra::Expr;
use crate::model::scene::{Int, SumId};
use crate::scene::Summand;

/// A summand in print.
pub(in super::super) struct Leaf {
    pub(in super::super) sum: Option<SumId>,
    /// The values to be computed.
    pub(in super::super) values: Vec<Expr>,
    /// Expressions that must be positive: the values are NaN elsewhere.
    pub(in super::super) conditions: Vec<Expr>,
    pub(in super::super) action: Action,
}

impl Leaf {
    /// A summand that is added to `value`.
    pub(in super::super) fn value(summand: &Summand) -> Self {
        Self {
            sum: summand.sum,
            values: vec![summand.value],
            conditions: summand.conditions.clone(),
            action: Action::AddValue,
        }
    }
}

/// The use of the values of a summand.
pub(in super::super) enum Action {
    /// The values, a row each, are added to these sites, of the array `to`.
    AddRows(Vec<Int>),
    /// The value is added to a component of a site, of the array `to`.
    AddComponent(Int, usize),
    /// The value is added to `value`.
    AddValue,
    /// The sites and columns of a term are shown to a visitor `to`.
    Visit(usize),
    /// The site and columns of a term of the kinetic energy are shown to a visitor `to`.
    VisitKinetic(usize),
}
