//! Transparent objects that move between frames.

use glam::Affine3A;
use scene::TransparentId;

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resources::geometry::bounds_in_world;
use crate::update_errors::TransparentError;

impl Renderer {
    /// Moves a transparent object. The next frame shows it.
    ///
    /// # Errors
    /// [`Error::Transparent`]: the scene has no such object, or the place is impossible. Nothing
    /// has changed then.
    pub fn move_transparent(
        &mut self,
        transparent: TransparentId,
        transform: Affine3A,
    ) -> Result<(), Error> {
        let refuse = |reason| Error::Transparent { transparent, reason };
        let object =
            self.passes.gpu_scene.transparent.as_ref().and_then(|objects| objects.get(transparent));
        let object = object.ok_or(refuse(TransparentError::UnknownObject))?;
        let bounds = bounds_in_world(&object.own_bounds, &transform);
        let bounds = bounds.ok_or(refuse(TransparentError::BadTransform))?;
        self.passes.gpu_scene.change_transparent(transparent, |object| {
            (object.object.transform, object.bounds) = (transform, bounds);
        })
    }
}
