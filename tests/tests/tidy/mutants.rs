//! Rules about the seeded mistakes of `ci/mutants`: they can be made, and name tests that exist.

use std::path::Path;
use std::process::Command;

use crate::files::SourceFile;
use crate::{assert_catches, assert_obeyed};

const FOLDER: &str = "ci/mutants/";

/// Finds mistakes without a test, and names of test programs and modules that no file has: a
/// filter that fits no test passes.
pub fn unknown_tests(files: &[SourceFile]) -> Vec<String> {
    let has = |ends: [String; 2]| {
        files.iter().any(|file| ends.iter().any(|end| file.path.ends_with(end.as_str())))
    };
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.path.starts_with(FOLDER)) {
        let lines = (1..).zip(file.text.lines());
        let tests = lines.filter_map(|(line, text)| Some((line, text.strip_prefix("# Test: ")?)));
        let mut tests = tests.peekable();
        if tests.peek().is_none() {
            findings.push(file.finding(1, "a mistake names the tests that should catch it"));
        }
        for (line, test) in tests {
            let words: Vec<&str> = test.split(' ').collect();
            let behind = |mark: &str| {
                let place = words.iter().position(|word| *word == mark)?;
                words.get(place + 1).copied()
            };
            let program = behind("--test");
            let is_known = program
                .is_none_or(|name| has([format!("/tests/{name}.rs"), format!("/{name}/main.rs")]));
            let module = behind("--").map(|filter| filter.replace("::", "/"));
            let is_there =
                module.is_none_or(|path| has([format!("/{path}.rs"), format!("/{path}/main.rs")]));
            if !is_known || !is_there {
                findings.push(file.finding(line, "there is no such test program or module"));
            }
        }
    }
    findings
}

/// Finds mistakes that cannot be made any more, because the code has changed.
fn stale(files: &[SourceFile]) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let check = |file: &&SourceFile| {
        let check = ["apply", "--check", "-C1", file.path.as_str()];
        let output = Command::new("git").args(check).current_dir(&root).output().expect("git");
        !output.status.success()
    };
    let patches = files.iter().filter(|file| file.path.starts_with(FOLDER)).filter(check);
    patches
        .map(|file| file.finding(1, "does not apply: make the same mistake in the new code"))
        .collect()
}

#[test]
fn seeded_mistakes_can_be_made_and_name_their_tests() {
    assert_obeyed(unknown_tests);
    assert_obeyed(stale);
    assert_catches(
        unknown_tests,
        &[
            ("ci/mutants/a.patch", "# A mistake.\n"),
            ("ci/mutants/a.patch", "# A mistake.\n# Test: --test nowhere\n"),
            ("ci/mutants/a.patch", "# A mistake.\n# Test: --lib -- no::module\n"),
        ],
    );
    assert_catches(stale, &[("ci/mutants/none.patch", "# A mistake.\n")]);
}
