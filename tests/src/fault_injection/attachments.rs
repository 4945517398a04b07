//! The loads and stores of attachments that commands declare, as a tile-based GPU would execute
//! them. Finds loads of undefined contents and stores that nothing reads. Follows the commands of
//! one thread in their order.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::ffi::CStr;
use std::mem::{take, transmute};

use ash::vk;

use super::{Function, barriers, due, injected, real};

const BEGIN: &CStr = c"vkCmdBeginRendering";
const BARRIER: &CStr = c"vkCmdPipelineBarrier2";
const VIEW: &CStr = c"vkCreateImageView";

/// The kind of an attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AttachmentKind {
    /// A colour image.
    Colour,
    /// A depth image, with or without stencil.
    Depth,
    /// The image that samples are averaged into.
    Average,
}

/// The traffic of some commands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AttachmentTraffic {
    /// The number of renderings.
    pub renderings: usize,
    /// Attachments that are read from memory at the beginning of a rendering, by their kind.
    pub loads: BTreeMap<AttachmentKind, usize>,
    /// Attachments that are written to memory at the end of a rendering, by their kind.
    pub stores: BTreeMap<AttachmentKind, usize>,
    /// Contents in memory that have not been read since they were written.
    pub unread: Vec<AttachmentKind>,
    /// The faults: reads of undefined contents, and stores over contents that were never read.
    pub faults: Vec<String>,
}

impl AttachmentTraffic {
    /// Returns the loads of a kind.
    pub fn loads(&self, kind: AttachmentKind) -> usize {
        self.loads.get(&kind).copied().unwrap_or(0)
    }

    /// Returns the stores of a kind.
    pub fn stores(&self, kind: AttachmentKind) -> usize {
        self.stores.get(&kind).copied().unwrap_or(0)
    }
}

/// An image, by the first layer of a view of it.
type Layer = (vk::Image, u32);

/// The contents of a layer in memory, as far as they are known.
#[derive(Clone, Copy)]
struct Contents {
    are_defined: bool,
    unread: Option<AttachmentKind>,
}

#[derive(Default)]
struct Recorder {
    layers: HashMap<vk::ImageView, Layer>,
    contents: HashMap<Layer, Contents>,
    traffic: AttachmentTraffic,
}

thread_local! {
    static RECORDER: RefCell<Recorder> = RefCell::default();
}

/// Returns the traffic of the commands that this thread recorded since the last call. Contents that
/// are still unread count as unread, and afterwards as read.
pub fn attachment_traffic() -> AttachmentTraffic {
    RECORDER.with_borrow_mut(|recorder| {
        let mut traffic = take(&mut recorder.traffic);
        traffic.unread =
            recorder.contents.values_mut().filter_map(|content| content.unread.take()).collect();
        traffic.unread.sort_unstable();
        traffic
    })
}

impl Recorder {
    fn contents(&mut self, image: Layer) -> &mut Contents {
        self.contents.entry(image).or_insert(Contents { are_defined: true, unread: None })
    }

    /// Notes that contents are read.
    fn read(&mut self, image: Layer, by: &str) {
        let contents = self.contents(image);
        contents.unread = None;
        if !contents.are_defined {
            self.traffic.faults.push(format!("{by} reads undefined contents"));
        }
    }

    /// Notes that contents are lost.
    fn lose(&mut self, image: Layer, by: &str) {
        if let Some(kind) = self.contents(image).unread.take() {
            self.traffic.faults.push(format!("{kind:?} was written to memory, and then {by}"));
        }
    }

    fn written(&mut self, image: Layer, kind: AttachmentKind) {
        *self.traffic.stores.entry(kind).or_default() += 1;
        *self.contents(image) = Contents { are_defined: true, unread: Some(kind) };
    }

    fn attach(&mut self, attachment: &vk::RenderingAttachmentInfo<'_>, kind: AttachmentKind) {
        let Some(image) = self.layers.get(&attachment.image_view).copied() else { return };
        let number = self.traffic.renderings;
        match attachment.load_op {
            vk::AttachmentLoadOp::LOAD => {
                *self.traffic.loads.entry(kind).or_default() += 1;
                self.read(image, &format!("rendering {number} ({kind:?})"));
            }
            _ => self.lose(image, &format!("rendering {number} does not load it")),
        }
        match attachment.store_op {
            vk::AttachmentStoreOp::STORE => self.written(image, kind),
            vk::AttachmentStoreOp::NONE if attachment.load_op == vk::AttachmentLoadOp::LOAD => {}
            _ => self.contents(image).are_defined = false,
        }
        if attachment.resolve_mode != vk::ResolveModeFlags::NONE
            && let Some(image) = self.layers.get(&attachment.resolve_image_view).copied()
        {
            self.written(image, AttachmentKind::Average);
        }
    }

    fn change(&mut self, barrier: &vk::ImageMemoryBarrier2<'_>) {
        let layers: Vec<Layer> =
            self.contents.keys().filter(|(image, _)| *image == barrier.image).copied().collect();
        for layer in layers {
            if barrier.old_layout == vk::ImageLayout::UNDEFINED {
                self.lose(layer, "its layout is undefined");
                self.contents(layer).are_defined = false;
            }
            match barrier.new_layout {
                vk::ImageLayout::TRANSFER_DST_OPTIMAL => self.contents(layer).are_defined = true,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL
                | vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL => {
                    self.read(layer, "a copy or a shader");
                }
                _ => {}
            }
        }
    }
}

/// Calls `note` with the recorder if the machine records. Other machines allocate nothing.
fn record(note: impl FnOnce(&mut Recorder)) {
    if injected(|injected| injected.records_attachments) {
        RECORDER.with_borrow_mut(note);
    }
}

pub(super) fn calls_that_attach() -> Vec<(&'static CStr, Function)> {
    // SAFETY: all are function pointers, and the caller knows the type by the name.
    unsafe {
        vec![
            (BEGIN, transmute::<vk::PFN_vkCmdBeginRendering, Function>(begin_rendering)),
            (BARRIER, transmute::<vk::PFN_vkCmdPipelineBarrier2, Function>(pipeline_barrier)),
            (VIEW, transmute::<vk::PFN_vkCreateImageView, Function>(create_view)),
        ]
    }
}

unsafe extern "system" fn begin_rendering(
    commands: vk::CommandBuffer,
    info: *const vk::RenderingInfo<'_>,
) {
    // SAFETY: here and below: the type belongs to the function, and the caller passes valid
    // arguments for it, so all pointers are valid.
    unsafe {
        let subpass = &*info;
        let colours = match subpass.color_attachment_count {
            0 => &[],
            count => std::slice::from_raw_parts(subpass.p_color_attachments, count as usize),
        };
        record(|recorder| {
            for colour in colours {
                recorder.attach(colour, AttachmentKind::Colour);
            }
            if let Some(depth) = subpass.p_depth_attachment.as_ref() {
                recorder.attach(depth, AttachmentKind::Depth);
            }
            recorder.traffic.renderings += 1;
        });
        real::<vk::PFN_vkCmdBeginRendering>(BEGIN)(commands, info);
    }
}

unsafe extern "system" fn pipeline_barrier(
    commands: vk::CommandBuffer,
    info: *const vk::DependencyInfo<'_>,
) {
    // SAFETY: as above.
    unsafe {
        let rendering = &*info;
        let images = match rendering.image_memory_barrier_count {
            0 => &[],
            count => std::slice::from_raw_parts(rendering.p_image_memory_barriers, count as usize),
        };
        record(|recorder| images.iter().for_each(|image| recorder.change(image)));
        barriers::passed(rendering);
        real::<vk::PFN_vkCmdPipelineBarrier2>(BARRIER)(commands, info);
    }
}

unsafe extern "system" fn create_view(
    device: vk::Device,
    info: *const vk::ImageViewCreateInfo<'_>,
    callbacks: *const vk::AllocationCallbacks<'_>,
    made: *mut vk::ImageView,
) -> vk::Result {
    if let Some(code) = due(VIEW) {
        return code;
    }
    // SAFETY: as above.
    unsafe {
        let code = real::<vk::PFN_vkCreateImageView>(VIEW)(device, info, callbacks, made);
        if code == vk::Result::SUCCESS {
            record(|recorder| {
                // Handles may be reused.
                let image = (*info).image;
                let first = (*info).subresource_range.base_array_layer;
                recorder.contents.remove(&(image, first));
                recorder.layers.insert(*made, (image, first));
            });
        }
        code
    }
}
