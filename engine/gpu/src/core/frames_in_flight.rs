//! The limit of frames in flight.

use crate::core::error::Error;

/// The most frames in flight.
pub const MAX_FRAMES_IN_FLIGHT: usize = 64;

/// Checks a number of frames in flight against the limit.
pub(crate) fn check_frames_in_flight(frames_in_flight: usize) -> Result<(), Error> {
    let wanted = frames_in_flight as u64;
    let limit = MAX_FRAMES_IN_FLIGHT as u64;
    if wanted <= limit {
        return Ok(());
    }
    Err(Error::TooLarge { what: "the number of frames in flight".to_owned(), wanted, limit })
}
