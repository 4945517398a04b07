//! OBJ files, read line by line. The engine uses only a few kinds of lines, and checks each line
//! when it is read, with its number. The crate `tobj` was considered: its version 4.0.5 panics on a
//! colour of one number, and its errors do not name a line.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::Vec3;

use super::materials::{self, MOST_NAME_BYTES, PartMaterial};
use super::{Corner, MeshFile, MeshPart, Reading};
use crate::error::{Fault, Reason, quoted};
use crate::memory;

/// The most corners of a face.
const MOST_CORNERS: usize = 1 << 16;

/// The most parts, in addition to the limit of objects.
const MOST_MATERIALS: usize = 1 << 16;

/// A file that is being read.
#[derive(Default)]
struct Reader {
    file: MeshFile,
    name: String,
    material: Option<usize>,
    /// The part for each name and material: a group may occur again.
    known: HashMap<(String, Option<usize>), usize>,
    part: Option<usize>,
    material_names: HashMap<String, usize>,
    /// The names of the material files that were read, without repetitions.
    libraries: HashSet<String>,
    /// The corners of the current face.
    face: Vec<Corner>,
}

/// Reads a file: each object or group becomes a part per material.
pub(super) fn read(
    bytes: &[u8],
    folder: Option<&Path>,
    reading: &mut Reading<'_, '_>,
) -> Result<MeshFile, Fault> {
    // A line of a face or a position takes less than twice its bytes per corner, plus some memory
    // for references to it.
    memory::ask(bytes.len() as u64 * 40).map_err(|reason| reason.of("the text"))?;
    let mut reader = Reader::default();
    let mut read = 0;
    let mut joined = Vec::new();
    for (number, line) in (1_u32..).zip(bytes.split(|byte| *byte == b'\n')) {
        read += line.len() + 1;
        let line = line.trim_ascii_end();
        // A backslash continues a line in the next one.
        if let Some(start) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(start);
            joined.push(b' ');
            continue;
        }
        joined.extend_from_slice(line);
        let text = String::from_utf8_lossy(&joined);
        let fraction = read as f32 / bytes.len().max(1) as f32;
        reader.line(&text, Line { number, fraction, folder }, reading)?;
        joined.clear();
    }
    Ok(reader.file)
}

/// A line of a file.
#[derive(Clone, Copy)]
struct Line<'a> {
    number: u32,
    /// The share of the file that is read.
    fraction: f32,
    folder: Option<&'a Path>,
}

impl Line<'_> {
    fn place(self) -> String {
        format!("line {}", self.number)
    }

    fn malformed(self, reason: impl Into<String>) -> Fault {
        Reason::malformed(reason).of(self.place())
    }
}

/// Returns three numbers, if all exist and are finite.
fn vector(words: &mut dyn Iterator<Item = &str>) -> Option<Vec3> {
    let mut part = || words.next()?.parse::<f32>().ok();
    let x = part()?;
    let y = part()?;
    let z = part()?;
    Some(Vec3::new(x, y, z)).filter(|vector| vector.is_finite())
}

/// Returns the list index for an OBJ index into a list of `count`: from 1 on, or negative from the
/// end.
fn index(text: &str, count: usize) -> Option<u32> {
    let given: i64 = text.parse().ok()?;
    let count = count as i64;
    let place = if given < 0 { count.checked_add(given)? } else { given - 1 };
    (0..count).contains(&place).then_some(place as u32)
}

impl Reader {
    fn line(
        &mut self,
        text: &str,
        line: Line<'_>,
        reading: &mut Reading<'_, '_>,
    ) -> Result<(), Fault> {
        let mut words = text.split_whitespace();
        let first = words.next().unwrap_or_default();
        let rest = text.trim_start().strip_prefix(first).unwrap_or_default().trim();
        if rest.len() > MOST_NAME_BYTES && matches!(first, "o" | "g" | "usemtl" | "mtllib") {
            return Err(line.malformed(format!("a name has more than {MOST_NAME_BYTES} bytes")));
        }
        match first {
            // The face that uses an invalid position reports it.
            "v" => {
                self.file.positions.push(vector(&mut words).unwrap_or(Vec3::NAN));
                reading.check_positions(self.file.positions.len())?;
            }
            "vn" => {
                self.file.normals.push(vector(&mut words).unwrap_or(Vec3::ZERO));
                reading.check_positions(self.file.normals.len())?;
            }
            "f" => return self.face(&mut words, line, reading),
            "o" | "g" => {
                self.name = rest.to_owned();
                self.part = None;
            }
            "usemtl" => {
                self.material = self.material_names.get(rest).copied();
                self.part = None;
                if self.material.is_none() {
                    let what = "a material is not there, and its faces are grey";
                    reading.notes.count(what, 1, || format!("material {}", quoted(rest)));
                }
            }
            "mtllib" if self.libraries.insert(rest.to_owned()) => {
                self.library(rest, line, reading)?;
            }
            "l" | "p" => {
                reading.notes.count("points and lines are left out", 1, || line.place());
            }
            "curv" | "curv2" | "surf" => {
                reading.notes.count("curves and surfaces are left out", 1, || line.place());
            }
            _ => {}
        }
        Ok(())
    }

    /// Reads a face as a fan of triangles.
    fn face(
        &mut self,
        words: &mut dyn Iterator<Item = &str>,
        line: Line<'_>,
        reading: &mut Reading<'_, '_>,
    ) -> Result<(), Fault> {
        self.face.clear();
        for word in words {
            let mut parts = word.split('/');
            let position = parts.next().and_then(|text| index(text, self.file.positions.len()));
            let is_there = |place: &u32| {
                self.file.positions.get(*place as usize).is_some_and(|at| at.is_finite())
            };
            let Some(position) = position.filter(is_there) else {
                let what = "a face has a position that is not there or no number, and is left out";
                return reading.leave_out(what, || line.place());
            };
            let normal = parts.nth(1).and_then(|text| index(text, self.file.normals.len()));
            self.face.push(Corner { position, normal });
            if self.face.len() > MOST_CORNERS {
                let reason = format!("a face has more than {MOST_CORNERS} corners");
                return Err(Reason::beyond_limits(reason).of(line.place()));
            }
        }
        if self.face.len() < 3 {
            let what = "a face has fewer than three corners, and is left out";
            return reading.leave_out(what, || line.place());
        }
        let part = self.current_part(line, reading)?;
        for place in 2..self.face.len() {
            reading.count_triangle(line.fraction)?;
            let corners = [self.face[0], self.face[place - 1], self.face[place]];
            if let Some(part) = self.file.parts.get_mut(part) {
                part.triangles.push(corners);
            }
        }
        Ok(())
    }

    /// Returns the current part of faces.
    fn current_part(&mut self, line: Line<'_>, reading: &Reading<'_, '_>) -> Result<usize, Fault> {
        if let Some(part) = self.part {
            return Ok(part);
        }
        let key = (self.name.clone(), self.material);
        let part = match self.known.get(&key) {
            Some(part) => *part,
            None => {
                let part = self.file.parts.len();
                if part as u64 >= reading.options.limits.objects {
                    let limit = reading.options.limits.objects;
                    return Err(
                        Reason::too_large("objects", part as u64 + 1, limit).of(line.place())
                    );
                }
                let triangles = Vec::new();
                let name = self.name.clone();
                self.file.parts.push(MeshPart { name, material: self.material, triangles });
                self.known.insert(key, part);
                part
            }
        };
        self.part = Some(part);
        Ok(part)
    }

    /// Reads a file of materials. A file that does not exist or is outside of the folder is noted.
    fn library(
        &mut self,
        name: &str,
        line: Line<'_>,
        reading: &mut Reading<'_, '_>,
    ) -> Result<(), Fault> {
        let limit = reading.options.limits.buffer_bytes;
        let found = match materials::read(name, line.folder, limit) {
            Ok(found) => found,
            Err(reason) => {
                let fault = reason.of(line.place());
                if fault.is_final() {
                    return Err(fault);
                }
                let (object, reason) = fault.into_parts();
                let reason = format!("{reason}; what needs its materials is grey");
                reading.notes.add(|| crate::Note::new(object, reason));
                return Ok(());
            }
        };
        for material in found {
            if self.file.materials.len() >= MOST_MATERIALS {
                return Err(
                    line.malformed(format!("there are more than {MOST_MATERIALS} materials"))
                );
            }
            self.add_material(material);
        }
        Ok(())
    }

    fn add_material(&mut self, material: PartMaterial) {
        self.material_names.insert(material.name.clone(), self.file.materials.len());
        self.file.materials.push(material);
    }
}
