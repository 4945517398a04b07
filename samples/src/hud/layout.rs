//! The size of points in an image, and the parts of the panel that fit.

use super::panel;

/// The largest share of the image's width that the panel covers.
pub const PANEL_SHARE: f32 = 0.25;
/// The width of the whole panel, in points.
const FULL_WIDTH: f32 = 232.0;
/// The widths of the panel with only the most important numbers, in points.
const NARROW_WIDTH: [f32; 2] = [62.0, 120.0];
/// The size of an image from which on a point has its normal size in the window.
const USUAL_SIZE: [f32; 2] = [960.0, 540.0];
/// The smallest factor of points, before parts are left out.
const SMALLEST: f32 = 0.66;

/// The parts of the panel that fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Room {
    /// Everything: the overview and the details below it.
    Full,
    /// The most important numbers.
    Narrow,
    /// Nothing: the window is too small for text.
    None,
}

/// The measures of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// The pixels per point.
    pub scale: f32,
    /// The parts of the panel that fit.
    pub room: Room,
    /// The width of the panel, in points.
    pub panel_width: f32,
}

impl Measures {
    /// Returns the measures of an image of `size` pixels whose window has `window_scale` pixels
    /// per point.
    pub fn of(size: [u32; 2], window_scale: f32) -> Self {
        let window_scale =
            if window_scale.is_finite() { window_scale.clamp(0.5, 8.0) } else { 1.0 };
        let shares = [0, 1].map(|side| size[side] as f32 / window_scale / USUAL_SIZE[side]);
        let share = shares[0].min(shares[1]);
        // Large images have larger letters, and more room beside the panel.
        let zoom = if share > 1.0 { share.sqrt() } else { share.max(SMALLEST) };
        let scale = window_scale * zoom;
        let widest = size[0] as f32 * PANEL_SHARE / scale;
        let (room, panel_width) = match widest {
            _ if widest >= FULL_WIDTH => (Room::Full, FULL_WIDTH),
            _ if widest >= NARROW_WIDTH[0] => (Room::Narrow, widest.min(NARROW_WIDTH[1])),
            _ => (Room::None, 0.0),
        };
        Self { scale, room, panel_width }
    }

    /// Returns the share of the image's width that the panel covers.
    pub fn covered_share(&self, size: [u32; 2]) -> f32 {
        (self.panel_width * self.scale / size[0].max(1) as f32).clamp(0.0, PANEL_SHARE)
    }

    /// Returns the width between the panel's margins, in points.
    pub fn inner_width(&self) -> f32 {
        self.panel_width - 2.0 * f32::from(panel::MARGINS[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_panel_covers_a_quarter_of_the_width_at_most() {
        for width in (1..4000).step_by(7) {
            for height in [1, 90, 360, 540, 1080, 4000] {
                for window_scale in [0.5, 1.0, 1.25, 2.0, f32::NAN] {
                    let measures = Measures::of([width, height], window_scale);
                    let pixels = measures.panel_width * measures.scale;
                    assert!(pixels <= width as f32 * PANEL_SHARE + 0.01, "{width}: {measures:?}");
                    assert!(measures.covered_share([width, height]) <= PANEL_SHARE);
                }
            }
        }
    }

    #[test]
    fn usual_images_have_all_and_tiny_ones_nothing() {
        for size in [[640, 360], [960, 540], [1280, 720], [1920, 1080], [3840, 2160]] {
            let measures = Measures::of(size, 1.0);
            assert_eq!(measures.room, Room::Full, "{size:?}: {measures:?}");
        }
        assert_eq!(Measures::of([1920, 1080], 2.0).room, Room::Full);
        assert_eq!(Measures::of([320, 180], 1.0).room, Room::Narrow);
        assert_eq!(Measures::of([100, 80], 1.0).room, Room::None);
        let [small, large] =
            [[960, 540], [1920, 1080]].map(|size| Measures::of(size, 1.0).covered_share(size));
        assert!(large < small, "{large} {small}");
    }
}
