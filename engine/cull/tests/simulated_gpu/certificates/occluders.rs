//! The images of certificates.
//!
//! # Solids, shrunk
//! Let a solid, shrunk by `e`, meet the segment from `p` to `x` at the point `o`, at the share `t`
//! of the way. For an eye `q` with `|q - p| <= r`, the segment from `q` to `x` is at the same share
//! at `o + (1 - t) (q - p)`, within `r` of `o`. If `r <= e`, this point is inside of the solid, so
//! `x` is hidden from `q` too (Wonka, Wimmer, Schmalstieg 2000). Different points of a box may be
//! hidden by different solids. A pixel counts only if one shrunk solid covers all of it: if the
//! solid, which is convex, covers its four corners. The inverse depth of the solid's front is the
//! least of linear functions, so it is least at a corner. Everything in the pixel beyond that depth
//! is hidden, from every eye within `r` and in every direction of sight.
//!
//! Later frames sample the solids on another grid, and snap vertices. By the proof of
//! [`Margin`](antumbra_cull::Margin), it is enough that the solids lose the margin of a proxy too:
//! `e = r + margin`. A solid that the near plane may cut for some eye hides nothing.
//!
//! # Surfaces, eroded
//! If no solids are known, the front of an object in the depth image is a surface. Going back from
//! `x`, which lies behind the surface, to `q`, which lies before it, the segment crosses the
//! surface, unless it leaves the part of the image in which the surface is known to be whole. At
//! the view depth `z` the segment is at most `r f / (z cos a)` pixels away from `x` in the image of
//! `p`; `f` is the focal length in pixels, and `a` the angle between `x` and the middle of the
//! image. It leaves a window of `R` pixels behind the surface only at a depth beyond the nearest
//! depth `z` of the surface in the window. So `x` stays hidden if `R >= r f / (z cos a)`, and if
//! all of the window shows this one surface. An image tells this only of convex objects, or with
//! the identity of each triangle: depths alone do not show a gap between two samples.

use antumbra_cull::{Aabb, Camera, CullView, Projection};
use glam::{DVec2, DVec3};

use super::{Along, Certificate, HALF_DIAGONAL, Pixels, Slabs, farthest_m};

/// The number of a pixel that shows no object, or several.
const NONE: u32 = u32::MAX;

/// The circumstances of a certificate.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// The eyes that it holds for are within this distance (metres).
    pub radius_m: f32,
    /// The size of its image (pixels).
    pub size: [u32; 2],
    /// The share by which its image is wider and higher than the view.
    pub guard: f32,
    /// The margin of proxies in later frames, where w is 1 (metres).
    pub margin_m: f32,
}

impl Setting {
    fn view(&self, camera: &Camera) -> CullView {
        let larger = 1.0 + self.guard;
        let Projection::Perspective { fov_y } = camera.projection else {
            panic!("certificates are for perspective views")
        };
        let fov_y = 2.0 * ((fov_y * 0.5).tan() * larger).atan();
        let camera = Camera { projection: Projection::perspective(fov_y), ..*camera };
        CullView::new(&camera, self.size.map(|side| (side as f32 * larger) as u32), 8)
    }

    /// Returns the distance by which a solid must be shrunk.
    fn shrink_m(&self, solid: &Aabb, camera: &Camera) -> f32 {
        let rounding = 64.0 * f32::EPSILON * solid.largest_coordinate();
        let farthest_m = farthest_m(solid, camera.eye) + self.radius_m;
        self.radius_m + self.margin_m * farthest_m + rounding
    }

    /// Returns true if the near plane cuts a solid for no eye.
    fn is_beyond_near(&self, solid: &Aabb, camera: &Camera, view: &CullView) -> bool {
        let corner = view.rays.middle.abs() + view.rays.right.abs() + view.rays.down.abs();
        let near_m = camera.near * corner.length() * 1.05 + self.radius_m;
        solid.distance_squared(camera.eye) > near_m * near_m
    }
}

/// Returns the certificate of solids that are known as such.
pub fn shrunk_solids(setting: &Setting, camera: &Camera, solids: &[Aabb]) -> Certificate {
    let view = setting.view(camera);
    let mut image = vec![0.0; (view.size[0] * view.size[1]) as usize];
    let mut corners = Vec::new();
    for solid in solids {
        let shrunk = solid.enlarged(-setting.shrink_m(solid, camera));
        if shrunk.is_empty() || !setting.is_beyond_near(solid, camera, &view) {
            continue;
        }
        let Some(seen) = Seen::of(&view, &shrunk) else { continue };
        seen.sample(&mut corners);
        seen.each_pixel(&corners, |pixel, depths| {
            image[pixel] = depths.into_iter().fold(f64::INFINITY, f64::min).max(image[pixel]);
        });
    }
    Certificate { view, hidden_beyond: image, reach_pixels: HALF_DIAGONAL }
}

/// Returns the certificate of the surfaces that a view shows, each of one solid.
pub fn eroded_surfaces(setting: &Setting, camera: &Camera, solids: &[Aabb]) -> Certificate {
    let view = setting.view(camera);
    let surfaces = Surfaces::of(setting, camera, &view, solids);
    let along = Along::of(&view);
    let [width, height] = view.size.map(|side| side as usize);
    let distances = surfaces.distances_to_edges();
    let nearest = Largest::new(&surfaces.nearest, [width, height]);
    let mut image = vec![0.0; width * height];
    for (pixel, distance) in distances.iter().enumerate().filter(|(_, distance)| **distance > 0) {
        let column = pixel % width;
        let row = pixel / width;
        let middle = along.at(DVec2::new(column as f64 + 0.5, row as f64 + 0.5));
        // Between the middle of a pixel and its corners, `cos a` changes little.
        let eyes_m = f64::from(setting.radius_m) * middle.length() * (1.0 + 2.0 * along.pixel_m);
        let reach = |nearest: f64| {
            let margin_m = f64::from(setting.margin_m) * (2.0 / nearest);
            ((eyes_m + margin_m) * nearest / along.pixel_m + 1.0).ceil() as usize
        };
        let mut window = reach(surfaces.nearest[pixel]);
        while window <= *distance {
            let wished = reach(nearest.around([column, row], window));
            if wished <= window {
                image[pixel] = surfaces.farthest[pixel];
                break;
            }
            window = wished;
        }
    }
    Certificate { view, hidden_beyond: image, reach_pixels: HALF_DIAGONAL }
}

/// Returns what a single eye sees in the middles of pixels. No certificate of eyes that include
/// this one covers more, but for boxes between the middles of pixels.
pub fn seen_by_one_eye(camera: &Camera, size: [u32; 2], solids: &[Aabb]) -> Certificate {
    let view = CullView::new(camera, size, 8);
    let mut image = vec![0.0_f64; (size[0] * size[1]) as usize];
    let along = Along::of(&view);
    for solid in solids {
        let Some(seen) = Seen::of(&view, solid) else { continue };
        for row in seen.pixels.rows.clone() {
            for column in seen.pixels.columns.clone() {
                let middle = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                let depth = seen.slabs.inverse_depth(along.at(middle)).unwrap_or_default();
                let stored = &mut image[(row * size[0] + column) as usize];
                *stored = stored.max(depth);
            }
        }
    }
    Certificate { view, hidden_beyond: image, reach_pixels: 0.0 }
}

/// A solid in an image.
struct Seen {
    slabs: Slabs,
    pixels: Pixels,
    along: Along,
    width: u32,
}

impl Seen {
    /// Returns `None` for a solid outside of the image.
    fn of(view: &CullView, solid: &Aabb) -> Option<Self> {
        let [width, height] = view.size;
        let everything = Pixels {
            columns: 0..width,
            rows: 0..height,
            crossed: [true; 4],
            farthest_m: f64::INFINITY,
        };
        let is_behind = solid.corners().iter().all(|corner| view.clip(*corner).w <= 0.0);
        let pixels = Pixels::of(view, solid).unwrap_or(everything);
        let eye = view.rays.origin.as_dvec3();
        let slabs = Slabs { low: solid.min.as_dvec3() - eye, high: solid.max.as_dvec3() - eye };
        let is_seen = !is_behind && !pixels.columns.is_empty() && !pixels.rows.is_empty();
        is_seen.then_some(Self { slabs, pixels, along: Along::of(view), width })
    }

    /// Fills `corners` with the inverse depths at the corners of the pixels; 0 where the solid is
    /// missed.
    fn sample(&self, corners: &mut Vec<f64>) {
        corners.clear();
        for row in self.pixels.rows.start..=self.pixels.rows.end {
            for column in self.pixels.columns.start..=self.pixels.columns.end {
                let along = self.along.at(DVec2::new(column.into(), row.into()));
                corners.push(self.slabs.inverse_depth(along).unwrap_or_default());
            }
        }
    }

    /// Calls `each` for the pixels that the solid covers completely, with the inverse depths at the
    /// four corners.
    fn each_pixel(&self, corners: &[f64], mut each: impl FnMut(usize, [f64; 4])) {
        let Pixels { columns, rows, .. } = &self.pixels;
        let stride = columns.len() + 1;
        for (line, row) in rows.clone().enumerate() {
            for (place, column) in columns.clone().enumerate() {
                let first = line * stride + place;
                let depths =
                    [0, 1, stride, stride + 1].map(|corner: usize| corners[first + corner]);
                if depths.iter().all(|depth| *depth > 0.0) {
                    each((row * self.width + column) as usize, depths);
                }
            }
        }
    }
}

/// The surfaces in the pixels of a view, for pixels that show a single object.
struct Surfaces {
    width: usize,
    objects: Vec<u32>,
    /// The least inverse depth of the surface in the pixel.
    farthest: Vec<f64>,
    /// An upper bound of the inverse depth of the surface in the pixel.
    nearest: Vec<f64>,
}

impl Surfaces {
    fn of(setting: &Setting, camera: &Camera, view: &CullView, solids: &[Aabb]) -> Self {
        let [width, height] = view.size.map(|side| side as usize);
        let stride = width + 1;
        let mut shown = vec![NONE; stride * (height + 1)];
        let mut depths = vec![0.0; shown.len()];
        let mut corners = Vec::new();
        for (object, solid) in (0..).zip(solids) {
            let Some(seen) = Seen::of(view, solid) else { continue };
            seen.sample(&mut corners);
            let Pixels { columns, rows, .. } = &seen.pixels;
            let mut sampled = corners.iter();
            for row in rows.start..=rows.end {
                for column in columns.start..=columns.end {
                    let depth = sampled.next().copied().unwrap_or_default();
                    let corner = row as usize * stride + column as usize;
                    if depth > depths[corner] {
                        depths[corner] = depth;
                        shown[corner] = object;
                    }
                }
            }
        }
        let pixels = width * height;
        let mut surfaces = Self {
            width,
            objects: vec![NONE; pixels],
            farthest: vec![0.0; pixels],
            nearest: vec![f64::INFINITY; pixels],
        };
        let along = Along::of(view);
        let eye = view.rays.origin.as_dvec3();
        for pixel in 0..pixels {
            let first = pixel / width * stride + pixel % width;
            let corners = [0, 1, stride, stride + 1].map(|corner| first + corner);
            let object = shown[first];
            let is_one = object != NONE && corners.iter().all(|corner| shown[*corner] == object);
            let Some(solid) = solids.get(object as usize).filter(|_| is_one) else { continue };
            if !setting.is_beyond_near(solid, camera, view) {
                continue;
            }
            let slabs = Slabs { low: solid.min.as_dvec3() - eye, high: solid.max.as_dvec3() - eye };
            let fronts = corners.iter().map(|corner| {
                let position = DVec2::new((corner % stride) as f64, (corner / stride) as f64);
                slabs.inverse_fronts(along.at(position))
            });
            let nearest = fronts.fold(DVec3::NEG_INFINITY, DVec3::max).min_element();
            surfaces.objects[pixel] = object;
            surfaces.nearest[pixel] = nearest;
            let depths = corners.iter().map(|corner| depths[*corner]);
            surfaces.farthest[pixel] = depths.fold(f64::INFINITY, f64::min);
        }
        surfaces
    }

    /// Returns for each pixel the largest `n` for which all pixels within `n` rows and columns show
    /// the same object.
    fn distances_to_edges(&self) -> Vec<usize> {
        let width = self.width;
        let height = self.objects.len() / width;
        let mut distances = vec![0; self.objects.len()];
        // A square of side 2 n + 1 is one more than the least of the squares around its neighbours.
        // Two passes find the distance to the nearest pixel that differs from a neighbour.
        let is_whole = |pixel: usize| {
            let object = self.objects[pixel];
            let around = [pixel - width - 1, pixel - 1, pixel + width - 1];
            let rows = around.into_iter().flat_map(|first| first..first + 3);
            object != NONE && rows.into_iter().all(|other| self.objects[other] == object)
        };
        let inner = |pixel: usize| {
            let column = pixel % width;
            let row = pixel / width;
            column > 0 && row > 0 && column + 1 < width && row + 1 < height
        };
        let pixels = 0..self.objects.len();
        for pixel in pixels.clone().filter(|pixel| inner(*pixel)) {
            if is_whole(pixel) {
                let before = [pixel - width - 1, pixel - width, pixel - width + 1, pixel - 1];
                distances[pixel] = 1 + before
                    .map(|other| distances[other])
                    .into_iter()
                    .fold(usize::MAX - 1, usize::min);
            }
        }
        for pixel in pixels.rev().filter(|pixel| inner(*pixel)) {
            let after = [pixel + width + 1, pixel + width, pixel + width - 1, pixel + 1];
            let least =
                after.map(|other| distances[other]).into_iter().fold(usize::MAX - 1, usize::min);
            distances[pixel] = distances[pixel].min(least + 1);
        }
        distances
    }
}

/// The largest numbers in squares of pixels, by squares whose sides are powers of two.
struct Largest {
    size: [usize; 2],
    levels: Vec<Vec<f64>>,
}

impl Largest {
    fn new(numbers: &[f64], size: [usize; 2]) -> Self {
        let [width, height] = size;
        let mut levels = vec![numbers.to_vec()];
        let mut side = 1;
        while 2 * side <= width.min(height) {
            let below = &levels[levels.len() - 1];
            let at = |column: usize, row: usize| {
                below[row.min(height - 1) * width + column.min(width - 1)]
            };
            let level = (0..below.len()).map(|pixel| {
                let column = pixel % width;
                let row = pixel / width;
                let pairs = [
                    at(column, row).max(at(column + side, row)),
                    at(column, row + side).max(at(column + side, row + side)),
                ];
                pairs[0].max(pairs[1])
            });
            let level = level.collect();
            levels.push(level);
            side *= 2;
        }
        Self { size, levels }
    }

    /// Returns the largest number within `reach` columns and rows of a pixel; the square must be in
    /// the image.
    fn around(&self, middle: [usize; 2], reach: usize) -> f64 {
        let [width, _] = self.size;
        let side = 2 * reach + 1;
        let level = (side.ilog2() as usize).min(self.levels.len() - 1);
        let part = 1 << level;
        let first = middle.map(|place| place - reach);
        let last = first.map(|place| place + side - part);
        let rows = [first[1], last[1]];
        let numbers = rows.map(|row| {
            let row = &self.levels[level][row * width..];
            row[first[0]].max(row[last[0]])
        });
        numbers[0].max(numbers[1])
    }
}
