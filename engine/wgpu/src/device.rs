//! The device of wgpu, opened with what the engine needs beside, and adopted by the engine.

use std::ffi::CString;
use std::sync::Arc;
use std::time::Duration;

use gpu::ash::{ext, nv};
use gpu::{Features, HostDevice, Purpose, Requirements, Tick, vk};
use wgpu::hal::api::Vulkan;
use wgpu::hal::vulkan;

use crate::error::Error;
use crate::frame_log::FrameLog;

/// The longest wait for the GPU: for the oldest frame in flight, and for all frames at the end.
pub const WAIT_BOUND: Duration = Duration::from_secs(10);

/// A device of wgpu's Vulkan backend with everything that the engine needs.
///
/// [`WgpuDevice::open`] takes the place of [`wgpu::Adapter::request_device`]. Everything made from
/// the device keeps it alive, so the order in which a program drops them does not matter.
pub struct WgpuDevice {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    pub(crate) shared: Arc<DeviceParts>,
}

/// The state that all scenes of a device share.
pub(crate) struct DeviceParts {
    pub(crate) gpu: gpu::Device,
    pub(crate) device: wgpu::Device,
    pub(crate) adapter: wgpu::Adapter,
    pub(crate) log: Arc<FrameLog>,
}

/// The Vulkan features that are added to those that wgpu turns on.
struct AddedFeatures {
    rendering: vk::PhysicalDeviceDynamicRenderingFeatures<'static>,
    synchronization: vk::PhysicalDeviceSynchronization2Features<'static>,
    resets: vk::PhysicalDeviceHostQueryResetFeatures<'static>,
    conditional: Option<vk::PhysicalDeviceConditionalRenderingFeaturesEXT<'static>>,
    representative: Option<vk::PhysicalDeviceRepresentativeFragmentTestFeaturesNV<'static>>,
}

impl WgpuDevice {
    /// Opens the device of an adapter as `descriptor` asks, with the features and extensions that
    /// the engine can use beside. Of wgpu's own features, `INDIRECT_FIRST_INSTANCE` is added, and
    /// `MULTI_DRAW_INDIRECT_COUNT` if the adapter has it.
    ///
    /// Create the instance without [`wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL`], since wgpu
    /// would otherwise copy and check each draw of a list, which is not made for that.
    ///
    /// # Errors
    /// [`Error::NotVulkan`], [`Error::Features`], [`Error::Experimental`], [`Error::Limit`];
    /// [`Error::Gpu`] with the names of capabilities that the adapter lacks; a failed call.
    pub fn open(
        adapter: &wgpu::Adapter,
        descriptor: &wgpu::DeviceDescriptor<'_>,
    ) -> Result<Self, Error> {
        let described = described(adapter, descriptor)?;
        // SAFETY: the handle is only used to open the device and is not destroyed.
        let raw = unsafe { adapter.as_hal::<Vulkan>() }.ok_or(Error::NotVulkan)?;
        let instance = raw.shared_instance();
        let physical = raw.raw_physical_device();
        // SAFETY: the adapter is of this instance, and both are alive.
        let needs =
            unsafe { Requirements::of(instance.raw_instance(), physical, Purpose::Executor) }?;
        needs.check()?;
        let features = features(&raw, described.required_features, needs.features());
        let mut added = AddedFeatures::new(&needs, features);
        let names = needs.extensions();
        // SAFETY: the adapter has the features, which were checked, and everything that is added.
        let opened = unsafe {
            raw.open_with_callback(
                described.required_features,
                &described.required_limits,
                &described.memory_hints,
                Some(Box::new(|args| {
                    let new = names.iter().filter(|name| !args.extensions.contains(name));
                    let new: Vec<_> = new.copied().collect();
                    args.extensions.extend(new);
                    let mut info = std::mem::take(args.create_info)
                        .push_next(&mut added.rendering)
                        .push_next(&mut added.synchronization)
                        .push_next(&mut added.resets);
                    if let Some(conditional) = &mut added.conditional {
                        info = info.push_next(conditional);
                    }
                    if let Some(representative) = &mut added.representative {
                        info = info.push_next(representative);
                    }
                    *args.create_info = info;
                })),
            )
        }?;
        let description = HostDevice {
            api_version: instance.instance_api_version(),
            extensions: enabled(&opened.device),
            features,
            ..HostDevice::new(
                instance.entry().clone(),
                instance.raw_instance().clone(),
                physical,
                opened.device.raw_device().clone(),
                opened.device.queue_family_index(),
            )
        };
        // SAFETY: opened by this adapter, with these features.
        let (device, queue) = unsafe { adapter.create_device_from_hal(opened, &described) }?;
        let owner = Some(Arc::new(device.clone()) as Arc<_>);
        // SAFETY: the handles are of this device and of its instance, which `owner` keeps alive;
        // the extensions and features are those of `opened`.
        let gpu = unsafe { gpu::Device::adopt(HostDevice { owner, ..description }) }?;
        let log = Arc::new(FrameLog::default());
        let adapter = adapter.clone();
        let parts = DeviceParts { gpu, device: device.clone(), adapter, log };
        Ok(Self { device, queue, shared: Arc::new(parts) })
    }

    /// Returns the device as the engine sees it, for its capabilities and the use of memory. Frames
    /// are begun by [`WgpuCulling`](crate::WgpuCulling) only: other frames would have the same
    /// numbers.
    #[must_use]
    pub fn gpu(&self) -> &gpu::Device {
        &self.shared.gpu
    }

    /// Waits until all frames are over, for at most [`WAIT_BOUND`], and frees what was kept for
    /// them. Afterwards the answers of all frames can be [read](crate::WgpuCulling::collect).
    /// Frames that were encoded must be submitted or dropped before.
    ///
    /// # Errors
    /// [`Error::Wait`], [`Error::FramesHeld`], a failed call.
    pub fn finish(&self) -> Result<(), Error> {
        self.shared.finish()
    }
}

impl DeviceParts {
    /// Waits until a frame is over, together with all frames before it.
    pub(crate) fn wait_for(&self, frame: Tick) -> Result<(), Error> {
        if self.log.lock().over() >= frame.0 {
            return Ok(());
        }
        self.device.poll(wgpu::PollType::Poll)?;
        // Bound to a name, so that the log is not locked while wgpu drops parts of frames.
        let submission = self.log.lock().last_submission(frame.0);
        if submission.is_some() {
            self.wait(submission)?;
        }
        if self.log.lock().over() < frame.0 {
            // The program may have submitted the tests by itself.
            self.wait(None)?;
        }
        let frames = self.log.lock();
        if frames.over() < frame.0 { Err(Error::FramesHeld(frames.unfinished())) } else { Ok(()) }
    }

    /// Waits for a submission, or for all of them.
    fn wait(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), Error> {
        let timeout = Some(WAIT_BOUND);
        self.device.poll(wgpu::PollType::Wait { submission_index, timeout })?;
        Ok(())
    }

    fn finish(&self) -> Result<(), Error> {
        self.wait(None)?;
        // Held, so that no other thread begins a frame in between.
        let frames = self.log.lock();
        if frames.unfinished() > 0 {
            return Err(Error::FramesHeld(frames.unfinished()));
        }
        // SAFETY: all frames have numbers of the log, which has seen the end of each.
        unsafe { self.gpu.host_finished() }?;
        Ok(())
    }
}

impl Drop for DeviceParts {
    fn drop(&mut self) {
        // Otherwise the engine leaks what frames may still use, and logs it.
        drop(self.finish());
    }
}

impl AddedFeatures {
    fn new(needs: &Requirements, on: Features) -> Self {
        let names = needs.extensions();
        Self {
            rendering: vk::PhysicalDeviceDynamicRenderingFeatures::default()
                .dynamic_rendering(on.dynamic_rendering),
            synchronization: vk::PhysicalDeviceSynchronization2Features::default()
                .synchronization2(on.synchronization2),
            resets: vk::PhysicalDeviceHostQueryResetFeatures::default()
                .host_query_reset(on.host_query_reset),
            conditional: names.contains(&ext::conditional_rendering::NAME).then(|| {
                vk::PhysicalDeviceConditionalRenderingFeaturesEXT::default()
                    .conditional_rendering(on.conditional_rendering)
            }),
            representative: names.contains(&nv::representative_fragment_test::NAME).then(|| {
                vk::PhysicalDeviceRepresentativeFragmentTestFeaturesNV::default()
                    .representative_fragment_test(on.representative_fragment_test)
            }),
        }
    }
}

/// Returns the descriptor with the features of wgpu that the engine needs, checked as
/// [`wgpu::Adapter::request_device`] checks it.
fn described<'a>(
    adapter: &wgpu::Adapter,
    descriptor: &wgpu::DeviceDescriptor<'a>,
) -> Result<wgpu::DeviceDescriptor<'a>, Error> {
    let counts = wgpu::Features::MULTI_DRAW_INDIRECT_COUNT & adapter.features();
    let required_features =
        descriptor.required_features | wgpu::Features::INDIRECT_FIRST_INSTANCE | counts;
    let lacking = required_features - adapter.features();
    if !lacking.is_empty() {
        return Err(Error::Features(lacking));
    }
    let experimental = required_features & wgpu::Features::all_experimental_mask();
    if !experimental.is_empty() && !descriptor.experimental_features.is_enabled() {
        return Err(Error::Experimental(experimental));
    }
    let mut refused = Ok(());
    descriptor.required_limits.check_limits_with_fail_fn(
        &adapter.limits(),
        true,
        |name, wanted, allowed| refused = Err(Error::Limit { name, wanted, allowed }),
    );
    refused?;
    Ok(wgpu::DeviceDescriptor { required_features, ..descriptor.clone() })
}

/// Returns which of the features that the engine can use are on: those of wgpu's that it turns on
/// itself for `wanted`, and those that are added.
fn features(adapter: &vulkan::Adapter, wanted: wgpu::Features, usable: Features) -> Features {
    let extensions = adapter.required_device_extensions(wanted);
    let core = adapter.physical_device_features(&extensions, wanted).get_core();
    let of_wgpu = Features {
        multi_draw_indirect: core.multi_draw_indirect == vk::TRUE,
        draw_indirect_first_instance: core.draw_indirect_first_instance == vk::TRUE,
        fragment_stores_and_atomics: core.fragment_stores_and_atomics == vk::TRUE,
        draw_indirect_count: wanted.contains(wgpu::Features::MULTI_DRAW_INDIRECT_COUNT),
        multiview: wanted.contains(wgpu::Features::MULTIVIEW),
        ..Features::default()
    };
    let added = Features {
        dynamic_rendering: true,
        synchronization2: true,
        host_query_reset: true,
        conditional_rendering: true,
        representative_fragment_test: true,
        ..Features::default()
    };
    let off = usable.without(of_wgpu.union(added));
    usable.without(off)
}

/// Returns the extensions of the device, and of the instance the one for names of objects.
fn enabled(device: &vulkan::Device) -> Vec<CString> {
    let of_instance = device.shared_instance().extensions();
    let debug = of_instance.iter().filter(|name| **name == ext::debug_utils::NAME);
    device.enabled_device_extensions().iter().chain(debug).map(|name| (*name).into()).collect()
}
