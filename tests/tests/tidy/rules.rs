//! The rules: each searches all files and returns its findings.

use crate::code::{has_word, without_comments_and_strings, without_tests};
use crate::files::SourceFile;

/// A rule: searches files, returns findings.
pub type Rule = fn(&[SourceFile]) -> Vec<String>;

const MAX_LINES: usize = 500;

/// Applies a check to each line of the Rust code, comments and strings blanked.
fn in_code(
    files: &[SourceFile],
    keep: impl Fn(&SourceFile) -> bool,
    forbidden: impl Fn(&str) -> bool,
    reason: &str,
) -> Vec<String> {
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.is_rust() && keep(file)) {
        let code = without_comments_and_strings(&file.text);
        for (line, text) in (1..).zip(code.lines()) {
            if forbidden(text) {
                findings.push(file.finding(line, reason));
            }
        }
    }
    findings
}

/// Finds crates other than `gpu` and the boundaries to C and wgpu that allow unsafe code.
pub fn safe_crates(files: &[SourceFile]) -> Vec<String> {
    const UNSAFE: [&str; 3] = ["engine/gpu/", "engine/capi/", "engine/wgpu/"];
    in_code(
        files,
        |file| {
            let is_ours = file.path.starts_with("engine/") || file.path.starts_with("samples/");
            is_ours && !UNSAFE.iter().any(|folder| file.path.starts_with(folder))
        },
        |line| line.contains("unsafe_code") && (line.contains("allow") || line.contains("expect")),
        "unsafe code is for gpu and the boundaries to C and wgpu",
    )
}

/// Finds files whose first line, or the one after the `#!`, does not name their purpose.
pub fn purpose(files: &[SourceFile]) -> Vec<String> {
    let mut findings = Vec::new();
    for file in files {
        let mark = match file.extension() {
            "rs" => "//! ",
            "glsl" => "// ",
            _ if file.is_stage() => "// ",
            _ if file.is_script() => "# ",
            _ => continue,
        };
        let mut lines = file.text.lines().skip_while(|line| line.starts_with("#!/"));
        let says = lines.next().and_then(|line| line.strip_prefix(mark));
        if says.is_none_or(|purpose| purpose.trim().is_empty()) {
            findings.push(file.finding(1, &format!("must begin with '{mark}' and its purpose")));
        }
    }
    findings
}

/// Finds files written by people that are too long to be read at once.
pub fn length(files: &[SourceFile]) -> Vec<String> {
    let written = |file: &&SourceFile| {
        file.is_rust()
            || file.is_stage()
            || file.is_script()
            || ["glsl", "md", "toml"].contains(&file.extension())
    };
    let too_long = |file: &SourceFile| {
        let lines = file.text.lines().count();
        (lines > MAX_LINES)
            .then(|| file.finding(lines, &format!("at most {MAX_LINES} lines: split it")))
    };
    files.iter().filter(written).filter_map(too_long).collect()
}

/// Finds files of a crate that include a file outside of it: the crate could not be packaged.
pub fn own_files(files: &[SourceFile]) -> Vec<String> {
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.is_rust() && !file.is_test()) {
        let Some((_, inside)) = file.path.split_once("src/") else { continue };
        // Folders between the file and its crate's root, `src` among them.
        let depth = inside.matches('/').count() + 1;
        for (line, text) in (1..).zip(without_tests(&file.text).lines()) {
            let includes = text.contains("include") || text.contains("#[path");
            if includes && text.contains(&format!("\"{}", "../".repeat(depth + 1))) {
                findings.push(file.finding(line, "must not include a file of another crate"));
            }
        }
    }
    findings
}

/// The only file of the programs that uses Vulkan: the crate that draws egui's triangles needs its
/// types.
pub const EGUI_OVER_VULKAN: &str = "samples/src/hud/overlay.rs";

/// Finds Vulkan in other files of the programs.
pub fn programs_without_vulkan(files: &[SourceFile]) -> Vec<String> {
    in_code(
        files,
        |file| file.path.starts_with("samples/") && file.path != EGUI_OVER_VULKAN,
        |line| ["ash", "vk", "egui_ash_renderer"].iter().any(|name| has_word(line, name)),
        "the programs know no Vulkan but in samples/src/hud/overlay.rs",
    )
}

/// The files with state of the whole process, and why it is there. Through unique numbers, and
/// through libraries that are loaded once, two devices cannot affect each other.
const GLOBAL: [(&str, &str); 6] = [
    ("engine/gpu/src/core/ownership.rs", "numbers of devices"),
    ("engine/gpu/src/core/pipeline_cache.rs", "numbers of temporary files"),
    ("engine/gpu/src/core/xcb.rs", "a library"),
    ("engine/gpu/src/present/display_link.rs", "a library"),
    ("engine/occlusion/src/leaf_table.rs", "numbers of tables"),
    ("engine/render/src/render_view.rs", "numbers of renderers"),
];

/// Finds state of the whole process in the engine's crates: statics that can change or are
/// initialised on first use.
pub fn global_state(files: &[SourceFile]) -> Vec<String> {
    let changing = ["Atomic", "Cell<", "Lazy", "Mutex<", "OnceLock", "RwLock<"];
    let is_allowed = |file: &SourceFile| GLOBAL.iter().any(|(path, _)| file.path == *path);
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.is_rust() && !file.is_test()) {
        if !file.path.starts_with("engine/") || !file.path.contains("/src/") || is_allowed(file) {
            continue;
        }
        let code = without_tests(&without_comments_and_strings(&file.text));
        for (line, text) in (1..).zip(code.lines()) {
            let declared = text.trim_start().trim_start_matches("pub(crate) ");
            let declared = declared.trim_start_matches("pub ");
            let changes = declared.starts_with("static mut ")
                || declared.starts_with("static ")
                    && changing.iter().any(|word| text.contains(word))
                || has_word(text, "thread_local");
            if changes {
                findings.push(file.finding(line, "state of the whole process: give it an owner"));
            }
        }
    }
    findings
}

/// Finds marks of unfinished work, which belong in an issue.
pub fn unfinished(files: &[SourceFile]) -> Vec<String> {
    // Joined from parts, so that the rule does not find this file.
    let marks =
        [["TO", "DO"], ["FIX", "ME"], ["XX", "X"], ["HA", "CK"]].map(|parts| parts.concat());
    let mut findings = Vec::new();
    for file in files {
        let shown = file.is_rust() || file.is_stage() || file.is_script();
        if !shown && !["glsl", "md", "toml"].contains(&file.extension()) {
            continue;
        }
        for (line, text) in (1..).zip(file.text.lines()) {
            if marks.iter().any(|mark| has_word(text, mark)) {
                findings.push(file.finding(line, "finish it, or write an issue"));
            }
        }
    }
    findings
}

/// Finds waits without a bound, which hang instead of reporting the error.
pub fn unbounded_waits(files: &[SourceFile]) -> Vec<String> {
    const WAITS: [&str; 4] =
        ["wait_semaphores", "wait_for_fences", "acquire_next_image", "wait_for_present"];
    const NEAR: usize = 4;
    let endless = |line: &str| {
        line.contains("Duration::MAX")
            || ["u64::MAX,", "u64::MAX)", "u64::MAX;", "!0,", "!0)", "!0;"]
                .iter()
                .any(|end| line.contains(end))
            || line.trim_end().ends_with("u64::MAX")
    };
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| file.is_rust()) {
        let code = without_comments_and_strings(&file.text);
        let lines: Vec<&str> = code.lines().collect();
        for (at, text) in lines.iter().enumerate().filter(|(_, text)| endless(text)) {
            let around = &lines[at.saturating_sub(NEAR)..(at + NEAR + 1).min(lines.len())];
            let waits = around.iter().any(|line| WAITS.iter().any(|wait| line.contains(wait)));
            if waits || text.contains("Duration::MAX") {
                findings.push(file.finding(at + 1, "every wait has a bound"));
            }
        }
    }
    findings
}

/// Finds modules whose files are not where their names say. Code that several programs share must
/// be a module or a crate.
pub fn module_paths(files: &[SourceFile]) -> Vec<String> {
    in_code(
        files,
        |_| true,
        |line| line.trim_start().starts_with("#[path"),
        "put the file where its module's name says, or share it by a crate",
    )
}

/// Finds names without a meaning, which attract too many purposes.
pub fn names(files: &[SourceFile]) -> Vec<String> {
    let empty = |word: &str| {
        ["Manager", "Helper", "Helpers", "Util", "Utils"].iter().any(|end| word.ends_with(end))
            || ["util", "utils", "helper", "helpers", "misc"].contains(&word)
    };
    in_code(
        files,
        |_| true,
        |line| {
            line.contains("fn get_")
                || line.split(|c: char| !c.is_alphanumeric() && c != '_').any(empty)
        },
        "name it after what it is or does",
    )
}

/// Finds Rust code in pages that is not an example in a crate's documentation, where it would be
/// compiled.
pub fn quoted_examples(files: &[SourceFile]) -> Vec<String> {
    let shown = |file: &SourceFile| {
        let documented = file.text.lines().filter_map(|line| {
            let line = line.trim_start();
            line.strip_prefix("//!").or_else(|| line.strip_prefix("///"))
        });
        let lines = documented.map(|line| line.strip_prefix(' ').unwrap_or(line));
        let shown = lines.filter(|line| !line.starts_with("# "));
        shown.flat_map(|line| [line, "\n"]).collect::<String>()
    };
    let compiled: Vec<String> = files.iter().filter(|file| file.is_rust()).map(shown).collect();
    let mut findings = Vec::new();
    for page in files.iter().filter(|file| file.extension() == "md") {
        for part in page.text.split("```rust\n").skip(1) {
            let code = part.split("```").next().unwrap_or(part);
            if !compiled.iter().any(|shown| shown.contains(code)) {
                let before = page.text.split(part).next().unwrap_or_default();
                let line = before.lines().count();
                findings
                    .push(page.finding(line, "must quote an example of a crate's documentation"));
            }
        }
    }
    findings
}

/// Finds shaders without their compiled SPIR-V, which builds without a shader compiler need.
pub fn committed_spirv(files: &[SourceFile]) -> Vec<String> {
    let exists = |path: &str| files.iter().any(|file| file.path == path);
    let mut findings = Vec::new();
    for file in files {
        if file.is_stage() && !exists(&format!("{}.spv", file.path)) {
            findings.push(file.finding(1, "its SPIR-V must lie beside it"));
        }
        if file.path.strip_suffix(".spv").is_some_and(|source| !exists(source)) {
            findings.push(file.finding(1, "its source is gone"));
        }
    }
    findings
}
