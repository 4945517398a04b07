//! Tangents: the normalised tangents of the file. If it has none, they are computed by MikkTSpace
//! for a material with a normal texture, and arbitrary otherwise.

use glam::{Affine2, Vec2, Vec3, Vec4};

use super::geometry::Geometry;
use super::numbers::direction;
use super::pack::snorm16;

/// The texture coordinates of a normal texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NormalUvs {
    /// The index of the set of texture coordinates, 0 or 1.
    pub(super) set: u8,
    /// The transform from these to coordinates in the texture.
    pub(super) transform: Affine2,
}

/// The most triangles that may share a corner for MikkTSpace: it visits neighbours by recursion,
/// and compares each with each.
const MOST_AROUND: u32 = 1024;

/// The most such comparisons in a mesh.
const MOST_COMPARISONS: u64 = 1 << 30;

/// Gives every vertex a tangent. Returns the geometry, whose vertices may have been split, and the
/// number of the file's tangents without direction.
pub(super) fn complete(mut geometry: Geometry, wanted: Option<NormalUvs>) -> (Geometry, usize) {
    if !geometry.tangents.is_empty() {
        let broken = repair(&mut geometry);
        return (geometry, broken);
    }
    for target in &mut geometry.targets {
        target.tangents.clear();
    }
    let uvs: Vec<Vec2> = match wanted
        .and_then(|normal| Some((normal, geometry.uvs.get(usize::from(normal.set))?)))
    {
        Some((normal, uvs)) => {
            uvs.iter().map(|uv| finite(normal.transform.transform_point2(*uv))).collect()
        }
        None => Vec::new(),
    };
    if uvs.is_empty() {
        geometry.tangents = geometry
            .normals
            .iter()
            .map(|normal| normal.any_orthonormal_vector().extend(1.0))
            .collect();
        return (geometry, 0);
    }
    let corners = if is_tame(&geometry, &uvs) {
        mikkelsen(&geometry, &uvs)
    } else {
        accumulated(&geometry, &uvs)
    };
    let corner = |triangle: usize, corner: usize| {
        let of_triangle = corners.get(triangle).copied().unwrap_or([Vec4::X; 3]);
        of_triangle[corner]
    };
    let (mut split, origins) =
        geometry.split(|triangle, place| corner(triangle, place).to_array().map(snorm16));
    split.tangents = origins
        .iter()
        .map(|&[triangle, place]| corner(triangle as usize, place as usize))
        .collect();
    repair(&mut split);
    (split, 0)
}

fn finite(uv: Vec2) -> Vec2 {
    if uv.is_finite() { uv } else { Vec2::ZERO }
}

/// Normalises all tangents in place. A tangent without direction gets one perpendicular to its
/// normal. Returns the number of such tangents.
fn repair(geometry: &mut Geometry) -> usize {
    let mut broken = 0;
    for (tangent, normal) in geometry.tangents.iter_mut().zip(&geometry.normals) {
        let sign = if tangent.w < 0.0 { -1.0 } else { 1.0 };
        let unit = direction(tangent.truncate()).unwrap_or_else(|| {
            broken += 1;
            normal.any_orthonormal_vector()
        });
        *tangent = unit.extend(sign);
    }
    broken
}

/// Returns a key of a vertex: vertices that MikkTSpace takes for one have equal keys.
fn welded(geometry: &Geometry, uvs: &[Vec2], vertex: u32) -> [u32; 8] {
    let vertex = vertex as usize;
    let position = geometry.positions.get(vertex).copied().unwrap_or_default().to_array();
    let normal = geometry.normals.get(vertex).copied().unwrap_or_default().to_array();
    let uv = uvs.get(vertex).copied().unwrap_or_default().to_array();
    let [x, y, z] = position.map(f32::to_bits);
    let [nx, ny, nz] = normal.map(f32::to_bits);
    let [u, v] = uv.map(f32::to_bits);
    [x, y, z, nx, ny, nz, u, v]
}

/// Returns true if MikkTSpace finishes in bounded time: hostile files have a million triangles
/// around one vertex.
fn is_tame(geometry: &Geometry, uvs: &[Vec2]) -> bool {
    let mut around: std::collections::HashMap<[u32; 8], u32> = std::collections::HashMap::new();
    for &vertex in geometry.triangles.as_flattened() {
        *around.entry(welded(geometry, uvs, vertex)).or_default() += 1;
    }
    let comparisons: u64 = around.values().map(|&count| u64::from(count).pow(2)).sum();
    around.values().all(|&count| count <= MOST_AROUND) && comparisons <= MOST_COMPARISONS
}

/// The triangles given to MikkTSpace: all triangles with three different corners.
struct Faces<'a> {
    geometry: &'a Geometry,
    uvs: &'a [Vec2],
    faces: Vec<usize>,
    tangents: Vec<[Vec4; 3]>,
}

impl Faces<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        let triangle = self.faces.get(face).and_then(|&place| self.geometry.triangles.get(place));
        triangle.map_or(0, |triangle| triangle[corner] as usize)
    }
}

impl bevy_mikktspace::Geometry for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.faces.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        let at = self.geometry.positions.get(self.vertex(face, corner));
        at.copied().unwrap_or_default().to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let at = self.geometry.normals.get(self.vertex(face, corner));
        at.copied().unwrap_or_default().to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs.get(self.vertex(face, corner)).copied().unwrap_or_default().to_array()
    }

    fn set_tangent(
        &mut self,
        space: Option<bevy_mikktspace::TangentSpace>,
        face: usize,
        corner: usize,
    ) {
        let place = self.faces.get(face).copied().unwrap_or_default();
        if let (Some(space), Some(tangents)) = (space, self.tangents.get_mut(place)) {
            let [x, y, z, sign] = space.tangent_encoded();
            // MikkTSpace assumes that v points up; in glTF it points down.
            tangents[corner] = Vec4::new(x, y, z, -sign);
        }
    }
}

/// Returns the tangents of all corners by MikkTSpace; zeros where it finds none.
fn mikkelsen(geometry: &Geometry, uvs: &[Vec2]) -> Vec<[Vec4; 3]> {
    let at = |vertex: u32| geometry.positions.get(vertex as usize).copied().unwrap_or_default();
    let is_proper = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(at);
        a != b && b != c && c != a
    };
    let triangles = geometry.triangles.iter().enumerate();
    let faces =
        triangles.filter(|(_, triangle)| is_proper(triangle)).map(|(place, _)| place).collect();
    let tangents = vec![[Vec4::W; 3]; geometry.triangles.len()];
    let mut faces = Faces { geometry, uvs, faces, tangents };
    // The error has no contents.
    match bevy_mikktspace::generate_tangents(&mut faces) {
        Ok(()) | Err(_) => faces.tangents,
    }
}

/// Returns the tangents of all corners: for each vertex, the sum over its triangles of the
/// direction in which u increases (E. Lengyel, Foundations of Game Engine Development, volume 2,
/// 7.5).
fn accumulated(geometry: &Geometry, uvs: &[Vec2]) -> Vec<[Vec4; 3]> {
    let mut sums = vec![(Vec3::ZERO, 0.0_f32); geometry.positions.len()];
    for triangle in &geometry.triangles {
        let at = |vertex: u32| geometry.positions.get(vertex as usize).copied().unwrap_or_default();
        let on = |vertex: u32| uvs.get(vertex as usize).copied().unwrap_or_default();
        let [a, b, c] = triangle.map(at);
        let [i, j, k] = triangle.map(on);
        let first = j - i;
        let second = k - i;
        let turn = first.perp_dot(second);
        let along = ((b - a) * second.y - (c - a) * first.y) * turn.signum();
        if along.is_finite() && turn != 0.0 {
            for &vertex in triangle {
                if let Some((sum, sign)) = sums.get_mut(vertex as usize) {
                    *sum += along;
                    *sign += turn.signum();
                }
            }
        }
    }
    let of_vertex = |vertex: u32| {
        let (sum, sign) = sums.get(vertex as usize).copied().unwrap_or_default();
        let normal = geometry.normals.get(vertex as usize).copied().unwrap_or_default();
        // v points down.
        (sum - normal * normal.dot(sum)).extend(if sign > 0.0 { -1.0 } else { 1.0 })
    };
    geometry.triangles.iter().map(|triangle| triangle.map(of_vertex)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    /// Returns a square in z = 0 that shows a whole texture upright: u to the right, v down.
    fn square() -> Geometry {
        let positions = vec![Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0), Vec3::Y];
        Geometry {
            uvs: [positions.iter().map(|at| Vec2::new(at.x, 1.0 - at.y)).collect(), Vec::new()],
            normals: vec![Vec3::Z; 4],
            positions,
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Geometry::default()
        }
    }

    const UPRIGHT: Option<NormalUvs> = Some(NormalUvs { set: 0, transform: Affine2::IDENTITY });

    #[test]
    fn upright_textures_have_tangents_to_the_right_and_bitangents_up() {
        let (geometry, _) = complete(square(), UPRIGHT);
        assert_eq!(geometry.tangents, [Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
        let mut mirrored = square();
        mirrored.uvs[0].iter_mut().for_each(|uv| uv.x = 1.0 - uv.x);
        let (geometry, _) = complete(mirrored, UPRIGHT);
        assert_eq!(geometry.tangents, [Vec4::new(-1.0, 0.0, 0.0, -1.0); 4]);
    }

    #[test]
    fn both_ways_to_find_tangents_agree_where_it_is_easy() {
        let square = square();
        assert_eq!(
            mikkelsen(&square, &square.uvs[0]),
            accumulated(&square, &square.uvs[0])
                .iter()
                .map(|corners| corners.map(|corner| corner.truncate().normalize().extend(corner.w)))
                .collect::<Vec<_>>()
        );
    }

    #[test]
    fn a_turned_texture_turns_the_tangents() {
        let transform = Affine2::from_angle(std::f32::consts::FRAC_PI_2);
        let (geometry, _) = complete(square(), Some(NormalUvs { set: 0, transform }));
        // u' = -v, which grows upwards.
        let expected = Vec4::new(0.0, 1.0, 0.0, 1.0);
        assert!(geometry.tangents.iter().all(|tangent| tangent.distance(expected) < 1e-6));
    }

    #[test]
    fn seams_in_the_texture_split_vertices() {
        let mut seam = square();
        // The second triangle is mirrored, so vertices that it shares with the first are split.
        seam.uvs[0][3] = Vec2::new(2.0, 1.0);
        let (geometry, _) = complete(seam, UPRIGHT);
        assert_eq!(geometry.positions.len(), 6);
        for (triangle, sign) in geometry.triangles.iter().zip([1.0, -1.0]) {
            assert!(triangle.iter().all(|&vertex| geometry.tangents[vertex as usize].w == sign));
        }
    }

    #[test]
    fn tangents_of_the_file_are_made_unit_vectors() {
        let mut given = square();
        given.tangents = vec![
            Vec4::new(0.0, 3.0, 0.0, -1.0),
            Vec4::NAN,
            Vec4::ZERO,
            Vec4::new(1.0, 0.0, 0.0, 7.0),
        ];
        let (geometry, broken) = complete(given, None);
        assert_eq!(broken, 2);
        assert_eq!(geometry.tangents[0], Vec4::new(0.0, 1.0, 0.0, -1.0));
        assert_eq!(geometry.tangents[3], Vec4::new(1.0, 0.0, 0.0, 1.0));
        for tangent in &geometry.tangents[1..3] {
            assert!(tangent.truncate().is_normalized() && tangent.z.abs() < 1e-6);
        }
    }

    #[test]
    fn without_a_normal_texture_they_are_across_the_normals() {
        let (geometry, _) = complete(square(), None);
        assert_eq!(geometry.positions.len(), 4);
        assert!(
            geometry.tangents.iter().all(|tangent| tangent.truncate().dot(Vec3::Z).abs() < 1e-6)
        );
    }

    #[test]
    fn a_hundred_thousand_triangles_around_one_vertex_take_no_stack_and_no_eternity() {
        let count = 100_000_u32;
        let rim = (0..count)
            .map(|step| Vec2::from_angle(step as f32 * std::f32::consts::TAU / count as f32));
        let positions: Vec<Vec3> =
            std::iter::once(Vec2::ZERO).chain(rim).map(|at| at.extend(0.0)).collect();
        let fan = Geometry {
            uvs: [positions.iter().map(|at| Vec2::new(at.x, -at.y)).collect(), Vec::new()],
            normals: vec![Vec3::Z; positions.len()],
            positions,
            triangles: (1..count).map(|step| [0, step, step + 1]).collect(),
            ..Geometry::default()
        };
        assert!(!is_tame(&fan, &fan.uvs[0]));
        let (fan, _) = complete(fan, UPRIGHT);
        for tangent in fan.tangents {
            assert!(tangent.distance(Vec4::new(1.0, 0.0, 0.0, 1.0)) < 1e-3, "{tangent}");
        }
    }

    #[test]
    fn nonsense_gives_unit_vectors() {
        let mut nonsense = square();
        nonsense.positions[2] = Vec3::splat(1e30);
        nonsense.positions[3] = Vec3::ZERO;
        nonsense.uvs[0] = vec![Vec2::splat(1e6); 4];
        let transform = Affine2::from_scale(Vec2::splat(1e38));
        let (geometry, _) = complete(nonsense, Some(NormalUvs { set: 0, transform }));
        assert!(geometry.tangents.iter().all(|tangent| tangent.truncate().is_normalized()));
    }
}
