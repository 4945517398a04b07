//! The table of object pairs. Each public call that takes two objects gets an object of another
//! device, instance or renderer, and returns an error before anything reaches Vulkan.

mod calls;
mod commands;
mod renderers;
mod side;

use std::collections::BTreeSet;

use gpu::{Commands, QueryRing, Tick, Timeline};
use side::Side;
use tests::xvfb::Xvfb;
use tests::{Driver, open, run};

/// A pair that does not belong together.
pub struct Row {
    /// The call that refuses the pair, by its path.
    pub call: &'static str,
    /// The argument, as the error names it.
    pub given: &'static str,
    /// The object that both must belong to.
    pub owner: &'static str,
    pub mistake: Mistake,
}

/// A call with objects of ours and one of theirs.
pub enum Mistake {
    /// A call that returns its error.
    Returned(fn(&mut Side, &mut Side) -> String),
    /// A call that records commands: the recording fails, and therefore the submit.
    Recorded(fn(&Commands, &mut Side, &mut Side)),
}

impl Mistake {
    /// Makes the call, and returns the error.
    fn make(self, ours: &mut Side, theirs: &mut Side) -> String {
        match self {
            Mistake::Returned(call) => call(ours, theirs),
            Mistake::Recorded(record) => {
                let device = ours.device();
                let submitted =
                    device.run_once("mistake", |commands| record(commands, ours, theirs));
                submitted.expect_err("an error").to_string()
            }
        }
    }
}

fn rows() -> impl Iterator<Item = Row> {
    calls::rows().into_iter().chain(commands::rows()).chain(renderers::rows())
}

#[test]
fn no_mistaken_pair_reaches_vulkan() {
    let server = Xvfb::start();
    let mut ours = Side::new(&server);
    let mut theirs = Side::new(&server);
    let submitted = |side: &Side| side.device().submitted();
    for Row { call, given, owner, mistake } in rows() {
        let before = (submitted(&ours), submitted(&theirs));
        let error = mistake.make(&mut ours, &mut theirs);
        let place = format!("`{call}` with {given}: {error}");
        assert!(error.contains(given), "{place}");
        match owner {
            "Renderer" => assert!(error.contains("by another renderer"), "{place}"),
            _ => {
                let both = error.contains("is used by ") && error.contains(&format!("`{owner}`s"));
                assert!(both, "{place}");
            }
        }
        assert_eq!((submitted(&ours), submitted(&theirs)), before, "{place}");
    }
    // Both sides go on, and the refused objects can be destroyed.
    ours.draw();
    theirs.draw();
    theirs.end();
    ours.draw();
    ours.end();
}

#[test]
fn the_document_and_the_test_name_the_same_pairs() {
    let text = include_str!("../../../../docs/lab/object_pairs.md");
    let cells = |line: &str| -> Option<[String; 3]> {
        let line = line.strip_prefix("| ")?.strip_suffix(" |")?;
        let cells: Vec<String> = line.split(" | ").map(str::to_owned).collect();
        cells.try_into().ok().filter(|[call, ..]: &[String; 3]| call.starts_with('`'))
    };
    let told: BTreeSet<[String; 3]> = text.lines().filter_map(cells).collect();
    let row =
        |row: Row| [format!("`{}`", row.call), row.given.to_owned(), format!("`{}`", row.owner)];
    let tried: BTreeSet<[String; 3]> = rows().map(row).collect();
    let missing: Vec<_> = tried.symmetric_difference(&told).map(|row| row.join(" | ")).collect();
    assert!(missing.is_empty(), "in one of them only:\n| {} |", missing.join(" |\n| "));
    assert!(tried.len() > 60, "{}", tried.len());
}

/// Checks that a tick of another device proves nothing, since ticks are numbers and the other
/// device may be far ahead.
#[test]
fn a_tick_of_another_device_proves_nothing() {
    run(Driver::Lavapipe, |device| {
        let (_instance, other) = open(Driver::Lavapipe);
        for _ in 0..9 {
            other.run_once("nothing", |_| {}).unwrap();
        }
        let gate = Timeline::new(device, "gate").unwrap();
        let mut ring = gpu::FrameRing::new(device, 1).unwrap();
        let mut queries = QueryRing::<u32>::new(device, 1, "test").unwrap();
        let mut frame = ring.begin().unwrap();
        queries.begin(&mut frame, &[7]).unwrap();
        queries.scope(frame.commands(), gpu::QueryIndex(0), |_| {});
        queries.resolve(frame.commands(), 0..1);
        queries.read_back(frame.commands());
        let tick = frame.submit(Some(gate.at(Tick(1)))).unwrap();
        // The frame would be over if its tick belonged to the other device.
        queries.submitted(Tick::ZERO);
        let mut told = Vec::new();
        queries.collect(other.completed().unwrap(), |tag, _| told.push(tag));
        assert!(told.is_empty() && other.completed().unwrap() > tick);
        gate.signal(Tick(1)).unwrap();
        device.wait_idle().unwrap();
        queries.collect(device.completed().unwrap(), |tag, _| told.push(tag));
        assert_eq!(told, [7]);
    });
}
