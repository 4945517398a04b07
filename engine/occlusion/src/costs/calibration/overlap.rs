//! Measures the cost of a break in a frame: the device waits for the earlier draws, and nothing
//! overlaps. A frame without tests, in contrast, starts while the previous one is still drawn.

use std::time::Instant;

use gpu::{Device, FrameRing};

use super::median;
use crate::costs::box_bench::{BenchItem, BoxRecorder, TestLoad};
use crate::error::Error;

/// Patches per frame: about three milliseconds on a software driver.
const PATCHES: u32 = 48;

/// The frames that are submitted in a row, several of them in flight at once.
const FRAMES: usize = 4;
const ROUNDS: usize = 3;

/// Returns the share by which a break among draws makes them take longer, not counting `break_ns`.
pub(super) fn break_wait_share(
    device: &Device,
    bench: &mut BoxRecorder<'_>,
    break_ns: f64,
) -> Result<f64, Error> {
    let mut frames = FrameRing::new(device, 2)?;
    let mut shares = Vec::new();
    for _ in 0..ROUNDS {
        let whole = time_ns(device, bench, &mut frames, TestLoad::Nothing)?;
        let broken = time_ns(device, bench, &mut frames, TestLoad::Once)?;
        let lost = (broken - whole) / FRAMES as f64 - break_ns;
        shares.push(lost / (whole / FRAMES as f64));
    }
    // NaN if the clock stands still; the caller then takes the default.
    let share = median(&mut shares);
    Ok(if share.is_nan() { share } else { share.clamp(0.0, 1.0) })
}

/// Returns the time of a number of frames in a row (ns).
fn time_ns(
    device: &Device,
    bench: &mut BoxRecorder<'_>,
    frames: &mut FrameRing,
    load: TestLoad,
) -> Result<f64, Error> {
    let began = Instant::now();
    for _ in 0..FRAMES {
        let mut frame = frames.begin()?;
        bench.prepare(&mut frame, BenchItem::Patches, PATCHES)?;
        frame.commands().pass("calibration", |commands| bench.record_load(commands, load));
        frame.submit(None)?;
    }
    device.wait_idle()?;
    Ok(began.elapsed().as_secs_f64() * 1.0e9)
}
