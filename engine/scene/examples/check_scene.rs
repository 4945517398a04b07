//! Builds a scene of two meshes and three objects, validates it, adds a broken object, and builds
//! an update.

use std::error::Error;

use antumbra_scene::{
    Light, Mesh, MeshId, Object, ObjectChange, Scene, SceneUpdate, limits, pack_unorm,
};
use cull::ObjectId;
use glam::{Affine3A, Vec3, vec3};

/// Returns a triangle of 1 m.
fn triangle(name: &str, colour: [f32; 3]) -> Mesh {
    let corners = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.0, 0.0]];
    Mesh::of_triangles(name, &corners.map(|corner| (corner, colour)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let object = |mesh: u32, at: Vec3| Object {
        mesh: MeshId(mesh),
        transform: Affine3A::from_translation(at),
        tint: pack_unorm([1.0; 4]),
    };
    let mut scene = Scene {
        name: "three sails".to_owned(),
        meshes: vec![triangle("red", [0.8, 0.1, 0.1]), triangle("white", [0.9; 3])],
        objects: vec![object(0, Vec3::ZERO), object(1, Vec3::X), object(1, vec3(2.0, 0.0, -3.0))],
        light: Light::afternoon(),
        surfaces: None,
    };
    scene.validate()?;
    let objects = scene.objects.len();
    let most = limits::OBJECTS_ANYWHERE;
    println!("{}: {} triangles, {objects} of {most} objects", scene.name, scene.triangles());
    for object in &scene.objects {
        println!("  {} in {:?}", object.mesh.0, scene.bounds_of(object).ok_or("no such mesh")?);
    }

    // A scene that no renderer could draw is refused before any upload.
    scene.objects.push(object(7, Vec3::ZERO));
    if let Err(error) = scene.validate() {
        println!("refused: {error}");
    }

    // A renderer applies an update between two frames; clips of imported files produce such
    // updates.
    let moved = Affine3A::from_translation(Vec3::Y);
    let mut update = SceneUpdate::default();
    update.objects.push(ObjectChange::Move { object: ObjectId(0), transform: moved });
    update.objects.push(ObjectChange::Remove { object: ObjectId(2) });
    update.objects.push(ObjectChange::Add { object: object(0, Vec3::NEG_X) });
    println!("next frame: {} changes, nothing else moves", update.objects.len());
    Ok(())
}
