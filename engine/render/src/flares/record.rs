//! The recording of a view's flares: counts of the finished depth, then sprites over the image.

use cull::CullView;
use gpu::{Access, BufferSlice, Counting, Frame, MemoryBarrier, QueryIndex, QueryRing};
use occlusion::{OcclusionState, PlanExecutor};
use scene::LensFlare;

use crate::attachment_schedule::AttachmentSchedule;
use crate::error::Error;
use crate::flares::block::FlareBlock;
use crate::flares::counts::FlareCounts;
use crate::flares::sprites::sprites;
use crate::frame_passes::FramePasses;
use crate::passes::FlareBlockIo;

/// Counts the flares of a view, once everything of its frame is drawn, and draws those that earlier
/// frames have counted.
///
/// # Errors
/// No memory, or a failed call.
pub(crate) fn record_flares(
    passes: &mut FramePasses,
    frame: &mut Frame<'_>,
    executor: &PlanExecutor,
    flares: &[LensFlare],
    counts: &mut FlareCounts,
    visibility: &OcclusionState,
    view: &CullView,
) -> Result<(), Error> {
    counts.is_asking = false;
    let now = visibility.plan().frame;
    let slots = visibility.frames_in_flight();
    let has_transmittance = passes.pipelines.transmittance.is_some() && has_transparent(passes);
    let samples_per_pixel = passes.target.attachments().samples.as_raw();
    counts.lay_out(flares, view, now, has_transmittance, samples_per_pixel);
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
        queries.begin(frame, &counts.asked.tags)?;
        counts.is_asking = true;
        let blocks = frame.uploads().push(&counts.asked.rows)?;
        let transmittance = if has_transmittance {
            Some(record_transmittance(passes, frame, executor, counts, blocks, view)?)
        } else {
            None
        };
        record_counts(passes, frame, counts, FlareBlockIo { blocks, transmittance }, view);
    }
    record_sprites(passes, frame, counts, flares, view)
}

/// Returns true if there are transparent objects in the view being recorded.
fn has_transparent(passes: &FramePasses) -> bool {
    passes.transparent.as_ref().is_some_and(|transparent| !transparent.list().is_empty())
}

/// Adds up how much the transparent objects in front of the lights take at each pixel of the
/// blocks.
fn record_transmittance(
    passes: &mut FramePasses,
    frame: &mut Frame<'_>,
    executor: &PlanExecutor,
    counts: &FlareCounts,
    blocks: BufferSlice,
    view: &CullView,
) -> Result<BufferSlice, Error> {
    let cells = std::iter::repeat_n(0_u32, counts.asked.cells as usize);
    let transmittance = frame.uploads().push_iter(cells)?;
    let [low, high] = counts.asked.covering;
    let origin = [0, 1].map(|axis| view.origin[axis] + low[axis]);
    let size = [0, 1].map(|axis| high[axis].saturating_sub(low[axis]));
    passes.target.prepare_tests(frame.commands());
    let target = passes.target_of(view, None);
    let target =
        passes.scope_target(frame.commands(), AttachmentSchedule::FlareTransmittance, target);
    let passes = &*passes;
    frame.commands().pass("transmittance flares", |commands| {
        commands.rendering(target, |commands| {
            let (Some(transparent), Some(pass), Some(surfaces)) =
                (&passes.transparent, &passes.pipelines.transmittance, passes.surface_io())
            else {
                return;
            };
            commands.clip(origin, size);
            transparent.draw_bound(executor, commands, surfaces, &|commands, surfaces| {
                pass.bind_transmittance(
                    commands,
                    surfaces,
                    blocks,
                    transmittance,
                    view,
                    &passes.light,
                );
            });
        });
        let to_counts = MemoryBarrier::between(&[Access::FragmentWrite], &[Access::FragmentRead]);
        commands.barrier(to_counts);
    });
    Ok(transmittance)
}

/// Counts the samples of the blocks.
fn record_counts(
    passes: &mut FramePasses,
    frame: &mut Frame<'_>,
    counts: &FlareCounts,
    io: FlareBlockIo,
    view: &CullView,
) {
    let (Some(queries), asked) = (&counts.queries, &counts.asked) else { return };
    passes.target.prepare_tests(frame.commands());
    let target = passes.target_of(view, None);
    let target = passes.scope_target(frame.commands(), AttachmentSchedule::FlareCounts, target);
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
    passes: &mut FramePasses,
    frame: &mut Frame<'_>,
    counts: &mut FlareCounts,
    flares: &[LensFlare],
    view: &CullView,
) -> Result<(), Error> {
    let mut sprites_drawn = std::mem::take(&mut counts.sprites);
    sprites_drawn.clear();
    let drawn = flares.iter().zip(counts.states()).filter_map(|(flare, state)| {
        let is_bright = state.brightness > 0.0;
        let block = is_bright.then(|| FlareBlock::of(flare, view)).flatten()?;
        Some(sprites(flare, block.middle, state.brightness, view.size))
    });
    sprites_drawn.extend(drawn.flatten());
    let count = sprites_drawn.len() as u32;
    let rows = frame.uploads().push(&sprites_drawn);
    counts.sprites = sprites_drawn;
    let rows = rows?;
    if count == 0 {
        return Ok(());
    }
    if passes.pipelines.flares.get().is_none() {
        return Ok(());
    }
    passes.target.prepare(frame.commands());
    let target = passes.target_of(view, None);
    let target = passes.scope_target(frame.commands(), AttachmentSchedule::Flares, target);
    let Some(pass) = passes.pipelines.flares.get() else { return Ok(()) };
    frame.commands().pass("lens flares", |commands| {
        commands.rendering(target, |commands| {
            pass.draw_sprites(commands, rows, count);
        });
    });
    Ok(())
}
