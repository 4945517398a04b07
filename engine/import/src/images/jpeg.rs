//! Facts about a JPEG that its decoder does not report: it fills up truncated files, and takes more
//! memory for progressive ones (ITU-T T.81, annex B).

/// The facts from the markers of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Jpeg {
    /// True if it has several scans, so that all coefficients are kept until the last scan.
    pub(super) is_progressive: bool,
    /// True if its end marker exists.
    pub(super) has_end: bool,
}

/// Reads the markers up to the first scan.
pub(super) fn inspect(bytes: &[u8]) -> Jpeg {
    let mut jpeg = Jpeg::default();
    let mut at = 2;
    while let Some(&[0xFF, marker]) = bytes.get(at..).and_then(|rest| rest.first_chunk()) {
        match marker {
            // A byte of padding.
            0xFF => at += 1,
            // Markers without a segment.
            0x01 | 0xD0..=0xD8 => at += 2,
            // The start of a scan: only the end marker can follow.
            0xDA => {
                jpeg.has_end = bytes.get(at..).is_some_and(has_end);
                break;
            }
            _ => {
                jpeg.is_progressive |= matches!(marker, 0xC2 | 0xC6 | 0xCA | 0xCE);
                let length = bytes.get(at + 2..).and_then(|rest| rest.first_chunk());
                let Some(&length) = length else { break };
                at += 2 + usize::from(u16::from_be_bytes(length));
            }
        }
    }
    jpeg
}

fn has_end(scans: &[u8]) -> bool {
    scans.windows(2).rev().any(|pair| pair == [0xFF, 0xD9])
}

/// Returns two ways to complete a file without an end marker: the marker alone, and other
/// coefficients before it. The decoded images differ if coefficients are missing.
pub(super) fn endings(bytes: &[u8]) -> [Vec<u8>; 2] {
    const END: [u8; 2] = [0xFF, 0xD9];
    // Half of a marker is not a marker, unless the byte was stuffed.
    let bytes = bytes.strip_suffix(&[0xFF]).unwrap_or(bytes);
    [[bytes, &END].concat(), [bytes, &[0x5A; 64], &END].concat()]
}
