//! Tests that the ground has no cracks, within a tile and between tiles.

use std::collections::{HashMap, HashSet};

use scene::Mesh;

use super::super::{city, field};

const EDGE_M: f32 = 32.0;

fn grounds() -> Vec<Mesh> {
    let scenes = [city(1, 0).unwrap().scene, field(1, 0).unwrap().scene];
    let meshes = scenes.into_iter().flat_map(|scene| scene.meshes);
    meshes.filter(|mesh| mesh.name.starts_with("ground")).collect()
}

type Point = [u32; 3];

fn point(mesh: &Mesh, index: u32) -> Point {
    mesh.vertices[index as usize].position.map(f32::to_bits)
}

#[test]
fn each_edge_joins_two_triangles_or_lies_on_the_rim() {
    for mesh in grounds() {
        let mut edges: HashMap<(Point, Point), i32> = HashMap::new();
        for triangle in mesh.indices.chunks_exact(3) {
            for corner in 0..3 {
                let from = point(&mesh, triangle[corner]);
                let to = point(&mesh, triangle[(corner + 1) % 3]);
                *edges.entry((from, to)).or_default() += 1;
            }
        }
        for (&(from, to), &count) in &edges {
            assert_eq!(count, 1, "{}: an edge that is used twice", mesh.name);
            let on_rim = [0, 2].iter().any(|&axis| {
                let at = [from, to].map(|point| f32::from_bits(point[axis]));
                at[0] == at[1] && at[0].abs() == EDGE_M
            });
            let places = [from, to].map(|point| point.map(f32::from_bits));
            assert_eq!(edges.contains_key(&(to, from)), !on_rim, "{}: {places:?}", mesh.name);
        }
    }
}

#[test]
fn opposite_rims_have_the_same_vertices_and_are_binary_fractions() {
    let meshes = grounds();
    let rim = |mesh: &Mesh, axis: usize, side: f32| -> HashSet<[u32; 2]> {
        let on_rim = mesh.vertices.iter().filter(|vertex| vertex.position[axis] == side);
        on_rim
            .map(|vertex| [vertex.position[1], vertex.position[2 - axis]].map(f32::to_bits))
            .collect()
    };
    for mesh in &meshes {
        for axis in [0, 2] {
            assert!(rim(mesh, axis, EDGE_M).len() > 4);
            assert_eq!(rim(mesh, axis, EDGE_M), rim(mesh, axis, -EDGE_M), "{}", mesh.name);
        }
        for vertex in &mesh.vertices {
            assert!(vertex.position.iter().all(|part| (part * 64.0).fract() == 0.0));
        }
    }
    // The two kinds of city ground are adjacent.
    assert_eq!(rim(&meshes[0], 0, EDGE_M), rim(&meshes[1], 0, EDGE_M));
}

#[test]
fn tiles_lie_on_a_grid_of_binary_fractions() {
    for scene in [city(5000, 1).unwrap().scene, field(5000, 1).unwrap().scene] {
        let mut taken = HashSet::new();
        for object in scene.objects.iter().filter(|object| super::is_ground(&scene, object)) {
            let place = object.transform.translation;
            assert_eq!(object.transform.matrix3, glam::Mat3A::IDENTITY);
            assert!([place.x, place.z].iter().all(|part| part.rem_euclid(64.0) == 32.0));
            assert!(taken.insert([place.x, place.z].map(f32::to_bits)), "two tiles at {place}");
        }
        assert!(taken.len() > 100);
    }
}
