//! A host that draws through the C interface, on its own device. The calls of the host itself do
//! not fail.

use std::ffi::{CStr, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use capi::api::context::{antumbra_context_create, antumbra_context_destroy};
use capi::api::device::antumbra_device_adopt;
use capi::api::renderer::{
    antumbra_renderer_create, antumbra_renderer_image, antumbra_renderer_render,
};
use capi::context::{AntumbraContext, AntumbraContextDesc};
use capi::decisions::camera::AntumbraCamera;
use capi::error::{AntumbraError, AntumbraResult};
use capi::executor::device::{
    AntumbraAdapterDesc, AntumbraDevice, AntumbraDeviceDesc, AntumbraFeatures,
};
use capi::executor::queue::AntumbraQueueDesc;
use capi::layout::Versioned;
use capi::renderer::description::{
    AntumbraMeshDesc, AntumbraMeshObject, AntumbraRendererDesc, AntumbraTransform, AntumbraVertex,
};
use capi::renderer::frame::{AntumbraFinishedImage, AntumbraRenderDesc, AntumbraRenderer};
use cull::CullView;
use gpu::{FinishedImage, ImageState, Purpose, Tick};
use tests::every_call;
use tests::host_device::Host;

use super::{Outcome, Program, SIZE, Stage};

unsafe extern "C" fn one_thread(_user: *mut c_void) {}

/// A context of the C interface, with the text of its last error.
pub(super) struct Context {
    pub(super) raw: *mut AntumbraContext,
    pub(super) error: AntumbraError,
}

impl Context {
    pub(super) fn new() -> Self {
        let struct_size = size_of::<AntumbraError>() as u32;
        let error = AntumbraError { struct_size, result: 0, message: [0; 504] };
        let mut context = Self { raw: null_mut(), error };
        let desc = AntumbraContextDesc::current();
        // SAFETY: pointers to values on this stack.
        let made = unsafe { antumbra_context_create(&desc, &mut context.raw, null_mut()) };
        assert_eq!(made, AntumbraResult::Ok);
        context
    }

    pub(super) fn destroy(mut self) -> Result<(), String> {
        // SAFETY: the context is no longer used.
        let gone = unsafe { antumbra_context_destroy(self.raw, &mut self.error) };
        self.check(gone)
    }

    /// Returns the message of the interface if a call has failed.
    pub(super) fn check(&self, result: AntumbraResult) -> Result<(), String> {
        if result == AntumbraResult::Ok {
            return Ok(());
        }
        // SAFETY: every call ends the message.
        let text = unsafe { CStr::from_ptr(self.error.message.as_ptr()) };
        Err(text.to_string_lossy().into_owned())
    }
}

impl Program {
    /// Draws on the device and the queue of a host in C, and returns the last image.
    pub(super) fn draw_in_c(&self, stage: &Stage) -> Outcome {
        let host = Host::new(stage.driver, Purpose::Renderer);
        every_call::watch(host.device.handle());
        let mut context = Context::new();
        let outcome = self.draw_with(&host, &mut context);
        let gone = context.destroy();
        let outcome = outcome.and_then(|image| gone.map(|()| image));
        every_call::forget_devices();
        host.finish();
        Ok(outcome?)
    }

    fn draw_with(&self, host: &Host, context: &mut Context) -> Result<Vec<u8>, String> {
        let queue = AntumbraQueueDesc {
            queue: host.queue,
            lock: Some(one_thread),
            unlock: Some(one_thread),
            user: null::<c_void>().cast_mut(),
            ..Versioned::INIT
        };
        let device = adopt(host, context, &queue)?;
        let renderer = self.renderer_in_c(device, context)?;
        let mut image = AntumbraFinishedImage::INIT;
        for camera in &self.cameras {
            let view = CullView::new(camera, SIZE, 8);
            let clip_from_world = view.view_proj.to_cols_array();
            let [width, height] = SIZE;
            let camera = AntumbraCamera { clip_from_world, width, height, ..Versioned::INIT };
            let desc = AntumbraRenderDesc { camera: &camera, ..Versioned::INIT };
            let error = &mut context.error;
            // SAFETY: pointers to values on this stack.
            let drawn = unsafe { antumbra_renderer_render(context.raw, renderer, &desc, error) };
            context.check(drawn)?;
            let error = &mut context.error;
            // SAFETY: as above.
            let found =
                unsafe { antumbra_renderer_image(context.raw, renderer, &mut image, error) };
            context.check(found)?;
        }
        let AntumbraFinishedImage { format, image, view, state, timeline, value, .. } = image;
        let state = ImageState { layout: state.layout, stages: state.stages, access: state.access };
        let tick = Tick(value);
        let finished = FinishedImage { image, view, format, size: SIZE, state, timeline, tick };
        Ok(host.copy(&Mutex::new(()), &finished))
    }

    fn renderer_in_c(
        &self,
        device: AntumbraDevice,
        context: &mut Context,
    ) -> Result<AntumbraRenderer, String> {
        let vertex = |vertex: &scene::Vertex| AntumbraVertex {
            position: vertex.position,
            normal: scene::unpack_normal(vertex.normal).to_array(),
            colour: scene::unpack_unorm(vertex.colour),
        };
        let meshes = self.scene.meshes.iter();
        let vertices: Vec<Vec<AntumbraVertex>> =
            meshes.map(|mesh| mesh.vertices.iter().map(vertex).collect()).collect();
        let meshes = self.scene.meshes.iter().zip(&vertices);
        let descs: Vec<AntumbraMeshDesc> = meshes
            .map(|(mesh, vertices)| AntumbraMeshDesc {
                vertices: vertices.as_ptr(),
                vertex_count: vertices.len(),
                indices: mesh.indices.as_ptr(),
                index_count: mesh.indices.len(),
                ..Versioned::INIT
            })
            .collect();
        let pointers: Vec<*const AntumbraMeshDesc> = descs.iter().map(std::ptr::from_ref).collect();
        let object = |object: &scene::Object| AntumbraMeshObject {
            mesh: object.mesh.0,
            tint: object.tint,
            transform: AntumbraTransform { columns: object.transform.to_cols_array() },
        };
        let objects: Vec<AntumbraMeshObject> = self.scene.objects.iter().map(object).collect();
        let desc = AntumbraRendererDesc {
            device,
            width: SIZE[0],
            height: SIZE[1],
            meshes: pointers.as_ptr(),
            mesh_count: pointers.len(),
            objects: objects.as_ptr(),
            object_count: objects.len(),
            ..Versioned::INIT
        };
        let mut renderer = AntumbraRenderer { id: 0 };
        let error = &mut context.error;
        // SAFETY: pointers to values on this stack.
        let made = unsafe { antumbra_renderer_create(context.raw, &desc, &mut renderer, error) };
        context.check(made)?;
        Ok(renderer)
    }
}

/// Adopts the device of a host, with a queue or none. The program has one thread, so the lock of
/// the queue is empty.
pub(super) fn adopt(
    host: &Host,
    context: &mut Context,
    queue: *const AntumbraQueueDesc,
) -> Result<AntumbraDevice, String> {
    let mut structures = host.needs.features().structures();
    let features = AntumbraFeatures {
        core: &raw mut structures.core,
        vulkan_12: (&raw mut structures.vulkan_12).cast(),
        vulkan_13: (&raw mut structures.vulkan_13).cast(),
        conditional_rendering: (&raw mut structures.conditional).cast(),
        ..Versioned::INIT
    };
    let extensions = host.needs.extensions().into_iter().chain([ash::ext::debug_utils::NAME]);
    let extensions: Vec<*const c_char> = extensions.map(CStr::as_ptr).collect();
    let adapter = AntumbraAdapterDesc {
        instance_proc_addr: Some(every_call::entry().static_fn().get_instance_proc_addr),
        instance: host.instance.handle(),
        physical_device: host.physical,
        ..Versioned::INIT
    };
    let desc = AntumbraDeviceDesc {
        queue_family: host.needs.queue_family.unwrap(),
        adapter: &adapter,
        device: host.device.handle(),
        features: &features,
        extensions: extensions.as_ptr(),
        extension_count: extensions.len(),
        queue,
        ..Versioned::INIT
    };
    let mut device = AntumbraDevice { id: 0 };
    // SAFETY: everything belongs to this host, and lives as long as the host.
    let adopted =
        unsafe { antumbra_device_adopt(context.raw, &desc, &mut device, &mut context.error) };
    context.check(adopted)?;
    Ok(device)
}
