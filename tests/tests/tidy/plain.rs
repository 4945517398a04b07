//! Rules about plain statements: a variable per `let`, `if` for a choice of two, names that say
//! something.

use crate::code::without_comments_and_strings;
use crate::files::SourceFile;

/// Finds a `let` that takes a tuple or array apart which is written out beside it.
pub fn one_variable_per_let(files: &[SourceFile]) -> Vec<String> {
    let is_packed = |code: &str, at: usize| {
        let is_condition = ["if ", "while ", "&& "].iter().any(|word| code[..at].ends_with(word));
        !is_condition && is_taken_apart(&code[at + "let ".len()..])
    };
    findings(files, "let ", "one variable per `let`", is_packed)
}

/// Returns true if a pattern of several names begins here, and their values are written out.
fn is_taken_apart(rest: &str) -> bool {
    let Some(pattern_end) = closing(rest) else { return false };
    let Some(equals) = rest[pattern_end..].find('=') else { return false };
    let after = &rest[pattern_end + equals..];
    let Some(value) = after.strip_prefix('=').map(str::trim_start) else { return false };
    if value.chars().next() != rest.chars().next() {
        return false;
    }
    let Some(value_end) = closing(value) else { return false };
    value[value_end + 1..].trim_start().starts_with(';') && value[..value_end].contains(',')
}

/// Returns the place of the bracket that closes the one at the beginning, if one is there.
fn closing(text: &str) -> Option<usize> {
    if !text.starts_with(['(', '[']) {
        return None;
    }
    let mut depth = 0_i32;
    for (at, character) in text.char_indices() {
        match character {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some(at);
        }
    }
    None
}

/// Finds parameters of functions that are tuples or arrays taken apart: their values have no names
/// where the function is called.
pub fn parameters_have_names(files: &[SourceFile]) -> Vec<String> {
    let is_packed = |code: &str, at: usize| {
        let rest = &code[at..];
        let Some(begin) = parameters_begin(rest) else { return false };
        let Some(end) = closing(&rest[begin..]) else { return false };
        let parameters = &rest[begin + 1..begin + end];
        first_characters(parameters).any(|first| first == '(' || first == '[')
            // A property of `proptest` takes values apart that it makes itself.
            && !parameters.contains(" in ")
    };
    findings(files, "fn ", "a parameter has a name, or is a struct", is_packed)
}

/// Returns the place of the bracket that begins the parameters of the function that begins here.
fn parameters_begin(function: &str) -> Option<usize> {
    let mut angles = 0_i32;
    let mut before = ' ';
    for (at, character) in function.char_indices() {
        match character {
            '<' => angles += 1,
            '>' if before != '-' => angles -= 1,
            '(' if angles == 0 => return Some(at),
            '{' | ';' => return None,
            _ => {}
        }
        before = character;
    }
    None
}

/// Returns the first character of each parameter.
fn first_characters(parameters: &str) -> impl Iterator<Item = char> {
    let mut depth = 0_i32;
    let is_end = move |character: char| {
        match character {
            '(' | '[' | '{' | '<' => depth += 1,
            ')' | ']' | '}' | '>' => depth -= 1,
            _ => {}
        }
        character == ',' && depth == 0
    };
    parameters.split(is_end).filter_map(|parameter| parameter.trim_start().chars().next())
}

/// Finds a `match` whose first arm is `true` or `false`.
pub fn if_for_a_choice_of_two(files: &[SourceFile]) -> Vec<String> {
    let is_choice = |code: &str, at: usize| {
        let arms = code[at..].split_once('{').map(|(_, arms)| arms.trim_start());
        let bodies = ["true", "false"].map(|value| arms.and_then(|arms| arms.strip_prefix(value)));
        bodies.into_iter().flatten().any(|rest| rest.starts_with(" =>") || rest.starts_with(" if "))
    };
    findings(files, "match ", "`if` and not `match` on a bool", is_choice)
}

/// Finds variables named `it`.
pub fn names_say_something(files: &[SourceFile]) -> Vec<String> {
    let is_name = |code: &str, at: usize| {
        !code[at + "it".len()..].starts_with(|next: char| next.is_alphanumeric() || next == '_')
    };
    findings(files, "it", "`it` says nothing: name the thing", is_name)
}

/// Returns a finding for each word of the code for which this is true, at its place.
fn findings(
    files: &[SourceFile],
    word: &str,
    reason: &str,
    is_wrong: impl Fn(&str, usize) -> bool,
) -> Vec<String> {
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.is_rust()) {
        let code = without_comments_and_strings(&file.text);
        for (at, _) in code.match_indices(word) {
            let joins = |before: char| before.is_alphanumeric() || before == '_';
            if !code[..at].ends_with(joins) && is_wrong(&code, at) {
                let line = code[..at].matches('\n').count() + 1;
                findings.push(file.finding(line, reason));
            }
        }
    }
    findings
}
