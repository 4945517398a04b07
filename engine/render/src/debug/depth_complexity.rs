//! The depth complexity of a view: the number of surfaces that its draws have at each pixel,
//! including hidden ones. It is low where much was culled.
//!
//! ```text
//! clear     a value per pixel
//! count     the draws once more, without a test of the depth: each fragment adds 1
//! show      the values as colours, over the image
//! ```

use crate::view_pass::ViewPass;
use cull::CullView;
use gpu::{Access, Buffer, BufferSlice, Device, MemoryBarrier, MemoryKind, vk};

use crate::attachment_schedule::AttachmentSchedule;
use crate::error::Error;
use crate::passes::LayersIo;

/// The label of the pass.
pub(super) const DEPTH_COMPLEXITY: &str = "depth complexity";

/// The counts of a view, a value per pixel. The memory is kept from frame to frame while they are
/// shown.
#[derive(Default)]
pub(crate) struct LayerCounts(Option<Buffer>);

impl LayerCounts {
    /// Returns the memory of the values, which is created when it is first needed.
    fn of(&mut self, device: &Device, view: &CullView) -> Result<BufferSlice, Error> {
        let bytes = view.size.map(u64::from).iter().product::<u64>() * size_of::<u32>() as u64;
        let buffer = match self.0.take().filter(|buffer| buffer.size_bytes() >= bytes) {
            Some(buffer) => buffer,
            None => {
                let usage =
                    vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
                Buffer::new(device, "layers", bytes, usage, MemoryKind::Device)?
            }
        };
        Ok(self.0.insert(buffer).whole().part(0, bytes))
    }
}

/// Draws the depth complexity of `draws` over the image of a view.
pub(super) fn record_depth_complexity(
    view_pass: &mut ViewPass<'_, '_>,
    draws: Option<BufferSlice>,
) -> Result<(), Error> {
    let ViewPass { passes, frame, scene, view } = view_pass;
    let layers = passes.layer_counts.of(scene.device(), view)?;
    let commands = frame.commands();
    let between = MemoryBarrier::between;
    passes.target.prepare_tests(commands);
    let counting = passes.target_of(view, None);
    let counting = passes.scope_target(commands, AttachmentSchedule::Layers, counting);
    commands.pass(DEPTH_COMPLEXITY, |commands| {
        // The previous frame may still show its values.
        commands.barrier(between(&[Access::FragmentRead], &[Access::CopyWrite]));
        commands.fill(layers, 0);
        commands.barrier(between(&[Access::CopyWrite], &[Access::FragmentWrite]));
        if let Some(draws) = draws {
            commands.rendering(counting, |commands| {
                let Some(pass) = passes.pipelines.layers.get() else { return };
                pass.bind(commands, &LayersIo { opaque: passes.opaque_io(), layers }, view);
                scene.leaves().predicates().draw_after_counted(commands, draws);
            });
        }
        let counted = [Access::CopyWrite, Access::FragmentWrite];
        commands.barrier(between(&counted, &[Access::FragmentRead]));
        passes.target.prepare(commands);
        let showing = passes.target_of(view, None).cleared_to([0.0; 4]);
        let showing = passes.scope_target(commands, AttachmentSchedule::DepthComplexity, showing);
        commands.rendering(showing, |commands| {
            if let Some(pass) = passes.pipelines.layers.get() {
                pass.show(commands, layers, view);
            }
        });
    });
    Ok(())
}
