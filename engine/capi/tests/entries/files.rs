//! Files of scenes: what they contain, and what is refused, without Vulkan. Devices that cannot be
//! opened.

use std::ffi::{CStr, CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{from_ref, null, null_mut};
use std::sync::Mutex;

use antumbra_capi::api::context::{antumbra_context_create, antumbra_context_destroy};
#[cfg(feature = "loaded")]
use antumbra_capi::api::device_open::antumbra_device_open;
use antumbra_capi::api::playback::*;
use antumbra_capi::api::scene_file::*;
use antumbra_capi::context::{AntumbraContext, AntumbraContextDesc};
use antumbra_capi::decisions::camera::AntumbraCamera;
use antumbra_capi::error::AntumbraError;
use antumbra_capi::error::AntumbraResult::{
    self, BadArgument, BadFile, BadPointer, BadStructSize, Ok, UnknownHandle,
};
#[cfg(feature = "loaded")]
use antumbra_capi::executor::{device::AntumbraDevice, device_open::*};
use antumbra_capi::layout::Versioned;
use antumbra_capi::renderer::frame::AntumbraRenderer;
use antumbra_capi::renderer::scene_file::*;

use crate::{Host, no_error, text};

/// Returns the path of the file of the examples.
fn yard() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/files/yard.gltf")
}

/// Returns a path in C.
fn path_in_c(path: &Path) -> CString {
    CString::new(path.to_str().unwrap()).unwrap()
}

fn load(
    context: *const AntumbraContext,
    desc: &AntumbraSceneFileDesc,
    error: &mut AntumbraError,
) -> (AntumbraResult, AntumbraSceneFile) {
    let mut file = AntumbraSceneFile { id: 0 };
    // SAFETY: pointers to values that live as long as the call.
    let result = unsafe { antumbra_scene_file_load(context, desc, &mut file, error) };
    (result, file)
}

/// Returns text of the library.
fn owned(text: *const c_char) -> String {
    // SAFETY: a text of a file that lives.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
}

#[test]
fn a_file_tells_its_objects_cameras_and_clips() {
    let mut host = Host::new();
    let path = path_in_c(&yard());
    let bytes = std::fs::read(yard()).unwrap();
    let at_path = AntumbraSceneFileDesc { path: path.as_ptr(), ..Versioned::INIT };
    let in_memory =
        AntumbraSceneFileDesc { bytes: bytes.as_ptr(), byte_count: bytes.len(), ..Versioned::INIT };
    for desc in [at_path, in_memory] {
        let (loaded, file) = load(host.context, &desc, &mut host.error);
        assert_eq!(loaded, Ok, "{}", text(&host.error));
        let x = host.context;
        let e = &mut host.error;
        let mut info = AntumbraSceneFileInfo::INIT;
        let mut camera = AntumbraSceneFileCamera::INIT;
        let mut clip = AntumbraSceneFileClip::INIT;
        let mut noted = AntumbraSceneFileNote::INIT;
        // SAFETY: pointers to values on this stack.
        unsafe {
            assert_eq!(antumbra_scene_file_info(x, file, &mut info, e), Ok);
            assert_eq!([info.cameras, info.clips, info.lights, info.notes], [2, 4, 2, 0]);
            assert_eq!((info.objects, info.origin), (17, [0.0; 3]));
            assert!(info.triangles > 17 * 6, "{info:?}");
            assert_eq!([info.bounds.min[0], info.bounds.max[0]], [-6.0, 6.0]);
            assert_eq!(antumbra_scene_file_camera(x, file, 0, &mut camera, e), Ok);
            assert_eq!(owned(camera.name), "eye");
            assert!((camera.aspect_ratio - 16.0 / 9.0).abs() < 1e-5, "{camera:?}");
            assert_eq!(antumbra_scene_file_clip(x, file, 1, &mut clip, e), Ok);
            assert_eq!((owned(clip.name).as_str(), clip.duration), ("lift", 2.0));
            for (name, result) in [
                ("cameras", antumbra_scene_file_camera(x, file, 2, &mut camera, e)),
                ("clips", antumbra_scene_file_clip(x, file, 4, &mut clip, e)),
                ("notes", antumbra_scene_file_note(x, file, 0, &mut noted, e)),
            ] {
                assert_eq!(result, BadArgument, "{name}");
            }
            assert_eq!(text(e), "index is 0, and the file has 0 notes, counted from 0");
            assert_eq!(antumbra_scene_file_destroy(x, file, e), Ok);
            assert_eq!(antumbra_scene_file_info(x, file, &mut info, e), UnknownHandle);
            assert!(text(e).contains("no scene file"), "{}", text(e));
        }
    }
}

type Messages = Mutex<Vec<(u32, String)>>;

unsafe extern "C" fn note(user: *mut c_void, level: u32, message: *const c_char) {
    // SAFETY: the test passes this as user.
    let notes = unsafe { &*user.cast::<Messages>() };
    notes.lock().unwrap().push((level, owned(message)));
}

#[test]
fn what_a_file_does_not_show_is_noted_and_logged_or_refused() {
    let messages = Messages::default();
    let desc = AntumbraContextDesc {
        log: Some(note),
        log_user: from_ref(&messages).cast_mut().cast(),
        ..AntumbraContextDesc::current()
    };
    let mut context = null_mut();
    let e = &mut no_error();
    // The crate is drawn with a sampler that does not exist.
    let whole = std::fs::read_to_string(yard()).unwrap();
    let broken = whole.replace(r#"{"source": 1, "sampler": 0}"#, r#"{"source": 1, "sampler": 9}"#);
    assert_ne!(broken, whole);
    let desc_of = |broken_parts| AntumbraSceneFileDesc {
        bytes: broken.as_ptr(),
        byte_count: broken.len(),
        broken_parts,
        ..Versioned::INIT
    };
    let mut info = AntumbraSceneFileInfo::INIT;
    let mut noted = AntumbraSceneFileNote::INIT;
    // SAFETY: pointers to values on this stack.
    unsafe {
        assert_eq!(antumbra_context_create(&desc, &mut context, e), Ok);
        let (loaded, file) = load(context, &desc_of(ANTUMBRA_BROKEN_PARTS_LEFT_OUT), e);
        assert_eq!(loaded, Ok, "{}", text(e));
        assert_eq!(antumbra_scene_file_info(context, file, &mut info, e), Ok);
        assert_eq!(info.notes, 1);
        assert_eq!(antumbra_scene_file_note(context, file, 0, &mut noted, e), Ok);
        let noted = owned(noted.text);
        assert!(noted.contains("texture 1") && noted.contains("sampler"), "{noted}");
        let logged = std::mem::take(&mut *messages.lock().unwrap());
        assert!(matches!(&logged[..], [(2, message)] if message.ends_with(&noted)), "{logged:?}");

        let (refused, file) = load(context, &desc_of(ANTUMBRA_BROKEN_PARTS_REFUSED), e);
        assert_eq!((refused, file.id), (BadFile, 0));
        assert!(text(e).contains("memory: texture 1"), "{}", text(e));
        assert_eq!(antumbra_context_destroy(context, e), Ok);
    }
}

#[test]
fn a_scene_far_away_is_moved_on_request() {
    let mut host = Host::new();
    let text_of_file = std::fs::read_to_string(yard()).unwrap();
    // All nodes hang below one that is far away.
    let roots = text_of_file.split(r#""nodes": ["#).nth(1).unwrap();
    let roots = roots.split(']').next().unwrap();
    let far = format!(r#"{{"name": "far", "translation": [4096, 0, 0], "children": [{roots}]}}"#);
    let count = text_of_file.matches(r#"{"name""#).count();
    assert!(count > 20, "{count}");
    let nodes = text_of_file.split("\n\"nodes\": [\n").nth(1).unwrap();
    let nodes = nodes.split("],\n\"cameras\"").next().unwrap();
    let number = nodes.lines().count();
    let moved = text_of_file
        .replace(nodes, &format!("{nodes},\n  {far}"))
        .replace(&format!(r#""nodes": [{roots}]"#), &format!(r#""nodes": [{number}]"#));
    let origin = |place| {
        let desc = AntumbraSceneFileDesc {
            bytes: moved.as_ptr(),
            byte_count: moved.len(),
            place,
            ..Versioned::INIT
        };
        let mut error = no_error();
        let (loaded, file) = load(host.context, &desc, &mut error);
        assert_eq!(loaded, Ok, "{}", text(&error));
        let mut info = AntumbraSceneFileInfo::INIT;
        // SAFETY: pointers to values on this stack.
        let told = unsafe { antumbra_scene_file_info(host.context, file, &mut info, &mut error) };
        assert_eq!(told, Ok);
        (info.origin[0], info.bounds.max[0])
    };
    assert_eq!(origin(ANTUMBRA_SCENE_PLACE_AS_IN_FILE), (0.0, 4102.0));
    let (origin, max) = origin(ANTUMBRA_SCENE_PLACE_NEAR_ORIGIN);
    assert_eq!(origin + f64::from(max), 4102.0);
    assert!(origin > 4000.0, "{origin}");
    host.error = no_error();
}

#[test]
fn files_that_cannot_be_named_or_read_are_refused_with_a_reason() {
    let host = Host::new();
    let e = &mut no_error();
    let path = path_in_c(&yard());
    let nowhere = c"/nowhere/at_all.glb".as_ptr();
    let torn = c"\xff\xfe".as_ptr();
    let byte = 7_u8;
    let at_path = AntumbraSceneFileDesc { path: path.as_ptr(), ..Versioned::INIT };
    let desc = AntumbraSceneFileDesc::INIT;
    let of_bytes = AntumbraSceneFileDesc { bytes: &raw const byte, byte_count: 1, ..desc };
    for (desc, result, words) in [
        (desc, BadArgument, "desc.path is null, and"),
        (AntumbraSceneFileDesc { path: nowhere, ..desc }, BadFile, "/nowhere/at_all.glb"),
        (AntumbraSceneFileDesc { path: torn, ..desc }, BadArgument, "desc.path is not UTF-8"),
        (AntumbraSceneFileDesc { folder: torn, ..of_bytes }, BadArgument, "desc.folder"),
        (AntumbraSceneFileDesc { folder: nowhere, ..at_path }, BadArgument, "beside"),
        (AntumbraSceneFileDesc { path: path.as_ptr(), ..of_bytes }, BadArgument, "beside"),
        (AntumbraSceneFileDesc { bytes: null(), ..of_bytes }, BadPointer, "desc.bytes is null"),
        (of_bytes, BadFile, "memory"),
        (AntumbraSceneFileDesc { broken_parts: 2, ..at_path }, BadArgument, "BROKEN_PARTS_.. 2"),
        (AntumbraSceneFileDesc { place: 2, ..at_path }, BadArgument, "SCENE_PLACE_.. 2"),
        (AntumbraSceneFileDesc { exposure: -1.0, ..at_path }, BadArgument, "desc.exposure is -1"),
        (AntumbraSceneFileDesc { exposure: f32::NAN, ..at_path }, BadArgument, "desc.exposure"),
        (AntumbraSceneFileDesc { unit: f32::INFINITY, ..at_path }, BadArgument, "desc.unit"),
        (AntumbraSceneFileDesc { reserved: 1, ..at_path }, BadArgument, "reserved"),
        (AntumbraSceneFileDesc { struct_size: 9, ..at_path }, BadStructSize, "SceneFileDesc"),
    ] {
        let (refused, file) = load(host.context, &desc, e);
        assert_eq!((refused, file.id), (result, 0), "{words}: {}", text(e));
        assert!(text(e).contains(words), "\"{}\" does not say \"{words}\"", text(e));
    }
}

#[test]
fn every_function_of_files_checks_its_handles() {
    type Call<'a> = (&'a str, &'a dyn Fn(*const AntumbraContext, u64) -> AntumbraResult);
    let host = Host::new();
    let e = null_mut;
    let f = |id| AntumbraSceneFile { id };
    let r = |id| AntumbraRenderer { id };
    // SAFETY: of all closures: pointers to values that live as long as the call, or null.
    let calls: [Call; 8] = unsafe {
        [
            ("info", &|x, id| {
                let mut info = AntumbraSceneFileInfo::INIT;
                antumbra_scene_file_info(x, f(id), &mut info, e())
            }),
            ("camera", &|x, id| {
                let mut camera = AntumbraSceneFileCamera::INIT;
                antumbra_scene_file_camera(x, f(id), 0, &mut camera, e())
            }),
            ("clip", &|x, id| {
                let mut clip = AntumbraSceneFileClip::INIT;
                antumbra_scene_file_clip(x, f(id), 0, &mut clip, e())
            }),
            ("note", &|x, id| {
                let mut noted = AntumbraSceneFileNote::INIT;
                antumbra_scene_file_note(x, f(id), 0, &mut noted, e())
            }),
            ("destroy", &|x, id| antumbra_scene_file_destroy(x, f(id), e())),
            ("play", &|x, id| antumbra_renderer_play(x, r(id), null(), 0, 0.0, 0.0, e())),
            ("advance", &|x, id| antumbra_renderer_advance(x, r(id), 0.0, e())),
            ("renderer_camera", &|x, id| {
                let mut camera = AntumbraCamera::INIT;
                antumbra_renderer_camera(x, r(id), 0, &mut camera, e())
            }),
        ]
    };
    for (name, call) in calls {
        assert_eq!(call(null(), 5), BadPointer, "{name}");
        for id in [5, u64::MAX, host.hierarchy.id, host.culler.id] {
            assert_eq!(call(host.context, id), UnknownHandle, "{name} {id:#x}");
        }
        let nothing = if name == "destroy" { Ok } else { UnknownHandle };
        assert_eq!(call(host.context, 0), nothing, "{name}");
    }
    // SAFETY: null is refused.
    unsafe {
        let x = host.context;
        let results = [
            antumbra_scene_file_load(x, null(), &mut f(0), e()),
            antumbra_scene_file_load(x, &Versioned::INIT, null_mut(), e()),
            antumbra_scene_file_info(x, f(0), null_mut(), e()),
            antumbra_scene_file_camera(x, f(0), 0, null_mut(), e()),
            antumbra_scene_file_clip(x, f(0), 0, null_mut(), e()),
            antumbra_scene_file_note(x, f(0), 0, null_mut(), e()),
            antumbra_renderer_play(x, r(0), null(), 1, 0.0, 0.0, e()),
            antumbra_renderer_camera(x, r(0), 0, null_mut(), e()),
        ];
        assert_eq!(results, [BadPointer; 8]);
    }
}

#[cfg(feature = "loaded")]
#[test]
fn a_device_that_cannot_be_opened_is_refused_before_the_loader_is_loaded() {
    let host = Host::new();
    let e = &mut no_error();
    let mut device = AntumbraDevice { id: 3 };
    let torn = c"\xff\xfe".as_ptr();
    let desc = AntumbraDeviceOpenDesc::INIT;
    for (desc, result, words) in [
        (AntumbraDeviceOpenDesc { validation: 3, ..desc }, BadArgument, "ANTUMBRA_VALIDATION_.. 3"),
        (AntumbraDeviceOpenDesc { name: torn, ..desc }, BadArgument, "desc.name is not UTF-8"),
        (AntumbraDeviceOpenDesc { struct_size: 5, ..desc }, BadStructSize, "DeviceOpenDesc"),
    ] {
        // SAFETY: pointers to values on this stack, here and below.
        let refused = unsafe { antumbra_device_open(host.context, &desc, &mut device, e) };
        assert_eq!((refused, device.id), (result, 3), "{words}: {}", text(e));
        assert!(text(e).contains(words), "\"{}\" does not say \"{words}\"", text(e));
    }
    // SAFETY: as above; null is refused.
    unsafe {
        assert_eq!(antumbra_device_open(null(), &desc, &mut device, e), BadPointer);
        assert_eq!(antumbra_device_open(host.context, null(), &mut device, e), BadPointer);
        assert_eq!(antumbra_device_open(host.context, &desc, null_mut(), e), BadPointer);
    }
}
