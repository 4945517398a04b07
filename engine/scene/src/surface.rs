//! Surfaces: the appearance of meshes, as plain data. Materials are glTF 2.0's metallic-roughness
//! model with its extensions `KHR_materials_unlit`, `KHR_materials_emissive_strength`,
//! `KHR_texture_transform` and `KHR_lights_punctual`.

use std::collections::HashMap;

use glam::Affine2;

use super::{Image, MeshId, Object, PunctualLight, Sprites};

/// The id of a material: an index into [`Surfaces::materials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub u32);

/// The id of a texture: an index into [`Surfaces::textures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TextureId(pub u32);

/// The id of an image: an index into [`Surfaces::images`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ImageId(pub u32);

/// The id of a transparent object: an index into [`Surfaces::transparent`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TransparentId(pub u32);

/// The id of a light: an index into [`Surfaces::lights`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u32);

/// The id of a skinned mesh: an index into [`Surfaces::skinned_meshes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SkinnedMeshId(pub u32);

/// The second half of a vertex, 40 bytes: the attributes that only shading reads.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SurfaceVertex {
    /// Unit normal as snorm16; the last is 32767 if the mesh has both sides of each triangle, and 0
    /// otherwise. With both sides, the normal may be mirrored in some frames.
    pub normal: [i16; 4],
    /// Unit tangent as snorm16; the last is the bitangent's sign, -32767 or 32767.
    pub tangent: [i16; 4],
    /// Two sets of texture coordinates.
    pub uv: [[f32; 2]; 2],
    /// **Linear** red, green, blue, alpha as unorm16: a factor of the base colour. The share in
    /// [`Vertex::colour`](super::Vertex::colour) mixes in the object's tint.
    pub colour: [u16; 4],
}

const _: () = assert!(size_of::<SurfaceVertex>() == 40);

/// The surface of a mesh of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceMesh {
    /// The second halves of the mesh's vertices.
    pub vertices: Vec<SurfaceVertex>,
    /// The material of all its triangles.
    pub material: MaterialId,
}

/// The way in which a surface covers the background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// Full cover, regardless of its alpha.
    Opaque,
    /// Full cover where its alpha is at least the cutoff, none elsewhere.
    Mask {
        /// The least alpha that counts as full cover.
        cutoff: f32,
    },
    /// Cover in proportion to its alpha.
    Blend,
}

/// A texture, and the coordinates of a surface in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// The sampled texture, one of the scene's.
    pub texture: TextureId,
    /// The set of texture coordinates: 0 or 1.
    pub uv_set: u8,
    /// The transform of texture coordinates to coordinates in the texture.
    pub transform: Affine2,
}

/// The material of a surface. All colours are linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name, for people.
    pub name: String,
    /// Factor of the base colour and alpha.
    pub base_colour: [f32; 4],
    /// Base colour and alpha; sRGB.
    pub base_colour_texture: Option<TextureUse>,
    /// Factor of metallic, 0 to 1.
    pub metallic: f32,
    /// Factor of roughness, 0 to 1.
    pub roughness: f32,
    /// Roughness in green, metallic in blue; linear.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// Normals in tangent space; linear.
    pub normal_texture: Option<TextureUse>,
    /// Factor of the normals' x and y.
    pub normal_scale: f32,
    /// Occlusion of ambient light in red; linear.
    pub occlusion_texture: Option<TextureUse>,
    /// Strength of the occlusion, 0 to 1.
    pub occlusion_strength: f32,
    /// Emitted light, with its strength.
    pub emission: [f32; 3],
    /// Factor of the emitted light; sRGB.
    pub emission_texture: Option<TextureUse>,
    /// The way in which it covers the background.
    pub alpha: Alpha,
    /// True if its back is drawn, too. Meshes with such materials have their backs as triangles of
    /// their own, so that one pipeline draws both sides.
    pub is_double_sided: bool,
    /// True if its colour is the base colour in any light.
    pub is_unlit: bool,
}

impl Material {
    /// Returns its textures.
    pub fn textures(&self) -> impl Iterator<Item = &TextureUse> {
        let uses: [&Option<TextureUse>; 5] = [
            &self.base_colour_texture,
            &self.metallic_roughness_texture,
            &self.normal_texture,
            &self.occlusion_texture,
            &self.emission_texture,
        ];
        uses.into_iter().flatten()
    }

    /// Checks that a scene with `texture_count` textures can use the material.
    ///
    /// # Errors
    /// The first fault, as the end of a sentence: a texture or a set of texture coordinates that
    /// does not exist, or a number that is not finite.
    pub fn check(&self, texture_count: usize) -> Result<(), &'static str> {
        for texture in self.textures() {
            if texture.texture.0 as usize >= texture_count {
                return Err("the scene does not have one of its textures");
            }
            if texture.uv_set > 1 {
                return Err("a texture lies by another set of coordinates than 0 and 1");
            }
            if !texture.transform.is_finite() {
                return Err("the transform of a texture has a number that is not finite");
            }
        }
        let cutoff = match self.alpha {
            Alpha::Mask { cutoff } => cutoff,
            Alpha::Opaque | Alpha::Blend => 0.0,
        };
        let numbers =
            [self.metallic, self.roughness, self.normal_scale, self.occlusion_strength, cutoff];
        let mut numbers = numbers.iter().chain(&self.base_colour).chain(&self.emission);
        let are_finite = numbers.all(|number| number.is_finite());
        if are_finite { Ok(()) } else { Err("one of its numbers is not finite") }
    }
}

impl Default for Material {
    /// Returns the default of glTF 2.0.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_colour: [1.0; 4],
            base_colour_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emission: [0.0; 3],
            emission_texture: None,
            alpha: Alpha::Opaque,
            is_double_sided: false,
            is_unlit: false,
        }
    }
}

/// The meaning of the bytes of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Colours: red, green, blue are sRGB, alpha is linear.
    Srgb,
    /// Numbers: all four channels are linear, as in normal maps.
    Linear,
}

/// The colour beyond the edges of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture repeats.
    Repeat,
    /// The texture repeats, mirrored every other time.
    Mirror,
    /// The last pixel at the edge continues.
    Clamp,
}

/// The filter of a texture's pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filter {
    /// The nearest pixel.
    Nearest,
    /// A mix of the nearest pixels.
    Linear,
}

/// The sampling of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// The colours beyond its edges, across and down.
    pub wrap: [Wrap; 2],
    /// The filter where the texture is magnified.
    pub magnified: Filter,
    /// The filter where the texture is minified.
    pub minified: Filter,
    /// The filter between the levels of mip maps; with `None`, only the largest level is sampled.
    pub between_levels: Option<Filter>,
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            wrap: [Wrap::Repeat; 2],
            magnified: Filter::Linear,
            minified: Filter::Linear,
            between_levels: Some(Filter::Linear),
        }
    }
}

/// An image and its sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Texture {
    /// The sampled image, one of the scene's.
    pub image: ImageId,
    /// The meaning of its bytes.
    pub encoding: Encoding,
    /// The wrapping and filtering of its pixels.
    pub sampler: Sampler,
}

/// The binding of the vertices of a skinned mesh to its joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinWeights {
    /// The number of joints.
    pub joint_count: u32,
    /// The joints: `sets` groups of four per vertex.
    pub joints: Vec<[u16; 4]>,
    /// The weights of the joints; the sum per vertex is 1.
    pub weights: Vec<[f32; 4]>,
    /// The number of groups of four joints per vertex.
    pub sets: u32,
}

/// The displacements of each vertex by a morph target. A list is empty or has an element per
/// vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// The displacements of positions.
    pub positions: Vec<[f32; 3]>,
    /// The displacements of normals.
    pub normals: Vec<[f32; 3]>,
    /// The displacements of tangents.
    pub tangents: Vec<[f32; 3]>,
}

/// A mesh of a single object whose vertices move: they are morphed first, then skinned.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinnedMesh {
    /// The mesh; the scene holds it at rest.
    pub mesh: MeshId,
    /// The skin, if the mesh has one.
    pub skin: Option<SkinWeights>,
    /// The morph targets.
    pub targets: Vec<MorphTarget>,
}

impl SkinnedMesh {
    /// Returns a number for each of `vertices` vertices. Vertices with equal numbers have the same
    /// joints, weights and displacements: if they start at one place, they always move together.
    pub fn motions(&self, vertices: usize) -> Vec<u32> {
        let mut known = HashMap::new();
        let motion_of = |vertex: usize| {
            let mut motion = Vec::new();
            if let Some(skin) = &self.skin {
                let sets = skin.sets as usize;
                let joints = skin.joints.chunks(sets.max(1)).nth(vertex).unwrap_or_default();
                let weights = skin.weights.chunks(sets.max(1)).nth(vertex).unwrap_or_default();
                let hung = joints.as_flattened().iter().zip(weights.as_flattened());
                for (joint, weight) in hung.filter(|(_, weight)| **weight != 0.0) {
                    motion.extend([u32::from(*joint), weight.to_bits()]);
                }
            }
            for target in &self.targets {
                let by = target.positions.get(vertex).copied().unwrap_or_default();
                motion.extend(by.map(|by| (by + 0.0).to_bits()));
            }
            let next = known.len() as u32;
            *known.entry(motion).or_insert(next)
        };
        (0..vertices).map(motion_of).collect()
    }
}

/// A coarser level of detail of a mesh, which uses the same vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct LodLevel {
    /// Three indices for each triangle.
    pub indices: Vec<u32>,
    /// The largest distance of its surface from the mesh's, in the mesh's space, in metres.
    pub error_m: f32,
}

/// The surfaces of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Surfaces {
    /// The surface of each mesh of the scene.
    pub meshes: Vec<SurfaceMesh>,
    /// The materials that meshes name.
    pub materials: Vec<Material>,
    /// The textures of materials.
    pub textures: Vec<Texture>,
    /// The images of textures.
    pub images: Vec<Image>,
    /// The lights beside the ambient one.
    pub lights: Vec<PunctualLight>,
    /// Objects whose material is [`Alpha::Blend`]; [`Scene::objects`](super::Scene::objects) must
    /// not contain any.
    pub transparent: Vec<Object>,
    /// The skinned meshes.
    pub skinned_meshes: Vec<SkinnedMesh>,
    /// Meshes of points and lines.
    pub sprites: Vec<Sprites>,
    /// Coarser levels of each mesh, the finest first; empty, or one list for each mesh of the
    /// scene.
    pub levels: Vec<Vec<LodLevel>>,
    /// Factor of all light before tone mapping; at 1, a white surface under pi lux appears white.
    pub exposure: f32,
    /// The light from all around, and the sky; with `None` the [ambient light](super::Light) is
    /// used.
    pub environment: Option<super::Environment>,
}

impl Default for Surfaces {
    /// Returns no surfaces, at an exposure of 1.
    fn default() -> Self {
        Self {
            meshes: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            images: Vec::new(),
            lights: Vec::new(),
            transparent: Vec::new(),
            skinned_meshes: Vec::new(),
            sprites: Vec::new(),
            levels: Vec::new(),
            exposure: 1.0,
            environment: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_that_hang_and_morph_alike_move_alike() {
        let up = [0.0, 1.0, 0.0];
        let mesh = SkinnedMesh {
            mesh: MeshId(0),
            skin: Some(SkinWeights {
                joint_count: 3,
                joints: vec![[0, 1, 0, 0], [0, 1, 2, 0], [1, 0, 0, 0], [0, 1, 0, 0]],
                weights: vec![[0.5, 0.5, 0.0, 0.0]; 4],
                sets: 1,
            }),
            targets: vec![MorphTarget {
                positions: vec![up, up, up, [-0.0; 3]],
                ..MorphTarget::default()
            }],
        };
        assert_eq!(mesh.motions(4), [0, 0, 1, 2]);
    }
}
