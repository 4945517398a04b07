//! The material table: the shaders' data of materials, and the features that a scene uses.

use bytemuck::{Pod, Zeroable};
use glam::Affine2;
use gpu::SpecializationConstant;
use scene::{
    Alpha, Encoding, LightCookie, Material, PunctualLight, Surfaces, TextureId, TextureUse,
};

use crate::error::Error;
use crate::resource_errors::MaterialError;
use crate::shading::surfaces::pages::PagePlan;
use crate::shading::surfaces::texture_slots::TexturePlace;
use crate::shading::surfaces::texture_transforms::TextureTransforms;

/// One material as `material.glsl` declares it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct MaterialEntry {
    base_colour: [u32; 2],
    roughness_metallic: u32,
    occlusion_and_flags: u32,
    cutoff: f32,
    normal_scale: f32,
    base_colour_texture: u32,
    metallic_roughness_texture: u32,
    emission: [f32; 3],
    emission_texture: u32,
    normal_texture: u32,
    occlusion_texture: u32,
    unused: [u32; 2],
}

const _: () = assert!(size_of::<MaterialEntry>() == 64);

/// The packed place without a texture.
pub(super) const NO_TEXTURE: u32 = 0xFFEF;
const UNLIT_FLAG: u32 = 1 << 16;
const NORMALS_OF_TWO_CHANNELS_FLAG: u32 = 1 << 17;
/// The number of textures of a material. Each may have its own transform.
const TEXTURES: usize = 5;

/// All materials of a scene, and room for more. The last one is for meshes without a material.
pub(crate) struct MaterialTable {
    pub(crate) entries: Vec<MaterialEntry>,
    pub(crate) transforms: TextureTransforms,
    places: Vec<Option<TexturePlace>>,
    /// The number of uses of each texture by materials and lights.
    texture_users: Vec<u32>,
}

/// The features that the materials and lights of a scene use. Pipelines are compiled for them, so
/// that unused features cost nothing per pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Features {
    pub(crate) is_masked: bool,
    pub(crate) is_unlit: bool,
    pub(crate) is_emissive: bool,
    pub(crate) is_transformed: bool,
    pub(crate) directional_lights: u32,
    pub(crate) has_local_lights: bool,
    pub(crate) has_spots: bool,
    /// The pages of base colours, of roughness and metallic, normals, occlusion and emission, with
    /// a bit per page; for textures with separate images, a bit per encoding.
    pub(crate) pages: [u32; 5],
    /// The pages of the pictures that spot lights project, with the same bits.
    pub(crate) pictures: u32,
}

impl MaterialTable {
    /// Packs the materials, with room for `spare` more, and notes the places of their textures.
    pub(crate) fn new(
        surfaces: &Surfaces,
        places: Vec<Option<TexturePlace>>,
        spare: u32,
    ) -> Result<Self, Error> {
        let mut transforms = TextureTransforms::new();
        let fallback = Material::default();
        let fallbacks = std::iter::repeat_n(&fallback, spare as usize + 1);
        let all = surfaces.materials.iter().chain(fallbacks);
        let entries = all.map(|material| entry_of(material, &places, &mut transforms)).collect();
        transforms.keep_room((spare as usize).saturating_mul(TEXTURES))?;
        let mut table = Self { entries, transforms, places, texture_users: Vec::new() };
        surfaces.materials.iter().for_each(|material| table.count_textures(material, 1));
        surfaces.lights.iter().for_each(|light| table.count_cookie(light, 1));
        Ok(table)
    }

    /// Returns the number of the scene's textures.
    pub(crate) fn texture_count(&self) -> usize {
        self.places.len()
    }

    /// Refuses a material that passes compiled for `features` cannot draw, with the reason.
    pub(crate) fn check(
        &self,
        material: &Material,
        features: &Features,
    ) -> Result<(), MaterialError> {
        let mut uses = textures_of(material).into_iter().flatten();
        if uses.any(|texture_use| place_of(texture_use, &self.places).is_none()) {
            return Err(MaterialError::UnknownTexture);
        }
        if Features::of([material].into_iter(), &self.places).are_within(features) {
            return Ok(());
        }
        Err(MaterialError::Encoding)
    }

    /// Refuses a material if there is no room for the transforms of its textures.
    pub(crate) fn check_room(&self, material: &Material) -> Result<(), Error> {
        let uses = textures_of(material).into_iter().flatten();
        self.transforms.check_room(uses.map(|texture_use| texture_use.transform))
    }

    /// Packs a material at its place. The material must have been [checked](MaterialTable::check),
    /// and there must be [room](MaterialTable::check_room) for it.
    pub(crate) fn set(&mut self, number: u32, material: &Material) {
        let entry = entry_of(material, &self.places, &mut self.transforms);
        self.count_textures(material, 1);
        if let Some(there) = self.entries.get_mut(number as usize) {
            *there = entry;
        }
    }

    /// Notes the place of a texture.
    pub(crate) fn place_texture(&mut self, texture: TextureId, place: Option<TexturePlace>) {
        let number = texture.0 as usize;
        let places = &mut self.places;
        places.resize(places.len().max(number + 1), None);
        if let Some(there) = places.get_mut(number) {
            *there = place;
        }
    }

    /// Returns the place of a texture, if it is on the GPU.
    pub(crate) fn place(&self, texture: TextureId) -> Option<TexturePlace> {
        self.places.get(texture.0 as usize).copied().flatten()
    }

    /// Notes that a light with its picture is added or removed.
    pub(crate) fn count_cookie(&mut self, light: &PunctualLight, change: i32) {
        if let Some(LightCookie { texture, .. }) = light.cookie {
            self.count_texture(texture, change);
        }
    }

    /// Returns true if a material or a light uses a texture.
    pub(crate) fn uses_texture(&self, texture: TextureId) -> bool {
        self.texture_users.get(texture.0 as usize).is_some_and(|users| *users > 0)
    }

    fn count_textures(&mut self, material: &Material, change: i32) {
        for texture_use in textures_of(material).into_iter().flatten() {
            self.count_texture(texture_use.texture, change);
        }
    }

    fn count_texture(&mut self, texture: TextureId, change: i32) {
        let number = texture.0 as usize;
        if number < self.places.len() {
            let users = &mut self.texture_users;
            users.resize(users.len().max(number + 1), 0);
            if let Some(users) = users.get_mut(number) {
                *users = users.saturating_add_signed(change);
            }
        }
    }

    /// Frees the textures of a material and their transforms.
    pub(crate) fn free(&mut self, material: &Material) {
        self.count_textures(material, -1);
        for texture_use in textures_of(material).into_iter().flatten() {
            if place_of(texture_use, &self.places).is_some() {
                self.transforms.free(texture_use.transform);
            }
        }
    }

    pub(crate) fn entry(&self, number: u32) -> MaterialEntry {
        self.entries.get(number as usize).copied().unwrap_or_else(MaterialEntry::zeroed)
    }
}

impl Features {
    /// Returns the features that materials use. The features of lights are left to the caller.
    pub(crate) fn of<'a>(
        materials: impl Iterator<Item = &'a Material>,
        places: &[Option<TexturePlace>],
    ) -> Self {
        let mut found = Self::default();
        for material in materials {
            found.is_masked |= matches!(material.alpha, Alpha::Mask { .. });
            found.is_unlit |= material.is_unlit;
            found.is_emissive |= material.emission.iter().any(|part| *part > 0.0);
            for (pages, texture_use) in found.pages.iter_mut().zip(textures_of(material)) {
                let place = texture_use.and_then(|texture_use| place_of(texture_use, places));
                let Some(TexturePlace { bit, .. }) = place else { continue };
                *pages |= bit;
                found.is_transformed |= texture_use
                    .is_some_and(|texture_use| texture_use.transform != Affine2::IDENTITY);
            }
        }
        found
    }

    /// Returns the pages of pictures that lights may project: if any light projects one, the pages
    /// of all colours.
    pub(crate) fn cookie_pages(
        surfaces: &Surfaces,
        places: &[Option<TexturePlace>],
        plan: &PagePlan,
    ) -> u32 {
        let place = |picture: LightCookie| *places.get(picture.texture.0 as usize)?;
        let places = surfaces.lights.iter().filter_map(|light| place(light.cookie?));
        let own = places.fold(0, |bits, place| bits | place.bit);
        if own == 0 { 0 } else { own | plan.bits_of(Encoding::Srgb) }
    }

    /// Returns the features that any material without blending may use, with these lights, if
    /// textures are used for their purpose.
    pub(crate) fn of_any(self, plan: &PagePlan) -> Self {
        let [colours, numbers] =
            [Encoding::Srgb, Encoding::Linear].map(|encoding| plan.bits_of(encoding));
        let of_kind = [colours, numbers, numbers, numbers, colours];
        Self {
            is_masked: true,
            is_unlit: true,
            is_emissive: true,
            is_transformed: true,
            pages: std::array::from_fn(|kind| self.pages[kind] | of_kind[kind]),
            ..self
        }
    }

    /// Returns true if passes compiled for `others` draw materials with these features.
    fn are_within(&self, others: &Self) -> bool {
        let has = |mine: bool, theirs: bool| !mine || theirs;
        has(self.is_masked, others.is_masked)
            && has(self.is_unlit, others.is_unlit)
            && has(self.is_emissive, others.is_emissive)
            && has(self.is_transformed, others.is_transformed)
            && self.pages.iter().zip(others.pages).all(|(mine, theirs)| mine & !theirs == 0)
    }

    /// Returns the specialisation constants of `surface_constants.glsl`.
    pub(crate) fn constants(&self, is_transparent: bool) -> [SpecializationConstant; 13] {
        let [base_colour, metallic_roughness, normal, occlusion, emission] = self.pages;
        let values = [
            u32::from(self.is_masked),
            u32::from(is_transparent),
            u32::from(self.is_unlit),
            u32::from(self.is_emissive),
            u32::from(self.is_transformed),
            self.directional_lights,
            u32::from(self.has_local_lights),
            u32::from(self.has_spots),
            base_colour,
            metallic_roughness,
            normal,
            occlusion,
            emission,
        ];
        std::array::from_fn(|id| SpecializationConstant { id: id as u32, value: values[id] })
    }
}

fn textures_of(material: &Material) -> [Option<TextureUse>; TEXTURES] {
    [
        material.base_colour_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.occlusion_texture,
        // Black times any texture is black.
        material.emission_texture.filter(|_| material.emission.iter().any(|part| *part > 0.0)),
    ]
}

/// Packs the place of a texture, without a set of coordinates and a transform: four bits of a page
/// and eleven bits of its layer, or fifteen bits of the number of an image. The fifth bit is left
/// out.
pub(super) fn packed(TexturePlace { page, layer, .. }: TexturePlace) -> u32 {
    let number = page as u32;
    number & 15 | ((number >> 4) + layer) << 5
}

fn place_of(texture_use: TextureUse, places: &[Option<TexturePlace>]) -> Option<TexturePlace> {
    places.get(texture_use.texture.0 as usize).copied().flatten()
}

fn entry_of(
    material: &Material,
    places: &[Option<TexturePlace>],
    transforms: &mut TextureTransforms,
) -> MaterialEntry {
    let mut texture = |texture_use: Option<TextureUse>| {
        let placed = texture_use.and_then(|used| Some((used, place_of(used, places)?)));
        let Some((texture_use, place)) = placed else { return NO_TEXTURE };
        let set = u32::from(texture_use.uv_set.min(1));
        packed(place) | set << 4 | transforms.take(texture_use.transform) << 16
    };
    let [base, metallic_roughness, normal, occlusion, emission] =
        textures_of(material).map(&mut texture);
    let [red, green, blue, alpha] = material.base_colour.map(|part| or(part, 1.0));
    let normals = material.normal_texture.and_then(|used| place_of(used, places));
    let flags = [
        (material.is_unlit, UNLIT_FLAG),
        (normals.is_some_and(|place| place.has_two_channels), NORMALS_OF_TWO_CHANNELS_FLAG),
    ];
    let flags =
        flags.into_iter().fold(0, |all, (is_on, flag)| if is_on { all | flag } else { all });
    MaterialEntry {
        base_colour: [pack_unorm16(red, green), pack_unorm16(blue, alpha)],
        roughness_metallic: pack_unorm16(or(material.roughness, 1.0), or(material.metallic, 1.0)),
        occlusion_and_flags: pack_unorm16(or(material.occlusion_strength, 1.0), 0.0) | flags,
        cutoff: match material.alpha {
            Alpha::Mask { cutoff } => or(cutoff, 0.5),
            // No alpha is lower.
            Alpha::Opaque | Alpha::Blend => -1.0,
        },
        normal_scale: or(material.normal_scale, 1.0),
        base_colour_texture: base,
        metallic_roughness_texture: metallic_roughness,
        // Anything brighter is shown as white anyway.
        emission: material.emission.map(|part| or(part, 0.0).clamp(0.0, 65504.0)),
        emission_texture: emission,
        normal_texture: normal,
        occlusion_texture: occlusion,
        unused: [0; 2],
    }
}

/// Returns `value`, or `otherwise` if it is not finite.
fn or(value: f32, otherwise: f32) -> f32 {
    if value.is_finite() { value } else { otherwise }
}

/// Packs two numbers in `0.0..=1.0` for GLSL's `unpackUnorm2x16`.
fn pack_unorm16(low: f32, high: f32) -> u32 {
    let unorm = |value: f32| (value.clamp(0.0, 1.0) * 65535.0).round() as u32;
    unorm(low) | unorm(high) << 16
}
