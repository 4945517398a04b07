//! Several views of one renderer in C: each has a history and counts of its own.

use capi::api::renderer::{
    antumbra_renderer_destroy, antumbra_renderer_render, antumbra_renderer_wait,
};
use capi::api::renderer_view::*;
use capi::decisions::culler::{ANTUMBRA_STRATEGY_ANTUMBRA, ANTUMBRA_STRATEGY_FRUSTUM};
use capi::error::AntumbraResult::{self, BadArgument, Ok, UnknownHandle};
use capi::layout::Versioned;
use capi::renderer::frame::{AntumbraRenderDesc, AntumbraRenderer};
use capi::renderer::view::{AntumbraRendererStats, AntumbraRendererView};
use gpu::Purpose;
use tests::host_device::Host;
use tests::{Driver, drivers};

use super::super::{expect, text};
use super::{CHost, SIZE};

/// The frames of each view.
const FRAMES: u64 = 6;

impl CHost<'_> {
    fn add_view(&mut self, renderer: AntumbraRenderer) -> AntumbraRendererView {
        let mut view = AntumbraRendererView { id: 0 };
        // SAFETY: pointers to values on this stack, here and below.
        let added = unsafe {
            antumbra_renderer_view_create(self.context, renderer, &mut view, &mut self.error)
        };
        assert_eq!(added, Ok, "{}", text(&self.error));
        view
    }

    fn view_stats(
        &mut self,
        renderer: AntumbraRenderer,
        view: AntumbraRendererView,
    ) -> (AntumbraResult, AntumbraRendererStats) {
        let mut stats = AntumbraRendererStats::INIT;
        let error = &mut self.error;
        // SAFETY: as above.
        let result = unsafe {
            antumbra_renderer_view_stats(self.context, renderer, view, &mut stats, error)
        };
        (result, stats)
    }

    /// Returns the image of a camera of the file in a view.
    fn seen_in(
        &mut self,
        renderer: AntumbraRenderer,
        view: AntumbraRendererView,
        index: u32,
        strategy: u32,
    ) -> Vec<u8> {
        let camera = self.camera(renderer, index);
        let desc = AntumbraRenderDesc { strategy, camera: &camera, view, ..Versioned::INIT };
        self.image_of(renderer, &desc)
    }
}

#[test]
fn views_have_histories_of_their_own_and_equal_those_with_all_drawn() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let mut c = CHost::new(&host);
        let file = c.file();
        let renderer = c.of_file(file);
        let reference = c.of_file(file);
        let own = AntumbraRendererView { id: 0 };
        let above = c.add_view(renderer);
        for renderer in [renderer, reference] {
            c.play_all(renderer);
        }
        for frame in 0..FRAMES {
            for renderer in [renderer, reference] {
                c.advance(renderer, 0.15 * frame as f64);
            }
            for (view, camera) in [(own, 0), (above, 1)] {
                let seen = c.seen_in(renderer, view, camera, ANTUMBRA_STRATEGY_ANTUMBRA);
                let all = c.seen_in(reference, own, camera, ANTUMBRA_STRATEGY_FRUSTUM);
                assert!(seen == all, "{driver:?}: frame {frame}, camera {camera}");
            }
        }
        // From above no wall hides the crates, and the history of the eye does not say that one
        // does.
        let of_eye = c.stats(renderer);
        let (told, of_above) = c.view_stats(renderer, above);
        assert_eq!(told, Ok, "{}", text(&c.error));
        assert_eq!([of_eye.frame, of_above.frame], [FRAMES; 2], "each counts its frames");
        assert_eq!([of_eye.total, of_above.total], [17; 2]);
        assert!(of_eye.drawn < of_above.drawn, "{of_eye:?} {of_above:?}");

        // The image of a view that is gone can be read, and the next frame works.
        let image = c.seen_in(renderer, above, 1, ANTUMBRA_STRATEGY_ANTUMBRA);
        // SAFETY: as above.
        let gone =
            unsafe { antumbra_renderer_view_destroy(c.context, renderer, above, &mut c.error) };
        assert_eq!(gone, Ok, "{}", text(&c.error));
        assert!(c.read_image(renderer) == image);
        c.seen(renderer, 0);
        c.finish();
        host.finish();
    }
}

#[test]
fn views_of_another_renderer_or_that_are_gone_are_refused() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    let mut c = CHost::new(&host);
    let file = c.file();
    let [first, second] = [(); 2].map(|()| c.of_file(file));
    let foreign = c.add_view(second);
    let gone = c.add_view(first);
    let before = c.seen(first, 0);
    let camera = c.camera(first, 0);
    let x = c.context;
    // SAFETY: pointers to values on this stack, here and below.
    unsafe {
        assert_eq!(antumbra_renderer_view_destroy(x, first, gone, &mut c.error), Ok);
        let again = antumbra_renderer_view_destroy(x, first, gone, &mut c.error);
        expect(again, UnknownHandle, "view of a renderer", &c.error);
    }
    for view in [foreign, gone, AntumbraRendererView { id: first.id }] {
        let desc = AntumbraRenderDesc { camera: &camera, view, ..Versioned::INIT };
        // SAFETY: as above.
        let refused = unsafe { antumbra_renderer_render(x, first, &desc, &mut c.error) };
        expect(refused, UnknownHandle, "another context, scene or renderer", &c.error);
        let (refused, _) = c.view_stats(first, view);
        expect(refused, UnknownHandle, "another context, scene or renderer", &c.error);
    }
    // An image of another size is refused in a view, too.
    let view = c.add_view(first);
    let mut wide = camera;
    wide.width = SIZE[0] + 1;
    let desc = AntumbraRenderDesc { camera: &wide, view, ..Versioned::INIT };
    // SAFETY: as above.
    unsafe {
        let refused = antumbra_renderer_render(x, first, &desc, &mut c.error);
        expect(refused, BadArgument, "antumbra_renderer_resize", &c.error);
        assert_eq!(antumbra_renderer_wait(x, first, &mut c.error), Ok);
    }
    assert!(c.read_image(first) == before, "frames that are refused leave the image");
    assert!(c.seen(first, 0) == before);
    // SAFETY: as above.
    unsafe { assert_eq!(antumbra_renderer_destroy(x, first, &mut c.error), Ok) };
    let (refused, _) = c.view_stats(first, view);
    expect(refused, UnknownHandle, "no renderer", &c.error);
    c.finish();
    host.finish();
}
