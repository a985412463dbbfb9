//! Functions of a scene that return an entry for each site: forces, and the generators of
//! symmetries.

use crate::algebra::Symbol;
use crate::interpret::Lowering;
use crate::interpret::types::Shape;
use crate::interpret::value::Value;
use crate::model::scene::{SiteField, Sum};
use crate::syntax::parse::RoleFunction;
use crate::syntax::readable;
use crate::syntax::roles::Role;
use crate::syntax::signature::{entry_of_slice, entry_of_vec};

use super::kept::Body;

/// A function that returns an entry for each site, with the sum of each component.
pub(super) type OnSites<'b> = (&'b RoleFunction, Vec<Option<Symbol>>);

impl Lowering<'_> {
    /// Executes functions that return an entry for each site. Returns them with the sum of each
    /// component; `None` for one that is zero.
    pub(super) fn on_sites<'b>(
        &mut self,
        functions: impl IntoIterator<Item = &'b RoleFunction>,
        time: Symbol,
    ) -> Vec<OnSites<'b>> {
        let found = functions.into_iter().filter_map(|function| {
            let result = self.run_scene(function, time);
            Some((function, self.components_on_sites(function, result)?))
        });
        found.collect()
    }

    pub(super) fn placed_on_sites(
        &mut self,
        functions: Vec<OnSites<'_>>,
        sums: &mut Vec<Sum>,
    ) -> Option<Vec<SiteField>> {
        let placed = functions.into_iter().map(|(function, components)| {
            let components = components.into_iter().map(|sum| match sum {
                Some(sum) => self.placed_root(sum, sums).map(Some),
                None => Some(None),
            });
            Some(SiteField {
                components: components.collect::<Option<_>>()?,
                name: function.name.to_string(),
                at: function.name.span(),
                is_noise: function.role == Role::NoiseForce,
            })
        });
        placed.collect()
    }

    fn components_on_sites(
        &mut self,
        function: &RoleFunction,
        value: Value,
    ) -> Option<Vec<Option<Symbol>>> {
        let of_site = entry_of_slice(self.block.coordinates())?;
        let entry = match entry_of_vec(&function.output) {
            Some(entry) => self.shape(entry),
            None => None,
        };
        let shape = self.scene.shape.clone()?;
        if entry.as_ref() != Some(&shape) {
            let what = match function.role {
                Role::Symmetry => "a generator",
                _ => "a force",
            };
            let message = format!(
                "{what} has an entry for each site: return `Vec<{}>`",
                readable(of_site)
            );
            return self.refuse(&function.output, message);
        }
        self.components_of_entries(function, value, &shape)
    }

    /// Returns the sum of each component of the entries of a `Vec` that a function returns; `None`
    /// for a component that is zero.
    pub(super) fn components_of_entries(
        &mut self,
        function: &RoleFunction,
        value: Value,
        shape: &Shape,
    ) -> Option<Vec<Option<Symbol>>> {
        let (stream, at) = self.collected(function, value)?;
        let body = Body::none("i");
        let mut components = Vec::new();
        let sums = self.rounds(&stream, at, &body, |x, value| {
            x.entries(&value, shape, &at, &mut components)?;
            let numbers = components.iter().map(|&number| Value::Scalar(number));
            Some(Value::Array(numbers.collect()))
        })?;
        let sums = sums.items().iter();
        let sums = sums.map(|sum| match sum {
            Value::Scalar(sum) => {
                let mut symbols = self.arena.symbols_of(*sum);
                symbols.find(|&symbol| self.kept_sum(symbol).is_some())
            }
            _ => None,
        });
        Some(sums.collect())
    }
}
