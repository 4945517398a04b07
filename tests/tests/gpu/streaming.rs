//! Meshes that come and go while a renderer runs: it looks like one that was made with them.

use std::collections::BTreeMap;

use cull::{Camera, DetailPolicy, ObjectId, Projection, Strategy};
use glam::{Affine3A, Vec3, vec3};
use gpu::{Device, Readback};
use render::{Costs, Error, FrameRequest, Renderer, RendererOptions, SpareRoom, ViewState};
use scene::{
    Alpha, LodLevel, Material, MaterialId, Mesh, MeshId, Object, ObjectChange, PreparedMesh, Scene,
    SurfaceMesh, SurfaceVertex, Surfaces,
};
use tests::run_on_all;
use tests::stage::Random;
use tests::studio::snorm16;
use tests::walk::pixels_that_differ;

const SIZE: [u32; 2] = [96, 64];
const SPARE: SpareRoom = SpareRoom {
    lights: 0,
    directional_lights: 0,
    meshes: 9,
    vertices: 400,
    indices: 700,
    levels: 12,
};
const FINEST: DetailPolicy = DetailPolicy { error_pixels: 0.0, hysteresis: 0.0 };
const COARSE: DetailPolicy = DetailPolicy { error_pixels: 2.0, hysteresis: 0.0 };

/// The scenes: one whose vertices hold the whole appearance, and one with surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Plain,
    Surfaces,
}

/// Returns a mesh of some triangles in a box of two metres; with surfaces it has a coarser level.
fn some_mesh(random: &mut Random, kind: Kind) -> PreparedMesh {
    let corner = |random: &mut Random| [0; 3].map(|_| random.below(2_001) as f32 / 1_000.0 - 1.0);
    let triangles = 1 + random.below(30) as usize;
    let colour = [0; 3].map(|_| random.below(256) as f32 / 255.0);
    let corners: Vec<_> = (0..triangles * 3).map(|_| (corner(random), colour)).collect();
    let mesh = Mesh::of_triangles("some", &corners);
    match kind {
        Kind::Plain => PreparedMesh::new(mesh).unwrap(),
        Kind::Surfaces => {
            let levels = match random.below(3) {
                0 => Vec::new(),
                _ => vec![LodLevel {
                    indices: mesh.indices[..triangles / 2 * 3].to_vec(),
                    error_m: 0.3,
                }],
            };
            let surface = surface_of(&mesh, random.below(2));
            PreparedMesh::with_surface(mesh, surface, levels).unwrap()
        }
    }
}

fn surface_of(mesh: &Mesh, material: u32) -> SurfaceMesh {
    let vertex = |vertex: &scene::Vertex| SurfaceVertex {
        normal: snorm16(scene::unpack_normal(vertex.normal).normalize_or_zero(), 0),
        tangent: snorm16(Vec3::X, 1),
        uv: [[0.0; 2]; 2],
        colour: [u16::MAX; 4],
    };
    let vertices = mesh.vertices.iter().map(vertex).collect();
    SurfaceMesh { vertices, material: MaterialId(material) }
}

/// Returns a wall with a mesh beside it, as the renderer begins.
fn first_scene(kind: Kind) -> Scene {
    let [a, b] = [[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0]];
    let [c, d] = [[2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]];
    let wall = Mesh::of_triangles("wall", &[a, b, c, a, c, d].map(|it| (it, [0.5; 3])));
    let beside = Mesh::of_triangles("beside", &[a, b, c].map(|it| (it, [0.9, 0.2, 0.1])));
    let meshes = vec![wall, beside];
    let glass = Material { alpha: Alpha::Blend, ..Material::default() };
    let red =
        Material { base_colour: [0.8, 0.1, 0.1, 1.0], emission: [0.2; 3], ..Material::default() };
    let surfaces = Surfaces {
        meshes: meshes.iter().map(|mesh| surface_of(mesh, 0)).collect(),
        materials: vec![Material { emission: [0.1, 0.2, 0.3], ..Material::default() }, red, glass],
        ..Surfaces::default()
    };
    let mut scene = Scene::single(meshes[0].clone());
    scene.objects = vec![object(0, Vec3::ZERO), object(1, vec3(2.5, 0.0, -1.0))];
    scene.meshes = meshes;
    scene.surfaces = (kind == Kind::Surfaces).then_some(surfaces);
    scene
}

fn object(mesh: u32, at: Vec3) -> Object {
    Object { mesh: MeshId(mesh), transform: Affine3A::from_translation(at), tint: u32::MAX }
}

fn options(spare: SpareRoom) -> RendererOptions {
    RendererOptions {
        size: SIZE,
        costs: Costs::Ignored,
        spare_objects: 40,
        spare,
        // Several frames for most meshes.
        upload_bytes_per_frame: 900,
        ..Default::default()
    }
}

/// A renderer, and what it should show.
struct Stream {
    kind: Kind,
    renderer: Renderer,
    views: [ViewState; 2],
    images: [Readback; 2],
    meshes: BTreeMap<MeshId, PreparedMesh>,
    objects: BTreeMap<ObjectId, Object>,
    frame: u32,
    added: u32,
    refused: u32,
}

impl Stream {
    fn new(device: &Device, kind: Kind) -> Self {
        let scene = first_scene(kind);
        let renderer = Renderer::new(device, &scene, &options(SPARE)).unwrap();
        let ids = (0..).map(ObjectId);
        let prepared = |(number, mesh): (usize, &Mesh)| {
            let surface = scene.surfaces.as_ref().map(|all| all.meshes[number].clone());
            let prepared = match surface {
                Some(it) => PreparedMesh::with_surface(mesh.clone(), it, Vec::new()),
                None => PreparedMesh::new(mesh.clone()),
            };
            (MeshId(number as u32), prepared.unwrap())
        };
        Self {
            kind,
            views: [(); 2].map(|()| renderer.new_view().unwrap()),
            images: [(); 2].map(|()| Readback::new(device, SIZE).unwrap()),
            renderer,
            meshes: scene.meshes.iter().enumerate().map(prepared).collect(),
            objects: ids.zip(scene.objects.iter().copied()).collect(),
            frame: 0,
            added: 0,
            refused: 0,
        }
    }

    fn camera(&self) -> Camera {
        let eye = vec3((self.frame as f32 * 0.1).sin() * 1.5, 0.3, 7.0);
        let projection = Projection::perspective(0.9);
        Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 }
    }

    /// Adds meshes with an object each, some of them behind the wall.
    fn add(&mut self, random: &mut Random) {
        let kind = self.kind;
        let meshes: Vec<_> = (0..1 + random.below(3)).map(|_| some_mesh(random, kind)).collect();
        match self.renderer.add_meshes(meshes.clone()) {
            Ok(ids) => {
                self.added += ids.len() as u32;
                for (id, mesh) in ids.into_iter().zip(meshes) {
                    assert!(self.meshes.insert(id, mesh).is_none(), "{id:?} was there");
                    assert!(!self.renderer.is_resident(id));
                    let x = random.below(60) as f32 / 10.0 - 3.0;
                    let object = object(id.0, vec3(x, 0.0, -1.5 - random.below(4) as f32));
                    let change = ObjectChange::Add { object };
                    let added = self.renderer.update(&[change]).unwrap().added[0];
                    self.objects.insert(added, object);
                }
            }
            Err(Error::NoRoom { .. }) => self.refused += 1,
            Err(error) => panic!("{error}"),
        }
    }

    /// Removes a mesh with its objects, on its way or not.
    fn remove(&mut self, random: &mut Random) {
        let ids: Vec<MeshId> = self.meshes.keys().copied().filter(|id| id.0 > 0).collect();
        let Some(id) = ids.get(random.below(ids.len().max(1) as u32) as usize).copied() else {
            return;
        };
        let users = self.objects.iter().filter(|(_, object)| object.mesh == id);
        let users: Vec<ObjectId> = users.map(|(object, _)| *object).collect();
        if !users.is_empty() {
            let error = self.renderer.remove_meshes(&[id]).unwrap_err().to_string();
            assert!(error.contains("objects have it"), "{error}");
        }
        for object in users {
            self.renderer.update(&[ObjectChange::Remove { object }]).unwrap();
            self.objects.remove(&object);
        }
        self.renderer.remove_meshes(&[id]).unwrap();
        self.meshes.remove(&id);
    }

    /// Draws a frame with culling and without, which look the same, and returns the image.
    fn draw(&mut self) -> Vec<u8> {
        let camera = self.camera();
        self.frame += 1;
        let policy = if self.frame.is_multiple_of(8) { FINEST } else { COARSE };
        self.renderer.choose_detail(&[camera], &policy);
        let resident = |stream: &Self| {
            stream.meshes.keys().filter(|id| stream.renderer.is_resident(**id)).count()
        };
        // Again where a mesh arrived in between: the second frame shows it, the first does not.
        while {
            let before = resident(self);
            self.draw_by(Strategy::ANTUMBRA, 0, camera);
            resident(self) != before
        } {}
        self.draw_by(Strategy::FRUSTUM, 1, camera);
        self.renderer.device().drain().unwrap();
        let [culled, all] = self.images.each_ref().map(|image| image.rgba8().unwrap().to_vec());
        assert_eq!(pixels_that_differ(&culled, &all), 0, "frame {} of {:?}", self.frame, self.kind);
        culled
    }

    fn draw_by(&mut self, strategy: Strategy, number: usize, camera: Camera) {
        let request = FrameRequest::new(strategy, camera);
        let request = FrameRequest { image: Some(&self.images[number]), ..request };
        self.renderer.render(&mut self.views[number], &request).unwrap();
    }

    /// Draws until everything is there, and compares with a renderer that is made of it.
    fn compare(&mut self, device: &Device) {
        let mut frames = 0;
        while self.renderer.is_uploading() {
            self.draw();
            frames += 1;
            assert!(frames < 100, "meshes never arrive");
        }
        assert!(self.meshes.keys().all(|id| self.renderer.is_resident(*id)));
        let mut scene = first_scene(self.kind);
        let numbers: BTreeMap<MeshId, u32> = self.meshes.keys().copied().zip(0..).collect();
        scene.meshes = self.meshes.values().map(|it| it.mesh().clone()).collect();
        if let Some(surfaces) = &mut scene.surfaces {
            surfaces.meshes =
                self.meshes.values().map(|it| it.surface().unwrap().clone()).collect();
            surfaces.levels = self.meshes.values().map(|it| it.levels().to_vec()).collect();
        }
        let object = |it: &Object| Object { mesh: MeshId(numbers[&it.mesh]), ..*it };
        scene.objects = self.objects.values().map(object).collect();
        let renderer = Renderer::new(device, &scene, &options(SpareRoom::default())).unwrap();
        let [view, other] = [(); 2].map(|()| renderer.new_view().unwrap());
        let images = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        let (meshes, objects) = (BTreeMap::new(), BTreeMap::new());
        let mut fresh = Self {
            renderer,
            views: [view, other],
            images,
            meshes,
            objects,
            frame: self.frame,
            ..Self { kind: self.kind, ..Self::new(device, self.kind) }
        };
        let [streamed, fresh] = [self.draw(), fresh.draw()];
        assert_eq!(pixels_that_differ(&streamed, &fresh), 0, "{:?}", self.kind);
    }
}

#[test]
fn meshes_that_come_and_go_look_as_if_they_had_always_been_there() {
    run_on_all(|device| {
        for kind in [Kind::Plain, Kind::Surfaces] {
            let mut random = Random::new(17);
            let mut stream = Stream::new(device, kind);
            for round in 0..48 {
                stream.add(&mut random);
                (0..random.below(3)).for_each(|_| drop(stream.draw()));
                (0..1 + random.below(2)).for_each(|_| stream.remove(&mut random));
                if round % 8 == 7 {
                    stream.compare(device);
                }
            }
            // The room is taken again and again, in pieces of all sizes.
            assert!(stream.added > 5 * SPARE.meshes, "{} meshes came", stream.added);
            assert!(stream.refused > 0, "there was always room");
        }
    });
}

#[test]
fn a_mesh_that_does_not_fit_is_refused_by_name_and_changes_nothing() {
    run_on_all(|device| {
        let mut random = Random::new(5);
        let spare = SpareRoom { meshes: 1, ..SPARE };
        let [plain, surfaces] = [Kind::Plain, Kind::Surfaces].map(first_scene);
        let mut plain = Renderer::new(device, &plain, &options(spare)).unwrap();
        let mut lit = Renderer::new(device, &surfaces, &options(spare)).unwrap();
        let [bare, whole] = [Kind::Plain, Kind::Surfaces].map(|it| some_mesh(&mut random, it));
        let of = |material| {
            let surface = surface_of(whole.mesh(), material);
            PreparedMesh::with_surface(whole.mesh().clone(), surface, Vec::new()).unwrap()
        };
        let refused = |renderer: &mut Renderer, meshes: Vec<PreparedMesh>, reason: &str| {
            let error = renderer.add_meshes(meshes).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        };
        refused(&mut plain, vec![whole.clone()], "mesh 0 of those named");
        refused(&mut lit, vec![whole.clone(), bare.clone()], "mesh 1 of those named");
        refused(&mut lit, vec![of(2)], "blends");
        refused(&mut lit, vec![of(3)], "does not have its material");
        refused(&mut plain, vec![bare.clone(); 2], "no room for 1 meshes");
        let added = plain.add_meshes(vec![bare.clone()]).unwrap();
        refused(&mut plain, vec![bare.clone()], "RendererOptions::spare");
        let twice = plain.remove_meshes(&[added[0], added[0]]).unwrap_err().to_string();
        assert!(twice.contains("named twice"), "{twice}");
        let unknown = plain.remove_meshes(&[added[0], MeshId(77)]).unwrap_err().to_string();
        assert!(unknown.contains("no such mesh"), "{unknown}");
        let scene = first_scene(Kind::Surfaces);
        for (spare, reason) in [
            (SpareRoom { meshes: u32::MAX, ..SPARE }, "no memory for meshes"),
            (SpareRoom { levels: u32::MAX, ..SPARE }, "no memory for meshes"),
            (SpareRoom { vertices: u32::MAX, ..SPARE }, "vertices, with room"),
            (SpareRoom { indices: u32::MAX, ..SPARE }, "indices, with room"),
            (SpareRoom { lights: u32::MAX, ..SPARE }, "lights"),
        ] {
            let error = Renderer::new(device, &scene, &options(spare)).err().unwrap().to_string();
            assert!(error.contains(reason), "{error}");
        }
        plain.remove_meshes(&added).unwrap();
        assert!(!plain.is_uploading() && !plain.is_resident(added[0]));
        let gone = Object { mesh: added[0], ..object(0, Vec3::ZERO) };
        let error = plain.update(&[ObjectChange::Add { object: gone }]).unwrap_err().to_string();
        assert!(error.contains("no such mesh"), "{error}");
        assert_eq!(plain.add_meshes(vec![bare]).unwrap(), added);
    });
}
