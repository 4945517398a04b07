//! The passes that draw a scene's objects, as the executor and the methods see them.

mod api;

use ::shadows::{ShadowMethod, ShadowOptions};
use cull::{Aabb, Containment, CullView, Hierarchy, PlaneMask, Strategy};
use glam::Affine3A;
use gpu::{Commands, Device, Frame, RenderTarget, Target, Tick};
use occlusion::ScenePartsMut;
use occlusion::{
    BucketId, CulledScene, DrawBuckets, Error, ObjectPass, ObjectRenderer, Rendering,
    SectionShaders, ShadedObjects, ShaderSet, UpcomingDraws,
};
use scene::{Light, Scene, TransparentId};

use crate::attachment_schedule::{AttachmentSchedule, ViewScopes};
use crate::debug::depth_complexity::LayerCounts;
use crate::edges::state::Edges;
use crate::passes::pipelines::{DepthFirst, PassNeeds, Pipelines};
use crate::passes::{OpaqueIo, SurfaceIo};
use crate::resources::geometry::{Geometry, bounds_in_world};
use crate::resources::skinned_mesh_state::SkinnedMeshState;
use crate::resources::skinned_meshes::{PoseUploads, Skinned, SkinnedMeshes};
use crate::resources::volume_meshes::VolumeMeshes;
use crate::section::Section;
use crate::shading::depth_first::{DARK, DepthPass};
use crate::shading::fragments::Fragments;
use crate::shading::surfaces::SurfaceOptions;
use crate::shading::surfaces::SurfaceResources;
use crate::shading::transparent::{Transparent, TransparentObject};
use crate::shadows::{MapUses, Shadows};

/// The passes and data that the objects of a scene are drawn with.
pub(crate) struct FramePasses {
    pub(crate) device: Device,
    pub(crate) target: Target,
    pub(crate) geometry: Geometry,
    pub(crate) pipelines: Pipelines,
    pub(crate) light: Light,
    /// The skinned meshes, if there are any.
    pub(crate) skinned_meshes: Option<SkinnedMeshes>,
    /// The transparent objects, if there are any.
    pub(crate) transparent: Option<Transparent>,
    pub(crate) shadows: Shadows,
    pub(crate) edges: Edges,
    /// The counts of the depth complexity, while it is shown.
    pub(crate) layer_counts: LayerCounts,
    /// The section planes and what they cut.
    pub(crate) section: Section,
    /// The renderings of the view that is recorded, if they are known.
    pub(crate) scopes: Option<ViewScopes>,
}

fn needs<'a>(
    target: &Target,
    geometry: &'a Geometry,
    transparent: Option<&Transparent>,
    skinned_meshes: Option<&SkinnedMeshes>,
    shadows: &'a Shadows,
) -> PassNeeds<'a> {
    PassNeeds {
        attachments: target.attachments(),
        surfaces: geometry.surfaces.as_ref(),
        has_transparent: transparent.is_some(),
        sorts_fragments: transparent.is_some_and(|transparent| transparent.fragments.is_some()),
        has_skinned_meshes: skinned_meshes.is_some(),
        shadows: &shadows.options,
        size: target.size(),
    }
}

impl ObjectRenderer for FramePasses {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, view: &CullView, rendering: Rendering) -> RenderTarget {
        let target = match rendering {
            // Caps were the first.
            Rendering::First if self.section.uploaded_caps.is_some() => self.target_of(view, None),
            Rendering::First => self.image_target(view, self.sky()),
            Rendering::Next => self.target_of(view, None),
        };
        if self.pipelines.shading.is_some() { target.depth_only() } else { target }
    }

    fn bind(&self, commands: &Commands, view: &CullView, _bucket: BucketId) {
        self.bind_visibility(commands, view);
    }
}

impl ShadedObjects for FramePasses {
    fn begin_last_rendering(
        &mut self,
        commands: &Commands,
        view: &CullView,
        rendering: Rendering,
    ) -> bool {
        let target = self.rendering(view, rendering);
        let within = AttachmentSchedule::ShadedRound;
        let target = if self.scopes.is_some_and(|scopes| scopes.has(within)) {
            self.scope_target(commands, within, target.cleared_to(DARK))
        } else {
            self.scope_target(commands, AttachmentSchedule::LastRound, target)
        };
        commands.begin_rendering(target)
    }

    fn colour_rendering(&self, view: &CullView) -> RenderTarget {
        self.target_of(view, None)
    }

    fn prepare(&mut self, _pass: ObjectPass, shaders: &ShaderSet) -> Result<(), Error> {
        self.pipelines.depth_first.prepare(&self.device, shaders)
    }

    fn has_draws_to_prepare(&self) -> bool {
        self.skinned_meshes.as_ref().is_some_and(SkinnedMeshes::is_deferring)
    }

    fn prepare_draws(&mut self, commands: &Commands, draws: UpcomingDraws<'_>) {
        if let (Some(skinned_meshes), Some(pass)) =
            (&mut self.skinned_meshes, &self.pipelines.skinning)
        {
            skinned_meshes.prepare(commands, pass, draws);
        }
    }

    fn bind_pass(&self, commands: &Commands, view: &CullView, bucket: BucketId, pass: ObjectPass) {
        let Some(DepthFirst { depth, colour }) = self.pipelines.depth_first.get() else {
            return self.bind(commands, view, bucket);
        };
        let pass = match pass {
            ObjectPass::Depth => depth,
            ObjectPass::Colour => colour,
        };
        pass.bind(commands, &self.opaque_io(), view, &self.light);
    }

    fn shades_later(&self) -> bool {
        self.pipelines.shading.is_some()
    }

    fn shade(
        &mut self,
        scene: &CulledScene,
        commands: &Commands,
        view: &CullView,
        draw: DrawBuckets<'_>,
    ) {
        // Bound already: there is one bucket.
        let draw = |commands: &Commands| draw(commands, &|_, _| {});
        self.shade_surfaces(scene, commands, view, &draw);
    }

    fn prepare_to_shade_within(&mut self, commands: &Commands) -> bool {
        let Some(scopes) = self.scopes else { return false };
        if !self.shades_later() || self.shadows.wait_for_depth() {
            return false;
        }
        self.scopes = Some(scopes.shaded_within());
        if let Some(transparent) = &self.transparent {
            transparent.list().prepare(commands);
        }
        true
    }

    fn shade_within(
        &mut self,
        scene: &CulledScene,
        commands: &Commands,
        view: &CullView,
        draw: DrawBuckets<'_>,
    ) {
        let draw = |commands: &Commands| draw(commands, &|_, _| {});
        commands.label("shade surfaces", |commands| {
            self.draw_colours(scene, commands, view, &draw);
        });
    }

    fn finish_shading(&mut self, scene: &CulledScene, commands: &Commands, view: &CullView) {
        self.record_transparent(scene, commands, view);
    }
}

/// The options of the passes of a frame.
#[derive(Clone, Copy)]
pub(crate) struct FrameOptions<'a> {
    pub(crate) frames_in_flight: usize,
    pub(crate) surfaces: &'a SurfaceOptions,
    /// The bytes of meshes and textures that a frame uploads.
    pub(crate) upload_bytes_per_frame: usize,
    pub(crate) shadows: ShadowOptions,
}

impl FramePasses {
    /// Uploads a scene, with a hierarchy over its objects, and compiles the passes that draw it.
    ///
    /// # Errors
    /// A scene beyond the device's limits, no memory, a shader that does not fit its pass, a failed
    /// call, [`gpu::Error::Cancelled`].
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        scene: &Scene,
        hierarchy: &Hierarchy,
        target: Target,
        options: &FrameOptions<'_>,
    ) -> Result<Self, crate::Error> {
        let FrameOptions { frames_in_flight, surfaces, upload_bytes_per_frame, shadows } = *options;
        let has_surfaces = scene.surfaces.is_some();
        let shadows = Shadows::new(device, shadows, &target, has_surfaces, frames_in_flight)?;
        let mut geometry =
            Geometry::upload(device, scene, hierarchy, surfaces, upload_bytes_per_frame)?;
        let cancellation = &surfaces.cancellation;
        cancellation.check()?;
        let samples = target.attachments().samples;
        let fragments = Fragments::new(device, surfaces.transparency, samples, frames_in_flight);
        let transparent = Transparent::new(device, scene, fragments)?;
        let first_vertex = |mesh| geometry.first_vertex(mesh);
        let skinned_meshes = SkinnedMeshes::new(device, scene, frames_in_flight, first_vertex)?;
        if shadows.options.method == ShadowMethod::Volumes {
            geometry.volumes = Some(VolumeMeshes::new(device, &geometry, skinned_meshes.as_ref())?);
        }
        cancellation.check()?;
        let needs =
            needs(&target, &geometry, transparent.as_ref(), skinned_meshes.as_ref(), &shadows);
        let pipelines = Pipelines::compile(device, shaders, needs, None)?;
        let device = device.clone();
        let light = scene.light;
        Ok(Self {
            device,
            target,
            geometry,
            pipelines,
            light,
            skinned_meshes,
            transparent,
            shadows,
            edges: Edges::default(),
            layer_counts: LayerCounts::default(),
            section: Section::default(),
            scopes: None,
        })
    }

    /// Compiles the same passes with other shaders, or for other shadows.
    ///
    /// # Errors
    /// A shader that does not fit its pass, a failed call.
    pub(crate) fn recompiled(
        &self,
        shaders: &ShaderSet,
        shadows: &Shadows,
    ) -> Result<Pipelines, Error> {
        let Self { target, geometry, transparent, skinned_meshes, .. } = self;
        let needs = needs(target, geometry, transparent.as_ref(), skinned_meshes.as_ref(), shadows);
        let mut pipelines =
            Pipelines::compile(&self.device, shaders, needs, Some(&self.pipelines))?;
        if shaders.section() == SectionShaders::Cut {
            pipelines.caps.prepare(&self.device, shaders)?;
        }
        Ok(pipelines)
    }

    /// Returns the attachments of a view: its part of the target.
    pub(crate) fn target_of(&self, view: &CullView, clear: Option<[f32; 4]>) -> RenderTarget {
        self.target.render_target(clear).within(view.origin, view.size)
    }

    /// Returns the attachments of a rendering with the least to load and to store. To be called
    /// right before it begins, once the target is prepared.
    pub(crate) fn scope_target(
        &mut self,
        commands: &Commands,
        scope: AttachmentSchedule,
        target: RenderTarget,
    ) -> RenderTarget {
        let Some(scopes) = self.scopes else { return target };
        let target = scopes.limit(scope, target);
        if scopes.averages(scope) { self.target.resolved_by(commands, target) } else { target }
    }

    pub(crate) fn opaque_io(&self) -> OpaqueIo {
        OpaqueIo {
            vertices: self.geometry.vertices.whole(),
            indices: self.geometry.indices.whole(),
            instances: self.geometry.instances.whole(),
            section: self.section.io(),
        }
    }

    /// Returns the sky's colour as it is exposed, as light, so that it is no brighter than white.
    pub(crate) fn sky(&self) -> [f32; 3] {
        let surfaces = self.geometry.surfaces.as_ref();
        let exposure = surfaces.map_or(1.0, SurfaceResources::exposure);
        self.light.sky.map(|part| (part * exposure).min(1.0))
    }

    /// Returns the attachments of [`FramePasses::draw_all`], cleared to a backdrop.
    pub(crate) fn image_target(&self, view: &CullView, backdrop: [f32; 3]) -> RenderTarget {
        let [red, green, blue] = backdrop;
        let plain = [red, green, blue, 1.0];
        self.target_of(view, Some(self.pipelines.shading.as_ref().map_or(plain, |_| DARK)))
    }

    /// Binds the pass that the rounds draw objects with: the one with colours where no other pass
    /// adds them.
    pub(crate) fn bind_visibility(&self, commands: &Commands, view: &CullView) {
        let Pipelines { opaque, shading, .. } = &self.pipelines;
        let pass = match (shading.as_ref().map(|shading| &shading.depth), self.surface_io()) {
            (Some(DepthPass::Masked(pass)), Some(io)) => {
                return pass.bind(commands, &io, view, &self.light);
            }
            (Some(DepthPass::Whole(pass)), _) => pass,
            _ => opaque,
        };
        pass.bind(commands, &self.opaque_io(), view, &self.light);
    }

    pub(crate) fn surface_io(&self) -> Option<SurfaceIo<'_>> {
        Some(SurfaceIo {
            vertices: self.geometry.vertices.whole(),
            indices: self.geometry.indices.whole(),
            instances: self.geometry.instances.whole(),
            surfaces: self.geometry.surfaces.as_ref()?,
            shadows: self.shadows.io(),
            section: self.section.io(),
            fragments: None,
        })
    }

    /// Gathers the transparent objects of a view, which its [shading](ObjectRenderer::shade) draws.
    /// Returns the number in its frustum.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn gather_transparent(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &CulledScene,
        view: &CullView,
        strategy: Strategy,
    ) -> Result<u32, crate::Error> {
        let Some(transparent) = &mut self.transparent else { return Ok(0) };

        transparent.gather(frame, &self.geometry, scene.passes(), view, strategy.culls_occluded())
    }

    /// Changes a transparent object, if it is there, and finds its lights again.
    pub(crate) fn change_transparent(
        &mut self,
        id: TransparentId,
        change: impl FnOnce(&mut TransparentObject),
    ) -> Result<(), crate::Error> {
        let bounds =
            self.transparent.as_mut().and_then(|transparent| transparent.change(id, change));
        if let (Some(bounds), Some(surfaces)) = (bounds, &mut self.geometry.surfaces) {
            surfaces.move_transparent(id, &bounds)?;
        }
        Ok(())
    }

    /// Records the upload of all changes since the last frame, before anything of `frame` reads
    /// them. Poses that none of the views can show wait until one can.
    ///
    /// A mesh waits only where the box of its pose **and** the box of the vertices on the GPU are
    /// outside of all views: its draw may be part of a range that shows, and then leaves no pixel.
    ///
    /// # Errors
    /// No memory, a lost device.
    pub(crate) fn upload_changes(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &mut CulledScene,
        uploads: PoseUploads<'_>,
        views: &[CullView],
        uses: MapUses,
    ) -> Result<(), crate::Error> {
        let ScenePartsMut { hierarchy, leaves, .. } = scene.parts_mut();
        self.geometry.relight(hierarchy, leaves);
        if let Some(fragments) = self.fragments_mut() {
            fragments.begin_frame(frame)?;
        }
        let hierarchy = scene.hierarchy();
        let opaque = hierarchy.root().map_or(Aabb::EMPTY, |root| hierarchy.bounds(root));
        let transparent = self.transparent.as_ref().filter(|_| self.shadows.culls_casters());
        let transparent = transparent.map_or(Aabb::EMPTY, Transparent::bounds);
        let opaque_and_transparent = opaque.union(&transparent);
        self.shadows.plan(&self.geometry, hierarchy, opaque_and_transparent, views, uses)?;
        self.geometry.upload_changes(frame, scene)?;
        let hierarchy = scene.hierarchy();
        self.edges.upload(frame, scene, &self.geometry)?;
        self.upload_poses(frame, hierarchy, uploads)?;
        let Self { geometry, pipelines, shadows, section, .. } = self;
        let predicates = scene.leaves().predicates();
        shadows.record(frame, geometry, hierarchy, section, pipelines, predicates)
    }

    fn upload_poses(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
        uploads: PoseUploads<'_>,
    ) -> Result<(), crate::Error> {
        let Self { device, geometry, pipelines, skinned_meshes, transparent, shadows, .. } = self;
        let (Some(skinned_meshes), Some(pass), Some(vertices)) =
            (skinned_meshes, &pipelines.skinning, geometry.skinned())
        else {
            return Ok(());
        };
        let transform = |state: &SkinnedMeshState| match state.transparent {
            Some(id) => transparent.as_ref()?.transform(id),
            None => geometry.transform(geometry.owner(state.mesh)?),
        };
        let is_in = |views: &[CullView], bounds: &Aabb, transform: &Affine3A| {
            let Some(bounds) = bounds_in_world(bounds, transform) else { return true };
            let is_outside = |(containment, _)| containment == Containment::Outside;
            views.iter().any(|view| !is_outside(view.frustum.classify(&bounds, PlaneMask::ALL)))
        };
        // A light may see what no view sees.
        let casts = |state: &SkinnedMeshState| {
            let leaf = || hierarchy.leaf_of(geometry.owner(state.mesh)?);
            state.transparent.is_none() && leaf().is_some_and(|leaf| shadows.draw(leaf))
        };
        let is_seen = |state: &SkinnedMeshState| match (transform(state), uploads) {
            (None, _) => false,
            (Some(_), PoseUploads::All) => true,
            _ if casts(state) => true,
            (Some(transform), PoseUploads::Seen(views)) => [state.bounds, state.shown_bounds]
                .iter()
                .any(|bounds| is_in(views, bounds, &transform)),
        };
        let leaf_of = |state: &SkinnedMeshState| {
            let PoseUploads::Seen(views) = uploads else { return None };
            let can_be_tested = state.transparent.is_none()
                && !casts(state)
                && is_in(views, &state.bounds, &transform(state)?);
            can_be_tested.then(|| hierarchy.leaf_of(geometry.owner(state.mesh)?)).flatten()
        };
        let completed = device.completed()?;
        skinned_meshes.upload(frame, completed, pass, vertices, is_seen, leaf_of)
    }

    /// Writes the vertices of meshes that the last frames left to a test: a draw of objects that
    /// are hidden follows.
    ///
    /// # Errors
    /// No memory, a lost device.
    pub(crate) fn write_stale(&mut self, frame: &mut Frame<'_>) -> Result<(), crate::Error> {
        let Self { device, geometry, pipelines, skinned_meshes, .. } = self;
        let (Some(skinned_meshes), Some(pass), Some(vertices)) =
            (skinned_meshes, &pipelines.skinning, geometry.skinned())
        else {
            return Ok(());
        };
        let completed = device.completed()?;
        let is_stale = |state: &SkinnedMeshState| state.is_stale;
        skinned_meshes.upload(frame, completed, pass, vertices, is_stale, |_| None)
    }

    /// Notes that the frame of the last [`FramePasses::write_stale`] was submitted.
    pub(crate) fn stale_submitted(&mut self, tick: Tick) {
        if let Some(skinned_meshes) = &mut self.skinned_meshes {
            skinned_meshes.submitted(tick);
        }
    }

    /// Records the last commands of a frame that changes were uploaded in.
    pub(crate) fn read_back(&self, commands: &Commands) {
        if let Some(skinned_meshes) = &self.skinned_meshes {
            skinned_meshes.read_back(commands);
        }
        if let Some(fragments) = self.fragments() {
            fragments.read_back(commands);
        }
    }

    /// Returns the work for skinned meshes in the frame that was recorded last.
    pub(crate) fn skinned(&self) -> Skinned {
        self.skinned_meshes.as_ref().map(SkinnedMeshes::skinned).unwrap_or_default()
    }

    /// Changes the number of frames in flight.
    pub(crate) fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        if let Some(skinned_meshes) = &mut self.skinned_meshes {
            skinned_meshes.set_frames_in_flight(&self.device, frames_in_flight);
        }
        self.shadows.set_frames_in_flight(frames_in_flight);
        if let Some(fragments) = self.fragments_mut() {
            fragments.set_frames_in_flight(frames_in_flight);
        }
    }

    /// Notes that the frame of the last [`FramePasses::upload_changes`] was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        self.target.submitted();
        self.geometry.submitted();
        self.edges.submitted();
        self.shadows.submitted(tick);
        if let Some(fragments) = self.fragments_mut() {
            fragments.submitted(tick);
        }
        if let Some(skinned_meshes) = &mut self.skinned_meshes {
            skinned_meshes.submitted(tick);
        }
    }
}
