//! The area of images to draw to.

use ash::vk;

/// A viewport, with a scissor for the same pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewport {
    /// The left edge (pixels).
    pub x: f32,
    /// The upper edge (pixels), or the lower edge if the height is negative.
    pub y: f32,
    /// The width (pixels).
    pub width: f32,
    /// The height (pixels). A negative height flips the image vertically, as for matrices whose y
    /// points up.
    pub height: f32,
    /// The depth values for the depths 0 and 1 of clip space.
    pub depths: [f32; 2],
}

impl Viewport {
    /// Returns the viewport that covers an area of `size` pixels at `origin`.
    pub fn covering(origin: [u32; 2], size: [u32; 2]) -> Self {
        let [[x, y], [width, height]] = [origin, size].map(|pair| pair.map(|side| side as f32));
        Self { x, y, width, height, depths: [0.0, 1.0] }
    }

    pub(crate) fn raw(&self) -> vk::Viewport {
        let Self { x, y, width, height, depths: [min_depth, max_depth] } = *self;
        vk::Viewport { x, y, width, height, min_depth, max_depth }
    }

    /// Returns the pixels that the viewport covers.
    pub(crate) fn scissor(&self) -> vk::Rect2D {
        let top = self.y.min(self.y + self.height);
        let offset = vk::Offset2D { x: self.x as i32, y: top as i32 };
        let width = self.width as u32;
        let height = self.height.abs() as u32;
        vk::Rect2D { offset, extent: vk::Extent2D { width, height } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_viewport_upside_down_has_the_same_scissor() {
        let upright = Viewport::covering([3, 5], [40, 20]);
        let turned = Viewport { y: 25.0, height: -20.0, ..upright };
        assert_eq!(turned.scissor(), upright.scissor());
        assert_eq!(upright.scissor().extent, vk::Extent2D { width: 40, height: 20 });
    }
}
