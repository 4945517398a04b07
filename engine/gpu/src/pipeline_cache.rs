//! The pipeline cache on disk: what the driver compiled last time need not be compiled again.

use std::path::{Path, PathBuf};

use ash::vk;

use crate::error::{Called, Error};

/// A driver's cache and the file it lives in.
pub(crate) struct PipelineCache {
    pub(crate) raw: vk::PipelineCache,
    path: Option<PathBuf>,
}

impl PipelineCache {
    /// Opens the cache with what `path` holds. The driver itself checks the header and ignores
    /// what another device or driver wrote (Vulkan specification, "Pipeline Cache Header").
    pub(crate) fn open(device: &ash::Device, path: Option<PathBuf>) -> Result<Self, Error> {
        let stored = path.as_deref().and_then(|path| std::fs::read(path).ok()).unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&stored);
        // SAFETY: the data is only a hint, the driver validates it.
        let raw = match unsafe { device.create_pipeline_cache(&info, None) } {
            Ok(raw) => raw,
            Err(code) => {
                tracing::warn!("the stored pipeline cache was refused ({code:?}), starting afresh");
                let empty = vk::PipelineCacheCreateInfo::default();
                // SAFETY: as above, without data.
                unsafe { device.create_pipeline_cache(&empty, None) }
                    .called("vkCreatePipelineCache")?
            }
        };
        Ok(Self { raw, path })
    }

    /// Writes the cache back and destroys it. A disk that refuses costs time, not correctness.
    pub(crate) fn save_and_destroy(&self, device: &ash::Device) {
        if let Some(path) = &self.path {
            // SAFETY: the cache is ours.
            let data = unsafe { device.get_pipeline_cache_data(self.raw) }.unwrap_or_default();
            let unchanged = std::fs::read(path).is_ok_and(|stored| stored == data);
            if !unchanged && let Err(error) = replace_file(path, &data) {
                tracing::warn!("the pipeline cache {} was not written: {error}", path.display());
            }
        }
        // SAFETY: called once, when the device goes.
        unsafe { device.destroy_pipeline_cache(self.raw, None) };
    }
}

/// Writes beside the file and renames: another process sees the old file or the new one, whole.
fn replace_file(path: &Path, data: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let written = path.with_extension(format!("{}.new", std::process::id()));
    std::fs::write(&written, data)?;
    std::fs::rename(&written, path).inspect_err(|_| {
        // Nothing half-written stays behind.
        let _gone_or_not_ours = std::fs::remove_file(&written);
    })
}
