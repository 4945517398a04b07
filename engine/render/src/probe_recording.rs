//! Renderings that the self-test and the cost list record by hand.

use cull::CullView;
use gpu::{Access, Commands, Load, MemoryBarrier};
use occlusion::{BucketId, ObjectRenderer};

use crate::scene_renderer::SceneRenderer;

/// The depth that hides everything, and the one that hides nothing.
pub(crate) const HIDES_ALL: Load<f32> = Load::Clear(1.0);
pub(crate) const HIDES_NOTHING: Load<f32> = Load::Clear(0.0);

/// Records a rendering over a black image of this depth, or over what is there.
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

/// Binds the pass that rounds draw objects with.
pub(crate) fn bind(passes: &SceneRenderer, commands: &Commands, view: &CullView) {
    passes.bind(commands, view, BucketId(0));
}

/// Waits until the results of the frame are cleared.
pub(crate) fn wait_for_reset(commands: &Commands) {
    let reset = [Access::FragmentWrite, Access::IndirectRead, Access::ComputeWrite];
    commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &reset));
}
