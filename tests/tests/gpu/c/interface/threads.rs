//! Calls of another thread while a frame is being recorded: the result is that the scene is busy.

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use ash::vk::{self, Handle};
use capi::api::scene::*;
use capi::context::AntumbraContext;
use capi::error::AntumbraResult::{self, Busy, Ok};
use capi::executor::frame::*;
use capi::executor::scene::*;
use capi::layout::Versioned;
use gpu::Purpose;
use tests::drivers;
use tests::host_device::Host;

use super::{CHost, Rendering, camera, text};

/// The handles of a scene that is being recorded.
#[derive(Clone, Copy)]
struct Handles {
    context: usize,
    scene: AntumbraScene,
    view: AntumbraView,
}

/// The renderings of a host. During each of them, another thread calls.
struct Renderings<'a> {
    handles: Handles,
    rendering: Rendering<'a>,
    told: Vec<[AntumbraResult; 8]>,
}

impl Handles {
    /// Calls every function that needs the scene.
    fn call_all(self) -> [AntumbraResult; 8] {
        let x = self.context as *const AntumbraContext;
        let s = self.scene;
        let v = self.view;
        let e = null_mut();
        let mut other = AntumbraView { id: 0 };
        let mut stats = AntumbraViewStats::INIT;
        let commands = vk::CommandBuffer::from_raw(8);
        let frame = AntumbraFrameDesc { current: 1, commands, ..Versioned::INIT };
        // SAFETY: pointers to values on this stack; the context lives.
        unsafe {
            [
                antumbra_scene_add(x, s, null(), 0, null(), 0, null_mut(), e),
                antumbra_scene_remove(x, s, null(), 0, e),
                antumbra_scene_move(x, s, null(), null(), 0, e),
                antumbra_scene_set_draws(x, s, 0, null(), 0, e),
                antumbra_view_create(x, s, &mut other, e),
                antumbra_view_destroy(x, s, v, e),
                antumbra_view_stats(x, s, v, &mut stats, e),
                antumbra_scene_record(x, s, &frame, e),
            ]
        }
    }
}

unsafe extern "C" fn begin(user: *mut c_void, rendering: *const AntumbraRendering) {
    // SAFETY: the test passes this as user; the rest is the promise of the interface.
    unsafe {
        let host = &mut *user.cast::<Renderings<'_>>();
        super::begin((&raw mut host.rendering).cast(), rendering);
        let handles = host.handles;
        let told = std::thread::spawn(move || handles.call_all()).join().unwrap();
        host.told.push(told);
    }
}

unsafe extern "C" fn end(user: *mut c_void, rendering: *const AntumbraRendering) {
    // SAFETY: as above.
    unsafe {
        let host = &mut *user.cast::<Renderings<'_>>();
        super::end((&raw mut host.rendering).cast(), rendering);
    }
}

#[test]
fn another_thread_is_told_that_a_scene_is_being_recorded() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Executor);
        let mut c = CHost::new(&host, null());
        let camera = camera();
        let target = c.target();
        let view =
            AntumbraViewFrame { view: c.view, camera: &camera, target: &target, ..Versioned::INIT };
        let mut host_of_two = Renderings {
            handles: Handles { context: c.context as usize, scene: c.scene, view: c.view },
            rendering: Rendering {
                device: &host.device,
                view: c.image.view,
                scene: (c.context, c.scene),
                begun: 0,
                ended: 0,
                inner: Ok,
            },
            told: Vec::new(),
        };
        let recorded = c.record(&[&view], |frame| {
            frame.user = (&raw mut host_of_two).cast();
            frame.begin_rendering = Some(begin);
            frame.end_rendering = Some(end);
        });
        assert_eq!(recorded, Ok, "{}", text(&c.error));
        let told = host_of_two.told;
        assert!(!told.is_empty() && told.iter().all(|told| *told == [Busy; 8]), "{told:?}");
        c.finish();
        host.finish();
    }
}
