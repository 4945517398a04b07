//! A renderer whose creation is cancelled while its scene is uploaded. The upload ends within a few
//! pieces after the request, at any piece, and leaves nothing behind.

use gpu::{CancellationToken, Device, DeviceOptions};
use render::surfaces::TextureStorage;
use render::{Error, Renderer, RendererOptions};
use tests::fault_injection::{FaultInjection, Impatience, calls};
use tests::{Driver, instance_with};

use super::{options, scene};

const SUBMIT: &std::ffi::CStr = c"vkQueueSubmit2";

/// The most submits after the request: the buffers between two checks.
const FEW: usize = 5;

/// Creates a renderer, and cancels the creation during the submit `given_up`. Returns the number of
/// submits.
fn submits(device: &Device, storage: TextureStorage, given_up: Option<usize>) -> usize {
    let cancellation = CancellationToken::new();
    let impatience = given_up.map(|number| Impatience {
        call: SUBMIT,
        number,
        cancellation: cancellation.clone(),
    });
    FaultInjection { impatience, ..FaultInjection::default() }.install();
    let options = RendererOptions { cancellation, ..options(Some(storage)) };
    let made = Renderer::new(device, &scene(), &options);
    match made {
        Ok(renderer) => assert!(renderer.supports(cull::Strategy::ANTUMBRA).is_ok()),
        Err(error) => assert!(
            given_up.is_some() && matches!(error, Error::Gpu(gpu::Error::Cancelled)),
            "{error}"
        ),
    }
    calls(SUBMIT)
}

#[test]
fn an_upload_ends_within_a_few_pieces_of_the_request() {
    let instance = instance_with(FaultInjection::default().entry());
    let adapter = instance.pick_adapter(Some(Driver::SwiftShader.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    for storage in [TextureStorage::ArrayPacked, TextureStorage::Bindless] {
        let all = submits(&device, storage, None);
        assert!(all > 2 * FEW, "{storage:?}: {all} submits");
        let beyond: Vec<usize> = (0..all)
            .map(|number| submits(&device, storage, Some(number)).saturating_sub(number + 1))
            .collect();
        assert!(beyond.iter().all(|submits| *submits <= FEW), "{storage:?}: {beyond:?}");
        // Most pieces belong to textures, whose upload checks for the request at each piece.
        let images = scene().surfaces.map_or(0, |surfaces| surfaces.images.len());
        let at_once = beyond.iter().filter(|submits| **submits == 0).count();
        assert!(at_once >= images, "{storage:?}: {beyond:?}");
    }
    drop(device);
    assert_eq!(instance.validation_log().drain(), []);
}

#[test]
fn a_renderer_that_is_made_heeds_no_request() {
    tests::run(Driver::Lavapipe, |device| {
        let cancellation = CancellationToken::new();
        let options = RendererOptions { cancellation: cancellation.clone(), ..options(None) };
        let mut renderer = Renderer::new(device, &scene(), &options).unwrap();
        cancellation.cancel();
        renderer.resize([64, 64]).unwrap();
        let mut view = renderer.new_view().unwrap();
        renderer.wait_idle(&mut view).unwrap();
        let refused = Renderer::new(device, &scene(), &options).map(drop).unwrap_err();
        assert!(matches!(refused, Error::Gpu(gpu::Error::Cancelled)), "{refused}");
    });
}
