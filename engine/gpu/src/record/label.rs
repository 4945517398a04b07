//! Labels of passes as C strings without allocation, because passes are recorded in every frame.

use std::ffi::CStr;

/// The size that labels are cut to.
const BYTES: usize = 64;

/// A buffer for a label and its terminating zero.
pub(crate) struct LabelName([u8; BYTES]);

impl Default for LabelName {
    fn default() -> Self {
        Self([0; BYTES])
    }
}

impl LabelName {
    /// Copies the label to a zero-terminated string, cut at the first zero in it.
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
