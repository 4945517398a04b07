//! The parts of a scene that are shown in a degraded form, and the reasons.

use crate::shading::surfaces::TextureStorage;
use scene::counted;
use scene::limits::{MAX_DIRECTIONAL_LIGHTS, MAX_LIGHTS_PER_OBJECT, MAX_PAGES};

/// The parts of a scene beyond a renderer's limits, which are shown in a degraded form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneDegradations {
    /// The present number of objects in reach of more point and spot lights than
    /// [`MAX_LIGHTS_PER_OBJECT`]. The weakest of these lights do not shine on the object.
    pub crowded_objects: usize,
    /// The number of directional lights beyond [`MAX_DIRECTIONAL_LIGHTS`]. They are the weakest and
    /// do not shine.
    pub dark_suns: usize,
    /// The present number of broken lights. A light with a number that is not finite, or without a
    /// direction that it needs, does not shine. A light with a range that is not above 0 shines
    /// without a range.
    pub broken_lights: usize,
    /// The present number of objects with masked materials under shadow volumes. They cast no
    /// shadow, since a stencil cannot represent holes.
    pub unshadowed_objects: usize,
    /// The present number of section planes under shadow volumes. They do not cut the shadows of
    /// objects.
    pub planes_without_shadows: usize,
    /// The number of images that lose sharpness, since the device or the texture memory cannot hold
    /// larger ones.
    pub shrunk_images: usize,
    /// The number of images that are enlarged to the size of their page, without loss.
    pub enlarged_images: usize,
    /// The number of compressed images that take four bytes per texel: they lie on pages, or the
    /// device does not sample their format or size, or not as colours (BC4 and BC5). An image
    /// counts once for each encoding, and with [images](TextureStorage::Bindless) once for each
    /// sampler. Textures that are added later do not count.
    pub unpacked_images: usize,
    /// The number of textures that are sampled by another sampler than their own.
    pub borrowed_samplers: usize,
    /// The storage of textures. Only pages enlarge images and borrow samplers.
    pub textures: TextureStorage,
}

impl SceneDegradations {
    /// Returns a sentence for each degradation, for users.
    #[must_use]
    pub fn texts(&self) -> Vec<String> {
        let Self { crowded_objects, dark_suns, broken_lights, unshadowed_objects, .. } = *self;
        let Self { shrunk_images, unpacked_images, borrowed_samplers, textures, .. } = *self;
        let shrunk_by = match textures {
            TextureStorage::Bindless => {
                "the device takes no larger ones, or has no memory for them".to_owned()
            }
            TextureStorage::ArrayPacked => format!(
                "{MAX_PAGES} texture pages hold no more sizes, or the device takes no larger ones, or has no memory for them"
            ),
        };
        let unpacked_by = match textures {
            TextureStorage::Bindless => "the device does not sample such blocks as they are",
            TextureStorage::ArrayPacked => "texture pages do not take blocks",
        };
        let sentence = |count: usize, one: &str, several: &str, rest: String| {
            (count > 0).then(|| format!("{} {rest}", counted(count, one, several)))
        };
        [
            sentence(
                crowded_objects,
                "object is",
                "objects are",
                format!(
                    "reached by more than {MAX_LIGHTS_PER_OBJECT} lights: the weakest of them are left out"
                ),
            ),
            sentence(
                dark_suns,
                "directional light does",
                "directional lights do",
                format!("not shine: only the strongest {MAX_DIRECTIONAL_LIGHTS} do"),
            ),
            sentence(
                broken_lights,
                "light has",
                "lights have",
                "a number that is not finite, no direction, or a range that is not above 0: dark, or without a range".to_owned(),
            ),
            sentence(
                unshadowed_objects,
                "object of a masked material casts",
                "objects of masked materials cast",
                "no shadow: shadow volumes know no holes, shadow maps do".to_owned(),
            ),
            sentence(
                shrunk_images,
                "image is",
                "images are",
                format!("less sharp than in the scene: {shrunk_by}"),
            ),
            sentence(
                unpacked_images,
                "compressed image is",
                "compressed images are",
                format!("unpacked to four bytes per pixel: {unpacked_by}"),
            ),
            sentence(
                borrowed_samplers,
                "texture is",
                "textures are",
                format!(
                    "filtered or wrapped like others: there are more samplers than {MAX_PAGES} texture pages have"
                ),
            ),
        ]
        .into_iter()
        .flatten()
        .chain(self.planes_text())
        .collect()
    }

    fn planes_text(&self) -> Option<String> {
        let count = self.planes_without_shadows;
        let planes = counted(count, "section plane does", "section planes do");
        (count > 0).then(|| format!("{planes} not cut shadow volumes: shadow maps are cut"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lost_is_said_and_nothing_else() {
        assert!(SceneDegradations::default().texts().is_empty());
        assert!(
            SceneDegradations { enlarged_images: 3, ..SceneDegradations::default() }
                .texts()
                .is_empty()
        );
        let all = SceneDegradations {
            crowded_objects: 5,
            dark_suns: 6,
            broken_lights: 4,
            unshadowed_objects: 2,
            planes_without_shadows: 1,
            shrunk_images: 7,
            enlarged_images: 8,
            unpacked_images: 3,
            borrowed_samplers: 9,
            textures: TextureStorage::ArrayPacked,
        };
        for (text, number) in all.texts().iter().zip([5, 6, 4, 2, 7, 3, 9, 1]) {
            assert!(text.starts_with(&number.to_string()), "{text}");
        }
        assert_eq!(all.texts().len(), 8);
        assert!(all.texts()[4].contains("texture pages"), "{}", all.texts()[4]);
        let own = SceneDegradations { textures: TextureStorage::Bindless, ..all }.texts();
        assert!(!own[4].contains("pages"), "{}", own[4]);
        let one = SceneDegradations { unpacked_images: 1, ..SceneDegradations::default() }.texts();
        assert!(one[0].starts_with("1 compressed image is unpacked"), "{}", one[0]);
    }
}
