//! Snapshots: frozen frames, which are drawn from other viewpoints.

use crate::view_pass::ViewPass;
use cull::{Answer, Camera, CullView, LeafRange, QueryKind, Strategy};
use gpu::{Readback, Tick};

use crate::debug::debug_overlay::DebugOverlay;
use crate::debug::outline::record_outline;
use crate::debug::top_down::{BACKGROUND, Sketch, VIEW_FROM_ABOVE, above, reach};
use crate::debug::visibility_snapshot::VisibilitySnapshot;
use crate::error::Error;
use crate::host_overlay::HostOverlay;
use crate::render_view::RenderView;
use crate::renderer::Renderer;
use crate::resources::skinned_meshes::PoseUploads;
use crate::shadows::MapUses;
use crate::views::finish_image;

/// The background: dark, as in a drawing, or the sky of the scene.
enum Backdrop {
    Dark,
    Sky,
}

/// The end of a frame that is drawn from a snapshot: a host's commands over its image, and the
/// destination of a copy.
#[derive(Clone, Copy)]
struct Over<'a> {
    image: Option<&'a Readback>,
    overlay: Option<&'a dyn HostOverlay>,
}

impl Renderer {
    /// Freezes the newest frame of `state`, which was seen from `view`. Waits for it.
    ///
    /// # Errors
    /// A view of another renderer; [`Error::InvalidView`]; a lost device, or a frame that takes too
    /// long.
    pub fn snapshot(
        &mut self,
        state: &mut RenderView,
        view: CullView,
    ) -> Result<VisibilitySnapshot, Error> {
        cull::check_view(&view)?;
        self.wait_idle(state)?;
        let plan = state.plan();
        let one = |first| LeafRange { first, count: 1 };
        let taken = plan.draws.iter().copied().map(one);
        let queried = plan.queried_draws.iter().map(|(leaf, _)| one(*leaf));
        let mut snapshot = VisibilitySnapshot {
            frame: plan.frame,
            view,
            drawn: taken.chain(queried).collect(),
            hidden: Vec::new(),
            renderer: self.id,
        };
        let mut showed = Vec::new();
        let of_frame = |answer: &&Answer| answer.shows() && answer.tag.frame == plan.frame;
        for answer in state.visibility.newest_answers().iter().filter(of_frame) {
            let node = answer.tag.node;
            match answer.tag.kind {
                QueryKind::Proxy | QueryKind::Leaf => {
                    snapshot.drawn.push(self.scene.hierarchy().leaves(node));
                    showed.push(node);
                }
                QueryKind::PerLeaf => showed.push(node),
                QueryKind::PullUpQuery
                | QueryKind::VisibleBoxQuery
                | QueryKind::VisibleDrawQuery => {}
            }
        }
        showed.sort_unstable();
        let tests = plan.tests.iter().filter(|test| test.leaves.count > 0);
        for test in tests.filter(|test| showed.binary_search(&test.tag.node).is_err()) {
            snapshot.hidden.push((self.scene.hierarchy().bounds(test.tag.node), test.level));
        }
        Ok(snapshot)
    }
}

impl Renderer {
    /// Draws `moment` from above into `image` and waits for it: the drawn objects in their own
    /// colours, the hidden frontier nodes as boxes coloured by their level, and the frustum.
    ///
    /// # Errors
    /// A snapshot of another renderer, an image of another device or size, no memory, a shader that
    /// does not compile, a failed call.
    pub fn top_down(
        &mut self,
        snapshot: &VisibilitySnapshot,
        image: &Readback,
    ) -> Result<(), Error> {
        let camera = self.above(snapshot);
        self.draw_snapshot(
            snapshot,
            camera,
            Over { image: Some(image), overlay: None },
            Backdrop::Dark,
        )?;
        Ok(self.device.wait_idle()?)
    }

    /// Draws `moment` from another viewpoint without a wait: the culling is frozen, the camera is
    /// not. Besides the drawn objects, the image shows the hidden frontier nodes and the frustum,
    /// as in [`Renderer::top_down`]. Of the overlay set by [`Renderer::set_debug_overlay`], it
    /// shows the wireframe and the view from above. `overlay` records over that.
    ///
    /// # Errors
    /// A snapshot of another renderer, an image of another device or size, a camera with numbers
    /// that are not finite, no memory, a failed call.
    pub fn render_snapshot(
        &mut self,
        snapshot: &VisibilitySnapshot,
        camera: Camera,
        image: Option<&Readback>,
        overlay: Option<&dyn HostOverlay>,
    ) -> Result<Tick, Error> {
        self.draw_snapshot(snapshot, camera, Over { image, overlay }, Backdrop::Sky)
    }

    fn draw_snapshot(
        &mut self,
        snapshot: &VisibilitySnapshot,
        camera: Camera,
        Over { image, overlay }: Over<'_>,
        backdrop: Backdrop,
    ) -> Result<Tick, Error> {
        self.check_renderer(snapshot.renderer, "a snapshot (`VisibilitySnapshot`)")?;
        image.map_or(Ok(()), |image| self.check_image(image))?;
        cull::check_camera(&camera, self.size())?;
        self.passes.pipelines.overlay.prepare(&self.device, &self.shaders)?;
        let view = self.view_of(&camera);
        let sketch = Sketch::of(snapshot, self.reach(snapshot));
        let outlined = match backdrop {
            Backdrop::Dark => None,
            Backdrop::Sky => self.outlined_bounds(),
        };
        let Self { frames, scene, passes, .. } = self;
        let before = match backdrop {
            Backdrop::Dark => Some(BACKGROUND),
            Backdrop::Sky => None,
        };
        let (clear, debug_overlay) = match backdrop {
            Backdrop::Dark => (BACKGROUND, DebugOverlay::default()),
            Backdrop::Sky => (passes.sky(), self.debug_overlay),
        };
        let mut frame = frames.begin()?;
        passes.scopes = None;
        let views = std::slice::from_ref(&view);
        passes.begin_section(&mut frame, scene.hierarchy())?;
        passes.upload_changes(&mut frame, scene, PoseUploads::All, views, MapUses::Anywhere)?;
        passes.begin_section_view(&mut frame, scene.hierarchy(), &view)?;
        passes.gpu_scene.gather_transparent(&mut frame, scene, &view, Strategy::FRUSTUM)?;
        let draws = snapshot.upload(&mut frame, scene.leaves())?;
        let io = sketch.upload(&mut frame)?;
        let commands = frame.commands();
        passes.target.prepare(commands);
        commands.pass(VIEW_FROM_ABOVE, |commands| {
            let from = passes.image_target(&view, clear);
            commands.rendering(from, |commands| {
                passes.draw_all(scene, commands, &view, draws, before);
            });
        });
        passes.record_transparent(scene, commands, &view);
        passes.target.prepare(commands);
        commands.pass(VIEW_FROM_ABOVE, |commands| {
            commands.rendering(passes.target_of(&view, None), |commands| {
                if let Some(overlay) = passes.pipelines.overlay.get() {
                    overlay.record(commands, &io, &view);
                }
            });
        });
        let mut view_pass = ViewPass { passes, frame: &mut frame, scene, view: &view };
        debug_overlay.record_snapshot(&mut view_pass, draws)?;
        debug_overlay.record_corner(&mut view_pass, snapshot, draws)?;
        if let Some(bounds) = outlined {
            record_outline(&mut view_pass, bounds)?;
        }
        finish_image(&mut frame, passes, overlay, image)?;
        passes.read_back(frame.commands());
        let tick = frame.submit(None)?;
        overlay.inspect(|overlay| overlay.submitted());
        self.submitted(tick);
        self.shown_tick = Some(tick);
        Ok(tick)
    }

    /// Returns the distance from the eye within which most of the snapshot's draws lie, without a
    /// few far draws.
    fn reach(&self, snapshot: &VisibilitySnapshot) -> f32 {
        reach(self.scene.hierarchy(), snapshot)
    }

    fn above(&self, snapshot: &VisibilitySnapshot) -> Camera {
        above(snapshot, self.reach(snapshot))
    }
}
