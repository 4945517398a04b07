//! File names and other untrusted text, escaped for terminals.

use std::fmt::{self, Write};
use std::path::Path;

/// Returns a file's name on one line: control characters, invisible marks that reorder text, and
/// bytes that are not UTF-8 are escaped.
pub fn shown(path: &Path) -> Shown<'_> {
    Shown(path)
}

/// A file's name for messages.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a>(&'a Path);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for chunk in self.0.as_os_str().as_encoded_bytes().utf8_chunks() {
            for character in chunk.valid().chars() {
                write_escaped(formatter, character)?;
            }
            for byte in chunk.invalid() {
                write!(formatter, "\\x{byte:02x}")?;
            }
        }
        Ok(())
    }
}

/// Returns the text with everything escaped that a terminal would interpret; line breaks and tabs
/// stay.
pub fn harmless(text: &str) -> String {
    let mut harmless = String::with_capacity(text.len());
    for character in text.chars() {
        // Writing to a String cannot fail.
        let _ok = match character {
            '\n' | '\t' => harmless.write_char(character),
            _ => write_escaped(&mut harmless, character),
        };
    }
    harmless
}

fn write_escaped(into: &mut impl Write, character: char) -> fmt::Result {
    match character {
        _ if !is_obeyed(character) => into.write_char(character),
        '\n' | '\r' | '\t' => write!(into, "{}", character.escape_default()),
        _ if character.is_ascii() => write!(into, "\\x{:02x}", u32::from(character)),
        _ => write!(into, "{}", character.escape_unicode()),
    }
}

/// Returns true for control characters, line separators, and marks that change the direction of
/// text.
fn is_obeyed(character: char) -> bool {
    character.is_control()
        || matches!(character, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_on_their_line_and_give_no_orders() {
        for (name, text) in [
            ("Räume/日本 x.glb", "Räume/日本 x.glb"),
            ("a\nerror: b", "a\\nerror: b"),
            ("\u{1b}[31mred\u{7}", "\\x1b[31mred\\x07"),
            ("tab\tcr\r", "tab\\tcr\\r"),
            ("c1\u{9b}2J", "c1\\u{9b}2J"),
            ("exe\u{202e}gpj", "exe\\u{202e}gpj"),
        ] {
            assert_eq!(shown(Path::new(name)).to_string(), text);
        }
    }

    #[cfg(unix)]
    #[test]
    fn bytes_that_are_no_text_are_told_apart() {
        use std::os::unix::ffi::OsStrExt;

        let name = std::ffi::OsStr::from_bytes(b"a\xff\xc3b");
        assert_eq!(shown(Path::new(name)).to_string(), "a\\xff\\xc3b");
    }

    #[test]
    fn messages_keep_their_lines() {
        assert_eq!(harmless("one\n\ttwo \u{1b}[2J"), "one\n\ttwo \\x1b[2J");
    }
}
