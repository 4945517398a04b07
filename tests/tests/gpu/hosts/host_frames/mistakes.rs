//! The mistakes of hosts: the refusal of each names it, and later frames are drawn.
#![allow(unsafe_code, reason = "a host calls Vulkan itself")]

use cull::Strategy;
use gpu::{Attachments, Error, HostImage, HostImages, ImageState, NearDepth, Purpose, Target, vk};
use occlusion::{OcclusionPasses, ShaderSet};
use tests::host_device::Host;
use tests::host_walk::camera;
use tests::{Driver, drivers};

use super::host::{HostLoop, HostOptions, Submits};

#[test]
fn numbers_that_cannot_be_are_refused_and_change_nothing() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Executor);
        let mut walk = HostLoop::new(&host, &HostOptions::default());
        for frame in 0..2 {
            walk.draw(Strategy::ANTUMBRA, &camera(frame), Submits::Once).unwrap();
        }
        host.wait_idle();
        let error = walk.refusal(3, 0).unwrap();
        let is_named = matches!(error, Error::TooManyFrames { current: 3, used: 1, slots: 2 });
        assert!(is_named, "{error}");
        for (current, safe) in [(2, 1), (1, 1), (3, 3), (0, 2)] {
            let error = walk.refusal(current, safe).unwrap();
            assert!(matches!(error, Error::FrameNumbers { .. }), "{current}, {safe}: {error}");
        }
        walk.draw(Strategy::ANTUMBRA, &camera(2), Submits::Once).unwrap();
        // A frame that is begun and given up takes its number with it.
        assert!(walk.refusal(4, 3).is_none() && walk.refusal(4, 3).is_some());
        walk.finish_draws();
        walk.destroy();
        host.finish();
    }
}

#[test]
fn a_frame_of_a_host_needs_a_device_without_a_queue() {
    tests::run_on_all(|device| {
        let mut frames = gpu::FrameRing::new(device, 2).unwrap();
        let numbers = gpu::FrameNumbers { current: gpu::Tick(1), safe: gpu::Tick::ZERO };
        // SAFETY: refused before the command buffer is used.
        let refused = unsafe { frames.begin_in(vk::CommandBuffer::null(), numbers) };
        assert!(matches!(refused.err(), Some(Error::HasQueue)));
        let frame = frames.begin().unwrap();
        assert!(matches!(frame.end(), Err(Error::HasQueue)));
    });
}

#[test]
fn passes_for_other_attachments_and_views_of_other_tables_are_refused() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let mut walks = [(); 2].map(|()| HostLoop::new(&host, &HostOptions::default()));
    let [walk, other] = &mut walks;
    std::mem::swap(&mut walk.state, &mut other.state);
    let error = walk.draw(Strategy::ANTUMBRA, &camera(0), Submits::Once).unwrap_err();
    assert!(matches!(error, occlusion::Error::ForeignView), "{error}");
    std::mem::swap(&mut walk.state, &mut other.state);
    let passes = walk.scene.parts_mut().passes;
    let attachments = Attachments { depth: vk::Format::D16_UNORM, ..passes.attachments() };
    let shaders = ShaderSet::embedded().unwrap();
    *passes = OcclusionPasses::new(&walk.device, &shaders, attachments).unwrap();
    let error = walk.draw(Strategy::ANTUMBRA, &camera(0), Submits::Once).unwrap_err();
    assert!(matches!(error, occlusion::Error::Attachments(_)), "{error}");
    let text = error.to_string();
    assert!(text.contains("D16_UNORM") && text.contains("D32_SFLOAT"), "{text}");
    for mut walk in walks {
        walk.finish_draws();
        walk.destroy();
    }
    host.finish();
}

#[test]
fn images_that_cannot_be_drawn_to_are_refused() {
    use vk::Format as F;
    use vk::ImageUsageFlags as U;
    let refusal_of = |device: &gpu::Device, depth, usages: [U; 2], colours: &[F]| {
        let image = |format, usage| HostImage {
            image: vk::Image::null(),
            view: vk::ImageView::null(),
            format,
            usage,
            entry: ImageState::depth_attachment(),
            exit: None,
        };
        let colours: Vec<HostImage> =
            colours.iter().map(|format| image(*format, usages[1])).collect();
        let images = HostImages {
            depth: image(depth, usages[0]),
            colours: &colours,
            samples: vk::SampleCountFlags::TYPE_1,
            near_depth: NearDepth::One,
            views: 1,
            size: [8, 8],
        };
        // SAFETY: no command uses the target.
        unsafe { Target::of_host(device, &images) }.err().map(|error| error.to_string())
    };
    let attached = [U::DEPTH_STENCIL_ATTACHMENT, U::COLOR_ATTACHMENT];
    let refusal =
        |device: &gpu::Device, depth, colours: &[F]| refusal_of(device, depth, attached, colours);
    tests::run_on_all(|device| {
        let [depth, colour] = attached;
        for (usages, words) in [
            ([U::empty(), colour], "the depth image of a host's target has the usage 0x0"),
            ([colour, colour], "without VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT"),
            ([depth, U::TRANSFER_SRC], "colour image 0 of a host's target has the usage 0x1"),
            ([depth, depth], "without VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT"),
        ] {
            let said = refusal_of(device, F::D32_SFLOAT, usages, &[F::R8G8B8A8_UNORM]).unwrap();
            assert!(said.contains(words), "{said}");
        }
        for depth in [
            F::D16_UNORM,
            F::X8_D24_UNORM_PACK32,
            F::D32_SFLOAT,
            F::D16_UNORM_S8_UINT,
            F::D24_UNORM_S8_UINT,
            F::D32_SFLOAT_S8_UINT,
        ] {
            assert_eq!(refusal(device, depth, &[]), None);
            let said = refusal(device, F::D32_SFLOAT, &[F::R8G8B8A8_UNORM, depth]).unwrap();
            assert!(said.contains("colour image 1") && said.contains(&format!("{depth:?}")));
        }
        for depth in [F::UNDEFINED, F::S8_UINT, F::R32_SFLOAT, F::B8G8R8A8_SRGB] {
            let said = refusal(device, depth, &[]).unwrap();
            assert!(said.contains("depth image") && said.contains(&format!("{depth:?}")), "{said}");
        }
        for colour in [F::UNDEFINED, F::S8_UINT] {
            let said = refusal(device, F::D32_SFLOAT, &[colour]).unwrap();
            assert!(said.contains("colour image 0"), "{said}");
        }
        assert_eq!(refusal(device, F::D32_SFLOAT, &[F::R16G16B16A16_SFLOAT]), None);
    });
}
