//! The settings of a study, complete and checked.
//!
//! Input: a [`Study`]. Output: [`Settings`], or an error that contains the remedy.

use super::any_method::AnyMethod;
use super::reference::Reference;
use super::{Study, StudyError};
use crate::system::{Increments as _, IncrementsOf, StateOf, System};

/// The settings of a study, complete and checked.
pub(super) struct Settings<'a, S: System> {
    pub(super) study: &'a Study<'a, S>,
    pub(super) start: &'a StateOf<S>,
    pub(super) horizon: f64,
    pub(super) reference: &'a Reference<'a, S>,
    pub(super) finest: usize,
    pub(super) paths: u64,
    pub(super) processes: usize,
    /// The most stages of a method with stage noise; 1 without.
    pub(super) stages: usize,
}

impl<'a, S: System> Settings<'a, S> {
    /// Checks the settings.
    pub(super) fn new(study: &'a Study<'a, S>) -> Result<Self, StudyError> {
        let processes = <IncrementsOf<S>>::PROCESSES;
        let missing = |what, write| StudyError::Missing { what, write };
        let names = study.methods.iter().map(|m| m.name.to_string());
        refuse_duplicates("methods", names)?;
        let names = study.observables.iter().map(|o| o.name.to_string());
        refuse_duplicates("observables", names)?;
        let horizon = study.horizon.ok_or(missing("horizon", ".horizon(10.0)"))?;
        if !(horizon > 0.0 && horizon.is_finite()) {
            return Err(StudyError::Horizon { horizon });
        }
        if study.methods.is_empty() {
            return Err(missing("methods", ".method(\"midpoint\", &integrator)"));
        }
        let methods = 0..study.methods.len();
        let finest = methods
            .clone()
            .flat_map(|method| study.steps_of(method))
            .max();
        let finest = *finest.ok_or(missing("numbers of steps", ".step_counts([64, 128, 256])"))?;
        for method in methods {
            check_steps(study.steps_of(method), finest, processes)?;
        }
        if study.paths == 0 {
            return Err(StudyError::Zero { setting: "paths" });
        }
        let reference = study.reference.as_ref().ok_or(missing(
            "reference",
            ".fine(&integrator, 16)` or `.exact(|path| …)",
        ))?;
        let mut stages = 1;
        if let Reference::Fine(method, factor) = *reference {
            check_fine(study, method, factor, finest)?;
            stages = method.stages();
        }
        let of_methods = study.methods.iter().map(|m| m.method.stages());
        let stages = of_methods.fold(stages, usize::max);
        Ok(Self {
            study,
            start: study
                .start
                .as_ref()
                .ok_or(missing("start", ".start(State::new([1.0], [0.0]))"))?,
            horizon,
            reference,
            finest,
            paths: if processes == 0 { 1 } else { study.paths },
            processes,
            stages,
        })
    }
}

/// Checks the numbers of steps of a method. With noise they divide the largest number of all
/// methods.
fn check_steps(numbers: &[usize], finest: usize, processes: usize) -> Result<(), StudyError> {
    refuse_duplicates("steps", numbers.iter().map(usize::to_string))?;
    for &steps in numbers {
        if steps == 0 {
            return Err(StudyError::Zero { setting: "steps" });
        }
        if processes > 0 && !finest.is_multiple_of(steps) {
            return Err(StudyError::Steps { steps, finest });
        }
    }
    Ok(())
}

/// Checks that the steps of a fine reference can be counted, and that the reference is none of the
/// methods with the same steps: the error of that method would be 0, and the errors of the others
/// too small.
fn check_fine<S: System>(
    study: &Study<'_, S>,
    reference: &dyn AnyMethod<S>,
    factor: usize,
    finest: usize,
) -> Result<(), StudyError> {
    if factor == 0 {
        return Err(StudyError::Zero { setting: "fine" });
    }
    if finest.checked_mul(factor).is_none() {
        return Err(StudyError::TooFine { finest, factor });
    }
    let own = study
        .methods
        .iter()
        .find(|candidate| factor == 1 && candidate.method.identity() == reference.identity());
    match own {
        None => Ok(()),
        Some(candidate) => Err(StudyError::OwnReference {
            method: candidate.name.to_string(),
            steps: finest,
        }),
    }
}

/// Returns an error if a name occurs twice.
fn refuse_duplicates(
    what: &'static str,
    names: impl Iterator<Item = String>,
) -> Result<(), StudyError> {
    let mut seen = Vec::new();
    for name in names {
        if seen.contains(&name) {
            return Err(StudyError::Twice { what, name });
        }
        seen.push(name);
    }
    Ok(())
}
