//! The context of interaction: the current state of a session.

use antumbra::cull::{Aabb, CullView, FrameId};
use antumbra::glam::Vec2;

use crate::document::Document;
use crate::orbit::OrbitCamera;
use crate::script::Pixel;

/// The context of interaction.
#[derive(Clone, Copy)]
pub struct InteractionContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// The camera.
    pub camera: OrbitCamera,
    /// The view of the next frame.
    pub view: CullView,
    /// The box around everything that is shown.
    pub bounds: Aabb,
    /// The newest frame.
    pub frame: FrameId,
}

impl InteractionContext<'_> {
    /// Returns the pixel at a place of the image; `None` outside of it.
    pub fn pixel_at(&self, place: Vec2) -> Option<Pixel> {
        let size = Vec2::from(self.view.size.map(|side| side as f32));
        let is_within = place.cmpge(Vec2::ZERO).all() && place.cmplt(size).all();
        is_within.then_some(Pixel { x: place.x as u32, y: place.y as u32 })
    }
}
