//! The pipeline cache on disk, so that pipelines of an earlier run are not compiled again.
//!
//! Drivers check little more than the header of their data, and may crash if the rest is damaged
//! (VUID-VkPipelineCacheCreateInfo-initialDataSize-00769). So the file has a header of its own. Its
//! data reaches a driver only if it is complete and was written by the same driver for the same
//! device.

use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use ash::vk;

use crate::core::adapter::Adapter;
use crate::core::error::{Called, Error};
use crate::core::host_callbacks::HostCallbacks;
use crate::core::instance::InstanceShared;
use crate::core::ownership::Ownership;

/// A driver's cache and its file.
pub(crate) struct PipelineCache {
    pub(crate) raw: vk::PipelineCache,
    path: Option<PathBuf>,
    identity: Identity,
    pub(crate) ownership: Ownership,
}

/// The identity of a device and of the exact build of its driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Identity([u8; IDENTITY_BYTES]);

/// The size of three numbers and three UUIDs.
const IDENTITY_BYTES: usize = 3 * 4 + 3 * vk::UUID_SIZE;

/// The size beyond which a file is rejected: caches of drivers take some megabytes.
const MOST_BYTES: u64 = 256 << 20;

/// The first bytes of the file. The last character is its version.
const MAGIC: &[u8; 8] = b"antumbr1";

impl Identity {
    fn read(instance: &InstanceShared, adapter: &Adapter) -> Self {
        let mut ids = vk::PhysicalDeviceIDProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut ids);
        // SAFETY: the adapter is of this instance; these properties are core since 1.1.
        unsafe {
            instance.raw.get_physical_device_properties2(adapter.physical, &mut properties);
        }
        let of_device = properties.properties;
        let numbers = [of_device.vendor_id, of_device.device_id, of_device.driver_version];
        let uuids = [of_device.pipeline_cache_uuid, ids.device_uuid, ids.driver_uuid];
        let mut bytes = [0; IDENTITY_BYTES];
        let all = numbers.iter().flat_map(|number| number.to_le_bytes());
        for (to, from) in bytes.iter_mut().zip(all.chain(uuids.into_iter().flatten())) {
            *to = from;
        }
        Self(bytes)
    }
}

impl PipelineCache {
    /// Wraps the cache of a host, which also saves and destroys it.
    pub(crate) fn of_host(raw: vk::PipelineCache) -> Self {
        let identity = Identity([0; IDENTITY_BYTES]);
        Self { raw, path: None, identity, ownership: Ownership::Host }
    }

    /// Opens the cache with the contents of `path`, if this device and driver wrote them.
    pub(crate) fn open(
        instance: &InstanceShared,
        adapter: &Adapter,
        device: &ash::Device,
        callbacks: &HostCallbacks,
        path: Option<PathBuf>,
    ) -> Result<Self, Error> {
        let identity = Identity::read(instance, adapter);
        let file = path.as_deref().map(|path| read_file(path, MOST_BYTES).unwrap_or_default());
        let file = file.unwrap_or_default();
        let stored = unseal(identity, &file);
        if stored.is_none() && !file.is_empty() {
            tracing::info!("the stored pipeline cache is damaged or of another driver");
        }
        let info = vk::PipelineCacheCreateInfo::default().initial_data(stored.unwrap_or_default());
        // SAFETY: the data, if any, was written by this driver for this device and is undamaged.
        let raw = match unsafe { device.create_pipeline_cache(&info, callbacks.get()) } {
            Err(code) if stored.is_some() => {
                tracing::warn!(
                    "vkCreatePipelineCache refused the stored data ({code:?}), starting afresh"
                );
                let empty = vk::PipelineCacheCreateInfo::default();
                // SAFETY: as above, without data.
                unsafe { device.create_pipeline_cache(&empty, callbacks.get()) }
                    .called("vkCreatePipelineCache")?
            }
            created => created.called("vkCreatePipelineCache")?,
        };
        Ok(Self { raw, path, identity, ownership: Ownership::Ours })
    }

    /// Writes the cache back to its file. A failure costs time, not correctness.
    pub(crate) fn save(&self, device: &ash::Device) {
        let Some(path) = &self.path else { return };
        // SAFETY: the engine created this cache.
        match unsafe { device.get_pipeline_cache_data(self.raw) } {
            Ok(data) if data.is_empty() => {}
            Ok(data) => self.write(path, &data),
            Err(code) => tracing::warn!(
                "the driver kept its pipeline cache (vkGetPipelineCacheData failed with {code:?})"
            ),
        }
    }

    /// Destroys the cache, unless it belongs to a host.
    pub(crate) fn destroy(&self, device: &ash::Device, callbacks: &HostCallbacks) {
        if self.ownership == Ownership::Ours {
            // SAFETY: called once, when the device is closed.
            unsafe { device.destroy_pipeline_cache(self.raw, callbacks.get()) };
        }
    }

    fn write(&self, path: &Path, data: &[u8]) {
        let file = seal(self.identity, data);
        let unchanged = read_file(path, file.len() as u64).is_ok_and(|stored| stored == file);
        if !unchanged && let Err(error) = replace_file(path, &file) {
            tracing::warn!("the pipeline cache {} was not written: {error}", path.display());
        }
    }
}

/// Returns the contents of the file for `data`.
fn seal(identity: Identity, data: &[u8]) -> Vec<u8> {
    let length = data.len() as u64;
    let hash = fnv_1a(data);
    [MAGIC, &identity.0[..], &length.to_le_bytes(), &hash.to_le_bytes(), data].concat()
}

/// Returns the data that [`seal`] wrote to `file`, if it is complete and of the same identity.
fn unseal(identity: Identity, file: &[u8]) -> Option<&[u8]> {
    let rest = file.strip_prefix(MAGIC)?.strip_prefix(&identity.0)?;
    let (length, rest) = rest.split_first_chunk()?;
    let (hash, data) = rest.split_first_chunk()?;
    let is_whole = u64::from_le_bytes(*length) == data.len() as u64
        && u64::from_le_bytes(*hash) == fnv_1a(data);
    is_whole.then_some(data)
}

/// Returns the 64-bit FNV-1a hash, which detects accidents, not attacks.
fn fnv_1a(data: &[u8]) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    data.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

/// Reads a regular file of at most `most_bytes`. Rejects other types before opening: opening a pipe
/// would wait for a writer. Rejects sparse files by their nominal size.
fn read_file(path: &Path, most_bytes: u64) -> std::io::Result<Vec<u8>> {
    let about = std::fs::metadata(path)?;
    let refuse = |reason| Err(std::io::Error::new(ErrorKind::InvalidData, reason));
    if !about.is_file() {
        return refuse("it is not a regular file");
    }
    if about.len() > most_bytes {
        return refuse("it is too large");
    }
    let mut bytes = Vec::with_capacity(about.len() as usize);
    // The file may grow meanwhile.
    std::fs::File::open(path)?.take(most_bytes).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Writes a new file and renames it: another process sees either the old file or the new one,
/// complete, and so does the next run after a power failure.
fn replace_file(path: &Path, data: &[u8]) -> std::io::Result<()> {
    /// The number of files written, for unique names: devices of one process may close at the same
    /// time.
    static WRITTEN: AtomicU64 = AtomicU64::new(0);
    // A pipe or a device file must not be replaced.
    if std::fs::metadata(path).is_ok_and(|about| !about.is_file()) {
        return Err(std::io::Error::new(ErrorKind::InvalidInput, "it is not a regular file"));
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let number = WRITTEN.fetch_add(1, Ordering::Relaxed);
    let beside = path.with_extension(format!("{}.{number}.new", std::process::id()));
    let write = || {
        let mut file = std::fs::File::create(&beside)?;
        file.write_all(data)?;
        // Otherwise the new name may reach the disk before the contents.
        file.sync_all()?;
        std::fs::rename(&beside, path)
    };
    write().inspect_err(|_| {
        // No partial file is left.
        let _gone_or_not_ours = std::fs::remove_file(&beside);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const OURS: Identity = Identity([5; IDENTITY_BYTES]);

    #[test]
    fn hashes_are_those_of_the_algorithm() {
        // From the test vectors of the Internet draft on FNV (draft-eastlake-fnv).
        for (text, hash) in [
            ("", 0xcbf2_9ce4_8422_2325),
            ("a", 0xaf63_dc4c_8601_ec8c),
            ("foobar", 0x8594_4171_f739_67e8),
        ] {
            assert_eq!(fnv_1a(text.as_bytes()), hash, "{text}");
        }
    }

    #[test]
    fn only_the_whole_file_of_the_same_driver_is_taken() {
        let data: Vec<u8> = (0..200).collect();
        let file = seal(OURS, &data);
        assert_eq!(unseal(OURS, &file), Some(&data[..]));
        assert_eq!(unseal(OURS, &seal(OURS, &[])), Some(&[][..]));
        let mut other = OURS;
        other.0[IDENTITY_BYTES - 1] ^= 1;
        assert_eq!(unseal(other, &file), None);
        for length in 0..file.len() {
            assert_eq!(unseal(OURS, &file[..length]), None, "cut to {length}");
            let mut wrong = file.clone();
            wrong[length] ^= 0x10;
            assert_eq!(unseal(OURS, &wrong), None, "byte {length}");
            wrong[length..].fill(0);
            assert_eq!(unseal(OURS, &wrong), None, "zeros from {length} on");
        }
        assert_eq!(unseal(OURS, &[&file[..], &[0]].concat()), None);
    }

    #[test]
    fn only_files_of_bounded_size_are_read() {
        let folder = std::env::temp_dir().join(format!("antumbra-read-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("file");
        let sparse = folder.join("sparse");
        std::fs::write(&file, [7; 100]).unwrap();
        assert_eq!(read_file(&file, 100).unwrap(), [7; 100]);
        assert!(read_file(&file, 99).is_err() && read_file(&folder, 100).is_err());
        std::fs::File::create(&sparse).unwrap().set_len(3 << 30).unwrap();
        assert!(read_file(&sparse, MOST_BYTES).is_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    #[cfg(unix)]
    fn pipes_and_devices_are_neither_read_nor_replaced() {
        let folder = std::env::temp_dir().join(format!("antumbra-pipe-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let pipe = folder.join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        assert!(read_file(&pipe, MOST_BYTES).is_err());
        for other in [&pipe, Path::new("/dev/null")] {
            assert!(replace_file(other, b"first").is_err(), "{}", other.display());
            assert!(!std::fs::metadata(other).unwrap().is_file());
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_file_is_replaced_as_a_whole() {
        let folder = std::env::temp_dir().join(format!("antumbra-replace-{}", std::process::id()));
        let path = folder.join("inner").join("file.bin");
        replace_file(&path, b"first").unwrap();
        replace_file(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        // A folder has the name of the file.
        let blocked = folder.join("inner");
        assert!(replace_file(&blocked, b"third").is_err());
        let left: Vec<_> = std::fs::read_dir(&folder).unwrap().collect();
        assert_eq!(left.len(), 1, "{left:?}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
