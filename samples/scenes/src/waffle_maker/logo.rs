//! The logo: letters on a picture, printed on the lid.

use glam::{Affine2, Vec3, vec3};
use scene::{
    Encoding, Image, ImageId, Material, MaterialId, Mesh, MeshId, Sampler, Surfaces, Texture,
    TextureId, TextureUse, Vertex, bounds_of_vertices, pack_normal,
};

/// Half of the picture's sides, in metres.
const HALF_X_M: f32 = 0.060;
const HALF_Z_M: f32 = 0.030;

/// The size of the picture in texels.
const WIDTH: u32 = 256;
const HEIGHT: u32 = 128;

/// The letters, five columns by seven rows each: a bit per dot, the leftmost in the highest bit.
const LETTERS: [[u8; 7]; 6] = [
    [0b10001, 0b10001, 0b10001, 0b10101, 0b10101, 0b11011, 0b10001],
    [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
    [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000],
    [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000],
    [0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111],
    [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111],
];

/// The number of texels per dot of a letter, and per letter with the following gap.
const DOT: u32 = 6;
const ADVANCE: u32 = 36;

const PLATE: [u8; 4] = [0x7A, 0x2E, 0x16, 0xFF];
const LETTER: [u8; 4] = [0xFF, 0xE9, 0xB8, 0xFF];
const LINE: [u8; 4] = [0xD9, 0x8A, 0x34, 0xFF];

/// Returns a rectangle at height `y` that faces up.
pub(super) fn decal(y: f32) -> Mesh {
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let vertices = corners.map(|(x, z)| Vertex {
        position: vec3(x * HALF_X_M, y, z * HALF_Z_M).to_array(),
        normal: pack_normal(Vec3::Y),
        colour: u32::from_le_bytes([0xFF, 0xFF, 0xFF, 0]),
    });
    Mesh {
        name: "logo".to_owned(),
        bounds: bounds_of_vertices(&vertices),
        vertices: vertices.into(),
        indices: vec![0, 1, 2, 0, 2, 3],
        has_backs: false,
    }
}

/// Adds the picture to the mesh of the decal.
pub(super) fn print(surfaces: &mut Surfaces, mesh: MeshId) {
    surfaces.images.push(Image::of_rgba8("logo", [WIDTH, HEIGHT], texels()));
    let image = ImageId(surfaces.images.len() as u32 - 1);
    surfaces.textures.push(Texture {
        image,
        encoding: Encoding::Srgb,
        sampler: Sampler::default(),
    });
    let texture = TextureId(surfaces.textures.len() as u32 - 1);
    surfaces.materials.push(Material {
        name: "logo".to_owned(),
        base_colour_texture: Some(TextureUse { texture, uv_set: 0, transform: Affine2::IDENTITY }),
        metallic: 0.0,
        roughness: 0.5,
        ..Material::default()
    });
    let material = MaterialId(surfaces.materials.len() as u32 - 1);
    if let Some(surface) = surfaces.meshes.get_mut(mesh.0 as usize) {
        surface.material = material;
        let uvs = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        for (vertex, uv) in surface.vertices.iter_mut().zip(uvs) {
            vertex.uv = [uv, uv];
        }
    }
}

fn texels() -> Vec<u8> {
    let texel = |x: u32, y: u32| {
        let to_edge = x.min(WIDTH - 1 - x).min(y).min(HEIGHT - 1 - y);
        let is_frame = (6..10).contains(&to_edge);
        let is_grid = (88..112).contains(&y) && (24..232).contains(&x) && (x % 8 < 2 || y % 8 < 2);
        if is_letter(x, y) {
            LETTER
        } else if is_frame || is_grid {
            LINE
        } else {
            PLATE
        }
    };
    (0..HEIGHT).flat_map(|y| (0..WIDTH).flat_map(move |x| texel(x, y))).collect()
}

fn is_letter(x: u32, y: u32) -> bool {
    let left = (WIDTH - ADVANCE * LETTERS.len() as u32 + DOT) / 2;
    let Some(along) = x.checked_sub(left) else { return false };
    let Some(down) = y.checked_sub(30) else { return false };
    let row =
        LETTERS.get((along / ADVANCE) as usize).and_then(|rows| rows.get((down / DOT) as usize));
    let column = along % ADVANCE / DOT;
    column < 5 && row.is_some_and(|row| row >> (4 - column) & 1 == 1)
}
