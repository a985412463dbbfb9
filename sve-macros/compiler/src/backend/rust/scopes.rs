//! Blocks of bounded size: a block with many `let` statements is cut into inner blocks.
//!
//! Each `let` opens a scope of the debug information, which lasts until the end of its block. The
//! scopes of a block are therefore nested as deeply as the block has `let` statements. rustc visits
//! them recursively, in threads with a stack of 2 MB, which overflows at about 2,500 scopes.
//!
//! Input: generated code. Output: the same statements in the same order. The value of an inner
//! block is the tuple of those names that later statements read. A block of at most [`LETS`] `let`
//! statements is not changed.

use std::collections::HashMap;
use std::mem;

use proc_macro2::{Delimiter, Group, Ident, TokenStream, TokenTree};
use quote::quote;

use crate::program::limits::{LETS, LETS_OF_PART};

/// Cuts every block with too many `let` statements.
pub(crate) fn bounded(code: TokenStream) -> TokenStream {
    let bounded = |tree| match tree {
        TokenTree::Group(group) => {
            let mut content = bounded(group.stream());
            if group.delimiter() == Delimiter::Brace {
                content = cut(content);
            }
            let mut bounded = Group::new(group.delimiter(), content);
            bounded.set_span(group.span());
            TokenTree::Group(bounded)
        }
        other => other,
    };
    code.into_iter().map(bounded).collect()
}

/// The content of a block, cut until the block is not too large.
fn cut(mut block: TokenStream) -> TokenStream {
    let mut lets = number_of_lets(&block);
    while lets > LETS {
        block = cut_once(block);
        let before = mem::replace(&mut lets, number_of_lets(&block));
        if lets == before {
            break;
        }
    }
    block
}

fn number_of_lets(block: &TokenStream) -> usize {
    let trees = block.clone().into_iter();
    trees.filter(|tree| is_word(tree, "let")).count()
}

fn cut_once(block: TokenStream) -> TokenStream {
    let statements = statements(block);
    let last_reads = last_reads(&statements);
    let mut output = TokenStream::new();
    let mut part = Part::default();
    for (at, (statement, last_reads)) in statements.into_iter().zip(last_reads).enumerate() {
        if !statement.is_movable {
            output.extend(mem::take(&mut part).block(at));
            output.extend(statement.tokens());
            continue;
        }
        if part.lets >= LETS_OF_PART && part.may_end(at) {
            output.extend(mem::take(&mut part).block(at));
        }
        part.push(statement, &last_reads);
    }
    // the last statement cannot be moved
    output
}

/// A statement of a block.
#[derive(Default)]
struct Statement {
    /// `let` with its pattern and its `=`; nothing in other statements.
    pattern: Vec<TokenTree>,
    /// The tokens after the pattern.
    rest: Vec<TokenTree>,
    /// Names that the pattern binds.
    names: Vec<Ident>,
    /// True if an inner block may hold the statement.
    is_movable: bool,
}

impl Statement {
    fn tokens(self) -> impl Iterator<Item = TokenTree> {
        self.pattern.into_iter().chain(self.rest)
    }

    /// Returns whether the statement binds a closure, which borrows other names.
    fn is_closure(&self) -> bool {
        !self.pattern.is_empty() && self.rest.first().is_some_and(|tree| is_mark(tree, '|'))
    }
}

/// The statements of a block. The last one may be the value of the block, so it is not movable.
fn statements(block: TokenStream) -> Vec<Statement> {
    let mut statements = Vec::new();
    let mut open: Vec<TokenTree> = Vec::new();
    let mut trees = block.into_iter().peekable();
    while let Some(tree) = trees.next() {
        let is_block =
            matches!(&tree, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace);
        let ends_with_block = ["if", "for", "while", "match"];
        let may_end = is_block
            && ends_with_block
                .iter()
                .any(|word| is_word(open.first().unwrap_or(&tree), word));
        let continues = trees.peek().is_some_and(|next| is_word(next, "else"));
        let ends = is_mark(&tree, ';') || may_end && !continues;
        open.push(tree);
        if ends {
            statements.push(statement(mem::take(&mut open)));
        }
    }
    statements.push(statement(open));
    if let Some(last) = statements.last_mut() {
        last.is_movable = false;
    }
    statements
}

/// A statement. A `let` is movable if its pattern has only names, and if it does not borrow a
/// temporary value. A `use` holds for the whole block.
fn statement(mut tokens: Vec<TokenTree>) -> Statement {
    if !tokens.first().is_some_and(|tree| is_word(tree, "let")) {
        return Statement {
            is_movable: !tokens.first().is_some_and(|tree| is_word(tree, "use")),
            rest: tokens,
            ..Statement::default()
        };
    }
    let equals = tokens.iter().position(|tree| is_mark(tree, '='));
    let rest = tokens.split_off(equals.map_or(tokens.len(), |at| at + 1));
    let names = names(&tokens[1..]);
    let borrows = rest.first().is_none_or(|tree| is_mark(tree, '&'));
    Statement {
        is_movable: names.is_some() && !borrows,
        names: names.unwrap_or_default(),
        pattern: tokens,
        rest,
    }
}

/// The names in a pattern of names, rows and tuples, before its type and `=`. Nothing if the
/// pattern has anything else.
fn names(pattern: &[TokenTree]) -> Option<Vec<Ident>> {
    let mut names = Vec::new();
    for (at, tree) in pattern.iter().enumerate() {
        match tree {
            TokenTree::Ident(word) if word == "mut" || word == "ref" => return None,
            TokenTree::Ident(word) => {
                let next = pattern.get(at + 1);
                if matches!(next, Some(TokenTree::Group(_))) {
                    return None;
                }
                names.extend((word != "_").then(|| word.clone()));
            }
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => return None,
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                names.extend(self::names(&inner)?);
            }
            TokenTree::Punct(mark) if mark.as_char() == ',' => {}
            TokenTree::Punct(mark) if matches!(mark.as_char(), ':' | '=') => break,
            _ => return None,
        }
    }
    Some(names)
}

/// For each name of each statement, the number of the last statement that reads it; 0 if there is
/// none.
fn last_reads(statements: &[Statement]) -> Vec<Vec<usize>> {
    let mut reads: Vec<Vec<usize>> = statements.iter().map(|s| vec![0; s.names.len()]).collect();
    let mut bound: HashMap<String, (usize, usize)> = HashMap::new();
    for (at, statement) in statements.iter().enumerate() {
        for_each_word(&statement.rest, &mut |word| {
            if let Some(&(binds, place)) = bound.get(&word.to_string()) {
                reads[binds][place] = at;
            }
        });
        let places = statement.names.iter().enumerate();
        bound.extend(places.map(|(place, name)| (name.to_string(), (at, place))));
    }
    reads
}

fn for_each_word(trees: &[TokenTree], visit: &mut impl FnMut(&Ident)) {
    for tree in trees {
        match tree {
            TokenTree::Ident(word) => visit(word),
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                for_each_word(&inner, visit);
            }
            TokenTree::Punct(_) | TokenTree::Literal(_) => {}
        }
    }
}

/// Statements that become an inner block.
#[derive(Default)]
struct Part {
    tokens: Vec<TokenTree>,
    lets: usize,
    names: Vec<Bound>,
}

/// A name that a statement binds.
struct Bound {
    name: Ident,
    /// The number of the last statement that reads the name.
    last_read: usize,
    is_closure: bool,
}

impl Part {
    fn push(&mut self, statement: Statement, last_reads: &[usize]) {
        self.lets += usize::from(!statement.pattern.is_empty());
        let is_closure = statement.is_closure();
        let names = statement.names.iter().zip(last_reads);
        self.names.extend(names.map(|(name, &last_read)| Bound {
            name: name.clone(),
            last_read,
            is_closure,
        }));
        self.tokens.extend(statement.tokens());
    }

    /// Returns whether the block may end before statement `end`: no closure leaves it, since a
    /// closure borrows names of the block.
    fn may_end(&self, end: usize) -> bool {
        self.names
            .iter()
            .all(|name| !name.is_closure || name.last_read < end)
    }

    /// The inner block, which ends before the statement number `end`.
    fn block(self, end: usize) -> TokenStream {
        let may_end = self.may_end(end);
        let Self {
            tokens,
            lets,
            names,
        } = self;
        let tokens = tokens.into_iter();
        if lets <= 1 || !may_end {
            return tokens.collect();
        }
        let results = names.iter().filter(|name| name.last_read >= end);
        let results: Vec<&Ident> = results.map(|name| &name.name).collect();
        match results.as_slice() {
            [] => quote!({ #(#tokens)* }),
            [result] => quote!(let #result = { #(#tokens)* #result };),
            results => quote!(let (#(#results),*) = { #(#tokens)* (#(#results),*) };),
        }
    }
}

fn is_word(tree: &TokenTree, text: &str) -> bool {
    matches!(tree, TokenTree::Ident(word) if word == text)
}

fn is_mark(tree: &TokenTree, character: char) -> bool {
    matches!(tree, TokenTree::Punct(mark) if mark.as_char() == character)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;

    fn parse(text: &str) -> TokenStream {
        text.parse().expect("tokens")
    }

    /// A block of `count` sums, each of the one before and the tenth before.
    fn sums(count: usize) -> String {
        let mut text = String::from("let a0 = x;");
        for i in 1..count {
            let _ = write!(text, "let a{i} = a{} + a{};", i - 1, i.saturating_sub(10));
        }
        text
    }

    /// The largest number of `let` statements of a block, inner blocks on their own.
    fn largest(code: &TokenStream) -> usize {
        let inner = code.clone().into_iter().map(|tree| match tree {
            TokenTree::Group(group) => largest(&group.stream()),
            _ => 0,
        });
        inner.max().unwrap_or_default().max(number_of_lets(code))
    }

    /// The statements without the inner blocks around them.
    fn flat(code: &str) -> String {
        let statements = code.split(';').map(str::trim);
        let plain = statements.map(|s| s.rsplit('{').next().unwrap_or_default().trim());
        let sums: Vec<&str> = plain.filter(|s| s.starts_with("let a")).collect();
        sums.join(";")
    }

    #[test]
    fn a_small_block_stays_as_it_is() {
        let code = format!("{{ {} a9 }}", sums(LETS));
        assert_eq!(bounded(parse(&code)).to_string(), parse(&code).to_string());
    }

    #[test]
    fn a_large_block_is_cut_and_keeps_its_statements() {
        for count in [LETS + 1, 5000, 200_000] {
            let code = format!("{{ {} a{} }}", sums(count), count - 1);
            let cut = bounded(parse(&code));
            assert!(largest(&cut) <= LETS, "{count}");
            assert_eq!(flat(&cut.to_string()), flat(&parse(&code).to_string()));
        }
    }

    #[test]
    fn an_inner_block_returns_what_is_read_later_and_nothing_else() {
        let code = format!("{{ {} a{} }}", sums(LETS + 1), LETS);
        let cut = bounded(parse(&code)).to_string();
        let names: Vec<String> = (LETS_OF_PART - 10..LETS_OF_PART)
            .map(|i| format!("a{i}"))
            .collect();
        let names = names.join(" , ");
        assert!(cut.contains(&format!("let ({names}) = {{")), "{cut}");
        assert!(cut.contains(&format!("({names}) }} ;")), "{cut}");
    }

    #[test]
    fn a_use_holds_for_all_inner_blocks() {
        let count = 2 * LETS;
        let code = format!("{{ use rounded::*; {} a{} }}", sums(count), count - 1);
        let cut = bounded(parse(&code)).to_string();
        let cut: String = cut.split_whitespace().collect();
        assert!(cut.starts_with("{userounded::*;let(a"), "{cut}");
    }

    /// The second `guess` hides the first, a closure stays in the block of the values that it
    /// borrows, and a mutable variable outside.
    #[test]
    fn hidden_names_closures_and_mutable_variables() {
        let (first, second) = (sums(LETS_OF_PART - 10), sums(LETS));
        let code = format!(
            "{{ let guess = x; {first} let y = 1.0; let f = || y + guess; let z = f(); let mut sum = z; {second} let guess = a3; sum += guess; sum }}"
        );
        let cut = bounded(parse(&code)).to_string();
        assert!(cut.contains("let z = { let guess = x ;"), "{cut}");
        assert!(
            cut.contains("let z = f () ; z } ; let mut sum = z ;"),
            "{cut}"
        );
        assert!(!cut.contains("f)") && !cut.contains("(guess"), "{cut}");
    }
}
