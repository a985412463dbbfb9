//! The messages of mistakes and their places. Each case of `tests/mistakes/cases` is expanded here,
//! and its errors are compared with the errors of the table. With `MISTAKES=overwrite` in the
//! environment the tables are written instead.

use proc_macro2::{LineColumn, Span, TokenStream, TokenTree};
use quote::ToTokens;
use sve_tests_mistakes::{Case, Message, tables};
use syn::{Attribute, Item, Meta};

use crate::tests::expand;

/// Returns the attributes of an item that a procedural macro can be on.
fn attributes(item: &mut Item) -> Option<&mut Vec<Attribute>> {
    match item {
        Item::Impl(item) => Some(&mut item.attrs),
        Item::Struct(item) => Some(&mut item.attrs),
        Item::Fn(item) => Some(&mut item.attrs),
        _ => None,
    }
}

/// Returns the attribute `#[variational(…)]`: its own tokens, its arguments, and the item without
/// it.
fn annotated(mut item: Item) -> Option<(Attribute, TokenStream, TokenStream)> {
    let all = attributes(&mut item)?;
    let is_ours = |attribute: &Attribute| {
        let path = attribute.path();
        path.segments
            .last()
            .is_some_and(|last| last.ident == "variational")
    };
    let attribute = all.remove(all.iter().position(is_ours)?);
    let arguments = match &attribute.meta {
        Meta::List(list) => list.tokens.clone(),
        _ => TokenStream::new(),
    };
    Some((attribute, arguments, item.into_token_stream()))
}

/// Returns the `compile_error!("…")` of an expansion: the message, and the first token that it
/// concerns, which the compiler of Rust marks.
fn mistakes(expansion: TokenStream) -> Vec<(String, Span)> {
    let tokens: Vec<TokenTree> = expansion.into_iter().collect();
    let is_error =
        |token: &TokenTree| matches!(token, TokenTree::Ident(word) if word == "compile_error");
    let errors = (0..tokens.len()).filter(|&at| is_error(&tokens[at]));
    let mistake = |at: usize| {
        let TokenTree::Group(group) = &tokens[at + 2] else {
            panic!("no message: {}", tokens[at]);
        };
        let message: syn::LitStr = syn::parse2(group.stream()).expect("a message");
        // tokens outside of the compiler of Rust are printed with a space before a comma
        (message.value().replace(" ,", ","), tokens[at].span())
    };
    errors.map(mistake).collect()
}

/// Returns the end of the token or group that starts at a place. Here a span of several tokens
/// covers all of them; in the compiler of Rust it covers the first one.
fn end_of_token(tokens: TokenStream, start: LineColumn) -> Option<LineColumn> {
    tokens.into_iter().find_map(|token| {
        if token.span().start() == start {
            return Some(token.span().end());
        }
        match token {
            TokenTree::Group(group) => end_of_token(group.stream(), start),
            _ => None,
        }
    })
}

/// Returns the place of an error in a program. A span without tokens stands for the whole
/// attribute.
fn place(span: Span, attribute: &Attribute, program: &TokenStream) -> (LineColumn, LineColumn) {
    let of_nothing = LineColumn { line: 1, column: 0 };
    if span.start() == of_nothing {
        let [first, last] = [
            attribute.pound_token.span,
            attribute.bracket_token.span.close(),
        ];
        return (first.start(), last.end());
    }
    let end = end_of_token(program.clone(), span.start());
    (span.start(), end.expect("a token").min(span.end()))
}

/// Returns all messages of a case, ordered by lines.
fn messages(case: &Case) -> Vec<Message> {
    let program: TokenStream = case.source().parse().expect("tokens");
    let file: syn::File = syn::parse2(program.clone()).expect("Rust");
    let blocks = file.items.into_iter().filter_map(annotated);
    let mut messages: Vec<Message> = blocks
        .flat_map(|(attribute, arguments, item)| {
            let all = mistakes(expand(&arguments, &item)).into_iter();
            let message = |(text, span)| {
                let (start, end) = place(span, &attribute, &program);
                assert_eq!(start.line, end.line, "{}: several lines", case.name);
                Message {
                    line: start.line - 1,
                    column: start.column,
                    width: end.column - start.column,
                    text,
                }
            };
            all.map(message).collect::<Vec<_>>()
        })
        .collect();
    messages.sort_by_key(|message| message.line);
    messages
}

#[test]
fn mistakes_have_their_messages_at_their_tokens() {
    let is_to_overwrite = std::env::var("MISTAKES").is_ok_and(|value| value == "overwrite");
    let (mut count, mut wrong) = (0, Vec::new());
    for table in tables() {
        let mut all = Vec::new();
        for case in table.cases() {
            let found = messages(case);
            assert!(!found.is_empty(), "{} {}", table.name, case.name);
            if found != case.messages {
                let written = case.written(&found);
                wrong.push(format!("{}.cases should have\n{written}", table.name));
            }
            count += 1;
            all.push(found);
        }
        if is_to_overwrite {
            table.overwrite(&all);
        }
    }
    assert!(count > 200, "{count}");
    assert!(is_to_overwrite || wrong.is_empty(), "{}", wrong.join("\n"));
}
