//! Meshes and materials that are added and removed while a renderer runs. Images equal those of a
//! renderer that was created with them.

mod refusals;
mod scenes;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use cull::{Camera, ObjectId, Projection, Strategy};
use glam::{Vec3, vec3};
use gpu::{Device, OptionalFeature, Purpose, Readback};
use render::{Error, FrameRequest, RenderView, Renderer, SpareCapacity};
use scene::{
    Encoding, ImageId, Material, MaterialId, Mesh, MeshId, Object, ObjectChange, PreparedMesh,
    PreparedTexture, SurfaceMesh, Surfaces, Texture, TextureId, TextureUse,
};
use tests::host_device::Host;
use tests::walk::pixels_that_differ;
use tests::window_fixture::Random;
use tests::{drivers, run_on_all};

use self::scenes::{
    COARSE, FINEST, FIRST_MATERIALS, FIRST_TEXTURES, Kind, SIZE, SPARE, first_scene, object,
    options_of, some_material, some_mesh, some_texture, spare, uses,
};

/// A renderer, and the scene that it should show.
struct Stream {
    kind: Kind,
    renderer: Renderer,
    views: [RenderView; 2],
    images: [Readback; 2],
    meshes: BTreeMap<MeshId, PreparedMesh>,
    materials: BTreeMap<MaterialId, Material>,
    textures: BTreeMap<TextureId, PreparedTexture>,
    objects: BTreeMap<ObjectId, Object>,
    frame: u32,
    added: u32,
    refused: u32,
    refused_materials: u32,
    added_textures: u32,
    refused_textures: u32,
}

impl Stream {
    fn new(device: &Device, kind: Kind) -> Self {
        let scene = first_scene(kind);
        let scene = Arc::new(scene);
        let mut renderer = Renderer::new(device, &scene, &options_of(kind, spare(kind))).unwrap();
        renderer.keep_scene(Arc::clone(&scene)).unwrap();
        let ids = (0..).map(ObjectId);
        let prepared = |(number, mesh): (usize, &Mesh)| {
            let surface = scene.surfaces.as_ref().map(|all| all.meshes[number].clone());
            let prepared = match surface {
                Some(surface) => PreparedMesh::with_surface(mesh.clone(), surface, Vec::new()),
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
            textures: BTreeMap::new(),
            objects: ids.zip(scene.objects.iter().copied()).collect(),
            frame: 0,
            added: 0,
            refused: 0,
            refused_materials: 0,
            added_textures: 0,
            refused_textures: 0,
        }
    }

    fn camera(&self) -> Camera {
        let eye = vec3((self.frame as f32 * 0.1).sin() * 1.5, 0.3, 7.0);
        let projection = Projection::perspective(0.9);
        Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 }
    }

    /// Returns textures of colours and of numbers, which are new if there is room.
    fn textures(&mut self, random: &mut Random) -> [TextureId; 2] {
        let new = some_texture(random);
        match self.renderer.add_textures(vec![new.clone()]) {
            Ok(ids) => {
                self.added_textures += 1;
                assert!(self.textures.insert(ids[0], new).is_none(), "{ids:?} were there");
            }
            Err(Error::CapacityExceeded { .. }) => self.refused_textures += 1,
            Err(error) => panic!("{error}"),
        }
        [(Encoding::Srgb, 0), (Encoding::Linear, 1)].map(|(encoding, first)| {
            let mut there: Vec<_> = self.textures.iter().collect();
            there.retain(|(_, texture)| texture.encoding() == encoding);
            let ids = std::iter::once(TextureId(first)).chain(there.iter().map(|(id, _)| **id));
            ids.last().unwrap()
        })
    }

    /// Returns a material for an added mesh, which is new if there is room.
    fn material(&mut self, random: &mut Random) -> MaterialId {
        if self.kind == Kind::Plain {
            return MaterialId(0);
        }
        let textures = self.textures(random);
        let new = some_material(random, textures);
        if random.below(3) == 0 {
            return MaterialId(random.below(2));
        }
        match self.renderer.add_materials(std::slice::from_ref(&new)) {
            Ok(ids) => {
                assert!(self.materials.insert(ids[0], new).is_none(), "{ids:?} were there");
                ids[0]
            }
            Err(Error::CapacityExceeded { .. }) => {
                self.refused_materials += 1;
                let there: Vec<_> = self.materials.keys().copied().collect();
                there[random.below(there.len() as u32) as usize]
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// Removes the added materials that no mesh uses.
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
        let used =
            |id: &TextureId| self.materials.values().any(|material| uses(material).contains(id));
        let (kept, gone): (Vec<_>, Vec<_>) = self.textures.keys().copied().partition(used);
        for id in kept {
            let error = self.renderer.remove_textures(&[id]).unwrap_err().to_string();
            assert!(error.contains("materials use it"), "{error}");
        }
        self.renderer.remove_textures(&gone).unwrap();
        self.textures.retain(|id, _| !gone.contains(id));
    }

    /// Adds meshes with one object each, some of them behind the wall.
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
            Err(Error::CapacityExceeded { .. }) => self.refused += 1,
            Err(error) => panic!("{error}"),
        }
    }

    /// Removes a mesh with its objects, even during its upload.
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

    /// Continues on another device, as after the loss of the first. What was still being uploaded
    /// is there at once.
    fn recover(&mut self, device: &Device) {
        let is_uploading = self.renderer.is_uploading();
        let before = (!is_uploading).then(|| self.draw());
        self.renderer.recover(device).unwrap();
        self.images = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        assert!(self.meshes.keys().all(|id| self.renderer.is_resident(*id)));
        assert!(!self.renderer.is_uploading());
        if let Some(before) = before {
            self.frame -= 1;
            assert_eq!(pixels_that_differ(&before, &self.draw()), 0, "{:?}", self.kind);
        }
    }

    /// Draws a frame with and without culling, checks that both look the same, and returns the
    /// image.
    fn draw(&mut self) -> Vec<u8> {
        let camera = self.camera();
        self.frame += 1;
        let policy = if self.frame.is_multiple_of(8) { FINEST } else { COARSE };
        self.renderer.choose_detail(&[camera], &policy);
        let resident = |stream: &Self| {
            stream.meshes.keys().filter(|id| stream.renderer.is_resident(**id)).count()
        };
        // Repeats the frames if a mesh arrived in between, since only the second frame shows the
        // mesh.
        while {
            let before = resident(self);
            self.draw_by(Strategy::ANTUMBRA, 0, camera);
            resident(self) != before
        } {}
        self.draw_by(Strategy::FRUSTUM, 1, camera);
        self.renderer.device().wait_idle().unwrap();
        let [culled, all] = self.images.each_ref().map(|image| image.rgba8().unwrap().to_vec());
        assert_eq!(pixels_that_differ(&culled, &all), 0, "frame {} of {:?}", self.frame, self.kind);
        culled
    }

    fn draw_by(&mut self, strategy: Strategy, number: usize, camera: Camera) {
        let request = FrameRequest::new(strategy, camera);
        let request = FrameRequest { image: Some(&self.images[number]), ..request };
        self.renderer.render(&mut self.views[number], request).unwrap();
    }

    /// Appends the added textures and materials to those of the first scene.
    fn add_textures_to(&self, surfaces: &mut Surfaces) {
        for (number, texture) in (FIRST_TEXTURES..).zip(self.textures.values()) {
            surfaces.images.push(texture.image().clone());
            let encoding = texture.encoding();
            let sampler = texture.sampler();
            surfaces.textures.push(Texture { image: ImageId(number), encoding, sampler });
        }
        let renamed = |texture_use: TextureUse| {
            let texture = texture_use.texture;
            let texture = match self.textures.range(..texture).count() {
                _ if texture.0 < FIRST_TEXTURES => texture,
                before => TextureId(FIRST_TEXTURES + before as u32),
            };
            TextureUse { texture, ..texture_use }
        };
        surfaces.materials.extend(self.materials.values().map(|material| Material {
            base_colour_texture: material.base_colour_texture.map(renamed),
            metallic_roughness_texture: material.metallic_roughness_texture.map(renamed),
            ..material.clone()
        }));
    }

    /// Draws until everything is uploaded, and compares with a renderer that is created with
    /// everything.
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
        scene.meshes = self.meshes.values().map(|mesh| mesh.mesh().clone()).collect();
        if let Some(surfaces) = &mut scene.surfaces {
            self.add_textures_to(surfaces);
            let renamed = |material: MaterialId| match self.materials.range(..material).count() {
                _ if material.0 < FIRST_MATERIALS => material,
                before => MaterialId(FIRST_MATERIALS + before as u32),
            };
            let surface = |mesh: &PreparedMesh| {
                let surface = mesh.surface().unwrap().clone();
                SurfaceMesh { material: renamed(surface.material), ..surface }
            };
            surfaces.meshes = self.meshes.values().map(surface).collect();
            surfaces.levels = self.meshes.values().map(|mesh| mesh.levels().to_vec()).collect();
        }
        let object = |object: &Object| Object { mesh: MeshId(numbers[&object.mesh]), ..*object };
        scene.objects = self.objects.values().map(object).collect();
        let renderer =
            Renderer::new(device, &scene, &options_of(self.kind, SpareCapacity::default()))
                .unwrap();
        let [view, other] = [(); 2].map(|()| renderer.new_view().unwrap());
        let images = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        let meshes = BTreeMap::new();
        let objects = BTreeMap::new();
        let mut fresh = Self {
            renderer,
            views: [view, other],
            images,
            meshes,
            materials: BTreeMap::new(),
            textures: BTreeMap::new(),
            objects,
            frame: self.frame,
            ..Self { kind: self.kind, ..Self::new(device, self.kind) }
        };
        let streamed = self.draw();
        let fresh = fresh.draw();
        assert_eq!(pixels_that_differ(&streamed, &fresh), 0, "{:?}", self.kind);
    }
}

/// Adds and removes meshes, and sometimes compares images.
fn stream(device: &Device, kind: Kind, rounds: u32) -> Stream {
    let mut random = Random::new(17);
    let mut stream = Stream::new(device, kind);
    for round in 0..rounds {
        stream.add(&mut random);
        (0..random.below(3)).for_each(|_| drop(stream.draw()));
        (0..1 + random.below(2)).for_each(|_| stream.remove(&mut random));
        if round % 8 == 3 {
            stream.recover(device);
        }
        if round % 8 == 7 {
            stream.compare(device);
        }
    }
    stream
}

#[test]
fn meshes_that_come_and_go_look_as_if_they_had_always_been_there() {
    run_on_all(|device| {
        let has_indexing = device.capabilities().has(OptionalFeature::DescriptorIndexing);
        let kinds = [Some(Kind::Plain), Some(Kind::Surfaces), has_indexing.then_some(Kind::Images)];
        for kind in kinds.into_iter().flatten() {
            let stream = stream(device, kind, 48);
            // The room is reused many times, in pieces of all sizes.
            assert!(stream.added > 5 * SPARE.meshes, "{} meshes came", stream.added);
            assert!(stream.refused > 0, "there was always room");
            let had_materials = kind != Kind::Plain;
            assert_eq!(stream.refused_materials > 0, had_materials, "room for materials");
            assert_eq!(stream.added_textures > 10, had_materials, "textures came");
            let had_pages = kind == Kind::Surfaces;
            assert_eq!(stream.refused_textures > 0, had_pages, "room for textures");
        }
    });
}

#[test]
fn a_host_copies_the_image_while_meshes_and_textures_arrive() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let lock = Arc::new(Mutex::new(()));
        let device = host.adopt(Some(host.share_queue(Arc::clone(&lock) as _)));
        let mut stream = Stream::new(&device, Kind::Surfaces);
        let mut random = Random::new(23);
        let mut arriving = 0;
        for _ in 0..24 {
            stream.add(&mut random);
            let camera = stream.camera();
            stream.frame += 1;
            stream.draw_by(Strategy::ANTUMBRA, 0, camera);
            arriving += u32::from(stream.renderer.is_uploading());
            // The only wait is for the host's own copy.
            let copied = host.copy(&*lock, &stream.renderer.finished_image().unwrap());
            device.wait_idle().unwrap();
            assert!(copied == *stream.images[0].rgba8().unwrap(), "{driver:?}");
            stream.remove(&mut random);
        }
        assert!(arriving > 6, "{arriving} frames with something on its way");
        drop((stream, device));
        host.finish();
    }
}

#[test]
fn meshes_come_and_go_on_a_hosts_device() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let device = host.adopt(Some(host.share_queue(Arc::new(Mutex::new(())) as _)));
        assert!(stream(&device, Kind::Surfaces, 16).added > SPARE.meshes);
        drop(device);
        host.finish();
    }
}
