//! The interface as C and C++ compilers see it: sizes and offsets of fields, constants, symbols.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use antumbra_capi::structs::STRUCTS;

const HEADER: &str = include_str!("../include/antumbra.h");

/// Compiles a file that includes the header.
fn compile(compiler: &str, standard: &str, name: &str, code: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = folder.join(name);
    std::fs::write(&file, code).unwrap();
    let output = Command::new(compiler)
        .args([standard, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"])
        .arg("-I")
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("include"))
        .arg(&file)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Returns a check of every struct by the compiler.
fn checks(keyword: &str) -> String {
    let mut code = "#include <antumbra_vulkan.h>\n".to_owned();
    for layout in STRUCTS {
        let name = layout.name;
        let mut check = |condition: String| {
            writeln!(code, "{keyword}({condition}, \"{name}\");").unwrap();
        };
        check(format!("sizeof({name}) == {}", layout.size));
        for field in layout.fields {
            check(format!("offsetof({name}, {}) == {}", field.name, field.offset));
            check(format!("sizeof((({name} *)0)->{}) == {}", field.name, field.size));
        }
    }
    code
}

#[test]
fn c_and_rust_agree_about_every_struct() {
    let declared: Vec<&str> = HEADER
        .lines()
        .filter_map(|line| line.strip_prefix("typedef struct ")?.strip_suffix(" {"))
        .collect();
    let mut known: Vec<&str> = STRUCTS.iter().map(|layout| layout.name).collect();
    known.sort_unstable();
    let mut sorted = declared;
    sorted.sort_unstable();
    assert_eq!(sorted, known, "`STRUCTS` lists the structs of the header");
    compile("cc", "-std=c11", "abi.c", &checks("_Static_assert"));
    compile("c++", "-std=c++17", "abi.cpp", &checks("static_assert"));
}

#[test]
fn a_wrong_layout_is_found() {
    let wrong = checks("_Static_assert").replacen("== 8,", "== 12,", 1);
    let compiled = std::panic::catch_unwind(|| compile("cc", "-std=c11", "wrong.c", &wrong));
    assert!(compiled.is_err());
}

#[test]
fn the_snippets_of_the_page_compile_silently() {
    let page = include_str!("../README.md");
    let snippets = page.split("```c\n").skip(1).filter_map(|rest| rest.split("```").next());
    assert_eq!(snippets.clone().count(), 5);
    for (number, code) in snippets.enumerate() {
        compile("cc", "-std=c11", &format!("snippet_{number}.c"), code);
    }
}

#[test]
fn structs_begin_silently_in_both_languages() {
    let mut code = "#include <antumbra_vulkan.h>\n".to_owned();
    let versioned = STRUCTS.iter().filter(|layout| layout.fields[0].name == "struct_size");
    for (number, layout) in versioned.enumerate() {
        let name = layout.name;
        writeln!(code, "{name} global_{number} = ANTUMBRA_INIT({name});").unwrap();
        writeln!(code, "uint32_t size_{number}(void);").unwrap();
        writeln!(code, "uint32_t size_{number}(void) {{").unwrap();
        writeln!(code, "    {name} value = ANTUMBRA_INIT({name});").unwrap();
        writeln!(code, "    return value.struct_size;\n}}").unwrap();
    }
    compile("cc", "-std=c11", "init.c", &code);
    compile("c++", "-std=c++17", "init.cpp", &code);
}
