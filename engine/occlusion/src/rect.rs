//! Rectangles of pixels.

use cull::CullView;

/// A rectangle of pixels in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// The upper left corner (pixels from the upper left corner of the image).
    pub origin: [u32; 2],
    /// The width and height (pixels).
    pub size: [u32; 2],
}

impl Rect {
    /// Returns the whole of an image of `size` pixels.
    pub fn whole(size: [u32; 2]) -> Self {
        Self { origin: [0, 0], size }
    }

    /// Returns true if the rectangle is not empty and lies within an image of `size` pixels.
    pub fn fits(&self, size: [u32; 2]) -> bool {
        let fits = |side: usize| {
            let end = u64::from(self.origin[side]) + u64::from(self.size[side]);
            self.size[side] > 0 && end <= u64::from(size[side])
        };
        fits(0) && fits(1)
    }

    /// Returns the part of the image that a view is drawn to.
    pub fn of(view: &CullView) -> Self {
        Self { origin: view.origin, size: view.size }
    }

    /// Returns `count` parts side by side, from the left, that cover an image of `size` pixels.
    /// Their widths differ by at most a pixel. Parts without pixels have a width of 0.
    pub fn side_by_side(size: [u32; 2], count: u32) -> impl Iterator<Item = Self> {
        let [width, height] = size;
        let edge =
            move |part: u32| (u64::from(width) * u64::from(part) / u64::from(count.max(1))) as u32;
        (0..count).map(move |part| Self {
            origin: [edge(part), 0],
            size: [edge(part + 1) - edge(part), height],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_side_by_side_cover_the_image() {
        for width in 0..20 {
            for count in 1..5 {
                let areas: Vec<Rect> = Rect::side_by_side([width, 7], count).collect();
                let mut next = 0;
                for area in &areas {
                    assert_eq!((area.origin, area.size[1]), ([next, 0], 7));
                    assert!(area.size[0].abs_diff(width / count) <= 1);
                    next += area.size[0];
                }
                assert_eq!((areas.len() as u32, next), (count, width));
            }
        }
        let whole = Rect { origin: [0, 0], size: [9, 4] };
        assert!(Rect::side_by_side([9, 4], 1).eq([whole]));
    }
}
