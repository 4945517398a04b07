//! The lights that flare in every image.

use gpu::OptionalFeature;
use scene::LensFlare;
use scene::limits::MAX_FLARES;

use crate::debug::sample_counts::check_counts;
use crate::error::Error;
use crate::passes::{SurfaceKind, SurfacePass};
use crate::renderer::Renderer;

impl Renderer {
    /// Replaces the lights that flare in every image from now on: a glow and ghosts are added over
    /// the scene. The brightness of a flare follows, some frames later, the visible share of its
    /// light ([`RenderView::flares`](crate::RenderView::flares)): opaque and masked objects hide
    /// the light, and transparent objects take their alpha. Nothing waits.
    ///
    /// A flare is identified by its index in the list: to move a light, pass the list again. A new
    /// flare fades in. Each flare costs a few small draws per frame and view; an empty list costs
    /// nothing. Lights of the scene flare by [`LensFlare::of_light`].
    ///
    /// Frames are the same under every exact strategy. On a device without
    /// [`gpu::OptionalFeature::FragmentStores`], transparent objects let all light through.
    ///
    /// # Errors
    /// [`Error::Flare`] for a flare that cannot be drawn; [`Error::SceneTooLarge`] for more than
    /// [`MAX_FLARES`]; a device that cannot count ([`Renderer::supports_counts`]); a shader that
    /// does not compile, a failed call. Nothing has changed then.
    pub fn set_flares(&mut self, flares: &[LensFlare]) -> Result<(), Error> {
        if flares.len() > MAX_FLARES {
            return Err(Error::SceneTooLarge {
                what: "lens flares",
                wanted: flares.len() as u64,
                limit: MAX_FLARES as u64,
                instead: "give those of the brightest and nearest lights",
            });
        }
        for (index, flare) in flares.iter().enumerate() {
            flare.check().map_err(|reason| Error::Flare { index, reason })?;
        }
        if !flares.is_empty() {
            check_counts(&self.device, "lens flares")?;
            self.prepare_flares()?;
        }
        self.flares.clear();
        self.flares.extend_from_slice(flares);
        Ok(())
    }

    /// Returns the lights that flare.
    pub fn flares(&self) -> &[LensFlare] {
        &self.flares
    }

    /// Compiles the passes of flares, unless they are compiled already.
    fn prepare_flares(&mut self) -> Result<(), Error> {
        let Self { device, shaders, passes, .. } = self;
        let attachments = passes.target.attachments();
        let pipelines = &mut passes.pipelines;
        pipelines.flares.prepare(device, shaders)?;
        let can_transmittance = device.capabilities().has(OptionalFeature::FragmentStores);
        let surfaces = passes.gpu_scene.geometry.surfaces.as_ref();
        let surfaces = surfaces.filter(|_| can_transmittance && pipelines.transparent.is_some());
        if let (Some(surfaces), None) = (surfaces, &pipelines.transmittance) {
            let pass = SurfacePass::new(
                device,
                &*shaders,
                attachments,
                SurfaceKind::Transmittance,
                surfaces,
                None,
            )?;
            pipelines.transmittance = Some(pass);
        }
        Ok(())
    }
}
