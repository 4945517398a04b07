//! Sprites: points and lines. A scene may have millions of them: each end takes 16 bytes, and there
//! are no triangles.

use cull::Aabb;
use glam::Vec3;

use super::mesh::MeshId;

/// The most sprites of a mesh: single precision holds their indices exactly, and boxes stay small.
pub const MAX_SPRITES: usize = 1 << 16;

/// The distance by which the box around the ends grows to hold the sprites, per metre of the
/// radius: a little more than half the diagonal of a square with sides of 2.
const REACH: f32 = 1.4143;

/// A point, or an end of a line.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SpriteEnd {
    /// Position in metres, in the space of the mesh.
    pub position: [f32; 3],
    /// The colour as a whole number below 2^24; see [`pack_sprite_colour`].
    pub colour: f32,
}

const _: () = assert!(size_of::<SpriteEnd>() == 16);

/// The shape of sprites.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SpriteShape {
    /// Points: each has one end.
    Point,
    /// Lines: each has two ends, one after the other.
    Line,
}

impl SpriteShape {
    /// Returns the number of ends of a sprite.
    pub fn ends(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Line => 2,
        }
    }
}

/// A mesh of points or lines, drawn as squares and bars that face the camera. The mesh itself has
/// neither vertices nor triangles, and its bounds are [`Sprites::bounds`]. Transparent objects must
/// not use it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sprites {
    /// The mesh of the scene that the sprites stand for.
    pub mesh: MeshId,
    /// The shape of all sprites of the mesh: points or lines.
    pub shape: SpriteShape,
    /// Half of their width, in the space of the mesh, in metres.
    pub radius_m: f32,
    /// The positions of points, or both ends of each line.
    pub ends: Vec<SpriteEnd>,
    /// A unit vector per end, for lit materials; empty for unlit ones.
    pub normals: Vec<[f32; 3]>,
}

impl Sprites {
    /// Returns the number of sprites.
    pub fn count(&self) -> usize {
        self.ends.len() / self.shape.ends()
    }

    /// Returns the box around the drawn sprites, seen from any direction.
    pub fn bounds(&self) -> Aabb {
        let points = self.ends.iter().map(|end| Vec3::from_array(end.position));
        let all = points.fold(Aabb::EMPTY, |all, point| all.union(&Aabb::new(point, point)));
        if all.is_empty() {
            return Aabb { min: Vec3::ZERO, max: Vec3::ZERO };
        }
        let reach = Vec3::splat(self.radius_m * REACH);
        Aabb { min: all.min - reach, max: all.max + reach }
    }

    /// Returns the fault of the sprites, if there is one.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let is_whole = |colour: f32| (0.0..16_777_216.0).contains(&colour) && colour.fract() == 0.0;
        let is_end = |end: &SpriteEnd| {
            end.position.iter().all(|part| part.is_finite()) && is_whole(end.colour)
        };
        if self.ends.is_empty() || !self.ends.len().is_multiple_of(self.shape.ends()) {
            Some("it has not as many ends as its sprites need")
        } else if self.count() > MAX_SPRITES {
            Some("it has more sprites than a mesh may have")
        } else if !self.normals.is_empty() && self.normals.len() != self.ends.len() {
            Some("it has not as many normals as ends")
        } else if !self.ends.iter().all(is_end) {
            Some("an end has a number that is none")
        } else if !self.normals.as_flattened().iter().all(|part| part.is_finite()) {
            Some("a normal is not a finite number")
        } else if !(self.radius_m.is_finite() && self.radius_m >= 0.0) {
            Some("its radius is not a finite length")
        } else {
            None
        }
    }
}

/// Packs a linear colour of `0.0..=1.0`: the square root of each part in 8 bits, red in the lowest
/// ones.
pub fn pack_sprite_colour(linear: [f32; 3]) -> f32 {
    let bits = |part: f32| (part.clamp(0.0, 1.0).sqrt() * 255.0).round() as u32;
    let [red, green, blue] = linear.map(bits);
    (red | green << 8 | blue << 16) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> Sprites {
        let end = |x: f32| SpriteEnd { position: [x, 0.0, 0.0], colour: 7.0 };
        Sprites {
            mesh: MeshId(0),
            shape: SpriteShape::Line,
            radius_m: 0.5,
            ends: vec![end(-1.0), end(3.0)],
            normals: Vec::new(),
        }
    }

    #[test]
    fn boxes_hold_what_is_drawn_around_the_ends() {
        let bounds = line().bounds();
        assert!(bounds.min.x < -1.707 && bounds.max.x > 3.707 && bounds.max.x < 3.708);
        assert!(bounds.max.y > 0.707);
        assert_eq!(line().count(), 1);
    }

    #[test]
    fn colours_are_whole_numbers_and_dark_ones_are_told_apart() {
        assert_eq!(pack_sprite_colour([1.0; 3]), 16_777_215.0);
        assert_eq!(pack_sprite_colour([0.0, 0.0, 2.0]), 16_711_680.0);
        assert!(pack_sprite_colour([0.0005, 0.0, 0.0]) > pack_sprite_colour([0.0002, 0.0, 0.0]));
    }

    #[test]
    fn what_cannot_be_drawn_is_found() {
        assert_eq!(line().fault(), None);
        let broken: [fn(&mut Sprites); 5] = [
            |sprites| sprites.ends.truncate(1),
            |sprites| sprites.ends[1].position[2] = f32::NAN,
            |sprites| sprites.ends[0].colour = 0.5,
            |sprites| sprites.radius_m = -1.0,
            |sprites| sprites.normals.push([0.0; 3]),
        ];
        for change in broken {
            let mut sprites = line();
            change(&mut sprites);
            assert!(sprites.fault().is_some());
        }
    }
}
