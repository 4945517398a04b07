//! Every function that C calls catches panics. The sources are searched, since calls cannot make
//! every function panic.

use std::path::{Path, PathBuf};

const HEADER: &str = include_str!("../../include/antumbra.h");

/// The functions that need no guard: they return a constant.
const CONSTANTS: [(&str, &str); 1] = [("antumbra_abi_version", "ANTUMBRA_ABI_VERSION")];

/// Returns all files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Returns name and body of the exported functions of a source, without blanks and comments.
fn exported(source: &str) -> Vec<(String, String)> {
    let after = source.split("#[unsafe(no_mangle)]").skip(1);
    let function = |text: &str| {
        let end = text.find("\n}").unwrap();
        let lines = text[..end].lines().map(str::trim).filter(|line| !line.starts_with("//"));
        let text: String = lines.collect::<Vec<_>>().join(" ");
        let (head, body) = text.split_once('{').unwrap();
        assert!(head.contains("extern \"C\""), "not of C: {head}");
        let name = head.split_once("fn ").unwrap().1.split('(').next().unwrap();
        (name.to_owned(), body.split_whitespace().collect())
    };
    after.map(function).collect()
}

/// Returns true if the whole body of a function is one guarded call.
fn is_guarded(body: &str) -> bool {
    let starts = ["unsafe{entry(context,error,|", "unsafe{guarded(error,||"];
    let Some(call) = body.strip_suffix('}') else { return false };
    if !starts.iter().any(|start| call.starts_with(start)) {
        return false;
    }
    // The parenthesis that the call opens is closed by the last character.
    let mut depth = 0;
    let opened = call.find('(').unwrap_or(0);
    let closed = call[opened..].char_indices().find(|(_, letter)| {
        depth += match letter {
            '(' => 1,
            ')' => -1,
            _ => 0,
        };
        depth == 0
    });
    closed.is_some_and(|(at, _)| opened + at + 1 == call.len())
}

#[test]
fn every_function_of_the_header_catches_panics() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    for file in files(&sources) {
        for (name, body) in exported(&std::fs::read_to_string(&file).unwrap()) {
            let is_constant = CONSTANTS.contains(&(name.as_str(), body.as_str()));
            assert!(is_constant || is_guarded(&body), "{name} does something unguarded: {body}");
            found.push(name);
        }
    }
    let declared = HEADER.lines().filter_map(|line| {
        let name = line.split('(').next()?.split_whitespace().last()?;
        (line.contains('(') && name.starts_with("antumbra_") && !line.starts_with([' ', '/']))
            .then(|| name.to_owned())
    });
    let mut declared: Vec<String> = declared.collect();
    found.sort_unstable();
    declared.sort_unstable();
    assert_eq!(found, declared);
}

#[test]
fn what_is_outside_of_the_guard_is_found() {
    for unguarded in [
        "",
        "call(context)",
        "unsafe{context.call();entry(context,error,|_|Ok(()))}",
        "unsafe{entry(context,error,|_|Ok(()));context.call()}",
        "unsafe{entry(context,error,|_|Ok(()))}+(1)}",
    ] {
        assert!(!is_guarded(unguarded), "{unguarded}");
    }
    assert!(is_guarded("unsafe{entry(context,error,|_|Ok((1)))}"));
}
