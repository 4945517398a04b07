//! Times resets of queries, by the CPU and by commands.

use std::time::Instant;

use gpu::{Device, FrameRing, OptionalFeature, QueryRing, Resubmission};

use crate::costs::device_costs::QueryResetCosts;
use crate::error::Error;

/// The number of queries in the shorter measurement; the longer one has twice that number.
const QUERIES: u32 = 256;

const ROUNDS: usize = 3;

/// Measures the cost of resetting a query.
pub(super) fn measure(
    device: &Device,
    queries: &mut QueryRing<()>,
) -> Result<QueryResetCosts, Error> {
    let mut each_ns = |by| -> Result<f32, Error> {
        let mut shortest_ns = [f64::NAN; 2];
        let mut frames = frames(device, by)?;
        // The first turn creates the pool.
        for turn in 0..=ROUNDS {
            for (count, shortest_ns) in [2 * QUERIES, QUERIES].into_iter().zip(&mut shortest_ns) {
                let ns = time_ns(device, &mut frames, by, queries, count)?;
                *shortest_ns = if turn == 0 { f64::NAN } else { shortest_ns.min(ns) };
            }
        }
        let [many, few] = shortest_ns;
        Ok(((many - few) / f64::from(QUERIES)).max(0.0) as f32)
    };
    let cpu_ns = if device.capabilities().has(OptionalFeature::HostQueryReset) {
        each_ns(Resubmission::Never)?
    } else {
        f32::NAN
    };
    Ok(QueryResetCosts { command_ns: each_ns(Resubmission::Allowed)?, cpu_ns })
}

/// Returns timed frames in which queries are reset by the CPU, or by commands if frames may be
/// submitted again.
pub(super) fn frames(device: &Device, by: Resubmission) -> Result<FrameRing, Error> {
    let mut frames = FrameRing::new(device, 1)?;
    frames.set_resubmission(by);
    if device.capabilities().has(OptionalFeature::Timestamps) {
        frames.time_frames()?;
    }
    Ok(frames)
}

/// Returns the time of a frame that resets `count` queries (ns). For resets by the CPU it is the
/// time of the call; for resets by commands it is their GPU time, or without timestamps the time
/// from submit to completion.
pub(super) fn time_ns(
    device: &Device,
    frames: &mut FrameRing,
    by: Resubmission,
    queries: &mut QueryRing<()>,
    count: u32,
) -> Result<f64, Error> {
    let tags = vec![(); count as usize];
    let mut frame = frames.begin()?;
    frame.begin_timing();
    let began = Instant::now();
    queries.begin(&mut frame, &tags)?;
    let called = began.elapsed();
    let began = Instant::now();
    let tick = frame.submit(None)?;
    queries.submitted(tick);
    device.wait_idle()?;
    let elapsed = began.elapsed();
    if by == Resubmission::Never {
        return Ok(called.as_secs_f64() * 1.0e9);
    }
    match frames.begin()?.last_time() {
        Some(time) => Ok(time.gpu_ms * 1.0e6),
        None => Ok(elapsed.as_secs_f64() * 1.0e9),
    }
}
