//! The parameters of a swapchain: pure choices from the capabilities of a surface.

use ash::vk;

use crate::core::error::Error;

/// Formats that store the bytes of a frame unchanged, best first. The renderer's bytes are already
/// sRGB-encoded, as the colour space declares; sRGB formats would encode them a second time.
const FORMATS: [vk::Format; 3] =
    [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM, vk::Format::A8B8G8R8_UNORM_PACK32];

/// The colour space of every frame.
pub(super) const COLOUR_SPACE: vk::ColorSpaceKHR = vk::ColorSpaceKHR::SRGB_NONLINEAR;

/// Returns the format for frames from those `offered`.
pub(super) fn format(offered: &[vk::SurfaceFormatKHR]) -> Result<vk::Format, Error> {
    let has = |format: vk::Format| {
        // A single UNDEFINED once meant that every format is supported.
        offered.iter().any(|f| {
            f.color_space == COLOUR_SPACE && [format, vk::Format::UNDEFINED].contains(&f.format)
        })
    };
    FORMATS.into_iter().find(|format| has(*format)).ok_or_else(|| {
        let offered: Vec<_> =
            offered.iter().map(|f| format!("{:?} in {:?}", f.format, f.color_space)).collect();
        Error::CannotPresent(format!(
            "it takes {}, and no eight bits a channel in sRGB as they are",
            offered.join(", ")
        ))
    })
}

/// Returns the size of the images, or `None` if the window has no pixel.
///
/// The size is the surface's own size if it has one. On Wayland, where the images determine the
/// size of the window, it is `window_size`.
pub(super) fn extent(
    state: &vk::SurfaceCapabilitiesKHR,
    window_size: [u32; 2],
) -> Option<[u32; 2]> {
    const UP_TO_THE_IMAGES: u32 = u32::MAX;
    let vk::Extent2D { width, height } = state.current_extent;
    let wanted = match [width, height] {
        [UP_TO_THE_IMAGES, _] | [_, UP_TO_THE_IMAGES] => window_size,
        current => current,
    };
    if wanted.contains(&0)
        || state.max_image_extent.width == 0
        || state.max_image_extent.height == 0
    {
        return None;
    }
    let within = |side: u32, least: u32, most: u32| side.max(least).min(most);
    let least = state.min_image_extent;
    let most = state.max_image_extent;
    Some([within(wanted[0], least.width, most.width), within(wanted[1], least.height, most.height)])
}

/// Returns one image more than the minimum: with the minimum, the CPU would wait for the screen
/// before each frame even if there is time.
pub(super) fn image_count(state: &vk::SurfaceCapabilitiesKHR) -> u32 {
    let most = if state.max_image_count == 0 { u32::MAX } else { state.max_image_count };
    (state.min_image_count + 1).max(3).min(most)
}

/// Returns opaque if the surface supports it, because the frame's alpha has no meaning.
pub(super) fn alpha(state: &vk::SurfaceCapabilitiesKHR) -> vk::CompositeAlphaFlagsKHR {
    let offered = state.supported_composite_alpha;
    [
        vk::CompositeAlphaFlagsKHR::OPAQUE,
        vk::CompositeAlphaFlagsKHR::INHERIT,
        vk::CompositeAlphaFlagsKHR::PRE_MULTIPLIED,
        vk::CompositeAlphaFlagsKHR::POST_MULTIPLIED,
    ]
    .into_iter()
    .find(|alpha| offered.contains(*alpha))
    .unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE)
}

/// Returns the identity, or the current transform of a screen that does not rotate frames itself.
pub(super) fn transform(state: &vk::SurfaceCapabilitiesKHR) -> vk::SurfaceTransformFlagsKHR {
    if state.supported_transforms.contains(vk::SurfaceTransformFlagsKHR::IDENTITY) {
        vk::SurfaceTransformFlagsKHR::IDENTITY
    } else {
        state.current_transform
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(current: [u32; 2], most: u32) -> vk::SurfaceCapabilitiesKHR {
        vk::SurfaceCapabilitiesKHR {
            min_image_count: 2,
            current_extent: vk::Extent2D { width: current[0], height: current[1] },
            min_image_extent: vk::Extent2D { width: 1, height: 1 },
            max_image_extent: vk::Extent2D { width: most, height: most },
            ..Default::default()
        }
    }

    fn offer(format: vk::Format) -> vk::SurfaceFormatKHR {
        vk::SurfaceFormatKHR { format, color_space: COLOUR_SPACE }
    }

    #[test]
    fn the_surface_knows_its_size_better_than_the_caller() {
        assert_eq!(extent(&state([30, 20], 100), [50, 50]), Some([30, 20]));
        assert_eq!(extent(&state([0, 20], 100), [50, 50]), None);
        assert_eq!(extent(&state([30, 20], 0), [50, 50]), None);
    }

    #[test]
    fn on_wayland_the_caller_says_how_large_the_window_is() {
        let unknown = [u32::MAX; 2];
        assert_eq!(extent(&state(unknown, 100), [50, 40]), Some([50, 40]));
        assert_eq!(extent(&state(unknown, 100), [500, 40]), Some([100, 40]));
        assert_eq!(extent(&state(unknown, 100), [0, 40]), None);
    }

    #[test]
    fn there_is_an_image_to_spare_if_there_may_be() {
        let mut state = state([1, 1], 1);
        assert_eq!(image_count(&state), 3);
        state.min_image_count = 4;
        assert_eq!(image_count(&state), 5);
        state.max_image_count = 4;
        assert_eq!(image_count(&state), 4);
    }

    #[test]
    fn frames_are_never_encoded_twice() {
        let bgra = vk::Format::B8G8R8A8_UNORM;
        let srgb = vk::Format::B8G8R8A8_SRGB;
        assert_eq!(format(&[offer(srgb), offer(bgra)]).unwrap(), bgra);
        let rgba = vk::Format::R8G8B8A8_UNORM;
        assert_eq!(format(&[offer(srgb), offer(rgba)]).unwrap(), rgba);
        assert_eq!(format(&[offer(vk::Format::UNDEFINED)]).unwrap(), bgra);
        let wide = vk::SurfaceFormatKHR {
            color_space: vk::ColorSpaceKHR::HDR10_ST2084_EXT,
            ..offer(bgra)
        };
        let error = format(&[offer(srgb), wide]).unwrap_err().to_string();
        assert!(error.contains("B8G8R8A8_SRGB") && error.contains("HDR10"), "{error}");
    }

    #[test]
    fn what_must_be_chosen_is_chosen_from_what_is_there() {
        let mut state = state([1, 1], 1);
        state.supported_composite_alpha = vk::CompositeAlphaFlagsKHR::INHERIT;
        state.supported_transforms = vk::SurfaceTransformFlagsKHR::ROTATE_90;
        state.current_transform = vk::SurfaceTransformFlagsKHR::ROTATE_90;
        assert_eq!(alpha(&state), vk::CompositeAlphaFlagsKHR::INHERIT);
        assert_eq!(transform(&state), vk::SurfaceTransformFlagsKHR::ROTATE_90);
        state.supported_composite_alpha |= vk::CompositeAlphaFlagsKHR::OPAQUE;
        state.supported_transforms |= vk::SurfaceTransformFlagsKHR::IDENTITY;
        assert_eq!(alpha(&state), vk::CompositeAlphaFlagsKHR::OPAQUE);
        assert_eq!(transform(&state), vk::SurfaceTransformFlagsKHR::IDENTITY);
    }
}
