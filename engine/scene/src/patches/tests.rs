//! Tests of the seams of surfaces and of the choice of levels.

use std::collections::HashMap;

use cull::{Camera, CullView, Projection};
use glam::{Affine3A, Mat4, Vec3, vec3};

use super::*;
use crate::{EdgeKind, EdgeRules, FeatureEdges, Mesh, Scene};

/// Returns a ball. Each of its patches has control points of its own.
fn ball() -> PatchSurface {
    ellipsoid(Vec3::ONE).unwrap()
}

fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    *state >> 33
}

fn random_levels(surface: &PatchSurface, seed: u64) -> TessellationLevels {
    let mut state = seed;
    let levels: Vec<u32> = surface.edges().iter().map(|_| 1 << (random(&mut state) % 7)).collect();
    TessellationLevels::from_edges(surface, &levels)
}

/// Returns how often triangles run along each edge between two places, in each direction.
fn walked(mesh: &Mesh) -> HashMap<[[u32; 3]; 2], usize> {
    let mut walked = HashMap::new();
    let place = |index: u32| mesh.vertices[index as usize].position.map(f32::to_bits);
    for triangle in mesh.indices.as_chunks::<3>().0 {
        for [a, b] in [[0, 1], [1, 2], [2, 0]] {
            *walked.entry([place(triangle[a]), place(triangle[b])]).or_default() += 1;
        }
    }
    walked
}

/// Checks that each edge of a closed mesh has exactly two triangles, with opposite directions.
fn walk_seams(mesh: &Mesh) {
    let walked = walked(mesh);
    for ([a, b], times) in &walked {
        assert_ne!(a, b);
        assert_eq!(*times, 1, "an edge has two triangles on one side");
        assert!(walked.contains_key(&[*b, *a]), "an edge has a triangle on one side only");
    }
}

#[test]
fn seams_are_closed_whatever_the_levels() {
    let surface = ball();
    assert_eq!(surface.edges().len(), 12 + 2, "eight meridians, four arcs of equator, two poles");
    let colour = u32::MAX;
    for seed in 0..12 {
        let levels = random_levels(&surface, seed);
        let points = SurfaceGrid::new(&surface, &levels).points().len() as u64;
        assert_eq!(SurfaceGrid::point_count(&surface, &levels), points);
        let mesh = tessellated(&surface, &levels, "ball", colour);
        walk_seams(&mesh);
        assert_eq!(Scene::single(mesh).validate(), Ok(()));
    }
    for level in [1, 2, 4, 64] {
        let levels = TessellationLevels::uniform(&surface, level);
        let mesh = tessellated(&surface, &levels, "ball", colour);
        walk_seams(&mesh);
        // Two triangles per quad, but one per quad at a pole.
        let level = u64::from(level);
        let of_patch = if level == 1 { 1 } else { 2 * level * level - level };
        assert_eq!(mesh.triangles(), 8 * of_patch, "{level}");
    }
}

#[test]
fn triangles_of_three_points_each_become_the_same_mesh() {
    let surface = ball();
    for seed in 0..6 {
        let levels = random_levels(&surface, seed);
        let grid = SurfaceGrid::new(&surface, &levels);
        let corners = grid.triangles().as_flattened().iter();
        let corner = |point: &u32| evaluated(&surface, &grid.points()[*point as usize]);
        let mut points: Vec<EvaluatedPoint> = corners.map(corner).collect();
        // A triangle without area, and one that was not captured.
        points.extend([points[0], points[1], points[0]]);
        points.extend([EvaluatedPoint { position: [0.0; 3], normal: 0 }; 3]);
        let mesh = captured_mesh(&points, "ball", 7);
        walk_seams(&mesh);
        let expected = tessellated(&surface, &levels, "ball", 7);
        assert_eq!(mesh.triangles(), expected.triangles());
        assert_eq!(mesh.vertices.len(), expected.vertices.len());
        assert_eq!(mesh.bounds, expected.bounds);
    }
    // Nothing is left out of a surface without poles.
    let points = (0..16).map(|point: u8| vec3(f32::from(point % 4), f32::from(point / 4), 0.0));
    let patch = Patch { control_points: std::array::from_fn(|point| point as u32) };
    let flat = PatchSurface::new(points.collect(), vec![patch]).unwrap();
    for seed in 0..12 {
        let levels = random_levels(&flat, seed);
        let triangles = SurfaceGrid::new(&flat, &levels).triangles().len() as u64;
        assert_eq!(captured_triangle_count(&flat, &levels), triangles, "{levels:?}");
    }
    assert_eq!(captured_triangle_count(&flat, &TessellationLevels::uniform(&flat, 1)), 2);
}

#[test]
fn points_are_in_bounds_and_on_the_ball_and_its_vertices_are_welded() {
    let surface = ball();
    let bounds = surface.bounds();
    for seed in 0..4 {
        let mesh = tessellated(&surface, &random_levels(&surface, seed), "ball", 0);
        assert!(bounds.contains(&mesh.bounds));
        for vertex in &mesh.vertices {
            let place = Vec3::from_array(vertex.position);
            assert!((place.length() - 1.0).abs() < 1e-3, "{place}");
            let normal = crate::unpack_normal(vertex.normal).normalize();
            assert!(normal.dot(place) > 0.995, "{place} {normal}");
        }
        let mut places: Vec<_> =
            mesh.vertices.iter().map(|vertex| vertex.position.map(f32::to_bits)).collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), mesh.vertices.len(), "a smooth surface has one vertex per place");
    }
}

#[test]
fn a_smooth_surface_faces_outside_and_has_no_features() {
    let half_axes = vec3(0.011, 0.008, 0.011);
    let surface = ellipsoid(half_axes).unwrap();
    for level in [8, 32, 64] {
        let levels = TessellationLevels::uniform(&surface, level);
        let mesh = tessellated(&surface, &levels, "knob", 0);
        for corners in mesh.indices.as_chunks::<3>().0 {
            let [a, b, c] =
                corners.map(|corner| Vec3::from_array(mesh.vertices[corner as usize].position));
            let across = (b - a).cross(c - a).normalize_or_zero();
            assert!(
                across.dot(((a + b + c) / half_axes).normalize()) > 0.8,
                "{a} {b} {c} does not face outside"
            );
        }
        let edges = FeatureEdges::of_mesh(&mesh, &EdgeRules::default());
        let features = edges.segments().iter().filter(|edge| edge.kind != EdgeKind::Smooth);
        let features: Vec<_> = features.collect();
        assert!(features.is_empty(), "{level}: {features:?}");
    }
}

#[test]
fn points_stay_in_the_hull_of_wild_control_points() {
    for seed in 0..12 {
        let mut state = seed;
        let mut coordinate = || {
            let scale = [1e-30, 1.0, 1e4, 1e15][(random(&mut state) % 4) as usize];
            (random(&mut state) as f32 / (1u64 << 31) as f32 * 2.0 - 1.0) * scale
        };
        let points: Vec<Vec3> =
            (0..16).map(|_| vec3(coordinate(), coordinate(), coordinate())).collect();
        let mut control_points = [0; 16];
        control_points.iter_mut().zip(0..).for_each(|(point, index)| *point = index);
        let surface = PatchSurface::new(points, vec![Patch { control_points }]).unwrap();
        let levels = TessellationLevels::uniform(&surface, 64);
        let mesh = tessellated(&surface, &levels, "wild", 0);
        assert!(surface.bounds().contains(&mesh.bounds), "{seed}");
    }
}

#[test]
fn levels_are_those_of_the_edge_and_the_view() {
    let surface = ball();
    let view =
        |piece_px| TessellationView { to_clip: Mat4::IDENTITY, size_px: [200, 100], piece_px };
    let levels = TessellationLevels::new(&surface, &view(5.0), None);
    for (edge, level) in surface.edges().iter().zip(levels.of_edges()) {
        let mut points = surface.places_of(*edge);
        if edge.is_collapsed() {
            assert_eq!(*level, 1);
        }
        points.reverse();
        // The same edge of another surface, whose patch runs the other way.
        let mut control_points = [0; 16];
        control_points.iter_mut().zip(0..).for_each(|(point, index)| *point = index.min(3));
        let other = PatchSurface::new(points.to_vec(), vec![Patch { control_points }]).unwrap();
        let of_other = TessellationLevels::new(&other, &view(5.0), None);
        assert_eq!(of_other.of_edge(other.sides()[0][0]), *level);
    }
    let of_patch = levels.of_patch(&surface, 0);
    assert_eq!(surface.sides()[0].map(|edge| levels.of_edge(edge)).iter().max(), Some(&of_patch));
    let finer = TessellationLevels::new(&surface, &view(2.0), None);
    assert!(levels.of_edges().iter().zip(finer.of_edges()).all(|(coarse, fine)| coarse <= fine));
    let camera = Camera {
        eye: vec3(0.0, 0.0, 3.0),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    };
    let view = CullView::new(&camera, [640, 480], 8);
    let near = TessellationView::new(&view, &Affine3A::IDENTITY, 8.0);
    let away = TessellationView::new(&view, &Affine3A::from_translation(vec3(0.0, 0.0, -9.0)), 8.0);
    let behind =
        TessellationView::new(&view, &Affine3A::from_translation(vec3(0.0, 0.0, 9.0)), 8.0);
    let most = |view| {
        let levels = TessellationLevels::new(&surface, &view, None);
        levels.of_edges().iter().copied().max().unwrap()
    };
    assert!(most(near) > most(away) && most(away) > 1);
    assert_eq!(most(behind), 1);
}

#[test]
fn levels_do_not_flicker() {
    let surface = ball();
    let view =
        |piece_px| TessellationView { to_clip: Mat4::IDENTITY, size_px: [200, 200], piece_px };
    let mut before = None;
    let mut changes = 0;
    for step in 0..100 {
        let piece_px = if step % 2 == 0 { 10.0 } else { 10.9 };
        let levels = TessellationLevels::new(&surface, &view(piece_px), before.as_ref());
        changes += usize::from(before.is_some_and(|before| before != levels));
        before = Some(levels);
    }
    assert!(changes <= 1, "{changes}");
    let plain = |piece_px| TessellationLevels::new(&surface, &view(piece_px), None);
    let far = TessellationLevels::new(&surface, &view(100.0), before.as_ref());
    assert_eq!(far, plain(100.0), "great changes are followed at once");
}

#[test]
fn what_is_no_surface_is_refused() {
    let patch = Patch { control_points: [0; 16] };
    let points = vec![Vec3::ZERO];
    assert_eq!(PatchSurface::new(points.clone(), Vec::new()), Err(PatchError::NoPatches));
    let far = PatchSurface::new(vec![Vec3::X, Vec3::INFINITY], vec![patch]);
    assert_eq!(far, Err(PatchError::NotFinite { point: 1 }));
    let nowhere = PatchSurface::new(vec![Vec3::NAN], vec![patch]);
    assert_eq!(nowhere, Err(PatchError::NotFinite { point: 0 }));
    let missing = Patch { control_points: [7; 16] };
    let refused = PatchSurface::new(points.clone(), vec![patch, missing]);
    assert_eq!(refused, Err(PatchError::NoSuchPoint { patch: 1, point: 7, points: 1 }));
    let many = PatchSurface::new(points, vec![patch; MAX_PATCHES + 1]);
    assert_eq!(many, Err(PatchError::TooManyPatches { patches: MAX_PATCHES + 1 }));
}
