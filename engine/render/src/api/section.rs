//! Section planes, which cut away the parts of objects on their removed side.

use cull::{ObjectId, SectionMember, SectionPlanes};
use gpu::{OptionalFeature, Target};
use occlusion::SectionShaders;

use crate::error::Error;
use crate::renderer::Renderer;
use crate::section::read_meshes;

impl Renderer {
    /// Cuts all objects by these planes in every image from now on, except objects that are
    /// [whole](Renderer::set_section_member), and closes solids where they are cut open. Removed
    /// parts cannot be picked, hide nothing, and are culled. Without planes nothing is cut.
    ///
    /// Planes may change in every frame at no cost. The change from no planes to some, or back,
    /// compiles passes and waits for a copy of the meshes.
    ///
    /// # Errors
    /// A device that cannot draw to a depth with a stencil, or binds too few buffers
    /// ([`gpu::OptionalFeature::SectionBuffers`]); no memory, a failed call. Nothing has changed
    /// then.
    pub fn set_section(&mut self, planes: SectionPlanes) -> Result<(), Error> {
        if planes == self.passes.section.planes {
            return Ok(());
        }
        if planes.is_empty() {
            self.leave_whole()?;
        } else if self.passes.section.planes.is_empty() {
            self.prepare_cuts()?;
        }
        self.passes.section.planes = planes;
        self.section_changed();
        Ok(())
    }

    /// Returns the planes that objects are cut by.
    pub fn section(&self) -> &SectionPlanes {
        &self.passes.section.planes
    }

    /// Applies section planes to an object from now on, or leaves it whole. Does nothing for an
    /// object that does not exist.
    pub fn set_section_member(&mut self, object: ObjectId, member: SectionMember) {
        if self.scene.hierarchy().section_member(object) != member {
            self.scene.parts_mut().hierarchy.set_section_member(object, member);
            self.section_changed();
        }
    }

    /// Returns the effect of section planes on an object.
    pub fn section_member(&self, object: ObjectId) -> SectionMember {
        self.scene.hierarchy().section_member(object)
    }

    /// Notes that other parts of objects are visible now.
    fn section_changed(&mut self) {
        self.revision.advance();
        self.passes.shadows.forget();
    }

    /// Compiles the passes that are cut, for images with a stencil.
    fn prepare_cuts(&mut self) -> Result<(), Error> {
        self.device.require(OptionalFeature::SectionBuffers, "section planes")?;
        let meshes = read_meshes(&self.device, &self.passes.gpu_scene.geometry)?;
        let former = if self.passes.target.has_stencil() {
            None
        } else {
            let size = self.size();
            let samples = self.options.samples;
            let target = Target::with_stencil(&self.device, size, samples, "target")?;
            Some(std::mem::replace(&mut self.passes.target, target))
        };
        let shaders = self.shaders.clone().with_section(SectionShaders::Cut);
        if let Err(error) = self.draw_with(shaders) {
            if let Some(former) = former {
                self.passes.target = former;
            }
            return Err(error);
        }
        if former.is_some() {
            self.methods.iter_mut().for_each(|method| method.resized());
        }
        self.passes.gpu_scene.geometry.section_meshes = Some(meshes);
        Ok(())
    }

    /// Compiles the passes that draw objects whole.
    fn leave_whole(&mut self) -> Result<(), Error> {
        self.draw_with(self.shaders.clone().with_section(SectionShaders::Whole))?;
        self.passes.gpu_scene.geometry.section_meshes = None;
        self.passes.section.forget();
        Ok(())
    }
}
