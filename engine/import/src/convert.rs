//! Converts a checked file to a scene and its animation. Each module does one step; this one calls
//! them in order.

mod assembly;
mod budget;
mod cameras;
mod clips;
mod components;
mod distances;
mod exposure;
pub(crate) mod framing;
mod geometry;
mod initial_view;
mod instancing;
mod lights;
mod materials;
mod mesh_file;
mod near_origin;
mod nodes;
mod normals;
mod numbers;
mod pack;
mod pieces;
mod primitives;
mod renderable;
mod shared;
mod sidedness;
mod skinned;
mod skinned_extents;
mod skins;
mod solids;
mod sprites;
mod tangents;
mod textures;
mod topology;
mod vertices;
mod weld;

use animation::RigNodeId;
use glam::Affine3A;
use scene::{LightId, Scene};

use self::assembly::{Assembly, rigid};
use self::cameras::Place;
use self::initial_view::{FirstCamera, InitialView};
use self::lights::PlacedLight;
use self::nodes::Tree;
use crate::gltf_scene::{GltfScene, PlacedNode, SceneCamera};
use crate::load_options::LoadOptions;
use crate::losses::Losses;
use crate::notes::Notes;
use crate::progress::{ProgressSender, Stage};
use crate::{ImportError, Source};

pub(crate) use self::mesh_file::convert_mesh_file;
pub(crate) use self::skins::used_joints;

/// Returns the scene of a file.
pub(crate) fn convert(
    mut source: Source,
    name: String,
    options: &LoadOptions,
    progress_sender: &mut ProgressSender<'_>,
) -> Result<GltfScene, ImportError> {
    let mut notes = Notes::after(std::mem::take(&mut source.notes));
    let mut losses = std::mem::take(&mut source.losses);
    let tree = Tree::of(&mut source, options.place, &mut notes)?;
    let mut clips = clips::clips(&source, &tree, &mut losses, &mut notes)?;
    let cameras = cameras::cameras(&source, &tree, &mut notes);
    let first = cameras.first();
    let first =
        first.map(|camera| FirstCamera { node: camera.node, projection: camera.projection });
    let sight = InitialView::of(&source, &tree, first);
    let lights = lights::lights(&source, &tree, &mut notes);
    renderable::check_lights(&source, &tree, &lights, &options.limits)?;
    let skinned_extents = skinned_extents::SkinnedExtents::new(&tree.rig, &clips, &options.limits);
    let mut share_fn = |done| progress_sender.report(Stage::Meshes, done);
    let scene = empty(name);
    let begun =
        Assembly::new(&source, &tree, options, skinned_extents, sight, scene, &mut share_fn);
    let mut assembly = Assembly { notes, losses, ..begun };
    place_lights(&mut assembly, lights);
    place_nodes(&mut assembly)?;
    let Assembly {
        mut notes,
        mut losses,
        mut scene,
        mut surfaces,
        materials,
        skins,
        placements,
        object_nodes,
        skinned_extents,
        ..
    } = assembly;
    (surfaces.materials, surfaces.textures, surfaces.images) = materials.finish(&mut source);
    renderable::check_textures(&source, &surfaces)?;
    let contents = distances::MovedContents {
        placements: &placements,
        scene: &scene,
        surfaces: &surfaces,
        skins: &skins.list,
        cameras: &cameras,
    };
    let extents = skinned_extents.into_extents();
    distances::refuse_far(&tree, &extents, &mut clips, &contents, &mut notes);
    let is_empty = scene.objects.is_empty() && surfaces.transparent.is_empty();
    if is_empty {
        note_empty(&mut losses, &source.file, &mut notes)?;
    }
    exposure::set(options.exposure, &scene, &mut surfaces, &mut notes);
    scene.surfaces = Some(surfaces);
    let places = places(&cameras, &tree, is_empty);
    let skins = skins.list;
    let mut imported = GltfScene {
        scene,
        origin_m: tree.origin_m,
        rig: tree.rig,
        object_nodes,
        clips,
        skins,
        placements,
        cameras,
        notes: Vec::new(),
    };
    cameras::check(&imported.cameras, &places, &imported.bounds(), &mut notes);
    imported.notes = notes.finish();
    Ok(imported)
}

/// Notes that nothing is visible.
///
/// # Errors
/// The first fault because of which something was left out, if there is one.
fn note_empty(losses: &mut Losses, file: &str, notes: &mut Notes) -> Result<(), ImportError> {
    if let Some(fault) = losses.take_first() {
        return Err(fault.in_file(file));
    }
    notes.say("there is nothing to see in the scene");
    Ok(())
}

/// Returns the places of cameras. They should see something unless the scene is empty.
fn places(cameras: &[SceneCamera], tree: &Tree, is_empty: bool) -> Vec<Place> {
    let place =
        |node| Place { world: tree.world(node), should_see: !is_empty && !tree.moves(node) };
    cameras.iter().map(|camera| place(camera.node)).collect()
}

/// Adds the lights, and attaches moving ones to their nodes.
fn place_lights(assembly: &mut Assembly<'_>, lights: Vec<PlacedLight>) {
    for PlacedLight { light, node } in lights {
        let id = LightId(assembly.surfaces.lights.len() as u32);
        assembly.surfaces.lights.push(light);
        if let Some(node) = node.filter(|node| assembly.tree.moves(*node)) {
            assembly.placements.push(rigid(node, PlacedNode::Light(id), Affine3A::IDENTITY));
        }
    }
}

/// Adds the objects of all nodes.
fn place_nodes(assembly: &mut Assembly<'_>) -> Result<(), ImportError> {
    let mut plan = shared::plan(assembly);
    assembly.scene.objects.reserve_exact(plan.objects());
    let count = assembly.tree.in_file.len();
    for (place, node) in (0..count).zip((0..).map(RigNodeId)) {
        assembly.done = place as f32 / count as f32;
        assembly.report()?;
        assembly.place(&mut plan, node)?;
    }
    Ok(())
}

/// Returns a scene without contents.
fn empty(name: String) -> Scene {
    Scene {
        name,
        meshes: Vec::new(),
        objects: Vec::new(),
        light: lights::surroundings(),
        surfaces: None,
    }
}
