//! The tables of rules in the documentation have the names, types and orders of the catalogue, each
//! rule once.

use crate::catalogue::{Rule, RuleOption};

const OF_THE_MACRO: &str = include_str!("../../../src/lib.rs");
const OF_THE_METHODS: &str = include_str!("../../../../docs/methods.md");

/// Returns the rules that the first cell of a row names: in backquotes one after the other, or a
/// range of a family from one member to another, written with `…` or `to`, or to the last one.
fn rules(cell: &str) -> Vec<Rule> {
    let all = Rule::all_with_options();
    let mut found: Vec<Rule> = Vec::new();
    let mut is_range = false;
    for (at, part) in cell.split('`').enumerate() {
        if at % 2 == 0 {
            is_range = part.contains('…') || part.trim() == "to";
            continue;
        }
        let named = all.iter().find(|rule| rule.name() == part);
        let rule = *named.unwrap_or_else(|| panic!("there is no rule `{part}`"));
        if is_range {
            found.extend(after(found[found.len() - 1], rule.stages()));
        } else {
            found.push(rule);
        }
    }
    if is_range {
        found.extend(after(found[found.len() - 1], None));
    }
    found
}

/// Returns the members of a family with the options of a rule and with more stages, up to `last`.
fn after(rule: Rule, last: Option<usize>) -> Vec<Rule> {
    let mut family = Rule::all_with_options();
    family.retain(|other| {
        let (is_of_family, stages) = (other.attribute_name == rule.attribute_name, other.stages());
        let is_within = stages > rule.stages() && last.is_none_or(|last| stages <= Some(last));
        is_of_family && other.options == rule.options && is_within
    });
    family
}

/// Returns the type of a rule: `Weak2<Gauss<2>>`.
fn type_of(rule: Rule) -> String {
    let stages = rule.stages().map(|stages| format!("<{stages}>"));
    let plain = format!("{}{}", rule.type_name, stages.unwrap_or_default());
    let options = rule.options.iter();
    options.fold(plain, |inner, option| {
        format!("{}<{inner}>", option.type_name())
    })
}

/// Returns the orders of rules as the tables write them: `2`, or `4, 6, …, 16`.
fn orders(rules: &[Rule]) -> String {
    match rules {
        [first, second, .., last] if second.order > first.order => {
            format!("{}, {}, …, {}", first.order, second.order, last.order)
        }
        rules => rules[0].order.to_string(),
    }
}

/// Checks the rows of a table. Their first cell names rules, the second their types, the cell
/// `order` their orders without noise.
fn check<'a>(rows: impl Iterator<Item = &'a str>, order: usize) {
    let mut named = Vec::new();
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let rules = rules(cells[1]);
        let types = cells[2]
            .replace("::", "")
            .replace('(', "<")
            .replace(')', ">");
        let first = types.split('`').nth(1);
        assert_eq!(first, Some(type_of(rules[0]).as_str()), "{row}");
        assert_eq!(cells[order], orders(&rules), "{row}");
        named.extend(rules.iter().map(Rule::name));
    }
    let all = Rule::all_with_options();
    let mut all: Vec<String> = all.iter().map(Rule::name).collect();
    named.sort_unstable();
    all.sort_unstable();
    assert_eq!(named, all);
}

#[test]
fn the_table_of_the_macro_is_the_catalogue() {
    let rows = OF_THE_MACRO
        .lines()
        .filter_map(|line| line.strip_prefix("/// "));
    let rows = rows
        .skip_while(|row| !row.starts_with("| argument |"))
        .skip(2);
    check(rows.take_while(|row| !row.contains("`crate = path`")), 4);
}

#[test]
fn the_table_of_the_methods_is_the_catalogue() {
    let rows = OF_THE_METHODS
        .lines()
        .skip_while(|row| !row.starts_with("| rule |"));
    let rows = rows.skip(2).take_while(|row| row.starts_with('|'));
    let is_sequence = |row: &str| row.contains("Composed::") || row.contains("Split::");
    check(rows.filter(|row| !is_sequence(row)), 3);
}

/// κ of `docs/mathematics.md`, section 9.
#[test]
fn the_factor_of_the_potential_is_that_of_the_theory() {
    for rule in Rule::all_with_options() {
        let factor = rule.weak2().map(|weak2| weak2.factor.recip().round());
        let has_stage_noise = rule.options.contain(RuleOption::StageNoise);
        let expected = match (rule.attribute_name, rule.stages()) {
            ("midpoint" | "stormer_verlet", None) => Some(4.0),
            ("gauss", Some(stages)) if has_stage_noise => Some(4.0 * (2.0 * stages as f64 - 1.0)),
            ("gauss", Some(_)) => Some(6.0),
            _ => None,
        };
        assert_eq!(factor, expected, "{rule:?}");
    }
}
