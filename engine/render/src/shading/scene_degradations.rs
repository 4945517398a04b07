//! The parts of a scene that are shown in a degraded form, and the reasons.

use crate::shading::surfaces::TextureStorage;
use scene::counted;
use scene::limits::{MAX_DIRECTIONAL_LIGHTS, MAX_LIGHTS_PER_OBJECT, MAX_PAGES};

/// The parts of a scene beyond a renderer's limits, which are shown in a degraded form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneDegradations {
    /// Objects that more point and spot lights reach than [`MAX_LIGHTS_PER_OBJECT`]: the weakest do
    /// not shine on them. The present number, which changes as lights and objects move.
    pub crowded_objects: usize,
    /// Directional lights beyond [`MAX_DIRECTIONAL_LIGHTS`], the weakest: they do not shine.
    pub dark_suns: usize,
    /// Lights with a number that is not finite, or without a direction that they need, which do not
    /// shine; and those whose range is not above 0, which shine as if they had none. The present
    /// number.
    pub broken_lights: usize,
    /// Objects of masked materials, which cast no shadow since a stencil knows no holes: with
    /// shadow volumes. The present number.
    pub unshadowed_objects: usize,
    /// Section planes that do not cut the shadows of objects: with shadow volumes. The present
    /// number.
    pub planes_without_shadows: usize,
    /// Images that lose sharpness, since the device or the memory for textures holds no larger
    /// ones.
    pub shrunk_images: usize,
    /// Images of another size than their page, which are made larger and lose nothing.
    pub enlarged_images: usize,
    /// Images of compressed blocks that take four bytes per texel, since they lie on pages, or the
    /// device does not sample their format or size, or not as colours (BC4 and BC5): once for each
    /// encoding, and with [images](TextureStorage::Bindless) for each sampler. Those that come
    /// later do not count.
    pub unpacked_images: usize,
    /// Textures that are sampled by another sampler than their own.
    pub borrowed_samplers: usize,
    /// The way that textures lie on the GPU: of the two, only pages enlarge images and borrow
    /// samplers.
    pub textures: TextureStorage,
}

impl SceneDegradations {
    /// Returns a sentence for each, for people.
    #[must_use]
    pub fn texts(&self) -> Vec<String> {
        let Self { crowded_objects, dark_suns, broken_lights, unshadowed_objects, .. } = *self;
        let Self { shrunk_images, unpacked_images, borrowed_samplers, textures, .. } = *self;
        let shrunk_by = match textures {
            TextureStorage::Bindless => "the device takes no larger ones".to_owned(),
            TextureStorage::ArrayPacked => format!(
                "{MAX_PAGES} texture pages hold no more sizes, or the device takes no larger ones"
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
