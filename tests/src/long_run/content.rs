//! The first scene of a long run, and what comes later.

use cull::{Camera, ObjectId};
use glam::{Affine3A, Quat, Vec3, vec3};
use render::{CostModel, Renderer, RendererOptions, SpareCapacity, TextureCapacity};
use scene::{
    Alpha, Encoding, Image, LightKind, Material, MaterialId, MeshId, MorphTarget, Object,
    PreparedMesh, PreparedTexture, PunctualLight, Sampler, Scene, SkinnedMesh, SurfaceMesh,
    TextureId, TextureUse, pack_unorm,
};
use shadows::{ShadowMethod, ShadowOptions};

use crate::shadow_scene;
use crate::shapes::{cube, surface_of};
use crate::window_fixture::Random;

/// The number of transparent objects.
pub(super) const PANES: u32 = 3;
/// The most objects that are added.
pub(super) const SPARE_OBJECTS: usize = 16;
/// The most meshes, materials and textures that come.
pub(super) const SPARE_MESHES: usize = 5;
/// The most lights that are added.
pub(super) const SPARE_LIGHTS: usize = 4;
/// The first shadows.
pub(super) const SHADOWS: ShadowOptions = ShadowOptions {
    method: ShadowMethod::Maps,
    filter: shadows::ShadowFilter::Pcf3,
    bias: shadows::ShadowBias::Plane,
    caching: shadows::ShadowCaching::Cached,
    culling: shadows::CasterCulling::Culled,
    penumbra_m: 0.15,
    cascades: 2,
    cascade_blend: 0.1,
    distance_m: Some(60.0),
    sun_side: 64,
    spot_side: 64,
    point_side: 32,
    // Room for the maps of all lights in any order: smaller ones would depend on the past.
    layers_max: 16,
};

const BOXES: usize = 28;
const SIDE: u32 = 8;

/// Returns a yard of boxes under a sun and a spot, with panes and a mesh that morphs.
pub(super) fn first_scene() -> Scene {
    let boxes = shadow_scene::boxes();
    let mut scene = shadow_scene::scene(&boxes[..BOXES], &shadow_scene::lights()[..2]);
    let surfaces = scene.surfaces.as_mut().expect("surfaces");
    for (number, colour) in [[0.3, 0.8, 0.7, 0.4], [0.9, 0.4, 0.2, 1.0]].into_iter().enumerate() {
        let mesh = cube(pack_unorm([1.0; 4]), 2);
        let material = MaterialId(surfaces.materials.len() as u32);
        surfaces.meshes.push(surface_of(&mesh, material));
        scene.meshes.push(mesh);
        let alpha = if number == 0 { Alpha::Blend } else { Alpha::Opaque };
        surfaces.materials.push(Material {
            base_colour: colour,
            alpha,
            metallic: 0.0,
            ..Material::default()
        });
    }
    let glass = MeshId(1);
    let soft = MeshId(2);
    let vertices = scene.meshes[soft.0 as usize].vertices.iter();
    let positions = vertices.map(|vertex| [0.0, vertex.position[0], 0.0]).collect();
    let targets = vec![MorphTarget { positions, ..MorphTarget::default() }];
    surfaces.skinned_meshes = vec![SkinnedMesh { mesh: soft, skin: None, targets }];
    let pane = |number: u32| {
        let low = vec3(number as f32 * 2.5 - 4.0, 0.2, 3.0 - number as f32);
        object(glass, low, vec3(2.0, 2.0, 0.1))
    };
    surfaces.transparent = (0..PANES).map(pane).collect();
    scene.objects.push(object(soft, vec3(-2.0, 0.0, 4.0), vec3(1.5, 1.0, 1.5)));
    scene
}

fn object(mesh: MeshId, low: Vec3, size: Vec3) -> Object {
    let transform = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, low);
    Object { mesh, transform, tint: u32::MAX }
}

/// Returns the options of a renderer with room for what comes.
pub(super) fn options(size: [u32; 2]) -> RendererOptions {
    let spare = SpareCapacity {
        lights: SPARE_LIGHTS as u32,
        meshes: SPARE_MESHES as u32,
        vertices: 2048,
        indices: 4096,
        materials: SPARE_MESHES as u32,
        textures: vec![TextureCapacity {
            size: [SIDE; 2],
            encoding: Encoding::Srgb,
            sampler: Sampler::default(),
            layers: SPARE_MESHES as u32,
        }],
        ..SpareCapacity::default()
    };
    RendererOptions {
        size,
        methods: methods::all(),
        spare,
        spare_objects: SPARE_OBJECTS,
        shadows: SHADOWS,
        cost_model: CostModel::Off,
        // What comes takes some frames.
        upload_bytes_per_frame: 500,
        ..RendererOptions::default()
    }
}

pub(super) fn first_camera() -> Camera {
    shadow_scene::camera()
}

/// Returns a camera somewhere in the yard.
pub(super) fn some_camera(random: &mut Random) -> Camera {
    let eye = vec3(random.between(-9.0, 9.0), random.between(0.5, 6.0), random.between(-3.0, 12.0));
    let to = vec3(random.between(-4.0, 4.0), 0.5, random.between(-7.0, 0.0));
    Camera { eye, forward: (to - eye).normalize_or(Vec3::NEG_Z), ..first_camera() }
}

/// Returns a place for an object, often on the ground.
pub(super) fn some_transform(random: &mut Random) -> Affine3A {
    let size = vec3(random.between(0.3, 3.0), random.between(0.3, 3.0), random.between(0.3, 3.0));
    let height = if random.below(3) == 0 { random.between(0.0, 3.0) } else { 0.0 };
    let low = vec3(random.between(-8.0, 6.0), height, random.between(-8.0, 6.0));
    let turn = Quat::from_rotation_y(random.between(0.0, 3.0));
    Affine3A::from_scale_rotation_translation(size, turn, low)
}

/// Returns a spot or point light over the yard.
pub(super) fn some_light(random: &mut Random, kind: Option<LightKind>) -> PunctualLight {
    let some_kind = match random.below(2) {
        0 => LightKind::Point,
        _ => LightKind::Spot { inner_rad: 0.3, outer_rad: 0.7 },
    };
    PunctualLight {
        kind: kind.unwrap_or(some_kind),
        colour: [1.0, random.part(), 0.6],
        intensity: random.between(5.0, 40.0),
        range_m: Some(random.between(4.0, 16.0)),
        position: vec3(
            random.between(-6.0, 6.0),
            random.between(1.0, 5.0),
            random.between(-6.0, 5.0),
        ),
        direction: vec3(random.between(-0.5, 0.5), -1.0, random.between(-0.5, 0.5)).normalize(),
        cookie: None,
    }
}

/// A mesh with a material and a texture that came, and its object.
pub(super) struct Came {
    pub(super) object: Option<ObjectId>,
    pub(super) mesh: MeshId,
    pub(super) material: MaterialId,
    pub(super) texture: TextureId,
}

impl Came {
    /// Adds a texture, a material and a mesh.
    pub(super) fn add(renderer: &mut Renderer, random: &mut Random) -> Self {
        let texels = (0..SIDE * SIDE * 4).map(|byte| match byte % 4 {
            3 => u8::MAX,
            _ => random.below(256) as u8,
        });
        let image = Image::of_rgba8("came", [SIDE; 2], texels.collect());
        let texture = PreparedTexture::new(image, Encoding::Srgb, Sampler::default());
        let texture = texture.expect("a texture");
        let texture = renderer.add_textures(vec![texture]).expect("room for a texture")[0];
        let material = renderer.add_materials(&[some_material(random, texture)]);
        let material = material.expect("room for a material")[0];
        let mesh = cube(pack_unorm([1.0; 4]), 1 + random.below(3));
        let surface = SurfaceMesh { material, ..surface_of(&mesh, material) };
        let mesh = PreparedMesh::with_surface(mesh, surface, Vec::new()).expect("a mesh");
        let mesh = renderer.add_meshes(vec![mesh]).expect("room for a mesh")[0];
        Self { object: None, mesh, material, texture }
    }

    /// Removes all but the object, which is gone.
    pub(super) fn remove(self, renderer: &mut Renderer) {
        renderer.remove_meshes(&[self.mesh]).expect("no object has it");
        renderer.remove_materials(&[self.material]).expect("no mesh has it");
        renderer.remove_textures(&[self.texture]).expect("no material has it");
    }
}

pub(super) fn some_material(random: &mut Random, texture: TextureId) -> Material {
    let base_colour_texture =
        Some(TextureUse { texture, uv_set: 0, transform: glam::Affine2::IDENTITY });
    Material {
        base_colour: [random.part(), random.part(), random.part(), 1.0],
        base_colour_texture: base_colour_texture.filter(|_| random.below(3) > 0),
        metallic: 0.0,
        roughness: random.part(),
        is_unlit: random.below(4) == 0,
        ..Material::default()
    }
}
