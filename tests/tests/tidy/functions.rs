//! The rule that a function can be read as one: its length.

use crate::files::SourceFile;
use crate::modules::product_code;

/// The most lines of code of a function, comments not counted.
const MAX_LINES: usize = 90;

/// The file of the frame, and the most lines of a function there: the frame is read first.
const FRAME: (&str, usize) = ("engine/render/src/api/render.rs", 70);

/// Finds functions that are too long. The formatter puts a function's last brace below the
/// beginning of its first line.
pub fn long_functions(files: &[SourceFile]) -> Vec<String> {
    let mut findings = Vec::new();
    for (path, code) in product_code(files) {
        let most = if path == FRAME.0 { FRAME.1 } else { MAX_LINES };
        let lines: Vec<&str> = code.lines().collect();
        for (first, line) in lines.iter().enumerate().filter(|(_, line)| begins_function(line)) {
            let indent = &line[..line.len() - line.trim_start().len()];
            let is_last = |line: &&str| line.strip_prefix(indent) == Some("}");
            let count = lines[first..].iter().position(is_last).map_or(1, |last| last + 1);
            let body = &lines[first..(first + count).min(lines.len())];
            let has_body = body.iter().any(|line| line.ends_with('{'));
            let code_lines = body.iter().filter(|line| !line.trim().is_empty()).count();
            if has_body && code_lines > most {
                let what = format!("{code_lines} lines of function, at most {most} may be");
                findings.push(format!("{path}:{}: {what}", first + 1));
            }
        }
    }
    findings
}

/// Returns true for the first line of a function that does not end on it.
fn begins_function(line: &str) -> bool {
    let is_qualifier = |word: &&str| {
        matches!(*word, "const" | "unsafe" | "async" | "extern") || word.starts_with("pub")
    };
    let first = line.split_whitespace().find(|word| !is_qualifier(word));
    first == Some("fn") && !line.ends_with([';', '}'])
}
