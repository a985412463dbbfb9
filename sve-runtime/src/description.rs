//! The description of a run for pages: the system with its parameters, the method, steps, paths and
//! seeds.
//!
//! Input: a method. Output: names and values. Invariant: descriptions decide nothing; fingerprints
//! identify runs.

use core::any::type_name;

use crate::system::System;

/// Largest number of parameters that are described.
const MOST_PARAMETERS: usize = 60;

/// The name of a system, and the values of its parameters.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SystemDescription {
    pub(crate) name: String,
    /// The names of the first parameters, as in the source.
    pub(crate) parameters: Vec<String>,
    /// The values of these parameters.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(crate) values: Vec<f64>,
    /// Number of further parameters.
    pub(crate) others: u64,
}

impl SystemDescription {
    pub(crate) fn of<S: System>(system: &S) -> Self {
        let mut values = Vec::new();
        system.parameters(&mut |value| values.push(value));
        // inputs that come from a function have no value of their own
        let inputs = values.iter().take(S::INPUTS);
        let unknown = inputs.take_while(|u| u.is_nan()).count();
        values.drain(..unknown);
        let others = values.len().saturating_sub(MOST_PARAMETERS);
        values.truncate(MOST_PARAMETERS);
        let names = S::PARAMETERS.iter().skip(unknown).take(values.len());
        Self {
            name: short_name::<S>(),
            parameters: names.map(|&name| name.to_owned()).collect(),
            values,
            others: others as u64,
        }
    }
}

/// The system, the method and the increments of the paths of an ensemble.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct RunDescription {
    pub(crate) system: SystemDescription,
    pub(crate) method: String,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub(crate) h: f64,
    pub(crate) steps: u64,
    /// The kind of the increments.
    pub(crate) noise: String,
    /// The seed of the increments.
    pub(crate) seed: u64,
    /// The seed of random starts.
    pub(crate) start_seed: u64,
}

/// Returns the name of a type without the paths of its parts: `Chain<3>` for `&models::Chain<3>`.
fn short_name<T: ?Sized>() -> String {
    let mut short = String::new();
    // The place where the last path begins.
    let mut start = 0;
    for character in type_name::<T>().trim_start_matches('&').chars() {
        match character {
            ':' => short.truncate(start),
            _ if character.is_alphanumeric() || character == '_' => short.push(character),
            _ => {
                short.push(character);
                start = short.len();
            }
        }
    }
    let held = short.strip_prefix("__WithInputs<");
    let held = held.and_then(|held| held.strip_suffix('>'));
    held.map_or_else(|| short.clone(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_types_have_no_paths() {
        assert_eq!(
            short_name::<&Option<std::path::PathBuf>>(),
            "Option<PathBuf>"
        );
        assert_eq!(short_name::<[std::vec::Vec<f64>; 3]>(), "[Vec<f64>; 3]");
        assert_eq!(short_name::<f64>(), "f64");
    }
}
