//! The budget of a frame, measured over a short walk.

use harness::Scratch;

use crate::{stdout, succeeded};

#[test]
fn a_budget_has_a_row_for_each_part_and_equal_images() {
    let scratch = Scratch::new("budget");
    let walk = ["--quiet", "--device", "llvmpipe", "--objects", "300", "--size", "96x54"];
    let frames = ["--frames", "4", "--path", "street"];
    let arguments = [&walk[..], &frames].concat();
    let program = env!("CARGO_BIN_EXE_budget");
    // The program itself compares the images of all parts with plain frustum culling.
    let output = succeeded(&mut harness::program(program, &scratch.0, &arguments));
    let table = stdout(&output);
    let column = |line: &str, number: usize| -> f64 {
        line.split('|').nth(number).and_then(|cell| cell.trim().parse().ok()).expect(line)
    };
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    let (sum, parts) = rows.split_last().expect("a sum");
    assert_eq!(parts.len(), 8, "{table}");
    // Medians of differences add up but for noise; the first row adds nothing.
    assert_eq!([column(parts[0], 4), column(parts[0], 5)], [0.0, 0.0], "{table}");
    assert!(sum.starts_with("| over the ideal |"), "{table}");
    assert!(parts.iter().all(|line| column(line, 2) > 0.0), "{table}");
}

#[test]
fn options_of_other_programs_are_refused() {
    let scratch = Scratch::new("budget-options");
    for option in ["--moving-percent=10", "--views=2", "--verify=every", "--strategy=chc"] {
        let mut program = harness::program(env!("CARGO_BIN_EXE_budget"), &scratch.0, &[option]);
        let output = program.output().expect("it starts");
        assert_eq!(output.status.code(), Some(2), "{option}");
        assert!(output.stdout.is_empty(), "{option}");
    }
}
