//! Programs whose content comes, moves and goes while they draw.

use std::error::Error;
use std::ops::ControlFlow;
use std::sync::mpsc::{Sender, channel};

use cull::Strategy;
use gltf_files::files;
use gpu::{CancellationToken, Device, MipGeneration, TextureArray, TextureArrayInfo, vk};
use import::{LoadOptions, SceneAnimator};
use render::{Renderer, RendererOptions, SpareCapacity, TextureCapacity};
use scene::{
    Encoding, Image, Material, Object, ObjectChange, PreparedMesh, PreparedTexture, Sampler,
    SurfaceMesh, TextureUse,
};
use tests::shadow_scene;

use super::running::Running;
use super::{Outcome, Program, SIZE, Stage, aside, device_options};

/// The side of textures that come.
const SIDE: u32 = 4;

/// Returns the scene of a file with textures, a light, a skin and a morph target.
fn load_file() -> Result<import::GltfScene, import::ImportError> {
    let bytes = files::everything().glb();
    import::load_bytes(bytes, None, &LoadOptions::default(), &mut |_| ControlFlow::Continue(()))
}

impl Program {
    /// Loads a file while another scene runs, and shows it.
    pub(super) fn load(&self, stage: &Stage) -> Outcome {
        let device = stage.device(&device_options())?;
        let mut running = Running::new(&device, &self.scene, &self.options())?;
        let before = self.show(&mut running)?;
        let open = || {
            let imported = load_file()?;
            let camera = imported.default_camera(SIZE);
            let mut opened = Running::new(&device, &imported.scene, &self.options())?;
            opened.draw(&[camera], &[Strategy::ANTUMBRA])
        };
        open().map_err(|error| running.still_shows(self.last_camera(), &before, error))
    }

    /// Plays a skinned mesh with a morph target.
    pub(super) fn animate(&self, stage: &Stage) -> Outcome {
        let device = stage.device(&device_options())?;
        let imported = load_file()?;
        let camera = imported.default_camera(SIZE);
        let (scene, mut animator, ..) = SceneAnimator::of(imported);
        let mut running = Running::new(&device, &scene, &self.options())?;
        animator.play(&[0], 0.0, 0.0);
        let mut image = running.draw(&[camera], &[Strategy::ANTUMBRA])?;
        for step in 1..4 {
            let update = animator.changes(f64::from(step) * 0.3);
            let change = |renderer: &mut Renderer| Ok(renderer.apply(update).map(drop)?);
            image = running.change(camera, &image, change)?;
        }
        Ok(image)
    }

    /// Adds a light that needs more shadow maps, and moves an object between lit frames.
    pub(super) fn relight(&self, stage: &Stage) -> Outcome {
        let device = stage.device(&device_options())?;
        let spare = SpareCapacity { lights: 2, ..Default::default() };
        let options = RendererOptions { spare, ..self.options() };
        let mut running = Running::new(&device, &self.scene, &options)?;
        self.show(&mut running)?;
        running.renderer.add_lights(&shadow_scene::lights()[2..])?;
        self.show(&mut running)?;
        let transform = aside(self.scene.objects[5].transform);
        running.renderer.update(&[ObjectChange::Move { object: cull::ObjectId(5), transform }])?;
        self.show(&mut running)
    }

    /// Adds a texture, a light and an object in each frame, and removes those before.
    pub(super) fn come_and_go(&self, stage: &Stage) -> Outcome {
        let device = stage.device(&device_options())?;
        let textures = vec![TextureCapacity {
            size: [SIDE; 2],
            encoding: Encoding::Srgb,
            sampler: Sampler::default(),
            layers: 8,
        }];
        let spare = SpareCapacity {
            meshes: 8,
            vertices: 4096,
            indices: 8192,
            materials: 8,
            lights: 4,
            textures,
            ..Default::default()
        };
        let options = RendererOptions { spare, spare_objects: 8, ..self.options() };
        let mut running = Running::new(&device, &self.scene, &options)?;
        let camera = self.last_camera();
        let mut image = self.show(&mut running)?;
        let mut there: Option<Came> = None;
        for number in 0..4 {
            let mut came = None;
            image = running.change(camera, &image, |renderer| {
                came = Some(self.come(renderer, number)?);
                Ok(())
            })?;
            image = running.change(camera, &image, |renderer| {
                let lights = renderer.add_lights(&shadow_scene::lights()[2..])?;
                came.iter_mut().for_each(|came| came.lights.clone_from(&lights));
                Ok(())
            })?;
            if let Some(Came { object, mesh, material, texture, lights }) = there.take() {
                image = running.change(camera, &image, |renderer| {
                    Ok(renderer.update(&[ObjectChange::Remove { object }]).map(drop)?)
                })?;
                image = running.change(camera, &image, |renderer| {
                    renderer.remove_meshes(&[mesh])?;
                    renderer.remove_materials(&[material])?;
                    renderer.remove_textures(&[texture])?;
                    Ok(renderer.remove_lights(&lights)?)
                })?;
            }
            there = came;
        }
        for _ in 0..8 {
            image = running.draw(&[camera], &[Strategy::ANTUMBRA])?;
            if !running.renderer.is_uploading() {
                break;
            }
        }
        Ok(image)
    }

    fn come(&self, renderer: &mut Renderer, number: u8) -> Result<Came, Box<dyn Error>> {
        let texel = [60 * number, 200, 90, 255];
        let image = Image::of_rgba8("came", [SIDE; 2], texel.repeat((SIDE * SIDE) as usize));
        let texture = PreparedTexture::new(image, Encoding::Srgb, Sampler::default())?;
        let texture = renderer.add_textures(vec![texture])?[0];
        let base_colour_texture =
            Some(TextureUse { texture, uv_set: 0, transform: glam::Affine2::IDENTITY });
        let material = Material { base_colour_texture, ..Material::default() };
        let material = renderer.add_materials(&[material])?[0];
        let surfaces = self.scene.surfaces.as_ref().ok_or("surfaces")?;
        let surface = SurfaceMesh { material, ..surfaces.meshes[0].clone() };
        let mesh = PreparedMesh::with_surface(self.scene.meshes[0].clone(), surface, Vec::new())?;
        let mesh = renderer.add_meshes(vec![mesh])?[0];
        let first = self.scene.objects[1];
        let object = Object { mesh, transform: aside(first.transform), ..first };
        let object = renderer.update(&[ObjectChange::Add { object }])?.added[0];
        Ok(Came { object, mesh, material, texture, lights: Vec::new() })
    }

    /// Closes everything while another thread still loads.
    pub(super) fn close_while_loading(&self, stage: &Stage) -> Outcome {
        let device = stage.device(&device_options())?;
        let mut running = Running::new(&device, &self.scene, &self.options())?;
        let image = self.show(&mut running)?;
        let cancellation = CancellationToken::default();
        let (has_begun, begins) = channel();
        let loader = {
            let device = device.clone();
            let cancellation = cancellation.clone();
            std::thread::spawn(move || load_until(&device, &cancellation, &has_begun))
        };
        // No texture comes if its calls fail.
        let _begun = begins.recv();
        drop((running, device));
        cancellation.cancel();
        loader.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        Ok(image)
    }

    fn last_camera(&self) -> cull::Camera {
        self.cameras[self.cameras.len() - 1]
    }
}

/// The content of a frame.
struct Came {
    object: cull::ObjectId,
    mesh: scene::MeshId,
    material: scene::MaterialId,
    texture: scene::TextureId,
    lights: Vec<scene::LightId>,
}

/// Fills textures until it is cancelled, and tells when the first one is filled.
fn load_until(
    device: &Device,
    cancellation: &CancellationToken,
    has_begun: &Sender<()>,
) -> Result<(), gpu::Error> {
    let info = TextureArrayInfo {
        name: "loading",
        size: [64; 2],
        layers: 1,
        format: vk::Format::R8G8B8A8_UNORM,
        wrap: [vk::SamplerAddressMode::REPEAT; 2],
        magnified: vk::Filter::LINEAR,
        minified: vk::Filter::LINEAR,
        between_levels: Some(vk::SamplerMipmapMode::LINEAR),
        anisotropy: 1.0,
        mip_making: MipGeneration::Blits,
    };
    let uploads = gpu::TextureUploads::new(device)?;
    let mut uploads = uploads.cancelled_by(cancellation.clone());
    loop {
        let mut array = TextureArray::new(device, &info)?;
        match uploads.write(&mut array, 0, &[90; 64 * 64 * 4]) {
            Err(gpu::Error::Cancelled) => return Ok(()),
            other => other?,
        }
        let _nobody_listens_for_the_second = has_begun.send(());
    }
}
