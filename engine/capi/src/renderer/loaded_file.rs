//! A loaded file: its scene, which renderers share, and its animation at rest, which they copy.

use std::collections::HashSet;
use std::ffi::{CStr, CString, OsStr, c_char};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use cull::Camera;
use import::{
    BrokenParts, Cause, GltfScene, ImportError, LoadOptions, SceneAnimator, SceneCamera, ScenePlace,
};
use scene::{Material, MaterialId, Scene};

use crate::error::{AntumbraResult, Failure};
use crate::layout::Versioned;
use crate::pointers::slice;
use crate::renderer::playback::{Playback, missing};
use crate::renderer::scene_begin::SceneBegin;
use crate::renderer::scene_file::{
    ANTUMBRA_BROKEN_PARTS_LEFT_OUT, ANTUMBRA_BROKEN_PARTS_REFUSED, ANTUMBRA_SCENE_PLACE_AS_IN_FILE,
    ANTUMBRA_SCENE_PLACE_NEAR_ORIGIN, AntumbraSceneFileCamera, AntumbraSceneFileClip,
    AntumbraSceneFileDesc, AntumbraSceneFileInfo, AntumbraSceneFileNote,
};

/// Loads a file.
///
/// # Safety
/// As the rules of the interface.
pub(crate) unsafe fn load(desc: &AntumbraSceneFileDesc) -> Result<SceneFile, Failure> {
    let options = options_of(desc)?;
    let go_on = &mut |_| ControlFlow::Continue(());
    // SAFETY: the caller's promise, here and below.
    let (path, folder) = unsafe { (path_of("path", desc.path)?, path_of("folder", desc.folder)?) };
    let loaded = match (path, desc.byte_count) {
        (Some(path), 0) if folder.is_none() => import::load(path, &options, go_on),
        (Some(_), _) => {
            return Err(Failure::argument(
                "desc.path is set beside desc.bytes or desc.folder: a file is at a path, or in \
                 memory",
            ));
        }
        (None, 0) => {
            return Err(Failure::argument(
                "desc.path is null, and desc.byte_count is 0: name a file, or pass its bytes",
            ));
        }
        (None, _) => {
            // SAFETY: as above.
            let bytes = unsafe { slice("desc.bytes", desc.bytes, desc.byte_count) }?;
            import::load_bytes(bytes.to_vec(), folder, &options, go_on)
        }
    };
    SceneFile::new(loaded?)
}

/// Returns the options of loading.
fn options_of(desc: &AntumbraSceneFileDesc) -> Result<LoadOptions, Failure> {
    let broken_parts = match desc.broken_parts {
        ANTUMBRA_BROKEN_PARTS_LEFT_OUT => BrokenParts::LeaveOut,
        ANTUMBRA_BROKEN_PARTS_REFUSED => BrokenParts::Refuse,
        other => {
            let message = format_args!("there is no ANTUMBRA_BROKEN_PARTS_.. {other}");
            return Err(Failure::argument(message));
        }
    };
    let place = match desc.place {
        ANTUMBRA_SCENE_PLACE_AS_IN_FILE => ScenePlace::AsInFile,
        ANTUMBRA_SCENE_PLACE_NEAR_ORIGIN => ScenePlace::NearOrigin,
        other => {
            let message = format_args!("there is no ANTUMBRA_SCENE_PLACE_.. {other}");
            return Err(Failure::argument(message));
        }
    };
    Ok(LoadOptions {
        exposure: factor("exposure", desc.exposure)?,
        unit_m: factor("unit", desc.unit)?,
        broken_parts,
        place,
        ..LoadOptions::default()
    })
}

/// Returns a factor; `None` for the default.
fn factor(name: &str, number: f32) -> Result<Option<f32>, Failure> {
    if number.is_finite() && number >= 0.0 {
        return Ok((number > 0.0).then_some(number));
    }
    Err(Failure::argument(format_args!("desc.{name} is {number}, and must be above 0, or 0")))
}

/// Returns a path of the caller; `None` for null.
///
/// # Safety
/// `text` is null or ends with a 0, and is not written as long as the result is used.
unsafe fn path_of<'a>(name: &str, text: *const c_char) -> Result<Option<&'a Path>, Failure> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    let text = unsafe { CStr::from_ptr(text) }.to_str();
    let text = text.map_err(|_| Failure::argument(format_args!("desc.{name} is not UTF-8")))?;
    Ok(Some(Path::new(OsStr::new(text))))
}

impl From<ImportError> for Failure {
    fn from(error: ImportError) -> Self {
        let ImportError { file, object, reason, cause } = &error;
        match cause {
            Cause::NoMemory => Self::new(AntumbraResult::NoMemory, error),
            // The usual advice names limits, which C cannot raise.
            Cause::TooLarge => Self::new(
                AntumbraResult::BadFile,
                format_args!("{file}: {object}: {reason} (make the scene smaller)"),
            ),
            _ => Self::new(AntumbraResult::BadFile, error),
        }
    }
}

/// A loaded file.
pub(crate) struct SceneFile {
    scene: Arc<Scene>,
    /// The material of meshes that are added to renderers; `None` in a scene without surfaces.
    added_material: Option<MaterialId>,
    /// The animation at rest.
    animator: SceneAnimator,
    cameras: Arc<[SceneCamera]>,
    overview: Camera,
    info: AntumbraSceneFileInfo,
    camera_names: Vec<CString>,
    clip_names: Vec<CString>,
    notes: Vec<CString>,
}

impl SceneFile {
    fn new(loaded: GltfScene) -> Result<Self, Failure> {
        let bounds = loaded.bounds();
        let overview = loaded.overview();
        let origin = loaded.origin_m.to_array();
        let (mut scene, animator, cameras, notes) = SceneAnimator::of(loaded);
        for note in &notes {
            tracing::warn!("{}: {note}", scene.name);
        }
        let notes: Vec<CString> = notes.iter().map(|note| text_in_c(&note.to_string())).collect();
        let info = AntumbraSceneFileInfo {
            cameras: cameras.len() as u32,
            clips: animator.clips().len() as u32,
            lights: scene.surfaces.as_ref().map_or(0, |surfaces| surfaces.lights.len()) as u32,
            notes: notes.len() as u32,
            objects: scene.objects.len() as u64,
            triangles: scene.triangles(),
            bounds: bounds.into(),
            origin,
            ..AntumbraSceneFileInfo::INIT
        };
        Ok(Self {
            added_material: add_matt(&mut scene),
            scene: Arc::new(scene),
            camera_names: cameras.iter().map(|camera| text_in_c(&camera.name)).collect(),
            clip_names: animator.clips().iter().map(|clip| text_in_c(&clip.name)).collect(),
            animator,
            cameras: cameras.into(),
            overview,
            info,
            notes,
        })
    }

    /// Returns the scene for a renderer, with an animation of its own.
    pub fn begin(&self) -> SceneBegin {
        SceneBegin {
            scene: Arc::clone(&self.scene),
            added_material: self.added_material,
            playback: Some(Playback {
                animator: self.animator.clone(),
                cameras: Arc::clone(&self.cameras),
                overview: self.overview,
                removed: HashSet::new(),
            }),
        }
    }

    /// Returns the contents.
    pub fn info(&self) -> &AntumbraSceneFileInfo {
        &self.info
    }

    /// Returns a camera.
    pub fn camera(&self, index: u32) -> Result<AntumbraSceneFileCamera, Failure> {
        let found = self.cameras.get(index as usize).zip(self.camera_names.get(index as usize));
        let found = found.ok_or_else(|| missing("index", index, self.cameras.len(), "cameras"));
        let (camera, name) = found?;
        Ok(AntumbraSceneFileCamera {
            aspect_ratio: camera.aspect_ratio.unwrap_or_default(),
            name: name.as_ptr(),
            ..AntumbraSceneFileCamera::INIT
        })
    }

    /// Returns a clip.
    pub fn clip(&self, index: u32) -> Result<AntumbraSceneFileClip, Failure> {
        let clips = self.animator.clips();
        let found = clips.get(index as usize).zip(self.clip_names.get(index as usize));
        let (clip, name) = found.ok_or_else(|| missing("index", index, clips.len(), "clips"))?;
        Ok(AntumbraSceneFileClip {
            duration: clip.duration_s(),
            name: name.as_ptr(),
            ..AntumbraSceneFileClip::INIT
        })
    }

    /// Returns a note.
    pub fn note(&self, index: u32) -> Result<AntumbraSceneFileNote, Failure> {
        let note = self.notes.get(index as usize);
        let note = note.ok_or_else(|| missing("index", index, self.notes.len(), "notes"))?;
        Ok(AntumbraSceneFileNote { text: note.as_ptr(), ..AntumbraSceneFileNote::INIT })
    }
}

/// Adds the material of meshes that renderers get later, which have vertex colours alone. Returns
/// `None` for a scene without surfaces.
fn add_matt(scene: &mut Scene) -> Option<MaterialId> {
    let materials = &mut scene.surfaces.as_mut()?.materials;
    let id = MaterialId(u32::try_from(materials.len()).ok()?);
    let name = "matt".to_owned();
    materials.push(Material { name, metallic: 0.0, roughness: 1.0, ..Material::default() });
    Some(id)
}

/// Returns text for C. Names in files may contain any letter, so 0 is left out.
fn text_in_c(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}
