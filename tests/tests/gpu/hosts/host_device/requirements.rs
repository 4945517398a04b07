//! Devices without some features that the engine can use: the engine works without them, or its
//! refusal names them.

use std::ffi::CString;
use std::sync::{Arc, Mutex};

use gpu::{Capabilities, Features, HostDevice, OptionalFeature, Purpose, RequiredFeature, vk};
use tests::host_device::Host;
use tests::{Driver, open};

use super::images;

#[test]
fn what_is_required_and_not_on_is_refused_by_its_name() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    for purpose in [Purpose::Executor, Purpose::Renderer] {
        let refusal = |change: &dyn Fn(&mut HostDevice)| {
            let mut description = host.describe();
            if purpose == Purpose::Renderer {
                description.queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
            }
            change(&mut description);
            host.try_adopt(description).err().map(|error| error.to_string())
        };
        assert_eq!(refusal(&|_| {}), None);
        let mut named = 0;
        for required in RequiredFeature::ALL {
            let said = refusal(&|description| match required {
                RequiredFeature::Vulkan13 => description.api_version = vk::API_VERSION_1_2,
                RequiredFeature::GraphicsQueue => description.queue_family = u32::MAX,
                feature => {
                    description.features = description.features.without(feature.features());
                }
            });
            // A host cannot leave out what belongs to the physical device, nor what only devices
            // with the portability subset may lack.
            let is_chosen = !matches!(
                required,
                RequiredFeature::Depth32
                    | RequiredFeature::StorageBuffers
                    | RequiredFeature::ComparisonSamplers
            );
            let expected = required.is_for(purpose) && is_chosen;
            assert_eq!(said.is_some(), expected, "{required:?} for {purpose:?}: {said:?}");
            if let Some(said) = said {
                assert!(said.contains(&format!("lacks {}", required.name())), "{said}");
                named += 1;
            }
        }
        assert_eq!(named, if purpose == Purpose::Renderer { 7 } else { 6 });
    }
    host.finish();
}

#[test]
fn what_is_optional_and_not_on_is_done_without() {
    for driver in Driver::ALL {
        let expected = images(&open(driver).1).unwrap();
        let all = OptionalFeature::ALL.map(OptionalFeature::features);
        let features = all.into_iter().fold(Features::default(), Features::union);
        let names: Vec<_> = OptionalFeature::ALL.map(OptionalFeature::extensions).concat().concat();
        let host = Host::without(driver, Purpose::Renderer, &names, features);
        let queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
        let features = host.needs.features().without(features);
        let extensions = Vec::<CString>::new();
        let description = HostDevice { queue, features, extensions, ..host.describe() };
        let device = host.try_adopt(description).unwrap();
        let mut optional = device.capabilities().optional.clone();
        // Features that need not be turned on.
        let is_found = [OptionalFeature::SampleDepths, OptionalFeature::SectionBuffers];
        optional.retain(|optional| !is_found.contains(optional));
        assert_eq!(optional, [OptionalFeature::Timestamps]);
        assert!(images(&device).unwrap() == expected, "other images on {driver:?}");
        drop(device);
        host.finish();
    }
}

#[test]
fn an_executor_asks_for_less() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let features = host.needs.features();
    let names = host.needs.extensions();
    assert!(!features.timeline_semaphore && !features.sampler_anisotropy);
    let device = host.adopt(None);
    // A GPU has further extensions, which the check of the optional features below covers.
    assert!(names.contains(&c"VK_EXT_conditional_rendering"), "{names:?}");
    assert!(names.len() == 1 || !device.adapter().is_software(), "{names:?}");
    let Capabilities { optional, .. } = device.capabilities();
    assert!(optional.iter().all(|what| what.is_for(Purpose::Executor)), "{optional:?}");
    drop(device);
    // A renderer would need more.
    let queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
    let refused = host.try_adopt(HostDevice { queue, ..host.describe() });
    let refused = refused.err().expect("an error").to_string();
    assert!(refused.contains("lacks timelineSemaphore"), "{refused}");
    host.finish();
}
