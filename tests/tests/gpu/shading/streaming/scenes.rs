//! The scenes to which meshes and materials are added, and the added meshes and materials.

use cull::DetailPolicy;
use glam::{Affine2, Affine3A, Vec2, Vec3, vec2, vec3};
use render::surfaces::TextureStorage;
use render::{CostModel, RendererOptions, SpareCapacity, TextureCapacity};
use scene::{
    Alpha, Encoding, Image, ImageId, LodLevel, Material, MaterialId, Mesh, MeshId, Object,
    PreparedMesh, PreparedTexture, Sampler, Scene, SurfaceMesh, SurfaceVertex, Surfaces, Texture,
    TextureId, TextureUse,
};
use tests::surface_fixture::snorm16;
use tests::window_fixture::Random;

pub(super) const SIZE: [u32; 2] = [96, 64];
pub(super) const SPARE: SpareCapacity = SpareCapacity {
    lights: 0,
    directional_lights: 0,
    meshes: 9,
    vertices: 400,
    indices: 700,
    levels: 12,
    materials: 5,
    textures: Vec::new(),
};
/// The textures that the renderer begins with.
pub(super) const FIRST_TEXTURES: u32 = 2;
/// The materials that the renderer begins with.
pub(super) const FIRST_MATERIALS: u32 = 3;
pub(super) const FINEST: DetailPolicy = by_distance(0.0);
pub(super) const COARSE: DetailPolicy = by_distance(2.0);

const fn by_distance(error_pixels: f32) -> DetailPolicy {
    DetailPolicy { error_pixels, hysteresis: 0.0, by_samples: None }
}

/// The kinds of scenes: colours only in vertices, or surfaces whose textures lie on pages or have
/// an image each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Plain,
    Surfaces,
    Images,
}

/// Returns a mesh of some triangles in a box of two metres, with a coarser level if it has
/// surfaces.
pub(super) fn some_mesh(random: &mut Random, kind: Kind, material: MaterialId) -> PreparedMesh {
    let corner = |random: &mut Random| [0; 3].map(|_| random.below(2_001) as f32 / 1_000.0 - 1.0);
    let triangles = 1 + random.below(30) as usize;
    let colour = [0; 3].map(|_| random.below(256) as f32 / 255.0);
    let corners: Vec<_> = (0..triangles * 3).map(|_| (corner(random), colour)).collect();
    let mesh = Mesh::of_triangles("some", &corners);
    match kind {
        Kind::Plain => PreparedMesh::new(mesh).unwrap(),
        Kind::Surfaces | Kind::Images => {
            let levels = match random.below(3) {
                0 => Vec::new(),
                _ => vec![LodLevel {
                    indices: mesh.indices[..triangles / 2 * 3].to_vec(),
                    error_m: 0.3,
                }],
            };
            let surface = surface_of(&mesh, material);
            PreparedMesh::with_surface(mesh, surface, levels).unwrap()
        }
    }
}

/// Returns room for textures of three kinds: large ones take several frames each.
pub(super) fn rooms() -> Vec<TextureCapacity> {
    let room = |(size, encoding, layers)| TextureCapacity {
        size,
        encoding,
        sampler: Sampler::default(),
        layers,
    };
    let small = ([4, 4], Encoding::Srgb, 2);
    let large = [Encoding::Srgb, Encoding::Linear].map(|encoding| ([32, 16], encoding, 1));
    std::iter::once(small).chain(large).map(room).collect()
}

/// Returns a texture of any of the kinds that have room.
pub(super) fn some_texture(random: &mut Random) -> PreparedTexture {
    let rooms = rooms();
    let TextureCapacity { size, encoding, sampler, .. } =
        rooms[random.below(rooms.len() as u32) as usize];
    let bytes = size[0] * size[1] * 4;
    let alpha = |at: u32, byte: u8| if at % 4 == 3 { byte | 0x80 } else { byte };
    let rgba8 = (0..bytes).map(|at| alpha(at, random.below(256) as u8)).collect();
    let image = Image::of_rgba8("came later", size, rgba8);
    PreparedTexture::new(image, encoding, sampler).unwrap()
}

/// Returns a material without blending, of any kind, with colours and numbers in textures.
pub(super) fn some_material(random: &mut Random, textures: [TextureId; 2]) -> Material {
    let part = |random: &mut Random| random.below(256) as f32 / 255.0;
    let colours = [(); 3].map(|()| random.below(3));
    let texture_use = |random: &mut Random, texture| {
        let scale = Vec2::splat(1.0 + random.below(4) as f32 / 3.0);
        let transform = Affine2::from_scale_angle_translation(scale, 0.5, vec2(0.1, 0.2));
        let transform = if random.below(2) == 0 { Affine2::IDENTITY } else { transform };
        TextureUse { texture, uv_set: 0, transform }
    };
    Material {
        base_colour: [part(random), part(random), part(random), 1.0],
        base_colour_texture: (colours[0] == 0).then(|| texture_use(random, textures[0])),
        metallic: part(random),
        roughness: part(random),
        metallic_roughness_texture: (colours[1] == 0).then(|| texture_use(random, textures[1])),
        emission: if colours[2] == 0 { [0.0; 3] } else { [0.2, 0.1, part(random)] },
        alpha: match random.below(3) {
            0 => Alpha::Mask { cutoff: 0.5 },
            _ => Alpha::Opaque,
        },
        is_unlit: random.below(4) == 0,
        ..Material::default()
    }
}

/// Returns an image of four by four texels, some of them with an alpha of 0.
pub(super) fn image(name: &str, step: usize) -> Image {
    let texel =
        |at: usize| [(at * step % 256) as u8, 90, 200, if at.is_multiple_of(5) { 0 } else { 255 }];
    let rgba8: Vec<u8> = (0..16).flat_map(texel).collect();
    Image::of_rgba8(name, [4, 4], rgba8)
}

pub(super) fn surface_of(mesh: &Mesh, material: MaterialId) -> SurfaceMesh {
    let vertex = |vertex: &scene::Vertex| SurfaceVertex {
        normal: snorm16(scene::unpack_normal(vertex.normal).normalize_or_zero(), 0),
        tangent: snorm16(Vec3::X, 1),
        uv: [[vertex.position[0], vertex.position[1]]; 2],
        colour: [u16::MAX; 4],
    };
    let vertices = mesh.vertices.iter().map(vertex).collect();
    SurfaceMesh { vertices, material }
}

/// Returns a wall with a mesh beside it, as the renderer begins.
pub(super) fn first_scene(kind: Kind) -> Scene {
    let a = [-2.0, -2.0, 0.0];
    let b = [2.0, -2.0, 0.0];
    let c = [2.0, 2.0, 0.0];
    let d = [-2.0, 2.0, 0.0];
    let wall = Mesh::of_triangles("wall", &[a, b, c, a, c, d].map(|corner| (corner, [0.5; 3])));
    let beside = Mesh::of_triangles("beside", &[a, b, c].map(|corner| (corner, [0.9, 0.2, 0.1])));
    let meshes = vec![wall, beside];
    let glass = Material { alpha: Alpha::Blend, ..Material::default() };
    let red =
        Material { base_colour: [0.8, 0.1, 0.1, 1.0], emission: [0.2; 3], ..Material::default() };
    let texture =
        |image, encoding| Texture { image: ImageId(image), encoding, sampler: Sampler::default() };
    let texture_use = |texture| {
        let texture = TextureId(texture);
        Some(TextureUse { texture, uv_set: 0, transform: Affine2::IDENTITY })
    };
    let glass = Material {
        base_colour_texture: texture_use(0),
        metallic_roughness_texture: texture_use(1),
        ..glass
    };
    let surfaces = Surfaces {
        meshes: meshes.iter().map(|mesh| surface_of(mesh, MaterialId(0))).collect(),
        images: vec![image("colours", 37), image("numbers", 11)],
        textures: vec![texture(0, Encoding::Srgb), texture(1, Encoding::Linear)],
        materials: vec![Material { emission: [0.1, 0.2, 0.3], ..Material::default() }, red, glass],
        ..Surfaces::default()
    };
    let mut scene = Scene::single(meshes[0].clone());
    scene.objects = vec![object(0, Vec3::ZERO), object(1, vec3(2.5, 0.0, -1.0))];
    scene.meshes = meshes;
    scene.surfaces = (kind != Kind::Plain).then_some(surfaces);
    scene
}

pub(super) fn object(mesh: u32, at: Vec3) -> Object {
    Object { mesh: MeshId(mesh), transform: Affine3A::from_translation(at), tint: u32::MAX }
}

/// Returns options with textures on pages.
pub(super) fn options(spare: SpareCapacity) -> RendererOptions {
    RendererOptions {
        textures: Some(TextureStorage::ArrayPacked),
        size: SIZE,
        cost_model: CostModel::Off,
        spare_objects: 40,
        spare,
        // Several frames for most meshes.
        upload_bytes_per_frame: 900,
        ..Default::default()
    }
}

/// Returns options for a scene of a kind.
pub(super) fn options_of(kind: Kind, spare: SpareCapacity) -> RendererOptions {
    let textures = match kind {
        Kind::Plain | Kind::Surfaces => TextureStorage::ArrayPacked,
        Kind::Images => TextureStorage::Bindless,
    };
    RendererOptions { textures: Some(textures), ..options(spare) }
}

/// Returns the spare room of a scene of a kind.
pub(super) fn spare(kind: Kind) -> SpareCapacity {
    let textures = if kind == Kind::Surfaces { rooms() } else { Vec::new() };
    SpareCapacity { textures, ..SPARE }
}

pub(super) fn uses(material: &Material) -> Vec<TextureId> {
    let both = [&material.base_colour_texture, &material.metallic_roughness_texture];
    both.into_iter().flatten().map(|texture_use| texture_use.texture).collect()
}
