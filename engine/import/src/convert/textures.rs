//! Textures: their images, encodings and samplers. Only textures that materials use are kept.

use std::collections::HashMap;

use glam::{Affine2, Vec2};
use gltf::json::validation::Checked;
use gltf::json::{Value, texture};
use gltf::texture::{MagFilter, MinFilter, WrappingMode};
use scene::{Encoding, Filter, Image, ImageId, Sampler, Texture, TextureId, Wrap};

use crate::Source;

/// The name of the extension that `gltf` does not parse everywhere.
const TRANSFORM: &str = "KHR_texture_transform";

/// A texture as a material refers to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Named {
    pub(super) texture: usize,
    pub(super) uv_set: u32,
    pub(super) transform: Affine2,
}

impl Named {
    pub(super) fn of_info(info: &texture::Info) -> Self {
        let named = Self {
            texture: info.index.value(),
            uv_set: info.tex_coord,
            transform: Affine2::IDENTITY,
        };
        match info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref())
        {
            Some(given) => Self {
                uv_set: given.tex_coord.unwrap_or(named.uv_set),
                transform: transform(given.scale.0, given.rotation.0, given.offset.0),
                ..named
            },
            None => named,
        }
    }

    /// Returns a texture of normals or occlusion, whose extensions `gltf` does not parse.
    pub(super) fn of_values<'a>(
        texture: usize,
        uv_set: u32,
        value: impl Fn(&str) -> Option<&'a Value>,
    ) -> Self {
        let named = Self { texture, uv_set, transform: Affine2::IDENTITY };
        let Some(given) = value(TRANSFORM) else {
            return named;
        };
        let pair = |name: &str, default: [f32; 2]| {
            let parts = given.get(name).and_then(Value::as_array);
            let part = |place: usize| Some(parts?.get(place)?.as_f64()? as f32);
            std::array::from_fn(|place| part(place).unwrap_or(default[place]))
        };
        let turn = given.get("rotation").and_then(Value::as_f64).unwrap_or_default() as f32;
        let set = given.get("texCoord").and_then(Value::as_u64);
        Self {
            uv_set: set.and_then(|set| u32::try_from(set).ok()).unwrap_or(uv_set),
            transform: transform(pair("scale", [1.0; 2]), turn, pair("offset", [0.0; 2])),
            ..named
        }
    }
}

/// Returns the transform that scales, then rotates, then translates. A positive angle turns
/// counter-clockwise in the displayed image, with v downwards. The result is the identity if
/// numbers overflow.
fn transform(scale: [f32; 2], rotation_rad: f32, offset: [f32; 2]) -> Affine2 {
    let transform = Affine2::from_scale_angle_translation(
        Vec2::from_array(scale),
        -rotation_rad,
        Vec2::from_array(offset),
    );
    let is_sane = transform.to_cols_array().iter().all(|part| part.abs() <= 1e9);
    if is_sane { transform } else { Affine2::IDENTITY }
}

/// The textures that materials use.
#[derive(Debug, Default)]
pub(super) struct Textures {
    list: Vec<Texture>,
    known: HashMap<Texture, TextureId>,
    images: Vec<usize>,
    known_images: HashMap<usize, ImageId>,
}

impl Textures {
    /// Returns the id of a texture of the file in this encoding; `None` if its image cannot be
    /// read.
    pub(super) fn id_of(
        &mut self,
        source: &Source,
        texture: usize,
        encoding: Encoding,
    ) -> Option<TextureId> {
        let image = source.texture_images.get(texture).copied().flatten()?;
        source.images.get(image)?.as_ref()?;
        // A placeholder would not be recognisable in a texture that is not colour.
        if encoding == Encoding::Linear && source.placeholders.contains(&image) {
            return None;
        }
        let image = *self.known_images.entry(image).or_insert_with(|| {
            self.images.push(image);
            ImageId(self.images.len() as u32 - 1)
        });
        let texture = Texture { image, encoding, sampler: sampler_of(source, texture) };
        Some(*self.known.entry(texture).or_insert_with(|| {
            self.list.push(texture);
            TextureId(self.list.len() as u32 - 1)
        }))
    }

    /// Returns all textures, and their images, which are taken out of the file.
    pub(super) fn finish(self, source: &mut Source) -> (Vec<Texture>, Vec<Image>) {
        let mut take = |image: usize| source.images.get_mut(image).and_then(Option::take);
        // Each image existed when its id was assigned, and each is taken once.
        let images = self.images.into_iter().filter_map(&mut take).collect();
        (self.list, images)
    }
}

fn sampler_of(source: &Source, texture: usize) -> Sampler {
    let json = source.document.as_json();
    let sampler = json.textures.get(texture).and_then(|texture| texture.sampler);
    let Some(sampler) = sampler.and_then(|sampler| json.samplers.get(sampler.value())) else {
        return Sampler::default();
    };
    let wrap = |mode: &Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    };
    let magnified = match sampler.mag_filter {
        Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
        _ => Filter::Linear,
    };
    let (minified, between_levels) = match sampler.min_filter {
        Some(Checked::Valid(filter)) => match filter {
            MinFilter::Nearest => (Filter::Nearest, None),
            MinFilter::Linear => (Filter::Linear, None),
            MinFilter::NearestMipmapNearest => (Filter::Nearest, Some(Filter::Nearest)),
            MinFilter::LinearMipmapNearest => (Filter::Linear, Some(Filter::Nearest)),
            MinFilter::NearestMipmapLinear => (Filter::Nearest, Some(Filter::Linear)),
            MinFilter::LinearMipmapLinear => (Filter::Linear, Some(Filter::Linear)),
        },
        _ => (Filter::Linear, Some(Filter::Linear)),
    };
    Sampler {
        wrap: [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)],
        magnified,
        minified,
        between_levels,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_scale_turn_and_move_in_this_order() {
        let quarter = std::f32::consts::FRAC_PI_2;
        let at = |uv: [f32; 2]| {
            transform([2.0, 3.0], quarter, [10.0, 20.0]).transform_point2(Vec2::from_array(uv))
        };
        // Counter-clockwise with v down: u turns up, to -v; v turns right, to u.
        assert!(at([1.0, 0.0]).distance(Vec2::new(10.0, 18.0)) < 1e-5);
        assert!(at([0.0, 1.0]).distance(Vec2::new(13.0, 20.0)) < 1e-5);
        assert_eq!(transform([1e38; 2], 0.3, [0.0; 2]), Affine2::IDENTITY);
    }

    #[test]
    fn transforms_of_values_and_of_infos_are_the_same() {
        let text = r#"{"offset": [0.5, 0.25], "rotation": 0.3, "scale": [2, 4], "texCoord": 3}"#;
        let value: Value = gltf::json::deserialize::from_str(text).expect("JSON");
        let by_value = Named::of_values(7, 1, |name| (name == TRANSFORM).then_some(&value));
        let info =
            format!(r#"{{"index": 7, "texCoord": 1, "extensions": {{"{TRANSFORM}": {text}}}}}"#);
        let info: texture::Info = gltf::json::deserialize::from_str(&info).expect("JSON");
        assert_eq!(by_value, Named::of_info(&info));
        assert_eq!((by_value.texture, by_value.uv_set), (7, 3));
        assert_eq!(by_value.transform.translation, Vec2::new(0.5, 0.25));
        let plain = Named::of_values(7, 1, |_| None);
        assert_eq!((plain.uv_set, plain.transform), (1, Affine2::IDENTITY));
    }
}
