//! The points and triangles of a surface at its levels, as whole numbers: nothing is computed yet.
//!
//! Each patch has a regular grid inside and four strips around it. A strip joins the pieces of an
//! edge, whose number is the edge's level, to the outer row of the grid. The patches on both sides
//! of an edge have the same points on it, so no vertex lies within another triangle's edge.

use super::levels::TessellationLevels;
use super::surface::{Patch, PatchSurface};
use super::welder::Welder;
use crate::Mesh;

/// A point of a surface to be computed, as shaders read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SurfacePoint {
    /// The index of its patch.
    pub patch: u32,
    /// 0 for a point inside. On a side of the patch, 1 + 2 * the side's number, plus 1 if the side
    /// runs against the canonical direction of its edge; see [`PatchSurface::sides`].
    pub side: u32,
    /// The first parameter in the patch: a multiple of 1/64, like the second one.
    pub u: f32,
    /// The second parameter in the patch.
    pub v: f32,
}

/// A computed point of a surface, as shaders write it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct EvaluatedPoint {
    /// The position in metres, in the space of the surface.
    pub position: [f32; 3],
    /// The unit normal as snorm8x4: see [`Vertex::normal`](crate::Vertex::normal).
    pub normal: u32,
}

/// The points and triangles of a surface at its levels.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceGrid {
    points: Vec<SurfacePoint>,
    /// The number of each point's place: points of several patches at one place have the same
    /// number.
    places: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl SurfaceGrid {
    /// Returns the grid of a surface at these levels. Triangles with an edge of no length, as at
    /// poles, are left out.
    pub fn new(surface: &PatchSurface, levels: &TessellationLevels) -> Self {
        let mut grid = Self { points: Vec::new(), places: Vec::new(), triangles: Vec::new() };
        // Places: control points, then the inner points of each edge, then those of each patch.
        let mut next_place = surface.control_points().len() as u32;
        let mut edge_places = Vec::with_capacity(surface.edges().len());
        for level in levels.of_edges() {
            edge_places.push(next_place);
            next_place += level - 1;
        }
        for patch in 0..surface.patches().len() {
            let rows = grid.add_inside(surface, levels, patch, &mut next_place);
            let corners = grid.add_corners(surface, patch);
            if rows.level == 1 {
                grid.add_triangle(corners.low_left, corners.low_right, corners.high_right);
                grid.add_triangle(corners.low_left, corners.high_right, corners.high_left);
                continue;
            }
            for side in 0..4 {
                let outer = grid.add_side(surface, levels, &edge_places, patch, side, corners);
                grid.add_strip(&outer, &rows.along(side), side);
            }
        }
        grid
    }

    /// Returns the number of points of a surface's grid at these levels, without creating it: the
    /// grid of a large surface takes gigabytes.
    pub fn point_count(surface: &PatchSurface, levels: &TessellationLevels) -> u64 {
        let of_patch = |(patch, sides): (usize, &[u32; 4])| {
            let inside = u64::from(levels.of_patch(surface, patch) - 1).pow(2);
            let on_sides = sides.iter().map(|edge| u64::from(levels.of_edge(*edge) - 1));
            inside + 4 + on_sides.sum::<u64>()
        };
        surface.sides().iter().enumerate().map(of_patch).sum()
    }

    /// Returns the points. A point on an edge is listed once per patch.
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    /// Returns the number of each point's place. Points with equal numbers lie at one place.
    pub fn places(&self) -> &[u32] {
        &self.places
    }

    /// Returns the triangles as three indices into the points, anticlockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Returns the mesh of the grid, with these computed points. Points at one place become one
    /// vertex if their positions are equal to the bit and their normals nearly equal. Missing
    /// points are at the origin.
    pub fn mesh(&self, points: &[EvaluatedPoint], name: &str, colour: u32) -> Mesh {
        let mut welder = Welder::new(colour);
        // The newest vertex at each place.
        let mut newest = vec![None; self.places.iter().max().map_or(0, |last| *last as usize + 1)];
        let mut of_point = Vec::with_capacity(self.points.len());
        let missing = EvaluatedPoint { position: [0.0; 3], normal: 0 };
        let points = points.iter().chain(std::iter::repeat(&missing));
        for (place, point) in self.places.iter().zip(points) {
            of_point.push(welder.vertex_of(point, &mut newest[*place as usize]));
        }
        let corners = self.triangles.as_flattened().iter();
        let indices = corners.map(|point| of_point[*point as usize]).collect();
        welder.into_mesh(indices, name)
    }

    fn add_point(&mut self, point: SurfacePoint, place: u32) -> u32 {
        self.points.push(point);
        self.places.push(place);
        self.points.len() as u32 - 1
    }

    /// Adds a triangle, unless two of its corners are at one place.
    fn add_triangle(&mut self, a: u32, b: u32, c: u32) {
        let place = |point: u32| self.places[point as usize];
        if place(a) != place(b) && place(b) != place(c) && place(c) != place(a) {
            self.triangles.push([a, b, c]);
        }
    }

    /// Adds the points inside of a patch and the triangles between them.
    fn add_inside(
        &mut self,
        surface: &PatchSurface,
        levels: &TessellationLevels,
        patch: usize,
        next_place: &mut u32,
    ) -> InnerRows {
        let level = levels.of_patch(surface, patch);
        let rows = InnerRows { first: self.points.len() as u32, level };
        for row in 1..level {
            for column in 1..level {
                let u = column as f32 / level as f32;
                let v = row as f32 / level as f32;
                self.add_point(SurfacePoint { patch: patch as u32, side: 0, u, v }, *next_place);
                *next_place += 1;
            }
        }
        for row in 1..level.saturating_sub(1) {
            for column in 1..level - 1 {
                let low = rows.at(row, column);
                let high = rows.at(row + 1, column);
                self.add_triangle(low, low + 1, high + 1);
                self.add_triangle(low, high + 1, high);
            }
        }
        rows
    }

    fn add_corners(&mut self, surface: &PatchSurface, patch: usize) -> PatchCorners {
        let Patch { control_points } = surface.patches()[patch];
        let mut add = |side: usize, u: f32, v: f32, control_point: usize| {
            let side = side_word(surface, patch, side);
            let point = SurfacePoint { patch: patch as u32, side, u, v };
            self.add_point(point, control_points[control_point])
        };
        PatchCorners {
            low_left: add(0, 0.0, 0.0, 0),
            low_right: add(0, 1.0, 0.0, 3),
            high_left: add(2, 0.0, 1.0, 12),
            high_right: add(2, 1.0, 1.0, 15),
        }
    }

    /// Adds the points on a side of a patch between its corners. Returns all points of the side, in
    /// the direction of u or v.
    fn add_side(
        &mut self,
        surface: &PatchSurface,
        levels: &TessellationLevels,
        edge_places: &[u32],
        patch: usize,
        side: usize,
        corners: PatchCorners,
    ) -> Vec<u32> {
        let edge = surface.sides()[patch][side];
        let level = levels.of_edge(edge);
        let is_reversed = surface.is_reversed(patch, side);
        let word = side_word(surface, patch, side);
        let of_edge = surface.edges()[edge as usize];
        let mut outer = vec![corners.start_of(side)];
        for piece in 1..level {
            let along = piece as f32 / level as f32;
            let u = [along, 1.0, along, 0.0][side];
            let v = [0.0, along, 1.0, along][side];
            let canonical = if is_reversed { level - piece } else { piece };
            let place = if of_edge.is_collapsed() {
                of_edge.control_points[0]
            } else {
                edge_places[edge as usize] + canonical - 1
            };
            outer.push(
                self.add_point(SurfacePoint { patch: patch as u32, side: word, u, v }, place),
            );
        }
        outer.push(corners.end_of(side));
        outer
    }

    /// Adds the triangles between a side of a patch and the parallel row of its grid.
    fn add_strip(&mut self, outer: &[u32], inner: &[u32], side: usize) {
        // The sides v = 0 and u = 1 run anticlockwise around the patch, the others clockwise.
        let is_clockwise = side >= 2;
        let mut add = |a: u32, b: u32, c: u32| {
            if is_clockwise {
                self.add_triangle(b, a, c);
            } else {
                self.add_triangle(a, b, c);
            }
        };
        let outer_level = outer.len() - 1;
        let inner_level = inner.len() + 1;
        let mut from_outer = 0;
        let mut from_inner = 0;
        while from_outer < outer_level || from_inner + 1 < inner.len() {
            // The next triangle is the one whose middle comes first, compared in whole numbers.
            let outer_middle = (2 * from_outer + 1) * inner_level;
            let inner_middle = (2 * from_inner + 3) * outer_level;
            let is_inner_done = from_inner + 1 >= inner.len();
            let is_outer_step = from_outer < outer_level && outer_middle <= inner_middle;
            if is_inner_done || is_outer_step {
                add(outer[from_outer], outer[from_outer + 1], inner[from_inner]);
                from_outer += 1;
            } else {
                add(outer[from_outer], inner[from_inner + 1], inner[from_inner]);
                from_inner += 1;
            }
        }
    }
}

/// The corners of a patch, as points of the grid.
#[derive(Clone, Copy)]
struct PatchCorners {
    low_left: u32,
    low_right: u32,
    high_left: u32,
    high_right: u32,
}

impl PatchCorners {
    fn start_of(self, side: usize) -> u32 {
        [self.low_left, self.low_right, self.high_left, self.low_left][side]
    }

    fn end_of(self, side: usize) -> u32 {
        [self.low_right, self.high_right, self.high_right, self.high_left][side]
    }
}

/// The points inside of a patch.
#[derive(Clone, Copy)]
struct InnerRows {
    first: u32,
    level: u32,
}

impl InnerRows {
    /// Returns the point at a row and a column, from 1.
    fn at(self, row: u32, column: u32) -> u32 {
        self.first + (row - 1) * (self.level - 1) + column - 1
    }

    /// Returns the outermost points along a side, in the direction of u or v.
    fn along(self, side: usize) -> Vec<u32> {
        let last = self.level - 1;
        let steps = 1..self.level;
        match side {
            0 => steps.map(|step| self.at(1, step)).collect(),
            1 => steps.map(|step| self.at(step, last)).collect(),
            2 => steps.map(|step| self.at(last, step)).collect(),
            _ => steps.map(|step| self.at(step, 1)).collect(),
        }
    }
}

/// Returns the value of [`SurfacePoint::side`] for points of a side.
fn side_word(surface: &PatchSurface, patch: usize, side: usize) -> u32 {
    1 + 2 * side as u32 + u32::from(surface.is_reversed(patch, side))
}
