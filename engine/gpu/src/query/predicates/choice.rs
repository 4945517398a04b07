//! The choice of the executor of predicates for a device.

use super::decisions::Predication;
use crate::core::capabilities::Optional;
use crate::core::device::Device;
use crate::core::error::Error;

/// Returns the executor for `draws` draws: the one wanted, else the best of the device for so many.
/// Any range may become one draw call, and a draw count is limited as a whole.
pub(super) fn choose(
    device: &Device,
    wanted: Option<Predication>,
    draws: u64,
    threshold_samples: u32,
) -> Result<Predication, Error> {
    let capabilities = device.capabilities();
    let unsupported = |lacking: Optional, wanted| Error::Unsupported {
        device: device.adapter().name.clone(),
        missing: lacking.name(),
        wanted,
    };
    let compares = threshold_samples > 0;
    if compares && wanted == Some(Predication::Conditional) {
        return Err(Error::CannotCompare { threshold_samples });
    }
    if compares && !capabilities.has(Optional::PreciseQueries) {
        return Err(unsupported(Optional::PreciseQueries, "a visibility threshold"));
    }
    let limit = u64::from(device.adapter().limits.max_draw_indirect_count);
    let is_too_much = |predication| predication == Predication::Counts && draws > limit;
    let Some(wanted) = wanted else {
        let best = match Predication::best(capabilities) {
            Predication::Conditional if compares => {
                match capabilities.has(Optional::DrawIndirectCount) {
                    true => Predication::Counts,
                    false => Predication::Instances,
                }
            }
            best => best,
        };
        return Ok(if is_too_much(best) { Predication::Instances } else { best });
    };
    if let Some(lacking) = wanted.needs().filter(|optional| !capabilities.has(*optional)) {
        return Err(unsupported(lacking, "this way to skip hidden draws"));
    }
    if is_too_much(wanted) {
        let what = "the number of draws under draw counts".to_owned();
        return Err(Error::TooLarge { what, wanted: draws, limit });
    }
    Ok(wanted)
}
