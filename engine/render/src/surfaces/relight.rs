//! Lights that move or change between frames.

use cull::Hierarchy;
use occlusion::LeafTable;
use scene::{LightId, LightKind, PunctualLight};

use crate::error::Error;
use crate::geometry::Geometry;
use crate::renderer::Renderer;
use crate::surfaces::SurfaceResources;

impl Renderer {
    /// Replaces a light of a scene with surfaces: it moved, or shines otherwise. The next frame shows it.
    /// The cost is that of the objects around its old and its new place, not of the scene; they find their
    /// lights once a frame, however many lights change.
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
        surfaces.replace_light(&self.hierarchy, light, to);
        Ok(())
    }
}

impl Geometry {
    /// Finds the lights again of who is around a light that changed since the last frame.
    pub(crate) fn relight(&mut self, hierarchy: &Hierarchy, leaves: &mut LeafTable) {
        let objects = self.surfaces.as_mut().map(SurfaceResources::relight).unwrap_or_default();
        for object in objects {
            if self.find_lights(hierarchy, object)
                && let Some(leaf) = hierarchy.leaf_of(object)
            {
                leaves.mark(leaf, self.draw_of(object));
            }
        }
    }
}

fn is_same_kind(a: LightKind, b: LightKind) -> bool {
    std::mem::discriminant(&a) == std::mem::discriminant(&b)
}
