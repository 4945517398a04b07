//! The edges of a view, drawn over its finished image and against its finished depth.
//!
//! The visible edges depend only on that depth, which is the same under every strategy. The edges
//! of all objects around the frustum are drawn, including the edges of hidden objects.

use crate::view_pass::ViewPass;
use gpu::{Access, BufferSlice, Frame, MemoryBarrier};
use occlusion::MeshDrawId;

use super::options::EdgeMode;
use crate::attachment_schedule::AttachmentSchedule;
use crate::error::Error;
use crate::gpu_scene::GpuScene;
use crate::passes::{EdgeIo, EdgeTest};
use crate::scene_renderer::SceneRenderer;

/// The pass that draws edges.
const EDGES: &str = "draw edges";

/// The draws of the transparent objects of a view.
struct TransparentEdges {
    instances: BufferSlice,
    /// The section states of the instances: all are cut, pixel by pixel.
    states: BufferSlice,
    draws: BufferSlice,
}

/// Draws the edges of a view, if they are on.
pub(crate) fn record_edges(view_pass: &mut ViewPass<'_, '_>) -> Result<(), Error> {
    let ViewPass { passes, frame, scene, view } = view_pass;
    let options = passes.edges.options;
    if options.mode == EdgeMode::Off {
        return Ok(());
    }
    // Snapping and rounding move a line by less than a pixel.
    let frustum = view.frustum_around(options.width_pixels / 2.0 + 1.0);
    let mut ranges = std::mem::take(&mut passes.edges.ranges);
    ranges.clear();
    scene.hierarchy().leaves_in(&frustum, view, &mut ranges);
    let transparent = transparent_edges(passes, frame, &frustum)?;
    wait_for_vertices(frame);
    passes.target.prepare(frame.commands());
    let mut target = passes.target_of(view, None);
    let mut scope = AttachmentSchedule::Edges;
    if options.mode.is_on_paper() {
        let [red, green, blue] = options.paper;
        target = target.cleared_to([red, green, blue, 1.0]);
        scope = AttachmentSchedule::EdgesOnPaper;
    }
    let target = passes.scope_target(frame.commands(), scope, target);
    let pass = passes.pipelines.edges.get();
    let meshes = passes.edges.meshes.as_ref();
    if let (Some(pass), Some(meshes), Some(io)) = (pass, meshes, edge_io(passes)) {
        let hidden = options.mode.shows_hidden().then(|| (EdgeTest::Hidden, options.hidden()));
        let visible = (EdgeTest::Visible, options.visible());
        frame.commands().pass(EDGES, |commands| {
            commands.rendering(target, |commands| {
                for (test, style) in hidden.iter().chain([&visible]) {
                    pass.bind(commands, &io, view, *test, style);
                    ranges.iter().for_each(|range| pass.draw(commands, meshes.leaf_draws(*range)));
                    if let Some(TransparentEdges { instances, states, draws }) = transparent {
                        let section = io.section.map(|section| section.of_states(states));
                        let io = EdgeIo { instances, section, ..io };
                        pass.bind(commands, &io, view, *test, style);
                        pass.draw(commands, draws);
                    }
                }
            });
        });
    }
    passes.edges.ranges = ranges;
    Ok(())
}

/// Waits for the vertices that earlier passes wrote: edges read them by other accesses.
pub(super) fn wait_for_vertices(frame: &Frame<'_>) {
    let written = [Access::ComputeWrite, Access::CopyWrite];
    frame.commands().barrier(MemoryBarrier::between(&written, &[Access::VertexRead]));
}

/// Uploads the draws of the transparent objects around the frustum of a view.
fn transparent_edges(
    passes: &SceneRenderer,
    frame: &mut Frame<'_>,
    frustum: &cull::Frustum,
) -> Result<Option<TransparentEdges>, Error> {
    let SceneRenderer { gpu_scene, edges, .. } = passes;
    let GpuScene { geometry, transparent, .. } = gpu_scene;
    let (Some(transparent), Some(meshes)) = (transparent, &edges.meshes) else {
        return Ok(None);
    };
    let objects: Vec<_> = transparent.in_frustum(frustum).collect();
    if objects.is_empty() {
        return Ok(None);
    }
    let instances = objects.iter().map(|(id, object)| geometry.transparent_instance(*id, object));
    let draws = (0..)
        .zip(&objects)
        .map(|(place, (_, object))| meshes.draw(MeshDrawId(object.mesh.0), place));
    let draws: Vec<_> = draws.collect();
    let instances = frame.uploads().push_iter(instances)?;
    let states = frame.uploads().push(&vec![0_u32; objects.len().div_ceil(2)])?;
    Ok(Some(TransparentEdges { instances, states, draws: frame.uploads().push(&draws)? }))
}

/// Returns the inputs of the edge pass; `None` until they are built.
pub(super) fn edge_io(passes: &SceneRenderer) -> Option<EdgeIo> {
    let segments = passes.edges.meshes.as_ref()?.segments();
    let instances = passes.gpu_scene.geometry.instances.whole();
    let vertices = passes.gpu_scene.geometry.vertices.whole();
    Some(EdgeIo { instances, segments, vertices, section: passes.section.io() })
}
