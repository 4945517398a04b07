//! Uploads that wait for a frame of a host: a device without a queue cannot submit copies.
//!
//! Each frame first records the copies, until a frame with them is known to have run.

use std::sync::{Arc, Weak};

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use crate::core::deletion::Retired;
use crate::core::tick::Tick;

/// The token that shows that the destination of a pending upload still exists; the buffer holds it.
pub(crate) type UploadToken = Arc<()>;

/// The uploads of a device that are not known to have been executed.
#[derive(Default)]
pub(crate) struct PendingUploads {
    uploads: Vec<PendingUpload>,
}

/// A buffer in mapped memory, and the buffer that it is copied to.
pub(crate) struct PendingUpload {
    pub(crate) from: vk::Buffer,
    pub(crate) allocation: Allocation,
    pub(crate) to: vk::Buffer,
    pub(crate) size_bytes: u64,
    wanted: Weak<()>,
    /// The first frame that recorded the copy.
    frame: Option<Tick>,
}

impl PendingUploads {
    /// Adds a copy of the whole buffer `from` to `to`. The owner of `to` must keep the token.
    pub(crate) fn push(
        &mut self,
        from: vk::Buffer,
        allocation: Allocation,
        to: vk::Buffer,
        size_bytes: u64,
    ) -> UploadToken {
        let token = UploadToken::default();
        let wanted = Arc::downgrade(&token);
        self.uploads.push(PendingUpload { from, allocation, to, size_bytes, wanted, frame: None });
        token
    }

    /// Calls `copy` for each upload that the frame `current` must record. Calls `retire` for each
    /// upload that was executed in a frame up to `confirmed` or is no longer wanted.
    pub(crate) fn record(
        &mut self,
        current: Tick,
        confirmed: Tick,
        mut copy: impl FnMut(&PendingUpload),
        mut retire: impl FnMut(Retired),
    ) {
        let is_over = |upload: &mut PendingUpload| {
            upload.wanted.strong_count() == 0
                || upload.frame.is_some_and(|frame| frame <= confirmed)
        };
        for upload in self.uploads.extract_if(.., is_over) {
            retire(Retired::Buffer(upload.from, upload.allocation));
        }
        for upload in &mut self.uploads {
            upload.frame.get_or_insert(current);
            copy(upload);
        }
    }

    /// Removes all uploads when the device is closed.
    pub(crate) fn drain(&mut self) -> impl Iterator<Item = Retired> {
        self.uploads.drain(..).map(|upload| Retired::Buffer(upload.from, upload.allocation))
    }
}
