//! A program in C without Vulkan: the library opens the device, and reads images. They are those on
//! a device of a host, copied by its commands.

use std::ffi::{CString, c_char, c_void};
use std::ptr::null_mut;
use std::sync::Mutex;

use capi::api::context::{antumbra_context_create, antumbra_context_destroy};
use capi::api::device::{antumbra_device_destroy, antumbra_device_finished};
use capi::api::device_open::antumbra_device_open;
use capi::api::playback::*;
use capi::api::renderer::*;
use capi::api::scene_file::antumbra_scene_file_load;
use capi::context::{AntumbraContext, AntumbraContextDesc};
use capi::decisions::camera::AntumbraCamera;
use capi::decisions::culler::ANTUMBRA_STRATEGY_FRUSTUM;
use capi::error::AntumbraResult::{self, BadArgument, NoMemory, Ok};
use capi::executor::device::AntumbraDevice;
use capi::executor::device_open::*;
use capi::layout::Versioned;
use capi::renderer::description::AntumbraRendererDesc;
use capi::renderer::frame::{AntumbraRenderDesc, AntumbraRenderer};
use capi::renderer::scene_file::*;
use gpu::Purpose;
use tests::host_device::Host;
use tests::{Driver, drivers};

use super::super::{expect, no_error, text};
use super::files::{desc_of, yard};
use super::{CHost, SIZE};

const BYTES: usize = SIZE[0] as usize * SIZE[1] as usize * 4;

/// Reads an image of a number of bytes.
fn read(
    context: *const AntumbraContext,
    renderer: AntumbraRenderer,
    byte_count: usize,
) -> (AntumbraResult, Vec<u8>, String) {
    let mut rgba = vec![7; byte_count];
    let mut error = no_error();
    // SAFETY: pointers to values on this stack.
    let result = unsafe {
        antumbra_renderer_read_image(context, renderer, rgba.as_mut_ptr(), byte_count, &mut error)
    };
    (result, rgba, text(&error).to_owned())
}

impl CHost<'_> {
    /// Reads the newest image.
    pub(super) fn read_image(&self, renderer: AntumbraRenderer) -> Vec<u8> {
        let (result, image, message) = read(self.context, renderer, BYTES);
        assert_eq!(result, Ok, "{message}");
        image
    }
}

#[test]
fn an_image_that_is_read_is_the_one_that_a_host_copies() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let file = c.file();
        for samples in [1, 4] {
            let (created, renderer) = c.create(&AntumbraRendererDesc { samples, ..desc_of(file) });
            assert_eq!(created, Ok, "{}", text(&c.error));
            let (refused, _, message) = read(c.context, renderer, BYTES);
            assert!(refused == BadArgument && message.contains("not there yet"), "{message}");
            let camera = c.camera(renderer, 0);
            let strategy = ANTUMBRA_STRATEGY_FRUSTUM;
            let desc = AntumbraRenderDesc { strategy, camera: &camera, ..Versioned::INIT };
            let image = c.image_of(renderer, &desc);
            let uses = c.queue.uses;
            assert!(c.read_image(renderer) == image, "{samples} samples");
            assert!(c.queue.uses > uses && !c.queue.held, "under the lock of the host");
            assert!(c.finished_image(renderer) == image, "it stays");
            assert!(c.read_image(renderer) == image, "again");
            let (refused, untouched, message) = read(c.context, renderer, BYTES - 4);
            assert!(refused == BadArgument && message.contains("has 24576 bytes"), "{message}");
            assert!(untouched.iter().all(|byte| *byte == 7));
            assert!(c.image_of(renderer, &desc) == image, "the next frame works");
        }
        c.finish();
        host.finish();
    }
}

type Messages = Mutex<Vec<String>>;

unsafe extern "C" fn note(user: *mut c_void, _level: u32, message: *const c_char) {
    // SAFETY: the test passes this as user, and the message ends with a 0.
    let (messages, message) =
        unsafe { (&*user.cast::<Messages>(), std::ffi::CStr::from_ptr(message)) };
    messages.lock().unwrap().push(message.to_str().unwrap().to_owned());
}

/// A program without a device.
struct Program {
    context: *mut AntumbraContext,
    messages: Box<Messages>,
}

impl Program {
    fn new() -> Self {
        tests::take_turn();
        let messages = Box::<Messages>::default();
        let desc = AntumbraContextDesc {
            log: Some(note),
            log_user: (&raw const *messages).cast_mut().cast(),
            ..AntumbraContextDesc::current()
        };
        let mut context = null_mut();
        // SAFETY: pointers to values on this stack.
        let made = unsafe { antumbra_context_create(&desc, &mut context, null_mut()) };
        assert_eq!(made, Ok);
        Self { context, messages }
    }

    /// Opens a device of this name, with all checks of the validation layer.
    fn open(
        &self,
        name: &str,
        memory_budget_bytes: u64,
    ) -> (AntumbraResult, AntumbraDevice, String) {
        let name = CString::new(name).unwrap();
        let desc = AntumbraDeviceOpenDesc {
            validation: ANTUMBRA_VALIDATION_SYNCHRONIZATION,
            name: name.as_ptr(),
            memory_budget_bytes,
            ..Versioned::INIT
        };
        let mut device = AntumbraDevice { id: 0 };
        let mut error = no_error();
        // SAFETY: as above.
        let result = unsafe { antumbra_device_open(self.context, &desc, &mut device, &mut error) };
        (result, device, text(&error).to_owned())
    }

    /// Creates a renderer of the file.
    fn renderer(&self, device: AntumbraDevice) -> (AntumbraResult, AntumbraRenderer, String) {
        let path = CString::new(yard().to_str().unwrap()).unwrap();
        let desc = AntumbraSceneFileDesc { path: path.as_ptr(), ..Versioned::INIT };
        let mut file = AntumbraSceneFile { id: 0 };
        let mut renderer = AntumbraRenderer { id: 0 };
        let x = self.context;
        let e = &mut no_error();
        // SAFETY: as above.
        let result = unsafe {
            assert_eq!(antumbra_scene_file_load(x, &desc, &mut file, e), Ok, "{}", text(e));
            let desc = AntumbraRendererDesc { device, ..desc_of(file) };
            antumbra_renderer_create(x, &desc, &mut renderer, e)
        };
        (result, renderer, text(e).to_owned())
    }

    /// Destroys the context, and returns the messages of its life.
    fn finish(self) -> Vec<String> {
        let mut error = no_error();
        // SAFETY: the context is no longer used.
        let destroyed = unsafe { antumbra_context_destroy(self.context, &mut error) };
        assert_eq!(destroyed, Ok, "{}", text(&error));
        self.messages.into_inner().unwrap()
    }
}

#[test]
fn a_program_without_vulkan_draws_a_file_as_on_the_device_of_a_host() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let file = c.file();
        let renderer = c.of_file(file);
        c.play_all(renderer);
        c.advance(renderer, 0.9);
        let expected = c.seen(renderer, 0);
        c.finish();
        host.finish();

        let program = Program::new();
        let (opened, device, message) = program.open(driver.device_name(), 0);
        assert_eq!(opened, Ok, "{message}");
        let x = program.context;
        let e = &mut no_error();
        let (made, renderer, message) = program.renderer(device);
        assert_eq!(made, Ok, "{message}");
        let mut camera = AntumbraCamera::INIT;
        // SAFETY: pointers to values on this stack.
        unsafe {
            let all = ANTUMBRA_ALL_CLIPS;
            let played = antumbra_renderer_play(x, renderer, std::ptr::null(), all, 0.0, 0.0, e);
            assert_eq!(played, Ok, "{}", text(e));
            assert_eq!(antumbra_renderer_advance(x, renderer, 0.9, e), Ok, "{}", text(e));
            assert_eq!(antumbra_renderer_camera(x, renderer, 0, &mut camera, e), Ok);
            let render = AntumbraRenderDesc { camera: &camera, ..Versioned::INIT };
            for _ in 0..3 {
                let drawn = antumbra_renderer_render(x, renderer, &render, e);
                assert_eq!(drawn, Ok, "{}", text(e));
            }
            let finished = antumbra_device_finished(x, device, e);
            expect(finished, BadArgument, "", e);
            // The renderer keeps the device open.
            assert_eq!(antumbra_device_destroy(x, device, e), Ok, "{}", text(e));
        }
        let (result, image, message) = read(x, renderer, BYTES);
        assert_eq!(result, Ok, "{message}");
        assert!(image == expected, "{driver:?}: not as on the device of a host");
        let messages = program.finish();
        assert!(messages.is_empty(), "of the validation layer: {messages:?}");
    }
}

#[test]
fn devices_that_do_not_exist_or_have_no_room_are_named() {
    let program = Program::new();
    let (refused, _, message) = program.open("voodoo", 0);
    assert!(refused == BadArgument && message.contains("voodoo"), "{message}");
    assert!(message.contains("llvmpipe"), "it lists those that are there: {message}");
    let (opened, device, message) = program.open(Driver::Lavapipe.device_name(), 4096);
    assert_eq!(opened, Ok, "{message}");
    let (refused, _, message) = program.renderer(device);
    assert_eq!(refused, NoMemory, "{message}");
    assert!(message.contains("AntumbraDeviceDesc::memory_budget_bytes"), "{message}");
    program.finish();
}
