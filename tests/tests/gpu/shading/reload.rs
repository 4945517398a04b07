//! A change of shaders between two frames: all passes use the new shaders, or no pass does if one
//! fails.

use std::ffi::CStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use ash::vk;
use cull::{Camera, ChcOptions, FirstPass, ObjectId, Projection, Strategy};
use glam::{Affine3A, Quat, Vec3, vec3};
use gpu::{Device, DeviceOptions, Instance, OptionalFeature, Readback, SampleCount};
use render::{
    CostModel, DebugOverlay, FrameRequest, Rect, RenderView, Renderer, RendererOptions, ShaderSet,
};
use scene::{MeshId, MorphTarget, Object, Scene, SkinnedMesh, SkinnedMeshId};
use tests::fault_injection::{Fault, FaultInjection};
use tests::shapes::coloured_cubes;
use tests::{Driver, instance_with, run_on_all};

const SIZE: [u32; 2] = [160, 90];

/// The mesh that morphs.
const FORM: MeshId = MeshId(2);

fn camera() -> Camera {
    let eye = vec3(0.0, 0.5, 6.0);
    let up = Vec3::Y;
    Camera { eye, forward: Vec3::NEG_Z, up, projection: Projection::perspective(0.9), near: 0.1 }
}

/// Returns coloured cubes; with surfaces also a transparent cube and a morphing one.
fn cubes(has_surfaces: bool) -> Scene {
    let object = |number: u32| {
        // The boxes are larger than the turned cubes, so views also meet a box beside its cube.
        let turn = Quat::from_rotation_y(0.8);
        let at = vec3(number as f32 * 1.6 - 2.4, 0.0, number as f32 * -0.7);
        let transform = Affine3A::from_rotation_translation(turn, at);
        Object { mesh: MeshId(number), transform, tint: u32::MAX }
    };
    let mut scene = coloured_cubes(4, (0..3).map(object).collect());
    if let Some(surfaces) = &mut scene.surfaces {
        surfaces.materials[3].base_colour[3] = 0.5;
        surfaces.transparent = vec![object(3)];
        let vertices = scene.meshes[FORM.0 as usize].vertices.iter();
        let positions = vertices.map(|vertex| [0.0, vertex.position[1], 0.0]).collect();
        let targets = vec![MorphTarget { positions, ..MorphTarget::default() }];
        surfaces.skinned_meshes = vec![SkinnedMesh { mesh: FORM, skin: None, targets }];
    }
    scene.surfaces = scene.surfaces.filter(|_| has_surfaces);
    scene
}

/// A renderer that uses all its passes.
struct Studio {
    renderer: Renderer,
    view: RenderView,
    image: Readback,
    has_surfaces: bool,
}

impl Studio {
    fn new(device: &Device, has_surfaces: bool, shaders: Option<ShaderSet>) -> Self {
        Self::sampled(device, has_surfaces, SampleCount::One, shaders)
    }

    fn sampled(
        device: &Device,
        has_surfaces: bool,
        samples: SampleCount,
        shaders: Option<ShaderSet>,
    ) -> Self {
        let coherent = ChcOptions { first_pass: FirstPass::DepthOnly, ..Default::default() };
        let options = RendererOptions {
            methods: [vec![methods::chc(coherent)], methods::all()].concat(),
            size: SIZE,
            samples,
            cost_model: CostModel::Off,
            shaders,
            ..RendererOptions::default()
        };
        let renderer = Renderer::new(device, &cubes(has_surfaces), &options).unwrap();
        let view = renderer.new_view().unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        Self { renderer, view, image, has_surfaces }
    }

    fn frame(&mut self, strategy: Strategy) -> Vec<u8> {
        let image = Some(&self.image);
        let request = FrameRequest { image, ..FrameRequest::new(strategy, camera()) };
        self.renderer.render(&mut self.view, request).unwrap();
        self.renderer.wait_idle(&mut self.view).unwrap();
        self.image.rgba8().unwrap().to_vec()
    }

    /// Returns the output of each pass, by its shader.
    fn shown(&mut self) -> Vec<(&'static str, Vec<u8>)> {
        let device = self.renderer.device().clone();
        // Debug overlays show the history.
        self.view = self.renderer.new_view().unwrap();
        let mut shown = vec![("objects", self.frame(Strategy::ANTUMBRA))];
        shown.push(("depth first", self.frame(methods::CHC)));
        self.frame(methods::HZB);
        if device.capabilities().has(OptionalFeature::PreciseQueries) {
            self.view.watch(&[ObjectId(0)]).unwrap();
        }
        if self.has_surfaces {
            // A new pose each time, so that it is computed, and the rest pose at the end.
            for weight in [0.5, 1.0, 0.0] {
                self.renderer.set_pose(SkinnedMeshId(0), &[], &[weight]).unwrap();
                shown.push(("poses", self.frame(Strategy::ANTUMBRA)));
            }
        }
        for debug_overlay in [
            DebugOverlay { has_boxes: true, ..DebugOverlay::default() },
            DebugOverlay {
                has_wireframe: device.capabilities().has(OptionalFeature::Wireframe),
                top_down: Some(Rect { origin: [0, 0], size: [40, 40] }),
                ..DebugOverlay::default()
            },
        ] {
            self.renderer.set_debug_overlay(debug_overlay).unwrap();
            shown.push(("debug overlays", self.frame(Strategy::ANTUMBRA)));
        }
        self.renderer.set_debug_overlay(DebugOverlay::default()).unwrap();
        self.renderer.outline(Some(ObjectId(1))).unwrap();
        shown.push(("outline", self.frame(Strategy::ANTUMBRA)));
        self.renderer.outline(None).unwrap();
        if device.capabilities().has(OptionalFeature::FragmentStores) {
            let set = self.renderer.visible_set(&mut self.view, camera(), Rect::whole(SIZE));
            let leaves = set.unwrap().leaves().len();
            shown.push(("seen leaves", vec![leaves as u8]));
        }
        shown
    }
}

/// A folder of shaders that is removed on drop.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

/// Lines of shaders that do not write colours, and their replacements.
const CHANGES: [(&str, &str); 2] = [
    ("seen[leaf], 1u,", "seen[leaf], 0u,"),
    ("vertices[place + 1] = values.y;", "vertices[place + 1] = 0;"),
];

/// Shaders that change the look of everything. It takes long to compile them.
static CHANGED_SHADERS: LazyLock<ShaderSet> = LazyLock::new(compile_changed_shaders);

fn compile_changed_shaders() -> ShaderSet {
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let own = format!("antumbra-reload-{}", std::process::id());
    let folder = Folder(std::env::temp_dir().join(own));
    fs::create_dir(&folder.0).unwrap();
    let mut is_there = [false; CHANGES.len()];
    for entry in fs::read_dir(committed).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if !path.is_file() || name.ends_with(".spv") {
            continue;
        }
        let mut text = fs::read_to_string(&path).unwrap();
        if text.contains("out vec4 colour") {
            let end = text.rfind('}').unwrap();
            text.insert_str(end, "    colour.rgb = colour.gbr;\n");
        }
        for (is_there, (from, to)) in is_there.iter_mut().zip(CHANGES) {
            *is_there |= text.contains(from);
            text = text.replace(from, to);
        }
        fs::write(folder.0.join(name), text).unwrap();
    }
    assert_eq!(is_there, [true; CHANGES.len()], "the shaders have other lines: change the test");
    ShaderSet::compiled_from(&folder.0).unwrap()
}

#[test]
fn every_pass_has_the_other_shaders() {
    let changed = &*CHANGED_SHADERS;
    run_on_all(|device| {
        let one = SampleCount::One;
        let four = SampleCount::Four;
        for (is_sampled, samples) in [(false, one), (true, one), (false, four), (true, four)] {
            let mut studio = Studio::sampled(device, is_sampled, samples, None);
            if studio.renderer.supports(Strategy::ANTUMBRA).is_err() {
                assert!(
                    !device.capabilities().has(OptionalFeature::SampleDepths),
                    "{is_sampled}, {samples:?}"
                );
                continue;
            }
            let before = studio.shown();
            studio.renderer.reload(changed.clone()).unwrap();
            let after = studio.shown();
            let expected =
                Studio::sampled(device, is_sampled, samples, Some(changed.clone())).shown();
            for ((before, after), expected) in before.iter().zip(&after).zip(&expected) {
                assert!(before.1 != after.1, "{}, {is_sampled}, {samples:?}", before.0);
                assert!(after.1 == expected.1, "{}, {is_sampled}, {samples:?}", after.0);
            }
        }
    });
}

/// Returns at least the number of pipelines that a reload creates by `call`. Before that, the
/// reload fails once at every third of them.
fn failures(
    device: &Device,
    studio: &mut Studio,
    call: &'static CStr,
    changed: &ShaderSet,
) -> usize {
    let shown = studio.shown();
    for number in (0..).step_by(3) {
        let code = vk::Result::ERROR_OUT_OF_HOST_MEMORY;
        let fault = Fault { call, fails: number..number + 1, code };
        FaultInjection { faults: vec![fault], ..FaultInjection::default() }.install();
        match studio.renderer.reload(changed.clone()) {
            Ok(()) => {
                FaultInjection::default().install();
                return number;
            }
            Err(error) => assert!(error.to_string().contains("memory"), "{error}"),
        }
        for (expected, found) in shown.iter().zip(studio.shown()) {
            assert!(expected.1 == found.1, "{}, {call:?} {number}", found.0);
        }
        device.wait_idle().unwrap();
    }
    0
}

#[test]
fn a_reload_that_fails_changes_nothing() {
    let changed = &*CHANGED_SHADERS;
    for has_surfaces in [false, true] {
        let instance: Instance = instance_with(FaultInjection::default().entry());
        let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        let mut studio = Studio::new(&device, has_surfaces, None);
        let graphics = failures(&device, &mut studio, c"vkCreateGraphicsPipelines", changed);
        studio.renderer.reload(ShaderSet::embedded().unwrap()).unwrap();
        let compute = failures(&device, &mut studio, c"vkCreateComputePipelines", changed);
        // These include passes that are compiled on first use.
        assert!(graphics >= 14 && compute >= 4, "{graphics}, {compute}");
        drop((studio, device));
        assert_eq!(instance.validation_log().drain(), []);
    }
}

#[test]
fn an_answer_about_the_pointer_outlives_a_reload() {
    run_on_all(|device| {
        let mut studio = Studio::new(device, false, None);
        let mut view = studio.renderer.new_view().unwrap();
        let mut found = |has_reload: bool| {
            let owner = |x: u32| {
                view.point_at(Some([x, 45])).unwrap();
                let request = FrameRequest::new(Strategy::ANTUMBRA, camera());
                studio.renderer.render(&mut view, request).unwrap();
                if has_reload {
                    studio.renderer.reload(ShaderSet::embedded().unwrap()).unwrap();
                }
                studio.renderer.wait_idle(&mut view).unwrap();
                view.pointed().expect("it is over").surface.map(|surface| surface.object)
            };
            (20..140).step_by(12).map(owner).collect::<Vec<_>>()
        };
        let expected = found(false);
        assert!(expected.contains(&None) && expected.contains(&Some(ObjectId(1))), "{expected:?}");
        assert_eq!(found(true), expected);
    });
}
