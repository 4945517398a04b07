//! Random sequences of calls of a renderer: add, move, remove, stream, resize, other strategies,
//! section planes, lights, shadows, shaders, the loss of the device. Each image with culling is the
//! image without, bit for bit.

use gpu::{Device, DeviceOptions};
use tests::long_run::{LongRun, Loss};
use tests::{Driver, open};

/// Makes `calls` calls of each seed on a driver.
fn verify(driver: Driver, seeds: std::ops::Range<u64>, calls: usize) {
    let (instance, device) = open(driver);
    let adapter = instance.pick_adapter(Some(driver.device_name())).unwrap();
    let log = instance.validation_log().clone();
    for seed in seeds {
        let instance = instance.clone();
        let adapter = adapter.clone();
        let open =
            move || Device::new(&instance, &adapter, &DeviceOptions::default()).expect("a device");
        let mut run = LongRun::new(seed, Loss::Feigned, Box::new(open));
        for _ in 0..calls {
            run.step_and_compare();
        }
        drop(run);
        let messages = log.drain();
        assert!(messages.is_empty(), "{driver:?}, seed {seed}: {messages:#?}");
    }
    drop((device, instance));
    let messages = log.drain();
    assert!(messages.is_empty(), "{driver:?}: {messages:#?}");
}

#[test]
fn every_image_of_a_sequence_of_calls_is_exact() {
    verify(Driver::Lavapipe, 0..20, 20);
    verify(Driver::SwiftShader, 0..1, 10);
}

/// Checks more seeds: `ANTUMBRA_SEEDS=5000`.
#[test]
#[ignore = "long walk"]
fn every_image_of_many_sequences_of_calls_is_exact() {
    let seeds = crate::seeds(20, 300);
    verify(Driver::Lavapipe, seeds.clone(), 40);
    verify(Driver::SwiftShader, seeds.start..seeds.start + (seeds.end - seeds.start) / 10, 40);
}
