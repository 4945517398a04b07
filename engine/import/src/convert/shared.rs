//! Rigid meshes, created once for all of their nodes, and once more for nodes that mirror.

use std::collections::HashMap;

use animation::RigNodeId;
use glam::Affine3A;
use gltf::json;
use gltf::json::validation::Checked;
use gltf::mesh::{Mode, Semantic};
use scene::{MeshId, Object};

use super::assembly::{Assembly, NO_TINT, rigid};
use super::geometry::Geometry;
use super::materials::{MaterialUse, Shading};
use super::primitives::{Facing, Primitive, Variant};
use super::sprites::{WantedSprites, is_crowd, sprites_of};
use super::{components, pieces};
use crate::ImportError;

/// The most parts of one transparent mesh, and the most objects that all such parts add: each is
/// sorted in each frame. Closed parts count twice.
const MOST_PARTS: usize = 256;
const MOST_PART_OBJECTS: usize = 16_384;

/// The identity of a primitive: its accessors with their semantics, and its material.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Key {
    attributes: Vec<(Semantic, usize)>,
    indices: Option<usize>,
    /// The number of the topology in the file.
    mode: u32,
    material: Option<usize>,
}

impl Key {
    fn of(primitive: &json::mesh::Primitive) -> Self {
        let named = primitive.attributes.iter();
        let attributes = named.filter_map(|(semantic, accessor)| match semantic {
            Checked::Valid(semantic) => Some((semantic.clone(), accessor.value())),
            Checked::Invalid => None,
        });
        let mode = match primitive.mode {
            Checked::Valid(mode) => mode,
            Checked::Invalid => Mode::Triangles,
        };
        Self {
            attributes: attributes.collect(),
            indices: primitive.indices.map(|indices| indices.value()),
            mode: mode.as_gl_enum(),
            material: primitive.material.map(|material| material.value()),
        }
    }
}

/// A primitive that several meshes of the file may share.
#[derive(Debug)]
pub(super) struct Kind {
    mesh: usize,
    number: usize,
    pub(super) material: MaterialUse,
    /// The number of places where it is shown.
    pub(super) uses: u64,
    /// The meshes created from it for each facing, once this was tried.
    made: [Option<Vec<MeshId>>; 3],
}

/// The primitives of each mesh of the file.
#[derive(Debug)]
pub(super) struct Plan {
    kinds: Vec<Kind>,
    of_meshes: Vec<Vec<usize>>,
}

impl Plan {
    /// Returns the number of primitives of a mesh of the scene.
    pub(super) fn primitives(&self, mesh: usize) -> usize {
        self.of_meshes.get(mesh).map_or(0, Vec::len)
    }

    /// Returns the expected number of opaque objects, to reserve memory.
    pub(super) fn objects(&self) -> usize {
        let opaque = self.kinds.iter().filter(|kind| !kind.material.is_transparent);
        opaque.map(|kind| kind.uses).fold(0, u64::saturating_add).min(1 << 20) as usize
    }

    /// Returns the kind of a primitive.
    pub(super) fn kind(&mut self, mesh: usize, number: usize) -> Option<&mut Kind> {
        let kind = *self.of_meshes.get(mesh)?.get(number)?;
        self.kinds.get_mut(kind)
    }
}

/// Finds identical primitives, the number of their places, and their materials.
pub(super) fn plan(assembly: &mut Assembly<'_>) -> Plan {
    let source = assembly.source;
    let json = source.document.as_json();
    let mut seen = vec![0_u64; json.meshes.len()];
    for (in_file, mesh) in assembly.tree.in_file.iter().zip(&assembly.tree.meshes) {
        if let Some(seen) = mesh.and_then(|mesh| seen.get_mut(mesh as usize)) {
            let instances = source.instancing.get(in_file).copied();
            *seen += instances.map_or(1, |instances| instances.count as u64);
        }
    }
    let mut kinds: Vec<Kind> = Vec::new();
    let mut of_meshes = Vec::with_capacity(json.meshes.len());
    let mut known: HashMap<Key, usize> = HashMap::new();
    for (mesh, (given, uses)) in json.meshes.iter().zip(seen).enumerate() {
        let mut of_mesh = Vec::new();
        // A primitive outside of the scene needs no material.
        let primitives = if uses > 0 { given.primitives.as_slice() } else { &[] };
        for (number, json) in primitives.iter().enumerate() {
            let kind = *known.entry(Key::of(json)).or_insert(kinds.len());
            if kind == kinds.len() {
                let primitive = Primitive { source, json, mesh, number };
                let material = material_of(assembly, &primitive);
                kinds.push(Kind { mesh, number, material, uses: 0, made: [None, None, None] });
            }
            if let Some(kind) = kinds.get_mut(kind) {
                kind.uses += uses;
            }
            of_mesh.push(kind);
        }
        of_meshes.push(of_mesh);
    }
    Plan { kinds, of_meshes }
}

fn material_of(assembly: &mut Assembly<'_>, primitive: &Primitive<'_>) -> MaterialUse {
    let shading = if primitive.is_unlit() { Shading::Unlit } else { Shading::Own };
    let material = primitive.json.material.map(|material| material.value());
    assembly.materials.use_of(primitive.source, material, shading, &mut assembly.notes)
}

/// Places a primitive at all places of a node.
pub(super) fn place_shared(
    assembly: &mut Assembly<'_>,
    kind: &mut Kind,
    primitive: &Primitive<'_>,
    node: RigNodeId,
    locals: &[Affine3A],
) -> Result<(), ImportError> {
    for local in locals {
        assembly.report()?;
        let transform = assembly.tree.world(node) * *local;
        if !assembly.can_be_seen(node, &transform) {
            continue;
        }
        let are_sprites = primitive.is_thin() && (kind.material.is_plain || is_crowd(primitive));
        // Sprites always face the camera.
        let variant = Variant::rigid(if are_sprites {
            Facing::Plain
        } else {
            Facing::of(&transform, assembly.may_turn(node))
        });
        if are_sprites {
            make_sprites(assembly, kind, primitive, &transform)?
        } else {
            make(assembly, kind, primitive, variant, &transform)?
        }
        let made = kind.made[variant.facing as usize].as_deref();
        for mesh in made.unwrap_or_default().iter().copied() {
            let object = Object { mesh, transform, tint: NO_TINT };
            if !assembly.scene.bounds_of(&object).is_some_and(|bounds| bounds.is_usable()) {
                assembly.leave_out_huge(node);
                continue;
            }
            let placed = assembly.add_object(node, object, &kind.material)?;
            if assembly.tree.moves(node) {
                assembly.placements.push(rigid(node, placed, *local));
            }
        }
    }
    Ok(())
}

/// Creates the sprites of a primitive on first use. Crowds get a plain material even if the file
/// specifies another one, which is noted.
fn make_sprites(
    assembly: &mut Assembly<'_>,
    kind: &mut Kind,
    primitive: &Primitive<'_>,
    to_world: &Affine3A,
) -> Result<(), ImportError> {
    let place = Facing::Plain as usize;
    if kind.made[place].is_some() {
        return Ok(());
    }
    let mut tint = [1.0; 4];
    if !kind.material.is_plain {
        let what =
            "it has too many points or lines to blend, cut out or texture: shown in plain colours";
        assembly.notes.count(what, 1, || primitive.place());
        tint = kind.material.base_colour;
        kind.material =
            assembly.materials.use_of(assembly.source, None, Shading::Unlit, &mut assembly.notes);
    }
    let wanted =
        WantedSprites { tint, is_seen_once: kind.uses == 1, sight: &assembly.sight, to_world };
    let budget = &mut assembly.budget;
    let notes = &mut assembly.notes;
    let sprites = sprites_of(primitive, &kind.material, &wanted, budget, notes);
    let sprites = assembly.unbroken(sprites.map(Some))?.unwrap_or_default();
    let name = assembly.name_of(kind.mesh, kind.number);
    let made = sprites.into_iter().enumerate().map(|(number, sprites)| {
        assembly.add_sprites(sprites, &kind.material, format!("{name}, chunk {number}"))
    });
    kind.made[place] = Some(made.collect());
    Ok(())
}

/// Creates the meshes of a primitive on first use.
fn make(
    assembly: &mut Assembly<'_>,
    kind: &mut Kind,
    primitive: &Primitive<'_>,
    variant: Variant,
    to_world: &Affine3A,
) -> Result<(), ImportError> {
    let place = variant.facing as usize;
    if kind.made[place].is_some() {
        return Ok(());
    }

    let geometry = primitive.build(
        variant,
        &kind.material,
        &assembly.sight,
        to_world,
        &mut assembly.budget,
        &mut assembly.notes,
    );
    let geometry = assembly.unbroken(geometry)?;
    let mut name = assembly.name_of(kind.mesh, kind.number);
    name.push_str(match variant.facing {
        Facing::Plain => "",
        Facing::Mirrored => " (mirrored)",
        Facing::Both => " (both sides)",
    });
    let mut made = Vec::new();
    if let Some(geometry) = geometry {
        let pieces = pieces(assembly, geometry, kind);
        let count = pieces.len();
        for (number, piece) in pieces.iter().enumerate() {
            let name = match count {
                1 => name.clone(),
                _ => format!("{name}, piece {number}"),
            };
            made.push(assembly.add_mesh(piece, &kind.material, name));
        }
    }
    kind.made[place] = Some(made);
    Ok(())
}

/// Returns geometry in pieces if it is transparent, or large and used once; else whole.
fn pieces(assembly: &mut Assembly<'_>, geometry: Geometry, kind: &Kind) -> Vec<Geometry> {
    let uses = usize::try_from(kind.uses).unwrap_or(usize::MAX).max(1);
    if kind.material.is_transparent {
        let left = MOST_PART_OBJECTS.saturating_sub(assembly.transparent_parts);
        let parts = components::apart(geometry, (left / uses).min(MOST_PARTS));
        let parts: Vec<Geometry> = parts.into_iter().flat_map(components::sides).collect();
        assembly.transparent_parts += parts.len().saturating_sub(1) * uses;
        return parts;
    }
    match assembly.cut_above {
        Some(most) if uses == 1 && geometry.triangles.len() > most => {
            pieces::cut(geometry, most / 8)
        }
        _ => vec![geometry],
    }
}
