//! Messages of the executor, which go to the log of the context.

use std::ffi::{CStr, c_char, c_void};
use std::ptr::{from_ref, null};
use std::sync::Mutex;

use capi::context::AntumbraContextDesc;
use capi::error::AntumbraResult::Ok;
use capi::executor::frame::AntumbraViewFrame;
use capi::layout::Versioned;
use capi::log::ANTUMBRA_LOG_DEBUG;
use gpu::Purpose;
use tests::Driver;
use tests::host_device::Host;

use super::{CHost, camera, text};

type Messages = Mutex<Vec<(u32, String)>>;

unsafe extern "C" fn note(user: *mut c_void, level: u32, message: *const c_char) {
    // SAFETY: the test passes this as user, and the message ends with a 0.
    let (messages, message) = unsafe { (&*user.cast::<Messages>(), CStr::from_ptr(message)) };
    messages.lock().unwrap().push((level, message.to_str().unwrap().to_owned()));
}

#[test]
fn a_frame_that_never_runs_is_in_the_log_of_its_context() {
    let [first, second] = [(); 2].map(|()| Messages::default());
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let [mut silent, mut c] = [(1, &second), (ANTUMBRA_LOG_DEBUG, &first)].map(|(level, log)| {
        let log_user = from_ref(log).cast_mut().cast();
        let desc = AntumbraContextDesc {
            log: Some(note),
            log_user,
            log_level: level,
            ..AntumbraContextDesc::current()
        };
        CHost::in_context(&host, &desc, null())
    });
    for c in [&mut silent, &mut c] {
        let camera = camera();
        let target = c.target();
        let device =
            AntumbraViewFrame { view: c.view, camera: &camera, target: &target, ..Versioned::INIT };
        for _ in 0..3 {
            assert_eq!(c.record(&[&device], |_| {}), Ok, "{}", text(&c.error));
        }
    }
    silent.finish();
    c.finish();
    host.finish();
    let [first, second] = [first, second].map(|messages| messages.into_inner().unwrap());
    let never_ran = |(level, message): &(u32, String)| {
        *level == ANTUMBRA_LOG_DEBUG && message.contains("frame 1 of the host never ran")
    };
    assert_eq!(first.iter().filter(|first| never_ran(first)).count(), 1, "{first:?}");
    assert!(second.is_empty(), "errors alone: {second:?}");
}
