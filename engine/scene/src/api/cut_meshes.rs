//! Large meshes of a scene, cut into pieces.

use glam::Vec3;

use crate::pieces::{PieceLimits, PieceMap, spatial_pieces};
use crate::{Mesh, MeshId, Object, Scene, SurfaceMesh, Surfaces, bounds_of_vertices};

impl Scene {
    /// Cuts large meshes into pieces and returns which pieces belong to which object. Each piece is
    /// an object with a box of its own. The pieces of an object take its place in the list, with
    /// its transform and tint. Triangles keep their order within a piece, and a back is in the
    /// piece of its front. Mesh ids stay valid: the first piece keeps the id of its mesh, the other
    /// pieces follow all meshes.
    ///
    /// The image stays the same to the bit, except where triangles of one mesh have equal depths:
    /// in scenes with [`Surfaces`] the renderer's rule for objects decides between them, in other
    /// scenes the first draw wins. A mesh stays whole if it has a skin or morph targets, is a mesh
    /// of sprites, or belongs to a transparent object. Pieces have no coarser levels of detail.
    pub fn cut_large_meshes(&mut self, limits: PieceLimits) -> PieceMap {
        let mut is_whole: Vec<bool> =
            self.meshes.iter().map(|mesh| mesh.indices.len() / 3 <= limits.cut_above).collect();
        for mesh in self.surfaces.iter().flat_map(whole_meshes) {
            if let Some(is_whole) = is_whole.get_mut(mesh.0 as usize) {
                *is_whole = true;
            }
        }
        let mut map = PieceMap::default();
        for (place, is_whole) in is_whole.into_iter().enumerate() {
            let mut meshes = vec![MeshId(place as u32)];
            if !is_whole {
                self.cut_mesh(place, limits.piece, &mut meshes);
            }
            map.meshes.push(meshes);
        }
        let objects = std::mem::take(&mut self.objects);
        for object in objects {
            map.firsts.push(self.objects.len() as u32);
            let own = [object.mesh];
            let meshes = map.meshes.get(object.mesh.0 as usize);
            let meshes = meshes.map_or(own.as_slice(), Vec::as_slice);
            self.objects.extend(meshes.iter().map(|mesh| Object { mesh: *mesh, ..object }));
        }
        map.firsts.push(self.objects.len() as u32);
        map
    }

    /// Replaces a mesh by its first piece, and adds the other pieces, with their surfaces.
    fn cut_mesh(&mut self, place: usize, most: usize, meshes: &mut Vec<MeshId>) {
        let empty = Mesh::of_triangles("", &[]);
        let Some(mesh) = self.meshes.get_mut(place).map(|mesh| std::mem::replace(mesh, empty))
        else {
            return;
        };
        let surface = self.surfaces.as_mut().and_then(|surfaces| surfaces.meshes.get_mut(place));
        let surface =
            surface.map(|surface| (std::mem::take(&mut surface.vertices), surface.material));
        let sides = if mesh.has_backs { 2 } else { 1 };
        let triangles = mesh.indices.as_chunks::<3>().0;
        let count = triangles.len() / sides;
        let at = |vertex: &u32| {
            let vertex = mesh.vertices.get(*vertex as usize);
            vertex.map_or(Vec3::ZERO, |vertex| Vec3::from_array(vertex.position))
        };
        // Thirds first: the sum of three large numbers may overflow.
        let middle = |corners: &[u32; 3]| corners.iter().map(|corner| at(corner) / 3.0).sum();
        let middles: Vec<Vec3> = triangles.iter().take(count).map(middle).collect();
        let mut names = vec![u32::MAX; mesh.vertices.len()];
        let pieces = spatial_pieces(&middles, (most / sides).max(1));
        for (number, piece) in pieces.into_iter().enumerate() {
            let of_side =
                |side: usize| piece.iter().map(move |triangle| *triangle as usize + side * count);
            let own = (0..sides).flat_map(of_side).filter_map(|place| triangles.get(place));
            let own: Vec<[u32; 3]> = own.copied().collect();
            let (indices, picks) = renamed(&own, &mut names);
            let picked = |pick: &u32| mesh.vertices.get(*pick as usize).copied();
            let vertices: Vec<_> = picks.iter().filter_map(picked).collect();
            let name = format!("{}, piece {number}", mesh.name);
            let bounds = bounds_of_vertices(&vertices);
            let made = Mesh { name, vertices, indices, bounds, has_backs: mesh.has_backs };
            let id = if number == 0 { place } else { self.meshes.len() };
            let surface = surface.as_ref().map(|(vertices, material)| SurfaceMesh {
                vertices: picks
                    .iter()
                    .filter_map(|pick| vertices.get(*pick as usize).copied())
                    .collect(),
                material: *material,
            });
            if number == 0 {
                self.put_piece(place, made, surface);
            } else {
                self.push_piece(made, surface);
                meshes.push(MeshId(id as u32));
            }
        }
    }

    fn put_piece(&mut self, place: usize, mesh: Mesh, surface: Option<SurfaceMesh>) {
        if let Some(whole) = self.meshes.get_mut(place) {
            *whole = mesh;
        }
        let Some(surfaces) = &mut self.surfaces else { return };
        if let Some((whole, piece)) = surfaces.meshes.get_mut(place).zip(surface) {
            *whole = piece;
        }
        if let Some(levels) = surfaces.levels.get_mut(place) {
            levels.clear();
        }
    }

    fn push_piece(&mut self, mesh: Mesh, surface: Option<SurfaceMesh>) {
        self.meshes.push(mesh);
        let Some(surfaces) = &mut self.surfaces else { return };
        surfaces.meshes.extend(surface);
        if !surfaces.levels.is_empty() {
            surfaces.levels.push(Vec::new());
        }
    }
}

/// Returns the meshes that stay whole.
fn whole_meshes(surfaces: &Surfaces) -> Vec<MeshId> {
    let skinned = surfaces.skinned_meshes.iter().map(|skinned_mesh| skinned_mesh.mesh);
    let sprites = surfaces.sprites.iter().map(|sprites| sprites.mesh);
    let transparent = surfaces.transparent.iter().map(|object| object.mesh);
    skinned.chain(sprites).chain(transparent).collect()
}

/// Returns new indices of these triangles, and the old index of each vertex that they use, in the
/// order of first use. `names` has an element per vertex, all `u32::MAX` before and after.
fn renamed(triangles: &[[u32; 3]], names: &mut [u32]) -> (Vec<u32>, Vec<u32>) {
    let mut picks = Vec::new();
    let mut indices = Vec::with_capacity(3 * triangles.len());
    for vertex in triangles.as_flattened() {
        let Some(name) = names.get_mut(*vertex as usize) else { continue };
        if *name == u32::MAX {
            *name = picks.len() as u32;
            picks.push(*vertex);
        }
        indices.push(*name);
    }
    for vertex in &picks {
        if let Some(name) = names.get_mut(*vertex as usize) {
            *name = u32::MAX;
        }
    }
    (indices, picks)
}
