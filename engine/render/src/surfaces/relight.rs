//! Lights that move or change between frames.

use cull::ObjectId;

use crate::error::Error;
use crate::renderer::Renderer;
use crate::scene::{LightId, LightKind, PunctualLight};
use crate::surfaces::light_lists::objects_within;

impl Renderer {
    /// Replaces a light of a scene with surfaces: it moved, or shines otherwise. The next frame shows it.
    /// The cost is that of the objects around its old and its new place, not of the scene.
    ///
    /// # Errors
    /// [`Error::Light`] for a light that the scene does not have, and for one that becomes another kind of
    /// light: pipelines are compiled for the kinds that there are. Make it dark and light another then.
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
        let mut objects: Vec<ObjectId> = Vec::new();
        for (centre, radius_m) in surfaces.replace_light(place, to) {
            objects_within(&self.hierarchy, centre, radius_m, |object| objects.push(object));
        }
        for object in objects {
            if geometry.find_lights(&self.hierarchy, object)
                && let Some(leaf) = self.hierarchy.leaf_of(object)
            {
                geometry.mark(leaf, object);
            }
        }
        Ok(())
    }
}

fn is_same_kind(a: LightKind, b: LightKind) -> bool {
    std::mem::discriminant(&a) == std::mem::discriminant(&b)
}
