//! Meshes and materials that come and go while a renderer runs: it looks like one that was made
//! with them.

mod refusals;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use cull::{Camera, DetailPolicy, ObjectId, Projection, Strategy};
use glam::{Affine2, Affine3A, Vec2, Vec3, vec2, vec3};
use gpu::{Device, Purpose, Readback};
use render::{Costs, Error, FrameRequest, Renderer, RendererOptions, SpareRoom, ViewState};
use scene::{
    Alpha, Encoding, Image, ImageId, LodLevel, Material, MaterialId, Mesh, MeshId, Object,
    ObjectChange, PreparedMesh, Sampler, Scene, SurfaceMesh, SurfaceVertex, Surfaces, Texture,
    TextureId, TextureUse,
};
use tests::host_device::Host;
use tests::stage::Random;
use tests::studio::snorm16;
use tests::walk::pixels_that_differ;
use tests::{Driver, run_on_all};

const SIZE: [u32; 2] = [96, 64];
const SPARE: SpareRoom = SpareRoom {
    lights: 0,
    directional_lights: 0,
    meshes: 9,
    vertices: 400,
    indices: 700,
    levels: 12,
    materials: 5,
};
/// The materials that the renderer begins with.
const FIRST_MATERIALS: u32 = 3;
const FINEST: DetailPolicy = DetailPolicy { error_pixels: 0.0, hysteresis: 0.0 };
const COARSE: DetailPolicy = DetailPolicy { error_pixels: 2.0, hysteresis: 0.0 };

/// The scenes: one whose vertices hold the whole appearance, and one with surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Plain,
    Surfaces,
}

/// Returns a mesh of some triangles in a box of two metres; with surfaces it has a coarser level.
fn some_mesh(random: &mut Random, kind: Kind, material: MaterialId) -> PreparedMesh {
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
            let surface = surface_of(&mesh, material);
            PreparedMesh::with_surface(mesh, surface, levels).unwrap()
        }
    }
}

/// Returns a material of any kind that does not blend.
fn some_material(random: &mut Random) -> Material {
    let part = |random: &mut Random| random.below(256) as f32 / 255.0;
    let colours = [(); 3].map(|()| random.below(3));
    let texture_use = |random: &mut Random, texture| {
        let scale = Vec2::splat(1.0 + random.below(4) as f32 / 3.0);
        let transform = Affine2::from_scale_angle_translation(scale, 0.5, vec2(0.1, 0.2));
        let transform = if random.below(2) == 0 { Affine2::IDENTITY } else { transform };
        TextureUse { texture: TextureId(texture), uv_set: 0, transform }
    };
    Material {
        base_colour: [part(random), part(random), part(random), 1.0],
        base_colour_texture: (colours[0] == 0).then(|| texture_use(random, 0)),
        metallic: part(random),
        roughness: part(random),
        metallic_roughness_texture: (colours[1] == 0).then(|| texture_use(random, 1)),
        emission: if colours[2] == 0 { [0.0; 3] } else { [0.2, 0.1, part(random)] },
        alpha: match random.below(3) {
            0 => Alpha::Mask { cutoff: 0.5 },
            _ => Alpha::Opaque,
        },
        is_unlit: random.below(4) == 0,
        ..Material::default()
    }
}

/// Returns an image of four by four texels, some of them with an alpha of 0.
fn image(name: &str, step: usize) -> Image {
    let texel =
        |at: usize| [(at * step % 256) as u8, 90, 200, if at.is_multiple_of(5) { 0 } else { 255 }];
    let rgba8: Vec<u8> = (0..16).flat_map(texel).collect();
    Image { name: name.into(), size: [4, 4], rgba8 }
}

fn surface_of(mesh: &Mesh, material: MaterialId) -> SurfaceMesh {
    let vertex = |vertex: &scene::Vertex| SurfaceVertex {
        normal: snorm16(scene::unpack_normal(vertex.normal).normalize_or_zero(), 0),
        tangent: snorm16(Vec3::X, 1),
        uv: [[vertex.position[0], vertex.position[1]]; 2],
        colour: [u16::MAX; 4],
    };
    let vertices = mesh.vertices.iter().map(vertex).collect();
    SurfaceMesh { vertices, material }
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
    let texture =
        |image, encoding| Texture { image: ImageId(image), encoding, sampler: Sampler::default() };
    let texture_use = |texture| {
        let texture = TextureId(texture);
        Some(TextureUse { texture, uv_set: 0, transform: Affine2::IDENTITY })
    };
    let glass = Material {
        base_colour_texture: texture_use(0),
        metallic_roughness_texture: texture_use(1),
        ..glass
    };
    let surfaces = Surfaces {
        meshes: meshes.iter().map(|mesh| surface_of(mesh, MaterialId(0))).collect(),
        images: vec![image("colours", 37), image("numbers", 11)],
        textures: vec![texture(0, Encoding::Srgb), texture(1, Encoding::Linear)],
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
    materials: BTreeMap<MaterialId, Material>,
    objects: BTreeMap<ObjectId, Object>,
    frame: u32,
    added: u32,
    refused: u32,
    refused_materials: u32,
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
            materials: BTreeMap::new(),
            objects: ids.zip(scene.objects.iter().copied()).collect(),
            frame: 0,
            added: 0,
            refused: 0,
            refused_materials: 0,
        }
    }

    fn camera(&self) -> Camera {
        let eye = vec3((self.frame as f32 * 0.1).sin() * 1.5, 0.3, 7.0);
        let projection = Projection::perspective(0.9);
        Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 }
    }

    /// Returns a material for a mesh that comes, a new one where there is room.
    fn material(&mut self, random: &mut Random) -> MaterialId {
        let new = some_material(random);
        if self.kind == Kind::Plain || random.below(3) == 0 {
            return MaterialId(random.below(2));
        }
        match self.renderer.add_materials(std::slice::from_ref(&new)) {
            Ok(ids) => {
                assert!(self.materials.insert(ids[0], new).is_none(), "{ids:?} were there");
                ids[0]
            }
            Err(Error::NoRoom { .. }) => {
                self.refused_materials += 1;
                let there: Vec<_> = self.materials.keys().copied().collect();
                there[random.below(there.len() as u32) as usize]
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// Removes the materials that came and that no mesh has.
    fn remove_materials(&mut self) {
        let used = |id: &MaterialId| {
            let mut meshes = self.meshes.values();
            meshes.any(|mesh| mesh.surface().is_some_and(|surface| surface.material == *id))
        };
        let (kept, gone): (Vec<_>, Vec<_>) = self.materials.keys().copied().partition(used);
        for id in kept {
            let error = self.renderer.remove_materials(&[id]).unwrap_err().to_string();
            assert!(error.contains("meshes have it"), "{error}");
        }
        self.renderer.remove_materials(&gone).unwrap();
        self.materials.retain(|id, _| !gone.contains(id));
    }

    /// Adds meshes with an object each, some of them behind the wall.
    fn add(&mut self, random: &mut Random) {
        let kind = self.kind;
        let mut meshes = Vec::new();
        for _ in 0..1 + random.below(3) {
            let material = self.material(random);
            meshes.push(some_mesh(random, kind, material));
        }
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
        self.remove_materials();
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
            surfaces.materials.extend(self.materials.values().cloned());
            let renamed = |material: MaterialId| match self.materials.range(..material).count() {
                _ if material.0 < FIRST_MATERIALS => material,
                before => MaterialId(FIRST_MATERIALS + before as u32),
            };
            let surface = |mesh: &PreparedMesh| {
                let surface = mesh.surface().unwrap().clone();
                SurfaceMesh { material: renamed(surface.material), ..surface }
            };
            surfaces.meshes = self.meshes.values().map(surface).collect();
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
            materials: BTreeMap::new(),
            objects,
            frame: self.frame,
            ..Self { kind: self.kind, ..Self::new(device, self.kind) }
        };
        let [streamed, fresh] = [self.draw(), fresh.draw()];
        assert_eq!(pixels_that_differ(&streamed, &fresh), 0, "{:?}", self.kind);
    }
}

/// Lets meshes come and go, and compares now and then.
fn stream(device: &Device, kind: Kind, rounds: u32) -> Stream {
    let mut random = Random::new(17);
    let mut stream = Stream::new(device, kind);
    for round in 0..rounds {
        stream.add(&mut random);
        (0..random.below(3)).for_each(|_| drop(stream.draw()));
        (0..1 + random.below(2)).for_each(|_| stream.remove(&mut random));
        if round % 8 == 7 {
            stream.compare(device);
        }
    }
    stream
}

#[test]
fn meshes_that_come_and_go_look_as_if_they_had_always_been_there() {
    run_on_all(|device| {
        for kind in [Kind::Plain, Kind::Surfaces] {
            let stream = stream(device, kind, 48);
            // The room is taken again and again, in pieces of all sizes.
            assert!(stream.added > 5 * SPARE.meshes, "{} meshes came", stream.added);
            assert!(stream.refused > 0, "there was always room");
            let had_materials = kind == Kind::Surfaces;
            assert_eq!(stream.refused_materials > 0, had_materials, "room for materials");
        }
    });
}

#[test]
fn meshes_come_and_go_on_a_hosts_device() {
    for driver in Driver::ALL {
        let host = Host::new(driver, Purpose::Renderer);
        let device = host.adopt(Some(host.share_queue(Arc::new(Mutex::new(())) as _)));
        assert!(stream(&device, Kind::Surfaces, 16).added > SPARE.meshes);
        drop(device);
        assert!(host.messages().is_empty(), "{:#?}", host.messages());
        host.finish();
    }
}
