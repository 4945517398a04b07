//! Lights and transparent objects that move or change between frames.

use glam::Affine3A;
use scene::{LightId, LightKind, PunctualLight, TransparentId};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resources::geometry::bounds_in_world;

impl Renderer {
    /// Replaces a light of a scene with surfaces by a moved or changed one. The next frame shows
    /// it. The cost grows with the objects around its old and its new place, not with the scene;
    /// they find their lights once per frame, for any number of changed lights.
    ///
    /// # Errors
    /// [`Error::Light`] for a light that is not in the scene, and for another kind of light:
    /// pipelines are compiled for the kinds in the scene. Make it dark and light another then.
    pub fn set_light(&mut self, light: LightId, to: PunctualLight) -> Result<(), Error> {
        let place = light.0 as usize;
        let geometry = &mut self.passes.geometry;
        let refused = |reason| Error::Light { light, reason };
        let surfaces = geometry.surfaces.as_mut();
        let surfaces = surfaces.ok_or(refused("the scene has no surfaces that it could light"))?;
        let before = surfaces.table.lights.get(place);
        let before = before.ok_or(refused("the scene has no such light"))?;
        if !is_same_kind(before.kind, to.kind) {
            return Err(refused("it cannot become another kind of light"));
        }
        surfaces.replace_light(&self.hierarchy, light, to);
        Ok(())
    }
}

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
        let object = self.passes.transparent.as_ref().and_then(|it| it.get(transparent));
        let object = object.ok_or(refuse("the scene has no such transparent object"))?;
        let bounds = bounds_in_world(&object.own_bounds, &transform);
        let bounds = bounds
            .ok_or(refuse("its transform takes it nowhere: check it for infinities and NaN"))?;
        self.passes.change_transparent(transparent, |object| {
            (object.object.transform, object.bounds) = (transform, bounds);
        })
    }
}

fn is_same_kind(a: LightKind, b: LightKind) -> bool {
    std::mem::discriminant(&a) == std::mem::discriminant(&b)
}
