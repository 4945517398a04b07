//! MTL files: the names and colours of materials. Everything else in them is ignored.

use std::path::Path;

use crate::error::Reason;
use crate::uri::{self, Wanted};

/// A material of a part.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PartMaterial {
    pub(crate) name: String,
    /// Linear red, green, blue, 0 to 1.
    pub(crate) colour: [f32; 3],
}

/// The most bytes of a name in OBJ and MTL files.
pub(super) const MOST_NAME_BYTES: usize = 1024;

/// The colour of parts without a material.
pub(crate) const GREY: [f32; 3] = [0.5, 0.5, 0.5];

/// Returns a channel in linear light: colours in MTL files are sRGB.
fn linear(value: f32) -> f32 {
    let value = value.clamp(0.0, 1.0);
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Reads a file of materials in a folder.
pub(super) fn read(
    name: &str,
    folder: Option<&Path>,
    limit: u64,
) -> Result<Vec<PartMaterial>, Reason> {
    // Names are not URIs: a percent sign and a colon stand for themselves.
    let escaped = name.replace('%', "%25").replace('\\', "/").replace(':', "%3A");
    let bytes = uri::fetch(&escaped, folder, Wanted::All, limit)?;
    let mut found: Vec<PartMaterial> = Vec::new();
    for line in bytes.split(|byte| *byte == b'\n') {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_whitespace();
        match words.next() {
            Some("newmtl") => {
                let name = text.trim_start().strip_prefix("newmtl").unwrap_or_default().trim();
                // No reference can be longer.
                let name = if name.len() > MOST_NAME_BYTES { "" } else { name };
                found.push(PartMaterial { name: name.to_owned(), colour: GREY });
            }
            Some("Kd") => {
                let parts: Vec<f32> = words.map_while(|word| word.parse().ok()).take(3).collect();
                let is_finite = parts.iter().all(|part| part.is_finite());
                if let (Ok(colour), true, Some(last)) =
                    (<[f32; 3]>::try_from(parts), is_finite, found.last_mut())
                {
                    last.colour = colour.map(linear);
                }
            }
            _ => {}
        }
    }
    Ok(found)
}
