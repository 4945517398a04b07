//! Runs `city` without a window, with good and bad input.

use std::fs;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use bench::args::Arguments;
use bench::exit_status;
use bench::progress;
use bench::run::walk_on;
use bench::signals::Signals;
use clap::Parser;
use harness::{Scratch, pixels, program, signalled_program, stderr};
use tests::Driver;

const SMALL: [&str; 5] = ["--headless", "--objects", "500", "--size", "160x90"];

fn city(scratch: &Scratch, arguments: &[&str]) -> Output {
    let mut command = program(crate::CITY, &scratch.0, arguments);
    // No test of this file may open a window.
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command.output().expect("the program runs")
}

fn headless(scratch: &Scratch, arguments: &[&str]) {
    let output = city(scratch, &[&SMALL[..], arguments].concat());
    assert!(output.status.success(), "{}", stderr(&output));
}

#[test]
fn no_display_is_said_and_headless_offered() {
    let scratch = Scratch::new("city-no-display");
    let output = city(&scratch, &[]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("no display") && message.contains("--headless"), "{message}");
    let mut command = program(crate::CITY, &scratch.0, &[]);
    command.env_remove("WAYLAND_DISPLAY").env("DISPLAY", ":4711");
    let output = command.output().expect("the program runs");
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("no display") && message.contains("--headless"), "{message}");
}

#[test]
fn what_cannot_be_ends_with_2_and_one_sentence() {
    let scratch = Scratch::new("city-mistakes");
    fs::write(scratch.0.join("bad.txt"), "antumbra path 1\n0 0 1\n").unwrap();
    fs::write(scratch.0.join("bad.script"), "3 hud\n4 jump\n").unwrap();
    // A city of one object has no streets, which is found when it is made: that comes last.
    let no_streets = ["--headless", "--objects", "1", "--size", "160x90", "--path", "street"];
    for (mistake, sentence) in [
        (["--path", "bad.txt"], "bad.txt:2: a frame has 12 or 13 numbers, not 3"),
        (["--path", "missing.txt"], "'missing.txt'"),
        (["--script", "bad.script"], "bad.script:2: unknown action 'jump'"),
        (["--scene", "a.glb"], "`viewer a.glb` shows a file"),
        (["--device", "no such"], "there is no device 'no such'"),
        (["--trace", "/proc/trace.json"], "--trace: cannot write into the folder '/proc'"),
        (["--trace", "nowhere/trace.json"], "there is no folder 'nowhere'"),
        // Found as soon as there is a device, and not with the scene.
        (["--size", "70000x70000"], "the width of the image would be 70000"),
    ] {
        let output = city(&scratch, &[&no_streets[..], &mistake].concat());
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{mistake:?}: {message}");
        assert!(message.contains(sentence) && message.lines().count() == 1, "{message}");
    }
    assert_eq!(scratch.names("."), ["bad.script", "bad.txt"], "nothing is left behind");
}

#[test]
fn without_renderdoc_a_capture_is_refused_with_a_reason() {
    let scratch = Scratch::new("city-capture");
    let output = city(&scratch, &[&SMALL[..], &["--capture", "3"]].concat());
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("renderdoccmd capture"), "{message}");
}

/// Checks that a recorded path is walked again with the same images, by both programs.
#[test]
fn a_recorded_path_is_walked_again_bit_for_bit() {
    let scratch = Scratch::new("city-path");
    fs::write(scratch.0.join("script"), "0 record\n12 record\n").unwrap();
    let record = ["--path", "street", "--frames", "13", "--script", "script", "--out", "first"];
    headless(&scratch, &[&record[..], &["--device", "llvmpipe"]].concat());
    assert!(scratch.names("first").contains(&"path_00012.txt".to_owned()));
    let replay = ["--replay", "first/path_00012.txt", "--frames", "12", "--out", "second"];
    headless(&scratch, &[&replay[..], &["--device", "llvmpipe"]].concat());
    let mut seen = Vec::new();
    for frame in 0..12 {
        let [first, second] = ["first", "second"]
            .map(|folder| pixels(&scratch.0.join(format!("{folder}/frame_{frame:05}.png"))));
        assert!(first == second, "frame {frame} is another");
        seen.push(first);
    }
    assert!(seen[0] != seen[11], "nobody walked");

    let [recorded, out] = ["first/path_00012.txt", "third"]
        .map(|name| scratch.0.join(name).to_string_lossy().into_owned());
    fs::create_dir(&out).unwrap();
    let path = ["walkthrough", "--path", &recorded, "--frames", "12", "--images", "12"];
    let rest = ["--objects", "500", "--size", "160x90", "--strategy", "antumbra"];
    let line = [&path[..], &rest, &["--out", &out, "--verify", "every"]].concat();
    let options = Arguments::try_parse_from(line).unwrap().options().unwrap();
    let signals = Signals::watch().unwrap();
    tests::run(Driver::Lavapipe, |device| {
        let walked = walk_on(device, &options, &*progress::for_terminal(true), &signals).unwrap();
        assert_eq!(
            (exit_status::complaint(&walked.report), walked.images.failures.len()),
            (None, 0)
        );
    });
    for (frame, image) in seen.iter().enumerate() {
        let walked = pixels(&scratch.0.join(format!("third/frame_{frame:05}.png")));
        assert!(walked == *image, "frame {frame} of the walkthrough is another");
    }
}

/// Checks that a driver that lies is not believed where it was tested first: here its fragment
/// shaders write before the depth test.
#[cfg(feature = "shader-compiler")]
#[test]
fn a_driver_that_lies_is_found_and_named() {
    let scratch = Scratch::new("city-trust");
    let shaders = scratch.0.join("shaders");
    copy_shaders(&shaders);
    let shader = shaders.join("proxy.frag");
    let line = "layout(early_fragment_tests) in;";
    let text = fs::read_to_string(&shader).unwrap();
    assert!(text.contains(line));
    fs::write(&shader, text.replace(line, "")).unwrap();
    let line = ["--frames", "2", "--shaders", "shaders", "--device", "llvmpipe", "--quirks"];
    for (quirks, is_named) in [("none", false), ("tested", true)] {
        let output = city(&scratch, &[&SMALL[..], &line, &[quirks]].concat());
        let message = stderr(&output);
        assert!(output.status.success(), "{message}");
        let is_found = message.contains("cannot be trusted with early tests");
        assert_eq!(is_found, is_named, "{message}");
    }
}

/// Checks that no change of strategies and frames in flight changes the image.
#[test]
fn strategies_and_frames_in_flight_change_no_pixel() {
    let scratch = Scratch::new("city-switches");
    let strategies = ["naive", "hzb", "chc", "antumbra_flags", "next_frame", "antumbra"];
    let mut script = String::new();
    for frame in 0..36 {
        // `next_frame` is not exact; here nothing moves, so it is after a few frames.
        script += &format!("{frame} strategy {}\n", strategies[frame / 6]);
        script += &format!("{frame} frames_in_flight {}\n", frame * 7 % 4 + 1);
    }
    fs::write(scratch.0.join("script"), script).unwrap();
    for device in ["llvmpipe", "SwiftShader"] {
        let common = ["--device", device, "--validation", "sync", "--frames", "36"];
        headless(&scratch, &[&common[..], &["--script", "script", "--out", device]].concat());
        let image =
            |frame: usize| pixels(&scratch.0.join(format!("{device}/frame_{frame:05}.png")));
        let first = image(0);
        for frame in (1..36).filter(|frame| frame % 6 == 5 || frame / 6 != 4) {
            assert!(image(frame) == first, "{device}: frame {frame} is another");
        }
    }
}

#[test]
fn explanations_are_drawn_and_go_again() {
    let scratch = Scratch::new("city-explained");
    let script = "2 boxes\n2 top_down\n4 wireframe\n6 hud\n8 boxes\n8 top_down\n8 wireframe\n8 hud\n\
                  8 hud\n10 freeze\n12 freeze\n12 time_passes\n13 time_passes\n14 screenshot\n";
    fs::write(scratch.0.join("script"), script).unwrap();
    let rest = ["--validation", "sync", "--frames", "16", "--script", "script", "--out", "out"];
    // The text has room in it.
    let rest = [&rest[..], &["--size", "320x180"]].concat();
    headless(&scratch, &rest);
    let image = |frame: u32| pixels(&scratch.0.join(format!("out/frame_{frame:05}.png")));
    let plain = image(1);
    for (frame, is_plain) in [
        (2, false),
        (4, false),
        (7, false),
        (8, true),
        (9, true),
        (10, false),
        (12, true),
        (15, true),
    ] {
        assert_eq!(image(frame) == plain, is_plain, "frame {frame}");
    }
    assert!(image(3) != image(5) && image(5) != image(7));
}

/// Checks that a screenshot is the same image as the frame that is written anyway.
#[test]
fn a_screenshot_is_the_frame_it_was_taken_of() {
    let scratch = Scratch::new("city-screenshots");
    fs::write(scratch.0.join("script"), "10 screenshot\n25 screenshot\n").unwrap();
    let rest = ["--path", "street", "--frames", "30", "--script", "script", "--out", "out"];
    headless(&scratch, &rest);
    let bytes = |name: String| fs::read(scratch.0.join("out").join(name)).unwrap();
    let [first, second] = ["00010", "00025"].map(|frame| {
        let shot = bytes(format!("city_{frame}.png"));
        assert!(shot == bytes(format!("frame_{frame}.png")), "the screenshot of frame {frame}");
        shot
    });
    assert!(first != second, "nobody walked");
}

/// Checks that unwritable files are named at the end, which is a failure; all others are written.
#[test]
fn what_cannot_be_written_is_no_success() {
    let scratch = Scratch::new("city-unwritten");
    let script = "0 record\n2 screenshot\n5 record\n";
    fs::write(scratch.0.join("script"), script).unwrap();
    let rest = ["--frames", "8", "--script", "script", "--out", "out", "--trace", "trace.json"];
    // No file may grow beyond 8 KiB: enough for the path, not for an image, nor for the trace.
    let limited = "trap '' XFSZ; ulimit -f 16; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.current_dir(&scratch.0).args(["-c", limited, crate::CITY]);
    command
        .args(SMALL)
        .args(["--size", "320x180"])
        .args(rest)
        .env("XDG_CACHE_HOME", "/proc/nowhere");
    let output = command.output().unwrap();
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("error: 9 images are lost; the first: "), "{message}");
    assert_eq!(message.lines().filter(|line| line.starts_with("error: ")).count(), 1, "{message}");
    assert!(message.contains("wrote out/path_00005.txt"), "{message}");
    assert_eq!(scratch.names("out"), ["path_00005.txt"]);
}

/// Checks that screenshots and paths of an earlier run are left alone.
#[test]
fn names_that_are_taken_are_left_alone() {
    let scratch = Scratch::new("city-again");
    fs::write(scratch.0.join("script"), "0 record\n2 screenshot\n5 record\n").unwrap();
    fs::write(scratch.0.join("city_00002.png"), "mine").unwrap();
    fs::write(scratch.0.join("path_00005.txt"), "mine").unwrap();
    let rest = ["--frames", "8", "--script", "script", "--trace", "trace.json"];
    let output = city(&scratch, &[&SMALL[..], &rest].concat());
    let message = stderr(&output);
    assert!(output.status.success(), "{message}");
    for name in ["city_00002-2.png", "path_00005-2.txt", "trace.json"] {
        assert!(message.contains(&format!("wrote ./{name}")) || name == "trace.json", "{message}");
        assert!(scratch.names(".").contains(&name.to_owned()), "{message}");
    }
    assert!(message.contains("wrote trace.json"), "{message}");
    for name in ["city_00002.png", "path_00005.txt"] {
        assert_eq!(fs::read_to_string(scratch.0.join(name)).unwrap(), "mine");
    }
}

/// Checks that scripts and paths that are no regular files are refused at once: they may have no
/// end.
#[test]
fn what_has_no_end_is_not_read() {
    let scratch = Scratch::new("city-endless");
    assert!(Command::new("mkfifo").arg(scratch.0.join("pipe.txt")).status().unwrap().success());
    let sparse = fs::File::create(scratch.0.join("sparse.txt")).unwrap();
    sparse.set_len(3 << 30).unwrap();
    for option in ["--script", "--path"] {
        for (file, reason) in [
            ("/dev/zero", "not a regular file"),
            ("./pipe.txt", "not a regular file"),
            ("./sparse.txt", "it has 3221225472 bytes"),
        ] {
            let output = city(&scratch, &[&SMALL[..], &[option, file]].concat());
            let message = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{option} {file}: {message}");
            assert!(message.contains(reason) && message.lines().count() == 1, "{message}");
        }
    }
}

/// Checks that a signal ends the program with all files written.
#[test]
fn a_signal_ends_it_and_all_is_written() {
    for (signal, code) in [
        (rustix::process::Signal::INT, 130),
        (rustix::process::Signal::TERM, 143),
        (rustix::process::Signal::HUP, 129),
    ] {
        let scratch = Scratch::new("city-signal");
        fs::write(scratch.0.join("script"), "0 record\n2 screenshot\n").unwrap();
        let rest = ["--frames", "1000000", "--script", "script", "--trace", "trace.json"];
        let arguments = [&SMALL[..], &rest].concat();
        let mut command = signalled_program(crate::CITY, &scratch.0, &arguments);
        let log = fs::File::create(scratch.0.join("log")).unwrap();
        let mut running = command.stderr(log).spawn().unwrap();
        let began = Instant::now();
        while !scratch.0.join("city_00002.png").exists() {
            assert!(began.elapsed() < Duration::from_secs(60), "no frame is drawn");
            std::thread::sleep(Duration::from_millis(20));
        }
        let process = rustix::process::Pid::from_child(&running);
        rustix::process::kill_process(process, signal).unwrap();
        let status = running.wait().unwrap();
        let said = fs::read_to_string(scratch.0.join("log")).unwrap();
        assert_eq!(status.code(), Some(code), "{status}: {said}");
        assert!(scratch.names(".").iter().any(|name| name.starts_with("path_")), "{said}");
        let trace = fs::read_to_string(scratch.0.join("trace.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&trace).unwrap();
    }
}

/// Checks that a frozen culling stays explained: the view from above and the wireframe stay.
#[test]
fn what_is_frozen_is_explained() {
    let scratch = Scratch::new("city-frozen");
    fs::write(scratch.0.join("script"), "2 freeze\n4 top_down\n6 wireframe\n").unwrap();
    let rest = ["--validation", "sync", "--frames", "8", "--script", "script", "--out", "out"];
    headless(&scratch, &rest);
    let image = |frame: u32| pixels(&scratch.0.join(format!("out/frame_{frame:05}.png")));
    let [frozen, from_above, wireframe] = [3, 5, 7].map(image);
    let differs = |a: &[[u8; 3]], b: &[[u8; 3]], in_corner: bool| {
        let places = (0..a.len()).filter(|at| (at % 160 >= 96 && at / 160 >= 54) == in_corner);
        places.filter(|at| a[*at] != b[*at]).count()
    };
    assert!(differs(&frozen, &from_above, true) > 1000, "the corner is another image");
    assert_eq!(differs(&frozen, &from_above, false), 0, "the rest stays");
    assert!(differs(&from_above, &wireframe, false) > 100, "there are wires");
}

/// Checks that a strategy whose draws only the GPU knows is not frozen.
#[test]
fn what_only_the_gpu_knows_is_not_frozen() {
    let scratch = Scratch::new("city-pyramid");
    let script = "2 strategy hzb\n4 freeze\n6 strategy antumbra\n8 freeze\n";
    fs::write(scratch.0.join("script"), script).unwrap();
    headless(&scratch, &["--frames", "10", "--script", "script", "--out", "out"]);
    let image = |frame: u32| pixels(&scratch.0.join(format!("out/frame_{frame:05}.png")));
    let plain = image(1);
    for (frame, is_plain) in [(3, true), (5, true), (7, true), (9, false)] {
        assert_eq!(image(frame) == plain, is_plain, "frame {frame}");
    }
}

/// Checks the message about a strategy that cannot be explained, in both orders: strategy first, or
/// explanation first.
#[test]
fn what_only_the_gpu_knows_is_not_explained() {
    let scratch = Scratch::new("city-unexplained");
    for (script, times) in [
        ("2 top_down\n3 strategy hzb\n", 1),
        ("2 boxes\n3 strategy hzb\n", 1),
        ("2 strategy hzb\n3 top_down\n4 boxes\n", 2),
        ("2 boxes\n3 boxes\n4 strategy hzb\n5 strategy antumbra\n", 0),
    ] {
        fs::write(scratch.0.join("script"), script).unwrap();
        let rest = ["--frames", "6", "--script", "script"];
        let mut command = program(crate::CITY, &scratch.0, &[&SMALL[..], &rest].concat());
        let output = command.env("RUST_LOG", "samples=info").output().unwrap();
        let said = stderr(&output);
        assert!(output.status.success(), "{said}");
        assert_eq!(said.matches("only the GPU knows").count(), times, "{script}: {said}");
    }
}

#[test]
fn a_trace_has_cpu_and_gpu_on_one_time_line() {
    let scratch = Scratch::new("city-trace");
    fs::create_dir(scratch.0.join("traces")).unwrap();
    for device in ["llvmpipe", "SwiftShader"] {
        let rest = ["--frames", "10", "--trace", "traces/trace.json"];
        headless(&scratch, &[&["--device", device][..], &rest].concat());
        check_trace(&fs::read_to_string(scratch.0.join("traces/trace.json")).unwrap());
    }
}

fn check_trace(text: &str) {
    let trace: serde_json::Value = serde_json::from_str(text).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    let named = |name: &str| {
        let of_name = events.iter().filter(|event| event["name"] == name);
        of_name.map(|event| event["ts"].as_f64().unwrap()).collect::<Vec<_>>()
    };
    let renders = named("render");
    let visible = named("draw visible");
    assert_eq!((renders.len(), visible.len()), (10, 8), "two frames are on their way in the end");
    for (render, visible) in renders.iter().zip(&visible) {
        assert!(visible >= render, "the GPU draws at {visible} what is submitted after {render}");
    }
    assert!(trace["otherData"]["gpu_clock"].as_str().unwrap().contains("within"), "{trace}");
}

/// Copies the GLSL of the engine into a folder of its own.
#[cfg(feature = "shader-compiler")]
fn copy_shaders(to: &std::path::Path) {
    fs::create_dir(to).unwrap();
    let committed = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    for entry in fs::read_dir(committed).unwrap() {
        let entry = entry.unwrap();
        if entry.path().is_file() {
            fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
    }
}

/// Checks that shaders that change while it runs are loaded; the second change does not compile.
#[cfg(feature = "shader-compiler")]
#[test]
fn shaders_are_loaded_while_it_runs() {
    let scratch = Scratch::new("city-shaders");
    let folder = scratch.0.join("shaders");
    copy_shaders(&folder);
    let arguments = [&SMALL[..], &["--shaders", "shaders", "--frames", "1000000"]].concat();
    let mut command = program(crate::CITY, &scratch.0, &arguments);
    let log = fs::File::create(scratch.0.join("log")).unwrap();
    let mut running = command.env("RUST_LOG", "info").stderr(log).spawn().unwrap();
    let await_text = |text: &str| {
        let began = Instant::now();
        while !fs::read_to_string(scratch.0.join("log")).unwrap().contains(text) {
            assert!(began.elapsed() < Duration::from_secs(240), "never said: {text}");
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    await_text("the frames begin");
    let shader = folder.join("opaque.frag");
    let text = fs::read_to_string(&shader).unwrap();
    fs::write(&shader, format!("{text}\n// changed\n")).unwrap();
    await_text("new shaders");
    fs::write(&shader, format!("{text}\nthis does not compile\n")).unwrap();
    await_text("opaque.frag:");
    assert!(running.try_wait().unwrap().is_none(), "it goes on with the old ones");
    fs::write(&shader, text).unwrap();
    running.kill().unwrap();
    running.wait().unwrap();
}

#[test]
fn the_triangle_is_in_the_middle() {
    let scratch = Scratch::new("triangle");
    let mut command = Command::new(crate::TRIANGLE);
    let output = command.arg("--headless").current_dir(&scratch.0).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let numbers = said.split(|c: char| !c.is_ascii_digit()).filter(|word| !word.is_empty());
    let colour: Vec<u8> = numbers.map(|number| number.parse().unwrap()).collect();
    let &[red, green, blue] = colour.as_slice() else { panic!("{said}") };
    // A mixture of the corners, the same of red as of green.
    assert!(red > 60 && green > 60 && blue > 60, "{said}");
    assert!(red.abs_diff(green) < 8, "it stands upright: {said}");
}

#[test]
fn the_triangle_says_why_it_cannot_be_drawn() {
    let scratch = Scratch::new("no-triangle");
    let run = |arguments: &[&str]| {
        let mut command = Command::new(crate::TRIANGLE);
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command.args(arguments).current_dir(&scratch.0);
        command
    };
    let no_driver = |mut command: Command| {
        command.env("VK_ADD_DRIVER_FILES", "").env("VK_DRIVER_FILES", "/nowhere.json");
        command
    };
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut unheard = run(&["--headless"]);
    unheard.stdout(full());
    let cases = [
        (run(&[]), "--headless"),
        (run(&["--bogus"]), "usage"),
        (run(&["--headless", "more"]), "usage"),
        (no_driver(run(&["--headless"])), "driver"),
        (unheard, "space"),
    ];
    for (mut command, expected) in cases {
        let output = command.output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{command:?}: {said}");
        assert!(said.contains(expected) && !said.contains("panicked"), "{command:?}: {said}");
    }
}
