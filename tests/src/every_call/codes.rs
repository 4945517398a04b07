//! The codes that each call may return, as the registry of Vulkan lists them.

use std::collections::HashMap;
use std::sync::OnceLock;

use ash::vk;

use super::calls::NAMES;
use super::state::CallNumber;

/// A code that no registry has.
pub const INVENTED: vk::Result = vk::Result::from_raw(-1_999_999_999);

const TABLE: &str = include_str!("codes.txt");

struct Codes {
    numbers: HashMap<&'static str, CallNumber>,
    codes: Vec<Vec<vk::Result>>,
}

fn table() -> &'static Codes {
    static CODES: OnceLock<Codes> = OnceLock::new();
    CODES.get_or_init(|| {
        let mut numbers: HashMap<&str, CallNumber> =
            NAMES.iter().enumerate().map(|(number, name)| (*name, number)).collect();
        let mut codes = vec![Vec::new(); NAMES.len()];
        for line in TABLE.lines().filter(|line| !line.starts_with('#')) {
            let words: Vec<&str> = line.split(' ').collect();
            match words[..] {
                [alias, "=", name] => {
                    numbers.insert(alias, numbers[name]);
                }
                [name, ref rest @ ..] => {
                    codes[numbers[name]] = rest.iter().filter_map(|word| parse_code(word)).collect()
                }
                [] => {}
            }
        }
        Codes { numbers, codes }
    })
}

/// Returns the version of Vulkan whose registry the table is made from.
pub fn table_version() -> &'static str {
    TABLE.split([' ', ':']).nth(2).unwrap_or_default()
}

/// Returns the number of a call, also by an alias.
pub fn number_of(name: &str) -> Option<CallNumber> {
    table().numbers.get(name).copied()
}

/// Returns the name of a call.
pub fn name_of(number: CallNumber) -> &'static str {
    NAMES[number]
}

/// Returns the codes other than `SUCCESS` that a call may return.
pub fn codes_of(number: CallNumber) -> &'static [vk::Result] {
    &table().codes[number]
}

/// Returns the code with a name, as the registry or `Debug` writes it. `None` for codes of
/// extensions that no crate knows.
pub fn parse_code(name: &str) -> Option<vk::Result> {
    static NAMED: OnceLock<HashMap<String, vk::Result>> = OnceLock::new();
    let named = NAMED.get_or_init(|| {
        let core = -13..=5;
        // The codes of extension N begin at 1,000,000,000 + 1,000 (N - 1).
        let extensions = (0..600).flat_map(|extension| {
            let first = 1_000_000_000 + 1000 * extension;
            (first..first + 8).flat_map(|code| [code, -code])
        });
        let all = core.chain(extensions).chain([INVENTED.as_raw()]);
        all.map(vk::Result::from_raw).map(|code| (format!("{code:?}"), code)).collect()
    });
    let aliased = match name {
        "PIPELINE_COMPILE_REQUIRED_EXT" => "PIPELINE_COMPILE_REQUIRED",
        "ERROR_FRAGMENTATION_EXT" => "ERROR_FRAGMENTATION",
        "ERROR_INVALID_EXTERNAL_HANDLE_KHR" => "ERROR_INVALID_EXTERNAL_HANDLE",
        "ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS_KHR" => "ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS",
        other => other,
    };
    named.get(aliased).copied()
}
