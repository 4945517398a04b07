//! Runs the programs inside and outside terminals: colours, widths, progress, names.

use harness::terminal::{
    assert_names_give_no_orders, assert_readers_may_go, help_that_fits, in_terminal,
};
use harness::{Scratch, stderr};

use crate::{WALKTHROUGH, walkthrough};

const SMALL: &str = "--objects=200 --frames=12 --size=64x48 --device=llvmpipe --cost-model=off";

/// The programs of this package.
const PROGRAMS: &[&str] = &[
    WALKTHROUGH,
    #[cfg(feature = "charts")]
    env!("CARGO_BIN_EXE_compare"),
];

#[test]
fn help_and_table_fit_the_terminal() {
    let scratch = Scratch::new("terminal-width");
    for columns in [80, 200] {
        for program in PROGRAMS {
            let help = help_that_fits(&scratch, program, columns);
            assert!(!help.contains("Keys in the window"), "{help}");
        }
        let line = format!("{} --quiet {SMALL}", WALKTHROUGH);
        let table = in_terminal(&scratch, columns, &[], &line);
        for line in table.lines() {
            assert!(line.chars().count() <= columns as usize, "{columns}: {line}");
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
    let help = format!("{} --help", WALKTHROUGH);
    // A cache that cannot be written causes a warning in the log.
    let walk = format!("XDG_CACHE_HOME=/proc/nowhere {} {SMALL}", WALKTHROUGH);
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
    // A bar is redrawn, so it is left out if lines cannot be rewritten.
    let said = in_terminal(&scratch, 80, &[("TERM", "dumb")], &walk);
    assert!(!escape(&said) && said.contains("12 of 12 frames"), "{said}");
    let mut piped = walkthrough(&scratch.0, &SMALL.split(' ').collect::<Vec<_>>());
    piped.env("TERM", "xterm-256color").env("XDG_CACHE_HOME", "/proc/nowhere");
    let said = stderr(&piped.output().expect("it starts"));
    // A sentence for people, without a time or a module in front.
    assert!(said.lines().any(|line| line.trim_start().starts_with("WARN ")), "{said}");
    assert!(!escape(&said) && !said.contains("bench::"), "{said}");
}

#[test]
fn progress_counts_and_does_not_guess() {
    let scratch = Scratch::new("terminal-progress");
    let program = WALKTHROUGH;
    // A bar is drawn at most 20 times per second, so a walk of a few frames may end before the
    // first bar.
    let long = SMALL.replace("--frames=12", "--frames=1000");
    let walk = format!("{program} {long} --strategy=ideal,antumbra");
    let said = in_terminal(&scratch, 120, &[], &walk);
    let bars: Vec<&str> = said.split('\r').collect();
    let counts = |what: &str| bars.iter().any(|bar| bar.contains(" frames") && bar.contains(what));
    assert!(counts("/1000 frames  finding the visible sets"), "{said}");
    assert!(counts("frames  ideal") || counts("frames  antumbra"), "{said}");
    assert!(!said.contains(" 0s left"), "{said}");
    let walk = format!("{SMALL} --strategy=ideal,antumbra");
    let piped = walkthrough(&scratch.0, &walk.split(' ').collect::<Vec<_>>()).output();
    let said = stderr(&piped.expect("it starts"));
    assert!(said.contains("finding the visible sets: 12 of 12 frames"), "{said}");
}

#[test]
fn names_of_files_give_no_orders() {
    let scratch = Scratch::new("terminal-names");
    assert_names_give_no_orders(&scratch, WALKTHROUGH, Some("--report"), &["--quiet"]);
    PROGRAMS[1..].iter().for_each(|compare| {
        assert_names_give_no_orders(&scratch, compare, None, &[]);
    });
}

#[test]
fn a_reader_that_has_seen_enough_is_a_success() {
    let scratch = Scratch::new("results-closed");
    PROGRAMS.iter().for_each(|program| assert_readers_may_go(&scratch, program));
}
