//! Tokens of a source with their places.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// A token with its place in the file.
#[derive(Clone, Debug)]
pub(crate) struct Token {
    pub(crate) text: String,
    pub(crate) start: usize,
    pub(crate) end: usize,
    pub(crate) line: usize,
    pub(crate) column: usize,
}

/// Byte offset of the start of each line.
fn line_starts(text: &str) -> Vec<usize> {
    let breaks = text.match_indices('\n').map(|(index, _)| index + 1);
    std::iter::once(0).chain(breaks).collect()
}

/// All tokens but those of attributes and documentation.
pub(crate) fn tokens(text: &str) -> Vec<Token> {
    fn collect(text: &str, lines: &[usize], stream: TokenStream, found: &mut Vec<Token>) {
        let mut skip_attribute = false;
        for tree in stream {
            if let TokenTree::Punct(punct) = &tree
                && punct.as_char() == '#'
            {
                skip_attribute = true;
                continue;
            }
            if skip_attribute {
                let is_bracket =
                    matches!(&tree, TokenTree::Group(g) if g.delimiter() == Delimiter::Bracket);
                skip_attribute = !is_bracket;
                continue;
            }
            let add = |found: &mut Vec<Token>, span: proc_macro2::Span| {
                let offset = |place: proc_macro2::LineColumn| {
                    let line = &text[lines[place.line - 1]..];
                    let bytes = line.char_indices().nth(place.column);
                    lines[place.line - 1] + bytes.map_or(line.len(), |(index, _)| index)
                };
                let (start, end) = (offset(span.start()), offset(span.end()));
                found.push(Token {
                    text: text[start..end].to_owned(),
                    start,
                    end,
                    line: span.start().line,
                    column: span.start().column + 1,
                });
            };
            match tree {
                TokenTree::Group(group) => {
                    add(found, group.span_open());
                    collect(text, lines, group.stream(), found);
                    add(found, group.span_close());
                }
                other => add(found, other.span()),
            }
        }
    }
    let mut found = Vec::new();
    if let Ok(stream) = text.parse::<TokenStream>() {
        collect(text, &line_starts(text), stream, &mut found);
    }
    join_operators(found)
}

/// `>` and `>` that touch are `>>`, and so on.
fn join_operators(tokens: Vec<Token>) -> Vec<Token> {
    let mut joined: Vec<Token> = Vec::new();
    for token in tokens {
        if let Some(last) = joined.last_mut()
            && last.end == token.start
        {
            let both = format!("{}{}", last.text, token.text);
            if [
                "<<", ">>", "<=", ">=", "==", "!=", "&&", "||", "->", "=>", "::",
            ]
            .contains(&both.as_str())
            {
                last.text = both;
                last.end = token.end;
                continue;
            }
        }
        joined.push(token);
    }
    joined
}
