//! Seeded scenes and camera paths, including awkward ones.

use antumbra_cull::{Aabb, Camera, ClipY, CullView, DepthConvention, Projection};
use glam::{Vec2, Vec3};

use crate::image::Shift;
use crate::optics::Optics;
use crate::random::Random;

/// A scene: the objects' bounding boxes, the solids in them, and their shifts by the sub-pixel
/// grid.
pub struct Scene {
    pub bounds: Vec<Aabb>,
    pub solids: Vec<Aabb>,
    pub shifts: Vec<Shift>,
}

impl Scene {
    pub fn random(random: &mut Random, sub_pixel_bits: u32) -> Self {
        let count = 1 + random.below(70);
        let bounds: Vec<Aabb> = match random.below(6) {
            0 => (0..count).map(|_| cube(random.point(-20.0, 20.0), random)).collect(),
            1 => city(random, 7),
            2 => wall_and_clutter(random, count),
            3 => row(count),
            4 => vec![Aabb::new(Vec3::splat(-2.0), Vec3::splat(1.0)); count],
            _ => flat(random, count),
        };
        let step = 0.5_f32.powi(sub_pixel_bits as i32);
        let solids = bounds.iter().map(|bounds| shrunken(bounds, random)).collect();
        let shifts =
            bounds.iter().map(|_| [0, 1].map(|_| f64::from(random.between(-step, step)))).collect();
        Self { bounds, solids, shifts }
    }

    /// Returns the scene at a place.
    pub fn placed(self, place: Place) -> Self {
        let all = |boxes: Vec<Aabb>| boxes.iter().map(|bounds| place.bounds(bounds)).collect();
        Self { bounds: all(self.bounds), solids: all(self.solids), shifts: self.shifts }
    }

    /// Creates a scene of solids that fill their bounding boxes, without shifts.
    pub fn solid(bounds: Vec<Aabb>) -> Self {
        Self { solids: bounds.clone(), shifts: vec![[0.0; 2]; bounds.len()], bounds }
    }

    /// Moves an object by a random distance and returns its index.
    pub fn move_one(&mut self, random: &mut Random) -> usize {
        let object = random.below(self.bounds.len());
        let offset = random.point(-3.0, 3.0);
        for bounds in [&mut self.bounds[object], &mut self.solids[object]] {
            *bounds = Aabb::new(bounds.min + offset, bounds.max + offset);
        }
        object
    }
}

/// A position in the world, and the scale of the scene there.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The position of the origin of a scene (metres).
    pub origin: Vec3,
    /// The length of one metre of a scene (metres).
    pub scale: f32,
}

impl Place {
    /// The origin, at the original scale.
    pub const HERE: Self = Self { origin: Vec3::ZERO, scale: 1.0 };

    pub fn bounds(&self, bounds: &Aabb) -> Aabb {
        let [min, max] = [bounds.min, bounds.max].map(|corner| corner * self.scale + self.origin);
        Aabb::new(min, max)
    }

    pub fn camera(&self, camera: &Camera) -> Camera {
        let projection = match camera.projection {
            Projection::Orthographic { height, far } => {
                Projection::Orthographic { height: height * self.scale, far: far * self.scale }
            }
            perspective @ Projection::Perspective { .. } => perspective,
        };
        Camera {
            eye: camera.eye * self.scale + self.origin,
            near: camera.near * self.scale,
            projection,
            ..*camera
        }
    }
}

pub fn cube(centre: Vec3, random: &mut Random) -> Aabb {
    let half = random.point(0.2, 3.0);
    Aabb::new(centre - half, centre + half)
}

/// Returns blocks of different heights on a grid, with small objects between.
pub fn city(random: &mut Random, side: usize) -> Vec<Aabb> {
    let mut boxes = Vec::new();
    for x in 0..side {
        for z in 0..side {
            let corner = Vec3::new(x as f32, 0.0, z as f32) * 8.0 - side as f32 * 4.0;
            let corner = corner.with_y(0.0);
            let size = Vec3::new(5.5, random.between(4.0, 14.0), 5.5);
            boxes.push(Aabb::new(corner, corner + size));
            if random.chance(0.4) {
                let prop = corner + Vec3::new(6.5, 0.0, random.between(0.0, 7.0));
                boxes.push(Aabb::new(prop, prop + random.point(0.3, 0.9)));
            }
        }
    }
    boxes
}

fn wall_and_clutter(random: &mut Random, count: usize) -> Vec<Aabb> {
    let wall = Aabb::new(Vec3::new(-15.0, -15.0, -6.0), Vec3::new(15.0, 15.0, -5.0));
    let clutter = (1..count).map(|_| {
        let centre = random.point(-12.0, 12.0) - Vec3::Z * 14.0;
        cube(centre, random)
    });
    std::iter::once(wall).chain(clutter).collect()
}

/// Returns equal boxes at equal distances that touch: ties everywhere, coplanar faces.
fn row(count: usize) -> Vec<Aabb> {
    (0..count)
        .map(|number| {
            let corner = Vec3::new(number as f32 % 8.0, 0.0, -(number as f32 / 8.0).floor());
            Aabb::new(corner * 2.0, corner * 2.0 + 2.0)
        })
        .collect()
}

/// Returns boxes without thickness, and boxes without any size.
fn flat(random: &mut Random, count: usize) -> Vec<Aabb> {
    (0..count)
        .map(|number| {
            let mut bounds = cube(random.point(-12.0, 12.0), random);
            bounds.max[number % 3] = bounds.min[number % 3];
            if number % 7 == 0 {
                bounds.max = bounds.min;
            }
            bounds
        })
        .collect()
}

/// Returns a solid that fills a part of a bounding box, or the whole box.
fn shrunken(bounds: &Aabb, random: &mut Random) -> Aabb {
    if random.chance(0.4) {
        return *bounds;
    }
    let half = bounds.half_extent() * random.between(0.4, 1.0);
    let solid = Aabb::new(bounds.centre() - half, bounds.centre() + half);
    Aabb::new(solid.min.max(bounds.min), solid.max.min(bounds.max))
}

/// A path of the camera.
#[derive(Clone, Copy, Debug)]
pub enum Path {
    Still,
    Forward,
    Turning,
    /// Another position every few frames.
    Cuts,
    /// A walk through everything, including boxes.
    Wander,
}

pub const PATHS: [Path; 5] = [Path::Still, Path::Forward, Path::Turning, Path::Cuts, Path::Wander];

impl Path {
    pub fn start(random: &mut Random) -> Camera {
        Camera {
            eye: random.point(-14.0, 14.0).with_y(1.7),
            forward: looking(random),
            up: Vec3::Y,
            projection: Projection::perspective(random.between(0.5, 1.6)),
            near: [0.01, 0.1, 1.0][random.below(3)],
        }
    }

    pub fn advance(self, camera: &mut Camera, frame: u64, random: &mut Random) {
        match self {
            Self::Still => {}
            Self::Forward => camera.eye += camera.forward * 0.3,
            Self::Turning => {
                let visit = glam::Quat::from_rotation_y(random.between(0.02, 0.2));
                camera.forward = visit * camera.forward;
            }
            Self::Cuts => {
                if frame % 5 == 4 {
                    camera.eye = random.point(-16.0, 16.0);
                    camera.forward = looking(random);
                }
            }
            Self::Wander => {
                camera.eye += random.point(-0.8, 0.8);
                camera.forward += random.point(-0.1, 0.1);
            }
        }
    }
}

/// The source of a view: the camera itself, or the matrix of a host.
#[derive(Clone, Copy, Debug)]
pub enum Lens {
    Camera,
    Matrix(Optics),
}

impl Lens {
    /// Returns any kind of projection at random. In every other case the camera becomes
    /// orthographic.
    pub fn random(random: &mut Random, camera: &mut Camera) -> Self {
        if random.chance(0.5) {
            let height = random.between(4.0, 40.0);
            camera.projection =
                Projection::Orthographic { height, far: random.between(30.0, 80.0) };
        }
        if random.chance(0.3) {
            return Self::Camera;
        }
        let far = random.between(10.0, 60.0);
        Self::Matrix(Optics {
            depth: [DepthConvention::Reversed, DepthConvention::Standard][random.below(2)],
            y: [ClipY::Down, ClipY::Up][random.below(2)],
            far: [None, Some(far)][random.below(2)],
            off_centre: [Vec2::ZERO, random.point(-0.8, 0.8).truncate()][random.below(2)],
            jitter: [0.0, 0.7][random.below(2)],
            scale: [1.0, random.between(0.1, 10.0)][random.below(2)],
        })
    }

    /// Returns the same kind of view for a scene of another size.
    pub fn scaled(self, scale: f32) -> Self {
        match self {
            Self::Camera => Self::Camera,
            Self::Matrix(optics) => {
                Self::Matrix(Optics { far: optics.far.map(|far| far * scale), ..optics })
            }
        }
    }

    pub fn view(&self, camera: &Camera, frame: u64, size: [u32; 2], bits: u32) -> CullView {
        match self {
            Self::Camera => CullView::new(camera, size, bits),
            Self::Matrix(optics) => optics.view(camera, frame, size, bits),
        }
    }
}

fn looking(random: &mut Random) -> Vec3 {
    let angle = random.between(0.0, std::f32::consts::TAU);
    Vec3::new(angle.cos(), random.between(-0.3, 0.3), angle.sin())
}
