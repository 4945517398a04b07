//! Changed files that still load become a frame, or an error that says why not.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use gltf_files::mutations::{SplitMix, corpus, mutant};
use tests::Driver;
use tests::frame_of_file::{FileOutcome, FileViewer};

/// The time after which a file hangs.
const HANG: Duration = Duration::from_secs(20);

/// Shows changed files, and prints what became of them.
fn verify(driver: Driver, seed: u64, tries: usize) {
    let corpus = corpus();
    let viewer = FileViewer::open(driver);
    let mut random = SplitMix(seed);
    let mut counted = BTreeMap::<String, usize>::new();
    // Each file as it is, and then its changes.
    for number in 0..corpus.len() + tries {
        let changed;
        let bytes = match corpus.get(number) {
            Some(bytes) => bytes,
            None => {
                changed = mutant(&corpus, &mut random);
                &changed
            }
        };
        let began = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| viewer.show(bytes)));
        let outcome = outcome.unwrap_or_else(|panic| {
            let file = std::env::temp_dir().join(format!("hostile_{seed}_{number}.glb"));
            std::fs::write(&file, bytes).unwrap();
            eprintln!("seed {seed}, file {number}, written to {}", file.display());
            std::panic::resume_unwind(panic)
        });
        assert!(began.elapsed() < HANG, "seed {seed}, file {number}: {:?}", began.elapsed());
        let name = match outcome {
            FileOutcome::NotShown(error) => error,
            outcome => format!("{outcome:?}"),
        };
        *counted.entry(name).or_default() += 1;
    }
    println!("{counted:#?}");
    let shown = counted[&format!("{:?}", FileOutcome::Shown)];
    assert!(shown > corpus.len() / 2, "{counted:#?}");
    let messages = viewer.close();
    assert!(messages.is_empty(), "{messages:#?}");
}

#[test]
fn a_changed_file_that_loads_becomes_a_frame() {
    verify(Driver::Lavapipe, 1, 300);
}

/// Shows more files: `ANTUMBRA_SEEDS=20`, a thousand each.
#[test]
#[ignore = "long walk"]
fn many_changed_files_that_load_become_frames() {
    for seed in crate::seeds(2, 3) {
        verify(Driver::Lavapipe, seed, 1_000);
    }
}
