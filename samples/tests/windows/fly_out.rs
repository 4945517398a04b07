//! Runs `city` for an animation, and reads its images.

use std::fs;
use std::io::Cursor;

use harness::{Scratch, program, stderr};

const ARGUMENTS: [&str; 9] =
    ["--headless", "--objects", "500", "--size", "64x36", "--frames", "9", "--device", "llvmpipe"];

/// Returns the images of an animation, as the places of their pixels in its palette.
fn images(file: &[u8]) -> Vec<Vec<u8>> {
    let mut reader = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (64, 36));
    let count = reader.info().animation_control().unwrap().num_frames;
    let mut next = || {
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    };
    (0..count).map(|_| next()).collect()
}

#[test]
fn an_animation_has_its_images_and_is_the_same_each_time() {
    let scratch = Scratch::new("fly-out");
    let files = ["a.png", "b.png"].map(|name| {
        let line = [&ARGUMENTS[..], &["--fly-out", name, "--validation", "sync"]].concat();
        let output = program(crate::CITY, &scratch.0, &line).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        fs::read(scratch.0.join(name)).unwrap()
    });
    assert!(files[0] == files[1]);
    let images = images(&files[0]);
    assert_eq!(images.len(), 9);
    assert!(images.windows(2).all(|pair| pair[0] != pair[1]), "all of it moves");
}

#[test]
fn an_animation_without_a_place_or_a_street_is_refused() {
    let scratch = Scratch::new("fly-out-refused");
    for (more, reason) in [
        (["--fly-out", "nowhere/a.png", "--scene", "city"], "there is no folder 'nowhere'"),
        (["--fly-out", "a.png", "--scene", "waffle"], "no streets"),
    ] {
        let line = [&ARGUMENTS[..], &more].concat();
        let output = program(crate::CITY, &scratch.0, &line).output().unwrap();
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(reason) && message.lines().count() == 1, "{message}");
    }
    assert!(scratch.names(".").is_empty(), "nothing is left behind");
}
