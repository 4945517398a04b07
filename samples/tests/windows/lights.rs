//! The hour of the day and shadows in `city` and `shadows`, without a window.

use std::fs;

use harness::{Scratch, pixels, program, stderr};

const SHADOWS: &str = env!("CARGO_BIN_EXE_shadows");

/// Runs a script with images of every frame; returns the log.
fn run(program_file: &str, scratch: &Scratch, script: &str, arguments: &[&str]) -> String {
    fs::write(scratch.0.join("script"), script).unwrap();
    let all = ["--headless", "--size", "160x96", "--script", "script", "--out", "out"];
    let rest = ["--device", "llvmpipe", "--validation", "sync", "--cost-model", "off"];
    let mut command = program(program_file, &scratch.0, &[&all[..], &rest, arguments].concat());
    command.env("RUST_LOG", "samples=info");
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    stderr(&output)
}

fn frame(scratch: &Scratch, number: u32) -> Vec<[u8; 3]> {
    pixels(&scratch.0.join(format!("out/frame_{number:05}.png")))
}

fn brightness(image: &[[u8; 3]]) -> u64 {
    image.iter().flatten().map(|part| u64::from(*part)).sum()
}

#[test]
fn a_lit_city_has_hours_shadows_and_filters() {
    let scratch = Scratch::new("lit-city");
    let script = "1 shadows off\n2 shadows maps_uncached\n3 filter pcf3\n4 hour 22\n5 hour\n";
    let lit = ["--objects", "400", "--time-of-day", "14", "--shadows", "maps", "--frames", "6"];
    let log = run(crate::CITY, &scratch, script, &lit);
    for said in [
        "shadows off",
        "shadows maps_uncached, adaptive",
        "shadows maps_uncached, pcf3",
        "the hour is 22:00",
        "the hour is 23:00",
    ] {
        assert!(log.contains(said), "{said}: {log}");
    }
    let images: Vec<Vec<[u8; 3]>> = (0..6).map(|number| frame(&scratch, number)).collect();
    assert!(images[0] != images[1], "there are shadows");
    assert!(brightness(&images[0]) < brightness(&images[1]), "and they are dark");
    assert!(images[0] == images[2], "those of a cache are those without");
    assert!(brightness(&images[4]) * 2 < brightness(&images[3]), "it is night");
    assert!(images[4] != images[5], "the moon moves");
}

#[test]
fn a_plain_city_gets_its_lights_when_they_are_first_asked_for() {
    let walk = ["--objects", "100", "--path", "street", "--frames", "5"];
    let lit = Scratch::new("lit-at-once");
    let at_once = [&walk[..], &["--time-of-day", "13:30", "--shadows", "maps"]].concat();
    run(crate::CITY, &lit, "", &at_once);
    for (name, script, told) in [
        ("lit-by-shadows", "2 shadows maps\n", "shadows maps, adaptive"),
        ("lit-by-hour", "2 hour\n2 shadows maps\n", "the hour is 13:30"),
    ] {
        let scratch = Scratch::new(name);
        let log = run(crate::CITY, &scratch, script, &walk);
        assert!(log.contains(told) && !log.contains("WARN"), "{log}");
        assert!(frame(&scratch, 1) != frame(&lit, 1), "plain at first");
        // The walk goes on where it was.
        assert!((2..5).all(|number| frame(&scratch, number) == frame(&lit, number)), "{name}");
    }
}

#[test]
fn the_courtyard_moves_and_is_exact_with_each_filter() {
    let scratch = Scratch::new("courtyard");
    let filters = ["single", "pcf3", "adaptive", "pcss", "fixed64", "pcss64"];
    let script: String =
        (1..).zip(filters).map(|(frame, name)| format!("{} filter {name}\n", 2 * frame)).collect();
    let log = run(SHADOWS, &scratch, &("1 compare\n".to_owned() + &script), &["--frames", "14"]);
    for filter in filters {
        assert!(log.contains(&format!("shadows maps, {filter}")), "{filter}: {log}");
    }
    assert!(log.contains("antumbra: 0 pixels differ in"), "{log}");
    let [first, second] = [0, 1].map(|number| frame(&scratch, number));
    assert!(first != second, "the lantern moves");
}

/// Returns the number of pixels of which a channel differs by more than two steps.
fn differing(one: &[[u8; 3]], other: &[[u8; 3]]) -> usize {
    let differs =
        |(a, b): &(&[u8; 3], &[u8; 3])| a.iter().zip(b.iter()).any(|(a, b)| a.abs_diff(*b) > 2);
    one.iter().zip(other).filter(differs).count()
}

#[test]
fn lamps_flare_and_a_spot_projects_a_picture_until_keys_end_it() {
    let scratch = Scratch::new("flares");
    let frames = |script: &str, arguments: &[&str]| {
        // Nothing is overwritten.
        let _absent = fs::remove_dir_all(scratch.0.join("out"));
        let all = [arguments, &["--time-of-day", "21", "--frames", "18"]].concat();
        let log = run(SHADOWS, &scratch, script, &all);
        (log, frame(&scratch, 15), frame(&scratch, 17))
    };
    let (log, lit, without) = frames("16 flares\n", &[]);
    assert!(log.contains("no lens flares"), "{log}");
    let (log, plain, begun) = frames("16 flares\n", &["--flares", "off"]);
    assert!(log.contains("lens flares") && !log.contains("no lens flares"), "{log}");
    let more = brightness(&lit) - brightness(&plain);
    assert!(more > 5_000, "flares add light: {more}");
    assert!(differing(&lit, &plain) > 300, "{}", differing(&lit, &plain));
    assert!(without != lit && begun != plain, "the key has an effect");
    let (log, coloured, white) = frames("16 pictures\n", &["--flares", "off"]);
    assert!(log.contains("no spot projects a picture"), "{log}");
    assert!(coloured == plain);
    let colourful = |image: &[[u8; 3]]| {
        let is_blue = |[red, _, blue]: &&[u8; 3]| *blue > 120 && *blue - 60 > *red;
        image.iter().filter(is_blue).count()
    };
    let [panes, none] = [&coloured, &white].map(|image| colourful(image));
    assert!(panes > 100 && none * 10 < panes, "{panes} and {none} blue pixels");
    let script = "2 pictures\n3 detail_by_samples\n4 flares\n";
    let log = run(crate::CITY, &scratch, script, &["--objects", "100", "--frames", "6"]);
    // A plain city gets the lights that flare when it is first asked for flares.
    for said in ["no light of the scene projects a picture", "no levels of detail", "lens flares"] {
        assert!(log.contains(said), "{said}: {log}");
    }
}

#[test]
fn lights_that_cannot_be_are_refused() {
    let scratch = Scratch::new("bad-lights");
    for (program_file, arguments, sentence) in [
        (SHADOWS, ["--time-of-day", "30"], "'30' is not an hour of the day"),
        (SHADOWS, ["--shadows", "stencil"], "unknown way to make shadows 'stencil'"),
        (SHADOWS, ["--flares", "bright"], "[possible values: off, on]"),
        (crate::CITY, ["--time-of-day", "NaN"], "'NaN' is not an hour of the day"),
        (crate::CITY, ["--filter", "soft"], "unknown filter 'soft'"),
    ] {
        let output = program(program_file, &scratch.0, &arguments).output().unwrap();
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(sentence) && !message.contains("panicked"), "{message}");
    }
}
