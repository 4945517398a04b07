//! Rust text without comments, strings and tests.

use std::str::FromStr;

use proc_macro2::{Span, TokenStream, TokenTree};

/// Returns the text with comments blanked, and strings and characters made empty strings; lines
/// stay where they are.
///
/// # Panics
/// If it is not Rust.
pub fn without_comments_and_strings(text: &str) -> String {
    let tokens = TokenStream::from_str(text)
        .unwrap_or_else(|error| panic!("line {}: {error}, of:\n{text}", error.span().start().line));
    let blank = text.bytes().map(|byte| if byte == b'\n' { byte } else { b' ' });
    let mut code = Code { text, kept: blank.collect() };
    code.keep(tokens);
    String::from_utf8(code.kept).expect("whole tokens")
}

/// A text, and the parts of it that are kept.
struct Code<'a> {
    text: &'a str,
    kept: Vec<u8>,
}

impl Code<'_> {
    fn keep(&mut self, tokens: TokenStream) {
        for token in tokens {
            let piece = &self.text[token.span().byte_range()];
            if piece.starts_with("//") || piece.starts_with("/*") {
                // A doc comment becomes tokens that lie within it.
                continue;
            }
            match token {
                TokenTree::Group(group) => {
                    self.copy(group.span_open());
                    self.keep(group.stream());
                    self.copy(group.span_close());
                }
                TokenTree::Literal(literal) if piece.contains(['"', '\'']) => {
                    let start = literal.span().byte_range().start;
                    self.kept[start..start + 2].fill(b'"');
                }
                token => self.copy(token.span()),
            }
        }
    }

    fn copy(&mut self, token: Span) {
        let place = token.byte_range();
        self.kept[place.clone()].copy_from_slice(&self.text.as_bytes()[place]);
    }
}

/// Blanks items under `#[cfg(test)]`, in text that has gone through
/// [`without_comments_and_strings`].
pub fn without_tests(code: &str) -> String {
    const MARK: &str = "#[cfg(test)]";
    let mut kept = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(start) = rest.find(MARK) {
        let (before, item) = rest.split_at(start);
        kept.push_str(before);
        let (skipped, after) = item.split_at(item_length(item));
        kept.extend(skipped.chars().filter(|&character| character == '\n'));
        rest = after;
    }
    kept + rest
}

/// Returns the length of an item up to its closing brace or, if it has none, its semicolon.
fn item_length(item: &str) -> usize {
    let mut depth = 0_usize;
    for (at, byte) in item.bytes().enumerate() {
        match byte {
            b'{' => depth += 1,
            b'}' if depth <= 1 => return at + 1,
            b'}' => depth -= 1,
            b';' if depth == 0 => return at + 1,
            _ => {}
        }
    }
    item.len()
}

/// Returns true if a line has a word that is not a part of a longer one.
pub fn has_word(line: &str, word: &str) -> bool {
    let joins = |character: char| character.is_alphanumeric() || character == '_';
    line.match_indices(word)
        .any(|(at, _)| !line[..at].ends_with(joins) && !line[at + word.len()..].starts_with(joins))
}

#[test]
fn comments_strings_and_characters_are_blank() {
    for (text, code) in [
        ("a // b\nc", "a     \nc"),
        ("/// a\nb /* c /* d */ e */ f // g", "\nb f"),
        (r#"a("b \" // c") d"#, "a(\"\") d"),
        ("r#\"a \" b\"# c", "\"\" c"),
        ("'a' + '\\'' + 1 + b", "\"\" + \"\" + 1 + b"),
        ("fn a<'b>(c: &'b str)", "fn a<'b>(c: &'b str)"),
        ("\"ä\" b", "\"\" b"),
    ] {
        let expected = code.split_whitespace().collect::<String>();
        let found = without_comments_and_strings(text);
        assert_eq!(found.split_whitespace().collect::<String>(), expected, "of {text}");
        assert_eq!(found.lines().count(), text.lines().count());
    }
}

#[test]
fn tests_are_blank_and_lines_stay() {
    let code = "a\n#[cfg(test)]\nmod tests {\n  fn b() { {} }\n}\nc\n#[cfg(test)]\nuse d;\ne";
    let kept = without_tests(code);
    assert_eq!(kept.lines().filter(|line| !line.is_empty()).collect::<Vec<_>>(), ["a", "c", "e"]);
    assert_eq!(kept.lines().count(), code.lines().count());
}
