//! The arguments of the attribute: rules with their own arguments, and the path of the runtime.
//!
//! Input: the tokens of the attribute. Output: [`Arguments`]. A mistake is reported at its token,
//! and a rule with a mistake is left out.

use proc_macro2::{Span, TokenStream};
use syn::parse::{ParseStream, Parser};
use syn::{Ident, Token};

use crate::catalogue::{self, Rule, RuleOption};
use crate::errors::{Errors, nearest};
use crate::syntax::rule_arguments::{self, RuleArguments};

/// The arguments of the attribute.
pub(crate) struct Arguments {
    pub(crate) rules: Vec<ListedRule>,
    /// Path of the runtime crate: `::sve_runtime`, or the path of `crate = path`.
    pub(crate) runtime: syn::Path,
    /// True if `reduced` stands in the attribute: functions and states do not contain the attitude
    /// of the bodies.
    pub(crate) is_reduced: bool,
}

/// A rule in the attribute, with the places of its tokens.
pub(crate) struct ListedRule {
    pub(crate) rule: Rule,
    /// The place of its name.
    pub(crate) place: Span,
    /// The options, each with its place.
    pub(crate) options: Vec<(RuleOption, Span)>,
}

impl ListedRule {
    /// Returns the place of an option.
    pub(crate) fn place_of(&self, option: RuleOption) -> Span {
        let found = self.options.iter().find(|(other, _)| *other == option);
        found.map_or(self.place, |&(_, place)| place)
    }
}

impl Arguments {
    /// Reads the attribute. Reports mistakes, and leaves out the parts that contain them.
    pub(crate) fn read(attribute: TokenStream, errors: &mut Errors) -> Self {
        Self::read_with(&Rule::all(), attribute, errors)
    }

    /// Reads an attribute. The rules in it must be among `all`.
    pub(super) fn read_with(all: &[Rule], attribute: TokenStream, errors: &mut Errors) -> Self {
        let mut read = Self {
            rules: Vec::new(),
            runtime: syn::parse_quote!(::sve_runtime),
            is_reduced: false,
        };
        let before = errors.count();
        let parsed = (|input: ParseStream<'_>| read.entries(all, input, errors)).parse2(attribute);
        errors.keep(parsed);
        if read.rules.is_empty() && errors.count() == before {
            errors.push(
                Span::call_site(),
                format!(
                    "name the rules to derive, for example `#[variational(midpoint)]`: {}",
                    listed(all)
                ),
            );
        }
        read
    }

    fn entries(
        &mut self,
        all: &[Rule],
        input: ParseStream<'_>,
        errors: &mut Errors,
    ) -> syn::Result<()> {
        while !input.is_empty() {
            if input.peek(Token![crate]) {
                input.parse::<Token![crate]>()?;
                let path = input
                    .parse::<Token![=]>()
                    .and_then(|_| input.call(syn::Path::parse_mod_style));
                self.runtime = path.map_err(|e| {
                    let message = "expected the path of the runtime, without quotes, as in `crate = physics::sve_runtime`";
                    syn::Error::new(e.span(), message)
                })?;
            } else {
                let name: Ident = input.parse().map_err(|e| {
                    let message = format!(
                        "expected the name of a rule, without quotes: {}",
                        listed(all)
                    );
                    syn::Error::new(e.span(), message)
                })?;
                if name == "reduced" && (input.is_empty() || input.peek(Token![,])) {
                    self.is_reduced = true;
                } else {
                    self.rule(all, &name, input, errors)?;
                }
            }
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        Ok(())
    }

    /// Reads the arguments of a rule whose name has just been read. Returns an error if the rest of
    /// the attribute cannot be separated from this rule.
    fn rule(
        &mut self,
        all: &[Rule],
        name: &Ident,
        input: ParseStream<'_>,
        errors: &mut Errors,
    ) -> syn::Result<()> {
        let known = all.iter().any(|rule| name == rule.attribute_name);
        let arguments = if input.peek(syn::token::Paren) {
            let content;
            let parentheses = syn::parenthesized!(content in input);
            if known {
                Some(RuleArguments::read(name, parentheses, &content, all)?)
            } else {
                content.parse::<TokenStream>()?;
                None
            }
        } else {
            None
        };
        if !input.is_empty() && !input.peek(Token![,]) {
            // the following tokens are a part of the same mistake
            return Err(no_comma(name, known, input.span(), all));
        }
        if !known {
            errors.push(name.span(), unknown_rule(&name.to_string(), all));
            return Ok(());
        }
        let Some(listed) = rule_arguments::resolve(name, arguments.as_ref(), all, errors) else {
            return Ok(());
        };
        if self.rules.iter().any(|other| other.rule == listed.rule) {
            let message = format!(
                "the rule `{}` is listed twice: remove one",
                listed.rule.name()
            );
            errors.push(listed.place, message);
        } else {
            self.rules.push(listed);
        }
        Ok(())
    }
}

/// Returns the error of an entry that is not followed by a comma.
fn no_comma(name: &Ident, is_rule: bool, follows: Span, all: &[Rule]) -> syn::Error {
    if is_rule {
        let message = "expected a comma between rules, as in `#[variational(midpoint, endpoint)]`";
        return syn::Error::new(follows, message);
    }
    let message = format!(
        "there is no argument `{name}`: the arguments are rules ({}) and `crate = path`",
        listed(all)
    );
    syn::Error::new(name.span(), message)
}

fn unknown_rule(name: &str, all: &[Rule]) -> String {
    let listed = listed(all);
    match nearest(name, all.iter().map(|r| r.attribute_name)) {
        Some(near) => {
            format!("there is no rule `{name}`; did you mean `{near}`? The rules are {listed}")
        }
        None => format!("there is no rule `{name}`; the rules are {listed}"),
    }
}

/// Returns the names of rules as a part of a sentence.
fn listed(rules: &[Rule]) -> String {
    catalogue::names(rules).join(", ")
}
