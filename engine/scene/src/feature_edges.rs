//! The feature edges of a mesh, as CAD drawings show them, and its smooth edges. The view decides
//! which smooth edges are silhouettes.
//!
//! Vertices at equal positions count as one vertex, a triangle and its back as one face. No
//! decision depends on the winding: the fold of an edge is measured between the two directions from
//! the edge into its faces.

use std::collections::HashSet;
use std::ops::Range;

use glam::{Affine3A, DVec3, Vec3};

use crate::mesh::Mesh;

/// The fold, in radians, up to which two faces count as one plane. Their edge could be a silhouette
/// only where they are seen edge-on, and there the edges around them are silhouettes, too.
const FLAT_RAD: f64 = 1.0e-4;

/// The ratio of a triangle's height to its longest side below which it has no plane.
const SLIVER: f64 = 1.0e-7;

/// The rules by which edges are features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeRules {
    /// The angle between the planes of two faces above which their edge is a crease, and the turn
    /// above which a chain ends, in degrees: from 0 to 180.
    pub crease_degrees: f32,
    /// True if flat edges are kept as smooth ones, for meshes that are bent later.
    pub keeps_flat: bool,
}

impl Default for EdgeRules {
    fn default() -> Self {
        Self { crease_degrees: 30.0, keeps_flat: false }
    }
}

/// The triangles whose edges are searched.
#[derive(Clone, Copy, Debug)]
pub struct EdgeSource<'a> {
    /// The positions of the vertices (metres).
    pub positions: &'a [Vec3],
    /// Three vertices per triangle. Triangles with an invalid index are left out.
    pub triangles: &'a [u32],
    /// The face of the model that each triangle belongs to; empty if that is not known. Edges
    /// between different faces are features.
    pub faces: &'a [u32],
}

/// The reason why an edge is a feature, or that it is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EdgeKind {
    /// The edge's faces fold by more than the crease angle.
    Crease,
    /// The edge has a single face.
    Border,
    /// The edge has more than two faces.
    NonManifold,
    /// The edge lies between different faces of the model.
    FaceBorder,
    /// The edge is none of these: it is visible only in views in which it is a silhouette.
    Smooth,
}

/// An edge of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeSegment {
    /// The first end in the direction of the chain: the first vertex at its position.
    pub from: u32,
    /// The other end.
    pub to: u32,
    /// The reason why it is a feature.
    pub kind: EdgeKind,
    /// A corner of the first face that is not on the edge: with the edge it spans the face's plane.
    pub left: u32,
    /// The corner of the second face, if there is one.
    pub right: Option<u32>,
}

/// The segments of one edge of a model, from corner to corner or around a closed loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EdgeChain {
    /// The segments, in order.
    pub segments: Range<u32>,
    /// True if the chain ends where it begins.
    pub is_closed: bool,
}

/// The edges of a mesh: features, chain by chain, followed by the smooth edges.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FeatureEdges {
    segments: Vec<EdgeSegment>,
    chains: Vec<EdgeChain>,
}

/// A triangle by the names of its corners.
#[derive(Clone, Copy)]
struct Corners {
    triangle: u32,
    a: u32,
    b: u32,
    c: u32,
}

/// A triangle without a plane: the ends of its longest side, and the corner that lies on this side.
#[derive(Clone, Copy)]
struct Sliver {
    from: u32,
    middle: u32,
    to: u32,
}

/// A face at an edge. The edge is the names of its vertices, in the upper and the lower half.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct EdgeFace {
    edge: u64,
    triangle: u32,
    opposite: u32,
}

impl FeatureEdges {
    /// Finds the edges of triangles. The result depends only on the triangles, their order and the
    /// rules.
    pub fn new(source: &EdgeSource<'_>, rules: &EdgeRules) -> Self {
        let names = welded(source.positions);
        let finder = Finder { source, names: &names };
        let faces = finder.faces();
        let mut edges = Self::default();
        let mut smooth = Vec::new();
        for faces in faces.chunk_by(|a, b| a.edge == b.edge) {
            match finder.segment(faces, rules) {
                Some(segment) if segment.kind == EdgeKind::Smooth => smooth.push(segment),
                Some(segment) => edges.segments.push(segment),
                None => {}
            }
        }
        let chains = Chains::new(&edges.segments, source.positions, rules);
        (edges.segments, edges.chains) = chains.ordered();
        edges.segments.extend(smooth);
        edges
    }

    /// Finds the edges of a mesh.
    pub fn of_mesh(mesh: &Mesh, rules: &EdgeRules) -> Self {
        let positions: Vec<Vec3> =
            mesh.vertices.iter().map(|vertex| vertex.position.into()).collect();
        let source = EdgeSource { positions: &positions, triangles: &mesh.indices, faces: &[] };
        Self::new(&source, rules)
    }

    /// Returns all segments: the segments of the chains in their order, then the smooth ones.
    pub fn segments(&self) -> &[EdgeSegment] {
        &self.segments
    }

    /// Returns the segments that are features.
    pub fn features(&self) -> &[EdgeSegment] {
        let end = self.chains.last().map_or(0, |chain| chain.segments.end as usize);
        self.segments.get(..end).unwrap_or_default()
    }

    /// Returns the smooth segments. Such a segment is a silhouette where both of its faces lie on
    /// one side of it in the view.
    pub fn smooth(&self) -> &[EdgeSegment] {
        self.segments.get(self.features().len()..).unwrap_or_default()
    }

    /// Returns the chains.
    pub fn chains(&self) -> &[EdgeChain] {
        &self.chains
    }

    /// Returns the index of the chain of a segment; `None` for a smooth segment.
    pub fn chain_of(&self, segment: u32) -> Option<u32> {
        let chain = self.chains.partition_point(|chain| chain.segments.end <= segment);
        self.chains.get(chain).map(|_| chain as u32)
    }

    /// Returns the length of a chain (metres) under the transform of its object, 0 for an invalid
    /// index. The chain is a whole edge of the model, regardless of the number of its segments.
    pub fn chain_length(&self, chain: u32, positions: &[Vec3], transform: &Affine3A) -> f64 {
        let segments = self.chains.get(chain as usize).map(|chain| chain.segments.clone());
        let segments = segments.map(|range| range.start as usize..range.end as usize);
        let place = |vertex: u32| {
            let position = positions.get(vertex as usize).copied().unwrap_or_default();
            transform.matrix3.as_dmat3() * position.as_dvec3()
        };
        let lengths = segments.and_then(|range| self.segments.get(range)).unwrap_or_default();
        lengths.iter().map(|segment| place(segment.from).distance(place(segment.to))).sum()
    }
}

/// Returns the first vertex at the position of each vertex.
fn welded(positions: &[Vec3]) -> Vec<u32> {
    // A negative zero equals zero.
    let key = |position: &Vec3| position.to_array().map(|part| (part + 0.0).to_bits());
    let mut sorted: Vec<_> = (0..).zip(positions).map(|(id, at)| (key(at), id)).collect();
    sorted.sort_unstable();
    let mut names = vec![0_u32; positions.len()];
    for same in sorted.chunk_by(|(a, _), (b, _)| a == b) {
        let first = same.first().map_or(0, |(_, id)| *id);
        for (_, id) in same {
            names[*id as usize] = first;
        }
    }
    names
}

fn edge_of(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

/// The search for segments.
struct Finder<'a> {
    source: &'a EdgeSource<'a>,
    names: &'a [u32],
}

impl Finder<'_> {
    fn place(&self, vertex: u32) -> DVec3 {
        self.source.positions.get(vertex as usize).copied().unwrap_or_default().as_dvec3()
    }

    /// Returns the triangles that have three distinct corners; a triangle and its back count once.
    fn triangles(&self) -> Vec<Corners> {
        let name = |vertex: &u32| self.names.get(*vertex as usize).copied();
        let mut sorted: Vec<([u32; 3], u32)> = Vec::new();
        for (number, corners) in (0..).zip(self.source.triangles.as_chunks::<3>().0) {
            let [Some(a), Some(b), Some(c)] = corners.each_ref().map(name) else { continue };
            if a != b && b != c && c != a {
                let mut corners = [a, b, c];
                corners.sort_unstable();
                sorted.push((corners, number));
            }
        }
        sorted.sort_unstable();
        sorted.dedup_by_key(|(corners, _)| *corners);
        let named = |(corners, triangle): ([u32; 3], u32)| {
            let [a, b, c] = corners;
            Corners { triangle, a, b, c }
        };
        sorted.into_iter().map(named).collect()
    }

    /// Returns the faces at all edges, edge by edge. A triangle without a plane has no face. At its
    /// two short sides, the face beyond its longest side takes its place.
    fn faces(&self) -> Vec<EdgeFace> {
        let mut faces = Vec::new();
        let mut slivers = Vec::new();
        for corners in self.triangles() {
            if let Some(sliver) = self.sliver(&corners) {
                slivers.push(sliver);
                continue;
            }
            let Corners { triangle, a, b, c } = corners;
            let face =
                |from, to, opposite| EdgeFace { edge: edge_of(from, to), triangle, opposite };
            faces.extend([face(a, b, c), face(b, c, a), face(c, a, b)]);
        }
        faces.sort_unstable();
        if slivers.is_empty() {
            return faces;
        }
        let mut spanned = HashSet::new();
        let mut passed_on = Vec::new();
        for Sliver { from, middle, to } in slivers {
            let edge = edge_of(from, to);
            let first = faces.partition_point(|face| face.edge < edge);
            let beyond = faces.iter().skip(first).take_while(|face| face.edge == edge);
            for face in beyond {
                passed_on.push(EdgeFace { edge: edge_of(from, middle), ..*face });
                passed_on.push(EdgeFace { edge: edge_of(middle, to), ..*face });
            }
            spanned.insert(edge);
        }
        faces.extend(passed_on);
        faces.retain(|face| !spanned.contains(&face.edge));
        faces.sort_unstable();
        faces
    }

    /// Returns a triangle as a sliver, if it has no plane.
    fn sliver(&self, corners: &Corners) -> Option<Sliver> {
        let Corners { a, b, c, .. } = *corners;
        let sides = [(a, b, c), (b, c, a), (c, a, b)];
        let sides = sides.map(|(from, middle, to)| Sliver { from, middle, to });
        let along = |side: &Sliver| self.place(side.to) - self.place(side.from);
        let length = |side: &Sliver| along(side).length_squared();
        let longest = sides.into_iter().max_by(|a, b| length(a).total_cmp(&length(b)))?;
        let away = self.place(longest.middle) - self.place(longest.from);
        let height_by_length = along(&longest).cross(away).length();
        (height_by_length <= SLIVER * length(&longest)).then_some(longest)
    }

    /// Returns the segment of an edge with these faces, unless it is flat.
    fn segment(&self, faces: &[EdgeFace], rules: &EdgeRules) -> Option<EdgeSegment> {
        let first = faces.first()?;
        let second = faces.get(1);
        let from = (first.edge >> 32) as u32;
        let to = first.edge as u32;
        let label = |face: &EdgeFace| self.source.faces.get(face.triangle as usize);
        let kind = match second {
            None => EdgeKind::Border,
            Some(_) if faces.len() > 2 => EdgeKind::NonManifold,
            Some(second) if label(first) != label(second) => EdgeKind::FaceBorder,
            Some(second) => {
                let fold = self.fold(from, to, first.opposite, second.opposite);
                if fold > f64::from(rules.crease_degrees).to_radians() {
                    EdgeKind::Crease
                } else if fold <= FLAT_RAD && !rules.keeps_flat {
                    return None;
                } else {
                    EdgeKind::Smooth
                }
            }
        };
        let right = second.map(|face| face.opposite);
        Some(EdgeSegment { from, to, kind, left: first.opposite, right })
    }

    /// Returns the angle between the planes of two faces at an edge, in radians.
    fn fold(&self, from: u32, to: u32, left: u32, right: u32) -> f64 {
        let start = self.place(from);
        let along = (self.place(to) - start).normalize_or_zero();
        let [left, right] = [left, right].map(|corner| {
            let into = self.place(corner) - start;
            (into - along * into.dot(along)).normalize_or_zero()
        });
        // From the sine, too: the cosine alone loses half of the digits near 0.
        left.cross(right).length().atan2(-left.dot(right))
    }
}

/// The search for chains.
struct Chains<'a> {
    segments: &'a [EdgeSegment],
    positions: &'a [Vec3],
    least_cosine: f64,
    /// The segments at each vertex, sorted.
    at: Vec<(u32, u32)>,
    is_taken: Vec<bool>,
}

impl<'a> Chains<'a> {
    fn new(segments: &'a [EdgeSegment], positions: &'a [Vec3], rules: &EdgeRules) -> Self {
        let ends =
            (0..).zip(segments).flat_map(|(id, segment)| [(segment.from, id), (segment.to, id)]);
        let mut at: Vec<_> = ends.collect();
        at.sort_unstable();
        let least_cosine = f64::from(rules.crease_degrees).to_radians().cos();
        Self { segments, positions, least_cosine, at, is_taken: vec![false; segments.len()] }
    }

    /// Returns the segments chain by chain, each in the direction of its chain.
    fn ordered(mut self) -> (Vec<EdgeSegment>, Vec<EdgeChain>) {
        let mut segments = Vec::with_capacity(self.segments.len());
        let mut chains = Vec::new();
        // First the chains with an end, from that end on; the rest are closed loops.
        for is_closed in [false, true] {
            for id in 0..self.segments.len() as u32 {
                for vertex in self.ends(id) {
                    let is_start = is_closed || self.next(id, vertex).is_none();
                    if self.is_taken[id as usize] || !is_start {
                        continue;
                    }
                    let start = segments.len() as u32;
                    self.follow(id, vertex, &mut segments);
                    chains.push(EdgeChain { segments: start..segments.len() as u32, is_closed });
                }
            }
        }
        (segments, chains)
    }

    /// Appends the chain that begins with a segment at one of its ends.
    fn follow(&mut self, first: u32, start: u32, to: &mut Vec<EdgeSegment>) {
        let mut here = Some((first, start));
        while let Some((id, from)) = here {
            self.is_taken[id as usize] = true;
            let segment = self.segments[id as usize];
            let end = if segment.from == from { segment.to } else { segment.from };
            to.push(EdgeSegment { from, to: end, ..segment });
            let next = self.next(id, end).filter(|next| !self.is_taken[*next as usize]);
            here = next.map(|next| (next, end));
        }
    }

    fn ends(&self, id: u32) -> [u32; 2] {
        self.segments.get(id as usize).map_or([0; 2], |segment| [segment.from, segment.to])
    }

    /// Returns the segment that continues the chain of segment `id` at a vertex, if there is one.
    fn next(&self, id: u32, vertex: u32) -> Option<u32> {
        let first = self.at.partition_point(|(at, _)| *at < vertex);
        let mut here = self.at.iter().skip(first).take_while(|(at, _)| *at == vertex);
        let (Some((_, a)), Some((_, b)), None) = (here.next(), here.next(), here.next()) else {
            return None;
        };
        let other = if *a == id { *b } else { *a };
        let this = self.segments.get(id as usize)?;
        let next = self.segments.get(other as usize)?;
        let goes_on = self.direction(this, vertex).dot(self.direction(next, vertex));
        (this.kind == next.kind && -goes_on >= self.least_cosine).then_some(other)
    }

    /// Returns the direction of a segment away from one of its ends.
    fn direction(&self, segment: &EdgeSegment, vertex: u32) -> DVec3 {
        let far = if segment.from == vertex { segment.to } else { segment.from };
        let place = |id: u32| self.positions.get(id as usize).copied().unwrap_or_default();
        (place(far).as_dvec3() - place(vertex).as_dvec3()).normalize_or_zero()
    }
}

#[cfg(test)]
mod tests;
