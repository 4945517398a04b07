//! The recording of a view's flares: counts of the finished depth, then sprites over the image.

use crate::view_pass::ViewPass;
use gpu::{Access, BufferSlice, Counting, MemoryBarrier, QueryIndex, QueryRing};
use occlusion::OcclusionState;
use scene::LensFlare;

use crate::attachment_schedule::AttachmentSchedule;
use crate::error::Error;
use crate::flares::block::FlareBlock;
use crate::flares::counts::FlareCounts;
use crate::flares::sprites::sprites;
use crate::passes::FlareBlockIo;
use crate::scene_renderer::SceneRenderer;

/// Counts the flares of a view, after everything of its frame is drawn, and draws the flares by the
/// counts of earlier frames.
pub(crate) fn record_flares(
    view_pass: &mut ViewPass<'_, '_>,
    flares: &[LensFlare],
    counts: &mut FlareCounts,
    visibility: &OcclusionState,
) -> Result<(), Error> {
    counts.is_asking = false;
    let passes = &*view_pass.passes;
    let now = visibility.plan().frame;
    let slots = visibility.frames_in_flight();
    let has_transmittance = passes.pipelines.transmittance.is_some() && has_transparent(passes);
    let samples_per_pixel = passes.target.attachments().samples.as_raw();
    counts.lay_out(flares, view_pass.view, now, has_transmittance, samples_per_pixel);
    counts.advance(now, slots);
    if flares.is_empty() {
        return Ok(());
    }
    if !counts.asked.tags.is_empty() {
        let queries = match counts.queries.take() {
            Some(queries) => queries,
            None => QueryRing::new(visibility.device(), slots, "flare counts")?,
        };
        let queries = counts.queries.insert(queries);
        queries.set_counting(Counting::Samples);
        queries.begin(view_pass.frame, &counts.asked.tags)?;
        counts.is_asking = true;
        let blocks = view_pass.frame.uploads().push(&counts.asked.rows)?;
        let transmittance = if has_transmittance {
            Some(record_transmittance(view_pass, counts, blocks)?)
        } else {
            None
        };
        record_counts(view_pass, counts, FlareBlockIo { blocks, transmittance });
    }
    record_sprites(view_pass, counts, flares)
}

/// Returns true if there are transparent objects in the view being recorded.
fn has_transparent(passes: &SceneRenderer) -> bool {
    passes.gpu_scene.transparent.as_ref().is_some_and(|transparent| !transparent.list().is_empty())
}

/// Adds up, at each pixel of the blocks, the light that transparent objects in front of the lights
/// take.
fn record_transmittance(
    view_pass: &mut ViewPass<'_, '_>,
    counts: &FlareCounts,
    blocks: BufferSlice,
) -> Result<BufferSlice, Error> {
    let cells = std::iter::repeat_n(0_u32, counts.asked.cells as usize);
    let transmittance = view_pass.frame.uploads().push_iter(cells)?;
    let [low, high] = counts.asked.covering;
    let origin = [0, 1].map(|axis| view_pass.view.origin[axis] + low[axis]);
    let size = [0, 1].map(|axis| high[axis].saturating_sub(low[axis]));
    let target = view_pass.prepare_tests(AttachmentSchedule::FlareTransmittance);
    let ViewPass { passes, frame, scene, view } = view_pass;
    frame.commands().pass("transmittance flares", |commands| {
        commands.rendering(target, |commands| {
            let (Some(transparent), Some(pass), Some(surfaces)) = (
                &passes.gpu_scene.transparent,
                &passes.pipelines.transmittance,
                passes.surface_io(),
            ) else {
                return;
            };
            commands.clip(origin, size);
            transparent.draw_bound(scene, commands, surfaces, &|commands, surfaces| {
                pass.bind_transmittance(
                    commands,
                    surfaces,
                    blocks,
                    transmittance,
                    view,
                    &passes.gpu_scene.light,
                );
            });
        });
        let to_counts = MemoryBarrier::between(&[Access::FragmentWrite], &[Access::FragmentRead]);
        commands.barrier(to_counts);
    });
    Ok(transmittance)
}

/// Counts the samples of the blocks.
fn record_counts(view_pass: &mut ViewPass<'_, '_>, counts: &FlareCounts, io: FlareBlockIo) {
    let (Some(queries), asked) = (&counts.queries, &counts.asked) else { return };
    let target = view_pass.prepare_tests(AttachmentSchedule::FlareCounts);
    let ViewPass { passes, frame, view, .. } = view_pass;
    let Some(pass) = passes.pipelines.flares.get() else { return };
    frame.commands().pass("count flares", |commands| {
        commands.rendering(target, |commands| {
            for (number, kind) in (0..).zip(io.kinds()) {
                pass.bind_blocks(commands, *kind, &io, view);
                for (block, QueryIndex(first)) in (0..).zip(&asked.queries) {
                    let query = QueryIndex(first + number);
                    queries
                        .scope(commands, query, |commands| pass.draw_block(commands, *kind, block));
                }
            }
        });
        queries.resolve(commands, 0..asked.tags.len() as u32);
        queries.read_back(commands);
    });
}

/// Adds the glow and the ghosts of the flares to the image.
fn record_sprites(
    view_pass: &mut ViewPass<'_, '_>,
    counts: &mut FlareCounts,
    flares: &[LensFlare],
) -> Result<(), Error> {
    let view = view_pass.view;
    let mut sprites_drawn = std::mem::take(&mut counts.sprites);
    sprites_drawn.clear();
    let drawn = flares.iter().zip(counts.states()).filter_map(|(flare, state)| {
        let is_bright = state.brightness > 0.0;
        let block = is_bright.then(|| FlareBlock::of(flare, view)).flatten()?;
        Some(sprites(flare, block.middle, state.brightness, view.size))
    });
    sprites_drawn.extend(drawn.flatten());
    let count = sprites_drawn.len() as u32;
    let rows = view_pass.frame.uploads().push(&sprites_drawn);
    counts.sprites = sprites_drawn;
    let rows = rows?;
    if count == 0 {
        return Ok(());
    }
    if view_pass.passes.pipelines.flares.get().is_none() {
        return Ok(());
    }
    let target = view_pass.prepare(AttachmentSchedule::Flares);
    let ViewPass { passes, frame, .. } = view_pass;
    let Some(pass) = passes.pipelines.flares.get() else { return Ok(()) };
    frame.commands().pass("lens flares", |commands| {
        commands.rendering(target, |commands| {
            pass.draw_sprites(commands, rows, count);
        });
    });
    Ok(())
}
