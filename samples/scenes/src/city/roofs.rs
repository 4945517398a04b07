//! Roofs, and the objects on them.

use glam::{Affine3A, Vec2, Vec3, vec3};

use super::super::builder::{Faces, Frame, MeshBuilder, Paint, Panel, panel};
use super::super::random::Random;
use super::palette::Materials;

/// The shape of a roof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Roof {
    /// A parapet around gravel, with stair heads, air handlers and pipes.
    Flat,
    /// A flat roof with a water tank on legs.
    Tank,
    /// Tiles on four slopes, with chimneys.
    Hipped,
    /// Steep slate with dormers below a flat top.
    Mansard,
    /// Tiles on two slopes, the gables at the narrow sides.
    Gabled,
    /// A smaller storey that is set back, with a flat roof.
    Setback,
}

/// A roof on a box of half sizes `half`, whose walls end at `eaves_m`.
pub(super) struct RoofSite<'a> {
    pub(super) half: Vec2,
    pub(super) eaves_m: f32,
    pub(super) materials: &'a Materials,
}

impl RoofSite<'_> {
    pub(super) fn build(&self, builder: &mut MeshBuilder, roof: Roof, random: &mut Random) {
        match roof {
            Roof::Flat => {
                self.parapet(builder, self.half, self.eaves_m);
                self.machines(builder, self.half, self.eaves_m, random);
            }
            Roof::Tank => {
                self.parapet(builder, self.half, self.eaves_m);
                self.machines(builder, self.half, self.eaves_m, random);
                self.tank(builder);
            }
            Roof::Hipped => self.hipped(builder, random),
            Roof::Mansard => self.mansard(builder, random),
            Roof::Gabled => self.gabled(builder, random),
            Roof::Setback => self.setback(builder, random),
        }
    }

    /// Adds a wall of 0.9 m around a flat roof that lies 0.1 m below the eaves.
    fn parapet(&self, builder: &mut MeshBuilder, half: Vec2, eaves: f32) {
        let Materials { trim, wall, gravel, .. } = self.materials;
        let top = eaves + 0.8;
        let deck = eaves - 0.1;
        let thick = 0.3;
        let corners = |half: Vec2, y: f32| {
            [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
                .map(|(x, z)| vec3(x * half.x, y, z * half.y))
        };
        let within = half - Vec2::splat(thick);
        let foot = corners(half, eaves);
        let outer = corners(half, top);
        let inner = corners(within, top);
        let floor = corners(within, deck);
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            builder.polygon(&[foot[corner], foot[next], outer[next], outer[corner]], *wall);
            builder.polygon(&[outer[corner], outer[next], inner[next], inner[corner]], *trim);
            builder.polygon(
                &[inner[corner], inner[next], floor[next], floor[corner]],
                wall.shade(0.8),
            );
        }
        builder.polygon(&floor, *gravel);
    }

    fn machines(&self, builder: &mut MeshBuilder, half: Vec2, eaves: f32, random: &mut Random) {
        let Materials { wall, steel, iron, gravel, .. } = self.materials;
        let deck = eaves - 0.15;
        let head = vec3(-half.x * 0.45, deck, -half.y * 0.4);
        let size = vec3(1.6, 2.7, 1.4);
        builder.cuboid(
            head - vec3(size.x, 0.0, size.z),
            head + size,
            Faces::Standing,
            wall.shade(0.9),
        );
        let lid = head + vec3(0.0, size.y - 0.02, 0.0);
        builder.cuboid(
            lid - vec3(1.75, 0.0, 1.55),
            lid + vec3(1.75, 0.18, 1.55),
            Faces::All,
            *gravel,
        );
        for place in 0..3u8 {
            let x = half.x * [0.15, 0.5, 0.3][usize::from(place)];
            let z = half.y * [0.5, 0.1, -0.5][usize::from(place)];
            let size =
                vec3(random.between(0.5, 1.0), random.between(0.7, 1.2), random.between(0.5, 0.9));
            let foot = vec3(x, deck, z);
            builder.cuboid(foot - vec3(size.x, 0.0, size.z), foot + size, Faces::Standing, *steel);
            let fan = Affine3A::from_translation(foot + Vec3::Y * (size.y - 0.02));
            builder.turned(&fan, &[(0.4, 0.0), (0.4, 0.14), (0.0, 0.14)], 8, *iron);
        }
        for pipe in 0..2u8 {
            let place = vec3(half.x * (0.7 - 0.2 * f32::from(pipe)), deck, half.y * -0.7);
            let profile = [(0.13, 0.0), (0.13, 1.3), (0.2, 1.3), (0.2, 1.5), (0.0, 1.55)];
            builder.turned(&Affine3A::from_translation(place), &profile, 6, *iron);
        }
    }

    fn tank(&self, builder: &mut MeshBuilder) {
        let Materials { wood, iron, slate, .. } = self.materials;
        let foot = vec3(-self.half.x * 0.4, self.eaves_m - 0.15, self.half.y * 0.45);
        for (x, z) in [(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)] {
            let leg = foot + vec3(x, 0.0, z);
            builder.cuboid(
                leg - vec3(0.1, 0.0, 0.1),
                leg + vec3(0.1, 2.05, 0.1),
                Faces::Sides,
                *iron,
            );
        }
        let profile = [(0.0, 2.0), (1.5, 2.0), (1.5, 4.4)];
        let place = Affine3A::from_translation(foot);
        builder.turned(&place, &profile, 14, *wood);
        builder.turned(&place, &[(1.65, 4.35), (0.0, 5.3)], 14, *slate);
        builder.turned(&place, &[(1.5, 4.4), (1.65, 4.35)], 14, *slate);
    }

    fn soffit(&self, builder: &mut MeshBuilder, out: f32, paint: Paint) {
        builder.band(self.half, out, [self.eaves_m - 0.3, self.eaves_m], paint);
    }

    fn chimney(&self, builder: &mut MeshBuilder, foot: Vec3, top_m: f32) {
        let Materials { wall, iron, .. } = self.materials;
        let half = vec3(0.4, 0.0, 0.3);
        let high = Vec3::new(foot.x, top_m, foot.z);
        builder.cuboid(foot - half, high + half, Faces::Standing, wall.shade(0.75));
        for x in [-0.18, 0.18] {
            let pot = Affine3A::from_translation(high + vec3(x, -0.02, 0.0));
            builder.turned(&pot, &[(0.12, 0.0), (0.1, 0.45), (0.0, 0.45)], 6, *iron);
        }
    }

    fn hipped(&self, builder: &mut MeshBuilder, random: &mut Random) {
        let Materials { trim, tile, .. } = self.materials;
        self.soffit(builder, 0.28, *trim);
        let wide = self.half + Vec2::splat(0.2);
        let short = wide.min_element();
        let rise = short * 0.62;
        let inset = Vec2::splat(short);
        let low = self.eaves_m;
        let high = self.eaves_m + rise;
        builder.tapered(
            vec3(-wide.x, low, -wide.y),
            vec3(wide.x, high, wide.y),
            inset,
            Faces::Sides,
            *tile,
        );
        for side in [-1.0, 1.0] {
            let foot = vec3(side * wide.x * random.between(0.35, 0.5), low, side * wide.y * 0.3);
            self.chimney(builder, foot, high + 0.6);
        }
    }

    fn gabled(&self, builder: &mut MeshBuilder, random: &mut Random) {
        let Materials { trim, tile, wall, .. } = self.materials;
        self.soffit(builder, 0.25, *trim);
        let x = self.half.x;
        let z = self.half.y;
        let rise = z * 0.8;
        let low = self.eaves_m;
        let high = self.eaves_m + rise;
        let ridge = |x: f32| vec3(x, high, 0.0);
        let eave = |x: f32, z: f32| vec3(x, low, z);
        builder.polygon(&[eave(-x, z), eave(x, z), ridge(x), ridge(-x)], *tile);
        builder.polygon(&[eave(x, -z), eave(-x, -z), ridge(-x), ridge(x)], *tile);
        builder.polygon(&[eave(x, z), eave(x, -z), ridge(x)], *wall);
        builder.polygon(&[eave(-x, -z), eave(-x, z), ridge(-x)], *wall);
        builder.cuboid(
            vec3(-x - 0.05, high - 0.12, -0.2),
            vec3(x + 0.05, high + 0.08, 0.2),
            Faces::All,
            tile.shade(0.8),
        );
        for side in [-1.0, 1.0] {
            let foot = vec3(side * x * random.between(0.45, 0.7), low, -side * z * 0.35);
            self.chimney(builder, foot, high + 0.7);
        }
        self.dormers(builder, [0, 2], 3, rise / z, 0.9);
    }

    /// Adds small windows that protrude from a slope of `slope` metres per metre.
    fn dormers(
        &self,
        builder: &mut MeshBuilder,
        sides: [usize; 2],
        count: u32,
        slope: f32,
        set_back: f32,
    ) {
        let Materials { trim, slate, glass, .. } = self.materials;
        for side in sides {
            let frame = Frame::of_side(side, self.half, Vec3::Y * self.eaves_m);
            let width = 2.0 * if side.is_multiple_of(2) { self.half.x } else { self.half.y };
            for dormer in 0..count {
                let middle = width * (dormer as f32 + 0.5) / count as f32;
                let low = set_back * slope - 0.05;
                let high = set_back * slope + 1.5;
                let left = middle - 0.65;
                let right = middle + 0.65;
                // The back end lies inside the roof.
                let back = -set_back - 1.7 / slope;
                let at = |u: f32, v: f32, d: f32| frame.at(u, v, d);
                let front = -set_back;
                let cell = panel(left, low, right, high);
                let face =
                    Frame::of_side(side, self.half - Vec2::splat(set_back), Vec3::Y * self.eaves_m);
                let shift =
                    |area: Panel| panel(area.u0 - set_back, area.v0, area.u1 - set_back, area.v1);
                let hole = panel(left + 0.25, low + 0.35, right - 0.25, high - 0.2);
                builder.recess(&face, shift(cell), shift(hole), 0.12, [*trim, *trim]);
                builder.rectangle(&face, shift(hole), -0.12, glass[1]);
                builder.polygon(
                    &[
                        at(left, low, back),
                        at(left, low, front),
                        at(left, high, front),
                        at(left, high, back),
                    ],
                    *trim,
                );
                builder.polygon(
                    &[
                        at(right, low, front),
                        at(right, low, back),
                        at(right, high, back),
                        at(right, high, front),
                    ],
                    *trim,
                );
                let lid = |u: f32, d: f32| at(u, high, d);
                builder.polygon(
                    &[lid(left, front), lid(right, front), lid(right, back), lid(left, back)],
                    *slate,
                );
            }
        }
    }

    fn mansard(&self, builder: &mut MeshBuilder, random: &mut Random) {
        let Materials { trim, slate, .. } = self.materials;
        self.soffit(builder, 0.28, *trim);
        let low = self.eaves_m;
        let high = self.eaves_m + 3.0;
        let inset = 1.2;
        let half = self.half;
        builder.tapered(
            vec3(-half.x, low, -half.y),
            vec3(half.x, high, half.y),
            Vec2::splat(inset),
            Faces::Sides,
            *slate,
        );
        let upper = half - Vec2::splat(inset);
        builder.tapered(
            vec3(-upper.x, high, -upper.y),
            vec3(upper.x, high + 0.7, upper.y),
            Vec2::splat(upper.min_element() * 0.6),
            Faces::Standing,
            slate.shade(1.2),
        );
        self.dormers(builder, [0, 2], 4, 3.0 / inset, 0.3);
        for side in [-1.0, 1.0] {
            let foot = vec3(side * upper.x * random.between(0.5, 0.7), high - 0.3, 0.0);
            self.chimney(builder, foot, high + 2.0);
        }
    }

    fn setback(&self, builder: &mut MeshBuilder, random: &mut Random) {
        let Materials { wall, trim, glass, .. } = self.materials;
        self.parapet(builder, self.half, self.eaves_m);
        let inset = self.half - Vec2::splat(2.4);
        let foot = self.eaves_m - 0.15;
        let height = 3.6;
        for side in 0..4 {
            let frame = Frame::of_side(side, inset, Vec3::Y * foot);
            let width = 2.0 * if side.is_multiple_of(2) { inset.x } else { inset.y };
            let cell = panel(0.0, 0.0, width, height);
            let hole = panel(0.7, 0.9, width - 0.7, height - 0.5);
            builder.recess(&frame, cell, hole, 0.25, [*wall, *trim]);
            builder.rectangle(&frame, hole, -0.25, glass[side % 3]);
        }
        self.parapet(builder, inset, foot + height);
        self.machines(builder, inset, foot + height, random);
    }
}
