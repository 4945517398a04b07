//! Runs a program in a terminal, and checks the behaviour that all of ours share.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::{Scratch, cache, program, stderr};

/// Runs a command line in a terminal of so many columns. Returns the terminal's text.
pub fn in_terminal(
    scratch: &Scratch,
    columns: u32,
    variables: &[(&str, &str)],
    line: &str,
) -> String {
    let line = format!("stty cols {columns} rows 40; {line}");
    let mut command = Command::new("script");
    command.current_dir(&scratch.0).args(["-qec", &line, "/dev/null"]);
    command.env("TERM", "xterm-256color").env_remove("NO_COLOR").envs(variables.iter().copied());
    command.env("XDG_CACHE_HOME", cache());
    let output = command.stdin(Stdio::null()).output().expect("bsdutils has it");
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8_lossy(&output.stdout).replace("\r\n", "\n")
}

/// Words that the documentation avoids.
const AVOIDED: [&str; 7] = ["told", "tells", "home", "bring", "brings", "brought", "anew"];
/// Words that turn a description into a question.
const QUESTIONS: [&str; 8] = ["What", "Who", "Whose", "Whether", "How", "Where", "When", "Whoever"];

/// Returns the help of a program. Checks that it fits the terminal, explains the exit codes, and is
/// in plain words.
pub fn help_that_fits(scratch: &Scratch, program: &str, columns: u32) -> String {
    let help = in_terminal(scratch, columns, &[("NO_COLOR", "1")], &format!("{program} --help"));
    for line in help.lines() {
        assert!(line.chars().count() <= columns.min(100) as usize, "{program}, {columns}: {line}");
    }
    assert!(help.contains("Exit codes: 0"), "{help}");
    assert_plain(program, &help);
    help
}

/// Checks that a help has no name of a type, no word that the documentation avoids, and no
/// description that begins like a question.
fn assert_plain(program: &str, help: &str) {
    for word in help.split(|c: char| !c.is_alphanumeric() && c != '_') {
        assert!(!is_camel_case(word) || word == "RenderDoc", "{program}: {word} in\n{help}");
        assert!(!AVOIDED.contains(&word.to_lowercase().as_str()), "{program}: {word} in\n{help}");
    }
    for line in help.lines().map(str::trim_start) {
        let description = match line.strip_prefix("- ") {
            Some(value) => value.split_once(": ").map_or(value, |(_, description)| description),
            None => line,
        };
        let first = description.split_whitespace().next().unwrap_or_default();
        assert!(!QUESTIONS.contains(&first), "{program}: {line}");
    }
}

/// Returns true for a word such as `TypeName`, but not for `WxH`.
fn is_camel_case(word: &str) -> bool {
    let humps = word.split_inclusive(char::is_lowercase).filter(|part| {
        part.len() > 1 && part.starts_with(char::is_uppercase) && part.ends_with(char::is_lowercase)
    });
    word.starts_with(char::is_uppercase) && humps.count() > 1
}

/// Checks that a reader of the help may go early, and that a full disk is an error.
pub fn assert_readers_may_go(scratch: &Scratch, program: &str) {
    let mut command = Command::new(program);
    command.current_dir(&scratch.0).arg("--help").stdout(Stdio::piped());
    let mut child = command.spawn().expect("it starts");
    drop(child.stdout.take());
    assert_eq!(child.wait().expect("it ends").code(), Some(0), "{program}");
    let full = File::create("/dev/full").expect("a device");
    let output = command.stdout(full).output().expect("it starts");
    assert_eq!(output.status.code(), Some(1), "{program}");
}

/// Checks that a program refuses files in a line that a terminal shows and does not obey: files
/// that are no scene, no script and no report; after some options, files below which it is to
/// write.
pub fn assert_names_give_no_orders(
    scratch: &Scratch,
    path: &str,
    option: Option<&str>,
    more: &[&str],
) {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    for (name, text) in [
        (&b"a\x1b[31m.glb"[..], "a\\x1b[31m.glb"),
        (b"a\nerror: b.glb", "a\\nerror: b.glb"),
        (b"a\xff.glb", "a\\xff.glb"),
    ] {
        let name = OsStr::from_bytes(name);
        fs::write(scratch.0.join(name), "no glTF").expect("the target folder is writable");
        let mut command = program(path, &scratch.0, more);
        command.args(option);
        match option {
            Some("--report" | "--trace") => command.arg(Path::new(name).join("below")),
            _ => command.arg(name),
        };
        let output = command.output().expect("it starts");
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{path} {option:?}: {said}");
        assert!(said.contains(text), "{path} {option:?}: {said}");
        assert!(!said.contains('\u{1b}') && said.lines().count() == 1, "{path}: {said}");
    }
}
