//! The rules of the workspace that no lint checks, as tests: style, dependencies between crates,
//! forbidden code. The lints are in `Cargo.toml` and `clippy.toml`.
//!
//! Each rule is a function from the files to findings, "file:line: reason". A test applies a rule
//! to the workspace, and to examples that it must report.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod code;
mod crate_page;
mod files;
mod knots;
mod links;
mod manifests;
mod map;
mod modules;
mod mutants;
mod plain;
mod prose;
mod rules;
mod types;

use files::{SourceFile, workspace};
use rules::Rule;

/// Checks that there is no finding in the workspace.
fn assert_obeyed(rule: Rule) {
    let files = workspace();
    assert!(files.len() > 20, "only {} files found: wrong folder?", files.len());
    let findings = rule(&files);
    assert!(findings.is_empty(), "\n{}\n", findings.join("\n"));
}

/// Checks that the rule finds something in each of these files alone.
fn assert_catches(rule: Rule, forbidden: &[(&str, &str)]) {
    for &(path, text) in forbidden {
        let findings = rule(&[SourceFile::new(path, text)]);
        let here = findings.iter().any(|finding| finding.starts_with(path));
        assert!(here, "nothing said about {path}:\n{text}\nbut: {findings:?}");
    }
}

/// Checks that the rule finds nothing in any of these files.
fn assert_permits(rule: Rule, allowed: &[(&str, &str)]) {
    for &(path, text) in allowed {
        let findings = rule(&[SourceFile::new(path, text)]);
        assert!(findings.is_empty(), "{findings:?}");
    }
}

#[test]
fn every_file_says_what_it_is_for() {
    assert_obeyed(rules::purpose);
    assert_catches(
        rules::purpose,
        &[
            ("a.rs", "use b;\n"),
            ("a.rs", "//!\n"),
            ("shaders/a.vert", "#version 460\n"),
            ("ci/a", "#!/bin/sh\nset -e\n"),
            ("ci/a", ""),
        ],
    );
    assert_permits(
        rules::purpose,
        &[("a.rs", "//! What.\n"), ("ci/a", "#!/bin/sh\n# What.\n"), ("ci/b", "# What.\n")],
    );
}

#[test]
fn no_file_is_too_long() {
    assert_obeyed(rules::length);
    let long = "\n".repeat(501);
    assert_catches(rules::length, &[("a.rs", &long), ("a.comp", &long), ("ci/a", &long)]);
    assert_permits(rules::length, &[("a.rs", &"\n".repeat(500))]);
}

#[test]
fn statements_are_plain() {
    assert_obeyed(plain::packed);
    let statements = |text: &str| format!("fn a() {{\n{text}\n}}");
    for packed in ["let (a, mut b) = (c, d(e));", "let [a, b]: [u32; 2] =\n    [c, d];"] {
        assert_catches(plain::packed, &[("a.rs", &statements(packed))]);
    }
    let taken = "let (a, b) = c;\nlet (a, b) = (c, d).e();\nif let (a, b) = (c, d) {}";
    assert_permits(plain::packed, &[("a.rs", &statements(taken))]);
    assert_catches(
        plain::packed,
        &[
            ("a.rs", "fn a(b: C, (d, e): (D, E)) {}"),
            ("a.rs", "fn a<B: Fn(C) -> D>([e, f]: [E; 2]) {}"),
        ],
    );
    let named = "fn a(b: (C, D), E { f, .. }: E) {\n    g.map(|(h, i)| h);\n}";
    assert_permits(plain::packed, &[("a.rs", named)]);
}

#[test]
fn modules_lie_where_their_names_say() {
    assert_obeyed(rules::module_paths);
    assert_catches(
        rules::module_paths,
        &[("a.rs", "#[path = \"b.rs\"]\nmod c;\n"), ("tests/a.rs", "    #[path=\"b\"] mod c;\n")],
    );
    assert_permits(rules::module_paths, &[("a.rs", "// #[path = \"b.rs\"]\nmod c;\n")]);
}

#[test]
fn crates_include_no_files_of_others() {
    assert_obeyed(rules::own_files);
    assert_catches(
        rules::own_files,
        &[
            ("engine/a/src/b.rs", "const A: &str = include_str!(\"../../c.txt\");\n"),
            ("engine/a/src/b/c.rs", "    include_bytes!(\"../../../c.spv\"),\n"),
            ("engine/a/src/lib.rs", "#[path = \"../../../b.rs\"]\nmod b;\n"),
        ],
    );
    let own = "macro_rules! a { ($a:literal) => { include_bytes!(concat!(\"../\", $a)) } }";
    assert_permits(rules::own_files, &[("shaders/src/lib.rs", own)]);
}

#[test]
fn unsafe_code_stays_in_its_crates() {
    assert_obeyed(rules::safe_crates);
    let allowed = "#![allow(unsafe_code, reason = \"x\")]";
    assert_catches(rules::safe_crates, &[("engine/render/src/lib.rs", allowed)]);
    assert_permits(rules::safe_crates, &[("engine/gpu/src/lib.rs", allowed)]);
}

#[test]
fn one_file_of_the_programs_knows_vulkan() {
    assert_obeyed(rules::programs_without_vulkan);
    assert_catches(
        rules::programs_without_vulkan,
        &[
            ("samples/src/window/a.rs", "use ash::vk;"),
            ("samples/src/hud/mod.rs", "fn a(_: antumbra::gpu::vk::Format) {}"),
            ("samples/bench/src/a.rs", "use egui_ash_renderer::Renderer;"),
        ],
    );
    assert_permits(
        rules::programs_without_vulkan,
        &[(rules::EGUI_OVER_VULKAN, "use ash::vk;"), ("samples/src/a.rs", "// ash::vk")],
    );
}

#[test]
fn nothing_is_left_for_later() {
    assert_obeyed(rules::unfinished);
    let mark = ["TO", "DO"].concat();
    let forbidden = [("a.rs", format!("// {mark}: more")), ("c.vert", format!("// {mark}"))];
    for (path, text) in &forbidden {
        assert_catches(rules::unfinished, &[(path, text)]);
    }
    assert_permits(rules::unfinished, &[("a.rs", "let mastodon = autodo; // as todos go")]);
}

#[test]
fn every_wait_has_a_bound() {
    assert_obeyed(rules::unbounded_waits);
    assert_catches(
        rules::unbounded_waits,
        &[
            ("a.rs", "device.wait_semaphores(&info, u64::MAX)"),
            (
                "a.rs",
                "let timeout = u64::MAX;\ndevice.wait_for_fences(\n    &[fence],\n    timeout)",
            ),
            ("a.rs", "swapchain.acquire_next_image(\n    chain,\n    !0,\n)"),
            ("a.rs", "let bound = Duration::MAX;"),
        ],
    );
    assert_permits(
        rules::unbounded_waits,
        &[("a.rs", "device.wait_semaphores(&info, bound_ns)"), ("b.rs", "let mask = u64::MAX;")],
    );
}

#[test]
fn the_engine_keeps_no_state_of_the_whole_process() {
    assert_obeyed(rules::global_state);
    assert_catches(
        rules::global_state,
        &[
            ("engine/gpu/src/a.rs", "pub static A: AtomicU64 = AtomicU64::new(0);"),
            ("engine/cull/src/a.rs", "fn a() {\n    static B: OnceLock<u32> = OnceLock::new();\n}"),
            ("engine/render/src/a.rs", "pub(crate) static C: Mutex<u32> = Mutex::new(0);"),
            ("engine/capi/src/a.rs", "static mut D: u32 = 0;"),
            ("engine/import/src/a.rs", "thread_local! {\n    static E: Cell<u32> = a();\n}"),
        ],
    );
    assert_permits(
        rules::global_state,
        &[
            ("engine/gpu/src/a.rs", "static NAMES: [&str; 1] = [a];\nconst A: &'static str = b;"),
            (
                "engine/gpu/src/a.rs",
                "#[cfg(test)]\nmod tests {\n    static A: Mutex<u32> = a();\n}",
            ),
            ("engine/gpu/src/a.rs", "struct A {\n    b: &'static Mutex<u32>,\n}"),
            ("samples/src/a.rs", "static A: AtomicU64 = AtomicU64::new(0);"),
        ],
    );
}

#[test]
fn names_say_what_things_are() {
    assert_obeyed(rules::names);
    assert_catches(
        rules::names,
        &[
            ("a.rs", "pub fn get_device(&self) {}"),
            ("a.rs", "struct BufferManager;"),
            ("a.rs", "mod utils;"),
        ],
    );
    assert_permits(rules::names, &[("a.rs", "device.get_device_queue(0, 0) // no Manager")]);
}

/// Returns files of a crate, by the part of the path after `a/src/`.
fn crate_files<const N: usize>(files: [(&str, &str); N]) -> [SourceFile; N] {
    files.map(|(path, text)| SourceFile::new(&format!("a/src/{path}"), text))
}

#[test]
fn files_import_each_other_in_no_large_circle() {
    assert_obeyed(knots::circles);
    let circle = |last: &str| {
        crate_files([
            ("lib.rs", "mod b; mod c; mod d; mod e; pub use b::B;"),
            ("b.rs", "pub struct B; fn b(_: crate::c::C) {}"),
            ("c.rs", "use super::d; pub struct C(d::D);"),
            ("d.rs", "pub struct D; fn d() -> crate::e::E {}"),
            ("e.rs", last),
        ])
    };
    let tied = circle("use crate::B; pub struct E;");
    let findings = knots::circles(&tied).join("\n");
    for arrow in ["b.rs -> a/src/c.rs: C", "c.rs -> a/src/d.rs: D", "e.rs -> a/src/b.rs: B"] {
        assert!(findings.contains(arrow), "{arrow} is not in:\n{findings}");
    }
    let free = circle("pub struct E; #[cfg(test)] mod tests { use crate::B; }");
    assert_eq!(knots::circles(&free), [""; 0]);
}

#[test]
fn the_methods_of_a_type_stand_in_its_file_or_in_api() {
    assert_obeyed(knots::scattered_impls);
    let methods_in = |path, text| {
        let root = "mod b; mod c; mod api;";
        let api = "mod d;";
        let b = "pub struct B; impl B {} impl Iterator for B {}";
        let files = [("lib.rs", root), ("api/mod.rs", api), ("b.rs", b), (path, text)];
        crate_files(files)
    };
    let scattered = methods_in("c.rs", "use crate::b; impl b::B {}");
    assert_eq!(knots::scattered_impls(&scattered).len(), 1);
    let root = ("lib.rs", "mod b; mod c;");
    let b = ("b.rs", "pub struct B;");
    let alone = crate_files([root, b, ("c.rs", "impl crate::b::B {}")]);
    assert_eq!(knots::scattered_impls(&alone).len(), 1);
    for (path, text) in [
        ("api/d.rs", "use crate::b::B; impl B {}"),
        ("c.rs", "use crate::b::B; impl Drop for B {} fn c() -> impl crate::b::B {}"),
        ("c.rs", "struct C; impl C {} #[cfg(test)] mod tests { use crate::b::B; impl B {} }"),
    ] {
        assert_eq!(knots::scattered_impls(&methods_in(path, text)), [""; 0]);
    }
}

#[test]
fn public_types_of_two_packages_have_two_names() {
    assert_obeyed(types::one_name_one_type);
    let at = |path, text| SourceFile::new(path, text);
    let one = "pub struct Camera {}\n";
    let other = "pub enum Camera {}\n";
    let found = |other_path, other| {
        types::one_name_one_type(&[at("engine/cull/src/a.rs", one), at(other_path, other)]).len()
    };
    for other_path in ["engine/import/src/b.rs", "samples/src/hud/b.rs", "tests/src/b.rs"] {
        assert_eq!(found(other_path, other), 1, "{other_path}");
    }
    assert_eq!(found("tests/tests/gpu/b.rs", other), 0, "a test's own");
    assert_eq!(found("samples/bench/src/b/tests.rs", other), 0, "a unit test's own");
    assert_eq!(found("engine/cull/src/b.rs", other), 0, "one crate's modules may");
    assert_eq!(found("engine/import/src/b.rs", "pub(crate) struct Camera;\n"), 0);
    assert_eq!(found("engine/import/src/b.rs", "pub struct Error;\n"), 0);
}

#[test]
fn pages_quote_examples_that_are_compiled() {
    assert_obeyed(rules::quoted_examples);
    let facade = "//! A.\n//! ```no_run\n//! a();\n//! # hidden();\n//! ```\n";
    let files = |readme| {
        [
            SourceFile::new("docs/page.md", readme),
            SourceFile::new("engine/antumbra/src/lib.rs", facade),
        ]
    };
    assert_eq!(rules::quoted_examples(&files("A.\n```rust\na();\n```\nB.\n")).len(), 0);
    let wrong = "A.\n```rust\na();\n```\n```rust\nb();\n```\n";
    let findings = rules::quoted_examples(&files(wrong));
    assert!(findings.len() == 1 && findings[0].starts_with("docs/page.md:5:"), "{findings:?}");
}

#[test]
fn every_shader_has_its_spirv_and_every_spirv_its_shader() {
    assert_obeyed(rules::committed_spirv);
    assert_catches(
        rules::committed_spirv,
        &[("shaders/a.vert", "// A."), ("shaders/a.frag.spv", "")],
    );
    assert_permits(rules::committed_spirv, &[("shaders/common.glsl", "// An include.")]);
}
