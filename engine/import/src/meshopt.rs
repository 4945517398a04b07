//! Compressed views (`EXT_meshopt_compression`, `KHR_meshopt_compression`). They are decompressed
//! into their buffers, so that later stages see plain views.

mod decode;

use gltf::json::Root;
use gltf::json::buffer::View;
use scene::counted;
use serde_json::{Map, Value};

use crate::Limits;
use crate::element::Kind;
use crate::elements::{BufferBytes, Store};
use crate::error::{At, Fault, Reason};
use crate::extensions::{self, MESHOPT, compression, compression_of};
use crate::verdict::Verdict;

/// A view whose bytes are compressed in another buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Compressed {
    view: usize,
    extension: &'static str,
    from_buffer: usize,
    from_byte: usize,
    bytes: usize,
    stride: usize,
    count: usize,
    mode: Mode,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Attributes(Filter),
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Colour,
}

/// Checks all views that are marked as compressed, and lists those without uncompressed bytes.
/// Views and buffers must have been checked before.
pub(crate) fn compressed(
    root: &Root,
    placeholders: &[bool],
    limits: &Limits,
    verdict: &mut Verdict,
) -> Result<Vec<Compressed>, Fault> {
    let mut all = Vec::new();
    let mut total: u64 = 0;
    for (index, view) in root.buffer_views.iter().enumerate() {
        let Some((name, extension)) = compression_of(view) else { continue };
        let at = || format!("buffer view {index}, {name}");
        let element = Kind::View.at(index);
        let compressed = of_view(root, index, view, name, extension).and_then(|compressed| {
            let from = compressed.from_buffer;
            let is_into_placeholder = placeholders.get(view.buffer.value()) == Some(&true);
            if is_into_placeholder && placeholders.get(from) == Some(&true) {
                let text = format!("its buffer {from} has no bytes of its own");
                return Err(Reason::malformed(text));
            }
            Ok(Some(compressed).filter(|_| is_into_placeholder))
        });
        let compressed = verdict.judge(element, compressed.at(at))?.flatten();
        let Some(compressed) = compressed.filter(|_| verdict.is_used(element)) else {
            continue;
        };
        // A few bytes can decompress to many, and many views can share these bytes.
        total = total.saturating_add(view.byte_length.0);
        if total > limits.buffer_bytes {
            return Err(Reason::too_large(
                "bytes decompressed up to it",
                total,
                limits.buffer_bytes,
            )
            .of(at()));
        }
        all.push(compressed);
    }
    Ok(all)
}

/// Returns true for each buffer that only states the size of decompressed views.
pub(crate) fn placeholders(root: &Root, has_binary: bool) -> Vec<bool> {
    let mut is_compressed_into = vec![false; root.buffers.len()];
    for view in &root.buffer_views {
        let is_compressed = compression_of(view).is_some();
        if let Some(slot) = is_compressed_into.get_mut(view.buffer.value()) {
            *slot |= is_compressed;
        }
    }
    let buffers = root.buffers.iter().zip(is_compressed_into).enumerate();
    let is_placeholder = buffers.map(|(index, (buffer, is_compressed_into))| {
        let extension = buffer.extensions.as_ref().and_then(|all| compression(&all.others));
        let fallback = extension.and_then(|(_, values)| values.get("fallback"));
        let is_marked = fallback == Some(&Value::Bool(true));
        let is_binary_chunk = index == 0 && has_binary;
        // A buffer without bytes is a fault, unless a view is decompressed into it.
        is_marked || (buffer.uri.is_none() && !is_binary_chunk && is_compressed_into)
    });
    is_placeholder.collect()
}

fn of_view(
    root: &Root,
    index: usize,
    view: &View,
    extension: &'static str,
    said: &Value,
) -> Result<Compressed, Reason> {
    let json = said.as_object().ok_or_else(|| Reason::malformed("it is not an object"))?;
    let number = |key: &str| -> Result<usize, Reason> {
        let value = json.get(key).ok_or_else(|| Reason::malformed(format!("it has no {key}")))?;
        extensions::index(value)
            .ok_or_else(|| Reason::malformed(format!("its {key} is not a whole number")))
    };
    let from_byte = if json.contains_key("byteOffset") { number("byteOffset")? } else { 0 };
    let found = Compressed {
        view: index,
        extension,
        from_buffer: number("buffer")?,
        from_byte,
        bytes: number("byteLength")?,
        stride: number("byteStride")?,
        count: number("count")?,
        mode: mode(json, extension)?,
    };
    let buffer = root
        .buffers
        .get(found.from_buffer)
        .ok_or_else(|| Reason::out_of_range("buffer", found.from_buffer, root.buffers.len()))?;
    let end = found.from_byte.checked_add(found.bytes);
    if end.is_none_or(|end| end as u64 > buffer.byte_length.0) {
        return Err(Reason::malformed("it ends beyond its buffer"));
    }
    found.check_layout()?;
    if found.count.checked_mul(found.stride).map(|bytes| bytes as u64) != Some(view.byte_length.0) {
        let text = format!(
            "its view has {}, and not {} of {}",
            counted(view.byte_length.0, "byte", "bytes"),
            counted(found.count, "element", "elements"),
            counted(found.stride, "byte", "bytes")
        );
        return Err(Reason::malformed(text));
    }
    Ok(found)
}

fn mode(json: &Map<String, Value>, extension: &str) -> Result<Mode, Reason> {
    let filter = match json.get("filter").map(Value::as_str) {
        None | Some(Some("NONE")) => Filter::None,
        Some(Some("OCTAHEDRAL")) => Filter::Octahedral,
        Some(Some("QUATERNION")) => Filter::Quaternion,
        Some(Some("EXPONENTIAL")) => Filter::Exponential,
        Some(Some("COLOR")) if extension == MESHOPT[1] => Filter::Colour,
        Some(Some("COLOR")) => {
            let text = format!("its filter COLOR is one of {}, not of {extension}", MESHOPT[1]);
            return Err(Reason::malformed(text));
        }
        Some(_) => return Err(Reason::malformed("its filter does not exist")),
    };
    match (json.get("mode").and_then(Value::as_str), filter) {
        (Some("ATTRIBUTES"), filter) => Ok(Mode::Attributes(filter)),
        (Some("TRIANGLES"), Filter::None) => Ok(Mode::Triangles),
        (Some("INDICES"), Filter::None) => Ok(Mode::Indices),
        (Some("TRIANGLES" | "INDICES"), _) => Err(Reason::malformed("its mode allows no filter")),
        _ => Err(Reason::malformed("its mode does not exist")),
    }
}

impl Compressed {
    fn check_layout(&self) -> Result<(), Reason> {
        let stride = self.stride;
        let fits = match self.mode {
            Mode::Attributes(filter) => {
                let fits_filter = match filter {
                    Filter::None | Filter::Exponential => true,
                    Filter::Octahedral | Filter::Colour => stride == 4 || stride == 8,
                    Filter::Quaternion => stride == 8,
                };
                fits_filter && stride.is_multiple_of(4) && (4..=256).contains(&stride)
            }
            Mode::Triangles => self.count.is_multiple_of(3) && (stride == 2 || stride == 4),
            Mode::Indices => stride == 2 || stride == 4,
        };
        if fits {
            return Ok(());
        }
        let text = format!(
            "its mode does not allow {} of {}",
            counted(self.count, "element", "elements"),
            counted(stride, "byte", "bytes")
        );
        Err(Reason::malformed(text))
    }
}

/// Decompresses these views into their buffers.
pub(crate) fn decompress(
    root: &Root,
    all: &[Compressed],
    store: &mut Store,
    verdict: &mut Verdict,
) -> Result<(), Fault> {
    for compressed in all {
        let at = || format!("buffer view {}, {}", compressed.view, compressed.extension);
        let encoded = store.buffer(compressed.from_buffer).get(compressed.from_byte..);
        let encoded = encoded.and_then(|bytes| bytes.get(..compressed.bytes)).unwrap_or_default();
        let element = Kind::View.at(compressed.view);
        let decoded = if verdict.is_kept(root, element) {
            decode::decode(compressed, encoded).at(at)
        } else {
            continue;
        };
        let Some(bytes) = verdict.judge(element, decoded)? else { continue };
        let Some(view) = root.buffer_views.get(compressed.view) else { continue };
        let start = view.byte_offset.unwrap_or_default().0 as usize;
        if let Some(BufferBytes::Apart(buffer)) = store.buffers.get_mut(view.buffer.value())
            && let Some(place) = buffer.get_mut(start..start.saturating_add(bytes.len()))
        {
            place.copy_from_slice(&bytes);
        }
    }
    Ok(())
}
