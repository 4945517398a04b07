//! A tokeniser of Rust text, for as much of the language as names and imports need.

/// A piece of code that has gone through [`crate::code`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Token<'a> {
    /// A name or a keyword.
    Word(&'a str),
    /// The path separator, `::`.
    Path,
    /// Any other character that is no space.
    Mark(char),
}

/// Splits code into its tokens.
pub fn tokens(code: &str) -> Vec<Token<'_>> {
    let joins = |character: char| character.is_alphanumeric() || character == '_';
    let mut tokens = Vec::new();
    let mut rest = code.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("::") {
            tokens.push(Token::Path);
            2
        } else if joins(first) {
            let end = rest.find(|character| !joins(character)).unwrap_or(rest.len());
            tokens.push(Token::Word(&rest[..end]));
            end
        } else {
            tokens.push(Token::Mark(first));
            first.len_utf8()
        };
        rest = rest[length..].trim_start();
    }
    tokens
}

/// A name that a `use` defines, with its path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Import<'a> {
    pub name: &'a str,
    pub path: Vec<&'a str>,
}

/// Returns the imports of a `use` with the tree that begins here, and the number of its tokens.
pub fn imports<'a>(tokens: &[Token<'a>]) -> (Vec<Import<'a>>, usize) {
    let mut imports = Vec::new();
    let length = tree(tokens, &[], &mut imports);
    (imports, length)
}

fn tree<'a>(tokens: &[Token<'a>], above: &[&'a str], imports: &mut Vec<Import<'a>>) -> usize {
    let mut path = above.to_vec();
    let mut name = None;
    let mut at = 0;
    while let Some(&token) = tokens.get(at) {
        match token {
            Token::Word("as") => {
                if let Some(&Token::Word(alias)) = tokens.get(at + 1) {
                    name = Some(alias);
                }
                at += 1;
            }
            Token::Word("self") if !path.is_empty() => {}
            Token::Word(word) => path.push(word),
            Token::Mark('*') => path.push("*"),
            Token::Mark('{') => loop {
                at += 1 + tree(&tokens[at + 1..], &path, imports);
                if tokens.get(at) != Some(&Token::Mark(',')) {
                    return at + 1;
                }
            },
            Token::Path => {}
            Token::Mark(_) => break,
        }
        at += 1;
    }
    if let Some(last) = path.last().copied().filter(|_| at > 0) {
        imports.push(Import { name: name.unwrap_or(last), path });
    }
    at
}

#[test]
fn imports_are_read_out_of_trees() {
    let of = |code: &str| {
        let tokens = tokens(code);
        let (imports, length) = imports(&tokens);
        assert_eq!(tokens[length], Token::Mark(';'), "of {code}");
        let shown =
            imports.iter().map(|import| format!("{} = {}", import.name, import.path.join("::")));
        shown.collect::<Vec<_>>()
    };
    assert_eq!(of("crate::a::B;"), ["B = crate::a::B"]);
    assert_eq!(of("super::a::{self, B as C,};"), ["a = super::a", "C = super::a::B"]);
    assert_eq!(of("a::{b::{C, D}, e::*};"), ["C = a::b::C", "D = a::b::D", "* = a::e::*"]);
    assert_eq!(of("self::a;"), ["a = self::a"]);
}
