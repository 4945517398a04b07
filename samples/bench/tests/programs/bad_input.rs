//! Runs `walkthrough` with bad input: one sentence, the right exit code, nothing left behind.

use std::fs;
use std::process::Command;

use harness::{Scratch, stderr};

use crate::{refusal, stdout, succeeded, walkthrough};

fn assert_empty(scratch: &Scratch) {
    let left = scratch.names(".");
    assert!(left.is_empty(), "left behind: {left:?}");
}

#[test]
fn mistakes_in_the_command_line_end_with_2_and_leave_nothing() {
    let scratch = Scratch::new("mistakes");
    let out = ["--out", "made", "--report", "made/report.json"];
    // Arguments that are wrong by themselves: as in every program.
    for (mistake, sentence) in [
        (["--scene", "citty"], "did you mean 'city'?"),
        (["--strategy", "frustum,frustum"], "'frustum' twice"),
        (["--objects", "33554433"], "33554433 is not in 1..=33554432"),
        (["--size", "0x0"], "'0x0'"),
        (["--predicates", "condtional"], "a similar value exists: 'conditional'"),
        (["--top-down", "-1"], "a frame, or off"),
    ] {
        let mut command = walkthrough(&scratch.0, &[&mistake[..], &out].concat());
        let output = command.output().expect("it starts");
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{mistake:?}");
        let message = stderr(&output);
        assert!(message.starts_with("error: ") && !message.contains("panicked"), "{message}");
        assert!(message.contains(mistake[0]), "names the option: {message}");
        assert!(message.contains(sentence), "{message}");
        assert_empty(&scratch);
    }
    // Arguments that are wrong together: one sentence.
    for (mistake, sentence) in [
        (["--path", "Camera"], "there is street, fly and cut"),
        (["--path", "missing.txt"], "cannot read the path file 'missing.txt'"),
        (["--top-down", "120"], "from 0 to 119, not '120'"),
    ] {
        // In one line: nothing was begun.
        let message = refusal(&mut walkthrough(&scratch.0, &[&mistake[..], &out].concat()), 2);
        assert!(message.contains(sentence), "{message}");
        assert_empty(&scratch);
    }
}

#[test]
fn questions_do_not_go_together_and_write_no_files() {
    let scratch = Scratch::new("questions");
    let questions = ["--list-devices", "--list-strategies", "--self-test"];
    let files = ["--out=made", "--report=report.json"];
    for question in questions {
        for other in questions.into_iter().chain(files).filter(|other| *other != question) {
            let output = walkthrough(&scratch.0, &[question, other]).output().expect("it starts");
            let message = stderr(&output);
            assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{message}");
            assert!(message.contains("cannot be used with"), "{message}");
        }
    }
    assert_empty(&scratch);
}

#[test]
fn shadows_that_no_image_of_this_kind_has_are_refused_before_any_work() {
    let scratch = Scratch::new("no-such-shadows");
    let more = ["--objects", "1", "--lights=sun", "--shadows=off,volumes", "--msaa=4"];
    let message = refusal(&mut small_walk(&scratch, &more), 2);
    assert!(message.contains("shadow volumes"));
    assert_empty(&scratch);
}

#[test]
fn arguments_that_do_not_exist_end_with_2() {
    let scratch = Scratch::new("unknown-argument");
    for arguments in [&["--objets", "5"][..], &["city"], &["--out"], &["--out", ""], &["--report="]]
    {
        let output = walkthrough(&scratch.0, arguments).output().expect("it starts");
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).starts_with("error: "));
    }
    let output = walkthrough(&scratch.0, &["--objets", "5"]).output().expect("it starts");
    assert!(stderr(&output).contains("'--objects'"), "{}", stderr(&output));
    assert_empty(&scratch);
}

#[test]
fn places_that_cannot_be_written_end_with_2_before_any_work() {
    let scratch = Scratch::new("unwritable");
    let beside = Scratch::new("unwritable-beside");
    let file = beside.0.join("file");
    fs::write(&file, "kept").expect("the target folder is writable");
    let below = file.join("below");
    let file_name = file.to_string_lossy();
    let below = below.to_string_lossy();
    for arguments in [
        ["--out", file_name.as_ref()],
        ["--out", below.as_ref()],
        ["--report", below.as_ref()],
        ["--report", "."],
        ["--report", "folder/"],
        ["--report", "folder/report.json"],
    ] {
        let message = refusal(&mut walkthrough(&scratch.0, &arguments), 2);
        assert!(message.contains(arguments[0]), "names the option: {message}");
        assert_empty(&scratch);
    }
    assert_eq!(fs::read_to_string(&file).expect("still there"), "kept");
    fs::remove_file(&file).expect("ours");
}

/// Returns a small walk that would leave images and a report, with `more` arguments.
fn small_walk(scratch: &Scratch, more: &[&str]) -> Command {
    let mut words = vec!["--quiet", "--out", "made/images", "--report", "made/report.json"];
    for [option, value] in [["--objects", "50"], ["--frames", "2"], ["--size", "32x32"]] {
        if !more.contains(&option) {
            words.extend([option, value]);
        }
    }
    words.extend(more);
    walkthrough(&scratch.0, &words)
}

#[test]
fn an_unknown_device_ends_with_2_and_lists_the_devices() {
    let scratch = Scratch::new("unknown-device");
    for wanted in ["voodoo", "99", "-1"] {
        let message = refusal(&mut small_walk(&scratch, &["--device", wanted]), 2);
        assert!(message.contains(&format!("no device '{wanted}'")), "{message}");
        assert!(message.contains("llvmpipe") && message.contains("0: "), "{message}");
        assert_empty(&scratch);
    }
}

#[test]
fn sizes_beyond_the_device_end_with_2() {
    let scratch = Scratch::new("too-large");
    for (size, side) in [("1000000x32", "width"), ("32x4294967295", "height")] {
        // A city of one object has no streets, which is found when it is made: that comes later.
        let asked = ["--size", size, "--objects", "1"];
        let message = refusal(&mut small_walk(&scratch, &asked), 2);
        assert!(message.contains(&format!("the {side} of the image")), "{message}");
        assert!(message.contains("takes at most"), "{message}");
        assert_empty(&scratch);
    }
}

#[test]
fn what_the_device_cannot_do_ends_with_2_and_says_what_it_lacks() {
    let scratch = Scratch::new("cannot");
    for (predicates, lacks) in [
        ("conditional", "VK_EXT_conditional_rendering"),
        ("count", "drawIndirectCount"),
        ("compacted", "drawIndirectCount"),
    ] {
        let asked = ["--device", "swiftshader", "--predicates", predicates];
        let message = refusal(&mut small_walk(&scratch, &asked), 2);
        assert!(message.contains("SwiftShader"), "needs `. ci/env`: {message}");
        assert!(message.contains(lacks), "{message}");
        assert_empty(&scratch);
    }
}

#[test]
fn without_the_validation_layer_it_ends_with_1_and_says_what_to_do() {
    let scratch = Scratch::new("no-layer");
    for validation in ["on", "sync"] {
        let mut command = small_walk(&scratch, &["--validation", validation]);
        // Says where the loader looks for such layers, and that is nowhere.
        command.env("VK_LAYER_PATH", "/nonexistent").env_remove("VK_ADD_LAYER_PATH");
        let message = refusal(&mut command, 1);
        assert!(message.contains("VK_LAYER_KHRONOS_validation is not installed"), "{message}");
        assert!(message.contains("apt install vulkan-validationlayers"), "{message}");
        assert_empty(&scratch);
    }
}

/// Checks that walks and `--list-devices` end with 1 and one error on a machine made poorer.
fn assert_machine_is_blamed(name: &str, poorer: impl Fn(&mut Command)) {
    let scratch = Scratch::new(name);
    let walk = ["--out", "made/images", "--report", "made/report.json"];
    for arguments in [&walk[..], &["--list-devices"]] {
        let mut command = walkthrough(&scratch.0, arguments);
        poorer(&mut command);
        let output = command.output().expect("it starts");
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{message}");
        // The Vulkan loader may add lines of its own.
        let errors = message.lines().filter(|line| line.starts_with("error: ")).count();
        assert_eq!(errors, 1, "{message}");
        assert!(!message.contains("panicked"), "{message}");
        assert_empty(&scratch);
    }
}

#[test]
fn without_a_driver_it_ends_with_1_and_leaves_nothing() {
    assert_machine_is_blamed("no-driver", |command| {
        command
            .env("VK_DRIVER_FILES", "/nonexistent/driver.json")
            .env_remove("VK_ADD_DRIVER_FILES");
    });
}

#[test]
#[cfg(target_os = "linux")]
fn without_a_loader_it_ends_with_1_and_leaves_nothing() {
    // An empty file of its name, found first: the dynamic linker gives up on it.
    let fake = Scratch::new("fake-loader");
    fs::write(fake.0.join("libvulkan.so.1"), "").expect("the target folder is writable");
    fs::write(fake.0.join("libvulkan.so"), "").expect("the target folder is writable");
    assert_machine_is_blamed("no-loader", |command| {
        command.env("LD_LIBRARY_PATH", &fake.0);
    });
}

#[test]
#[cfg(target_os = "linux")]
fn a_fault_of_vulkan_ends_with_1_and_its_call_and_code() {
    harness::assert_faults_end_programs("walkthrough-fault", |folder| {
        let walk = ["--device", "llvmpipe", "--objects", "50", "--frames", "8", "--size", "64x36"];
        let rest = ["--strategy", "antumbra", "--cost-model", "off"];
        walkthrough(folder, &[&walk[..], &rest].concat())
    });
}

#[test]
fn help_explains_every_option_of_the_contract() {
    let scratch = Scratch::new("help");
    let help = stdout(&succeeded(&mut walkthrough(&scratch.0, &["--help"])));
    for option in [
        "--scene",
        "--objects",
        "--seed",
        "--path",
        "--frames",
        "--size",
        "--strategy",
        "--verify",
        "--frames-in-flight",
        "--device",
        "--validation",
        "--out",
        "--report",
        "Examples:",
        &format!("1 to {}", bench::options::MAX_OBJECTS),
    ] {
        assert!(help.contains(option), "{option} is missing in\n{help}");
    }
}

#[test]
#[cfg(not(feature = "shader-compiler"))]
fn shaders_need_a_build_with_the_compiler() {
    let scratch = Scratch::new("no-compiler");
    let message = refusal(&mut walkthrough(&scratch.0, &["--shaders", "."]), 2);
    assert!(message.contains("--features shader-compiler"));
}

#[test]
#[cfg(feature = "shader-compiler")]
fn a_folder_of_shaders_that_is_none_ends_with_2() {
    let scratch = Scratch::new("no-shaders");
    let message = refusal(&mut small_walk(&scratch, &["--shaders", "nowhere"]), 2);
    assert!(message.contains("there is no folder 'nowhere'"));
    assert_empty(&scratch);
}

#[test]
#[cfg(feature = "shader-compiler")]
fn a_shader_that_does_not_compile_ends_with_2_and_its_line() {
    let scratch = Scratch::new("broken-shader");
    let shaders = Scratch::new("broken-shader-glsl");
    harness::edited_shaders(&shaders, "opaque_main.glsl", "normalize(", "normalise(");
    let text = fs::read_to_string(shaders.0.join("opaque_main.glsl")).expect("the shader");
    let line = 1 + text.lines().position(|line| line.contains("normalise(")).expect("a line");

    let folder = shaders.0.to_string_lossy();
    let output = small_walk(&scratch, &["--shaders", &folder]).output().expect("it starts");
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    // One error, and under it what the compiler said.
    assert!(message.starts_with("error: ") && !message.contains("panicked"), "{message}");
    assert_eq!(message.lines().filter(|line| line.starts_with("error: ")).count(), 1, "{message}");
    assert!(message.contains(&format!("opaque_main.glsl:{line}: ")), "{message}");
    assert!(message.contains("normalise"), "{message}");
    assert_empty(&scratch);
}

#[test]
fn a_damaged_driver_manifest_is_not_called_a_lack_of_memory() {
    let scratch = Scratch::new("manifest");
    let manifest = scratch.0.join("driver.json");
    fs::write(&manifest, r#"{ "file_format_version": "1.0.0", "ICD": {"#).expect("it is written");
    let mut command = walkthrough(&scratch.0, &["--list-devices"]);
    let message = refusal(command.env("VK_DRIVER_FILES", &manifest), 1);
    assert!(message.contains("the manifest of a driver"), "{message}");
    assert!(message.contains("VK_LOADER_DEBUG") && !message.contains("fewer"), "{message}");
}

/// Checks the message where a scene of 2,000,000 objects gets too little memory, regardless of how
/// much the driver takes.
#[cfg(target_os = "linux")]
#[test]
fn too_little_memory_for_a_scene_is_said_in_a_sentence() {
    let scratch = Scratch::new("memory");
    let arguments = ["--objects", "2000000", "--frames", "1", "--size", "64x36"];
    let arguments = [&arguments[..], &["--strategy", "antumbra", "--device", "llvmpipe"]].concat();
    let plain = walkthrough(&scratch.0, &arguments);
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 1200000 && exec \"$0\" \"$@\""]);
    command.arg(plain.get_program()).args(arguments).current_dir(&scratch.0);
    let output = command.output().expect("it starts");
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("error: there is no memory "), "{message}");
    assert!(!message.contains("panicked") && !message.contains("allocation of"), "{message}");
}

/// Checks that a limit under which no driver runs is told as such, on each of the software drivers
/// alone: the loader says that there is none, or one of them ends the process.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_address_space_is_not_called_a_missing_driver() {
    let scratch = Scratch::new("address-space");
    for limit_kib in [200_000, 400_000] {
        for arguments in [&["--list-devices"][..], &["--frames", "2", "--size", "320x180"]] {
            let plain = walkthrough(&scratch.0, arguments);
            let mut command = Command::new("sh");
            command.args(["-c", &format!("ulimit -v {limit_kib} && exec \"$0\" \"$@\"")]);
            command.arg(plain.get_program()).args(arguments).current_dir(&scratch.0);
            let message = refusal(&mut command, 1);
            let limit = format!("may take {} MiB of address space", limit_kib >> 10);
            assert!(message.contains(&limit) && message.contains("ulimit -v"), "{message}");
            assert!(!message.contains("install"), "{message}");
        }
    }
}

/// Checks that a cache that is not a regular file, or larger than any, is left alone and costs
/// neither time nor memory.
#[cfg(target_os = "linux")]
#[test]
fn a_pipeline_cache_that_is_no_cache_is_left_alone() {
    let scratch = Scratch::new("cache");
    let arguments = ["--objects", "50", "--frames", "1", "--size", "64x36"];
    let arguments = [&arguments[..], &["--strategy", "antumbra", "--device", "llvmpipe"]].concat();
    let run = |home: &str| {
        let mut command = walkthrough(&scratch.0, &arguments);
        command.env("XDG_CACHE_HOME", scratch.0.join(home)).output().expect("it starts")
    };
    let first = run("plain");
    assert!(first.status.success(), "{}", stderr(&first));
    let folder = &scratch.names("plain")[0];
    let file = &scratch.names(&format!("plain/{folder}"))[0];
    for kind in ["pipe", "sparse"] {
        fs::create_dir_all(scratch.0.join(kind).join(folder)).expect("it is made");
        let path = scratch.0.join(kind).join(folder).join(file);
        match kind {
            "pipe" => {
                let made = Command::new("mkfifo").arg(&path).status();
                assert!(made.expect("mkfifo").success());
            }
            _ => fs::File::create(&path).expect("it is made").set_len(3 << 30).expect("holes"),
        }
        let output = run(kind);
        assert!(output.status.success(), "{kind}: {}", stderr(&output));
        let memory = stdout(&output);
        let peak = memory.split("peak memory ").nth(1).and_then(|rest| rest.split(' ').next());
        let peak_mib: u64 = peak.and_then(|peak| peak.parse().ok()).expect("its peak memory");
        assert!(peak_mib < 1500, "{kind}: {peak_mib} MiB");
        assert_eq!(path.is_file(), kind == "sparse", "a pipe stays a pipe");
    }
}
