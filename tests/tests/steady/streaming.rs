//! A renderer after meshes, materials, textures and lights were added and removed. Without further
//! additions it creates no Vulkan object and allocates no memory.

use cull::{Camera, Projection, Strategy};
use glam::{Affine2, Affine3A, Vec3, vec3};
use gpu::{Device, DeviceOptions};
use render::{CostModel, FrameRequest, Renderer, RendererOptions, SpareCapacity, TextureCapacity};
use scene::{
    Encoding, Image, LightKind, Material, MaterialId, Mesh, MeshId, Object, ObjectChange,
    PreparedMesh, PreparedTexture, PunctualLight, Sampler, Scene, Surfaces, TextureUse,
};
use tests::counting::allocations;
use tests::fault_injection::FaultInjection;
use tests::shapes::{cube, surface_of};
use tests::{Driver, instance_with};

use super::renderer::made;

const FRAMES: usize = 60;

fn prepared(mesh: &Mesh, material: MaterialId) -> PreparedMesh {
    let surface = surface_of(mesh, material);
    PreparedMesh::with_surface(mesh.clone(), surface, Vec::new()).unwrap()
}

fn object(mesh: MeshId, at: Vec3) -> Object {
    Object { mesh, transform: Affine3A::from_translation(at), tint: u32::MAX }
}

fn scene(mesh: &Mesh) -> Scene {
    let mut scene = Scene::single(mesh.clone());
    scene.objects = (0..20).map(|n| object(MeshId(0), Vec3::NEG_Z * 2.0 * n as f32)).collect();
    scene.surfaces = Some(Surfaces {
        meshes: vec![surface_of(mesh, MaterialId(0))],
        materials: vec![Material::default()],
        ..Surfaces::default()
    });
    scene
}

fn options() -> RendererOptions {
    let kind = TextureCapacity {
        size: [16, 16],
        encoding: Encoding::Srgb,
        sampler: Sampler::default(),
        layers: 2,
    };
    RendererOptions {
        size: [96, 64],
        cost_model: CostModel::Off,
        spare_objects: 8,
        spare: SpareCapacity {
            lights: 2,
            directional_lights: 1,
            meshes: 4,
            vertices: 400,
            indices: 400,
            levels: 0,
            materials: 2,
            textures: vec![kind],
        },
        upload_bytes_per_frame: 500,
        ..RendererOptions::default()
    }
}

/// Adds one of each kind, with an object, and removes them; then adds them again.
fn change(renderer: &mut Renderer, mesh: &Mesh) {
    let image = Image::of_rgba8("came", [16, 16], vec![200; 1024]);
    let texture = PreparedTexture::new(image, Encoding::Srgb, Sampler::default()).unwrap();
    for is_kept in [false, true] {
        let texture = renderer.add_textures(vec![texture.clone()]).unwrap()[0];
        let use_of = TextureUse { texture, uv_set: 0, transform: Affine2::IDENTITY };
        let material = Material { base_colour_texture: Some(use_of), ..Material::default() };
        let material = renderer.add_materials(&[material]).unwrap()[0];
        let mesh = renderer.add_meshes(vec![prepared(mesh, material)]).unwrap()[0];
        let lamp = PunctualLight {
            kind: LightKind::Point,
            colour: [1.0; 3],
            intensity: 5.0,
            range_m: None,
            position: vec3(2.0, 2.0, 2.0),
            direction: Vec3::NEG_Z,
            cookie: None,
        };
        let lights = renderer.add_lights(&[lamp]).unwrap();
        let change = ObjectChange::Add { object: object(mesh, vec3(2.5, 0.0, 0.0)) };
        let added = renderer.update(&[change]).unwrap().added[0];
        if !is_kept {
            renderer.update(&[ObjectChange::Remove { object: added }]).unwrap();
            renderer.remove_meshes(&[mesh]).unwrap();
            renderer.remove_materials(&[material]).unwrap();
            renderer.remove_textures(&[texture]).unwrap();
            renderer.remove_lights(&lights).unwrap();
        }
    }
}

#[test]
fn a_renderer_that_things_came_to_is_at_rest_again() {
    for driver in Driver::ALL {
        let instance = instance_with(FaultInjection::default().entry());
        let adapter = instance.pick_adapter(Some(driver.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        let mesh = cube(0, 1);
        let mut renderer = Renderer::new(&device, &scene(&mesh), &options()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let eye = vec3(0.5, 0.8, 6.0);
        let projection = Projection::perspective(0.9);
        let camera = Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 };
        let mut draw = |renderer: &mut Renderer| {
            renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, camera)).unwrap();
            view.drain_stats();
        };
        (0..FRAMES).for_each(|_| draw(&mut renderer));

        change(&mut renderer, &mesh);
        assert!(renderer.is_uploading());
        (0..FRAMES).for_each(|_| draw(&mut renderer));
        assert!(!renderer.is_uploading());
        let before = (made(), allocations());
        (0..FRAMES).for_each(|_| draw(&mut renderer));
        assert_eq!((made(), allocations()), before, "{driver:?}");
        device.wait_idle().unwrap();
        drop((view, renderer, device));
        assert_eq!(instance.validation_log().drain(), []);
    }
}
