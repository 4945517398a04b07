//! The pixels in which two images differ, and their areas.

/// The side, in pixels, of the tiles in which images are compared.
const TILE_PIXELS: usize = 16;
/// The most areas; further ones are merged into one.
const MOST_AREAS: usize = 48;

/// A rectangle of pixels: left, top, right and bottom edge.
pub type PixelArea = [u32; 4];

/// The differences between two images.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Differences {
    /// The number of pixels that are not identical.
    pub pixels: u64,
    /// Areas that contain all of these pixels, to the tile.
    pub areas: Vec<PixelArea>,
}

impl Differences {
    /// Compares two images of `width` pixels per row, four bytes per pixel. If their lengths
    /// differ, every pixel that only one of them has counts as different.
    pub fn between(a: &[u8], b: &[u8], width: u32) -> Self {
        if a == b || width == 0 {
            return Self::default();
        }
        let width = width as usize;
        let a = a.as_chunks::<4>().0;
        let b = b.as_chunks::<4>().0;
        let rows = a.len().max(b.len()).div_ceil(width);
        let tiles = width.div_ceil(TILE_PIXELS);
        let mut found = Self::default();
        let mut is_marked = vec![false; tiles];
        for (number, first) in (0..rows).step_by(TILE_PIXELS).enumerate() {
            is_marked.fill(false);
            for place in first * width..((first + TILE_PIXELS).min(rows)) * width {
                if a.get(place) != b.get(place) {
                    found.pixels += 1;
                    is_marked[place % width / TILE_PIXELS] = true;
                }
            }
            let bottom = (first + TILE_PIXELS).min(rows);
            let top = number * TILE_PIXELS;
            found.add_runs(&is_marked, width, top as u32, bottom as u32);
        }
        if found.areas.len() > MOST_AREAS {
            let around = found.areas.iter().copied().reduce(union);
            found.areas = around.into_iter().collect();
        }
        found
    }

    /// Adds the marked tiles of a row. Neighbours become one area, which extends an area of equal
    /// width above.
    fn add_runs(&mut self, is_marked: &[bool], width: usize, top: u32, bottom: u32) {
        let mut tile = 0;
        while tile < is_marked.len() {
            let end = tile + is_marked[tile..].iter().take_while(|is_marked| **is_marked).count();
            if end > tile {
                let sides = [tile * TILE_PIXELS, (end * TILE_PIXELS).min(width)];
                let [left, right] = sides.map(|side| side as u32);
                let continued = self.areas.iter_mut().find(|[other_left, _, other_right, edge]| {
                    (*other_left, *other_right, *edge) == (left, right, top)
                });
                match continued {
                    Some(area) => area[3] = bottom,
                    None => self.areas.push([left, top, right, bottom]),
                }
            }
            tile = end + 1;
        }
    }
}

fn union(a: PixelArea, b: PixelArea) -> PixelArea {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SIZE: [usize; 2] = [100, 40];

    fn image(changed: &[[usize; 2]]) -> Vec<u8> {
        let mut bytes = vec![7; SIZE[0] * SIZE[1] * 4];
        changed.iter().for_each(|[x, y]| bytes[(y * SIZE[0] + x) * 4 + 2] = 8);
        bytes
    }

    fn between(changed: &[[usize; 2]]) -> Differences {
        Differences::between(&image(&[]), &image(changed), SIZE[0] as u32)
    }

    #[test]
    fn equal_images_differ_in_nothing() {
        assert_eq!(between(&[]), Differences::default());
    }

    #[test]
    fn neighbours_are_one_area_and_edges_are_kept() {
        let found = between(&[[3, 3], [17, 4], [18, 20]]);
        assert_eq!(found.areas, [[0, 0, 32, 16], [16, 16, 32, 32]]);
        // The last tile on each side is cut by the image.
        assert_eq!(between(&[[99, 39]]).areas, [[96, 32, 100, 40]]);
        // Tiles below each other with equal width form one area.
        assert_eq!(between(&[[50, 1], [50, 17], [50, 39]]).areas, [[48, 0, 64, 40]]);
    }

    #[test]
    fn what_one_image_lacks_differs() {
        let whole = image(&[]);
        let found = Differences::between(&whole, &whole[..whole.len() - 8], SIZE[0] as u32);
        assert_eq!(found.pixels, 2);
    }

    proptest! {
            #[test]
            fn every_changed_pixel_is_counted_and_in_an_area(
                changed in prop::collection::btree_set((0..SIZE[0], 0..SIZE[1]), 0..300)
            ) {
                let changed: Vec<[usize; 2]> = changed.into_iter().map(|(x, y)| [x, y]).collect();
                let found = between(&changed);
                prop_assert_eq!(found.pixels, changed.len() as u64);
                for [x, y] in changed {
                    let x = x as u32;
    let y = y as u32;
                    let holds = |[left, top, right, bottom]: &PixelArea| {
                        (left..right).contains(&&x) && (top..bottom).contains(&&y)
                    };
                    prop_assert!(found.areas.iter().any(holds));
                }
            }
        }
}
