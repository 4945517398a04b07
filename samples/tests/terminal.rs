//! Runs the programs in terminals and outside of them: colours, widths, progress, names.
#![cfg(target_os = "linux")]
#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

#[allow(dead_code, reason = "shared with other tests")]
mod program;

use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::{Command, Stdio};

use program::{Scratch, stderr, walkthrough};

const SMALL: &str = "--objects=200 --frames=12 --size=64x48 --device=llvmpipe --costs=ignored";

fn path_of(program: &str) -> String {
    let walkthrough = Path::new(env!("CARGO_BIN_EXE_walkthrough"));
    walkthrough.with_file_name(program).to_string_lossy().into_owned()
}

/// What a command line shows in a terminal of so many columns.
fn in_terminal(scratch: &Scratch, columns: u32, variables: &[(&str, &str)], line: &str) -> String {
    let line = format!("stty cols {columns} rows 40; {line}");
    let mut command = Command::new("script");
    command.current_dir(&scratch.0).args(["-qec", &line, "/dev/null"]);
    command.env("TERM", "xterm-256color").env_remove("NO_COLOR").envs(variables.iter().copied());
    command.env("XDG_CACHE_HOME", Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache"));
    let output = command.stdin(Stdio::null()).output().expect("bsdutils has it");
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8_lossy(&output.stdout).replace("\r\n", "\n")
}

#[test]
fn help_and_table_fit_the_terminal() {
    let scratch = Scratch::new("terminal-width");
    for (columns, widest) in [(80, 80), (200, 200)] {
        for program in ["walkthrough", "city", "viewer", "compare"] {
            let line = format!("{} --help", path_of(program));
            let help = in_terminal(&scratch, columns, &[("NO_COLOR", "1")], &line);
            for line in help.lines() {
                assert!(line.chars().count() <= widest.min(100), "{program}, {columns}: {line}");
            }
            assert!(help.contains("Exit codes: 0"), "{help}");
            assert_eq!(help.contains("Keys in the window"), matches!(program, "city" | "viewer"));
        }
        let help = in_terminal(&scratch, columns, &[], &format!("{} --help", path_of("triangle")));
        assert_eq!(help, "usage: triangle [--headless]\n");
        let line = format!("{} --quiet {SMALL}", path_of("walkthrough"));
        let table = in_terminal(&scratch, columns, &[], &line);
        for line in table.lines() {
            assert!(line.chars().count() <= widest, "{columns}: {line}");
        }
        let blocks = table.matches("strategy").count();
        assert_eq!(blocks, if columns == 80 { 2 } else { 1 }, "{table}");
        for column in ["triangles", "queries", "waits", "pixels"] {
            assert!(table.contains(column), "{table}");
        }
    }
}

#[test]
fn colours_are_for_terminals_that_want_them() {
    let scratch = Scratch::new("terminal-colours");
    let help = format!("{} --help", path_of("city"));
    // A cache that cannot be written is a warning on the log.
    let walk = format!("XDG_CACHE_HOME=/proc/nowhere {} {SMALL}", path_of("walkthrough"));
    let escape = |text: &str| text.contains("\u{1b}[");
    for (variables, is_coloured) in [
        (&[("TERM", "xterm-256color")][..], true),
        (&[("TERM", "xterm-256color"), ("NO_COLOR", "1")], false),
        (&[("TERM", "dumb")], false),
        (&[("TERM", "dumb"), ("CLICOLOR_FORCE", "1")], false),
    ] {
        let help = in_terminal(&scratch, 80, variables, &help);
        assert_eq!(escape(&help), is_coloured, "{variables:?}: {help}");
        let said = in_terminal(&scratch, 80, variables, &format!("{walk} --quiet"));
        assert!(said.contains("WARN"), "{said}");
        assert_eq!(escape(&said), is_coloured, "{variables:?}: {said}");
    }
    // A bar is drawn again and again: not where lines cannot be.
    let said = in_terminal(&scratch, 80, &[("TERM", "dumb")], &walk);
    assert!(!escape(&said) && said.contains("12 of 12 frames"), "{said}");
    let mut piped = walkthrough(&scratch.0, &SMALL.split(' ').collect::<Vec<_>>());
    piped.env("TERM", "xterm-256color").env("XDG_CACHE_HOME", "/proc/nowhere");
    let said = stderr(&piped.output().expect("it starts"));
    // A sentence for people: no time and no module before it.
    assert!(said.lines().any(|line| line.trim_start().starts_with("WARN ")), "{said}");
    assert!(!escape(&said) && !said.contains("samples::"), "{said}");
}

#[test]
fn progress_counts_and_does_not_guess() {
    let scratch = Scratch::new("terminal-progress");
    let program = path_of("walkthrough");
    // A bar is drawn at most 20 times per second: a walk of a few frames may be over before.
    let long = SMALL.replace("--frames=12", "--frames=1000");
    let walk = format!("{program} {long} --strategy=ideal,antumbra");
    let said = in_terminal(&scratch, 120, &[], &walk);
    let bars: Vec<&str> = said.split('\r').collect();
    let counts = |what: &str| bars.iter().any(|bar| bar.contains(" frames") && bar.contains(what));
    assert!(counts("/1000 frames  finding out what is visible"), "{said}");
    assert!(counts("frames  ideal") || counts("frames  antumbra"), "{said}");
    assert!(!said.contains("0s left"), "{said}");
    let walk = format!("{SMALL} --strategy=ideal,antumbra");
    let piped = walkthrough(&scratch.0, &walk.split(' ').collect::<Vec<_>>()).output();
    let said = stderr(&piped.expect("it starts"));
    assert!(said.contains("finding out what is visible: 12 of 12 frames"), "{said}");
}

#[test]
fn names_of_files_give_no_orders() {
    let scratch = Scratch::new("terminal-names");
    let names: [&[u8]; 3] = [b"a\x1b[31m.glb", b"a\nerror: b.glb", b"a\xff.glb"];
    for (name, text) in names.into_iter().zip(["a\\x1b[31m.glb", "a\\nerror: b.glb", "a\\xff.glb"])
    {
        let name = std::ffi::OsStr::from_bytes(name);
        fs::write(scratch.0.join(name), "no glTF").expect("the target folder is writable");
        for (program, option) in [
            ("walkthrough", Some("--report")),
            ("viewer", None),
            ("city", Some("--script")),
            ("city", Some("--trace")),
            ("compare", None),
        ] {
            let mut command = Command::new(path_of(program));
            command.current_dir(&scratch.0).args(option);
            // Below a file, nothing can be written.
            match option {
                Some("--report" | "--trace") => command.arg(Path::new(name).join("below")),
                _ => command.arg(name),
            };
            if program != "compare" {
                command.args(if program == "walkthrough" {
                    &["--quiet"][..]
                } else {
                    &["--headless"]
                });
            }
            let output = command.output().expect("it starts");
            let said = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{program} {option:?}: {said}");
            assert!(said.contains(text), "{program} {option:?}: {said}");
            assert!(!said.contains('\u{1b}') && said.lines().count() == 1, "{program}: {said}");
        }
    }
}
