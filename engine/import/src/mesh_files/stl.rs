//! STL files: binary ones are recognised by their length, all others are text. The crate `stl_io`
//! reads triangles; values that it would not check are checked before.

use std::collections::HashMap;
use std::io::Cursor;

use glam::Vec3;
use stl_io::Triangle;

use super::{Corner, MeshFile, MeshPart, Reading};
use crate::error::{Fault, Reason, quoted};
use crate::memory;

/// The bytes before the triangles of a binary file: a comment and the number of triangles.
const HEADER_BYTES: usize = 84;

/// The bytes of a triangle in a binary file.
const TRIANGLE_BYTES: usize = 50;

/// The longest line of a text: the crate keeps each word of a line.
const LONGEST_LINE: usize = 4096;

/// The most memory per triangle while it is read and welded, in bytes.
const TRIANGLE_MEMORY_BYTES: u64 = 256;

/// Returns the number of triangles that a binary file states.
fn stated_triangles(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(HEADER_BYTES - 4..HEADER_BYTES)?;
    count.try_into().ok().map(u32::from_le_bytes)
}

/// Returns true if the length of a file matches its stated number of triangles. Such a file is
/// binary even if it begins with "solid".
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    let stated =
        stated_triangles(bytes).and_then(|count| (count as usize).checked_mul(TRIANGLE_BYTES));
    stated.is_some_and(|stated| stated > 0 && bytes.len() - HEADER_BYTES == stated)
}

/// Returns true if a file contains the words of a text, and no byte that texts never have.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.get(..bytes.len().min(1024)).unwrap_or_default();
    let words = start.trim_ascii_start();
    words.starts_with(b"solid") && !start.contains(&0)
}

/// Reads a file: each of its solids is a part.
pub(super) fn read(bytes: &[u8], reading: &mut Reading<'_, '_>) -> Result<MeshFile, Fault> {
    let mut welder = Welder::default();
    if !is_binary(bytes) && is_text(bytes) {
        return read_text(bytes, welder, reading);
    }
    let Some(stated) = stated_triangles(bytes) else {
        return Err(Reason::not_scene("it is too short for an STL file").of("the header"));
    };
    let room = (bytes.len() - HEADER_BYTES) / TRIANGLE_BYTES;
    if stated as usize > room {
        let reason =
            format!("it says that {stated} triangles follow, but only {room} fit the file");
        return Err(Reason::damaged(reason).of("the header"));
    }
    if room > stated as usize {
        reading.notes.say("bytes after the last triangle are left out");
    }
    memory::ask(u64::from(stated) * TRIANGLE_MEMORY_BYTES)
        .map_err(|reason| reason.of("the triangles"))?;
    let mut cursor = Cursor::new(bytes);
    // The crate takes files that begin with "solid " for text, and reads a whole line to decide.
    let header = [[b'\n'; HEADER_BYTES - 4].as_slice(), &stated.to_le_bytes()].concat();
    cursor.set_position(HEADER_BYTES as u64);
    let mut source = HeaderFirst { header: Cursor::new(header), rest: cursor };
    let triangles =
        stl_io::create_stl_reader(&mut source).map_err(|error| damaged(&error, "triangles"))?;
    let mut part = MeshPart::default();
    for (number, triangle) in (0_u32..).zip(triangles) {
        let triangle = triangle.map_err(|error| damaged(&error, "triangles"))?;
        reading.count_triangle(number as f32 / stated.max(1) as f32)?;
        welder.add(&triangle, &mut part, reading, || format!("triangle {number}"))?;
    }
    Ok(MeshFile { positions: welder.positions, parts: vec![part], ..MeshFile::default() })
}

fn damaged(error: &std::io::Error, object: &str) -> Fault {
    Reason::damaged(quoted(&error.to_string())).of(object)
}

/// Reads a text of consecutive solids, each from its first line to its last.
fn read_text(
    bytes: &[u8],
    mut welder: Welder,
    reading: &mut Reading<'_, '_>,
) -> Result<MeshFile, Fault> {
    memory::ask(bytes.len() as u64 * 2).map_err(|reason| reason.of("the text"))?;
    let mut parts = Vec::new();
    let mut solid = Vec::new();
    let mut name = None;
    let mut read = 0;
    for (number, line) in (1_u32..).zip(bytes.split(|byte| *byte == b'\n')) {
        read += line.len() + 1;
        if line.len() > LONGEST_LINE {
            let reason = format!("it is longer than {LONGEST_LINE} bytes");
            return Err(Reason::damaged(reason).of(format!("line {number}")));
        }
        let line = line.trim_ascii();
        let is_start = is_word(line, b"solid");
        if name.is_none() && is_start {
            let rest = line.get(5..).unwrap_or_default().trim_ascii();
            name = Some(String::from_utf8_lossy(rest).into_owned());
            // The crate requires the space after the word.
            solid.extend_from_slice(b"solid \n");
        } else if name.is_some() && is_word(line, b"endsolid") {
            solid.extend_from_slice(b"endsolid\n");
            let part = MeshPart { name: name.take().unwrap_or_default(), ..MeshPart::default() };
            let share = read as f32 / bytes.len() as f32;
            parts.push(read_solid(&mut solid, part, share, &mut welder, reading)?);
        } else if name.is_some() {
            solid.extend_from_slice(line);
            solid.push(b'\n');
        }
    }
    if let Some(name) = name {
        let object = format!("solid {}", quoted(&name));
        return Err(Reason::damaged("it has no end").of(object));
    }
    Ok(MeshFile { positions: welder.positions, parts, ..MeshFile::default() })
}

fn is_word(line: &[u8], word: &[u8]) -> bool {
    line.strip_prefix(word).is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
}

/// Parses the lines of a solid, and removes them.
fn read_solid(
    solid: &mut Vec<u8>,
    mut part: MeshPart,
    share: f32,
    welder: &mut Welder,
    reading: &mut Reading<'_, '_>,
) -> Result<MeshPart, Fault> {
    let object = || format!("solid {}", quoted(&part.name));
    let mut cursor = Cursor::new(std::mem::take(solid));
    let triangles =
        stl_io::create_stl_reader(&mut cursor).map_err(|error| damaged(&error, &object()))?;
    let mut found = Vec::new();
    for (number, triangle) in (0_u32..).zip(triangles) {
        let at = || format!("{}, triangle {number}", object());
        found.push(triangle.map_err(|error| damaged(&error, &at()))?);
        reading.count_triangle(share)?;
    }
    for (number, triangle) in (0_u32..).zip(&found) {
        let name = format!("solid {}, triangle {number}", quoted(&part.name));
        welder.add(triangle, &mut part, reading, || name)?;
    }
    Ok(part)
}

/// Positions without repetitions.
#[derive(Default)]
struct Welder {
    positions: Vec<Vec3>,
    known: HashMap<[u32; 3], u32>,
}

impl Welder {
    /// Adds a triangle, unless a number is not finite.
    fn add(
        &mut self,
        triangle: &Triangle,
        part: &mut MeshPart,
        reading: &mut Reading<'_, '_>,
        object: impl FnOnce() -> String,
    ) -> Result<(), Fault> {
        let corners = triangle.vertices.map(|corner| Vec3::from_array(corner.0));
        if !corners.iter().all(|corner| corner.is_finite()) {
            return reading.leave_out(
                "a triangle has a position that is not a number, and is left out",
                object,
            );
        }
        part.triangles.push(corners.map(|corner| self.corner(corner)));
        reading.check_positions(self.positions.len())
    }

    fn corner(&mut self, position: Vec3) -> Corner {
        // Adding zero turns -0 into +0, which is the same place.
        let position = position + Vec3::ZERO;
        let positions = &mut self.positions;
        let index = *self.known.entry(position.to_array().map(f32::to_bits)).or_insert_with(|| {
            positions.push(position);
            positions.len() as u32 - 1
        });
        Corner { position: index, normal: None }
    }
}

/// A header, followed by the rest of a file.
struct HeaderFirst<'a> {
    header: Cursor<Vec<u8>>,
    rest: Cursor<&'a [u8]>,
}

impl std::io::Read for HeaderFirst<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let count = self.header.read(into)?;
        if count > 0 || into.is_empty() { Ok(count) } else { self.rest.read(into) }
    }
}

impl std::io::Seek for HeaderFirst<'_> {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.rest.set_position(HEADER_BYTES as u64);
        self.header.seek(to)
    }
}
