//! The committed header matches the declarations in the sources.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use cbindgen::{Builder, Config};

/// A section of the header: the declarations of some sources.
struct Section {
    title: &'static str,
    /// The introduction, in lines.
    about: &'static [&'static str],
    /// The sources, each after those whose types it uses.
    files: &'static [&'static str],
}

/// The sections that do not need Vulkan.
const PLAIN: [Section; 2] = [
    Section {
        title: "1. Version, results, log and contexts",
        about: &[
            "A program creates a context first: it owns all other objects, and passes messages on.",
        ],
        files: &["version", "error", "log", "context", "api/context"],
    },
    Section {
        title: "2. Decisions alone",
        about: &[
            "The host has objects with boxes, in a hierarchy. Each leaf of it has one object or none;",
            "plans name leaves, and antumbra_hierarchy_leaves says which objects they are. In each",
            "frame a culler plans, for a camera, which leaves to draw at once, and which boxes to test",
            "against the depth so far. If a box shows, its leaves are drawn, too. A tester is a way to",
            "test a box: an occlusion query, or another one that the host has. The results of queries",
            "go back to the culler in a later frame, as answers.",
        ],
        files: &[
            "decisions/camera",
            "decisions/hierarchy",
            "decisions/culler",
            "decisions/plan",
            "api/hierarchy",
            "api/culler",
        ],
    },
];

/// The sections that need Vulkan.
const VULKAN: [Section; 4] = [
    Section {
        title: "3. Devices",
        about: &[
            "The host asks for the requirements, creates its VkDevice with them, and adopts it: with a",
            "queue for a renderer, and without one for scenes of the executor. For a program without",
            "Vulkan of its own, the library opens a device.",
        ],
        files: &[
            "executor/queue",
            "executor/device",
            "executor/device_open",
            "api/device",
            "api/device_open",
        ],
    },
    Section {
        title: "4. The self-test and the costs of a device",
        about: &[
            "Both are optional, and need a device that was adopted with a queue. The self-test finds",
            "assumptions about the driver that do not hold; what rests on them can be disabled.",
        ],
        files: &[
            "executor/quirks",
            "executor/device_costs",
            "renderer/self_test",
            "renderer/device_costs",
            "api/self_test",
            "api/device_costs",
        ],
    },
    Section {
        title: "5. The executor",
        about: &[
            "A scene has the objects of the host, each with a box and with indexed indirect draws. A",
            "draw is in a bucket: a pipeline of the host. A view of the scene has a history of its own.",
            "In each frame antumbra_scene_record records the tests and draws of all views into a",
            "command buffer of the host. Predication is the way that the GPU skips hidden draws. Frames",
            "have numbers, and the host says which frames are over.",
        ],
        files: &[
            "executor/target",
            "executor/scene",
            "executor/lists",
            "executor/frame",
            "api/scene",
        ],
    },
    Section {
        title: "6. The renderer",
        about: &[
            "For a host without a renderer of its own: it passes meshes and objects, or the scene of a",
            "file with its clips, and a camera per frame, and gets an image. The library submits to the",
            "queue of the host, or of the device that it opened. Each view has a history of its own.",
        ],
        files: &[
            "renderer/scene_file",
            "renderer/description",
            "renderer/shadows",
            "renderer/view",
            "renderer/frame",
            "api/scene_file",
            "api/renderer",
            "api/renderer_view",
            "api/shadows",
            "api/playback",
        ],
    },
];

/// Returns the header.
fn generate() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut config = Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let header = config.header.take().unwrap();
    let trailer = config.trailer.take().unwrap();
    let mut text = header.trim_start().to_owned();
    for section in &PLAIN {
        text += &section.declarations(&config);
    }
    text += "\n#ifdef ANTUMBRA_VULKAN\n";
    for section in &VULKAN {
        text += &section.declarations(&config);
    }
    text += "\n#endif /* ANTUMBRA_VULKAN */\n";
    text + &trailer
}

impl Section {
    /// Returns the banner and the declarations.
    fn declarations(&self, config: &Config) -> String {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut builder = Builder::new().with_config(config.clone());
        for file in self.files {
            builder = builder.with_src(sources.join(file).with_extension("rs"));
        }
        let mut declared = Vec::new();
        builder.generate().unwrap().write(&mut declared);
        let declared = String::from_utf8(declared).unwrap();
        // All of the header is within one block of `extern "C"`.
        let begin = "#ifdef __cplusplus\nextern \"C\" {\n#endif // __cplusplus\n";
        let end = "#ifdef __cplusplus\n}  // extern \"C\"\n#endif  // __cplusplus\n";
        // Rust wants this heading; in C the rules at the top are enough.
        let rules = " *\n * # Safety\n * The rules of the interface.\n";
        let declared = declared.replace(begin, "").replace(end, "").replace(rules, "");
        let mut text = format!("\n/* {}\n * {}\n", "=".repeat(97), self.title);
        for line in self.about {
            writeln!(text, " * {line}").unwrap();
        }
        writeln!(text, " * {} */\n", "=".repeat(94)).unwrap();
        let mut last = "";
        for line in declared.lines() {
            if !(line.is_empty() && last.is_empty()) {
                // Every struct has a typedef.
                let line = if line.starts_with("typedef struct ") {
                    line.to_owned()
                } else {
                    line.replace("struct Antumbra", "Antumbra")
                };
                writeln!(text, "{line}").unwrap();
            }
            last = line;
        }
        text.trim_end().to_owned() + "\n"
    }
}

#[test]
fn the_header_is_fresh() {
    let fresh = generate();
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/antumbra.h");
    if fs::read_to_string(&committed).unwrap_or_default() != fresh {
        let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join("antumbra.h");
        fs::write(&made, fresh).unwrap();
        panic!("the header is stale: cp {} {}", made.display(), committed.display());
    }
}

#[test]
fn the_header_reads_as_c() {
    let header = generate();
    let count = |what: &str| header.matches(what).count();
    for section in PLAIN.iter().chain(&VULKAN) {
        // The contents and the banner.
        let beginning = format!("\n * {}", &section.title[..3]);
        assert_eq!(count(&beginning), 2, "{}", section.title);
    }
    // What needs Vulkan is in one piece: most other conditions are those of C++.
    assert_eq!(count("#ifdef ANTUMBRA_VULKAN"), 2);
    assert!(count("\n#if") < 12, "{} conditions", count("\n#if"));
    // Headings, links and short names of Rust.
    for rust in ["# Safety", "rules of the interface", "[`", "`]", "`None`", "`self"] {
        assert_eq!(count(rust), 0, "{rust}");
    }
    let is_constant = |name: &&str| {
        name.len() > 3 && name.chars().all(|letter| letter.is_ascii_uppercase() || letter == '_')
    };
    let short = header.split('`').filter(is_constant);
    let short: Vec<&str> =
        short.filter(|name| !name.starts_with("ANTUMBRA_") && !name.starts_with("VK_")).collect();
    assert!(short.is_empty(), "names without ANTUMBRA_RESULT_: {short:?}");
}

/// Checks that every name in a comment is one that a program can use.
#[test]
fn what_comments_name_is_declared() {
    let header = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/antumbra.h");
    let header = fs::read_to_string(header).unwrap();
    let mut comments = String::new();
    let mut code = String::new();
    for (number, part) in header.split("/*").enumerate() {
        let (comment, rest) = part.split_once("*/").unwrap_or(("", part));
        if number > 0 {
            comments += comment;
        }
        code += rest;
    }
    let words = |text: &str| -> BTreeSet<String> {
        let is_of_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let words = text.split(|letter| !is_of_word(letter));
        words.filter(|word| word.starts_with("ANTUMBRA_")).map(str::to_owned).collect()
    };
    let declared = words(&code);
    // A name that ends with an underscore stands for all names that begin so:
    // `ANTUMBRA_SHADOWS_..`.
    let is_declared = |word: &&String| {
        let begins = |other: &String| other.starts_with(word.as_str());
        declared.contains(word.as_str()) || word.ends_with('_') && declared.iter().any(begins)
    };
    let used = words(&comments);
    let missing: Vec<&String> = used.iter().filter(|word| !is_declared(word)).collect();
    assert!(used.len() > 30 && missing.is_empty(), "of {} names: {missing:?}", used.len());
}
