//! Transparent objects with sorted fragments.

use cull::CullView;
use gpu::{Access, BufferSlice, Commands, MemoryBarrier};
use occlusion::CulledScene;

use crate::attachment_schedule::AttachmentSchedule;
use crate::passes::{FragmentIo, SurfaceIo};
use crate::scene_renderer::SceneRenderer;

impl SceneRenderer {
    /// Stores the fragments of the transparent objects of a view, and blends them over its image,
    /// in two renderings.
    pub(super) fn record_fragments(
        &mut self,
        scene: &CulledScene,
        commands: &Commands,
        view: &CullView,
        io: &FragmentIo,
    ) {
        if let Some(fragments) = self.gpu_scene.fragments() {
            fragments.clear(commands);
        }
        self.target.prepare_tests(commands);
        let target = self.target_of(view, None);
        let storing = self.scope_target(commands, AttachmentSchedule::Fragments, target);
        commands.pass("store fragments", |commands| {
            commands.rendering(storing, |commands| {
                self.store_fragments(scene, commands, view, io.fragments);
            });
            let accesses = [Access::FragmentWrite];
            commands.barrier(MemoryBarrier::between(&accesses, &accesses));
        });
        self.target.prepare(commands);
        let target = self.target_of(view, None);
        let sorting = self.scope_target(commands, AttachmentSchedule::Transparent, target);
        commands.pass("draw transparent", |commands| {
            commands.rendering(sorting, |commands| {
                if let Some(passes) = &self.pipelines.fragments {
                    passes.sort(commands, io);
                }
            });
        });
    }

    fn store_fragments(
        &self,
        scene: &CulledScene,
        commands: &Commands,
        view: &CullView,
        fragments: BufferSlice,
    ) {
        let (Some(transparent), Some(passes), Some(surfaces)) =
            (&self.gpu_scene.transparent, &self.pipelines.fragments, self.surface_io())
        else {
            return;
        };
        let surfaces = SurfaceIo { fragments: Some(fragments), ..surfaces };
        transparent.draw(&passes.storing, scene, commands, surfaces, view, &self.gpu_scene.light);
    }
}
