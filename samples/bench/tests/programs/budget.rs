//! The budget of a frame, measured over a short walk.

use harness::Scratch;

use crate::{stdout, succeeded};

#[test]
fn the_parts_of_a_budget_add_up_to_the_time_over_the_ideal() {
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
    assert_eq!(parts.len(), 7, "{table}");
    let added: f64 = parts.iter().map(|line| column(line, 4)).sum();
    assert!((added - column(sum, 4)).abs() < 0.1, "{table}");
    assert!(parts.iter().all(|line| column(line, 2) > 0.0), "{table}");
}
