//! The context: what a program creates first. It keeps all objects and the log.

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};

use tracing::Dispatch;

use crate::decisions::culler::{AntumbraCuller, ViewCuller};
use crate::decisions::hierarchy::{AntumbraHierarchy, BoxHierarchy};
use crate::error::{AntumbraError, AntumbraResult, Failure};
#[cfg(feature = "vulkan")]
use crate::executor::device::AntumbraDevice;
#[cfg(feature = "vulkan")]
use crate::executor::device_costs::AntumbraDeviceCosts;
#[cfg(feature = "vulkan")]
use crate::executor::scene::{AntumbraScene, HostedScene};
use crate::layout::{Versioned, layout, versioned};
use crate::log::{ANTUMBRA_LOG_DEBUG, ANTUMBRA_LOG_WARN, AntumbraLogCallback, CallbackLog};
#[cfg(feature = "renderer")]
use crate::renderer::frame::{AntumbraRenderer, HostedRenderer};
#[cfg(feature = "import")]
use crate::renderer::loaded_file::SceneFile;
#[cfg(feature = "renderer")]
use crate::renderer::scene_begin::SceneBegin;
#[cfg(feature = "renderer")]
use crate::renderer::scene_file::AntumbraSceneFile;
use crate::table::Table;
use crate::version::ANTUMBRA_ABI_VERSION;

/// The first bytes of a context, by which pointers to something else are detected.
const MAGIC: u64 = 0x616e_7475_6d62_7261;

/// The owner of all objects of one user of the library. Several contexts can exist at once.
pub struct AntumbraContext {
    magic: u64,
    log: Option<Dispatch>,
    pub(crate) hierarchies: Table<BoxHierarchy, AntumbraHierarchy>,
    pub(crate) cullers: Table<ViewCuller, AntumbraCuller>,
    #[cfg(feature = "renderer")]
    pub(crate) renderers: Table<HostedRenderer, AntumbraRenderer>,
    #[cfg(feature = "import")]
    pub(crate) scene_files: Table<SceneFile, AntumbraSceneFile>,
    #[cfg(feature = "vulkan")]
    pub(crate) scenes: Table<HostedScene, AntumbraScene>,
    #[cfg(feature = "vulkan")]
    pub(crate) costs: Table<occlusion::DeviceCosts, AntumbraDeviceCosts>,
    #[cfg(feature = "vulkan")]
    pub(crate) devices: Table<gpu::Device, AntumbraDevice>,
}

/// The options of a context.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraContextDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Required: the `ANTUMBRA_ABI_VERSION` that the caller was compiled with.
    pub abi_version: u32,
    /// The function that takes messages. Default: null, for none.
    pub log: AntumbraLogCallback,
    /// The first argument of `log`. Default: null.
    pub log_user: *mut c_void,
    /// The least severe level that is passed on, `ANTUMBRA_LOG_ERROR` to `ANTUMBRA_LOG_DEBUG`. For
    /// no messages at all, leave `log` null. Default: `ANTUMBRA_LOG_WARN`.
    pub log_level: u32,
    /// Must be 0.
    pub reserved: u32,
}
layout!(AntumbraContextDesc: struct_size, abi_version, log, log_user, log_level, reserved);

versioned!(AntumbraContextDesc: 2, required: [], defaults: { log_level: ANTUMBRA_LOG_WARN });

impl AntumbraContextDesc {
    /// Returns the default options of a caller that was compiled with this version.
    #[must_use]
    pub const fn current() -> Self {
        Self { abi_version: ANTUMBRA_ABI_VERSION, ..Self::INIT }
    }
}

impl AntumbraContext {
    pub(crate) fn new(desc: &AntumbraContextDesc) -> Result<Box<Self>, Failure> {
        if desc.abi_version != ANTUMBRA_ABI_VERSION {
            let message = format!(
                "the program was compiled with version {} of antumbra.h, this library has version \
                 {ANTUMBRA_ABI_VERSION}: compile and link files of one release",
                desc.abi_version
            );
            return Err(Failure::new(AntumbraResult::AbiVersion, message));
        }
        if !(1..=ANTUMBRA_LOG_DEBUG).contains(&desc.log_level) {
            let message = format_args!("there is no ANTUMBRA_LOG_.. {}", desc.log_level);
            return Err(Failure::argument(message));
        }
        let user = desc.log_user;
        let max_level = desc.log_level;
        let log = desc.log.map(|callback| CallbackLog { callback, user, max_level });
        let mut context = Box::<Self>::new_uninit();
        // Contexts that live at the same time have different addresses.
        let salt = context.as_mut_ptr() as u64;
        Ok(Box::write(
            context,
            Self {
                magic: MAGIC,
                log: log.map(Dispatch::new),
                hierarchies: Table::new(salt),
                cullers: Table::new(salt),
                #[cfg(feature = "renderer")]
                renderers: Table::new(salt),
                #[cfg(feature = "import")]
                scene_files: Table::new(salt),
                #[cfg(feature = "vulkan")]
                scenes: Table::new(salt),
                #[cfg(feature = "vulkan")]
                costs: Table::new(salt),
                #[cfg(feature = "vulkan")]
                devices: Table::new(salt),
            },
        ))
    }

    /// Returns the scene of a file for a renderer.
    #[cfg(feature = "import")]
    pub(crate) fn scene_of(&self, file: AntumbraSceneFile) -> Result<SceneBegin, Failure> {
        Ok(self.scene_files.find(file)?.read()?.begin())
    }

    /// Refuses a file, which only a library with the feature `import` can have loaded.
    #[cfg(all(feature = "renderer", not(feature = "import")))]
    pub(crate) fn scene_of(&self, _: AntumbraSceneFile) -> Result<SceneBegin, Failure> {
        let message = "desc.scene_file: this library was built without the feature `import`, which \
                       reads files";
        Err(Failure::new(AntumbraResult::Unsupported, message))
    }

    /// Destroys a context.
    ///
    /// # Safety
    /// `context` points to readable memory. If that is a context, no other call uses it.
    pub(crate) unsafe fn destroy(context: *mut Self) -> Result<(), Failure> {
        // SAFETY: the caller's promises.
        unsafe {
            checked(context)?;
            (*context).magic = 0;
            let context = Box::from_raw(context);
            let log = context.log.clone();
            logged(log.as_ref(), || drop(context));
        }
        Ok(())
    }
}

/// Runs a call that uses a context.
///
/// # Safety
/// `context` and `error` are as the rules of the interface say.
pub(crate) unsafe fn entry(
    context: *const AntumbraContext,
    error: *mut AntumbraError,
    call: impl FnOnce(&AntumbraContext) -> Result<(), Failure>,
) -> AntumbraResult {
    // SAFETY: the caller's promises.
    unsafe {
        guarded(error, || {
            let context = checked(context)?;
            logged(context.log.as_ref(), || call(context))
        })
    }
}

/// Runs a call, turns its panic into an error, and reports its outcome.
///
/// # Safety
/// `error` is as the rules of the interface say.
pub(crate) unsafe fn guarded(
    error: *mut AntumbraError,
    call: impl FnOnce() -> Result<(), Failure>,
) -> AntumbraResult {
    // Objects that were being changed are poisoned by their locks.
    let outcome = catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        let text = text.unwrap_or("no message");
        let failure = Failure::new(
            AntumbraResult::Panic,
            format_args!("a defect of the library, please report it: {text}"),
        );
        // The payload's own drop could panic again.
        std::mem::forget(panic);
        Err(failure)
    });
    let (result, message) = match &outcome {
        Ok(()) => (AntumbraResult::Ok, ""),
        Err(failure) => (failure.result, failure.message.as_str()),
    };
    // SAFETY: the caller's promise.
    unsafe { AntumbraError::write(error, result, message) };
    result
}

/// Calls a function, and passes the messages of this thread to a log.
fn logged<R>(log: Option<&Dispatch>, call: impl FnOnce() -> R) -> R {
    match log {
        Some(log) => tracing::dispatcher::with_default(log, call),
        None => call(),
    }
}

/// Checks a pointer to a context and returns the context.
///
/// # Safety
/// `context` is null, or points to readable memory. If that is a context, it outlives the result.
unsafe fn checked<'a>(context: *const AntumbraContext) -> Result<&'a AntumbraContext, Failure> {
    if context.is_null() {
        return Err(Failure::new(AntumbraResult::BadPointer, "context is null"));
    }
    // SAFETY: the caller's promise. The magic number detects some broken promises.
    let is_context =
        context.is_aligned() && unsafe { (&raw const (*context).magic).read() } == MAGIC;
    if !is_context {
        let message = "context is none, or was destroyed";
        return Err(Failure::new(AntumbraResult::UnknownHandle, message));
    }
    // SAFETY: as above.
    Ok(unsafe { &*context })
}
