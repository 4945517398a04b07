//! The last step of a frame: the copy from the target to an image of the window.

use ash::vk;

use crate::record::access::{Access, LayoutChange, MemoryBarrier};
use crate::record::commands::Commands;
use crate::record::target::Target;

/// Copies the frame of `target` to an image of a window, byte for byte if their sizes are equal. A
/// frame of another shape keeps its proportions, in the middle between black borders. Restores the
/// layout of the target, since these commands may never be submitted.
pub(crate) fn copy_to_window(
    target: &Target,
    commands: &Commands,
    window: vk::Image,
    window_size: [u32; 2],
) {
    if commands.check_owner(target).is_err() {
        return;
    }
    let colour = vk::ImageAspectFlags::COLOR;
    let (Some((image, drawn)), read) = (target.colour(), Access::CopyRead) else { return };
    let is_drawn = drawn != read;
    let fresh = LayoutChange::forgetting(window, colour, &[Access::CopyWrite], Access::CopyWrite);
    if is_drawn {
        commands.change_layouts([LayoutChange::new(image, colour, drawn, read), fresh])
    } else {
        commands.change_layouts([fresh])
    }
    let [from, to] = fitted(target.size(), window_size);
    if [from, to] != [[0; 2], window_size] {
        clear(commands, window);
    }
    let layers =
        vk::ImageSubresourceLayers { aspect_mask: colour, layer_count: 1, ..Default::default() };
    let corner = |[x, y]: [u32; 2], z| vk::Offset3D { x: x as i32, y: y as i32, z };
    let regions = [vk::ImageBlit::default()
        .src_subresource(layers)
        .src_offsets([corner([0; 2], 0), corner(target.size(), 1)])
        .dst_subresource(layers)
        .dst_offsets([corner(from, 0), corner(to, 1)])];
    let filter = if [to[0] - from[0], to[1] - from[1]] == target.size() {
        vk::Filter::NEAREST
    } else {
        vk::Filter::LINEAR
    };
    // SAFETY: both images are in the given layouts and contain the regions; creating the swapchain
    // checked that the formats support blits.
    unsafe {
        commands.device().raw().cmd_blit_image(
            commands.raw(),
            image,
            vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
            window,
            vk::ImageLayout::TRANSFER_DST_OPTIMAL,
            &regions,
            filter,
        );
    }
    let shown = LayoutChange::new(window, colour, Access::CopyWrite, Access::Present);
    if is_drawn {
        commands.change_layouts([LayoutChange::new(image, colour, read, drawn), shown])
    } else {
        commands.change_layouts([shown])
    }
}

/// Clears an image of a window to black. The image stays in the layout of a copy destination.
fn clear(commands: &Commands, window: vk::Image) {
    let black = vk::ClearColorValue { float32: [0.0, 0.0, 0.0, 1.0] };
    let whole = vk::ImageSubresourceRange {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        level_count: 1,
        layer_count: 1,
        ..Default::default()
    };
    // SAFETY: the image is a copy destination in the given layout.
    unsafe {
        commands.device().raw().cmd_clear_color_image(
            commands.raw(),
            window,
            vk::ImageLayout::TRANSFER_DST_OPTIMAL,
            &black,
            &[whole],
        );
    }
    commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::CopyWrite]));
}

/// Returns the upper left and lower right corner (pixels) of the largest centred area of `window`
/// with the proportions of `frame`, up to rounding; at least one pixel. No side may be 0.
fn fitted(frame: [u32; 2], window: [u32; 2]) -> [[u32; 2]; 2] {
    let [[width, height], limits] = [frame, window].map(|size| size.map(u64::from));
    let scaled = |side: u64, to: u64, of: u64| ((side * to + of / 2) / of.max(1)).max(1);
    let size = if width * limits[1] > height * limits[0] {
        [limits[0], scaled(height, limits[0], width)]
    } else {
        [scaled(width, limits[1], height), limits[1]]
    };
    let size: [u32; 2] = std::array::from_fn(|side| size[side].min(limits[side]) as u32);
    let from: [u32; 2] = std::array::from_fn(|side| (window[side] - size[side]) / 2);
    [from, std::array::from_fn(|side| from[side] + size[side])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_keeps_its_proportions_in_windows_of_any_shape() {
        for (frame, window, area) in [
            ([1280, 720], [1280, 720], [[0, 0], [1280, 720]]),
            ([1280, 720], [640, 360], [[0, 0], [640, 360]]),
            ([1280, 720], [1281, 720], [[0, 0], [1280, 720]]),
            ([1280, 720], [720, 720], [[0, 157], [720, 562]]),
            ([1280, 720], [2000, 720], [[360, 0], [1640, 720]]),
            ([100, 100], [31, 900], [[0, 434], [31, 465]]),
            ([16384, 1], [5, 5], [[0, 2], [5, 3]]),
            ([1, 16384], [5, 5], [[2, 0], [3, 5]]),
            ([u32::MAX, 1], [1, u32::MAX], [[0, u32::MAX / 2], [1, u32::MAX / 2 + 1]]),
        ] {
            assert_eq!(fitted(frame, window), area, "{frame:?} in {window:?}");
        }
    }
}
