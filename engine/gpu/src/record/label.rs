//! Labels of passes as Vulkan wants them, without memory of their own: passes come every frame.

use std::ffi::CStr;

/// The length beyond which labels are cut.
const BYTES: usize = 64;

/// A buffer for a label and the zero behind it.
pub(crate) struct LabelName([u8; BYTES]);

impl Default for LabelName {
    fn default() -> Self {
        Self([0; BYTES])
    }
}

impl LabelName {
    /// Copies the label to a string that ends with a zero, or at the first zero in it.
    pub(crate) fn hold(&mut self, label: &str) -> &CStr {
        let length = label.len().min(BYTES - 1);
        self.0 = [0; BYTES];
        self.0[..length].copy_from_slice(&label.as_bytes()[..length]);
        CStr::from_bytes_until_nul(&self.0).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_end_with_a_zero() {
        let mut place = LabelName::default();
        assert_eq!(place.hold("visible"), c"visible");
        assert_eq!(place.hold(""), c"");
        assert_eq!(place.hold("a\0b"), c"a");
        assert_eq!(place.hold(&"x".repeat(200)).to_bytes().len(), BYTES - 1);
    }
}
