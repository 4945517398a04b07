//! The order in which transparent objects are blended.

use cull::VisibilityTest;

use crate::renderer::Renderer;
use crate::shading::fragments::Fragments;
use crate::shading::transparency::{
    FragmentCounts, TransparencyFallback, TransparencyMethod, TransparencyOptions, fallback_of,
};

impl Renderer {
    /// Returns the options of transparent objects.
    pub fn transparency(&self) -> &TransparencyOptions {
        &self.transparency
    }

    /// Returns the order in which transparent objects are blended: the requested order, or
    /// [`TransparencyMethod::SortedObjects`] if there is a
    /// [reason](Renderer::transparency_fallback) against it.
    pub fn transparency_method(&self) -> TransparencyMethod {
        match self.transparency_fallback() {
            Some(_) => TransparencyMethod::SortedObjects,
            None => self.transparency.method,
        }
    }

    /// Returns the counts of sorted fragments, of the newest frame whose counts have been read;
    /// zeros if there is no such frame.
    pub fn fragment_counts(&self) -> FragmentCounts {
        self.passes.gpu_scene.fragments().map(Fragments::newest).unwrap_or_default()
    }

    /// Returns the reason why objects are sorted although [`TransparencyMethod::SortedFragments`]
    /// was requested, if there is one.
    pub fn transparency_fallback(&self) -> Option<TransparencyFallback> {
        if self.transparency.method == TransparencyMethod::SortedObjects {
            return None;
        }
        if !self.scene.passes().quirks().allows(VisibilityTest::Flag) {
            return Some(TransparencyFallback::DriverQuirk);
        }
        let samples = self.passes.target.attachments().samples;
        let has_room = |size| {
            self.passes.gpu_scene.fragments().is_none_or(|fragments| fragments.has_room_for(size))
        };
        let too_many = (!has_room(self.size())).then_some(TransparencyFallback::TooManyPixels);
        fallback_of(&self.device, samples).or(too_many)
    }
}
