//! Times of passes belong to their labels, whatever happened to the frames in between.

use gpu::{Commands, Device, Frame, FrameRing};
use tests::run_on_all;

fn labels(frame: &Frame<'_>) -> Vec<&'static str> {
    frame.pass_times().iter().map(|time| time.label).collect()
}

fn timed_ring(device: &Device) -> FrameRing {
    let mut ring = FrameRing::new(device, 1).unwrap();
    ring.time_passes().unwrap();
    ring
}

fn nothing(_: &Commands) {}

#[test]
fn a_frame_that_was_given_up_leaves_no_times() {
    run_on_all(|device| {
        let mut ring = timed_ring(device);
        // Frames that are given up before and after any timestamps exist.
        for _ in 0..2 {
            let frame = ring.begin().unwrap();
            assert_eq!(labels(&frame), [""; 0]);
            frame.commands().pass("never", nothing);
        }
        let frame = ring.begin().unwrap();
        assert_eq!(labels(&frame), [""; 0]);
        frame.commands().pass("first", nothing);
        frame.submit(None).unwrap();
        let mut frame = ring.begin().unwrap();
        assert_eq!(labels(&frame), ["first"]);
        frame.commands().pass("sent off", nothing);
        frame.flush(None).unwrap();
        frame.commands().pass("given up", nothing);
        drop(frame);
        // The times of the last complete frame stay.
        let frame = ring.begin().unwrap();
        assert_eq!(labels(&frame), ["first"]);
        frame.commands().pass("second", nothing);
        frame.submit(None).unwrap();
        assert_eq!(labels(&ring.begin().unwrap()), ["second"]);
    });
}

#[test]
fn a_pass_within_a_pass_is_timed_with_it() {
    run_on_all(|device| {
        let mut ring = timed_ring(device);
        let frame = ring.begin().unwrap();
        frame.commands().pass("outer", |commands| {
            commands.pass("inner", nothing);
            commands.pass("inner", nothing);
        });
        frame.commands().pass("next", nothing);
        frame.submit(None).unwrap();
        let frame = ring.begin().unwrap();
        assert_eq!(labels(&frame), ["outer", "next"]);
        assert!(frame.pass_times().iter().all(|time| (0.0..60_000.0).contains(&time.gpu_ms)));
    });
}

#[test]
fn of_several_frames_one_is_timed() {
    run_on_all(|device| {
        let mut ring = FrameRing::new(device, 2).unwrap();
        assert_eq!(ring.timed_interval(), None);
        ring.time_passes_of_one_in(3).unwrap();
        assert_eq!(ring.timed_interval(), Some(3));
        let mut timed = Vec::new();
        for _ in 0..12 {
            let frame = ring.begin().unwrap();
            timed.push(!frame.pass_times().is_empty());
            frame.commands().pass("pass", nothing);
            frame.submit(None).unwrap();
        }
        // Frames 0, 3, 6 and 9 are timed. The times are known when the slots are reused, two frames
        // later.
        let expected: Vec<bool> = (0..12).map(|frame| frame >= 2 && (frame - 2) % 3 == 0).collect();
        assert_eq!(timed, expected);
        ring.stop_timing_passes();
        assert_eq!(ring.timed_interval(), None);
        assert!(ring.begin().unwrap().pass_times().is_empty());
    });
}
