//! Converts a file of triangles: each of its parts becomes an object of the scene.

use std::collections::HashMap;

use animation::Rig;
use glam::{Affine3A, Vec3};
use scene::{CREASE_RAD, Material, MaterialId, MeshId, Object, Surfaces, creased};

use super::assembly::NO_TINT;
use super::geometry::Geometry;
use super::numbers::direction;
use super::sidedness::{Backs, with_backs};
use super::{lights, pack, pieces, weld};
use crate::error::{Fault, Reason};
use crate::gltf_scene::GltfScene;
use crate::load_options::LoadOptions;
use crate::memory;
use crate::mesh_files::{GREY, MeshFile, MeshFormat, MeshPart, PartMaterial};
use crate::notes::Notes;
use crate::progress::{ProgressSender, Stage};
use crate::{Cause, ImportError};

/// The largest coordinate, in metres: beyond it, computations with boxes overflow.
const FARTHEST_M: f32 = 1e15;

/// The most memory per corner while its part is converted, in bytes.
const CORNER_BYTES: u64 = 224;

/// Returns the scene of a file.
pub(crate) fn convert_mesh_file(
    file: MeshFile,
    format: MeshFormat,
    name: String,
    options: &LoadOptions,
    mut notes: Notes,
    progress_sender: &mut ProgressSender<'_>,
) -> Result<GltfScene, ImportError> {
    let shown = progress_sender.file.clone();
    let unit_m = options.unit_m.unwrap_or(format.unit_m());
    if options.unit_m.is_none() && format == MeshFormat::Stl {
        notes.say("the file has no unit: its numbers are taken for millimetres");
    }
    let mut scene = super::empty(name);
    let mut surfaces = Surfaces { materials: materials(&file.materials), ..Surfaces::default() };
    surfaces.lights.push(lights::from_above());
    let mut positions: Vec<Vec3> =
        file.positions.iter().map(|position| *position * unit_m).collect();
    weld::weld(&mut positions);
    let MeshFile { normals, parts, materials, .. } = file;
    let count = parts.len();
    for (place, part) in parts.into_iter().enumerate() {
        progress_sender.report(Stage::Meshes, place as f32 / count as f32)?;
        let name = match (part.name.is_empty(), count) {
            (false, _) => part.name.clone(),
            (true, 1) => scene.name.clone(),
            (true, _) => format!("part {}", place + 1),
        };
        let material = part.material.filter(|material| *material < materials.len());
        let colour =
            material.and_then(|at| materials.get(at)).map_or(GREY, |material| material.colour);
        let material = MaterialId(material.unwrap_or(materials.len()) as u32);
        let made = geometry(&part, &positions, &normals, &mut notes, &name);
        let geometry = made.map_err(|fault| fault.in_file(&shown))?;
        let pieces = match options.cut_above_triangles {
            Some(most) if geometry.triangles.len() > most => pieces::cut(geometry, most / 8),
            _ => vec![geometry],
        };
        for piece in pieces.iter().filter(|piece| !piece.triangles.is_empty()) {
            let [red, green, blue] = colour;
            let packed = pack::pack(piece, name.clone(), material, [red, green, blue, 1.0]);
            let mesh = MeshId(scene.meshes.len() as u32);
            scene.meshes.push(packed.0);
            surfaces.meshes.push(packed.1);
            let transform = Affine3A::IDENTITY;
            scene.objects.push(Object { mesh, transform, tint: NO_TINT });
        }
    }
    if scene.objects.is_empty() {
        let reason = Reason::not_scene("all of its triangles are without area");
        return Err(reason.of("the mesh").in_file(&shown));
    }
    scene.surfaces = Some(surfaces);
    let rig = Rig::new(Vec::new()).map_err(|error| ImportError {
        file: shown,
        object: "nodes".to_owned(),
        reason: error.to_string(),
        cause: Cause::Malformed,
    })?;
    Ok(GltfScene {
        scene,
        origin_m: glam::DVec3::ZERO,
        rig,
        object_nodes: Vec::new(),
        clips: Vec::new(),
        skins: Vec::new(),
        placements: Vec::new(),
        cameras: Vec::new(),
        notes: notes.finish(),
    })
}

/// Returns the materials, followed by the material of parts without one.
fn materials(given: &[PartMaterial]) -> Vec<Material> {
    let material = |name: &str, [red, green, blue]: [f32; 3]| Material {
        name: name.to_owned(),
        base_colour: [red, green, blue, 1.0],
        metallic: 0.0,
        roughness: 0.7,
        ..Material::default()
    };
    let named = given.iter().map(|given| material(&given.name, given.colour));
    named.chain([material("none", GREY)]).collect()
}

/// Returns the triangles of a part that have an area. They have the file's normals if each corner
/// has one, else smooth normals with creases. A part that encloses nothing is seen from both sides.
fn geometry(
    part: &MeshPart,
    positions: &[Vec3],
    normals: &[Vec3],
    notes: &mut Notes,
    name: &str,
) -> Result<Geometry, Fault> {
    memory::ask(part.triangles.len() as u64 * 3 * CORNER_BYTES)
        .map_err(|reason| reason.of(name))?;
    let mut own = Geometry::default();
    let mut known = HashMap::new();
    let mut flat = 0;
    let normal_of = |corner: &super::super::mesh_files::Corner| {
        corner.normal.and_then(|at| normals.get(at as usize)).and_then(|normal| direction(*normal))
    };
    let has_normals =
        part.triangles.as_flattened().iter().all(|corner| normal_of(corner).is_some());
    for corners in &part.triangles {
        let at = corners.map(|corner| positions.get(corner.position as usize).copied());
        let [Some(a), Some(b), Some(c)] = at else { continue };
        if [a, b, c].iter().any(|at| at.abs().max_element() > FARTHEST_M) {
            return Err(Reason::beyond_limits("it reaches beyond all numbers").of(name));
        }
        if a == b || b == c || c == a {
            flat += 1;
            continue;
        }
        own.triangles.push(corners.map(|corner| {
            let key = (corner.position, corner.normal.filter(|_| has_normals));
            *known.entry(key).or_insert_with(|| {
                let position = positions.get(corner.position as usize).copied();
                own.positions.push(position.unwrap_or_default());
                if has_normals {
                    own.normals.push(normal_of(&corner).unwrap_or(Vec3::Y));
                }
                own.positions.len() as u32 - 1
            })
        }));
    }
    notes.count("a triangle has two corners in one place, and is left out", flat, || {
        name.to_owned()
    });
    let is_closed = is_closed(&own);
    if !has_normals {
        let made = creased(&own.positions, &own.triangles, CREASE_RAD);
        let mut smooth = own.gather(&made.origins);
        smooth.normals =
            made.normals.iter().map(|normal| normal.try_normalize().unwrap_or(Vec3::Y)).collect();
        smooth.triangles = made.triangles;
        own = smooth;
    }
    if !is_closed {
        notes
            .count("it is not a closed solid, and is shown from both sides", 1, || name.to_owned());
        with_backs(&mut own, Backs::Last);
    }
    Ok(own)
}

/// Returns true if triangles run along each edge equally often in both directions, by position.
fn is_closed(geometry: &Geometry) -> bool {
    let bits = |vertex: u32| {
        let position = geometry.positions.get(vertex as usize).copied().unwrap_or_default();
        position.to_array().map(f32::to_bits)
    };
    let mut edges: HashMap<_, i32> = HashMap::new();
    for [a, b, c] in geometry.triangles.iter().map(|triangle| triangle.map(bits)) {
        for (begin, end) in [(a, b), (b, c), (c, a)] {
            let is_back = begin > end;
            let edge = if is_back { (end, begin) } else { (begin, end) };
            *edges.entry(edge).or_default() += if is_back { -1 } else { 1 };
        }
    }
    edges.values().all(|balance| *balance == 0)
}
