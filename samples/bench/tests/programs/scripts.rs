//! Runs ci/compare, ci/demo, ci/gpu and ci/verify with stand-ins for the programs: the scripts' own
//! decisions.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;

use harness::{Scratch, stderr};

use crate::stdout;

/// A stand-in that knows some strategies; a walk leaves its options in the place of its report, and
/// beside the program.
const WALKTHROUGH: &str = r#"#!/bin/sh
case " $* " in *" --list-strategies "*) 
    for name in frustum antumbra next_frame naive ideal; do echo "$name  exact  its description"; done
    exit ;;
esac
case "$*" in *ideal*--moving-percent*) echo "error: --strategy ideal and --moving-percent 10 do not go together" >&2; exit 2 ;; esac
words="$*"
echo "$words" >>"$0.walks"
while [ "$#" -gt 1 ]; do
    [ "$1" != --report ] || { mkdir -p "$(dirname "$2")"; printf '%s\n"frames_verified": 3,\n' "$words" >"$2"; }
    shift
done
"#;

/// A stand-in that builds nothing; it names the program that it should run.
const CARGO: &str = "#!/bin/sh\n[ \"$1\" != run ] || echo \"$*\"\n";

/// A stand-in with a commit; a tree with the file `dirty` has changes.
const GIT: &str = r#"#!/bin/sh
case "$*" in "rev-parse "*" HEAD") echo abc ;; "diff --quiet HEAD -- :!docs") [ ! -e dirty ] ;; *) exit 9 ;; esac
"#;

/// The lock held while a program is written and while one is started. A child that another test
/// starts in between has the file open for writing until it is replaced, and executing it would
/// fail (ETXTBSY).
static PROGRAMS: Mutex<()> = Mutex::new(());

fn program(path: &Path, text: &str) {
    let folder = path.parent().expect("a folder");
    fs::create_dir_all(folder).expect("the target folder is writable");
    let _no_child_starts = PROGRAMS.lock();
    fs::write(path, text).expect("the target folder is writable");
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).expect("ours");
}

/// Returns a tree with one of our scripts and nothing real besides.
fn tree(name: &str, script: &str) -> Scratch {
    let scratch = Scratch::new(name);
    let ours = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../ci").join(script);
    program(&scratch.0.join("ci").join(script), &fs::read_to_string(ours).expect("the script"));
    for called in ["setup", "capi", "hosts"] {
        program(&scratch.0.join("ci").join(called), "#!/bin/sh\n");
    }
    program(&scratch.0.join("ci/env"), "ANTUMBRA_NEW_LAYER_PATH=nowhere\n");
    program(&scratch.0.join("bin/cargo"), CARGO);
    program(&scratch.0.join("bin/git"), GIT);
    program(&scratch.0.join("target/release/walkthrough"), WALKTHROUGH);
    program(&scratch.0.join("target/release/compare"), "#!/bin/sh\n");
    let words = "#!/bin/sh\necho \"$*\" >words\n";
    program(&scratch.0.join("target/release/gpu_page"), words);
    scratch
}

fn run(scratch: &Scratch, script: &str, arguments: &[&str]) -> Output {
    let path = std::env::var("PATH").expect("a path");
    let nothing_is_written = PROGRAMS.lock();
    // It returns when the child has replaced itself and holds nothing of ours any more.
    let child = Command::new(scratch.0.join("ci").join(script))
        .args(arguments)
        .env("PATH", format!("{}:{path}", scratch.0.join("bin").display()))
        .env_remove("CARGO_TARGET_DIR")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    drop(nothing_is_written);
    child.wait_with_output().expect("it ends")
}

fn assert_ends_with(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "{}", stderr(output));
}

#[test]
fn a_folder_takes_reports_of_one_mode_and_device_only() {
    let scratch = tree("script-compare", "compare");
    let compare = |more: &[&str]| run(&scratch, "compare", &[&["--out", "out"], more].concat());
    assert_ends_with(&compare(&["--quick"]), 0);
    let quick = scratch.names("out/reports");
    assert!(quick.contains(&"street-2000.2.json".to_owned()), "{quick:?}");
    for other in [&["--full"][..], &["--quick", "--device", "other"]] {
        let output = compare(other);
        assert_ends_with(&output, 2);
        assert!(stderr(&output).contains("another build, device or mode"), "{}", stderr(&output));
        assert_eq!(scratch.names("out/reports"), quick, "nothing was walked");
    }
    // The same goes on where it was.
    fs::remove_file(scratch.0.join("out/reports/street-2000.1.json")).expect("it is there");
    let again = compare(&[]);
    assert_ends_with(&again, 0);
    assert!(stdout(&again).contains("1 walks to go"));
    assert_ends_with(&compare(&["--full", "--fresh"]), 0);
    assert!(scratch.names("out/reports").contains(&"street-2000.3.json".to_owned()));
}

/// Checks that noisy walks are repeated while they are noisy, up to a bound; the first walk of a
/// case leaves an image.
#[test]
fn noisy_walks_are_repeated_and_no_others() {
    let scratch = tree("script-noise", "compare");
    let noisy =
        "#!/bin/sh\ncase \" $* \" in *' --noisy '*) printf 'street-2000\\nfield-fly\\n' ;; esac\n";
    program(&scratch.0.join("target/release/compare"), noisy);
    assert_ends_with(&run(&scratch, "compare", &["--quick", "--out", "out"]), 0);
    let reports = scratch.names("out/reports");
    let times = |name: &str| {
        let of_name = |file: &&String| {
            file.strip_prefix(name).is_some_and(|rest| rest.len() == ".1.json".len())
        };
        reports.iter().filter(of_name).count()
    };
    assert_eq!(["street-2000", "field-fly"].map(times), [4, 4], "{reports:?}");
    assert_eq!(["street-2000-tie", "fly-10000"].map(times), [2, 2], "{reports:?}");
    let words = |name: &str| fs::read_to_string(scratch.0.join("out/reports").join(name));
    let first = words("street-2000.1.json").expect("a walk");
    assert!(first.contains("--out out/images/street-2000.1 --images 1"), "{first}");
    assert!(!words("street-2000.2.json").expect("a walk").contains("--out"));
}

#[test]
fn moving_objects_are_compared_for_one_eye_and_for_two() {
    let scratch = tree("script-compared", "compare");
    assert_ends_with(&run(&scratch, "compare", &["--quick", "--out", "out"]), 0);
    let words = |name: &str| {
        let file = scratch.0.join(format!("out/reports/verify-{name}.1.json"));
        fs::read_to_string(file).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    for (name, options) in [
        ("moving", "--moving-percent 10"),
        ("views", "--views 2"),
        ("moving-views", "--moving-percent 10 --views 2"),
    ] {
        let words = words(name);
        assert!(words.contains(options) && words.contains("--verify every"), "{words}");
        assert_eq!(words.contains("ideal"), name == "views", "{words}");
    }
}

#[test]
fn what_is_verified_is_every_exact_strategy_of_the_program() {
    let scratch = tree("script-verify", "verify");
    let output = run(&scratch, "verify", &["2"]);
    assert_ends_with(&output, 0);
    let walks = scratch.0.join("target/release/walkthrough.walks");
    let walks = fs::read_to_string(walks).expect("it walked");
    for walk in walks.lines() {
        let moving = walk.contains("--moving-percent");
        let strategies = if moving { "frustum,antumbra" } else { "frustum,antumbra,ideal" };
        assert!(walk.contains(&format!("--strategy {strategies} --verify every")), "{walk}");
    }
    assert!(walks.contains("--moving-percent") && walks.contains("--projection orthographic"));
    let told = stdout(&output);
    assert_eq!(told.matches(": 3 images compared, 0 pixels wrong").count(), walks.lines().count());
    // A program that compares nothing is no proof.
    program(&scratch.0.join("target/release/walkthrough"), "#!/bin/sh\n");
    let output = run(&scratch, "verify", &["2"]);
    assert_ends_with(&output, 1);
    assert!(stderr(&output).contains("no image was compared"), "{}", stderr(&output));
}

#[test]
fn options_of_the_demo_come_after_its_own() {
    let scratch = tree("script-demo", "demo");
    let output = run(&scratch, "demo", &["--path", "fly"]);
    assert_ends_with(&output, 0);
    let told = stdout(&output);
    let words = told.lines().next().expect("a call").split(" -- ").nth(1).expect("its options");
    assert!(words.ends_with("--path fly"), "{words}");
    // Read as the program reads them: the last word counts.
    let line = ["walkthrough"].into_iter().chain(words.split(' '));
    let arguments: bench::args::Arguments = clap::Parser::try_parse_from(line).expect("options");
    let fly = bench::options::PathChoice::Made(bench::choices::CameraPathChoice::Fly);
    assert_eq!(arguments.options().expect("options").path, fly);
}

#[test]
fn the_page_of_a_gpu_has_compared_and_timed_walks_of_every_way() {
    let scratch = tree("script-gpu", "gpu");
    let output = run(&scratch, "gpu", &["--quick", "--device", "some", "--out", "pages"]);
    assert_ends_with(&output, 0);
    let walks = fs::read_to_string(scratch.0.join("target/release/walkthrough.walks"));
    let walks = walks.expect("walks");
    let walks: Vec<&str> = walks.lines().collect();
    assert!(walks.iter().all(|walk| walk.contains("--device some")), "{walks:?}");
    let has =
        |parts: &[&str]| walks.iter().any(|walk| parts.iter().all(|part| walk.contains(part)));
    for checks in ["--validation on", "--validation sync"] {
        assert!(has(&[checks, "--verify every", "--strategy frustum,antumbra,ideal"]));
    }
    for way in ["count", "instances", "compacted"].map(|way| format!("--predicates {way}")) {
        assert!(has(&[&way, "--verify every"]), "{way}");
    }
    for compared in [
        "--scene field",
        "--strategy naive,batched",
        "--moving-percent 10 --views 2",
        "--objects 100 --msaa 4",
        "--lights sun --shadows maps,volumes",
        "--lights 4 --shadows maps,volumes",
        "--scene samples/bench/fences.gltf --lights sun --shadows maps --msaa 4",
    ] {
        assert!(has(&[compared, "--verify every", "--validation sync"]), "{compared}");
    }
    let timed: Vec<&str> =
        walks.iter().copied().filter(|walk| !walk.contains("--verify")).collect();
    for way in
        ["--path fly", "--strategy frustum,naive,batched,stop_and_wait,ideal", "--shadows maps"]
    {
        assert!(timed.iter().any(|walk| walk.contains(way)), "{way}");
    }
    let is_late = |walk: &&&str| walk.contains("next_frame");
    assert_eq!(walks.iter().filter(is_late).count(), timed.len() - 2, "{timed:?}");
    let words = fs::read_to_string(scratch.0.join("words")).expect("a page");
    assert!(words.contains("--reports out/gpu/reports"), "{words}");
    assert!(words.contains("--out pages --commit abc --size"), "{words}");
    fs::write(scratch.0.join("dirty"), "").expect("the target folder is writable");
    assert_ends_with(&run(&scratch, "gpu", &["--quick"]), 0);
    let words = fs::read_to_string(scratch.0.join("words")).expect("a page");
    assert!(words.contains("--commit abc --uncommitted --size"), "{words}");
}

#[test]
fn a_wrong_walk_leaves_no_page_and_what_a_gpu_lacks_is_left_out() {
    for (code, message, expected) in [(1, "wrong pixels", 1), (2, "it lacks counts", 0)] {
        let scratch = tree(&format!("script-gpu-{code}"), "gpu");
        let failing =
            format!("case \"$*\" in *instances*) echo '{message}' >&2; exit {code} ;; esac\n");
        let text = WALKTHROUGH.replacen("#!/bin/sh\n", &format!("#!/bin/sh\n{failing}"), 1);
        program(&scratch.0.join("target/release/walkthrough"), &text);
        let output = run(&scratch, "gpu", &["--quick"]);
        assert_ends_with(&output, expected);
        assert_eq!(scratch.0.join("words").exists(), expected == 0);
        let told = fs::read_to_string(scratch.0.join("out/gpu/left-out.txt")).expect("a list");
        assert_eq!(told, if expected == 0 { "compared-instances: it lacks counts\n" } else { "" });
    }
}
