//! A trace of CPU and GPU work on one time line, in the format of Chrome and Perfetto.

use std::collections::VecDeque;
use std::path::Path;

use antumbra::gpu;
use antumbra::gpu::{Clocks, Device, PassTime};
use antumbra::pacing::Time;
use serde_json::{Value, json};

use bench::outputs::{WriteError, write_file};

/// The most events that are stored; further events are only counted.
const MOST_EVENTS: usize = 1 << 20;
/// The interval at which the clocks are compared again, because they drift.
const COMPARE_EVERY_NS: u64 = 500_000_000;

const CPU: u32 = 1;
const GPU: u32 = 2;

/// One bar of the trace.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Event {
    name: &'static str,
    thread: u32,
    /// The time of its beginning; for GPU events, on the GPU's clock until they are written.
    began_ns: f64,
    took_ns: f64,
    /// The offset from its clock to the CPU's, if it is known.
    offset_ns: Option<f64>,
}

/// The relation of the GPU's clock to the CPU's.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Calibration {
    /// Both clocks were read at once, with at most `deviation_ns` between the readings.
    Read { offset_ns: f64, deviation_ns: u64, at_ns: u64 },
    /// The GPU's work lies between its submission and the time at which its end was known.
    Bounds { least_ns: f64, most_ns: f64 },
}

impl Calibration {
    const UNKNOWN: Self = Self::Bounds { least_ns: f64::NEG_INFINITY, most_ns: f64::INFINITY };

    fn read(clocks: &Clocks) -> Self {
        let offset_ns = clocks.monotonic_ns as f64 - clocks.gpu_ns as f64;
        let Clocks { deviation_ns, monotonic_ns: at_ns, .. } = *clocks;
        Self::Read { offset_ns, deviation_ns, at_ns }
    }

    /// Narrows the bounds by work that ran between the times `gpu_ns`, and that was submitted and
    /// known to be finished at the times `ours_ns`.
    fn narrow(&mut self, ours_ns: [f64; 2], gpu_ns: [f64; 2]) {
        if let Self::Bounds { least_ns, most_ns } = self {
            *least_ns = least_ns.max(ours_ns[0] - gpu_ns[0]);
            *most_ns = most_ns.min(ours_ns[1] - gpu_ns[1]);
        }
    }

    /// Returns the offset to add to the GPU's times. Work starts after its submission, but soon.
    fn offset_ns(&self) -> f64 {
        let offset = match *self {
            Self::Read { offset_ns, .. } => offset_ns,
            Self::Bounds { least_ns, .. } => least_ns,
        };
        if offset.is_finite() { offset } else { 0.0 }
    }

    /// Returns a description of the calibration for the reader of the trace.
    fn how(&self) -> String {
        match self {
            Self::Read { deviation_ns, .. } => {
                format!("VK_EXT_calibrated_timestamps, within {deviation_ns} ns")
            }
            Self::Bounds { least_ns, most_ns } if most_ns >= least_ns && most_ns.is_finite() => {
                let within_ns = most_ns - least_ns;
                format!("between submit and finish of each frame, within {within_ns:.0} ns")
            }
            Self::Bounds { .. } => "between submit and finish of each frame".to_owned(),
        }
    }
}

/// A limited number of events.
#[derive(Clone, Debug, Default)]
struct Events {
    kept: Vec<Event>,
    left_out: u64,
}

impl Events {
    fn push(&mut self, event: Event, most: usize) {
        if self.kept.len() < most {
            return self.kept.push(event);
        }
        if self.left_out == 0 {
            tracing::warn!("the trace is full: later events are not in it");
        }
        self.left_out += 1;
    }
}

/// Collects events until they are written.
pub struct Trace {
    device: Device,
    events: Events,
    calibration: Calibration,
    /// The times of submission of the frames in flight, oldest first.
    submitted: VecDeque<Time>,
}

impl Trace {
    /// Creates a trace of the work of `device` from now on.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(device: &Device) -> Result<Self, gpu::Error> {
        let clocks = device.clocks()?;
        Ok(Self {
            device: device.clone(),
            events: Events::default(),
            calibration: clocks.as_ref().map_or(Calibration::UNKNOWN, Calibration::read),
            submitted: VecDeque::new(),
        })
    }

    /// Continues on another device. The frames that the lost one had in flight have no times.
    /// `clocks` are those of the new one.
    pub fn follow_device(&mut self, device: &Device, clocks: Option<&Clocks>) {
        self.device = device.clone();
        self.calibration = clocks.map_or(Calibration::UNKNOWN, Calibration::read);
        self.submitted.clear();
    }

    /// Adds an event of the CPU.
    pub fn cpu(&mut self, name: &'static str, from: Time, to: Time) {
        let took_ns = to.since(from).as_nanos() as f64;
        let began_ns = from.as_nanos() as f64;
        self.push(Event { name, thread: CPU, began_ns, took_ns, offset_ns: None });
    }

    /// Records the submission of a frame, with this number of frames in flight. Its recording began
    /// at `began`. The passes of the previous frame in its slot are known since `known`.
    ///
    /// # Errors
    /// A failed call.
    pub fn submitted(
        &mut self,
        began: Time,
        known: Time,
        frames_in_flight: usize,
        passes: &[PassTime],
    ) -> Result<(), gpu::Error> {
        let before = if self.submitted.len() >= frames_in_flight {
            self.submitted.drain(..=self.submitted.len() - frames_in_flight).next_back()
        } else {
            None
        };
        self.submitted.push_back(began);
        if let Calibration::Read { at_ns, .. } = self.calibration
            && known.as_nanos().saturating_sub(at_ns) > COMPARE_EVERY_NS
            && let Some(clocks) = self.device.clocks()?
        {
            self.calibration = Calibration::read(&clocks);
        }
        let (Some(before), Some(first), Some(last)) = (before, passes.first(), passes.last())
        else {
            return Ok(());
        };
        let end_ns = last.began_ns as f64 + last.gpu_ms * 1e6;
        let ours = [before, known].map(|time| time.as_nanos() as f64);
        self.calibration.narrow(ours, [first.began_ns as f64, end_ns]);
        let offset_ns = match self.calibration {
            Calibration::Read { offset_ns, .. } => Some(offset_ns),
            // Bounds are best at the end.
            Calibration::Bounds { .. } => None,
        };
        for pass in passes {
            let began_ns = pass.began_ns as f64;
            let took_ns = pass.gpu_ms * 1e6;
            self.push(Event { name: pass.label, thread: GPU, began_ns, took_ns, offset_ns });
        }
        Ok(())
    }

    /// Removes the frames in flight. Their passes are never read back, because the ring of frames
    /// was replaced.
    pub fn forget_submitted(&mut self) {
        self.submitted.clear();
    }

    fn push(&mut self, event: Event) {
        self.events.push(event, MOST_EVENTS);
    }

    /// Writes the file completely, or not at all.
    ///
    /// # Errors
    /// When the folder or the disk does not allow it.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        let device = &self.device.adapter().name;
        let text = to_json(&self.events, &self.calibration, device).to_string();
        write_file(path, text.as_bytes())
    }
}

/// Returns the trace in the "Trace Event Format" (Google, 2016): complete events, in microseconds.
fn to_json(events: &Events, calibration: &Calibration, device: &str) -> Value {
    let Events { kept: events, left_out } = events;
    let placed = |event: &Event| match event.thread {
        GPU => event.began_ns + event.offset_ns.unwrap_or_else(|| calibration.offset_ns()),
        _ => event.began_ns,
    };
    let origin_ns = events.iter().map(placed).fold(f64::INFINITY, f64::min);
    let thread = |id: u32, name: &str| json!({"name": "thread_name", "ph": "M", "pid": 1, "tid": id, "args": {"name": name}});
    let complete = |event: &Event| {
        json!({
            "name": event.name,
            "cat": if event.thread == GPU { "gpu" } else { "cpu" },
            "ph": "X",
            "ts": (placed(event) - origin_ns) / 1e3,
            "dur": event.took_ns / 1e3,
            "pid": 1,
            "tid": event.thread,
        })
    };
    let names = [thread(CPU, "frame loop"), thread(GPU, device)];
    let all: Vec<Value> = names.into_iter().chain(events.iter().map(complete)).collect();
    json!({
        "displayTimeUnit": "ms",
        "otherData": {"device": device, "gpu_clock": calibration.how(), "events_left_out": left_out},
        "traceEvents": all,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_close_in_on_the_offset() {
        let mut calibration = Calibration::UNKNOWN;
        assert_eq!(calibration.offset_ns(), 0.0);
        // The GPU's clock is 1000 behind the CPU's.
        for (submit, start, end, known) in [(5.0, 9.0, 30.0, 50.0), (60.0, 61.0, 70.0, 90.0)] {
            let gpu = [start - 1000.0, end - 1000.0];
            calibration.narrow([submit, known], gpu);
        }
        let Calibration::Bounds { least_ns, most_ns } = calibration else { panic!() };
        assert!(least_ns <= 1000.0 && 1000.0 <= most_ns, "{calibration:?}");
        assert_eq!((calibration.offset_ns(), most_ns), (999.0, 1020.0));
        assert!(calibration.how().contains("within 21 ns"), "{}", calibration.how());
    }

    #[test]
    fn both_lie_on_one_time_line() {
        let event = |name, thread, began_ns, offset_ns| Event {
            name,
            thread,
            began_ns,
            took_ns: 500.0,
            offset_ns,
        };
        let events = [
            event("render", CPU, 10_000.0, None),
            event("visible", GPU, 2_000.0, Some(9_000.0)),
            event("revealed", GPU, 3_000.0, None),
            event("too many", CPU, 20_000.0, None),
            event("far too many", CPU, 30_000.0, None),
        ];
        let clocks = Clocks { gpu_ns: 0, monotonic_ns: 9_500, deviation_ns: 7 };
        let mut kept = Events::default();
        for event in events {
            kept.push(event, 3);
        }
        let json = to_json(&kept, &Calibration::read(&clocks), "a GPU");
        let read = json["traceEvents"].as_array().unwrap();
        assert_eq!(read.len(), 5);
        assert_eq!(read[1]["args"]["name"], "a GPU");
        let at = |event: usize| read[event]["ts"].as_f64().unwrap();
        assert_eq!((at(2), at(3), at(4)), (0.0, 1.0, 2.5));
        assert_eq!((&read[3]["dur"], &read[3]["tid"]), (&json!(0.5), &json!(GPU)));
        assert!(json["otherData"]["gpu_clock"].as_str().unwrap().contains("within 7 ns"));
        assert_eq!(json["otherData"]["events_left_out"], 2);
    }
}
