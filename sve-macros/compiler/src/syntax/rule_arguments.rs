//! The arguments of one rule in the attribute: the number of stages of a family, then options, as
//! in `gauss(3, stage_noise, weak2)`.
//!
//! [`RuleArguments::read`] parses the tokens; [`resolve`] finds the rule that they name, or reports
//! what to write instead.

use proc_macro2::Span;
use syn::parse::ParseBuffer;
use syn::{Ident, LitInt, Token, token::Paren};

use super::arguments::ListedRule;
use crate::catalogue::{Rule, RuleOption, names, written};
use crate::errors::{Errors, nearest};

/// The arguments in the parentheses after the name of a rule.
pub(super) struct RuleArguments {
    parentheses: Paren,
    arguments: Vec<Argument>,
}

enum Argument {
    Number(LitInt),
    Word(Ident),
}

impl Argument {
    fn place(&self) -> Span {
        match self {
            Self::Number(number) => number.span(),
            Self::Word(word) => word.span(),
        }
    }
}

impl RuleArguments {
    pub(super) fn read(
        name: &Ident,
        parentheses: Paren,
        content: &ParseBuffer<'_>,
        all: &[Rule],
    ) -> syn::Result<Self> {
        let mut arguments = Vec::new();
        while !content.is_empty() {
            let argument = if content.peek(LitInt) {
                content.parse().map(Argument::Number)
            } else {
                content.parse().map(Argument::Word)
            };
            let expected = |_| syn::Error::new(content.span(), expected(name, all));
            arguments.push(argument.map_err(expected)?);
            if !content.is_empty() {
                content.parse::<Token![,]>().map_err(expected)?;
            }
        }
        Ok(Self {
            parentheses,
            arguments,
        })
    }
}

/// Returns the rules with a name, in ascending numbers of stages.
fn members(name: &Ident, all: &[Rule]) -> Vec<Rule> {
    let members = all.iter().filter(|rule| name == rule.attribute_name);
    members.copied().collect()
}

/// Returns the member of a family that messages show as an example.
fn example(family: &[Rule]) -> Rule {
    family[2.min(family.len() - 1)]
}

/// Returns the member of a family whose number is among the arguments, if there is one.
fn meant(family: &[Rule], arguments: &[Argument]) -> Rule {
    let mut numbers = arguments.iter().enumerate().filter_map(number);
    let stages = numbers.find_map(|(_, number)| number.base10_parse().ok());
    let member = family
        .iter()
        .find(|rule| stages.is_some() && rule.stages() == stages);
    member.copied().unwrap_or_else(|| example(family))
}

/// Returns the message for a token that is neither a number nor a word.
fn expected(name: &Ident, all: &[Rule]) -> String {
    let members = members(name, all);
    let rule = example(&members);
    let with_options = rule
        .takes
        .options
        .iter()
        .fold(rule, |rule, &o| rule.with(o));
    match (rule.stages(), rule.takes.options) {
        (None, []) => format!("`{name}` takes no arguments: write `{}`", rule.name()),
        (None, _) => format!(
            "expected options, separated by commas, as in `{}`",
            with_options.name()
        ),
        (Some(_), []) => format!("expected the number of stages, as in `{}`", rule.name()),
        (Some(_), _) => format!(
            "expected the number of stages and options, separated by commas, as in `{}` or `{}`",
            rule.name(),
            with_options.name()
        ),
    }
}

/// Returns the rule that a name and its arguments denote; `None` after an error.
pub(super) fn resolve(
    name: &Ident,
    arguments: Option<&RuleArguments>,
    all: &[Rule],
    errors: &mut Errors,
) -> Option<ListedRule> {
    let members = members(name, all);
    let before = errors.count();
    let given = arguments.map_or(&[][..], |a| &a.arguments);
    let options = options(name, given, meant(&members, given), all, errors);
    let base = if members[0].stages().is_some() {
        member(name, arguments, &members, all, errors)
    } else {
        without_stages(name, arguments, &members, errors);
        Some(members[0])
    };
    let rule = options.iter().fold(base?, |rule, &(o, _)| rule.with(o));
    (errors.count() == before).then_some(ListedRule {
        rule,
        place: name.span(),
        options,
    })
}

/// Checks that a rule without stages has no number, and no empty parentheses.
fn without_stages(
    name: &Ident,
    arguments: Option<&RuleArguments>,
    members: &[Rule],
    errors: &mut Errors,
) {
    let Some(RuleArguments {
        parentheses,
        arguments,
    }) = arguments
    else {
        return;
    };
    if arguments.is_empty() {
        let message = format!("these parentheses are empty: write `{name}`");
        errors.push(parentheses.span.join(), message);
    }
    let instead = written(name.to_string().as_str(), &options_of(arguments));
    for argument in arguments {
        if let Argument::Number(number) = argument {
            let order = members[0].order;
            let message = format!(
                "`{name}` has no number of stages, and its order is {order}: write `{instead}`"
            );
            errors.push(number.span(), message);
        }
    }
}

/// Returns the member of a family with the number of stages in the arguments; `None` after an
/// error.
fn member(
    name: &Ident,
    arguments: Option<&RuleArguments>,
    family: &[Rule],
    all: &[Rule],
    errors: &mut Errors,
) -> Option<Rule> {
    let given = arguments.map_or(&[][..], |a| &a.arguments);
    let options = options_of(given);
    let write = |number: &str| {
        let arguments: Vec<String> = [vec![number.to_owned()], options.clone()].concat();
        written(&name.to_string(), &arguments)
    };
    let (at, number) = the_number(name, arguments, family, &write, errors)?;
    let mut refuse = |message: String| {
        errors.push(number.span(), message);
        None
    };
    let stages = number.base10_digits().parse::<usize>().ok();
    let found = family.iter().find(|rule| rule.stages() == stages);
    let Some(&rule) = found else {
        let message = match (stages, all.iter().find(|rule| rule.node() == Some(0.5))) {
            (Some(1), Some(midpoint)) => format!(
                "with one stage this is the rule `{}`: write `{}`",
                midpoint.attribute_name,
                written(midpoint.attribute_name, &options)
            ),
            _ => other_stages(name, number, family, &write),
        };
        return refuse(message);
    };
    if at > 0 || !number.suffix().is_empty() {
        let message = format!(
            "the number of stages comes first, without a suffix: write `{}`",
            write(number.base10_digits())
        );
        return refuse(message);
    }
    Some(rule)
}

/// Returns the number among the arguments of a family, and its position; `None` after an error.
fn the_number<'a>(
    name: &Ident,
    arguments: Option<&'a RuleArguments>,
    family: &[Rule],
    write: &impl Fn(&str) -> String,
    errors: &mut Errors,
) -> Option<(usize, &'a LitInt)> {
    let first_and_last = [family.first()?, family.last()?];
    let [least, most] = first_and_last.map(|rule| rule.stages().unwrap_or_default());
    let given = arguments.map_or(&[][..], |a| &a.arguments);
    let numbers: Vec<(usize, &LitInt)> = given.iter().enumerate().filter_map(number).collect();
    let (place, message) = match numbers.as_slice() {
        &[number] => return Some(number),
        [] => {
            let place = match arguments {
                Some(empty) if given.is_empty() => empty.parentheses.span.join(),
                _ => name.span(),
            };
            let example = example(family);
            let stages = example.stages().unwrap_or_default().to_string();
            let message = format!(
                "`{name}` needs its number of stages, {least} to {most}: write `{}`, which has order {}",
                write(&stages),
                example.order
            );
            (place, message)
        }
        [(_, first), (_, second), ..] => {
            let message = format!(
                "`{name}` takes one number, that of its stages: write `{}`",
                write(&first.to_string())
            );
            (second.span(), message)
        }
    };
    errors.push(place, message);
    None
}

/// Returns the message for a number of stages that a family does not have. The user may have meant
/// the order.
fn other_stages(
    name: &Ident,
    number: &LitInt,
    family: &[Rule],
    write: &impl Fn(&str) -> String,
) -> String {
    let digits = number.base10_digits();
    let is_order = |rule: &&Rule| rule.order.to_string() == digits;
    let end = if digits == "0" || digits.starts_with('-') {
        &family[0]
    } else {
        &family[family.len() - 1]
    };
    let meant = family.iter().find(is_order).unwrap_or(end);
    let stages = |rule: &Rule| rule.stages().unwrap_or_default();
    format!(
        "the number is that of the stages, of which `{name}` has {} to {}, and the order is twice this number: write `{}`, which has order {}",
        stages(&family[0]),
        stages(&family[family.len() - 1]),
        write(&stages(meant).to_string()),
        meant.order
    )
}

fn number((at, argument): (usize, &Argument)) -> Option<(usize, &LitInt)> {
    match argument {
        Argument::Number(number) => Some((at, number)),
        Argument::Word(_) => None,
    }
}

/// Returns the options among arguments, as the source spells them.
fn options_of(arguments: &[Argument]) -> Vec<String> {
    let words = arguments.iter().filter_map(|argument| match argument {
        Argument::Word(word) => Some(word.to_string()),
        Argument::Number(_) => None,
    });
    words.collect()
}

/// Returns the options among the arguments, with their places.
fn options(
    name: &Ident,
    arguments: &[Argument],
    rule: Rule,
    all: &[Rule],
    errors: &mut Errors,
) -> Vec<(RuleOption, Span)> {
    let mut found: Vec<(RuleOption, Span)> = Vec::new();
    for argument in arguments {
        let (Argument::Word(word), place) = (argument, argument.place()) else {
            continue;
        };
        let word = word.to_string();
        match RuleOption::named(&word) {
            None => errors.push(place, unknown_option(name, &word, rule)),
            Some(option) if !rule.takes.options.contains(&option) => {
                errors.push(place, not_taken(name, option, rule, all));
            }
            Some(option) if found.iter().any(|(other, _)| *other == option) => {
                let message = format!("the option `{word}` is written twice: remove one");
                errors.push(place, message);
            }
            Some(option) => found.push((option, place)),
        }
    }
    found
}

/// Returns the options of a rule as a part of a sentence; `None` if there are none.
fn taken(rule: Rule) -> Option<String> {
    let options = rule.takes.options.iter();
    let names: Vec<String> = options.map(|o| format!("`{}`", o.name())).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

fn unknown_option(name: &Ident, word: &str, rule: Rule) -> String {
    let options = rule.takes.options.iter().map(|option| option.name());
    match (nearest(word, options), taken(rule)) {
        (Some(near), _) => format!("there is no option `{word}`; did you mean `{near}`?"),
        (None, Some(taken)) => {
            format!("there is no option `{word}`; the options of `{name}` are {taken}")
        }
        (None, None) => format!("`{name}` takes no options: write `{}`", rule.name()),
    }
}

/// Returns the message for an option that only other rules have.
fn not_taken(name: &Ident, option: RuleOption, rule: Rule, all: &[Rule]) -> String {
    let takes = |other: &Rule| other.takes.options.contains(&option);
    let others: Vec<Rule> = all.iter().copied().filter(takes).collect();
    let others = names(&others).join(", ");
    let option = option.name();
    match (taken(rule), others.is_empty()) {
        (Some(taken), true) => format!(
            "`{name}` does not take the option `{option}`; the options of `{name}` are {taken}"
        ),
        (Some(taken), false) => format!(
            "`{name}` does not take the option `{option}`, which is one of {others}; the options of `{name}` are {taken}"
        ),
        (None, true) => format!("`{name}` takes no options: write `{}`", rule.name()),
        (None, false) => format!(
            "`{name}` takes no options: write `{}`; `{option}` is an option of {others}",
            rule.name()
        ),
    }
}

#[cfg(test)]
mod tests;
