//! Uploads that wait for a frame of a host: a device without a queue cannot copy by itself.
//!
//! Each frame records the copies first, again and again until one that holds them is known to have
//! run.

use std::sync::{Arc, Weak};

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use crate::core::deletion::Retired;
use crate::core::tick::Tick;

/// The proof that the destination of a pending upload is still wanted; it goes with the buffer.
pub(crate) type UploadToken = Arc<()>;

/// The uploads of a device that no frame is known to have done.
#[derive(Default)]
pub(crate) struct PendingUploads {
    uploads: Vec<PendingUpload>,
}

/// A buffer in mapped memory, and the one that it is copied to.
pub(crate) struct PendingUpload {
    pub(crate) from: vk::Buffer,
    pub(crate) allocation: Allocation,
    pub(crate) to: vk::Buffer,
    pub(crate) size_bytes: u64,
    wanted: Weak<()>,
    /// The first frame that did it.
    frame: Option<Tick>,
}

impl PendingUploads {
    /// Adds the copy of the whole of `from` to `to`. The token belongs to the owner of `to`.
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

    /// Calls `copy` for each upload that the frame `current` does, and `retire` with what no later
    /// frame needs: done in a frame up to `confirmed`, or no longer wanted.
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

    /// Takes all of them, when the device goes.
    pub(crate) fn drain(&mut self) -> impl Iterator<Item = Retired> {
        self.uploads.drain(..).map(|upload| Retired::Buffer(upload.from, upload.allocation))
    }
}
