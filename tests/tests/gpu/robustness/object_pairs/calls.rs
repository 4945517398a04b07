//! Calls of instances, devices, windows and frames that return their error.
#![allow(unsafe_code, reason = "handles that point nowhere are borrowed from raw ones")]

use std::ptr::NonNull;
use std::sync::Arc;

use gpu::{Acquired, Device, DeviceOptions, Surface, Swapchain, TextureSet, Tick};
use raw_window_handle::{
    DisplayHandle, HandleError, HasDisplayHandle, HasWindowHandle, RawDisplayHandle,
    RawWindowHandle, WaylandDisplayHandle, WaylandWindowHandle, WindowHandle,
};

use super::side::{EmptyDraws, SIZE, SOURCE, Side, framed};
use super::{Mistake, Row};

/// A window with dangling handles, which is refused before the handles are used.
struct NowhereOnWayland;

impl HasDisplayHandle for NowhereOnWayland {
    fn display_handle(&self) -> Result<DisplayHandle<'_>, HandleError> {
        let raw = RawDisplayHandle::Wayland(WaylandDisplayHandle::new(NonNull::dangling()));
        // SAFETY: the pointer is never followed, which is tested here.
        Ok(unsafe { DisplayHandle::borrow_raw(raw) })
    }
}

impl HasWindowHandle for NowhereOnWayland {
    fn window_handle(&self) -> Result<WindowHandle<'_>, HandleError> {
        let raw = RawWindowHandle::Wayland(WaylandWindowHandle::new(NonNull::dangling()));
        // SAFETY: as above.
        Ok(unsafe { WindowHandle::borrow_raw(raw) })
    }
}

fn text<T>(result: Result<T, gpu::Error>) -> String {
    result.err().expect("an error").to_string()
}

pub fn rows() -> Vec<Row> {
    let row = |call, given, owner, mistake| Row {
        call,
        given,
        owner,
        mistake: Mistake::Returned(mistake),
    };
    const SURFACE: &str = "a surface (`Surface`)";
    let mut rows = vec![
        row("Device::new", "an adapter", "Instance", |ours, theirs| {
            let adapter = theirs.stage.instance.pick_adapter(None).unwrap();
            text(Device::new(&ours.stage.instance, &adapter, &DeviceOptions::default()))
        }),
        row("Instance::pick_adapter_for", SURFACE, "Instance", |ours, theirs| {
            text(ours.stage.instance.pick_adapter_for(&theirs.stage.surface, None))
        }),
        row("Surface::new", "a window", "WindowSystem", |ours, _| {
            text(Surface::new(&ours.stage.instance, Arc::new(NowhereOnWayland)))
        }),
        row("Surface::present_modes", SURFACE, "Instance", |ours, theirs| {
            text(theirs.stage.surface.present_modes(&ours.device()))
        }),
        row("Swapchain::new", SURFACE, "Instance", |ours, theirs| {
            text(Swapchain::new(&ours.device(), &theirs.stage.surface, &Default::default()))
        }),
        row("Swapchain::show", "a target (`Target`)", "Device", |ours, theirs| {
            text(ours.swapchain.show(&theirs.target, SIZE))
        }),
        row("WindowImage::show", "a target (`Target`)", "Device", |ours, theirs| {
            match ours.swapchain.acquire(SIZE).unwrap() {
                Acquired::Image(image) => text(image.show(&theirs.target)),
                Acquired::Not(reason) => panic!("{reason}"),
            }
        }),
        row(
            "TextureUploads::write",
            "a texture array (`TextureArray`)",
            "Device",
            |ours, theirs| text(ours.uploads.write(&mut theirs.array, 0, &[0; 64])),
        ),
        row(
            "TextureUploads::write_rows",
            "a texture array (`TextureArray`)",
            "Device",
            |ours, theirs| text(ours.uploads.write_rows(&mut theirs.array, 0, &[0; 16])),
        ),
        row(
            "TextureUploads::reserve",
            "a texture array (`TextureArray`)",
            "Device",
            |ours, theirs| text(ours.uploads.reserve(&mut theirs.array, 0..1)),
        ),
        row("TextureSet::new", "a texture (`DynamicTexture`)", "Device", |ours, theirs| {
            text(TextureSet::new(&ours.device(), &theirs.texture, "set"))
        }),
    ];
    rows.extend(frames());
    rows
}

/// Returns the calls that take a frame.
fn frames() -> Vec<Row> {
    let row = |call, given, mistake| Row {
        call,
        given,
        owner: "Device",
        mistake: Mistake::Returned(mistake),
    };
    const TIMELINE: &str = "a timeline (`Timeline`)";
    const PREDICATES: &str = "predicates (`Predicates`)";
    vec![
        row("Frame::submit", TIMELINE, |ours: &mut Side, theirs: &mut Side| {
            let mut ring = gpu::FrameRing::new(&ours.device(), 1).unwrap();
            text(ring.begin().unwrap().submit(Some(theirs.timeline.at(Tick(1)))))
        }),
        row("Frame::flush", TIMELINE, |ours, theirs| {
            let mut ring = gpu::FrameRing::new(&ours.device(), 1).unwrap();
            text(ring.begin().unwrap().flush(Some(theirs.timeline.at(Tick(1)))))
        }),
        row("QueryRing::begin", "a query ring (`QueryRing`)", |ours, theirs| {
            framed(&ours.device(), |frame| theirs.queries.begin(frame, &[1]))
        }),
        row("FlagRing::begin", "a flag ring (`FlagRing`)", |ours, theirs| {
            framed(&ours.device(), |frame| theirs.flags.begin(frame, [1].into_iter()))
        }),
        row("LeafDrawRing::begin", "leaf draws (`LeafDrawRing`)", |ours, theirs| {
            framed(&ours.device(), |frame| {
                let range = gpu::DrawRange { first: 0, count: 1 };
                theirs.leaf_draws.begin(frame, 1, [range].into_iter(), &EmptyDraws)
            })
        }),
        row("Predicates::begin", PREDICATES, |ours, theirs| {
            framed(&ours.device(), |frame| {
                theirs.predicates.begin(frame, SOURCE, None, [].into_iter())
            })
        }),
        row("Predicates::begin", "a buffer (`BufferSlice`)", |ours, theirs| {
            framed(&ours.device(), |frame| {
                let results = Some(theirs.slice());
                ours.predicates.begin(frame, SOURCE, results, [].into_iter())
            })
        }),
        row("BlockingQueryPool::take", "blocking queries (`BlockingQueryPool`)", |ours, theirs| {
            framed(&ours.device(), |frame| theirs.pages.take(frame.commands(), 1).map(|_| ()))
        }),
    ]
}
