//! Shadows: the maps of lights, drawn before the views of a frame and kept from frame to frame.

mod light_shadow;
mod records;
mod shadow_maps;

use std::collections::HashMap;

use ::shadows::{ShadowMethod, ShadowOptions, ShadowStats};
use gpu::Device;
use scene::LightId;

use crate::error::Error;
pub use light_shadow::LightShadow;
pub use records::ShadowIo;
pub(crate) use shadow_maps::ShadowMaps;

/// The shadows of a renderer's lights.
pub(crate) struct Shadows {
    pub(crate) options: ShadowOptions,
    /// The shadows of lights that differ from what the options say.
    pub(crate) own: HashMap<LightId, LightShadow>,
    /// The maps, with the method that has some.
    pub(crate) maps: Option<ShadowMaps>,
}

impl Shadows {
    /// Creates the maps that the options ask for.
    ///
    /// # Errors
    /// Impossible options, no memory, a failed call.
    pub(crate) fn new(device: &Device, options: ShadowOptions) -> Result<Self, Error> {
        options.check()?;
        let maps = match options.method {
            ShadowMethod::Off => None,
            ShadowMethod::Maps => Some(ShadowMaps::new(device, options)?),
        };
        Ok(Self { options, own: HashMap::new(), maps })
    }

    /// Returns the counts of the newest frame.
    pub(crate) fn stats(&self) -> ShadowStats {
        self.maps.as_ref().map(ShadowMaps::stats).unwrap_or_default()
    }
}
