//! Materials: metallic-roughness with its extensions, in safe numbers, and their requirements on
//! geometry.

use std::collections::HashMap;

use gltf::json;
use gltf::json::validation::Checked;
use gltf::material::AlphaMode;
use scene::{Alpha, Encoding, Image, Material, MaterialId, Texture, TextureUse};

use super::sidedness::Backs;
use super::tangents::NormalUvs;
use super::textures::{Named, Textures};
use crate::Source;
use crate::error::quoted;
use crate::notes::Notes;

/// The strongest emission: the largest half-precision number.
const LARGEST_EMISSION: f32 = 65504.0;

/// The lighting of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Shading {
    /// The lighting of the material itself.
    Own,
    /// No lighting: the base colour is shown unchanged.
    Unlit,
}

/// A material, and its requirements on the geometry that uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MaterialUse {
    pub(super) id: MaterialId,
    /// The two of the file's sets of texture coordinates that are kept.
    pub(super) sets: [Option<u32>; 2],
    /// The texture coordinates of its normal texture, if it has one.
    pub(super) normal: Option<NormalUvs>,
    pub(super) backs: Backs,
    pub(super) is_transparent: bool,
    /// True if it is neither blended nor masked, and has no textures.
    pub(super) is_plain: bool,
    pub(super) base_colour: [f32; 4],
}

/// The materials that primitives use.
#[derive(Debug, Default)]
pub(super) struct Materials {
    list: Vec<Material>,
    uses: HashMap<(Option<usize>, Shading), MaterialUse>,
    textures: Textures,
}

impl Materials {
    /// Returns the use of a material of the file; an `index` of `None` is the default material.
    pub(super) fn use_of(
        &mut self,
        source: &Source,
        index: Option<usize>,
        shading: Shading,
        notes: &mut Notes,
    ) -> MaterialUse {
        if let Some(known) = self.uses.get(&(index, shading)) {
            return *known;
        }
        let given = index.and_then(|index| source.document.as_json().materials.get(index));
        let default = json::Material::default();
        let mut slots = Slots::default();
        let mut material =
            convert(given.unwrap_or(&default), source, &mut self.textures, &mut slots);
        material.is_unlit |= shading == Shading::Unlit;
        if material.name.is_empty() {
            material.name =
                index.map_or_else(|| "default".to_owned(), |index| format!("material {index}"));
        }
        notes.count(
            "it has a factor that is out of its range, shown with one within",
            usize::from(given.is_some_and(is_out_of_range)),
            || format!("material {}", quoted(&material.name)),
        );
        notes.count(
            "it has a texture by a third set of texture coordinates, shown by the first",
            slots.unassigned,
            || format!("material {}", quoted(&material.name)),
        );
        let is_transparent = material.alpha == Alpha::Blend;
        let found = MaterialUse {
            id: MaterialId(self.list.len() as u32),
            sets: slots.sets,
            normal: material
                .normal_texture
                .map(|normal| NormalUvs { set: normal.uv_set, transform: normal.transform }),
            backs: match (material.is_double_sided, is_transparent) {
                (false, _) => Backs::None,
                (true, false) => Backs::Last,
                (true, true) => Backs::First,
            },
            is_transparent,
            is_plain: material.alpha == Alpha::Opaque && slots.sets == [None, None],
            base_colour: material.base_colour,
        };
        self.list.push(material);
        self.uses.insert((index, shading), found);
        found
    }

    /// Returns all used materials, with their textures and images, which are taken out of the file.
    pub(super) fn finish(self, source: &mut Source) -> (Vec<Material>, Vec<Texture>, Vec<Image>) {
        let (textures, images) = self.textures.finish(source);
        (self.list, textures, images)
    }
}

/// The two sets of texture coordinates that a material uses. They are the first two of the file if
/// the material needs no others, so that most meshes keep them.
#[derive(Debug, Default)]
struct Slots {
    sets: [Option<u32>; 2],
    unassigned: usize,
}

impl Slots {
    fn slot_of(&mut self, set: u32) -> u8 {
        if let Some(slot) = self.sets.iter().position(|held| *held == Some(set)) {
            return slot as u8;
        }
        let order = if set == 1 { [1, 0] } else { [0, 1] };
        for slot in order {
            if self.sets[slot].is_none() {
                self.sets[slot] = Some(set);
                return slot as u8;
            }
        }
        self.unassigned += 1;
        0
    }
}

fn unit(value: f32) -> f32 {
    if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) }
}

fn convert(
    given: &json::Material,
    source: &Source,
    textures: &mut Textures,
    slots: &mut Slots,
) -> Material {
    let mut texture = |named: Option<Named>, encoding: Encoding| -> Option<TextureUse> {
        let Named { texture, uv_set, transform } = named?;
        let texture = textures.id_of(source, texture, encoding)?;
        Some(TextureUse { texture, uv_set: slots.slot_of(uv_set), transform })
    };
    let metallic_roughness = &given.pbr_metallic_roughness;
    let info = |info: &Option<json::texture::Info>| info.as_ref().map(Named::of_info);
    let base_colour_texture = texture(info(&metallic_roughness.base_color_texture), Encoding::Srgb);
    let metallic_roughness_texture =
        texture(info(&metallic_roughness.metallic_roughness_texture), Encoding::Linear);
    let normal = given.normal_texture.as_ref().map(|normal_texture| {
        let values = |name: &str| normal_texture.extensions.as_ref()?.others.get(name);
        Named::of_values(normal_texture.index.value(), normal_texture.tex_coord, values)
    });
    let normal_texture = texture(normal, Encoding::Linear);
    let occlusion = given.occlusion_texture.as_ref().map(|occlusion_texture| {
        let values = |name: &str| occlusion_texture.extensions.as_ref()?.others.get(name);
        Named::of_values(occlusion_texture.index.value(), occlusion_texture.tex_coord, values)
    });
    let occlusion_texture = texture(occlusion, Encoding::Linear);
    let emission_texture = texture(info(&given.emissive_texture), Encoding::Srgb);
    let extensions = given.extensions.as_ref();
    let strength = extensions.and_then(|extensions| extensions.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
    let emission = |factor: f32| {
        let emission = (factor * strength).clamp(0.0, LARGEST_EMISSION);
        if emission.is_nan() { 0.0 } else { emission }
    };
    Material {
        name: given.name.clone().unwrap_or_default(),
        base_colour: metallic_roughness.base_color_factor.0.map(unit),
        base_colour_texture,
        metallic: unit(metallic_roughness.metallic_factor.0),
        roughness: unit(metallic_roughness.roughness_factor.0),
        metallic_roughness_texture,
        normal_texture,
        normal_scale: given
            .normal_texture
            .as_ref()
            .map_or(1.0, |normal_texture| normal_texture.scale.clamp(-1e3, 1e3)),
        occlusion_texture,
        occlusion_strength: given
            .occlusion_texture
            .as_ref()
            .map_or(1.0, |occlusion_texture| unit(occlusion_texture.strength.0)),
        emission: given.emissive_factor.0.map(emission),
        emission_texture,
        alpha: match given.alpha_mode {
            Checked::Valid(AlphaMode::Mask) => {
                Alpha::Mask { cutoff: given.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0.max(0.0)) }
            }
            Checked::Valid(AlphaMode::Blend) => Alpha::Blend,
            Checked::Valid(AlphaMode::Opaque) | Checked::Invalid => Alpha::Opaque,
        },
        is_double_sided: given.double_sided,
        is_unlit: extensions.is_some_and(|extensions| extensions.unlit.is_some()),
    }
}

/// Returns true if a factor is out of the range that glTF allows.
fn is_out_of_range(given: &json::Material) -> bool {
    let pbr = &given.pbr_metallic_roughness;
    let occlusion = given
        .occlusion_texture
        .as_ref()
        .map_or(1.0, |occlusion_texture| occlusion_texture.strength.0);
    let [red, green, blue, alpha] = pbr.base_color_factor.0;
    let units = [red, green, blue, alpha, pbr.metallic_factor.0, pbr.roughness_factor.0, occlusion];
    let strength =
        given.extensions.as_ref().and_then(|extensions| extensions.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
    let cutoff = given.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0);
    let is_unit = |number: &f32| (0.0..=1.0).contains(number);
    !units.iter().chain(&given.emissive_factor.0).all(is_unit) || strength < 0.0 || cutoff < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sets_of_coordinates_find_a_place_and_a_third_shares_one() {
        let mut slots = Slots::default();
        assert_eq!([1, 0, 1].map(|set| slots.slot_of(set)), [1, 0, 1]);
        assert_eq!((slots.sets, slots.unassigned), ([Some(0), Some(1)], 0));
        assert_eq!((slots.slot_of(5), slots.unassigned), (0, 1));
        let mut slots = Slots::default();
        assert_eq!([4, 2, 4].map(|set| slots.slot_of(set)), [0, 1, 0]);
        assert_eq!((slots.sets, slots.unassigned), ([Some(4), Some(2)], 0));
        let mut slots = Slots::default();
        assert_eq!([3, 0].map(|set| slots.slot_of(set)), [0, 1]);
    }

    #[test]
    fn numbers_are_kept_in_their_ranges() {
        assert_eq!([-1.0, 0.25, 7.0, f32::NAN].map(unit), [0.0, 0.25, 1.0, 1.0]);
    }
}
