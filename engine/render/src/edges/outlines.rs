//! Outlines of objects by a stencil. The pixels of the objects are marked in the stencil, and their
//! edges are drawn where there is no mark, so that only the outer halves of silhouettes remain.

use crate::view_pass::ViewPass;
use cull::{LeafIndex, ObjectId};
use gpu::{BufferSlice, Frame, IndirectDraw, StencilTarget};
use occlusion::{CulledScene, MeshDrawId};

use super::record::{edge_io, wait_for_vertices};
use crate::attachment_schedule::AttachmentSchedule;
use crate::error::Error;
use crate::passes::EdgeStyle;
use crate::scene_renderer::SceneRenderer;

/// The pass that outlines objects.
const OUTLINES: &str = "outline objects";

/// The draws of one outline.
struct OutlineDraws {
    style: EdgeStyle,
    triangles: BufferSlice,
    edges: BufferSlice,
}

/// Outlines objects in a view, if there are outlines.
pub(crate) fn record_outlines(view_pass: &mut ViewPass<'_, '_>) -> Result<(), Error> {
    let passes = &mut *view_pass.passes;
    if passes.edges.outlines.is_empty() {
        return Ok(());
    }
    let mut outlines = Vec::new();
    for number in 0..passes.edges.outlines.len() {
        outlines.extend(upload(passes, view_pass.frame, view_pass.scene, number)?);
    }
    if passes.edges.stencil.is_none() {
        let stencil = StencilTarget::beside(&passes.device, &passes.target, "outlines")?;
        passes.edges.stencil = Some(stencil);
    }
    wait_for_vertices(view_pass.frame);
    let target = view_pass.prepare(AttachmentSchedule::StencilOutlines);
    let ViewPass { passes, frame, scene, view } = view_pass;
    let pass = passes.pipelines.outlines.get();
    let stencil = passes.edges.stencil.as_ref();
    let (Some(pass), Some(io), Some(stencil)) = (pass, edge_io(passes), stencil) else {
        return Ok(());
    };
    let predicates = scene.leaves().predicates();
    frame.commands().pass(OUTLINES, |commands| {
        stencil.forget(commands);
        commands.rendering(stencil.with_colours(target), |commands| {
            for OutlineDraws { style, triangles, edges } in &outlines {
                commands.clear_stencil(view.origin, view.size);
                pass.mark.bind(commands, &passes.opaque_io(), view, &passes.gpu_scene.light);
                predicates.draw_after_counted(commands, *triangles);
                pass.draw(commands, &io, view, style, *edges);
            }
        });
    });
    Ok(())
}

/// Uploads the draws of an outline; `None` if it has no object in the scene.
fn upload(
    passes: &SceneRenderer,
    frame: &mut Frame<'_>,
    scene: &CulledScene,
    number: usize,
) -> Result<Option<OutlineDraws>, Error> {
    let (Some(outline), Some(meshes)) = (passes.edges.outlines.get(number), &passes.edges.meshes)
    else {
        return Ok(None);
    };
    let leaf_of = |object: &ObjectId| Some((*object, scene.hierarchy().leaf_of(*object)?));
    let objects: Vec<(ObjectId, LeafIndex)> = outline.objects.iter().filter_map(leaf_of).collect();
    if objects.is_empty() {
        return Ok(None);
    }
    let triangles: Vec<IndirectDraw> =
        objects.iter().map(|(_, leaf)| scene.leaves().draw(*leaf)).collect();
    let draw_of = |object: ObjectId| -> MeshDrawId { passes.gpu_scene.geometry.draw_of(object) };
    let edges: Vec<_> =
        objects.iter().map(|(object, leaf)| meshes.draw(draw_of(*object), leaf.0)).collect();
    Ok(Some(OutlineDraws {
        style: outline.style(),
        triangles: frame.uploads().push(&triangles)?,
        edges: frame.uploads().push(&edges)?,
    }))
}
