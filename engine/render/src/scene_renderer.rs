//! The passes that draw a scene's objects, as the executor and the methods call them.

mod api;

use crate::gpu_scene::GpuScene;
use cull::{Aabb, CullView};
use gpu::{Commands, Device, Frame, RenderTarget, Target, Tick};
use occlusion::ScenePartsMut;
use occlusion::{
    BucketId, CulledScene, DrawBuckets, Error, ObjectPass, ObjectRenderer, Rendering,
    SectionShaders, ShadedObjects, ShaderSet, UpcomingDraws,
};

use crate::attachment_schedule::{AttachmentSchedule, ViewScopes};
use crate::debug::depth_complexity::LayerCounts;
use crate::edges::state::Edges;
use crate::passes::pipelines::{DepthFirst, PassNeeds, Pipelines};
use crate::passes::{OpaqueIo, SurfaceIo};
use crate::resources::skinned_meshes::{PoseUploads, SkinnedMeshes};
use crate::section::Section;
use crate::shading::depth_first::{DARK, DepthPass};
use crate::shading::surfaces::SurfaceResources;
use crate::shading::transparent::Transparent;
use crate::shadows::{MapUses, Shadows};

/// The passes and data that the objects of a scene are drawn with.
pub(crate) struct SceneRenderer {
    pub(crate) device: Device,
    pub(crate) target: Target,
    pub(crate) gpu_scene: GpuScene,
    pub(crate) pipelines: Pipelines,
    pub(crate) shadows: Shadows,
    pub(crate) edges: Edges,
    /// The counts for the depth complexity, while it is shown.
    pub(crate) layer_counts: LayerCounts,
    /// The section planes and the objects that they cut.
    pub(crate) section: Section,
    /// The renderings of the view being recorded, if they are known.
    pub(crate) scopes: Option<ViewScopes>,
}

/// Returns the passes that the objects of a scene need.
fn needs<'a>(target: &Target, gpu_scene: &'a GpuScene, shadows: &'a Shadows) -> PassNeeds<'a> {
    PassNeeds {
        attachments: target.attachments(),
        surfaces: gpu_scene.geometry.surfaces.as_ref(),
        has_transparent: gpu_scene.transparent.is_some(),
        sorts_fragments: gpu_scene.fragments().is_some(),
        has_skinned_meshes: gpu_scene.skinned_meshes.is_some(),
        shadows: &shadows.options,
        size: target.size(),
    }
}

impl ObjectRenderer for SceneRenderer {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, view: &CullView, rendering: Rendering) -> RenderTarget {
        let target = match rendering {
            // Caps were drawn first, and have cleared the target.
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

impl ShadedObjects for SceneRenderer {
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
        self.gpu_scene.skinned_meshes.as_ref().is_some_and(SkinnedMeshes::is_deferring)
    }

    fn prepare_draws(&mut self, commands: &Commands, draws: UpcomingDraws<'_>) {
        if let (Some(skinned_meshes), Some(pass)) =
            (&mut self.gpu_scene.skinned_meshes, &self.pipelines.skinning)
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
        pass.bind(commands, &self.opaque_io(), view, &self.gpu_scene.light);
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
        // Everything is already bound, since there is one bucket.
        let draw = |commands: &Commands| draw(commands, &|_, _| {});
        self.shade_surfaces(scene, commands, view, &draw);
    }

    fn prepare_to_shade_within(&mut self, commands: &Commands) -> bool {
        let Some(scopes) = self.scopes else { return false };
        if !self.shades_later() || self.shadows.wait_for_depth() {
            return false;
        }
        self.scopes = Some(scopes.shaded_within());
        if let Some(transparent) = &self.gpu_scene.transparent {
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

impl SceneRenderer {
    /// Compiles the passes that draw an uploaded scene.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        gpu_scene: GpuScene,
        target: Target,
        shadows: Shadows,
    ) -> Result<Self, crate::Error> {
        let pipelines =
            Pipelines::compile(device, shaders, needs(&target, &gpu_scene, &shadows), None)?;
        Ok(Self {
            device: device.clone(),
            target,
            gpu_scene,
            pipelines,
            shadows,
            edges: Edges::default(),
            layer_counts: LayerCounts::default(),
            section: Section::default(),
            scopes: None,
        })
    }

    /// Compiles these passes with other shaders, or for other shadows.
    pub(crate) fn recompiled(
        &self,
        shaders: &ShaderSet,
        shadows: &Shadows,
    ) -> Result<Pipelines, Error> {
        let needs = needs(&self.target, &self.gpu_scene, shadows);
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

    /// Returns the attachments of a rendering with as few loads and stores as possible. Call it
    /// right before the rendering begins, after the target is prepared.
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
            vertices: self.gpu_scene.geometry.vertices.whole(),
            indices: self.gpu_scene.geometry.indices.whole(),
            instances: self.gpu_scene.geometry.instances.whole(),
            section: self.section.io(),
        }
    }

    /// Returns the exposed colour of the sky as light, limited to white.
    pub(crate) fn sky(&self) -> [f32; 3] {
        let surfaces = self.gpu_scene.geometry.surfaces.as_ref();
        let exposure = surfaces.map_or(1.0, SurfaceResources::exposure);
        self.gpu_scene.light.sky.map(|part| (part * exposure).min(1.0))
    }

    /// Returns the attachments of [`SceneRenderer::draw_all`], cleared to a backdrop.
    pub(crate) fn image_target(&self, view: &CullView, backdrop: [f32; 3]) -> RenderTarget {
        let [red, green, blue] = backdrop;
        let plain = [red, green, blue, 1.0];
        self.target_of(view, Some(self.pipelines.shading.as_ref().map_or(plain, |_| DARK)))
    }

    /// Binds the pass that rounds draw objects with: with colours unless another pass adds them.
    pub(crate) fn bind_visibility(&self, commands: &Commands, view: &CullView) {
        let Pipelines { opaque, shading, .. } = &self.pipelines;
        let pass = match (shading.as_ref().map(|shading| &shading.depth), self.surface_io()) {
            (Some(DepthPass::Masked(pass)), Some(io)) => {
                return pass.bind(commands, &io, view, &self.gpu_scene.light);
            }
            (Some(DepthPass::Whole(pass)), _) => pass,
            _ => opaque,
        };
        pass.bind(commands, &self.opaque_io(), view, &self.gpu_scene.light);
    }

    pub(crate) fn surface_io(&self) -> Option<SurfaceIo<'_>> {
        Some(SurfaceIo {
            vertices: self.gpu_scene.geometry.vertices.whole(),
            indices: self.gpu_scene.geometry.indices.whole(),
            instances: self.gpu_scene.geometry.instances.whole(),
            surfaces: self.gpu_scene.geometry.surfaces.as_ref()?,
            shadows: self.shadows.io(),
            section: self.section.io(),
            fragments: None,
        })
    }

    /// Records the upload of all changes since the last frame, before anything of `frame` reads
    /// them. Poses that no view can show wait until one can.
    ///
    /// A mesh waits only if the box of its pose **and** the box of the vertices on the GPU are
    /// outside of all views: its draw may be part of a visible range, and then must not cover a
    /// pixel.
    pub(crate) fn upload_changes(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &mut CulledScene,
        uploads: PoseUploads<'_>,
        views: &[CullView],
        uses: MapUses,
    ) -> Result<(), crate::Error> {
        let ScenePartsMut { hierarchy, leaves, .. } = scene.parts_mut();
        self.gpu_scene.geometry.relight(hierarchy, leaves);
        if let Some(fragments) = self.gpu_scene.fragments_mut() {
            fragments.begin_frame(frame)?;
        }
        let hierarchy = scene.hierarchy();
        let opaque = hierarchy.root().map_or(Aabb::EMPTY, |root| hierarchy.bounds(root));
        let transparent =
            self.gpu_scene.transparent.as_ref().filter(|_| self.shadows.culls_casters());
        let transparent = transparent.map_or(Aabb::EMPTY, Transparent::bounds);
        let opaque_and_transparent = opaque.union(&transparent);
        self.shadows.plan(
            &self.gpu_scene.geometry,
            hierarchy,
            opaque_and_transparent,
            views,
            uses,
        )?;
        self.gpu_scene.geometry.upload_changes(frame, scene)?;
        let hierarchy = scene.hierarchy();
        self.edges.upload(frame, scene, &self.gpu_scene.geometry)?;
        self.upload_poses(frame, hierarchy, uploads)?;
        let Self { gpu_scene, pipelines, shadows, section, .. } = self;
        let geometry = &gpu_scene.geometry;
        let predicates = scene.leaves().predicates();
        shadows.record(frame, geometry, hierarchy, section, pipelines, predicates)
    }

    /// Records the last commands of a frame in which changes were uploaded.
    pub(crate) fn read_back(&self, commands: &Commands) {
        if let Some(skinned_meshes) = &self.gpu_scene.skinned_meshes {
            skinned_meshes.read_back(commands);
        }
        if let Some(fragments) = self.gpu_scene.fragments() {
            fragments.read_back(commands);
        }
    }

    /// Changes the number of frames in flight.
    pub(crate) fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        if let Some(skinned_meshes) = &mut self.gpu_scene.skinned_meshes {
            skinned_meshes.set_frames_in_flight(&self.device, frames_in_flight);
        }
        self.shadows.set_frames_in_flight(frames_in_flight);
        if let Some(fragments) = self.gpu_scene.fragments_mut() {
            fragments.set_frames_in_flight(frames_in_flight);
        }
    }

    /// Notes that the frame of the last [`SceneRenderer::upload_changes`] was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        self.target.submitted();
        self.gpu_scene.geometry.submitted();
        self.edges.submitted();
        self.shadows.submitted(tick);
        if let Some(fragments) = self.gpu_scene.fragments_mut() {
            fragments.submitted(tick);
        }
        if let Some(skinned_meshes) = &mut self.gpu_scene.skinned_meshes {
            skinned_meshes.submitted(tick);
        }
    }
}
