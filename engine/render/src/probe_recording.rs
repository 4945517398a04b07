//! Renderings that the self-test and the cost list record themselves.

use cull::CullView;
use gpu::{Access, Commands, Load, MemoryBarrier};
use occlusion::{BucketId, ObjectRenderer};

use crate::scene_renderer::SceneRenderer;

/// The depth that hides everything, and the depth that hides nothing.
pub(crate) const HIDES_ALL: Load<f32> = Load::Clear(1.0);
pub(crate) const HIDES_NOTHING: Load<f32> = Load::Clear(0.0);

/// Records a rendering that clears to black and a depth, or that loads the contents.
pub(crate) fn rendering(
    passes: &mut SceneRenderer,
    commands: &Commands,
    depth: Load<f32>,
    record: impl FnOnce(&SceneRenderer, &Commands),
) {
    passes.target.prepare(commands);
    let mut target = passes.target.render_target(None);
    if depth != Load::Keep {
        (target.colour_load, target.depth_load) = (Load::Clear([0.0; 4]), depth);
    }
    commands.rendering(target, |commands| record(passes, commands));
}

/// Binds the pass that draws objects in rounds.
pub(crate) fn bind(passes: &SceneRenderer, commands: &Commands, view: &CullView) {
    passes.bind(commands, view, BucketId(0));
}

/// Waits until the results of the frame have been cleared.
pub(crate) fn wait_for_reset(commands: &Commands) {
    let reset = [Access::FragmentWrite, Access::IndirectRead, Access::ComputeWrite];
    commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &reset));
}
