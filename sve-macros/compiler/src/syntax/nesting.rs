//! A bound on the nesting of the input, checked before any function recurses over the input.
//!
//! Input: the unparsed tokens. The parser, and every walk of a syntax tree, recurses once for each
//! bracket and for each token that may open an operand, so the source text alone decides whether
//! the stack overflows. This check itself walks no token tree by recursion.

use proc_macro2::token_stream::IntoIter;
use proc_macro2::{Delimiter, Span, TokenStream, TokenTree};

/// Cost at which the input is refused. The cost estimates the height of the syntax tree, in sixths
/// of a term.
const LIMIT: usize = 6_000;

/// Cost of a term of a sum or a factor of a product: one level of the tree, but none of the
/// parser's stack.
const TERM: usize = 6;

/// Cost of a token of a chain such as `a.b(c)[d]`. Each factor begins a new chain.
const LINK: usize = 15;

/// Cost of a bracket, or of a token that an operand follows: the parser recurses there.
const OPENER: usize = 60;

/// An open bracket, with the cost of the nesting in it.
struct Level {
    stream: IntoIter,
    /// Cost of the surrounding levels.
    around: usize,
    /// Cost since the last separator.
    statement: usize,
    /// Cost since the last sign between terms.
    product: usize,
    /// Cost since the last operator.
    chain: usize,
}

impl Level {
    fn new(stream: TokenStream, around: usize) -> Self {
        Self {
            stream: stream.into_iter(),
            around,
            statement: 0,
            product: 0,
            chain: 0,
        }
    }

    fn cost(&self) -> usize {
        let Self {
            stream: _,
            around,
            statement,
            product,
            chain,
        } = self;
        around + statement + product + chain
    }

    /// Counts a token.
    fn count(&mut self, token: &TokenTree, after_operator: bool) {
        match kind(token, after_operator) {
            Kind::Separator => (self.statement, self.product, self.chain) = (0, 0, 0),
            Kind::Opener => self.statement += OPENER,
            Kind::Sign => {
                self.statement += TERM;
                (self.product, self.chain) = (0, 0);
            }
            Kind::Times => {
                self.product += TERM;
                self.chain = 0;
            }
            Kind::Link => self.chain += LINK,
        }
    }
}

/// The effect of a token on the syntax tree.
enum Kind {
    Separator,
    Opener,
    Sign,
    Times,
    Link,
}

fn kind(token: &TokenTree, after_operator: bool) -> Kind {
    match token {
        TokenTree::Punct(punct) => match punct.as_char() {
            ';' | ',' => Kind::Separator,
            ':' | '.' | '#' => Kind::Link,
            '+' | '-' if !after_operator => Kind::Sign,
            '*' | '/' if !after_operator => Kind::Times,
            _ => Kind::Opener,
        },
        TokenTree::Ident(ident) if is_opener(&ident.to_string()) => Kind::Opener,
        _ => Kind::Link,
    }
}

/// Returns an error if the input is nested too deeply to be read.
pub(crate) fn check(tokens: &TokenStream) -> syn::Result<()> {
    let mut open = vec![Level::new(tokens.clone(), 0)];
    let mut after_operator = true;
    while let Some(level) = open.last_mut() {
        let Some(token) = level.stream.next() else {
            open.pop();
            after_operator = false;
            continue;
        };
        level.count(&token, after_operator);
        after_operator = matches!(token, TokenTree::Punct(_));
        let cost = level.cost();
        if cost > LIMIT {
            return Err(too_deep(token.span()));
        }
        if let TokenTree::Group(group) = token {
            if group.delimiter() == Delimiter::Brace && !continues(level.stream.clone().next()) {
                // this token ends a statement
                (level.statement, level.product, level.chain) = (0, 0, 0);
            }
            open.push(Level::new(group.stream(), cost + OPENER));
            after_operator = true;
        }
    }
    Ok(())
}

/// Returns whether the token after a block belongs to the same expression.
fn continues(next: Option<TokenTree>) -> bool {
    match next {
        Some(TokenTree::Ident(ident)) => ident == "else",
        Some(TokenTree::Punct(punct)) => punct.as_char() != '#',
        _ => false,
    }
}

/// Returns whether a word is a keyword that an operand follows.
fn is_opener(word: &str) -> bool {
    matches!(
        word,
        "return"
            | "break"
            | "yield"
            | "move"
            | "unsafe"
            | "async"
            | "const"
            | "mut"
            | "dyn"
            | "impl"
            | "fn"
            | "for"
            | "if"
            | "while"
            | "match"
            | "let"
            | "else"
            | "loop"
            | "in"
            | "static"
            | "ref"
            | "box"
    )
}

fn too_deep(span: Span) -> syn::Error {
    syn::Error::new(
        span,
        "this is nested too deeply, or too long, to be read: name parts of it with `let`",
    )
}
