//! All passes of a renderer, compiled from one set of shaders.

use ::shadows::{ShadowMethod, ShadowOptions};
use gpu::{Attachments, Device, OptionalFeature};
use occlusion::{BoxVolumePass, Error, ShaderSet};

use crate::passes::{
    CapPass, CountPass, EdgePass, FlarePass, FragmentPasses, LayersPass, MapPasses, OpaquePass,
    OutlinePass, OverlayPass, SeenPass, SkinningPass, SurfaceKind, SurfacePass, SurfaceShadows,
    VolumePass, VolumePath,
};
use crate::shading::depth_first::Shading;
use crate::shading::surfaces::SurfaceResources;

/// The passes of a renderer. [`Pipelines::compile`] is the only list of them, for new renderers and
/// for other shaders.
pub(crate) struct Pipelines {
    pub(crate) opaque: OpaquePass,
    /// The passes of scenes with surfaces.
    pub(crate) shading: Option<Shading>,
    /// The pass of transparent objects, if there are any.
    pub(crate) transparent: Option<SurfacePass>,
    /// The passes of transparent objects with sorted fragments, if fragments are sorted.
    pub(crate) fragments: Option<FragmentPasses>,
    /// The pass of skinned meshes, if there are any.
    pub(crate) skinning: Option<SkinningPass>,
    /// The passes of shadow maps, if there are any.
    pub(crate) maps: Option<MapPasses>,
    /// The pass that tests which casters matter, if casters are culled.
    pub(crate) shadow_tests: Option<BoxVolumePass>,
    /// The pass of shadow volumes, if there are any.
    pub(crate) volumes: Option<VolumePass>,
    /// The opaque pass in two parts, for methods that draw depth first.
    pub(crate) depth_first: OnDemand<DepthFirst>,
    pub(crate) caps: OnDemand<CapPass>,
    pub(crate) count: OnDemand<CountPass>,
    pub(crate) flares: OnDemand<FlarePass>,
    /// The pass of transparent objects in front of flares, if there are both.
    pub(crate) transmittance: Option<SurfacePass>,
    pub(crate) seen: OnDemand<SeenPass>,
    pub(crate) pointer: OnDemand<SeenPass>,
    pub(crate) overlay: OnDemand<OverlayPass>,
    pub(crate) wireframe: OnDemand<OpaquePass>,
    pub(crate) layers: OnDemand<LayersPass>,
    pub(crate) edges: OnDemand<EdgePass>,
    pub(crate) outlines: OnDemand<OutlinePass>,
}

/// The parts of a scene that need passes of their own.
#[derive(Clone, Copy)]
pub(crate) struct PassNeeds<'a> {
    /// The images that all passes except shadow maps draw to.
    pub(crate) attachments: Attachments,
    pub(crate) surfaces: Option<&'a SurfaceResources>,
    pub(crate) has_transparent: bool,
    /// True if fragments of transparent objects are sorted.
    pub(crate) sorts_fragments: bool,
    pub(crate) has_skinned_meshes: bool,
    pub(crate) shadows: &'a ShadowOptions,
    /// The size of the image in pixels.
    pub(crate) size: [u32; 2],
}

/// Returns the shadows that surfaces are drawn with.
fn surface_shadows(options: &ShadowOptions) -> Option<SurfaceShadows> {
    match options.method {
        ShadowMethod::Off => None,
        ShadowMethod::Maps => Some(SurfaceShadows::Maps(options.filter)),
        ShadowMethod::Volumes => Some(SurfaceShadows::Volumes),
    }
}

impl Pipelines {
    /// Compiles the passes that a scene needs, and the passes on demand that are compiled in
    /// `former`.
    pub(crate) fn compile(
        device: &Device,
        shaders: &ShaderSet,
        needs: PassNeeds<'_>,
        former: Option<&Self>,
    ) -> Result<Self, Error> {
        let PassNeeds { attachments, surfaces, has_transparent, has_skinned_meshes, .. } = needs;
        let options = needs.shadows;
        let shadows = surface_shadows(options);
        let transmitted = surfaces.filter(|_| has_transparent);
        let transparent = transmitted;
        let transparent = transparent
            .map(|transparent| {
                SurfacePass::new(
                    device,
                    shaders,
                    attachments,
                    SurfaceKind::Transparent,
                    transparent,
                    shadows,
                )
            })
            .transpose()?;
        let fragments = transmitted.filter(|_| needs.sorts_fragments);
        let fragments = fragments
            .map(|fragment| FragmentPasses::new(device, shaders, attachments, fragment, shadows))
            .transpose()?;
        let skinning =
            has_skinned_meshes.then(|| SkinningPass::new(device, shaders)).transpose()?;
        let has_maps = options.method == ShadowMethod::Maps;
        let maps = surfaces
            .filter(|_| has_maps)
            .map(|surfaces| MapPasses::new(device, shaders, surfaces, options.bias))
            .transpose()?;
        let volumes = (options.method == ShadowMethod::Volumes)
            .then(|| VolumePass::new(device, shaders, needs.size, VolumePath::of(device)))
            .transpose()?;
        let can_cull = options.method != ShadowMethod::Off
            && options.may_cull_casters()
            && device.capabilities().has(OptionalFeature::FragmentStores);
        let shadow_tests =
            can_cull.then(|| BoxVolumePass::new(device, shaders, attachments)).transpose()?;
        let on_demand = Former { device, shaders, attachments, former };
        let transmittance =
            match (transmitted, former.and_then(|former| former.transmittance.as_ref())) {
                (Some(pass), Some(_)) => Some(SurfacePass::new(
                    device,
                    shaders,
                    attachments,
                    SurfaceKind::Transmittance,
                    pass,
                    None,
                )?),
                _ => None,
            };
        Ok(Self {
            opaque: OpaquePass::new(device, shaders, attachments)?,
            shading: surfaces
                .map(|surface| Shading::new(device, shaders, attachments, surface, shadows))
                .transpose()?,
            transparent,
            fragments,
            skinning,
            maps,
            shadow_tests,
            volumes,
            depth_first: on_demand.again(|on_demand| &on_demand.depth_first, DepthFirst::new)?,
            caps: on_demand.again(|on_demand| &on_demand.caps, CapPass::new)?,
            count: on_demand.again(|on_demand| &on_demand.count, CountPass::new)?,
            flares: on_demand.again(|on_demand| &on_demand.flares, FlarePass::new)?,
            transmittance,
            seen: on_demand.again(|on_demand| &on_demand.seen, SeenPass::new)?,
            pointer: on_demand.again(|on_demand| &on_demand.pointer, SeenPass::of_pointer)?,
            overlay: on_demand.again(|on_demand| &on_demand.overlay, OverlayPass::new)?,
            wireframe: on_demand.again(|on_demand| &on_demand.wireframe, OpaquePass::wireframe)?,
            layers: on_demand.again(|on_demand| &on_demand.layers, LayersPass::new)?,
            edges: on_demand.again(|on_demand| &on_demand.edges, EdgePass::new)?,
            outlines: on_demand.again(|on_demand| &on_demand.outlines, OutlinePass::new)?,
        })
    }
}

type Constructor<P> = fn(&Device, &ShaderSet, Attachments) -> Result<P, Error>;

/// A pass that is compiled when it is first needed.
pub(crate) struct OnDemand<P> {
    compile: Constructor<P>,
    attachments: Attachments,
    pass: Option<P>,
}

impl<P> OnDemand<P> {
    /// Compiles the pass unless it is already compiled.
    pub(crate) fn prepare(&mut self, device: &Device, shaders: &ShaderSet) -> Result<(), Error> {
        if self.pass.is_none() {
            self.pass = Some((self.compile)(device, shaders, self.attachments)?);
        }
        Ok(())
    }

    /// Returns the pass, if it is compiled.
    pub(crate) fn get(&self) -> Option<&P> {
        self.pass.as_ref()
    }
}

/// The passes with the former shaders, if there are any.
struct Former<'a> {
    device: &'a Device,
    shaders: &'a ShaderSet,
    attachments: Attachments,
    former: Option<&'a Pipelines>,
}

impl Former<'_> {
    /// Returns a pass on demand, which is compiled if the former one is.
    fn again<P>(
        &self,
        pass_of: fn(&Pipelines) -> &OnDemand<P>,
        compile: Constructor<P>,
    ) -> Result<OnDemand<P>, Error> {
        let mut pass = OnDemand { compile, attachments: self.attachments, pass: None };
        if self.former.is_some_and(|former| pass_of(former).get().is_some()) {
            pass.prepare(self.device, self.shaders)?;
        }
        Ok(pass)
    }
}

/// The opaque pass in two parts: depth, then colour.
pub(crate) struct DepthFirst {
    pub(crate) depth: OpaquePass,
    pub(crate) colour: OpaquePass,
}

impl DepthFirst {
    fn new(device: &Device, shaders: &ShaderSet, attachments: Attachments) -> Result<Self, Error> {
        Ok(Self {
            depth: OpaquePass::depth_only(device, shaders, attachments)?,
            colour: OpaquePass::colour_only(device, shaders, attachments)?,
        })
    }
}
