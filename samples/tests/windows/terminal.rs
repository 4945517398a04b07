//! Runs the window programs in terminals and outside of them.

use harness::Scratch;
use harness::terminal::{
    assert_names_give_no_orders, assert_readers_may_go, help_that_fits, in_terminal,
};

use crate::{CITY, TRIANGLE, VIEWER};

#[test]
fn help_fits_the_terminal_and_tells_the_keys() {
    let scratch = Scratch::new("terminal-windows");
    for columns in [80, 200] {
        for program in [CITY, VIEWER] {
            let help = help_that_fits(&scratch, program, columns);
            assert!(help.contains("Keys in the window"), "{help}");
        }
        let help = in_terminal(&scratch, columns, &[], &format!("{TRIANGLE} --help"));
        assert_eq!(help, "usage: triangle [--headless]\n");
    }
}

#[test]
fn names_of_files_give_no_orders() {
    let scratch = Scratch::new("terminal-window-names");
    for (program, option) in [(VIEWER, None), (CITY, Some("--script")), (CITY, Some("--trace"))] {
        assert_names_give_no_orders(&scratch, program, option, &["--headless"]);
    }
}

#[test]
fn a_reader_that_has_seen_enough_is_a_success() {
    let scratch = Scratch::new("terminal-window-closed");
    [CITY, VIEWER].iter().for_each(|program| assert_readers_may_go(&scratch, program));
}
