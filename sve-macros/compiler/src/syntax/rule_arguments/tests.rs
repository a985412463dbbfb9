//! Attributes that name rules with arguments: their meanings, and the messages about their
//! mistakes. A family of rules and two rules with options represent all kinds of rules.

use proc_macro2::TokenStream;

use crate::catalogue::{Entry, Nodes, Rule, RuleOption, Takes};
use crate::errors::Errors;
use crate::syntax::arguments::Arguments;

const fn entry(name: &'static str, nodes: Nodes, options: &'static [RuleOption]) -> Entry {
    let order = match nodes {
        Nodes::Gauss { stages } => 2 * stages as u32,
        _ => 2,
    };
    let takes = Takes {
        noise: true,
        force: true,
        constraints: true,
        rotations: true,
        options,
    };
    Entry {
        attribute_name: name,
        type_name: "",
        nodes,
        order,
        takes,
    }
}

const fn member(stages: usize) -> Entry {
    entry("stages", Nodes::Gauss { stages }, &RuleOption::ALL)
}

const fn bare(stages: usize) -> Entry {
    entry("bare", Nodes::Gauss { stages }, &[])
}

static START: Entry = entry("start", Nodes::One { c: 0.0 }, &[]);
static MIDDLE: Entry = entry("middle", Nodes::One { c: 0.5 }, &[RuleOption::Weak2]);
static BARE: [Entry; 2] = [bare(2), bare(3)];
static FAMILY: [Entry; 4] = [member(2), member(3), member(4), member(5)];

/// Returns the rules that an attribute names, or the first error with the columns of its token.
fn read(attribute: &str) -> Result<Vec<String>, (String, usize, usize)> {
    let family = FAMILY.iter().chain(&BARE).map(Rule::plain);
    let all: Vec<Rule> = [Rule::plain(&START), Rule::plain(&MIDDLE)]
        .into_iter()
        .chain(family)
        .collect();
    let tokens: TokenStream = attribute.parse().expect("tokens");
    let mut errors = Errors::new();
    let arguments = Arguments::read_with(&all, tokens, &mut errors);
    let names = arguments.rules.iter().map(|listed| listed.rule.name());
    errors.finish(names.collect()).map_err(|error| {
        let first = error.into_iter().next().expect("an error");
        let (start, end) = (first.span().start().column, first.span().end().column);
        (first.to_string(), start, end)
    })
}

#[test]
fn rules_that_differ_in_stages_or_options_are_different() {
    for (attribute, rules) in [
        ("start", &["start"][..]),
        ("middle(weak2)", &["middle(weak2)"]),
        (
            "middle, middle(weak2,), start",
            &["middle", "middle(weak2)", "start"],
        ),
        ("stages(3)", &["stages(3)"]),
        (
            "stages(3), stages(4), stages(3, weak2)",
            &["stages(3)", "stages(4)", "stages(3, weak2)"],
        ),
        (
            "stages(5, weak2, stage_noise)",
            &["stages(5, stage_noise, weak2)"],
        ),
        (
            "stages(2, stage_noise), crate = a::b, stages(2, weak2)",
            &["stages(2, stage_noise)", "stages(2, weak2)"],
        ),
    ] {
        assert_eq!(
            read(attribute).as_deref(),
            Ok(&rules.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>()[..]),
            "{attribute}"
        );
    }
}

/// Attributes with a mistake. The line below marks the token, and has the message.
const MISTAKES: &str = r#"
middle(weak2), middle(weak2)
               ^^^^^^ the rule `middle(weak2)` is listed twice: remove one
stages(2, weak2, stage_noise), stages(2, stage_noise, weak2)
                               ^^^^^^ the rule `stages(2, stage_noise, weak2)` is listed twice: remove one
start()
     ^^ these parentheses are empty: write `start`
stages
^^^^^^ `stages` needs its number of stages, 2 to 5: write `stages(4)`, which has order 8
stages()
      ^^ `stages` needs its number of stages, 2 to 5: write `stages(4)`, which has order 8
stages(weak2)
^^^^^^ `stages` needs its number of stages, 2 to 5: write `stages(4, weak2)`, which has order 8
stages(1)
       ^ with one stage this is the rule `middle`: write `middle`
stages(1, weak2)
       ^ with one stage this is the rule `middle`: write `middle(weak2)`
stages(6)
       ^ the number is that of the stages, of which `stages` has 2 to 5, and the order is twice this number: write `stages(3)`, which has order 6
stages(99, weak2)
       ^^ the number is that of the stages, of which `stages` has 2 to 5, and the order is twice this number: write `stages(5, weak2)`, which has order 10
stages(0)
       ^ the number is that of the stages, of which `stages` has 2 to 5, and the order is twice this number: write `stages(2)`, which has order 4
stages(99999999999999999999999)
       ^^^^^^^^^^^^^^^^^^^^^^^ the number is that of the stages, of which `stages` has 2 to 5, and the order is twice this number: write `stages(5)`, which has order 10
stages(3, 4)
          ^ `stages` takes one number, that of its stages: write `stages(3)`
stages(weak2, 3)
              ^ the number of stages comes first, without a suffix: write `stages(3, weak2)`
stages(3usize)
       ^^^^^^ the number of stages comes first, without a suffix: write `stages(3)`
stages(2.0)
       ^^^ expected the number of stages and options, separated by commas, as in `stages(4)` or `stages(4, stage_noise, weak2)`
stages(-2)
       ^^ the number is that of the stages, of which `stages` has 2 to 5, and the order is twice this number: write `stages(2)`, which has order 4
stages(3 weak2)
         ^^^^^ expected the number of stages and options, separated by commas, as in `stages(4)` or `stages(4, stage_noise, weak2)`
middle("weak2")
       ^^^^^^^ expected options, separated by commas, as in `middle(weak2)`
start("weak2")
      ^^^^^^^ `start` takes no arguments: write `start`
middle(2)
       ^ `middle` has no number of stages, and its order is 2: write `middle`
middle(4, weak2)
       ^ `middle` has no number of stages, and its order is 2: write `middle(weak2)`
middle(weak)
       ^^^^ there is no option `weak`; did you mean `weak2`?
middle(fast)
       ^^^^ there is no option `fast`; the options of `middle` are `weak2`
start(fast)
      ^^^^ `start` takes no options: write `start`
middle(stage_noise)
       ^^^^^^^^^^^ `middle` does not take the option `stage_noise`, which is one of `stages(2)` to `stages(5)`; the options of `middle` are `weak2`
start(weak2)
      ^^^^^ `start` takes no options: write `start`; `weak2` is an option of `middle`, `stages(2)` to `stages(5)`
middle(weak2, weak2)
              ^^^^^ the option `weak2` is written twice: remove one
middle weak2
       ^^^^^ expected a comma between rules, as in `#[variational(midpoint, endpoint)]`
bare(2, fast)
        ^^^^ `bare` takes no options: write `bare(2)`
bare(2, weak2)
        ^^^^^ `bare` takes no options: write `bare(2)`; `weak2` is an option of `middle`, `stages(2)` to `stages(5)`
bare(x)
     ^ `bare` takes no options: write `bare(3)`
bare("x")
     ^^^ expected the number of stages, as in `bare(3)`
middle(weak2) start
              ^^^^^ expected a comma between rules, as in `#[variational(midpoint, endpoint)]`
middel(weak2)
^^^^^^ there is no rule `middel`; did you mean `middle`? The rules are `start`, `middle`, `stages(2)` to `stages(5)`, `bare(2)` to `bare(3)`
order = 2
^^^^^ there is no argument `order`: the arguments are rules (`start`, `middle`, `stages(2)` to `stages(5)`, `bare(2)` to `bare(3)`) and `crate = path`
"#;

#[test]
fn mistakes_are_named_at_their_token_with_what_to_write() {
    let lines: Vec<&str> = MISTAKES.trim_matches('\n').lines().collect();
    assert_eq!(lines.len(), 2 * 36);
    for pair in lines.chunks(2) {
        let attribute = pair[0];
        let marked = pair[1].trim_start();
        let (marks, message) = marked.split_once(' ').expect("marks and a message");
        let (found, start, end) = read(attribute).expect_err(attribute);
        assert_eq!(found, message, "{attribute}");
        let place = pair[1].len() - marked.len();
        assert_eq!((start, end), (place, place + marks.len()), "{attribute}");
    }
}
