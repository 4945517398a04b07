//! Rust text without comments, strings and tests.

/// Returns the text with comments, strings and characters blanked; lines stay where they are.
pub fn without_comments_and_strings(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while !rest.is_empty() {
        let skipped = comment_length(rest).or_else(|| literal_length(rest, &code));
        let (length, blank) = match skipped {
            Some(length) => (length, true),
            None => (rest.chars().next().map_or(1, char::len_utf8), false),
        };
        let (piece, after) = rest.split_at(length.min(rest.len()));
        if blank {
            code.extend(piece.chars().map(|character| if character == '\n' { '\n' } else { ' ' }));
        } else {
            code.push_str(piece);
        }
        rest = after;
    }
    code
}

/// Returns the length of the comment that begins here, if one does.
fn comment_length(rest: &str) -> Option<usize> {
    if rest.starts_with("//") {
        return Some(rest.find('\n').unwrap_or(rest.len()));
    }
    if !rest.starts_with("/*") {
        return None;
    }
    let mut depth = 0_usize;
    let mut at = 0;
    while at < rest.len() {
        let here = &rest.as_bytes()[at..];
        if here.starts_with(b"/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if here.starts_with(b"*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                return Some(at);
            }
        } else {
            at += 1;
        }
    }
    Some(rest.len())
}

/// Returns the length of the string or character that begins here, if one does.
fn literal_length(rest: &str, before: &str) -> Option<usize> {
    if let Some(inside) = rest.strip_prefix('"') {
        return Some(match raw_hashes(before) {
            Some(hashes) => {
                let end = format!("\"{}", "#".repeat(hashes));
                inside.find(&end).map_or(rest.len(), |at| 1 + at + end.len())
            }
            None => escaped_length(rest, b'"'),
        });
    }
    // A quote begins a character if another one ends it; else it begins a lifetime.
    let character = rest.strip_prefix('\'')?.chars().next()?;
    let is_character = character == '\\' || rest[1 + character.len_utf8()..].starts_with('\'');
    is_character.then(|| escaped_length(rest, b'\''))
}

/// Returns the hashes of a raw string whose quote follows this text; none if it is not raw.
fn raw_hashes(before: &str) -> Option<usize> {
    let without = before.trim_end_matches('#');
    let prefix = without.strip_suffix('r')?;
    let in_word = prefix.ends_with(|c: char| c.is_alphanumeric() && c != 'b' || c == '_');
    (!in_word).then_some(before.len() - without.len())
}

/// Returns the length of a quoted piece in which a backslash escapes.
fn escaped_length(rest: &str, quote: u8) -> usize {
    let bytes = rest.as_bytes();
    let mut at = 1;
    while at < bytes.len() {
        match bytes[at] {
            b'\\' => at += 2,
            byte if byte == quote => return at + 1,
            _ => at += 1,
        }
    }
    bytes.len()
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

/// Returns true if a line has a word, not as a part of a longer one.
pub fn has_word(line: &str, word: &str) -> bool {
    let joins = |character: char| character.is_alphanumeric() || character == '_';
    line.match_indices(word)
        .any(|(at, _)| !line[..at].ends_with(joins) && !line[at + word.len()..].starts_with(joins))
}

#[test]
fn comments_strings_and_characters_are_blank() {
    for (text, code) in [
        ("a // b\nc", "a     \nc"),
        ("a /* b /* c */ d */ e", "a                   e"),
        (r#"a("b \" // c") d"#, "a(            ) d"),
        ("r#\"a \" b\"# c", "r#         c"),
        ("'a' + '\\'' + b", "    +      + b"),
        ("fn a<'b>(c: &'b str)", "fn a<'b>(c: &'b str)"),
        ("\"ä\" b", "    b"),
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
