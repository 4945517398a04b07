//! A file's way to a frame: from bytes to a scene, a renderer and an image, for any bytes.

use std::ops::ControlFlow;

use cull::Strategy;
use gltf_files::target::small_limits;
use gpu::{Device, Instance, Message, Readback};
use import::{LoadOptions, load_bytes};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};

use crate::walk::pixels_that_differ;
use crate::{Driver, open};

const SIZE: [u32; 2] = [32, 18];

/// The outcome of showing a file.
#[derive(Clone, Debug, PartialEq)]
pub enum FileOutcome {
    /// It is no scene.
    Refused,
    /// The device cannot show its scene, as the error says.
    NotShown(String),
    /// Its frame was drawn.
    Shown,
}

/// A device on which each file gets a renderer.
pub struct FileViewer {
    device: Device,
    instance: Instance,
}

impl FileViewer {
    /// Opens the device of a driver, under the validation layer.
    pub fn open(driver: Driver) -> Self {
        let (instance, device) = open(driver);
        Self { device, instance }
    }

    /// Loads a file and draws one frame of it, and one without occlusion culling.
    ///
    /// # Panics
    /// On a message of the validation layer, on a frame that fails, and on images that differ.
    pub fn show(&self, bytes: &[u8]) -> FileOutcome {
        let outcome = self.try_to_show(bytes);
        let messages: Vec<Message> = self.instance.validation_log().drain();
        assert!(messages.is_empty(), "{messages:#?}");
        outcome
    }

    fn try_to_show(&self, bytes: &[u8]) -> FileOutcome {
        let options = LoadOptions { limits: small_limits(), ..LoadOptions::default() };
        let loaded = load_bytes(bytes.to_vec(), None, &options, &mut |_| ControlFlow::Continue(()));
        let Ok(imported) = loaded else { return FileOutcome::Refused };
        let camera = imported.default_camera(SIZE);
        let options =
            RendererOptions { size: SIZE, cost_model: CostModel::Off, ..Default::default() };
        let mut renderer = match Renderer::new(&self.device, &imported.scene, &options) {
            Ok(renderer) => renderer,
            Err(error) => return FileOutcome::NotShown(error.to_string()),
        };
        let images = [Strategy::ANTUMBRA, Strategy::FRUSTUM].map(|strategy| {
            let mut view = renderer.new_view().expect("a view");
            let image = Readback::new(&self.device, SIZE).expect("memory");
            let request =
                FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera) };
            renderer.render(&mut view, request).expect("a frame");
            renderer.wait_idle(&mut view).expect("it works");
            image.rgba8().expect("it is over").to_vec()
        });
        assert_eq!(pixels_that_differ(&images[0], &images[1]), 0, "pixels with culling differ");
        FileOutcome::Shown
    }

    /// Closes the device, and returns what the validation layer has said of it.
    pub fn close(self) -> Vec<Message> {
        let log = self.instance.validation_log().clone();
        drop(self);
        log.drain()
    }
}
