//! Paces frames on a simulated display of 100 Hz, with 2 ms of CPU work and 3 ms of GPU work. No
//! clock is read: time is a variable.

use std::error::Error;
use std::time::Duration;

use antumbra_pacing::{
    Feedback, FrameStatistics, HitchRule, Pacer, PacerOptions, PresentReports, Presentation,
    PresentationMode, Refresh, Step, Time,
};

const PERIOD_NS: u64 = 10_000_000;

fn main() -> Result<(), Box<dyn Error>> {
    let mode = PresentationMode::Fifo;
    let reports = PresentReports::Times;
    let presentation = Presentation { mode, images: 3, refresh: Refresh::Unknown, reports };
    let mut pacer = Pacer::new(PacerOptions::default(), presentation)?;
    let mut statistics = FrameStatistics::new(100, HitchRule::default())?;
    let mut now = Time::from_origin(Duration::from_secs(5));
    let mut newest = now;
    let mut underway = Vec::new();
    for _ in 0..2_000 {
        // The display reports the present time of a frame.
        underway.retain(|&(frame, at)| {
            if at <= now {
                pacer.feedback(frame, Feedback::Shown { at });
            }
            at > now
        });
        while let Some((_, timing)) = pacer.completed() {
            statistics.record(timing);
        }
        match pacer.next(now) {
            // A real program sleeps until then, or until there is feedback.
            Step::Wait(wait) => now = wait.until,
            // A real program reads its input, records, submits and presents.
            Step::Start(plan) => {
                let start = now;
                now = now.after(Duration::from_millis(2));
                pacer.feedback(plan.frame, Feedback::Acquired { from: now, to: now });
                pacer.feedback(plan.frame, Feedback::Queued { at: now });
                let finished = now.after(Duration::from_millis(3));
                pacer.feedback(plan.frame, Feedback::Finished { at: finished });
                let ready = finished.max(newest.after(Duration::from_millis(1))).as_nanos();
                newest = Time::from_nanos(ready.next_multiple_of(PERIOD_NS));
                underway.push((plan.frame, newest));
                let number = plan.frame.0;
                let lead = newest.as_nanos() - start.as_nanos();
                if number % 100 == 0 {
                    println!("frame {number} starts {} us before it is shown", lead / 1000);
                }
            }
        }
    }
    let summary = statistics.summary();
    let latency = summary.latencies.ok_or("no frame was shown")?.median;
    println!("period {:?}, latency {latency:?}", pacer.refresh_period().ok_or("not learnt")?);
    println!("missed refreshes: {}", summary.missed_refreshes.ok_or("not known")?);
    Ok(())
}
