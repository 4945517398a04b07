//! Ends of programs by a fault of Vulkan.

use std::fs;

use harness::{assert_faults_end_programs, program, scene};

const FRAMES: [&str; 9] = [
    "--headless",
    "--frames",
    "12",
    "--size",
    "64x36",
    "--device",
    "llvmpipe",
    "--cost-model",
    "off",
];

#[test]
fn city_ends_with_1_and_the_call_and_its_code() {
    assert_faults_end_programs("city-fault", |folder| {
        program(crate::CITY, folder, &[&FRAMES[..], &["--objects", "50"]].concat())
    });
}

#[test]
fn viewer_ends_with_1_and_the_call_and_its_code() {
    assert_faults_end_programs("viewer-fault", |folder| {
        fs::write(folder.join("file.glb"), scene::thin()).unwrap();
        program(crate::VIEWER, folder, &[&["file.glb"], &FRAMES[..]].concat())
    });
}
