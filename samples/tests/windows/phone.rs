//! Programs on a device that lacks what phones often lack.

use std::fs;

use harness::{PhoneLoader, Scratch, pixels, program, scene};

const FRAMES: [&str; 9] = [
    "--headless",
    "--frames",
    "8",
    "--size",
    "160x90",
    "--device",
    "llvmpipe",
    "--cost-model",
    "off",
];

/// Checks that the images of a program on the device are those without culling.
fn assert_exact(name: &str, file: &str, arguments: &[&str]) {
    let loader = PhoneLoader::new(&format!("phone-{name}-loader"));
    let scratch = Scratch::new(&format!("phone-{name}"));
    fs::write(scratch.0.join("file.glb"), scene::small()).unwrap();
    let run = |strategy| {
        let how = ["--strategy", strategy, "--out", strategy];
        loader.run(program(file, &scratch.0, &[arguments, &FRAMES[..], &how].concat()));
        scratch.names(strategy)
    };
    let frustum = run("frustum");
    let culled = run("antumbra");
    assert_eq!((culled.len(), &culled), (8, &frustum));
    for image in &culled {
        let of = |strategy: &str| pixels(&scratch.0.join(strategy).join(image));
        assert!(of("antumbra") == of("frustum"), "{name}: {image} is another image");
    }
}

#[test]
fn city_is_exact_on_a_phone() {
    assert_exact("city", crate::CITY, &["--objects", "300", "--path", "cut"]);
}

#[test]
fn shadows_are_exact_on_a_phone() {
    assert_exact("shadows", env!("CARGO_BIN_EXE_shadows"), &[]);
}

#[test]
fn viewer_is_exact_on_a_phone() {
    assert_exact("viewer", crate::VIEWER, &["file.glb"]);
}
