//! Rules about comments: the first words of documentation, and the width of lines.

use crate::files::SourceFile;
use crate::{assert_catches, assert_obeyed, assert_permits};

/// The longest line of a comment, in columns.
const MAX_COLUMNS: usize = 100;
/// Words that turn a description into a question.
const QUESTIONS: [&str; 8] = ["What", "Who", "Whose", "Whether", "How", "Where", "When", "Whoever"];
/// Words that end with s and are not verbs in the third person, or not what a function does.
const NO_VERBS: [&str; 21] = [
    "Across", "Always", "As", "Besides", "Boxes", "Frames", "Has", "Is", "Its", "Less", "Objects",
    "Others", "Perhaps", "Pixels", "This", "Thus", "Towards", "Unless", "Was", "Words", "Yes",
];

/// Finds documentation of functions that does not begin with a verb in the third person.
pub fn function_verbs(files: &[SourceFile]) -> Vec<String> {
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| is_checked(file) && file.is_rust()) {
        for doc in docs(&file.text).into_iter().filter(|doc| doc.is_of_function) {
            let word = first_word(doc.text);
            let is_verb = word.starts_with(|first: char| first.is_ascii_uppercase())
                && word.ends_with('s')
                && !NO_VERBS.contains(&word);
            if !is_verb {
                let reason = format!("begin with a verb in the third person, not '{}'", doc.text);
                findings.push(file.finding(doc.line, &reason));
            }
        }
    }
    findings
}

/// Finds documentation and file headers that begin with a question word.
pub fn questions(files: &[SourceFile]) -> Vec<String> {
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| is_checked(file)) {
        let header = || file.text.lines().next().and_then(|line| line.strip_prefix("//"));
        let docs = if file.is_rust() {
            docs(&file.text)
        } else {
            header().map(|text| Doc::new(1, text)).into_iter().collect()
        };
        for doc in docs.into_iter().filter(|doc| QUESTIONS.contains(&first_word(doc.text))) {
            let reason = format!("name the thing instead of asking '{}'", doc.text);
            findings.push(file.finding(doc.line, &reason));
        }
    }
    findings
}

/// Finds lines of comments that are too wide, except for addresses and tables.
pub fn width(files: &[SourceFile]) -> Vec<String> {
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| is_checked(file)) {
        for (line, text) in (1..).zip(file.text.lines()) {
            let Some(comment) = text.trim_start().strip_prefix("//") else { continue };
            let comment = comment.trim_start_matches(['/', '!']).trim_start();
            let may_be_wide = comment.starts_with('|') || comment.contains("://");
            if !may_be_wide && text.chars().count() > MAX_COLUMNS {
                let reason = format!("comments wrap at {MAX_COLUMNS} columns");
                findings.push(file.finding(line, &reason));
            }
        }
    }
    findings
}

/// Returns true for code whose comments the rules are about.
fn is_checked(file: &SourceFile) -> bool {
    file.is_rust() || file.is_stage() || file.extension() == "glsl"
}

/// The first line of a block of documentation.
struct Doc<'a> {
    line: usize,
    text: &'a str,
    is_of_function: bool,
}

impl<'a> Doc<'a> {
    fn new(line: usize, text: &'a str) -> Self {
        Self { line, text: text.trim(), is_of_function: false }
    }
}

/// Returns the first line of each block of documentation.
fn docs(text: &str) -> Vec<Doc<'_>> {
    let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
    let mut docs = Vec::new();
    for mark in ["///", "//!"] {
        let is_doc = |at: usize| lines.get(at).is_some_and(|line| line.starts_with(mark));
        for at in (0..lines.len()).filter(|at| is_doc(*at) && (*at == 0 || !is_doc(*at - 1))) {
            let end = (at..).find(|line| !is_doc(*line)).unwrap_or(lines.len());
            let mut doc = Doc::new(at + 1, &lines[at][mark.len()..]);
            doc.is_of_function = mark == "///" && begins_function(&lines[end..]);
            docs.push(doc);
        }
    }
    docs
}

/// Returns true if a function follows, after its attributes.
fn begins_function(lines: &[&str]) -> bool {
    let mut in_attribute = false;
    for line in lines {
        in_attribute |= line.starts_with("#[");
        if !in_attribute {
            let visible =
                line.strip_prefix("pub").map_or(*line, |rest| match rest.split_once(") ") {
                    Some((inside, rest)) if inside.starts_with('(') => rest,
                    _ => rest,
                });
            let mut words = visible.split_whitespace();
            let qualifiers = ["const", "async", "unsafe", "extern", "\"C\""];
            return words.find(|word| !qualifiers.contains(word)) == Some("fn");
        }
        in_attribute = !line.trim_end().ends_with(']');
    }
    false
}

/// Returns the first word of a text, without the punctuation after it.
fn first_word(text: &str) -> &str {
    let text = text.trim_start();
    text.split(|c: char| !c.is_alphanumeric() && !['\'', '-', '`'].contains(&c))
        .next()
        .unwrap_or_default()
}

#[test]
fn docs_of_functions_begin_with_a_verb() {
    assert_obeyed(function_verbs);
    let forbidden = [
        "/// The number.\nfn a() -> u32 {}\n",
        "/// returns a number.\nfn a() -> u32 {}\n",
        "/// Return a number.\nfn a() -> u32 {}\n",
        "/// This is a number.\nfn a() -> u32 {}\n",
        "//! A.\n\nimpl A {\n    /// As [`b`].\n    ///\n    /// Returns.\n    pub(crate) const fn a();\n}\n",
        "/// A test.\n#[test]\n#[cfg(\n    unix\n)]\nfn a() {}\n",
        "/// `a` is a number.\npub unsafe extern \"C\" fn a() {}\n",
    ];
    for text in forbidden {
        assert_catches(function_verbs, &[("a.rs", text)]);
    }
    let allowed = [
        "/// Returns a number.\n///\n/// # Errors\n/// None.\n#[must_use]\npub fn a() {}\n",
        "/// Re-reads, then writes.\nfn a() {}\n/// Reads, or fails.\nfn b() {}\n",
        "/// A number.\npub type A = fn(u32);\n/// A number.\nstruct A { a: fn() }\n",
        "//! The numbers.\n\n// The first.\nfn a() {}\n",
    ];
    assert_permits(function_verbs, &allowed.map(|text| ("a.rs", text)));
}

#[test]
fn docs_and_headers_ask_no_questions() {
    assert_obeyed(questions);
    let forbidden = [
        ("a.rs", "//! What it does.\n"),
        ("a.rs", "//! A.\n\n/// How many.\nconst A: u32 = 1;\n"),
        ("a.rs", "enum A {\n    /// Whether it is.\n    B(bool),\n}\n"),
        ("a.rs", "mod a {\n    //! Where it is.\n}\n"),
        ("shaders/a.glsl", "// What is the same.\n"),
    ];
    for file in forbidden {
        assert_catches(questions, &[file]);
    }
    let allowed = [
        ("a.rs", "//! A.\n//! What follows.\n\n// What follows.\n/// Whatsoever.\nstruct A;\n"),
        ("shaders/a.glsl", "// A.\n// What follows.\n"),
        ("a.md", "What follows.\n"),
    ];
    assert_permits(questions, &allowed);
}

#[test]
fn comments_wrap() {
    assert_obeyed(width);
    let words = |columns: usize| "a ".repeat(columns / 2);
    for mark in ["//", "///", "//!", "    //"] {
        let wide = format!("{mark} {}\n", words(100));
        assert_catches(width, &[("a.rs", &wide), ("shaders/a.comp", &wide)]);
    }
    let allowed = [
        format!("// {}\n", words(96)),
        format!("/// <https://example.org/{}>\n", "a".repeat(100)),
        format!("/// | {}|\n", words(100)),
        format!("let a = \"{}\";\n", words(100)),
    ];
    for text in &allowed {
        assert_permits(width, &[("a.rs", text)]);
    }
}
