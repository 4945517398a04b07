//! Compiling at run time: its output equals the committed SPIR-V, and its errors name the line.

use std::path::{Path, PathBuf};

use gpu::Readback;
use render::{FrameRequest, Renderer, RendererOptions, ShaderSet};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::Driver;

use crate::{REGENERATE, committed_spirv, folder, sources};

/// A copy of the shader folder for broken shaders, removed on drop.
struct Copy(PathBuf);

impl Copy {
    fn new(name: &str) -> Self {
        let copy = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("shaders-{name}"));
        let _absent = std::fs::remove_dir_all(&copy);
        std::fs::create_dir_all(&copy).unwrap();
        for entry in std::fs::read_dir(folder()).unwrap() {
            let entry = entry.unwrap();
            if entry.file_type().unwrap().is_file() {
                std::fs::copy(entry.path(), copy.join(entry.file_name())).unwrap();
            }
        }
        Self(copy)
    }

    /// Replaces `from` in the file `name`, which must contain it.
    fn edit(&self, name: &str, from: &str, to: &str) {
        let file = self.0.join(name);
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(from), "{name} has changed: adapt this test");
        std::fs::write(file, text.replace(from, to)).unwrap();
    }

    /// Returns the text of the error of compiling the file `name`.
    fn error_of(&self, name: &str) -> String {
        let error = gpu::compile(&self.0.join(name)).err();
        error.unwrap_or_else(|| panic!("{name} compiles")).to_string()
    }

    /// Returns the number of the first line of the file `name` that contains `text`.
    fn line_of(&self, name: &str, text: &str) -> usize {
        let content = std::fs::read_to_string(self.0.join(name)).unwrap();
        1 + content.lines().position(|line| line.contains(text)).unwrap()
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        let _gone = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn the_committed_spirv_is_what_the_compiler_makes() {
    for name in sources::stages(&folder()).unwrap() {
        let spirv = gpu::compile(&folder().join(&name)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(spirv.name, name);
        // Other versions of shaderc may generate different code: the version of Debian 12 is the
        // reference.
        assert!(
            spirv.to_bytes() == committed_spirv(&name),
            "{name} compiles to other SPIR-V than is committed; {REGENERATE} (with Debian 12's \
             shaderc, 2023.2: another version makes other bytes)"
        );
    }
}

#[test]
fn a_mistake_is_told_with_file_and_line() {
    let copy = Copy::new("mistake");
    copy.edit("proxy.vert", "test = instance_number;", "test = nonsense;");
    let place = format!("proxy.vert:{}: error:", copy.line_of("proxy.vert", "nonsense"));
    let error = copy.error_of("proxy.vert");
    assert!(error.contains(&place) && error.contains("nonsense"), "{place} is not in {error}");
}

#[test]
fn a_mistake_in_an_include_is_told_with_its_own_file_and_line() {
    let copy = Copy::new("include");
    copy.edit("instance.glsl", "(origin - anchor)", "(nowhere - anchor)");
    let place = format!("instance.glsl:{}: error:", copy.line_of("instance.glsl", "nowhere"));
    let error = copy.error_of("opaque.vert");
    assert!(error.contains(&place) && error.contains("nowhere"), "{place} is not in {error}");
}

#[test]
fn a_missing_include_is_named() {
    let copy = Copy::new("missing");
    std::fs::remove_file(copy.0.join("instance.glsl")).unwrap();
    let error = copy.error_of("opaque.vert");
    assert!(error.contains("instance.glsl") && error.contains("opaque.vert"), "{error}");
}

#[test]
fn a_missing_file_is_named() {
    let copy = Copy::new("no-file");
    std::fs::remove_file(copy.0.join("opaque.frag")).unwrap();
    let error = copy.error_of("opaque.frag");
    assert!(error.contains("opaque.frag") && error.contains("No such file"), "{error}");
}

#[test]
fn stages_are_told_by_their_extension() {
    let copy = Copy::new("stage");
    for name in ["proxy.vertex", "proxy", "instance.glsl"] {
        std::fs::copy(copy.0.join("proxy.vert"), copy.0.join(name)).unwrap();
        let error = copy.error_of(name);
        let endings = ".vert, .tesc, .tese, .geom, .frag or .comp";
        assert!(error.contains(name) && error.contains(endings), "{error}");
    }
}

#[test]
fn a_set_with_one_broken_shader_is_refused() {
    let copy = Copy::new("broken-set");
    copy.edit("overlay.frag", "colour = passed_colour;", "colour = passed_colour");
    let error = ShaderSet::compiled_from(&copy.0).unwrap_err().to_string();
    assert!(error.contains("overlay.frag:"), "{error}");
}

/// Returns one frame of a small city, drawn with `shaders`.
fn image(device: &gpu::Device, shaders: Option<ShaderSet>) -> Vec<u8> {
    let GeneratedScene { scene, routes } = city(200, 1).unwrap();
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    let options =
        RendererOptions { methods: methods::all(), size: [160, 90], shaders, ..Default::default() };
    let mut renderer = Renderer::new(device, &scene, &options).unwrap();
    let mut history = renderer.new_view().unwrap();
    let image = Readback::new(device, renderer.size()).unwrap();
    let strategy = cull::Strategy::ANTUMBRA;
    let request =
        FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, path.camera(3)) };
    renderer.render(&mut history, request).unwrap();
    renderer.wait_idle(&mut history).unwrap();
    image.rgba8().unwrap().to_vec()
}

#[test]
fn compiled_and_embedded_shaders_draw_the_same_image() {
    let copy = Copy::new("good");
    let compiled = ShaderSet::compiled_from(&copy.0).unwrap();
    tests::run(Driver::Lavapipe, |device| {
        let embedded = image(device, None);
        let colours: std::collections::BTreeSet<&[u8]> = embedded.chunks_exact(4).collect();
        assert!(colours.len() > 20, "there is a city in the image");
        assert!(image(device, Some(compiled)) == embedded, "the images differ");
    });
}
