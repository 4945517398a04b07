//! The eyes of a walk: one, or a stereo pair side by side in one image.

use antumbra::cull::{Camera, CullView, FrameId, Strategy};
use antumbra::gpu::Readback;
use antumbra::render::{
    FrameReport, FrameStats, Rect, RenderView, Renderer, ViewRequest, ViewsRequest, VisibleSet,
};

use crate::camera_path::FrameCamera;
use crate::choices::ProjectionChoice;
use crate::projection::viewpoint;
use crate::run_error::RunError;

/// The distance between the eyes of a person, in metres.
const BETWEEN_EYES_M: f32 = 0.065;

/// One strategy's eyes, each with its history.
pub struct Eyes {
    histories: Vec<RenderView>,
    projection: ProjectionChoice,
}

impl Eyes {
    /// Creates as many eyes as asked for, at least one, with empty histories.
    ///
    /// # Errors
    /// When the device fails.
    pub fn new(
        renderer: &Renderer,
        views: u32,
        projection: ProjectionChoice,
    ) -> Result<Self, RunError> {
        let histories = (0..views.max(1)).map(|_| renderer.new_view());
        Ok(Self { histories: histories.collect::<Result<_, _>>()?, projection })
    }

    /// Renders a frame from `middle`, which is in the middle of the eyes; `visible` holds the
    /// visible set of each of them, for [`antumbra::methods::IDEAL`].
    ///
    /// # Errors
    /// When the device fails, or the image has fewer columns than there are eyes.
    pub fn render(
        &mut self,
        renderer: &mut Renderer,
        strategy: Strategy,
        middle: &FrameCamera,
        visible: &[VisibleSet],
        image: Option<&Readback>,
    ) -> Result<FrameReport, RunError> {
        let views = self.histories.len() as u32;
        let areas = Rect::side_by_side(renderer.size(), views);
        let projection = self.projection;
        let eye = |((number, history), rect)| {
            let viewpoint = viewpoint(&camera_of(middle, number, views), projection, rect);
            let visible = visible.get(number as usize);
            ViewRequest { state: history, viewpoint, visible, rect }
        };
        let mut eyes: Vec<ViewRequest<'_>> =
            (0..).zip(&mut self.histories).zip(areas).map(eye).collect();
        let request = ViewsRequest { strategy, image, overlay: None, after: None };
        Ok(renderer.render_views(&mut eyes, &request)?)
    }

    /// Returns the visible set of each eye. Not for a timed loop: it waits for the GPU.
    ///
    /// # Errors
    /// When the device fails.
    pub fn visible_sets(
        &mut self,
        renderer: &mut Renderer,
        middle: &FrameCamera,
    ) -> Result<Vec<VisibleSet>, RunError> {
        let views = self.histories.len() as u32;
        let areas = Rect::side_by_side(renderer.size(), views);
        let eyes = (0..).zip(&mut self.histories).zip(areas);
        eyes.map(|((number, history), area)| {
            let camera = camera_of(middle, number, views);
            Ok(renderer.visible_set(history, viewpoint(&camera, self.projection, area), area)?)
        })
        .collect()
    }

    /// Waits until every frame is over and reads back its results.
    ///
    /// # Errors
    /// When the device fails.
    pub fn wait_idle(&mut self, renderer: &mut Renderer) -> Result<(), RunError> {
        for history in &mut self.histories {
            renderer.wait_idle(history)?;
        }
        Ok(())
    }

    /// Returns the last frame drawn, which is the same for all eyes.
    pub fn frame(&self) -> FrameId {
        self.histories.first().map_or(FrameId(0), |history| history.plan().frame)
    }

    /// Returns the outcomes of the frames whose results were read back: one per eye and frame.
    pub fn drain_stats(&mut self) -> impl Iterator<Item = FrameStats> {
        self.histories.iter_mut().flat_map(RenderView::drain_stats)
    }

    /// Returns the first eye's history, and its view if `middle` is the camera between the eyes.
    ///
    /// # Errors
    /// A camera whose matrix is not a projection.
    pub fn first(
        &mut self,
        renderer: &Renderer,
        middle: &FrameCamera,
    ) -> Result<Option<(&mut RenderView, CullView)>, RunError> {
        let views = self.histories.len() as u32;
        let area = Rect::side_by_side(renderer.size(), views).next();
        let Some((area, history)) = area.zip(self.histories.first_mut()) else {
            return Ok(None);
        };
        let viewpoint = viewpoint(&camera_of(middle, 0, views), self.projection, area);
        Ok(Some((history, renderer.view_in(viewpoint, area)?)))
    }
}

/// Returns the camera of eye `number` of `views`: all beside each other, looking the same way.
fn camera_of(middle: &FrameCamera, number: u32, views: u32) -> FrameCamera {
    let FrameCamera { frame, camera } = *middle;
    let aside = number as f32 - (views.max(1) - 1) as f32 / 2.0;
    let right = camera.forward.cross(camera.up).normalize_or_zero();
    let eye = camera.eye + right * (aside * BETWEEN_EYES_M);
    FrameCamera { frame, camera: Camera { eye, ..camera } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenes::{CameraPath, PathKind, city};

    #[test]
    fn eyes_are_beside_each_other_around_the_middle() {
        let routes = city(100, 1).unwrap().routes;
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        for frame in 0..40 {
            let middle = FrameCamera { frame, camera: path.camera(frame) };
            assert_eq!(camera_of(&middle, 0, 1), middle);
            let [left, right] = [0, 1].map(|eye| camera_of(&middle, eye, 2));
            let [left, middle, right] = [left, middle, right].map(|eye| eye.camera);
            assert!(((right.eye - left.eye).length() - BETWEEN_EYES_M).abs() < 1e-4);
            assert!((left.eye + right.eye - 2.0 * middle.eye).length() < 1e-3);
            assert_eq!((left.forward, right.up), (middle.forward, middle.up));
        }
    }
}
