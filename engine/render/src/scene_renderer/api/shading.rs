//! The draws of a scene for their colour: surfaces, the sky, and transparent objects.

use cull::CullView;
use gpu::{BufferSlice, Commands};
use occlusion::CulledScene;

use crate::attachment_schedule::AttachmentSchedule;
use crate::scene_renderer::SceneRenderer;
use crate::shading::depth_first::{DARK, Shading};
use crate::shading::fragments::Fragments;

impl SceneRenderer {
    /// Adds the colour to the draws of the rounds, if they have none yet. `draw` repeats all these
    /// draws.
    pub(crate) fn shade_surfaces(
        &mut self,
        scene: &CulledScene,
        commands: &Commands,
        view: &CullView,
        draw: &dyn Fn(&Commands),
    ) {
        if self.pipelines.shading.is_none() {
            return;
        }
        self.draw_culled_maps(commands, view);
        let Self { gpu_scene, pipelines, shadows, target, .. } = self;
        shadows.count_volumes(commands, &gpu_scene.geometry, pipelines, view, target);
        if let Some(transparent) = &self.gpu_scene.transparent {
            transparent.list().prepare(commands);
        }
        self.target.prepare(commands);
        let target = self.target_of(view, None).cleared_to(DARK);
        let target = self.scope_target(commands, AttachmentSchedule::Shade, target);
        commands.pass("shade surfaces", |commands| {
            commands.rendering(target, |commands| {
                self.draw_colours(scene, commands, view, draw);
            });
        });
        self.shadows.end_view();
        self.record_transparent(scene, commands, view);
    }

    /// Draws the surfaces and the sky, and tests the boxes of transparent objects against them.
    pub(crate) fn draw_colours(
        &self,
        scene: &CulledScene,
        commands: &Commands,
        view: &CullView,
        draw: &dyn Fn(&Commands),
    ) {
        // Paper covers all colours.
        if !self.edges.options.mode.is_on_paper() {
            self.draw_surfaces(commands, view, None, draw);
        }
        if let Some(transparent) = &self.gpu_scene.transparent {
            transparent.list().test(scene.passes(), commands, view);
        }
    }

    /// Draws the shadow maps that wait for the finished depth of the view.
    fn draw_culled_maps(&mut self, commands: &Commands, view: &CullView) {
        if !self.shadows.has_culled() {
            return;
        }
        self.target.prepare_tests(commands);
        let target = self.target_of(view, None).depth_only();
        let target = self.scope_target(commands, AttachmentSchedule::CasterTests, target);
        let Self { gpu_scene, pipelines, shadows, .. } = self;
        shadows.record_culled(commands, &gpu_scene.geometry, pipelines, target, view);
    }

    fn draw_surfaces(
        &self,
        commands: &Commands,
        view: &CullView,
        backdrop: Option<[f32; 3]>,
        draw: impl FnOnce(&Commands),
    ) {
        let (Some(Shading { surfaces, sky, .. }), Some(io)) =
            (&self.pipelines.shading, self.surface_io())
        else {
            return;
        };
        surfaces.bind(commands, &io, view, &self.gpu_scene.light);
        draw(commands);
        self.colour_caps(commands, view);
        match (backdrop, io.surfaces.environment.sky()) {
            (None, Some(around)) => {
                sky.draw_around(commands, &around, view, io.surfaces.exposure());
            }
            _ => sky.draw(commands, backdrop.unwrap_or(self.sky())),
        }
    }

    /// Draws all `draws`, a buffer and a count, in their own colours over a backdrop or the sky, to
    /// the [image's target](SceneRenderer::image_target).
    pub(crate) fn draw_all(
        &self,
        scene: &CulledScene,
        commands: &Commands,
        view: &CullView,
        draws: Option<BufferSlice>,
        backdrop: Option<[f32; 3]>,
    ) {
        let draw = |commands: &Commands| {
            if let Some(draws) = draws {
                scene.leaves().predicates().draw_after_counted(commands, draws);
            }
        };
        self.draw_caps(commands, view);
        self.bind_visibility(commands, view);
        draw(commands);
        self.draw_surfaces(commands, view, backdrop, draw);
    }

    /// Draws the transparent objects over the finished image of a view, in a separate rendering.
    pub(crate) fn record_transparent(
        &mut self,
        scene: &CulledScene,
        commands: &Commands,
        view: &CullView,
    ) {
        let Some(transparent) = self
            .gpu_scene
            .transparent
            .as_ref()
            .filter(|transparent| !transparent.list().is_empty())
        else {
            return;
        };
        transparent.list().decide(commands);
        if let Some(io) = self.gpu_scene.fragments().and_then(Fragments::io) {
            return self.record_fragments(scene, commands, view, &io);
        }
        self.target.prepare(commands);
        let target = self.target_of(view, None);
        let target = self.scope_target(commands, AttachmentSchedule::Transparent, target);
        commands.pass("draw transparent", |commands| {
            commands.rendering(target, |commands| self.draw_transparent(scene, commands, view));
        });
    }

    /// Draws the transparent objects of a view to the current attachments.
    fn draw_transparent(&self, scene: &CulledScene, commands: &Commands, view: &CullView) {
        let (Some(transparent), Some(pass)) =
            (&self.gpu_scene.transparent, &self.pipelines.transparent)
        else {
            return;
        };
        if let Some(surfaces) = self.surface_io() {
            transparent.draw(pass, scene, commands, surfaces, view, &self.gpu_scene.light);
        }
    }
}
