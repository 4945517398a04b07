//! A host: a program with its own instance and device under the validation layers. Plain Vulkan
//! creates them with exactly what the engine's requirements list.

use std::ffi::{CStr, CString, c_void};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ash::{ext, vk};
use gpu::{
    Device, DeviceOptions, Features, FrameNumbers, FrameRing, HostDevice, HostQueue, HostQueueLock,
    Purpose, Requirements, Tick, Timeline,
};

use crate::{Driver, take_turn};

/// A host's instance and device. Destroyed by [`Host::finish`].
pub struct Host {
    /// The loader's entry.
    pub entry: ash::Entry,
    /// The host's own instance.
    pub instance: ash::Instance,
    /// The physical device.
    pub physical: vk::PhysicalDevice,
    /// The host's own device.
    pub device: ash::Device,
    /// The only queue of the device.
    pub queue: vk::Queue,
    /// The requirements that the device was made from.
    pub needs: Requirements,
    debug: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    // Boxed: the messenger holds its address.
    messages: Box<Messages>,
}

type Messages = Mutex<Vec<String>>;

/// The bound of every wait.
const BOUND: Duration = Duration::from_secs(60);

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

impl Host {
    /// Creates a device of `driver` with exactly the features that `purpose` requires and can use.
    pub fn new(driver: Driver, purpose: Purpose) -> Self {
        Self::without(driver, purpose, &[], Features::default())
    }

    /// Creates a device without some of the extensions and features that it should have.
    pub fn without(
        driver: Driver,
        purpose: Purpose,
        extensions: &[&CStr],
        features: Features,
    ) -> Self {
        let entry = gpu::load_entry().unwrap_or_else(|error| panic!("{error}"));
        Self::through(entry, driver, purpose, extensions, features)
    }

    /// Creates a device as [`Self::without`] does, through a loader of the test.
    pub fn through(
        entry: ash::Entry,
        driver: Driver,
        purpose: Purpose,
        extensions: &[&CStr],
        features: Features,
    ) -> Self {
        take_turn();
        let messages = Box::new(Messages::default());
        let instance = create_instance(&entry, &messages);
        let debug = ext::debug_utils::Instance::new(&entry, &instance);
        let info = messenger_info(&messages);
        // SAFETY: the messages are boxed and outlive the messenger.
        let messenger = unsafe { debug.create_debug_utils_messenger(&info, None) }.unwrap();
        // SAFETY: a valid instance.
        let devices = unsafe { instance.enumerate_physical_devices() }.unwrap();
        let is_wanted = |physical: &vk::PhysicalDevice| {
            // SAFETY: a physical device of this instance.
            let properties = unsafe { instance.get_physical_device_properties(*physical) };
            let name = properties.device_name_as_c_str().unwrap().to_string_lossy();
            name.contains(driver.device_name())
        };
        let physical = devices.into_iter().find(is_wanted).unwrap_or_else(|| {
            panic!("Run `ci/setup --tests` and `. ci/env` first: these tests need {driver:?}.")
        });
        // SAFETY: a physical device of this instance.
        let needs = unsafe { Requirements::of(&instance, physical, purpose) }.unwrap();
        needs.check().unwrap();
        let kept = needs.extensions().into_iter().filter(|name| !extensions.contains(name));
        let device = create_device(
            &instance,
            physical,
            needs.queue_family.unwrap(),
            &kept.collect::<Vec<_>>(),
            needs.features().without(features),
        );
        // SAFETY: the device was created with this family and index.
        let queue = unsafe { device.get_device_queue(needs.queue_family.unwrap(), 0) };
        Self { entry, instance, physical, device, queue, needs, debug, messenger, messages }
    }

    /// Returns the description of the device for its adoption without a queue.
    pub fn describe(&self) -> HostDevice {
        let extensions = self.needs.extensions();
        let extensions = extensions.into_iter().chain([ext::debug_utils::NAME]);
        HostDevice {
            entry: self.entry.clone(),
            instance: self.instance.clone(),
            physical_device: self.physical,
            device: self.device.clone(),
            queue_family: self.needs.queue_family.unwrap(),
            api_version: vk::API_VERSION_1_3,
            extensions: extensions.map(CString::from).collect(),
            features: self.needs.features(),
            allocation_callbacks: None,
            pipeline_cache: None,
            queue: None,
            options: DeviceOptions { wait_bound: BOUND, ..Default::default() },
            owner: None,
        }
    }

    /// Lets the engine adopt the device by a description from [`Host::describe`].
    pub fn try_adopt(&self, description: HostDevice) -> Result<Device, gpu::Error> {
        // SAFETY: the description is of this host's device, which lives until `finish`.
        unsafe { Device::adopt(description) }
    }

    /// Lets the engine adopt the device, with a queue or for an executor.
    pub fn adopt(&self, queue: Option<HostQueue>) -> Device {
        self.try_adopt(HostDevice { queue, ..self.describe() }).unwrap()
    }

    /// Declares that every frame is over: the host records none, or has waited for all.
    pub fn say_all_is_over(&self, device: &Device) {
        self.say_finished(device).unwrap();
    }

    /// Declares that every frame is over, to a device that may refuse it.
    pub fn say_finished(&self, device: &Device) -> Result<(), gpu::Error> {
        self.wait_idle();
        // SAFETY: the wait before.
        unsafe { device.host_finished() }
    }

    /// Returns the host's queue, shared with an engine that takes this lock.
    pub fn share_queue(&self, lock: Arc<dyn HostQueueLock>) -> HostQueue {
        HostQueue { raw: self.queue, lock }
    }

    /// Submits work of the host once, and waits until it is over. `record` gets the command buffer.
    /// `lock` holds the queue during the submit.
    pub fn run_once(&self, lock: &dyn HostQueueLock, record: impl FnOnce(vk::CommandBuffer)) {
        let pool_info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(self.needs.queue_family.unwrap());
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: plain Vulkan with objects that live until the fence is signalled.
        unsafe {
            let pool = self.device.create_command_pool(&pool_info, None).unwrap();
            let info =
                vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = self.device.allocate_command_buffers(&info).unwrap()[0];
            self.device.begin_command_buffer(commands, &begin).unwrap();
            record(commands);
            self.device.end_command_buffer(commands).unwrap();
            let fence = self.device.create_fence(&vk::FenceCreateInfo::default(), None).unwrap();
            let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
            let info = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
            lock.locked(BOUND, &mut || {
                self.device.queue_submit2(self.queue, &info, fence).unwrap();
            });
            self.device.wait_for_fences(&[fence], true, BOUND.as_nanos() as u64).unwrap();
            self.device.destroy_fence(fence, None);
            self.device.destroy_command_pool(pool, None);
        }
    }

    /// Submits an empty frame of a ring on an executor's device, and waits until it is over.
    pub fn run_frame(&self, lock: &dyn HostQueueLock, ring: &mut FrameRing, current: u64) {
        self.run_once(lock, |commands| {
            let numbers = FrameNumbers { current: Tick(current), safe: Tick(current - 1) };
            // SAFETY: a command buffer of this device; the frames before are over.
            let frame = unsafe { ring.begin_in(commands, numbers) }.unwrap();
            frame.end().unwrap();
        });
    }

    /// Creates a pipeline cache of the host's own.
    pub fn create_pipeline_cache(&self) -> vk::PipelineCache {
        // SAFETY: an empty cache.
        unsafe { self.device.create_pipeline_cache(&vk::PipelineCacheCreateInfo::default(), None) }
            .unwrap()
    }

    /// Destroys a pipeline cache that is no longer used.
    pub fn destroy_pipeline_cache(&self, cache: vk::PipelineCache) {
        // SAFETY: a cache of this device; the engine that used it is gone.
        unsafe { self.device.destroy_pipeline_cache(cache, None) };
    }

    /// Waits until the GPU is idle.
    #[expect(clippy::disallowed_methods, reason = "the device is the host's own")]
    pub fn wait_idle(&self) {
        // SAFETY: no other thread submits meanwhile.
        unsafe { self.device.device_wait_idle() }.unwrap();
    }

    /// Creates a timeline semaphore of the host's own, at 0.
    pub fn create_timeline(&self) -> vk::Semaphore {
        let mut kind =
            vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
        // SAFETY: the feature is on.
        unsafe { self.device.create_semaphore(&info, None) }.unwrap()
    }

    /// Wraps a timeline for frames of the engine. All frames end before the timeline is destroyed.
    pub fn lend_timeline(&self, device: &Device, timeline: vk::Semaphore) -> Timeline {
        // SAFETY: a timeline of this device.
        unsafe { Timeline::from_raw(device, timeline) }.unwrap()
    }

    /// Signals a timeline from the CPU.
    pub fn signal(&self, timeline: vk::Semaphore, value: u64) {
        let info = vk::SemaphoreSignalInfo::default().semaphore(timeline).value(value);
        // SAFETY: a live timeline of this device.
        unsafe { self.device.signal_semaphore(&info) }.unwrap();
    }

    /// Returns the value of a timeline.
    pub fn value_of(&self, timeline: vk::Semaphore) -> u64 {
        // SAFETY: a live timeline of this device.
        unsafe { self.device.get_semaphore_counter_value(timeline) }.unwrap()
    }

    /// Destroys a timeline that is no longer used.
    pub fn destroy_timeline(&self, timeline: vk::Semaphore) {
        // SAFETY: all frames that waited for it are over.
        unsafe { self.device.destroy_semaphore(timeline, None) };
    }

    /// Takes the messages of the validation layers so far.
    pub fn messages(&self) -> Vec<String> {
        std::mem::take(&mut *lock(&self.messages))
    }

    /// Destroys device and instance, and fails if a layer reported anything, including leaks.
    pub fn finish(self) {
        self.wait_idle();
        // SAFETY: the engine's devices were dropped before, or the layer reports it.
        unsafe {
            self.device.destroy_device(None);
            self.debug.destroy_debug_utils_messenger(self.messenger, None);
            self.instance.destroy_instance(None);
        }
        let messages = self.messages();
        assert!(messages.is_empty(), "the validation layer said: {messages:#?}");
    }
}

fn create_instance(entry: &ash::Entry, messages: &Messages) -> ash::Instance {
    let application =
        vk::ApplicationInfo::default().application_name(c"a host").api_version(vk::API_VERSION_1_3);
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut checks = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut messenger = messenger_info(messages);
    let layers = [LAYER.as_ptr()];
    let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
    let info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_layer_names(&layers)
        .enabled_extension_names(&extensions)
        .push_next(&mut checks)
        .push_next(&mut messenger);
    // SAFETY: every pointer in `info` lives until the call returns.
    unsafe { entry.create_instance(&info, None) }
        .unwrap_or_else(|code| panic!("{code}: run `ci/setup --tests` first, for the layer"))
}

fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    family: u32,
    extensions: &[&CStr],
    features: Features,
) -> ash::Device {
    let mut structures = features.structures();
    let mut chain = structures.link(extensions);
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
    let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&names)
        .push_next(&mut chain);
    // SAFETY: the requirements contain only features and extensions that the device has.
    unsafe { instance.create_device(physical, &info, None) }.unwrap()
}

fn messenger_info(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'_> {
    use vk::{
        DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type,
    };
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Type::VALIDATION | Type::PERFORMANCE)
        .pfn_user_callback(Some(on_message))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast())
}

unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the loader passes valid data, and the boxed messages of a host that lives.
    let (data, messages) = unsafe { (&*data, &*user_data.cast::<Messages>()) };
    // SAFETY: the name is null or null-terminated.
    let id = unsafe { data.message_id_name_as_c_str() }.unwrap_or_default();
    // Loaders and drivers look names up at the wrong level during `vkCreateDevice`.
    if id != c"WARNING-vkGetDeviceProcAddr-device" {
        // SAFETY: the text is null-terminated.
        let text = unsafe { data.message_as_c_str() }.unwrap_or_default();
        lock(messages).push(text.to_string_lossy().into_owned());
    }
    vk::FALSE
}

fn lock(messages: &Messages) -> MutexGuard<'_, Vec<String>> {
    messages.lock().unwrap_or_else(PoisonError::into_inner)
}
